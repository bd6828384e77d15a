//! Rows that the code lists: it determines which rows must exist, and adds its own information to them.

use super::effect::{causes, object_key};
use super::sources::{Sources, Vector};
use super::table::{Facts, Row, Section, Table};
use narx_core::bus::Id;
use narx_core::bus::narmotion::{Addresses, MessageId, MessageKind};
use narx_core::dictionary::{Dictionary, PRINTED_COUNT, Parameter};
use narx_core::eddycan::{OBJECTS, Object};
use narx_core::motor::guard::fault::FaultWord;
use narx_core::motor::machine::state::{State, TRANSITIONS};
use std::collections::BTreeSet;
use std::ops::Range;

/// First number of Table 11.
const CONTROL_FIRST: u16 = 78;

/// Returns the sections with everything that the code adds; reports in `wrong` every row that does not match
/// the code.
pub(super) fn complete(table: Table, sources: &Sources, wrong: &mut Vec<String>) -> Vec<Section> {
    let Table { mut section } = table;
    for section in &mut section {
        let printed = PRINTED_COUNT as u16;
        match section.facts {
            Facts::None => {}
            Facts::Transitions => transitions(section, sources, wrong),
            Facts::Faults => faults(section, sources, wrong),
            Facts::Messages => messages(section, sources, wrong),
            Facts::General => parameters(section, 0..CONTROL_FIRST, sources, wrong),
            Facts::Control => parameters(section, CONTROL_FIRST..printed, sources, wrong),
            Facts::Own => parameters(section, printed..u16::MAX, sources, wrong),
            Facts::Objects => objects(section, wrong),
        }
    }
    section
}

/// Adds the section's shared code and tests to every row, without duplicates.
pub(super) fn share(sections: &mut [Section]) {
    for section in sections {
        for row in &mut section.rows {
            row.code.extend(section.code.iter().cloned());
            row.tests.extend(section.tests.iter().cloned());
            for list in [&mut row.code, &mut row.tests, &mut row.vectors] {
                let mut seen = BTreeSet::new();
                list.retain(|entry| seen.insert(entry.clone()));
            }
        }
    }
}

/// Checks for one row for each name of the table, and no others; adds the vectors that take the transition.
fn transitions(section: &mut Section, sources: &Sources, wrong: &mut Vec<String>) {
    let names: BTreeSet<String> = TRANSITIONS.iter().map(ToString::to_string).collect();
    same_keys(section, names.into_iter().collect(), wrong);
    for row in &mut section.rows {
        let Some(found) = TRANSITIONS.iter().find(|found| found.to_string() == row.key) else { continue };
        row.says = format!("{} to {}: {}", found.from as u8, found.to as u8, row.says);
        let pair: [State; 2] = [found.from, found.to];
        let takes = |states: &[State]| states.windows(2).any(|window| window == pair);
        row.vectors.extend(sources.vectors(false, |vector| takes(&vector.expect.states)));
    }
}

/// Checks for one row for each bit of the fault word; adds its causes, and the vectors that end in them.
fn faults(section: &mut Section, sources: &Sources, wrong: &mut Vec<String>) {
    let bits = FaultWord::all().iter().map(|fault| fault.bits().trailing_zeros().to_string());
    let unused = section.rows.iter().map(|row| row.key.clone()).filter(|key| key.contains('-'));
    same_keys(section, bits.chain(unused).collect(), wrong);
    for row in section.rows.iter_mut().filter(|row| !row.key.contains('-')) {
        let causes: Vec<u16> = causes(&row.key).collect();
        let codes: Vec<String> = causes.iter().map(|code| format!("{code:04X}h")).collect();
        row.says = format!("{} ({})", row.says, codes.join(", "));
        row.vectors.extend(sources.vectors(false, |Vector { expect, .. }| {
            let warns = row.key == "0" && expect.faults.iter().any(|name| name == "TEMPERATURE_WARNING");
            warns || expect.codes.iter().any(|code| causes.contains(code))
        }));
    }
}

