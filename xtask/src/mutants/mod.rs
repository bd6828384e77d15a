//! Changes the code on purpose, one place at a time, and checks that a test fails: cargo-mutants, area by
//! area. The time for one mutant matters most. Each is therefore run against small programs of the tests that
//! concern its area (`tests/mutants`), at first without the tests that take long; only the mutants that
//! survive are run against these, too.

mod areas;
mod outcomes;
mod report;
mod tree;

pub(crate) use report::{Report, Row};

use crate::install;
use areas::{AREAS, Area, Tests};
use narx_report::steps::{self, Outcome};
use narx_report::target_directory;
use outcomes::{Listed, Summary};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, fs};

/// Version of cargo-mutants.
const VERSION: &str = "27.1.0";

/// Selection of mutants.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Areas to mutate; without a name all of them: tick, machine, boot, storage, narmotion, eddycan
    areas: Vec<String>,
    /// Run a part of an area's mutants: 0/4 is the first quarter
    #[arg(long)]
    shard: Option<String>,
    /// Run at most this many of the mutants that have not run yet
    #[arg(long, value_name = "COUNT", conflicts_with = "shard")]
    rest: Option<usize>,
    /// Run only those that were missed last time, to see whether new tests notice them
    #[arg(long, conflicts_with_all = ["shard", "rest"])]
    missed: bool,
    /// Run nothing; write the results of the runs so far
    #[arg(long, conflicts_with_all = ["shard", "rest", "missed"])]
    collect: bool,
    /// Folder of mutants.json
    #[arg(long, default_value = "target")]
    out: PathBuf,
}

/// Runs `cargo xtask mutants`.
pub(crate) fn command(root: &Path, arguments: &Arguments) -> ExitCode {
    steps::finish(mutate(root, arguments))
}

fn mutate(root: &Path, arguments: &Arguments) -> Outcome {
    let areas = chosen(&arguments.areas)?;
    install::cargo_program("cargo-mutants", VERSION)?;
    let folder = env::current_dir().unwrap_or_default().join(target_directory(root)).join("mutation");
    let workspace = Workspace { tree: folder.join("tree"), folder };
    tree::refresh(root, &workspace.tree)?;
    let mut rows = Vec::new();
    for area in areas {
        if !arguments.collect {
            workspace.run(area, arguments)?;
        }
        rows.push(Row::new(area, &workspace.list(area)?, &workspace.results(area)?));
    }
    let mut lines: Vec<String> = rows.iter().flat_map(told).collect();
    let out = root.join(&arguments.out).join("mutants.json");
    Report::write(&out, rows)?;
    lines.push(format!("written to {}", out.display()));
    Ok(lines)
}

fn chosen(names: &[String]) -> Result<Vec<&'static Area>, String> {
    let known = |name: &String| AREAS.iter().any(|area| area.name == name);
    if let Some(unknown) = names.iter().find(|name| !known(name)) {
        return Err(format!("no area {unknown:?}; there are {}", AREAS.map(|area| area.name).join(" ")));
    }
    Ok(AREAS.iter().filter(|area| names.is_empty() || names.iter().any(|name| name == area.name)).collect())
}

/// Lines about an area: its figures, and its survivors.
fn told(row: &Row) -> Vec<String> {
    let missed = row.missed.iter().map(|mutant| format!("    {mutant}"));
    [row.to_string()].into_iter().chain(missed).collect()
}

/// Place of the mutations: a copy of the working copy, and the results beside it.
struct Workspace {
    folder: PathBuf,
    tree: PathBuf,
}

impl Workspace {
    /// Runs an area: quick tests, then the long ones for the mutants that survive. Each run writes a folder
    /// of its own; the last result of a mutant counts.
    fn run(&self, area: &Area, arguments: &Arguments) -> Result<(), String> {
        let mut command = self.cargo_mutants(area);
        let mut only = Vec::new();
        if let Some(shard) = &arguments.shard {
            command.args(["--shard", shard]);
        } else if arguments.missed || arguments.rest.is_some() {
            only = match arguments.rest {
                Some(count) => rest(self.list(area)?, &self.results(area)?, count),
                None => self.missed(area)?,
            };
            if only.is_empty() {
                return Ok(());
            }
        } else {
            // A run of all mutants begins anew; runs of parts add up.
            fs::remove_dir_all(self.folder.join(area.name)).ok();
        }
        self.pass(area, &area.quick, command, &only)?;
        // Survivors of parts are run against the long tests only once, after the last part.
        let is_part = arguments.shard.is_some() || arguments.rest.is_some();
        let missed = if is_part { Vec::new() } else { self.missed(area)? };
        match &area.long {
            Some(long) if !missed.is_empty() => self.pass(area, long, self.cargo_mutants(area), &missed),
            _ => Ok(()),
        }
    }

