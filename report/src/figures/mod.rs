//! Measured figures: each with its unit, its goal if there is one, and the command that measures it again.
//! Every table and every page uses this kind of row.

mod table;

pub use table::{table, value};

use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;
use std::process::Command;
use std::str::FromStr;
use std::{fs, io};

/// Bound that a figure must keep.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum Goal {
    /// The figure must be at least this.
    AtLeast(f64),
    /// The figure must be at most this.
    AtMost(f64),
}

impl Goal {
    /// Returns whether a figure keeps the bound.
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

/// A measured figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Name of the measured quantity.
    pub name: String,
    /// Value of the figure. JSON has no infinity: a figure that was not reached is null.
    pub figure: Option<f64>,
    /// Its unit; empty for a ratio or a count.
    pub unit: String,
    /// Promise about the figure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal: Option<Goal>,
    /// Further words: number of samples, comparison, source.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
}

impl Figure {
    /// Builds a figure without goal.
    pub fn new(name: impl Into<String>, figure: f64, unit: &str) -> Self {
        let figure = figure.is_finite().then(|| rounded(figure));
        Self { name: name.into(), figure, unit: unit.into(), goal: None, note: String::new() }
    }

    /// Adds a lower bound.
    pub fn at_least(self, bound: f64) -> Self {
        Self { goal: Some(Goal::AtLeast(bound)), ..self }
    }

    /// Adds an upper bound.
    pub fn at_most(self, bound: f64) -> Self {
        Self { goal: Some(Goal::AtMost(bound)), ..self }
    }

    /// Adds a note.
    pub fn note(self, note: impl Into<String>) -> Self {
        Self { note: note.into(), ..self }
    }

    /// Returns whether the goal is met. A figure without goal always meets it; a figure that was not reached
    /// misses its goal.
    pub fn is_met(&self) -> bool {
        self.goal.is_none_or(|goal| self.figure.is_some_and(|figure| goal.is_met(figure)))
    }
}

/// Rounds to six digits: more would only make noise in the committed file.
fn rounded(figure: f64) -> f64 {
    format!("{figure:.5e}").parse().unwrap_or(figure)
}

/// Figures that one command measures together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Name of the part, as the command takes it.
    pub part: String,
    /// Command that measures it again.
    pub command: String,
    /// Reason why it was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skipped: Option<String>,
    /// Figures of the part.
    pub figures: Vec<Figure>,
    /// Misses of a goal, each with the command that repeats it alone where there is one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failures: Vec<String>,
}

impl Part {
    /// Builds a part of figures and failures.
    pub fn new(figures: Vec<Figure>, failures: Vec<String>) -> Self {
        Self { figures, failures, ..Self::default() }
    }

    /// Builds a part that was not measured, with the reason.
    pub fn skipped(reason: impl Into<String>) -> Self {
        Self { skipped: Some(reason.into()), ..Self::default() }
    }

    /// Adds the figures and failures of another part.
    pub fn join(&mut self, other: Self) {
        self.figures.extend(other.figures);
        self.failures.extend(other.failures);
    }

    /// Returns whether every goal is met; a part that was not measured misses none.
    pub fn is_met(&self) -> bool {
        self.figures.iter().all(Figure::is_met)
    }
}

/// Report: all parts in one file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Machine on which rates were measured: they hold for it only.
    pub machine: String,
    /// Parts in the order in which they are measured.
    pub parts: Vec<Part>,
}

impl Report {
    /// Reads a file; an empty report if there is none.
    ///
    /// # Errors
    /// Fails if the file is not a report.
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
    /// Fails if it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), String> {
        write(path, self)
    }

    /// Puts a part in the place of its older version, or at the end.
    pub fn replace(&mut self, part: Part) {
        match self.parts.iter_mut().find(|old| old.part == part.part) {
            Some(old) => *old = part,
            None => self.parts.push(part),
        }
    }
}

/// Writes a value as JSON that can be reviewed.
///
/// # Errors
/// Fails if it cannot be written.
pub fn write(path: &Path, value: &impl Serialize) -> Result<(), String> {
    let failed = |error: io::Error| format!("{}: {error}", path.display());
    if let Some(directory) = path.parent() {
        fs::create_dir_all(directory).map_err(failed)?;
    }
    let text = serde_json::to_string_pretty(value).map_err(|error| error.to_string())?;
    fs::write(path, text + "\n").map_err(failed)
}

/// Name of the processor, as the system gives it, and its number of threads.
pub fn machine() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let model = model.map_or("an unnamed processor", |(_, model)| model);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{model}, {threads} threads, {}", std::env::consts::ARCH)
}

/// Commit that is checked out, with `-dirty` if files were changed since; `unknown` outside a Git repository.
/// Files in `docs/evidence` do not count: the figures themselves are written there.
pub fn commit(root: &Path) -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).current_dir(root).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let head = git(&["rev-parse", "--short=12", "HEAD"]);
    let changed = git(&["status", "--porcelain", "--untracked-files=no", "--", ".", ":!docs/evidence"]);
    match (head, changed) {
        (Some(head), Some(changed)) => head + if changed.is_empty() { "" } else { "-dirty" },
        _ => "unknown".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A long run goes on from its own figures, and commands that measure follow each other.
    #[test]
    fn figures_do_not_make_a_commit_dirty() {
        let root = std::env::temp_dir().join(format!("narx-commit-{}", std::process::id()));
        let git = |arguments: &[&str]| {
            let identity = ["-c", "user.name=narx", "-c", "user.email=narx@example.com"];
            let status = Command::new("git").args(identity).args(arguments).current_dir(&root).status();
            assert!(status.unwrap().success(), "{arguments:?}");
        };
        fs::create_dir_all(root.join("docs/evidence")).unwrap();
        let write = |name: &str, text: &str| fs::write(root.join(name), text).unwrap();
        write("docs/evidence/figures.json", "1");
        write("code.rs", "1");
        git(&["init", "--quiet"]);
        git(&["add", "."]);
        git(&["commit", "--quiet", "--message", "first"]);
        let clean = commit(&root);
        assert_eq!(clean.len(), 12, "{clean}");
        write("docs/evidence/figures.json", "2");
        assert_eq!(commit(&root), clean);
        write("code.rs", "2");
        assert_eq!(commit(&root), format!("{clean}-dirty"));
        fs::remove_dir_all(&root).unwrap();
    }

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
        for (name, failure) in [("c", "1"), ("a", "1"), ("c", "2")] {
            report.replace(part(name, failure));
        }
        let seen: Vec<_> =
            report.parts.iter().map(|part| (part.part.as_str(), part.failures[0].as_str())).collect();
        assert_eq!(seen, [("c", "2"), ("a", "1")]);
    }
}
