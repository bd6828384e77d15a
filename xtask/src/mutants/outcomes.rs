//! Files that cargo-mutants writes: `mutants.out/outcomes.json`, and its list of the mutants.

use super::report::Mutant;
use serde::Deserialize;
use std::fs;
use std::path::Path;

/// A mutant as cargo-mutants describes it. Its name contains the line, so it is unique within one state of
/// the sources.
#[derive(Clone, Deserialize)]
pub(super) struct Listed {
    /// `FILE:LINE:COLUMN: MUTATION`.
    pub(super) name: String,
    file: String,
    function: Option<Function>,
    replacement: String,
    genre: String,
}

#[derive(Clone, Deserialize)]
struct Function {
    function_name: String,
}

impl Listed {
    /// Returns the mutant without its place, so that it stays the same when lines move.
    pub(super) fn mutant(&self) -> Mutant {
        let function = self.function.as_ref().map_or_else(String::new, |it| it.function_name.clone());
        let mutation = if self.genre == "FnValue" {
            format!("replace with {}", self.replacement)
        } else {
            let words = self.name.splitn(4, ':').nth(3).unwrap_or(&self.name).trim();
            words.strip_suffix(&format!(" in {function}")).unwrap_or(words).to_owned()
        };
        Mutant { file: self.file.clone(), function, mutation }
    }
}

/// Result of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub(super) enum Summary {
    /// Without a mutant: the tests pass.
    Success,
    /// Without a mutant: the tests fail.
    Failure,
    /// A test failed.
    CaughtMutant,
    /// No test failed.
    MissedMutant,
    /// The mutant does not build.
    Unviable,
    /// The tests hung.
    Timeout,
}

#[derive(Deserialize)]
struct Outcomes {
    outcomes: Vec<Outcome>,
}

#[derive(Deserialize)]
struct Outcome {
    scenario: Scenario,
    summary: Summary,
    #[serde(default)]
    phase_results: Vec<PhaseResult>,
}

#[derive(Deserialize)]
struct PhaseResult {
    phase: String,
}

impl Outcome {
    /// Returns whether the compiler took too long, not the tests: such a run has no result.
    fn is_of_the_machine(&self) -> bool {
        self.summary == Summary::Timeout && self.phase_results.iter().all(|result| result.phase != "Test")
    }
}

#[derive(Deserialize)]
enum Scenario {
    Baseline,
    Mutant(Box<Listed>),
}

/// Reads the result of each mutant of a run.
///
/// # Errors
/// Fails if the file is missing, or has another content.
pub(super) fn read(path: &Path) -> Result<Vec<(Listed, Summary)>, String> {
    let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    parse(&text).map_err(|error| format!("{}: {error}", path.display()))
}

fn parse(text: &str) -> Result<Vec<(Listed, Summary)>, serde_json::Error> {
    let outcomes: Outcomes = serde_json::from_str(text)?;
    let known = outcomes.outcomes.into_iter().filter(|outcome| !outcome.is_of_the_machine());
    let mutants = known.filter_map(|outcome| match outcome.scenario {
        Scenario::Mutant(mutant) => Some((*mutant, outcome.summary)),
        Scenario::Baseline => None,
    });
    Ok(mutants.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"{"outcomes": [
        {"scenario": "Baseline", "summary": "Success"},
        {"scenario": {"Mutant": {"name": "a.rs:57:9: replace F::c -> Self with Default::default()", "file": "a.rs",
            "function": {"function_name": "F::c"}, "replacement": "Default::default()", "genre": "FnValue"}}, "summary": "Unviable"},
        {"scenario": {"Mutant": {"name": "a.rs:162:19: replace < with <= in F::q", "file": "a.rs",
            "function": {"function_name": "F::q"}, "replacement": "<=", "genre": "BinaryOperator"}}, "summary": "MissedMutant"},
        {"scenario": {"Mutant": {"name": "a.rs:3:1: replace + with -", "file": "a.rs",
            "function": null, "replacement": "-", "genre": "BinaryOperator"}}, "summary": "CaughtMutant"},
        {"scenario": {"Mutant": {"name": "a.rs:4:1: replace + with -", "file": "a.rs",
            "function": null, "replacement": "-", "genre": "BinaryOperator"}}, "summary": "Timeout", "phase_results": [{"phase": "Build"}]},
        {"scenario": {"Mutant": {"name": "a.rs:5:1: delete !", "file": "a.rs",
            "function": null, "replacement": "", "genre": "UnaryOperator"}}, "summary": "Timeout",
            "phase_results": [{"phase": "Build"}, {"phase": "Test"}]}
    ], "total_mutants": 5}"#;

    /// A mutant is named without its line, and a build that took too long gives no result.
    #[test]
    fn a_mutant_is_named_without_its_line() {
        let read = parse(TEXT).unwrap();
        let seen: Vec<(String, Summary)> =
            read.iter().map(|(it, how)| (it.mutant().to_string(), *how)).collect();
        assert_eq!(
            seen,
            [
                ("a.rs: F::c: replace with Default::default()".to_owned(), Summary::Unviable),
                ("a.rs: F::q: replace < with <=".to_owned(), Summary::MissedMutant),
                ("a.rs: replace + with -".to_owned(), Summary::CaughtMutant),
                ("a.rs: delete !".to_owned(), Summary::Timeout),
            ]
        );
    }
}