    fn cargo_mutants(&self, area: &Area) -> Command {
        let mut command = Command::new("cargo");
        command.args(["mutants", "--package", area.package]).current_dir(&self.tree);
        command.args(area.files.iter().flat_map(|file| ["--file", file]));
        command
    }

    fn pass(&self, area: &Area, tests: &Tests, mut command: Command, only: &[Listed]) -> Result<(), String> {
        let passes = self.passes(area);
        let next = self.folder.join(area.name).join(format!("{:03}", passes.len()));
        fs::create_dir_all(&next).map_err(|error| format!("{}: {error}", next.display()))?;
        self.check(tests)?;
        command.args([
            "--in-place",
            "--baseline=skip",
            "--timeout",
            tests.timeout,
            "--no-shuffle",
            "--output",
        ]);
        command.arg(&next).args(["--test-package", tests.package]);
        command.args(tests.programs.iter().map(|program| format!("--cargo-arg=--test={program}")));
        command.args(features(tests));
        for mutant in only {
            command.args(["--re", &format!("^{}$", escaped(&mutant.name))]);
        }
        if !tests.skip.is_empty() {
            command.args(["--", "--"]).args(tests.skip.iter().flat_map(|name| ["--skip", name]));
        }
        command.env("CARGO_TARGET_DIR", self.target());
        // The first counter-example suffices.
        command.env("PROPTEST_MAX_SHRINK_ITERS", "0").env_remove("UPDATE").env_remove("INSTA_UPDATE");
        let status = command.status().map_err(|error| format!("cargo: {error}"))?;
        match status.code() {
            // Exit codes: all caught; some missed; some hung.
            Some(0 | 2 | 3) => Ok(()),
            _ => Err(format!("{}: cargo mutants failed, {status}: {}", area.name, next.display())),
        }
    }

    /// Checks that the tests pass without a mutant; else every mutant would count as caught. cargo-mutants
    /// itself would run the tests of the mutated package.
    fn check(&self, tests: &Tests) -> Result<(), String> {
        let mut cargo = Command::new("cargo");
        cargo.args(["test", "--profile", "mutants", "--package", tests.package]).args(features(tests));
        cargo.args(tests.programs.iter().flat_map(|program| ["--test", program]));
        if !tests.skip.is_empty() {
            cargo.arg("--").args(tests.skip.iter().flat_map(|name| ["--skip", name]));
        }
        cargo.env("CARGO_TARGET_DIR", self.target()).current_dir(&self.tree);
        steps::run(&mut cargo).map(drop)
    }

    fn target(&self) -> PathBuf {
        self.folder.join("target")
    }

    /// Lists the mutants of an area.
    fn list(&self, area: &Area) -> Result<Vec<Listed>, String> {
        let output = self.cargo_mutants(area).args(["--list", "--json"]).output();
        let output = output.map_err(|error| format!("cargo: {error}"))?;
        if !output.status.success() {
            return Err(format!("cargo mutants: {}", String::from_utf8_lossy(&output.stderr)));
        }
        serde_json::from_slice(&output.stdout).map_err(|error| format!("cargo mutants --list: {error}"))
    }

    fn missed(&self, area: &Area) -> Result<Vec<Listed>, String> {
        let results = self.results(area)?;
        let mut listed = self.list(area)?;
        listed.retain(|mutant| results.get(&mutant.name) == Some(&Summary::MissedMutant));
        Ok(listed)
    }

    fn results(&self, area: &Area) -> Result<BTreeMap<String, Summary>, String> {
        let mut results = BTreeMap::new();
        for pass in self.passes(area) {
            for (mutant, summary) in outcomes::read(&pass.join("mutants.out/outcomes.json"))? {
                learn(&mut results, mutant.name, summary);
            }
        }
        Ok(results)
    }

