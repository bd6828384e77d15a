//! Tests of the hall calibration alone: three lines that are sensors of one rotor, and others that are not.

use crate::rotor::code_at;
use narx_core::motor::rotor::hall_calibration::{
    HallCalibration, HallCalibrationCoefficients, HallCalibrator,
};

/// Speed of the field: 1024 ticks per revolution.
const SPEED: u32 = 1 << 22;

/// Turns a field forward and back, with a rotor whose lines `change` alters; returns the result.
fn calibrate(change: impl Fn(u8, f64) -> u8) -> HallCalibration {
    let c = HallCalibrationCoefficients { speed: SPEED, level: 1 << 16 };
    let mut calibrator = HallCalibrator::default();
    let line = |tick: u32| {
        // 1.25 revolutions forward, and the same back.
        let travelled = f64::from(tick) / 1024.0;
        let angle = if travelled < 1.25 { travelled } else { 2.5 - travelled };
        change(code_at(angle.rem_euclid(1.0)), angle.rem_euclid(1.0))
    };
    calibrator.start(line(0));
    for tick in 0..10_000 {
        let (_, outcome) = calibrator.step(&c, line(tick));
        if outcome != HallCalibration::Running {
            return outcome;
        }
    }
    panic!("a calibration ends");
}

#[test]
fn a_line_that_does_not_change_as_a_sensor_does_fails() {
    let whole = calibrate(|code, _| code);
    assert!(matches!(whole, HallCalibration::Done(found) if found.offset.unsigned_abs() < 600), "{whole:?}");
    for line in 0..3 {
        let bit = 1 << line;
        assert_eq!(calibrate(|code, _| code & !bit), HallCalibration::Failed, "line {line} is low");
        assert_eq!(calibrate(|code, _| code | bit), HallCalibration::Failed, "line {line} is high");
        let bounces = |code, angle: f64| if (0.5..0.51).contains(&angle) { code ^ bit } else { code };
        assert_eq!(calibrate(bounces), HallCalibration::Failed, "line {line} bounces");
    }
    // Two lines are equal: no three sensors behave like this.
    assert_eq!(calibrate(|code, _| code & 0b110 | code >> 1 & 1), HallCalibration::Failed);
}
