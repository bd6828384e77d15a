//! Tests of the dictionary: numbering, ranges, factory values, error texts.

use narx_core::dictionary::{
    Access, Decimal, Dictionary, Kind, OWN_FIRST, PARAMETER_COUNT, PRINTED_COUNT, ParameterError, Parameters,
    number,
};
use proptest::prelude::*;

/// Numbers that the decisions of PROTOCOL.md name, with the name that the document has there.
const ANCHORS: [(u16, &str); 39] = [
    (0, "Memory Mapping Flag"),
    (1, "Device Number"),
    (2, "Slave CAN address"),
    (3, "Master CAN address"),
    (4, "Hardware Release"),
    (5, "Build number"),
    (8, "Temperature measurement source selection"),
    (10, "Accel X calib offset"),
    (17, "Set position calibration value (rising edge)"),
    (22, "Virtual Scop Channels Selection"),
    (26, "Virtual Scop Trig phase"),
    (27, "01 - Logging start index"),
    (28, "02 - Logging package index"),
    (29, "03 - Logging slot"),
    (65, "39 - Logging slot"),
    (66, "40 - Logging end index"),
    (67, "Logging read start index"),
    (76, "Logging erase request"),
    (77, "Logging memory full flag"),
    (78, "Motor pair poles"),
    (79, "Select control sequence for standard motor"),
    (81, "Open-loop enable"),
    (82, "Closed-loop Sensorless enable"),
    (83, "Closed-loop Hall Effect Sensors enable"),
    (99, "Speed setpoint rate"),
    (100, "ZC delay compensation"),
    (107, "Max duty cycle"),
    (108, "Open-Loop phase duration"),
    (111, "can_autosend_period"),
    (112, "Fault state wait time before acknowledgement"),
    (113, "Electrical period measurement time-out"),
    (114, "Can TimeOut period"),
    (115, "Critical fault mask"),
    (121, "Over-temperature warning threshold"),
    (256, "Store parameters"),
    (257, "Store once parameters"),
    (258, "Reset calibration parameters"),
    (259, "Auto-calibrate"),
    (260, "Scope state"),
];

/// Last number of the dictionary.
const OWN_LAST: u16 = OWN_FIRST + (PARAMETER_COUNT - PRINTED_COUNT) as u16 - 1;

#[test]
fn rows_stand_in_the_order_of_their_numbers_and_our_own_have_no_gaps() {
    assert_eq!(PRINTED_COUNT, 122);
    let numbers: Vec<u16> = Dictionary::rows().map(|row| row.number).collect();
    assert_eq!(numbers, (0..122).chain(256..=OWN_LAST).collect::<Vec<u16>>());
}

#[test]
fn anchors_stand_where_they_were_published() {
    for (number, name) in ANCHORS {
        assert_eq!(Dictionary::row(number).map(|row| row.name()), Some(name), "parameter {number}");
        assert_eq!(Dictionary::find(name).map(|row| row.number), Some(number), "{name}");
    }
    assert_eq!((number::OPEN_LOOP_ENABLE, number::SENSORLESS_ENABLE, number::HALL_ENABLE), (81, 82, 83));
}

#[test]
fn names_are_unique_and_every_row_is_documented() {
    for row in Dictionary::rows() {
        assert_eq!(Dictionary::find(row.name()), Some(row), "{}", row.name());
        assert!(
            row.description().len() > 20 && row.description().ends_with('.'),
            "{}: {}",
            row.number,
            row.name()
        );
    }
}

#[test]
fn factory_values_lie_within_their_ranges() {
    let factory = Parameters::new();
    for (row, raw) in factory.iter() {
        assert!(row.min() <= row.default() && row.default() <= row.max(), "{} {}", row.number, row.name());
        assert!(row.accepts(raw), "{} {}", row.number, row.name());
        let (low, high) = match row.kind {
            Kind::U16 => (0, i64::from(u16::MAX)),
            Kind::I32 => (i64::from(i32::MIN), i64::from(i32::MAX)),
            Kind::U32 => (0, i64::from(u32::MAX)),
        };
        assert!(low <= row.min() && row.max() <= high, "{} {} does not fit its type", row.number, row.name());
    }
}

#[test]
fn stated_limits_and_defaults() {
    let factory = Parameters::new();
    let expect = [
        (number::OVER_VOLTAGE, 61_000),
        (number::UNDER_VOLTAGE, 16_000),
        (number::TEMPERATURE_WARNING, 1850),
        (number::OVER_TEMPERATURE, 1900),
        (number::OVER_CURRENT, 7000),
        (number::HV_CURRENT_MAX, 6000),
        (number::AUTOSEND_PERIOD, 50),
        (number::SPEED_MIN_SL, 500),
        (number::SPEED_MAX_SL, 4000),
        (number::SPEED_MIN_HES, 500),
        (number::SPEED_MAX_HES, 4000),
        (number::FAULT_WAIT, 500),
        (number::CAN_TIMEOUT, 250),
        (number::LOCK_DURATION, 150),
        (number::OPEN_LOOP_DURATION, 500),
        (number::SLAVE_CAN_ADDRESS, 170),
        (number::MASTER_CAN_ADDRESS, 85),
        (number::NOMINAL_SUPPLY, 0),
        (number::PHASE_CURRENT_MAX, 12_000),
        (number::HALL_STALL_TIME, 500),
    ];
    for (number, raw) in expect {
        assert_eq!(factory.value(number), Some(raw), "parameter {number}");
    }
    assert_eq!(factory.raw_u32(number::CRITICAL_FAULT_MASK), 0xFC00_007E);
}

