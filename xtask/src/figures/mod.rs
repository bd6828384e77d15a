//! Figures that were measured: each with its unit, its goal where there is one, and the command that measures it again. One kind of row for every table
//! and every page.

mod table;

pub use table::table;
pub(crate) use table::value;

use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;
use std::process::Command;
use std::str::FromStr;
use std::{fs, io};

/// What a figure must keep.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum Goal {
    /// This or more.
    AtLeast(f64),
    /// This or less.
    AtMost(f64),
}

impl Goal {
    /// Whether a figure keeps it.
    pub fn is_met(self, figure: f64) -> bool {
        match self {
            Self::AtLeast(bound) => figure >= bound,
            Self::AtMost(bound) => figure <= bound,
        }
    }
}

impl fmt::Display for Goal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtLeast(bound) => write!(f, ">= {bound}"),
            Self::AtMost(bound) => write!(f, "<= {bound}"),
        }
    }
}

impl FromStr for Goal {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("goal {text:?} is neither `>= NUMBER` nor `<= NUMBER`");
        let (relation, bound) = text.split_once(' ').ok_or_else(wrong)?;
        let bound = bound.parse().map_err(|_| wrong())?;
        match relation {
            ">=" => Ok(Self::AtLeast(bound)),
            "<=" => Ok(Self::AtMost(bound)),
            _ => Err(wrong()),
        }
    }
}

impl From<Goal> for String {
    fn from(goal: Goal) -> Self {
        goal.to_string()
    }
}

impl TryFrom<String> for Goal {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

/// One figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// What it is of.
    pub name: String,
    /// The figure; JSON knows no infinity, and what was not reached is null.
    pub figure: Option<f64>,
    /// Its unit; empty for a ratio or a count.
    pub unit: String,
    /// What is promised of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal: Option<Goal>,
    /// Of how many, beside what, by whom.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
}

impl Figure {
    /// A figure without goal.
    pub fn new(name: impl Into<String>, figure: f64, unit: &str) -> Self {
        let figure = figure.is_finite().then(|| rounded(figure));
        Self { name: name.into(), figure, unit: unit.into(), goal: None, note: String::new() }
    }

    /// With a lower bound.
    pub fn at_least(self, bound: f64) -> Self {
        Self { goal: Some(Goal::AtLeast(bound)), ..self }
    }

    /// With an upper bound.
    pub fn at_most(self, bound: f64) -> Self {
        Self { goal: Some(Goal::AtMost(bound)), ..self }
    }

    /// With words.
    pub fn note(self, note: impl Into<String>) -> Self {
        Self { note: note.into(), ..self }
    }

    /// Without a goal there is nothing to miss; a figure that was not reached misses its goal.
    pub fn is_met(&self) -> bool {
        self.goal.is_none_or(|goal| self.figure.is_some_and(|figure| goal.is_met(figure)))
    }
}

/// Six digits: more of a measurement would only make noise where it is committed.
fn rounded(figure: f64) -> f64 {
    format!("{figure:.5e}").parse().unwrap_or(figure)
}

/// What was measured together, by one command.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its name, as the command takes it.
    pub part: String,
    /// What measures it again.
    pub command: String,
    /// Why it was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skipped: Option<String>,
    /// What it came to.
    pub figures: Vec<Figure>,
    /// What missed a goal, each with what repeats it alone where that can be.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failures: Vec<String>,
}

impl Part {
    /// Figures, and what failed.
    pub fn new(figures: Vec<Figure>, failures: Vec<String>) -> Self {
        Self { figures, failures, ..Self::default() }
    }

    /// Nothing but a reason.
    pub fn skipped(reason: impl Into<String>) -> Self {
        Self { skipped: Some(reason.into()), ..Self::default() }
    }

    /// One of another part's figures and failures more.
    pub fn join(&mut self, other: Self) {
        self.figures.extend(other.figures);
        self.failures.extend(other.failures);
    }

    /// Every goal is met; what was not measured misses none.
    pub fn is_met(&self) -> bool {
        self.figures.iter().all(Figure::is_met)
    }

    /// The figure of that name.
    pub fn figure(&self, name: &str) -> Option<&Figure> {
        self.figures.iter().find(|figure| figure.name == name)
    }
}

/// Everything in one file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Where rates were measured: they hold for this machine only.
    pub machine: String,
    /// The parts, in the order in which they are measured.
    pub parts: Vec<Part>,
}

