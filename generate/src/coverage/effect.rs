//! Effects that can be disabled in a running test (`core/src/blind.rs`), and the tests that failed without
//! them: `tests/effects.toml`.

use super::table::{Facts, Row, Section};
use narx_core::eddycan::{OBJECTS, Object};
use narx_core::motor::guard::fault::Cause;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{self, Write};
use std::fs;
use std::path::Path;

const FILE: &str = "tests/effects.toml";
const HEAD: &str = "\
# Made by `cargo xtask effects`: every effect that can be taken out (core/src/blind.rs), and the tests that failed without it.
# The coverage table names these and no others.
";

/// Tests that compare the coefficients into which a parameter is built: they show no effect.
pub(super) const BUILT: [&str; 3] = [
    "motor::parameters_that_are_converted_alone_reach_the_tick_in_its_units",
    "motor::what_does_not_fit_is_named_with_what_does",
    "protocol::what_the_tick_gets_is_what_the_set_builds",
];

/// An effect, as the environment variable `NARX_BLIND` names it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Effect {
    table: &'static str,
    row: u32,
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.table, self.row)
    }
}

impl Effect {
    /// Effects of a row of the coverage table; none for a row whose effect cannot be disabled.
    pub(crate) fn of(section: &Section, row: &Row) -> Vec<Self> {
        let key = row.key.as_str();
        let (table, rows): (_, Vec<u32>) = match section.facts {
            Facts::None => return Vec::new(),
            Facts::Transitions => ("transition", key.trim_start_matches('T').parse().into_iter().collect()),
            Facts::Faults => ("cause", causes(key).map(u32::from).collect()),
            Facts::Messages => {
                ("message", u32::from_str_radix(key, 16).map(|id| id & 0x7FF).into_iter().collect())
            }
            Facts::General | Facts::Control | Facts::Own => ("parameter", key.parse().into_iter().collect()),
            Facts::Objects => {
                let objects =
                    OBJECTS.iter().filter(|object| object_key(object.index, object.subindex) == key);
                let number =
                    |object: &Object| u32::from(object.index) << 8 | u32::from(object.subindex.unwrap_or(0));
                ("object", objects.map(number).collect())
            }
        };
        rows.into_iter().map(|row| Self { table, row }).collect()
    }
}

/// Extended fault codes of a bit.
pub(super) fn causes(bit: &str) -> impl Iterator<Item = u16> {
    let bit = bit.parse::<u16>().ok();
    Cause::TABLE.iter().map(|row| row.cause as u16).filter(move |code| bit == Some(code >> 8))
}

/// Key of an object's row.
pub(super) fn object_key(index: u16, subindex: Option<u8>) -> String {
    subindex.map_or_else(|| format!("{index:04X}h"), |subindex| format!("{index:04X}h.{subindex}"))
}

/// Tests that noticed each effect.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct Record(BTreeMap<String, BTreeMap<u32, BTreeSet<String>>>);

impl Record {
    /// Reads the file; without a file no effect has been noticed.
    pub(crate) fn read(root: &Path) -> Result<Self, String> {
        let Ok(text) = fs::read_to_string(root.join(FILE)) else { return Ok(Self::default()) };
        toml::from_str(&text).map_err(|error| format!("{FILE}: {error}"))
    }

    /// Writes the file.
    pub(crate) fn write(&self, root: &Path) -> Result<(), String> {
        let mut text = String::from(HEAD);
        for (table, rows) in &self.0 {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "\n[{table}]");
            for (row, tests) in rows {
                let tests: Vec<&String> = tests.iter().collect();
                let _ = writeln!(text, "{row} = {tests:?}");
            }
        }
        fs::write(root.join(FILE), text).map_err(|error| format!("{FILE}: {error}"))
    }

    /// Records the tests that have just noticed an effect.
    pub(crate) fn set(&mut self, effect: &Effect, tests: BTreeSet<String>) {
        self.0.entry(effect.table.to_owned()).or_default().insert(effect.row, tests);
    }

    /// Forgets effects that no longer exist.
    pub(crate) fn keep_only(&mut self, effects: &BTreeSet<Effect>) {
        for (table, rows) in &mut self.0 {
            rows.retain(|row, _| effects.iter().any(|effect| effect.table == table && effect.row == *row));
        }
    }

    pub(crate) fn of(&self, effect: &Effect) -> Option<&BTreeSet<String>> {
        self.0.get(effect.table)?.get(&effect.row)
    }

    /// Keeps, in each row whose effects can be disabled, only the tests that notice them. A test that the
    /// table names for a row but that does not notice is reported as wrong, and so is an effect that no test
    /// notices.
    pub(super) fn apply(&self, sections: &mut [Section], wrong: &mut Vec<String>) {
        for section in sections {
            let effects: Vec<Vec<Effect>> = section.rows.iter().map(|row| Effect::of(section, row)).collect();
            for (row, effects) in section.rows.iter_mut().zip(effects) {
                if !row.stays.is_empty() {
                    row.says = format!("{} ({})", row.says, row.stays);
                }
                if effects.is_empty() || !row.stays.is_empty() {
                    continue;
                }
                let mut miss = |what: String| {
                    wrong.push(format!("coverage, {}, row {}: {what}", section.title, row.key));
                };
                let mut notice = BTreeSet::new();
                for effect in &effects {
                    match self.of(effect) {
                        Some(tests) if !tests.is_empty() => notice.extend(tests.iter().cloned()),
                        _ => miss(format!("no test notices that the effect of {effect} is gone")),
                    }
                }
                for test in row.tests.iter().filter(|test| !notice.contains(*test)) {
                    miss(format!("{test} does not notice that the effect is gone"));
                }
                row.tests.append(&mut row.mentions);
                row.tests.retain(|test| notice.contains(test));
            }
        }
    }
}
