//! Calibration of the slow inputs, as far as it shows in the broadcast measurements.

use super::bench::Bench;
use narx_core::bus::narmotion::{FromDrive, Measurement, ParameterStatus};
use narx_core::dictionary::number;
use narx_core::node::SlowInputs;
use narx_core::units::Volts;

/// Category 02: offsets of the accelerometer (0.001 g) add to it, gain (10^-6) and offset (0.001 V) scale what is sent as PIN_MEAS.
#[test]
fn acceleration_and_pressure_are_broadcast_calibrated() {
    let mut bench = Bench::new();
    for (number, raw) in [
        (number::ACCEL_X_OFFSET, 10),
        (number::ACCEL_Y_OFFSET, -20),
        (number::ACCEL_Z_OFFSET, 30),
        (number::PRESSURE_MEAS_GAIN, 1_500_000),
        (number::PRESSURE_MEAS_OFFSET, 250),
    ] {
        assert_eq!(bench.write(number, raw), (raw, ParameterStatus::Done));
    }
    bench.node.handle_inputs(SlowInputs {
        accel: [100, 200, 1000],
        pressure: Volts::from_milli(2000),
        ..SlowInputs::default()
    });
    bench.node.poll(0);
    let sent = bench.messages();
    let accel = |message: &FromDrive| {
        matches!(message, FromDrive::Measurement(Measurement::M0 { accel: [110, 180, 1030], .. }))
    };
    // 2 V x 1.5 + 0.25 V.
    let pressure = |message: &FromDrive| {
        matches!(message, FromDrive::Measurement(Measurement::M4 { pressure: 3250, .. }))
    };
    assert!(sent.iter().any(accel) && sent.iter().any(pressure), "{sent:?}");
}
