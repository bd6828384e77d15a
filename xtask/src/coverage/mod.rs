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

use crate::steps;
use sources::Sources;
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use table::Table;

/// Writes `tests/coverage.md`; with `check` only reports whether it would change.
pub fn command(root: &Path, check: bool) -> ExitCode {
    steps::finish(regenerate(root, check))
}

/// Writes the page or, with `check`, compares it; returns the closing line.
///
/// # Errors
/// Fails with a line for each name that does not exist, or that is missing.
pub fn regenerate(root: &Path, check: bool) -> steps::Outcome {
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
    let (document, summary) = render::document(&sections, &sources);
    let path = root.join("tests/coverage.md");
    if check && fs::read_to_string(&path).ok().as_ref() != Some(&document) {
        return Err("tests/coverage.md is out of date: cargo xtask coverage".into());
    }
    if !check {
        fs::write(&path, document).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(vec![summary])
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
            let mut tests: Vec<String> =
                row.tests.iter().chain(&row.mentions).chain(&section.tests).cloned().collect();
            tests.sort_unstable();
            tests.dedup();
            tests.retain(|test| !effect::BUILT.contains(&test.as_str()));
            let effects = Effect::of(section, row).into_iter();
            found.extend(effects.map(|effect| (effect, row.says.clone(), tests.clone())));
        }
    }
    Ok(found)
}
