//! Equality of the bits on every target: conformance vectors times targets, with every digest equal.
//!
//! Each target is a program that replays recordings and prints a line for each (see [`Answer`]). If a digest
//! differs from the recorded one, bisection over the number of ticks finds the first tick that differs, and
//! its outputs show the difference.

mod answer;
mod covered;
mod difference;
mod evidence;
mod random;
mod replayer;
mod table;

pub use answer::Answer;
pub use covered::{Counts, Covered};
pub use difference::{Difference, locate};
pub use evidence::{Conformance, Set};
pub use random::Random;
pub use replayer::{Native, Replay, Replayer};
pub use table::Table;

use crate::test::{self, Target};
use crate::{figures, install, steps, vectors};
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Replays every vector on this machine and on the builds of these targets, and prints the table.
///
/// # Errors
/// Fails with every digest that differs from the recorded one, with the first tick and output that differ.
pub fn run(root: &Path, targets: &[Target]) -> steps::Outcome {
    let mut files = vectors::recordings(root)?;
    files.extend(vectors::transcripts(root)?);
    on(root, targets, |all| compare(all, &files))
}

/// Arguments of `conformance`.
#[derive(Args, Clone, Debug)]
pub struct Arguments {
    #[command(flatten)]
    random: Random,
    /// Replay the committed vectors, too, and write conformance.json into this folder
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Runs [`run_random`] as a command, on every target; with `--out` replays vectors and random recordings, and
/// writes the result.
pub fn command(root: &Path, arguments: &Arguments) -> ExitCode {
    let Arguments { random, out } = arguments;
    steps::finish(match out {
        None => run_random(root, Target::value_variants(), *random),
        Some(out) => measure(root, *random, &root.join(out).join("conformance.json")),
    })
}

fn measure(root: &Path, random: Random, path: &Path) -> steps::Outcome {
    let vectors = vectors::recordings(root)?;
    let directory = install::target_directory(root).join("parity");
    on(root, Target::value_variants(), |targets| {
        let transcripts = vectors::transcripts(root)?;
        let mut sets = vec![
            Set::of("vectors", targets, &vectors)?,
            Set::of("vectors of both nodes", targets, &transcripts)?,
        ];
        let (made, files) = random.sets(targets, &directory)?;
        sets.extend(made);
        let conformance = Conformance {
            command: format!(
                "cargo xtask conformance --count {} --first {} --ticks {} --out docs/evidence",
                random.count, random.first, random.ticks
            ),
            commit: figures::commit(root),
            targets: targets.iter().map(|target| target.name().to_owned()).collect(),
            sets,
            covered: evidence::covered(&[vectors.as_slice(), &files].concat()),
        };
        figures::write(path, &conformance)?;
        let closing = format!("{} digests equal, written to {}", conformance.digests(), path.display());
        Ok([closing].into_iter().chain(conformance.sets.iter().map(|set| set.times(targets))).collect())
    })
}

/// Replays recordings that are made for it, as [`run`] does the vectors.
///
/// # Errors
/// Those of [`run`].
pub fn run_random(root: &Path, targets: &[Target], random: Random) -> steps::Outcome {
    let directory = install::target_directory(root).join("parity");
    on(root, targets, |all| random.compare(all, &directory))
}

/// Calls `compare` with this machine and the builds of these targets.
fn on(
    root: &Path,
    targets: &[Target],
    compare: impl FnOnce(&[&dyn Replay]) -> steps::Outcome,
) -> steps::Outcome {
    let programs: Vec<Replayer> = targets
        .iter()
        .flat_map(|target| match target {
            Target::Rust => Vec::new(),
            Target::Ffi => test::ffi::replayers(root),
            Target::Python => test::python::replayers(root),
            Target::Wasm => test::wasm::replayers(root),
            Target::Firmware => test::firmware::replayers(root),
        })
        .collect();
    let native: [&dyn Replay; 1] = [&Native];
    let all: Vec<&dyn Replay> =
        native.into_iter().chain(programs.iter().map(|program| program as &dyn Replay)).collect();
    compare(&all)
}

/// Replays `files` on every target; the others are compared with the first one.
///
/// # Errors
/// Those of [`run`].
pub fn compare(targets: &[&dyn Replay], files: &[PathBuf]) -> steps::Outcome {
    let table = Table::new(targets, files);
    println!("{table}");
    let wrong = table.differences(targets, files);
    if wrong.is_empty() {
        Ok(vec![format!(
            "{} digests equal: {} vectors x {} targets",
            table.len(),
            files.len(),
            targets.len()
        )])
    } else {
        Err(wrong.join("\n"))
    }
}
