//! `tests/coverage.md`: each row of the specification, the code that carries it and the test that shows it.
//!
//! `tests/coverage.toml` has everything that cannot be read from the code. Every file, item, test and vector
//! named there must exist, and rows that the code lists (transitions, fault bits, parameters, messages) must
//! be complete: so the table cannot go out of date.

mod effect;
mod facts;
mod render;
mod sources;
mod table;

pub(crate) use effect::{Effect, Record};

use crate::Made;
use sources::Sources;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use table::Table;

/// Makes the table.
///
/// # Errors
/// Fails with a line for each name that does not exist, or that is missing.
pub fn make(root: &Path) -> Result<Made, String> {
    let sources = Sources::read(root)?;
    let mut wrong = Vec::new();
    let mut sections = facts::complete(read(root)?, &sources, &mut wrong);
    Record::read(root)?.apply(&mut sections, &mut wrong);
    facts::share(&mut sections);
    for section in &sections {
        section.check(&sources, &mut wrong);
    }
    if !wrong.is_empty() {
        return Err(wrong.join("\n"));
    }
    let rows: usize = sections.iter().map(|section| section.rows.len()).sum();
    let files = vec![("tests/coverage.md".into(), render::document(&sections, &sources))];
    Ok(Made { files, summary: format!("{rows} rows, each with its code and what shows it") })
}

fn read(root: &Path) -> Result<Table, String> {
    let path = root.join("tests/coverage.toml");
    let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    toml::from_str(&text).map_err(|error| format!("tests/coverage.toml: {error}"))
}

/// Effects that can be disabled, each with the name of its row and the tests that may notice it.
pub(crate) fn effects(root: &Path) -> Result<Vec<(Effect, String, Vec<String>)>, String> {
    let sections = facts::complete(read(root)?, &Sources::read(root)?, &mut Vec::new());
    let mut found = Vec::new();
    for section in &sections {
        for row in section.rows.iter().filter(|row| row.stays.is_empty()) {
            let tests = row.tests.iter().chain(&row.mentions).chain(&section.tests);
            let tests: BTreeSet<&String> =
                tests.filter(|test| !effect::BUILT.contains(&test.as_str())).collect();
            let tests: Vec<String> = tests.into_iter().cloned().collect();
            let effects = Effect::of(section, row).into_iter();
            found.extend(effects.map(|effect| (effect, row.says.clone(), tests.clone())));
        }
    }
    Ok(found)
}
