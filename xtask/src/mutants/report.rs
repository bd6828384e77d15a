//! `mutants.json`: how many mutants of each area there are, what came of them, and the names of those that live.

use super::areas::Area;
use super::outcomes::{Listed, Summary};
use crate::figures;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::Path;

/// A change of the code.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Mutant {
    /// Where.
    pub file: String,
    /// In which function; empty outside of any.
    pub function: String,
    /// What was changed.
    pub mutation: String,
}

impl fmt::Display for Mutant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, function, mutation } = self;
        if function.is_empty() {
            write!(f, "{file}: {mutation}")
        } else {
            write!(f, "{file}: {function}: {mutation}")
        }
    }
}

/// What came of an area's mutants.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    /// Name of the area.
    pub area: String,
    /// What it is.
    pub what: String,
    /// Mutants that there are.
    pub mutants: usize,
    /// Of these run; the others nobody has tried.
    pub run: usize,
    /// A test failed.
    pub caught: usize,
    /// The tests hung: noticed, too.
    pub timeout: usize,
    /// It does not build.
    pub unviable: usize,
    /// No test failed.
    pub missed: Vec<Mutant>,
}

impl Row {
    /// What came of those that are listed; the last result of each counts.
    pub(super) fn new(area: &Area, listed: &[Listed], results: &BTreeMap<String, Summary>) -> Self {
        let of = |summary| listed.iter().filter(move |mutant| results.get(&mutant.name) == Some(&summary));
        let mut missed: Vec<Mutant> = of(Summary::MissedMutant).map(Listed::mutant).collect();
        missed.sort();
        Self {
            area: area.name.into(),
            what: area.what.into(),
            mutants: listed.len(),
            run: listed.iter().filter(|mutant| results.contains_key(&mutant.name)).count(),
            caught: of(Summary::CaughtMutant).count(),
            timeout: of(Summary::Timeout).count(),
            unviable: of(Summary::Unviable).count(),
            missed,
        }
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { area, what, mutants, run, caught, timeout, unviable, missed } = self;
        write!(
            f,
            "{area} ({what}): {run} of {mutants} run: {caught} caught, {timeout} hung, {unviable} do not build, {} missed",
            missed.len()
        )
    }
}

/// The file.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Report {
    /// In the order of the table of areas.
    pub areas: Vec<Row>,
}

impl Report {
    /// Reads a file.
    ///
    /// # Errors
    /// There is none, or it is something else.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
    }

    /// Writes rows into a file; those of other areas stay.
    ///
    /// # Errors
    /// It cannot be written.
    pub(super) fn write(path: &Path, rows: Vec<Row>) -> Result<(), String> {
        let mut report = Self::read(path).unwrap_or_default();
        report.areas.retain(|old| !rows.iter().any(|row| row.area == old.area));
        report.areas.extend(rows);
        let place = |row: &Row| super::areas::AREAS.iter().position(|area| area.name == row.area);
        report.areas.sort_by_key(place);
        figures::write(path, &report)
    }
}
