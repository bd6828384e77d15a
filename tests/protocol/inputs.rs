//! Tests of the way from the wires of the board to the bus: every slow input, its calibration, and the
//! outputs back to the wires.

use super::bench::Bench;
use super::wired::Wired;
use narx_core::bus::narmotion::{DigitalOutputs, MotorMode, ToDrive};
use narx_core::dictionary::{Category, Dictionary, number};
use narx_core::motor::State;
use narx_core::motor::guard::fault::Cause;
use narx_core::node::SlowInputs;
use narx_core::units::Volts;
use narx_sim::bench::SIGNALS;
use narx_sim::plant::Input;

/// A value on a wire is received over the bus, to half a code of the converter and half a step of the frame.
#[test]
fn every_input_comes_back_over_the_bus_in_its_scale() {
    type Row = (&'static [(Input, f64)], &'static str, f64, f64, f64);
    let table: [Row; 16] = [
        (&[(Input::Asi, 2.5)], "ASI_DSP", 0.0, 2.5, 1e-3),
        (&[(Input::Asi, 3.3)], "ASI_DSP", 0.0, 3.3, 1e-3),
        // A source of 20 kohm against the input's own resistance.
        (&[(Input::Asi, 2.5), (Input::AsiSource, 20_000.0)], "ASI_DSP", 0.0, 1.25, 1e-3),
        (&[(Input::AccelX, 1.5)], "Accel X", 0.0, 1.5, 2e-3),
        (&[(Input::AccelY, -2.0)], "Accel Y", 0.0, -2.0, 2e-3),
        (&[(Input::AccelZ, -1.0)], "Accel Z", 1.0, -1.0, 2e-3),
        // 30 mV x 56.
        (&[(Input::Pressure, 30.0)], "PIN_MEAS", 0.0, 1.68, 1.2e-3),
        (&[(Input::Pressure, 55.0)], "PIN_MEAS", 0.0, 3.08, 1.2e-3),
        // 1 V off the middle, attenuated by 80 dB, x 56.
        (&[(Input::Pressure, 30.0), (Input::PressureCommonMode, 3.5)], "PIN_MEAS", 0.0, 1.6856, 1.2e-3),
        (&[(Input::Rail6V, 5.5)], "+6V_MEAS", 6.0, 5.5, 1.6e-3),
        (&[(Input::Rail14V, 13.2)], "Driver 14V Voltage", 14.0, 13.2, 3.1e-3),
        (&[(Input::AccelReference, 1.75)], "Vref Accel (+1.8V)", 1.8, 1.75, 1e-3),
        (&[(Input::Reference, 0.4)], "+0.383VREF", 0.383, 0.4, 1e-3),
        (&[(Input::InternalTemperature, 120.3)], "Ambient Temperature", 25.0, 120.3, 0.09),
        (&[(Input::Dsio1, 3.3)], "DSI1_DSP", 0.0, 1.0, 0.0),
        (&[(Input::Dsio2, 3.3)], "DSI2_DSP", 0.0, 1.0, 0.0),
    ];
    for (values, signal, before, after, tolerance) in table {
        let mut wired = Wired::resting();
        let seen = wired.signal(signal);
        assert!((seen - before).abs() <= tolerance, "{signal} before: {seen}");
        for (input, value) in values {
            wired.put(*input, *value);
        }
        let seen = wired.signal(signal);
        assert!((seen - after).abs() <= tolerance, "{values:?}: {signal} is {seen}");
    }
}

#[test]
fn what_no_wire_can_carry_is_refused() {
    let mut wired = Wired::resting();
    for input in Input::ALL {
        let (min, max) = input.range();
        let before = wired.bench.plant().slow_inputs();
        for value in [min - 1e-3, max + 1e-3, f64::NAN, f64::INFINITY] {
            let error = wired.bench.plant_mut().set_input(input, value).unwrap_err();
            assert_eq!(error.input, input);
        }
        assert_eq!(wired.bench.plant().slow_inputs(), before, "{input:?}");
        for value in [min, max] {
            wired.put(input, value);
        }
    }
    let error = wired.bench.plant_mut().set_input(Input::Pressure, 56.0).unwrap_err();
    assert_eq!(error.to_string(), "Pressure takes 0 to 55 mV");
    let error = wired.bench.plant_mut().set_input(Input::AccelX, -2.5).unwrap_err();
    assert_eq!(error.to_string(), "AccelX takes -2 to 2 g");
}