    /// Folders of the area's runs, in their order.
    fn passes(&self, area: &Area) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.folder.join(area.name)).into_iter().flatten().flatten();
        let mut passes: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
        passes.sort();
        passes
    }
}

/// Records a run's result of a mutant. The last result counts, but a mutant that a test has noticed stays
/// noticed: cargo-mutants does not restrict every kind of mutant to the given test names, so other tests may
/// have run it, too.
fn learn(results: &mut BTreeMap<String, Summary>, name: String, summary: Summary) {
    let is_noticed = matches!(results.get(&name), Some(Summary::CaughtMutant | Summary::Timeout));
    if !(is_noticed && summary == Summary::MissedMutant) {
        results.insert(name, summary);
    }
}

/// Returns the first mutants without a result.
fn rest(mut listed: Vec<Listed>, results: &BTreeMap<String, Summary>, count: usize) -> Vec<Listed> {
    listed.retain(|mutant| !results.contains_key(&mutant.name));
    listed.truncate(count);
    listed
}

/// Features of the tests, whose package is not the mutated one.
fn features(tests: &Tests) -> Vec<String> {
    match tests.features {
        "" => Vec::new(),
        features => vec!["--features".into(), format!("{}/{features}", tests.package)],
    }
}

/// Converts a name into a regular expression that matches it only. Not every character may be escaped: `\\<`
/// is the beginning of a word.
fn escaped(name: &str) -> String {
    let mut escaped = String::new();
    for letter in name.chars() {
        if r"\.+*?()|[]{}^$&".contains(letter) {
            escaped.push('\\');
        }
        escaped.push(letter);
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_area_that_is_not_there_is_named_with_those_that_are() {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let error = chosen(&names(&["boot", "shell"])).err().unwrap();
        assert_eq!(error, "no area \"shell\"; there are tick machine boot storage narmotion eddycan");
        assert_eq!(chosen(&[]).unwrap().len(), AREAS.len());
        assert_eq!(chosen(&names(&["boot"])).unwrap()[0].name, "boot");
    }

    #[test]
    fn the_rest_is_what_has_no_result() {
        let texts: Vec<String> = ["a", "b", "c", "d"]
            .map(|name| format!(r#"{{"name": "{name}", "file": "", "replacement": "", "genre": ""}}"#))
            .into();
        let listed: Vec<Listed> = texts.iter().map(|text| serde_json::from_str(text).unwrap()).collect();
        let results = [("b", Summary::CaughtMutant), ("c", Summary::MissedMutant)];
        let results = results.map(|(name, summary)| (name.to_owned(), summary)).into();
        let names = |count| -> Vec<String> {
            rest(listed.clone(), &results, count).into_iter().map(|it| it.name).collect()
        };
        assert_eq!(names(9), ["a", "d"]);
        assert_eq!(names(1), ["a"]);
    }

    #[test]
    fn what_a_test_has_noticed_stays_noticed() {
        let mut results = BTreeMap::new();
        let words = [
            ("a", Summary::CaughtMutant),
            ("b", Summary::MissedMutant),
            ("c", Summary::Timeout),
            ("a", Summary::MissedMutant),
            ("b", Summary::CaughtMutant),
            ("c", Summary::MissedMutant),
            ("d", Summary::MissedMutant),
        ];
        for (name, summary) in words {
            learn(&mut results, name.to_owned(), summary);
        }
        let seen: Vec<Summary> = results.into_values().collect();
        assert_eq!(
            seen,
            [Summary::CaughtMutant, Summary::CaughtMutant, Summary::Timeout, Summary::MissedMutant]
        );
    }

    /// The name of a mutant contains operators, which are also special characters of a regular expression; it
    /// still matches itself only.
    #[test]
    fn a_name_matches_itself_alone() {
        assert_eq!(escaped("a.rs:1:2: replace += with *="), r"a\.rs:1:2: replace \+= with \*=");
        assert_eq!(escaped("replace <impl A for B>::f with ()"), r"replace <impl A for B>::f with \(\)");
    }
}
