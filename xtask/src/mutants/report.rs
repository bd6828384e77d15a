//! `mutants.json`: number of mutants of each area, their results, and the names of those that survive.

use super::areas::Area;
use super::outcomes::{Listed, Summary};
use narx_report::figures;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::Path;

/// A change of the code.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct Mutant {
    /// File of the change.
    pub(crate) file: String,
    /// Function that was changed; empty outside of any.
    pub(crate) function: String,
    /// Description of the change.
    pub(crate) mutation: String,
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

/// Results of an area's mutants.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Row {
    /// Name of the area.
    pub(crate) area: String,
    /// Description of the area.
    pub(crate) what: String,
    /// Number of mutants.
    pub(crate) mutants: usize,
    /// Number of mutants that were run.
    pub(crate) run: usize,
    /// Number for which a test failed.
    pub(crate) caught: usize,
    /// Number for which the tests hung: these count as noticed.
    pub(crate) timeout: usize,
    /// Number that do not build.
    pub(crate) unviable: usize,
    /// Mutants for which no test failed.
    pub(crate) missed: Vec<Mutant>,
}

impl Row {
    /// Counts the results of the listed mutants; the last result of each counts.
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

/// Content of the file.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Report {
    /// Rows in the order of the table of areas.
    pub(crate) areas: Vec<Row>,
}

impl Report {
    /// Reads a file.
    ///
    /// # Errors
    /// Fails if the file is missing, or has another content.
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
    }

    /// Writes rows into a file; those of other areas stay.
    ///
    /// # Errors
    /// Fails if it cannot be written.
    pub(super) fn write(path: &Path, rows: Vec<Row>) -> Result<(), String> {
        let mut report = Self::read(path).unwrap_or_default();
        report.areas.retain(|old| !rows.iter().any(|row| row.area == old.area));
        report.areas.extend(rows);
        let place = |row: &Row| super::areas::AREAS.iter().position(|area| area.name == row.area);
        report.areas.sort_by_key(place);
        figures::write(path, &report)
    }
}