/// Between wire and node half a code at most is lost, up to the middle of the last code.
#[test]
fn converters_have_12_bits() {
    const CODE: f64 = 3.3 / 4096.0;
    let mut wired = Wired::resting();
    let mut seen = Vec::new();
    for step in 0..=32_990 {
        let value = f64::from(step) * 1e-4;
        wired.put(Input::Asi, value);
        let bits = wired.bench.plant().slow_inputs().asi.to_bits();
        assert!((f64::from(bits) / 65_536.0 - value).abs() <= 0.5 * CODE + 0.5 / 65_536.0, "{value}");
        seen.push(bits);
    }
    seen.dedup();
    assert_eq!(seen.len(), 4096);
}

/// A digital line is low up to 1.2 V, high from 1.3 V, and unchanged between the two (Table 2).
#[test]
fn a_digital_line_has_hysteresis() {
    for (input, signal) in [(Input::Dsio1, "DSI1_DSP"), (Input::Dsio2, "DSI2_DSP")] {
        let mut wired = Wired::resting();
        let course = [
            (1.25, 0.0),
            (1.29, 0.0),
            (1.3, 1.0),
            (1.25, 1.0),
            (1.21, 1.0),
            (1.2, 0.0),
            (1.25, 0.0),
            (3.3, 1.0),
            (0.0, 0.0),
        ];
        for (volts, level) in course {
            wired.put(input, volts);
            assert_eq!(wired.signal(signal), level, "{input:?} at {volts} V");
        }
    }
}

#[test]
fn digital_outputs_reach_the_wire_and_are_read_back() {
    let mut wired = Wired::resting();
    wired.put(Input::Dsio2, 3.3);
    let outputs = |enable1, value1, enable2, value2| {
        ToDrive::DigitalOutputs(DigitalOutputs { enable1, value1, enable2, value2 })
    };
    let table = [
        (outputs(false, true, false, false), [0.0, 3.3]),
        (outputs(true, true, false, false), [3.3, 3.3]),
        (outputs(true, false, true, false), [0.0, 0.0]),
        (outputs(false, false, true, true), [0.0, 3.3]),
        (outputs(false, false, false, false), [0.0, 3.3]),
    ];
    for (message, volts) in table {
        wired.send(message);
        let read = [wired.signal("DSI1_DSP"), wired.signal("DSI2_DSP")];
        assert_eq!(wired.bench.plant().digital_lines(), volts, "{message:?}");
        assert_eq!(read.map(|level| 3.3 * level), volts, "{message:?}");
    }
}

#[test]
fn hall_sensors_without_supply_leave_their_lines_high() {
    let hall = |wired: &mut Wired| {
        wired.run(0.01);
        let place = SIGNALS.iter().position(|signal| signal.name == "hall").unwrap();
        wired.bench.values()[place]
    };
    let mut wired = Wired::resting();
    let supplied = hall(&mut wired);
    assert_ne!(supplied, 7.0);
    type Switch = fn(&mut Wired, bool);
    let switches: [Switch; 3] = [
        |wired, on| wired.send(ToDrive::DisableHallSupply(!on)),
        |wired, on| wired.write(number::HALL_SUPPLY_ENABLE, on.into()),
        |wired, on| wired.put(Input::HallSupply, if on { 5.0 } else { 3.0 }),
    ];
    for switch in switches {
        switch(&mut wired, false);
        assert_eq!(hall(&mut wired), 7.0);
        switch(&mut wired, true);
        assert_eq!(hall(&mut wired), supplied);
    }
}

