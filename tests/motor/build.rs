//! Tests that parameters reach the tick in its units: each against its own conversion, written out again
//! here.

use narx_core::dictionary::{Dictionary, Parameters, number};
use narx_core::motor::gain::Gain;
use narx_core::motor::{Board, BuildError, Coefficients};
use std::f64::consts::TAU;

/// A parameter and its converted value, in volts, amperes, electrical revolutions, seconds or shares of one.
struct Row {
    number: u16,
    /// Value in the parameter's unit.
    value: f64,
    found: fn(&Coefficients) -> f64,
    expected: f64,
}

const fn row(number: u16, value: f64, found: fn(&Coefficients) -> f64, expected: f64) -> Row {
    Row { number, value, found, expected }
}

fn fixed(raw: i32) -> f64 {
    f64::from(raw) / 65_536.0
}

/// Value of a number with 16 extra fraction bits.
fn extended(raw: i64) -> f64 {
    raw as f64 / 4_294_967_296.0
}

fn share(raw: u16) -> f64 {
    f64::from(raw) / 32_768.0
}

fn gain(gain: Gain) -> f64 {
    gain.apply(1 << 30) as f64 / f64::from(1 << 30)
}

/// Set-up of the conversions: with 5 pole pairs 12 rpm are one electrical revolution per second, at 40 V one
/// per cent of duty is 0.4 V, and the tick is 10 kHz.
const POLE_PAIRS: f64 = 5.0;
const RPM: f64 = POLE_PAIRS / 60.0;

/// Parameters whose coefficient follows from their own value and the set-up above. Those that act together
/// with others have tests of their own.
const ROWS: [Row; 31] = [
    row(number::INITIAL_DUTY, 5.0, |c| fixed(c.control.initial_level), 2.0),
    row(number::OPEN_LOOP_DUTY, 10.0, |c| fixed(c.open_loop.level), 4.0),
    row(number::OPEN_LOOP_SPEED, 600.0, |c| fixed(c.open_loop.speed), 50.0),
    // 50 rev/s in 2500 ticks.
    row(number::OPEN_LOOP_RAMP, 0.25, |c| extended(c.open_loop.rate), 50.0 / 250.0),
    row(number::LOCK_DUTY, 8.0, |c| fixed(c.machine.lock_level), 3.2),
    row(number::LOCK_DURATION, 0.2, |c| f64::from(c.machine.lock), 2000.0),
    row(number::OPEN_LOOP_DURATION, 0.7, |c| f64::from(c.machine.open_loop), 7000.0),
    row(number::FAULT_WAIT, 300.0, |c| f64::from(c.machine.fault_wait), 3000.0),
    row(number::CAN_TIMEOUT, 150.0, |c| f64::from(c.machine.command_timeout), 1500.0),
    // Loops run every millisecond; a mechanical rad/s is 5 / 2 pi electrical rev/s.
    row(number::SPEED_KP_SL, 0.02, |c| gain(c.sensorless_mode.speed.proportional), 0.02 * TAU / POLE_PAIRS),
    row(number::SPEED_KI_SL, 2.0, |c| gain(c.sensorless_mode.speed.integral), 2.0e-3 * TAU / POLE_PAIRS),
    row(number::SPEED_KP_HES, 0.002, |c| gain(c.hall_mode.speed.proportional), 0.002 / RPM),
    row(number::SPEED_KI_HES, 0.1, |c| gain(c.hall_mode.speed.integral), 0.1e-3 / RPM),
    // The current limiter runs every tick.
    row(number::HV_CURRENT_KP, 0.25, |c| gain(c.control.current.proportional), 0.25),
    row(number::HV_CURRENT_KI, 300.0, |c| gain(c.control.current.integral), 0.03),
    row(number::HV_CURRENT_RATE, 80.0, |c| extended(c.control.limits.rate), 0.08),
    row(number::HV_CURRENT_SOFT_START, 2.5, |c| fixed(c.control.limits.soft_start), 2.5),
    row(number::HV_CURRENT_MAX, 5.5, |c| fixed(c.control.limits.maximum), 5.5),
    row(number::SPEED_RATE, 3000.0, |c| extended(c.control.speed_rate), 3.0 * RPM),
    row(number::DUTY_MAX, 85.0, |c| share(c.hall_mode.duty_max), 0.85),
    row(number::DUTY_MAX_SL, 90.0, |c| share(c.sensorless_mode.duty_max), 0.9),
    row(number::SPEED_MAX_HES, 3600.0, |c| fixed(c.hall_mode.speed_max), 300.0),
    row(number::SPEED_MIN_HES, 480.0, |c| fixed(c.hall_mode.speed_min), 40.0),
    row(number::SPEED_MAX_SL, 3000.0, |c| fixed(c.sensorless_mode.speed_max), 250.0),
    row(number::SPEED_MIN_SL, 600.0, |c| fixed(c.sensorless_mode.speed_min), 50.0),
    // In 1/65 536 tick.
    row(number::HALL_PERIOD_TIMEOUT, 0.2, |c| f64::from(c.hall.timeout) / 65_536.0, 2000.0),
    row(number::OVER_PRESSURE, 2.5, |c| fixed(c.protection.over_pressure.trip), 2.5),
    row(number::OVER_TEMPERATURE, 170.0, |c| fixed(c.protection.over_temperature.trip), 170.0),
    row(number::OVER_CURRENT, 6.5, |c| fixed(c.protection.over_current.trip), 6.5),
    row(number::OVER_VOLTAGE, 55.0, |c| fixed(c.protection.over_voltage.trip), 55.0),
    row(number::UNDER_VOLTAGE, 20.0, |c| fixed(c.protection.under_voltage.trip), 20.0),
];

