//! Tests of set-points that a drive would clamp: the master knows them in advance, and names the parameter
//! that limits.

use crate::pair::Pair;
use narx_core::dictionary::{Parameters, number};
use narx_core::master::{Config, SpeedLimits};

const ENABLES: [u16; 3] = [number::OPEN_LOOP_ENABLE, number::SENSORLESS_ENABLE, number::HALL_ENABLE];
const LIMITS: [(u16, i32); 5] = [
    (number::SPEED_MAX_SL, 2191),
    (number::SPEED_MIN_SL, 600),
    (number::SPEED_MAX_HES, 4100),
    (number::SPEED_MIN_HES, 300),
    (number::OPEN_LOOP_SPEED, 500),
];

/// Limits that were never written follow the pole pairs for the master as for the drive.
#[test]
fn factory_limits_are_those_of_the_pole_pairs() {
    for (pole_pairs, min, max) in [(2, 1000, 8000), (4, 500, 4000), (8, 250, 2000)] {
        let mut parameters = Parameters::new();
        parameters.set(number::HALL_ENABLE, 1).unwrap();
        parameters.set(number::MOTOR_POLE_PAIRS, pole_pairs).unwrap();
        let limits = SpeedLimits::of(|number| parameters.value(number)).unwrap();
        assert_eq!((limits.min.rpm, limits.max.rpm), (min, max), "{pole_pairs}");
    }
}

/// A drive with these of its modes enabled: open loop, sensorless, halls.
fn drive(enabled: [i32; 3]) -> Parameters {
    let mut parameters = Parameters::new();
    for (number, raw) in ENABLES.into_iter().zip(enabled).chain(LIMITS) {
        parameters.set(number, raw).unwrap();
    }
    parameters
}

/// The master refuses a set-point exactly if the drive would clamp it.
#[test]
fn a_set_point_is_refused_where_the_drive_would_clamp_it() {
    for (enabled, min, max) in [
        ([0, 0, 0], 0, 65_535),
        ([1, 0, 0], 500, 500),
        ([1, 1, 0], 600, 2191),
        ([0, 0, 1], 300, 4100),
        ([1, 1, 1], 300, 4100),
    ] {
        let mut pair = Pair::with_parameters(Config::default(), drive(enabled));
        assert_eq!(pair.master.speed_limits(), None, "nothing was received yet");
        assert_eq!(pair.master.check_speed(30_000), Ok(()), "nothing was received yet");
        pair.run(400);
        let limits = pair.master.speed_limits().unwrap();
        assert_eq!((limits.min.rpm, limits.max.rpm), (min, max), "{enabled:?}");
        for rpm in [0, 1, 299, 300, 500, 600, 2191, 2192, 4100, 4101, 65_535_u16] {
            let taken = pair.master.check_speed(rpm.into()).is_ok();
            assert_eq!(taken, pair.master.check_speed(-i32::from(rpm)).is_ok());
            pair.master.set_speed(rpm);
            pair.run(20);
            let accepted = pair.master.report().accepted_speed.unwrap().value;
            assert_eq!(taken, accepted == rpm, "{enabled:?}: {rpm} rpm is {accepted} rpm for the drive");
        }
        for rpm in [65_536, -65_536, i32::MAX, i32::MIN] {
            assert!(pair.master.check_speed(rpm).is_err(), "MOTOR_CMD cannot carry {rpm}");
        }
    }
}

/// [`SpeedLimits::PARAMETERS`] suffice for the limits of every mode, and each of them is needed.
#[test]
fn its_parameters_decide_about_the_limits_and_no_others() {
    let modes = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
    let knows = |enabled, without: Option<u16>| {
        let parameters = drive(enabled);
        let read = |number: &u16| SpeedLimits::PARAMETERS.contains(number) && Some(*number) != without;
        SpeedLimits::of(|number| Some(number).filter(read).and_then(|number| parameters.value(number)))
            .is_some()
    };
    for enabled in modes {
        assert!(knows(enabled, None), "{enabled:?}");
    }
    for number in SpeedLimits::PARAMETERS {
        assert!(modes.iter().any(|&enabled| !knows(enabled, Some(number))), "{number}");
    }
}

#[test]
fn the_refusal_names_value_parameter_and_range() {
    let text = |enabled, rpm| {
        let parameters = drive(enabled);
        let limits = SpeedLimits::of(|number| parameters.value(number)).unwrap();
        limits.check(rpm).unwrap_err().to_string()
    };
    let cases = [
        (
            [0, 1, 0],
            3120,
            "speed 3120 rpm is above parameter 101 \"Speed setpoint max saturation SL\": must be 600 to 2191 rpm",
        ),
        (
            [0, 1, 0],
            599,
            "speed 599 rpm is below parameter 102 \"Speed setpoint min saturation SL\": must be 600 to 2191 rpm",
        ),
        (
            [0, 0, 1],
            -4101,
            "speed -4101 rpm is above parameter 103 \"Speed setpoint max saturation HES\": must be 300 to 4100 rpm in either direction",
        ),
        (
            [0, 0, 1],
            0,
            "speed 0 rpm is below parameter 104 \"Speed setpoint min saturation HES\": must be 300 to 4100 rpm",
        ),
        (
            [1, 0, 0],
            800,
            "speed 800 rpm is not equal to parameter 88 \"Open-loop speed setpoint\": must be 500 rpm",
        ),
        ([0, 0, 0], 65_536, "speed 65536 rpm: must be 0 to 65535 rpm"),
    ];
    for (enabled, rpm, expected) in cases {
        assert_eq!(text(enabled, rpm), expected);
    }
}

/// Limits that cross each other do not build: the drive refuses the start, and names the parameter.
#[test]
fn limits_that_cross_each_other_are_for_the_drive_to_refuse() {
    let mut parameters = drive([0, 0, 1]);
    parameters.set(number::SPEED_MIN_HES, 5000).unwrap();
    assert_eq!(SpeedLimits::of(|number| parameters.value(number)), Some(SpeedLimits::WIRE));
}
