//! Tests of docs/HARDWARE.md: its figures are those of the code, its parameters those of the dictionary, its
//! pins complete.

use narx_core::commissioning::SUPPLY;
use narx_core::dictionary::{Decimal, Dictionary, Parameter};
use narx_core::motor::Board;
use narx_core::motor::guard::fault::{Cause, FaultWord};
use narx_sim::bench::BITRATE;
use narx_sim::plant::InverterConfig;
use std::path::PathBuf;

fn text() -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs/HARDWARE.md");
    std::fs::read_to_string(path).unwrap()
}

/// Rows of every table that have at least `cells` cells.
fn rows(text: &str, cells: usize) -> Vec<Vec<&str>> {
    let rows = text.lines().filter_map(|line| line.strip_prefix('|')?.strip_suffix('|'));
    rows.map(|line| line.split('|').map(str::trim).collect())
        .filter(|row: &Vec<_>| row.len() >= cells)
        .collect()
}

/// Cells of the row that begins with `key`.
fn row<'a>(text: &'a str, key: &str) -> Vec<&'a str> {
    let mut found = rows(text, 2).into_iter().filter(|row| row[0] == key);
    let row = found.next().unwrap_or_else(|| panic!("no row {key}"));
    assert!(found.next().is_none(), "two rows {key}");
    row
}

fn factory(row: &Parameter) -> String {
    format!("{} {}", Decimal { digits: row.default(), exponent: row.exponent }, row.unit())
}

/// A last cell such as `119 Over-voltage HV threshold` names a parameter of the dictionary; the cell after
/// the name of the limit is its factory value.
#[test]
fn limits_are_the_factory_values_of_their_parameters() {
    let text = text();
    let mut found = 0;
    for cells in rows(&text, 4).into_iter().filter(|cells| cells.len() == 4) {
        let Some((number, name)) = cells[3].split_once(' ') else { continue };
        let Ok(number) = number.parse::<u16>() else { continue };
        let Some(parameter) = Dictionary::rows().find(|row| row.number == number && row.name() == name)
        else {
            panic!("no parameter {number} is called {name}");
        };
        assert_eq!(cells[1], factory(parameter), "{cells:?}");
        found += 1;
    }
    assert_eq!(found, 12);
}

#[test]
fn every_parameter_that_is_mentioned_exists() {
    let text = text();
    let mut found = 0;
    for mention in text.split("parameter ").skip(1) {
        let digits: String = mention.chars().take_while(char::is_ascii_digit).collect();
        let Ok(number) = digits.parse::<u16>() else { continue };
        assert!(Dictionary::rows().any(|row| row.number == number), "parameter {number}");
        found += 1;
    }
    assert!(found >= 8, "{found}");
}

#[test]
fn times_are_those_of_the_causes() {
    let text = text();
    let held = |cause: Cause| {
        let row = Cause::TABLE.into_iter().find(|row| row.cause == cause).unwrap();
        format!("{} ms", f64::from(row.qualification) / 1000.0)
    };
    for (key, cause) in [
        ("bus over-voltage", Cause::OverVoltage),
        ("bus under-voltage", Cause::UnderVoltage),
        ("bus over-current", Cause::OverCurrent),
        ("temperature warning", Cause::TemperatureWarning),
        ("temperature shutdown", Cause::OverTemperature),
        ("pressure", Cause::OverPressure),
    ] {
        assert_eq!(row(&text, key)[2].split(',').next(), Some(held(cause).as_str()), "{key}");
    }
    assert_eq!(row(&text, "shutdown input high (parameter 270)")[2], held(Cause::ShutdownLine));
    assert_eq!(row(&text, "master silent while driving")[2], row(&text, "silent master")[1]);
}

/// The document lists the faults that stop the motor even if they are masked, and those that can be masked.
#[test]
fn masks_are_those_of_the_fault_word() {
    let text = text();
    for (key, bits) in [
        (
            "over-voltage, under-voltage, over-current, gate driver, open phase",
            FaultWord::OVER_VOLTAGE
                | FaultWord::UNDER_VOLTAGE
                | FaultWord::OVER_CURRENT
                | FaultWord::LEGS_DRIVER,
        ),
        ("master silent while driving", FaultWord::DEVICE_TIMEOUT),
        ("hardware break input of the controller", FaultWord::EMERGENCY_SHUTDOWN),
    ] {
        assert!(FaultWord::critical(0, true).contains(bits), "{key}");
        assert!(!row(&text, key)[1].contains("unless"), "{key}");
    }
    let masked = row(&text, "parameter 115 with a bit cleared")[1];
    let bits =
        masked.split(|other: char| !other.is_ascii_digit()).filter_map(|digits| digits.parse::<u32>().ok());
    let named = bits.fold(FaultWord::empty(), |word, bit| word | FaultWord::from_bits_truncate(1 << bit));
    let never = FaultWord::TEMPERATURE_WARNING;
    assert_eq!(named, FaultWord::all() - FaultWord::critical(0, true) - never);
}

#[test]
fn ratings_are_those_of_the_bench_and_of_commissioning() {
    let text = text();
    let cells = |key| row(&text, key).join(" ");
    let supply = row(&text, "supply voltage");
    assert_eq!([supply[1], supply[3]], [SUPPLY.start(), SUPPLY.end()].map(|volts| format!("{volts} V")));
    assert!(cells("rate").contains(&format!("{} kbit/s", BITRATE / 1000)));
    assert!(cells("switching frequency").contains(&format!("{} kHz", Board::BENCH.tick_rate / 1000)));
    let capacitance = InverterConfig::default().capacitance * 1e6;
    assert!(cells("bus capacitance").contains(&format!("{capacitance:.0} uF")));
    for (key, number) in [("supply current", 106), ("phase current, peak", 269)] {
        let parameter = Dictionary::rows().find(|row| row.number == number).unwrap();
        let most = Decimal { digits: parameter.max(), exponent: parameter.exponent };
        assert_eq!(row(&text, key)[3], format!("{most} {}", parameter.unit()), "no more can be asked for");
    }
}

/// Pins 1 to 15 of P1 and 1 to 9 of P2 are listed, each once; Table 5 connects pins of P1 by their names
/// there.
#[test]
fn connectors_are_complete() {
    let text = text();
    let section = |title: &str| {
        let start = text.find(title).unwrap_or_else(|| panic!("no section {title}"));
        text[start + 3..].split("\n## ").next().unwrap().to_owned()
    };
    let pins = |section: &str| -> Vec<(u8, String)> {
        let rows = rows(section, 4);
        rows.iter().filter_map(|row| Some((row[0].parse().ok()?, row[1].to_owned()))).collect()
    };
    let (p1, p2) = (pins(&section("## 2. Connector P1")), pins(&section("## 3. Connector P2")));
    for (pins, last) in [(&p1, 15), (&p2, 9)] {
        assert!(pins.iter().map(|(pin, _)| *pin).eq(1..=last), "{pins:?}");
    }
    let signal =
        |pin: &str| p1.iter().find(|(number, _)| number.to_string() == pin).map(|(_, name)| name.as_str());
    for (name, on_p1) in [("CAN_H", "CAN_H"), ("CAN_L", "CAN_L"), ("CAN_Ref", "GND"), ("CAN_Shield", "GND")] {
        assert_eq!(signal(row(&text, name)[1]), Some(on_p1), "{name}");
    }
}