/// Checks the rows of messages. Keys are identifiers: each must follow from the addresses of the figure, type
/// and opcode, and there are 32. Adds the transcripts that contain them.
fn messages(section: &mut Section, sources: &Sources, wrong: &mut Vec<String>) {
    if section.rows.len() != 32 {
        wrong.push(format!("coverage, {}: {} rows, Figure 14 has 32", section.title, section.rows.len()));
    }
    let title = section.title.clone();
    for row in &mut section.rows {
        row.vectors.extend(sources.vectors(true, |vector| vector.text.contains(&row.key)));
        let id = u32::from_str_radix(&row.key, 16).ok().and_then(Id::extended);
        let id = id.and_then(|id| MessageId::decode(id).ok());
        let expected = id.map(|id| match id.kind {
            MessageKind::SlaveTx => Addresses::FACTORY.from_drive(id.opcode),
            kind => Addresses::FACTORY.to_drive(kind, id.opcode),
        });
        if id.is_none() || id != expected {
            wrong.push(format!("coverage, {title}: {} is no identifier of Figure 14", row.key));
        }
        let opcode = id.map_or(0, |id| id.opcode.raw());
        if !row.says.contains(&format!(" {opcode},")) {
            wrong
                .push(format!("coverage, {title}: {} has opcode {opcode}, not in \"{}\"", row.key, row.says));
        }
    }
}

/// Adds a row for every parameter: the code that reads it, and the tests and vectors that name it. Rows of
/// the file add to that.
fn parameters(section: &mut Section, numbers: Range<u16>, sources: &Sources, wrong: &mut Vec<String>) {
    let mut added = std::mem::take(&mut section.rows);
    for parameter in Dictionary::rows().filter(|row| numbers.contains(&row.number)) {
        let place = added.iter().position(|row| covers(&row.key, parameter.number));
        let own = place.map(|place| added[place].clone()).unwrap_or_default();
        section.rows.push(parameter_row(parameter, own, sources));
    }
    added.retain(|row| !numbers.clone().any(|number| covers(&row.key, number)));
    for row in added {
        wrong.push(format!("coverage, {}: no parameter {}", section.title, row.key));
    }
}

fn parameter_row(parameter: &Parameter, own: Row, sources: &Sources) -> Row {
    let is_range = own.key.contains('-');
    let mut row = Row { key: parameter.number.to_string(), says: parameter.name().to_owned(), ..own };
    if is_range {
        // Not every test of a range concerns every row of it.
        row.mentions.append(&mut row.tests);
    }
    if let Some(constant) = sources.constant(parameter.number) {
        row.code.extend(sources.users(constant).into_iter().map(|path| format!("{path} number::{constant}")));
        row.mentions.extend(sources.tests_of(constant));
        let name = format!("\"{}\"", parameter.name());
        row.vectors.extend(sources.vectors(false, |vector| vector.text.contains(&name)));
    }
    row
}

/// Returns whether a key, a number or `first-last`, covers this number.
fn covers(key: &str, number: u16) -> bool {
    let (first, last) = key.split_once('-').unwrap_or((key, key));
    let range = first.parse::<u16>().ok().zip(last.parse::<u16>().ok());
    range.is_some_and(|(first, last)| (first..=last).contains(&number))
}

/// Checks for one row for each object of the dictionary, by index and subindex.
fn objects(section: &mut Section, wrong: &mut Vec<String>) {
    let key = |object: &Object| object_key(object.index, object.subindex);
    same_keys(section, OBJECTS.iter().map(key).collect(), wrong);
    for row in &mut section.rows {
        let Some(object) = OBJECTS.iter().find(|object| key(object) == row.key) else { continue };
        object.name.clone_into(&mut row.says);
    }
}

fn same_keys(section: &Section, mut expected: Vec<String>, wrong: &mut Vec<String>) {
    for row in &section.rows {
        match expected.iter().position(|key| *key == row.key) {
            Some(place) => drop(expected.remove(place)),
            None => wrong.push(format!("coverage, {}: the code has no row {}", section.title, row.key)),
        }
    }
    for key in expected {
        wrong.push(format!("coverage, {}: row {key} of the code is missing", section.title));
    }
}