/// Limits apply to the wires: just inside, the motor turns on; just outside, it is stopped with the right
/// cause.
#[test]
fn a_wire_beyond_its_limit_stops_the_motor() {
    use Cause::{HallInvalid, OverPressure, OverTemperature, ShutdownLine};
    // Over-pressure stops the motor only if the mask says so.
    let critical = 0xFC00_00FE_u32.cast_signed();
    let pressure = [(number::OVER_PRESSURE, 2000), (number::CRITICAL_FAULT_MASK, critical)];
    let table = [
        (&[(number::SHUTDOWN_INPUT, 1)][..], Input::Dsio1, 1.29, 1.3, ShutdownLine),
        (&[(number::SHUTDOWN_INPUT, 2)], Input::Dsio2, 1.29, 1.3, ShutdownLine),
        // 35 mV and 36 mV x 56 are 1.96 V and 2.02 V.
        (&pressure, Input::Pressure, 35.0, 36.0, OverPressure),
        (&[], Input::InternalTemperature, 189.0, 191.0, OverTemperature),
        (&[], Input::HallSupply, 4.0, 3.0, HallInvalid),
    ];
    for (parameters, input, inside, outside, cause) in table {
        let mut wired = Wired::turning();
        if !parameters.is_empty() {
            wired.asks = Some(MotorMode::Standby);
            wired.run(1.0);
            parameters.iter().for_each(|(number, raw)| wired.write(*number, *raw));
            wired.asks = Some(MotorMode::Drive);
            wired.run(0.5);
        }
        wired.put(input, inside);
        wired.run(1.5);
        assert_eq!(wired.bench.status().state, State::HallClosedLoop, "{input:?} at {inside}");
        wired.put(input, outside);
        wired.run(1.5);
        assert_eq!(wired.look(number::EXTENDED_FAULT_CODE), cause as i32, "{input:?} at {outside}");
        assert_eq!(wired.bench.status().state, State::Fault, "{input:?} at {outside}");
    }
}