#[test]
fn writing_rules_follow_the_category() {
    for row in Dictionary::rows() {
        let label = row.category.label();
        let live = ["04", "06", "13", "15", "16"].iter().any(|number| label.starts_with(number));
        match row.access {
            Access::ReadOnly => {}
            Access::Live => assert!(live, "{} {label}", row.number),
            Access::Stopped => assert!(!live, "{} {label}", row.number),
        }
    }
}

#[test]
fn errors_name_number_name_value_and_range() {
    let mut parameters = Parameters::new();
    let text = |result: Result<(), ParameterError>| result.unwrap_err().to_string();
    assert_eq!(
        text(parameters.set(number::CAN_TIMEOUT, 0)),
        "parameter 114 \"Can TimeOut period\": 0 ms is outside 1 to 60000 ms"
    );
    assert_eq!(
        text(parameters.set(number::OVER_VOLTAGE, 62_500)),
        "parameter 119 \"Over-voltage HV threshold\": 62.5 V is outside 18 to 62 V"
    );
    assert_eq!(
        text(parameters.set(number::SPEED_KP_HES, -1)),
        "parameter 93 \"Speed Kp coefficient HES\": -0.000000001 V/rpm is outside 0 to 2.147483647 V/rpm"
    );
    assert_eq!(
        text(parameters.set(number::MOTOR_POLE_PAIRS, 51)),
        "parameter 78 \"Motor pair poles\": 51 is outside 1 to 50"
    );
    assert_eq!(text(parameters.set(122, 0)), "there is no parameter 122");
    assert_eq!(text(parameters.set(255, 0)), "there is no parameter 255");
    assert_eq!(text(parameters.set(u16::MAX, 0)), "there is no parameter 65535");
    assert_eq!(parameters, Parameters::new());
}

#[test]
fn decimals_are_exact() {
    let text = |digits, exponent| Decimal { digits, exponent }.to_string();
    assert_eq!(text(61_000, -3), "61");
    assert_eq!(text(-5, -3), "-0.005");
    assert_eq!(text(1900, -1), "190");
    assert_eq!(text(12, 3), "12000");
    assert_eq!(text(i64::MIN, -18), "-9.223372036854775808");
}

#[test]
fn table() {
    let mut table = String::new();
    for row in Dictionary::rows() {
        let value = |digits| Decimal { digits, exponent: row.exponent }.to_string();
        table += &format!(
            "{:3} | {} | {} | {} 1e{} | {} | {}..={} | {} | {:?}{} | {:?}\n",
            row.number,
            row.category.label(),
            row.name(),
            row.kind.label(),
            row.exponent,
            row.unit(),
            value(row.min()),
            value(row.max()),
            value(row.default()),
            row.access,
            if row.command { " command" } else { "" },
            row.effect,
        );
    }
    insta::assert_snapshot!(table);
}

#[test]
fn a_set_survives_its_stored_form_and_a_damaged_one_is_refused() {
    let mut parameters = Parameters::new();
    parameters.set(number::CRITICAL_FAULT_MASK, -1).unwrap();
    let mut buffer = [0; 1024];
    let stored = postcard::to_slice(&parameters, &mut buffer).unwrap();
    assert_eq!(postcard::from_bytes::<Parameters>(stored), Ok(parameters.clone()));

    let raw: heapless::Vec<i32, PARAMETER_COUNT> = parameters.clone().into();
    let short: heapless::Vec<i32, PARAMETER_COUNT> = raw.iter().copied().skip(1).collect();
    assert_eq!(Parameters::try_from(short), Err(ParameterError::Layout));
    let mut damaged = raw;
    damaged[114] = 0;
    let error = Parameters::try_from(damaged.clone()).unwrap_err();
    assert!(matches!(error, ParameterError::OutOfRange { parameter, raw: 0 } if parameter.number == 114));
    let bytes = postcard::to_slice(&damaged, &mut buffer).unwrap();
    assert!(postcard::from_bytes::<Parameters>(bytes).is_err());
}

proptest! {
    #[test]
    fn a_write_is_taken_exactly_within_the_range(number in 0..=OWN_LAST + 10, raw: i32) {
        let mut parameters = Parameters::new();
        let before = parameters.clone();
        match parameters.set(number, raw) {
            Ok(()) => {
                let row = Dictionary::row(number).unwrap();
                prop_assert!(row.accepts(raw));
                prop_assert_eq!(parameters.value(number), Some(raw));
                let changed = parameters.iter().zip(before.iter()).filter(|(a, b)| a.1 != b.1);
                prop_assert!(changed.map(|(a, _)| a.0.number).all(|changed| changed == number));
            }
            Err(error) => {
                prop_assert_eq!(&parameters, &before);
                match error {
                    ParameterError::Unknown { .. } => prop_assert!(Dictionary::row(number).is_none()),
                    ParameterError::OutOfRange { parameter, .. } => prop_assert!(!parameter.accepts(raw)),
                    ParameterError::Layout => prop_assert!(false),
                }
            }
        }
    }
}
