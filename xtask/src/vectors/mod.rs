//! Conformance vectors: committed scenarios with the recordings that they give, in `tests/vectors`.
//!
//! `NAME.toml` says what happens and what must come of it, `NAME.narxrec` is the drive's recording of it. Whatever
//! claims to be the same control core replays every recording to the digest that it carries.

mod action;
mod expect;
mod run;
mod scenario;

pub use expect::{Expect, Seen, Speed, Wiring};
pub use run::{Run, run};
pub use scenario::{Invalid, Scenario};

use crate::steps;
use narx_core::motor::Drive;
use narx_core::recording::{Recording, replay};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Where the vectors are, in the repository at `root`.
pub fn directory(root: &Path) -> PathBuf {
    root.join("tests/vectors")
}

/// Every scenario of the repository at `root`, by name.
///
/// # Errors
/// One line that names the file and what is wrong with it.
pub fn scenarios(root: &Path) -> Result<Vec<Scenario>, String> {
    let directory = directory(root);
    names(&directory, "toml")?
        .iter()
        .map(|name| {
            Scenario::read(&directory.join(format!("{name}.toml"))).map_err(|error| error.to_string())
        })
        .collect()
}

/// Every recording of the repository at `root`, by name.
///
/// # Errors
/// The directory cannot be read.
pub fn recordings(root: &Path) -> Result<Vec<PathBuf>, String> {
    let directory = directory(root);
    let names = names(&directory, "narxrec")?;
    Ok(names.iter().map(|name| directory.join(format!("{name}.narxrec"))).collect())
}

/// Makes all recordings anew and prints what they are; with `check` nothing is written, and anything that differs is a
/// failure.
pub fn command(root: &Path, check: bool) -> ExitCode {
    steps::finish(regenerate(root, check))
}

/// Makes all recordings anew, or with `check` compares them: the closing line.
///
/// # Errors
/// Every vector that is not as it should be, a line each.
pub fn regenerate(root: &Path, check: bool) -> steps::Outcome {
    let directory = directory(root);
    let scenarios = scenarios(root)?;
    let mut wrong = orphans(&directory, &scenarios, check)?;
    let (mut bytes, mut changed) = (0, 0);
    println!("{:<28} {:>6} {:>8}  digest", "vector", "ticks", "bytes");
    for scenario in &scenarios {
        let fresh = run(scenario);
        let path = directory.join(format!("{}.narxrec", scenario.name));
        let old = fs::read(&path).ok();
        let same = old.as_ref() == Some(&fresh.recording);
        bytes += fresh.recording.len();
        changed += usize::from(!same);
        let note = if same { String::new() } else { changed_from(old.as_deref()) };
        let Run { ticks, digest, recording, .. } = &fresh;
        println!("{:<28} {ticks:>6} {:>8}  {digest:016x}{note}", scenario.name, recording.len());
        let mut reasons = scenario.expect.misses(&fresh.seen, Some(fresh.speed));
        if !same && check {
            reasons.push("the recording on disk is not what the scenario gives: cargo xtask vectors".into());
        }
        reasons.extend(replayed(&fresh).err());
        wrong.extend(reasons.into_iter().map(|reason| format!("{}: {reason}", scenario.name)));
        if !same && !check {
            fs::write(&path, &fresh.recording).map_err(|error| format!("{}: {error}", path.display()))?;
        }
    }
    if !wrong.is_empty() {
        return Err(wrong.join("\n"));
    }
    Ok(vec![format!("{} vectors, {bytes} bytes, {changed} changed", scenarios.len())])
}

/// What stood on disk before.
fn changed_from(old: Option<&[u8]>) -> String {
    let Some(old) = old else { return "  new".into() };
    match Recording::open(old).and_then(|recording| recording.verify()) {
        Ok(end) => format!("  was {:016x}", end.digest),
        Err(error) => format!("  was: {error}"),
    }
}

/// A replay of the fresh recording answers what was recorded.
fn replayed(run: &Run) -> Result<(), String> {
    let recording = Recording::open(&run.recording).map_err(|error| error.to_string())?;
    let outcome = replay::<Drive>(&recording).map_err(|error| error.to_string())?;
    if outcome.digest == run.digest && outcome.is_identical() {
        Ok(())
    } else {
        Err(format!("replays to digest {:016x}", outcome.digest))
    }
}

/// Recordings without a scenario: removed, or with `check` named.
fn orphans(directory: &Path, scenarios: &[Scenario], check: bool) -> Result<Vec<String>, String> {
    let mut wrong = Vec::new();
    for name in names(directory, "narxrec")? {
        if scenarios.iter().any(|scenario| scenario.name == name) {
            continue;
        }
        if check {
            wrong.push(format!("{name}: a recording without a scenario"));
        } else {
            let path = directory.join(format!("{name}.narxrec"));
            fs::remove_file(&path).map_err(|error| format!("{}: {error}", path.display()))?;
            println!("{name}: removed, it has no scenario");
        }
    }
    Ok(wrong)
}

/// File names without the extension, sorted.
fn names(directory: &Path, extension: &str) -> Result<Vec<String>, String> {
    let entries = fs::read_dir(directory).map_err(|error| format!("{}: {error}", directory.display()))?;
    let paths = entries.map_while(Result::ok).map(|entry| entry.path());
    let mut names: Vec<String> = paths
        .filter(|path| path.extension().is_some_and(|found| found == extension))
        .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
        .collect();
    names.sort();
    Ok(names)
}
