//! `tests/coverage.md`: each row of the specification, the code that carries it and the test that shows it.
//!
//! What cannot be read from the code stands in `tests/coverage.toml`. Every file, item, test and vector named there must
//! exist, and rows that the code lists (transitions, fault bits, parameters, messages) must all be there: so the table
//! cannot rot.

mod facts;
mod render;
mod sources;
mod table;

use crate::steps;
use sources::Sources;
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use table::Table;

/// Writes `tests/coverage.md`; with `check` only says whether it would change.
pub fn command(root: &Path, check: bool) -> ExitCode {
    steps::finish(regenerate(root, check))
}

/// Writes the page, or with `check` compares it: the closing line.
///
/// # Errors
/// Whatever is named and does not exist, or is missing, a line each.
pub fn regenerate(root: &Path, check: bool) -> steps::Outcome {
    let path = root.join("tests/coverage.toml");
    let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let table: Table = toml::from_str(&text).map_err(|error| format!("tests/coverage.toml: {error}"))?;
    let sources = Sources::read(root)?;
    let mut wrong = Vec::new();
    let sections = facts::complete(table, &sources, &mut wrong);
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