/// Every parameter of category 02 moves its measurement: values on the wires, the measurement before, the
/// parameter's value, the measurement after.
#[test]
fn every_calibration_parameter_moves_its_measurement() {
    const PRESSURE: &[(Input, f64)] = &[(Input::Pressure, 30.0)];
    const SHIFTED: &[(Input, f64)] = &[(Input::AccelReference, 1.9)];
    type Row = (u16, &'static [(u16, i32)], i32, &'static [(Input, f64)], &'static str, f64, f64, f64);
    let table: [Row; 15] = [
        (8, &[], 1, &[(Input::ExternalTemperature, 100.0)], "Ambient Temperature", 25.0, 100.0, 0.06),
        // The outputs have moved with the reference: 0.1 V are 0.2 g.
        (9, &[], 0, SHIFTED, "Accel Z", 1.0, 1.2, 3e-3),
        (10, &[], 100, &[(Input::AccelX, 0.5)], "Accel X", 0.5, 0.6, 2e-3),
        (11, &[], -200, &[(Input::AccelY, 0.5)], "Accel Y", 0.5, 0.3, 2e-3),
        (12, &[], 30, &[], "Accel Z", 1.0, 1.03, 2e-3),
        (13, &[], 500, &[], "HV Current", 0.0, 0.5, 0.05),
        (14, &[], 1500, &[], "HV Voltage", 24.0, 25.5, 0.15),
        (15, &[], -50, &[], "Ambient Temperature", 25.0, 20.0, 0.06),
        (16, &[(17, 0)], 9000, &[], "Mechanical position", 0.0, 90.0, 0.0),
        (17, &[(16, 4500), (17, 0)], 1, &[], "Mechanical position", 0.0, 45.0, 0.0),
        (18, &[], 100, PRESSURE, "PIN_MEAS", 1.68, 1.78, 2e-3),
        (19, &[], 1_500_000, PRESSURE, "PIN_MEAS", 1.68, 2.52, 2e-3),
        (20, &[], -250, PRESSURE, "PIN_MEAS", 1.68, 1.43, 2e-3),
        (21, &[], 2_000_000, PRESSURE, "PIN_MEAS", 1.68, 3.36, 3e-3),
        (number::ACCEL_MEAS_OFFSET, &[(9, 0)], 1900, SHIFTED, "Accel Z", 1.2, 1.0, 3e-3),
    ];
    let of_category = Dictionary::rows().filter(|row| row.category == Category::Calibration);
    let shown: Vec<u16> = table.iter().map(|row| row.0).collect();
    assert_eq!(of_category.map(|row| row.number).collect::<Vec<_>>(), shown);
    for (number, first, raw, wires, signal, before, after, tolerance) in table {
        let mut wired = Wired::resting();
        for (input, value) in wires {
            wired.put(*input, *value);
        }
        for (number, raw) in first {
            wired.write(*number, *raw);
        }
        let seen = wired.signal(signal);
        assert!((seen - before).abs() <= tolerance, "{number} before: {signal} is {seen}");
        wired.write(number, raw);
        if number == 16 {
            wired.write(17, 1);
        }
        let seen = wired.signal(signal);
        assert!((seen - after).abs() <= tolerance, "{number} after: {signal} is {seen}");
    }
}

/// Tilt and vibration from a second of readings, 0.01 degrees and 0.001 g.
fn moved(readings: impl Fn(usize) -> [f64; 3]) -> (f64, f64) {
    let mut bench = Bench::new();
    for index in 0..100 {
        let volts = |g: f64| Volts::from_bits(((1.8 + 0.5 * g) * 65_536.0).round() as i32);
        bench.node.handle_inputs(SlowInputs {
            accel: readings(index).map(volts),
            accel_reference: Volts::from_milli(1800),
            ..SlowInputs::default()
        });
    }
    bench.messages();
    let [tilt, vibration] = [number::TILT, number::VIBRATION].map(|number| f64::from(bench.read(number).0));
    (tilt / 100.0, vibration / 1000.0)
}

#[test]
fn tilt_is_the_angle_to_the_vertical() {
    for tilt in (0..=180).step_by(5) {
        for azimuth in (0..360).step_by(30) {
            let [tilt, azimuth] = [tilt, azimuth].map(|degrees| f64::from(degrees).to_radians());
            let accel = [tilt.sin() * azimuth.cos(), tilt.sin() * azimuth.sin(), tilt.cos()];
            let (seen, vibration) = moved(|_| accel);
            assert!((seen - tilt.to_degrees()).abs() < 0.2, "{} at {azimuth}: {seen}", tilt.to_degrees());
            assert_eq!(vibration, 0.0, "gravity is none");
        }
    }
    assert_eq!(moved(|_| [0.0; 3]).0, 0.0, "free fall has no direction");
    // Shaking causes no tilt.
    let shaken = moved(|index| [if index % 2 == 0 { 1.5 } else { -1.5 }, 1.0, 0.0]);
    assert_eq!(shaken, (90.0, 1.5));
}

#[test]
fn vibration_is_the_root_mean_square_without_the_mean() {
    for amplitude in [0.0, 0.002, 0.01, 0.1, 0.5, 1.0, 2.0] {
        for axis in 0..3 {
            let reading = |index: usize| {
                let mut accel = [0.3, -0.2, 0.9];
                accel[axis] += amplitude * (std::f64::consts::TAU * 7.0 * index as f64 / 100.0).sin();
                // Rounded as in the node.
                accel.map(|g| (g * 1000.0).round() / 1000.0)
            };
            let mean =
                |of: &dyn Fn([f64; 3]) -> f64| (0..100).map(|index| of(reading(index))).sum::<f64>() / 100.0;
            let variance: f64 = (0..3)
                .map(|axis| mean(&|accel| accel[axis] * accel[axis]) - mean(&|accel| accel[axis]).powi(2))
                .sum();
            let seen = moved(reading).1;
            assert!(
                (seen - variance.max(0.0).sqrt()).abs() <= 0.5e-3 + 1e-5,
                "{amplitude} g along {axis}: {seen}"
            );
        }
    }
}

/// Tilt and vibration are read over the bus: the board is laid on its side and shaken.
#[test]
fn tilt_and_vibration_are_read_over_the_bus() {
    let mut wired = Wired::resting();
    wired.run(0.5);
    assert_eq!((wired.read(number::TILT), wired.read(number::VIBRATION)), (0, 0));
    wired.put(Input::AccelZ, 0.0);
    for reading in 0..300 {
        wired.put(Input::AccelX, if reading % 2 == 0 { 0.5 } else { 1.5 });
        wired.run(0.01);
    }
    assert_eq!(wired.read(number::TILT), 9000);
    assert!((wired.read(number::VIBRATION) - 500).abs() <= 2, "{}", wired.read(number::VIBRATION));
}