impl Report {
    /// Reads a file; an empty report if there is none.
    ///
    /// # Errors
    /// The file is not a report.
    pub fn read(path: &Path) -> Result<Self, String> {
        match fs::read_to_string(path) {
            Ok(text) => serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Self::default()),
            Err(error) => Err(format!("{}: {error}", path.display())),
        }
    }

    /// Writes the file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), String> {
        write(path, self)
    }

    /// The part of that name.
    pub fn part(&self, name: &str) -> Option<&Part> {
        self.parts.iter().find(|part| part.part == name)
    }

    /// Puts a part in the place of the older one, in the order of `order`.
    pub fn replace(&mut self, part: Part, order: &[&str]) {
        self.parts.retain(|old| old.part != part.part && order.contains(&old.part.as_str()));
        self.parts.push(part);
        self.parts.sort_by_key(|part| order.iter().position(|name| *name == part.part));
    }
}

/// Writes a value as JSON that can be reviewed.
pub(crate) fn write(path: &Path, value: &impl Serialize) -> Result<(), String> {
    let failed = |error: io::Error| format!("{}: {error}", path.display());
    if let Some(directory) = path.parent() {
        fs::create_dir_all(directory).map_err(failed)?;
    }
    let text = serde_json::to_string_pretty(value).map_err(|error| error.to_string())?;
    fs::write(path, text + "\n").map_err(failed)
}

/// The processor and how many threads it has, as the system names it.
pub fn machine() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let model = model.map_or("an unnamed processor", |(_, model)| model);
    format!("{model}, {} threads, {}", narx_host::parallel::threads(), std::env::consts::ARCH)
}

/// The commit that is checked out, with `-dirty` if files were changed since; of an archive nobody knows it.
pub fn commit(root: &Path) -> String {
    let told = Command::new("git")
        // No tags: a hash is what `git checkout` takes on every clone.
        .args(["describe", "--always", "--dirty", "--exclude", "*", "--abbrev=12"])
        .current_dir(root)
        .output();
    match told {
        Ok(told) if told.status.success() => String::from_utf8_lossy(&told.stdout).trim().to_owned(),
        _ => "unknown".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_read_as_it_was_written() {
        let path = std::env::temp_dir().join(format!("narx-report-{}.json", std::process::id()));
        let mut part = Part::new(
            vec![
                Figure::new("share", 99.871_234_5, "%").at_least(99.9).note("\"quoted\"\n"),
                Figure::new("never", f64::INFINITY, "s"),
            ],
            vec!["seed 7".into()],
        );
        part.part = "start".into();
        let report = Report { machine: machine(), parts: vec![part] };
        report.write(&path).unwrap();
        assert_eq!(Report::read(&path), Ok(report));
        fs::remove_file(&path).unwrap();
        assert_eq!(Report::read(&path), Ok(Report::default()));
    }

    #[test]
    fn files_without_history_have_no_commit() {
        assert_eq!(commit(Path::new("/")), "unknown");
        assert_eq!(commit(Path::new("/nowhere")), "unknown");
    }

    #[test]
    fn goals_are_met_at_their_bound_and_missed_by_what_was_not_reached() {
        for (figure, met) in [
            (Figure::new("", 99.9, "%").at_least(99.9), true),
            (Figure::new("", 99.8, "%").at_least(99.9), false),
            (Figure::new("", 2.0, "%").at_most(2.0), true),
            (Figure::new("", 2.1, "%").at_most(2.0), false),
            (Figure::new("", f64::INFINITY, "s").at_most(2.0), false),
            (Figure::new("", f64::NAN, "s").at_least(2.0), false),
            (Figure::new("", f64::NAN, "s"), true),
        ] {
            assert_eq!(figure.is_met(), met, "{figure:?}");
        }
        for text in [">= 99.9", "<= -0.5"] {
            assert_eq!(text.parse::<Goal>().unwrap().to_string(), text);
        }
        for text in ["99.9", "= 3", ">= x", ">=3"] {
            assert!(text.parse::<Goal>().unwrap_err().contains(text));
        }
    }

    #[test]
    fn a_part_that_is_measured_again_takes_its_place() {
        let part = |name: &str, failure: &str| Part {
            part: name.into(),
            failures: vec![failure.into()],
            ..Part::default()
        };
        let mut report = Report::default();
        for (name, failure) in [("c", "1"), ("a", "1"), ("gone", "1"), ("a", "2")] {
            report.replace(part(name, failure), &["a", "b", "c", "gone"]);
        }
        report.replace(part("b", "1"), &["a", "b", "c"]);
        let seen: Vec<_> =
            report.parts.iter().map(|part| (part.part.as_str(), part.failures[0].as_str())).collect();
        assert_eq!(seen, [("a", "2"), ("b", "1"), ("c", "1")]);
    }
}