#[test]
fn parameters_that_are_converted_alone_reach_the_tick_in_its_units() {
    let mut parameters = Parameters::new();
    let mut set = |number: u16, value: f64| {
        let exponent = Dictionary::row(number).unwrap().exponent;
        parameters.set(number, (value / 10_f64.powi(exponent.into())).round() as i32).unwrap();
    };
    set(number::MOTOR_POLE_PAIRS, POLE_PAIRS);
    set(number::NOMINAL_SUPPLY, 40.0);
    set(number::TEMPERATURE_WARNING, 160.0);
    let factory = Coefficients::build(&Parameters::new(), &Board::BENCH).unwrap();
    ROWS.iter().for_each(|row| set(row.number, row.value));
    let built = Coefficients::build(&parameters, &Board::BENCH).unwrap();
    for row in &ROWS {
        let name = Dictionary::row(row.number).unwrap().name();
        let found = (row.found)(&built);
        assert!(
            (found - row.expected).abs() <= 1e-4 * row.expected,
            "{name}: {found}, expected {}",
            row.expected
        );
        // With a factory value the table would not notice a parameter that is missing.
        assert!(
            ((row.found)(&factory) - row.expected).abs() > 1e-3 * row.expected,
            "{name} is the factory's"
        );
    }
}

#[test]
fn what_does_not_fit_is_named_with_what_does() {
    let mut parameters = Parameters::new();
    parameters.set(number::OVER_VOLTAGE, 20_000).unwrap();
    parameters.set(number::UNDER_VOLTAGE, 19_500).unwrap();
    let refused = Coefficients::build(&parameters, &Board::BENCH).unwrap_err();
    let expected = BuildError { parameter: number::UNDER_VOLTAGE, raw: 19_500, min: 0, max: 18_500 };
    assert_eq!(refused, expected);
    assert_eq!(
        refused.to_string(),
        "parameter 120 \"Under-voltage HV threshold\": 19.5 does not fit the other parameters, which allow 0 to 18.5 V"
    );
    // The text of a parameter without a unit ends with its value.
    let speeds = BuildError { parameter: number::MOTOR_POLE_PAIRS, raw: 51, min: 1, max: 50 };
    assert_eq!(
        speeds.to_string(),
        "parameter 78 \"Motor pair poles\": 51 does not fit the other parameters, which allow 1 to 50"
    );
    // The fields are public: an error for a parameter that is never built.
    assert_eq!(BuildError { parameter: 122, ..expected }.to_string(), "unknown parameter");
}

#[test]
fn a_board_is_plausible_up_to_its_limits() {
    type Change = fn(&mut Board);
    let with = |change: Change| {
        let mut board = Board::BENCH;
        change(&mut board);
        board.is_plausible()
    };
    let within: [(&str, Change); 8] = [
        ("the bench's own", |_| {}),
        ("1 kHz", |board| board.tick_rate = 1_000),
        ("100 kHz", |board| board.tick_rate = 100_000),
        ("the finest bus voltage", |board| board.front_end.bus_voltage.micro_per_code = 1),
        ("the finest current", |board| board.front_end.bus_current.micro_per_code = 1),
        ("the coarsest phase voltage", |board| board.front_end.phase_voltage.micro_per_code = 62_500),
        ("a zero at the converter's end", |board| board.front_end.bus_current.zero = 4095),
        ("no dead time", |board| board.dead_time_ns = 0),
    ];
    let beyond: [(&str, Change); 9] = [
        ("999 Hz", |board| board.tick_rate = 999),
        ("100 001 Hz", |board| board.tick_rate = 100_001),
        ("a bus voltage without a scale", |board| board.front_end.bus_voltage.micro_per_code = 0),
        ("a phase voltage that falls", |board| board.front_end.phase_voltage.micro_per_code = -1),
        ("a current without a scale", |board| board.front_end.bus_current.micro_per_code = 0),
        ("too coarse a bus voltage", |board| board.front_end.bus_voltage.micro_per_code = 62_501),
        ("too coarse a current", |board| board.front_end.bus_current.micro_per_code = i32::MAX),
        ("a zero of 13 bits, phase voltage", |board| board.front_end.phase_voltage.zero = 4096),
        ("a zero of 13 bits, current", |board| board.front_end.bus_current.zero = 4096),
    ];
    for (name, change) in within {
        assert!(with(change), "{name}");
    }
    for (name, change) in beyond {
        assert!(!with(change), "{name}");
    }
}

/// At another rate the tick takes as long as before, and a period that is too short for it is no board's.
#[test]
fn a_tick_takes_as_long_at_every_rate() {
    let board = Board::BENCH.at_rate(40_000).unwrap();
    assert_eq!((board.tick_rate, board.earliest), (40_000, 4 * Board::BENCH.earliest));
    assert_eq!(Board::BENCH.at_rate(79_990).unwrap().earliest, 65_527);
    assert_eq!(Board::BENCH.at_rate(80_000), None);
}
