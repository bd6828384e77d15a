//! Conformance vectors: committed scenarios with the recordings that they give, in `tests/vectors`.
//!
//! `NAME.toml` describes the actions and the expected results, `NAME.narxrec` is the drive's recording of it.
//! Every implementation of the control core must replay every recording to the digest in it.
//! `tests/vectors/transcripts` has those of the nodes on the bus, the drive's and a TX-Driver's.

mod action;
mod expect;
mod run;
mod scenario;

pub use expect::{Expect, Seen, Speed, Wiring};
pub use run::{Run, run};
pub use scenario::{Invalid, Of, Scenario};

use narx_core::recording::{ReadError, ReplayError, replay_any};
use narx_report::steps;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Folder of the vectors, in the repository at `root`.
pub fn directory(root: &Path) -> PathBuf {
    root.join("tests/vectors")
}

/// Folder of the nodes' vectors.
pub fn transcript_directory(root: &Path) -> PathBuf {
    directory(root).join("transcripts")
}

/// Scenarios of a drive in the repository at `root`, by name.
///
/// # Errors
/// Fails with one line that names the file and its error.
pub fn scenarios(root: &Path) -> Result<Vec<Scenario>, String> {
    read(&directory(root))
}

/// Scenarios of a node.
///
/// # Errors
/// Those of [`scenarios`].
pub fn transcript_scenarios(root: &Path) -> Result<Vec<Scenario>, String> {
    read(&transcript_directory(root))
}

fn read(directory: &Path) -> Result<Vec<Scenario>, String> {
    names(directory, "toml")?
        .iter()
        .map(|name| {
            Scenario::read(&directory.join(format!("{name}.toml"))).map_err(|error| error.to_string())
        })
        .collect()
}

/// Recordings of a drive in the repository at `root`, by name.
///
/// # Errors
/// Fails if the directory cannot be read.
pub fn recordings(root: &Path) -> Result<Vec<PathBuf>, String> {
    files(&directory(root))
}

/// Recordings of a node.
///
/// # Errors
/// Those of [`recordings`].
pub fn transcripts(root: &Path) -> Result<Vec<PathBuf>, String> {
    files(&transcript_directory(root))
}

fn files(directory: &Path) -> Result<Vec<PathBuf>, String> {
    let names = names(directory, "narxrec")?;
    Ok(names.iter().map(|name| directory.join(format!("{name}.narxrec"))).collect())
}

/// Makes all recordings anew and prints them. With `check` it writes nothing, and fails if one differs.
pub fn command(root: &Path, check: bool) -> ExitCode {
    steps::finish(regenerate(root, check))
}

/// Makes all recordings anew or, with `check`, compares them; returns the closing line.
///
/// # Errors
/// Fails with a line for every vector that is not as expected.
pub fn regenerate(root: &Path, check: bool) -> steps::Outcome {
    let [drives, nodes] = [directory(root), transcript_directory(root)];
    let scenarios: Vec<(PathBuf, Vec<Scenario>)> =
        [(drives, scenarios(root)?), (nodes, transcript_scenarios(root)?)].into();
    let mut wrong = Vec::new();
    for (directory, scenarios) in &scenarios {
        wrong.extend(orphans(directory, scenarios, check)?);
        let drives = scenarios.first().is_some_and(|scenario| scenario.of == Of::Drive);
        wrong.extend(scenarios.iter().filter(|scenario| (scenario.of == Of::Drive) != drives).map(
            |scenario| {
                format!(
                    "{}: a drive's belong into tests/vectors, the others into tests/vectors/transcripts",
                    scenario.name
                )
            },
        ));
    }
    let (mut count, mut bytes, mut changed) = (0, 0, 0);
    println!("{:<28} {:>6} {:>8}  digest", "vector", "ticks", "bytes");
    for (directory, scenario) in
        scenarios.iter().flat_map(|(directory, all)| all.iter().map(move |one| (directory, one)))
    {
        count += 1;
        let fresh = run(scenario);
        let path = directory.join(format!("{}.narxrec", scenario.name));
        let old = fs::read(&path).ok();
        let same = old.as_ref() == Some(&fresh.recording);
        bytes += fresh.recording.len();
        changed += usize::from(!same);
        let note = if same { String::new() } else { changed_from(old.as_deref()) };
        let Run { ticks, recording, .. } = &fresh;
        let digest = replay_any(recording).map(|outcome| outcome.digest);
        println!(
            "{:<28} {ticks:>6} {:>8}  {:016x}{note}",
            scenario.name,
            recording.len(),
            digest.unwrap_or(0)
        );
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
    Ok(vec![format!("{count} vectors, {bytes} bytes, {changed} changed")])
}

/// Describes the earlier content of the file.
fn changed_from(old: Option<&[u8]>) -> String {
    let Some(old) = old else { return "  new".into() };
    match replay_any(old) {
        Ok(outcome) => format!("  was {:016x}", outcome.recorded_digest),
        Err(ReplayError::Read(ReadError::LayoutVersion { found, .. })) => {
            format!("  was recorded with layout version {found}")
        }
        Err(error) => format!("  was: {error}"),
    }
}

/// Checks that a replay of the fresh recording gives the recorded digest.
fn replayed(run: &Run) -> Result<(), String> {
    let outcome = replay_any(&run.recording).map_err(|error| error.to_string())?;
    if outcome.is_identical() { Ok(()) } else { Err(format!("replays to digest {:016x}", outcome.digest)) }
}

/// Removes recordings without a scenario or, with `check`, names them.
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
