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
pub use covered::Covered;
pub use difference::{Difference, locate};
pub use evidence::{Conformance, Set};
pub use random::Random;
pub use replayer::{Native, Replay, Replayer};
pub use table::Table;

use crate::vectors;
use clap::Args;
use narx_report::{figures, steps, target_directory};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `conformance`.
#[derive(Args, Clone, Debug)]
pub struct Arguments {
    #[command(flatten)]
    random: Random,
    /// File with the programs of the other targets, as `cargo xtask conformance` writes it
    #[arg(long, value_name = "FILE")]
    targets: Option<PathBuf>,
    /// Replay the committed vectors only
    #[arg(long, conflicts_with = "out")]
    vectors: bool,
    /// Replay vectors and random recordings, and write conformance.json into this folder
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

/// Replays on this machine and on the given targets, and compares every digest.
pub fn command(root: &Path, arguments: &Arguments) -> ExitCode {
    steps::finish(run(root, arguments))
}

fn run(root: &Path, arguments: &Arguments) -> steps::Outcome {
    let programs = arguments.targets.as_deref().map_or(Ok(Vec::new()), Replayer::read)?;
    let native: [&dyn Replay; 1] = [&Native];
    let targets: Vec<&dyn Replay> =
        native.into_iter().chain(programs.iter().map(|program| program as &dyn Replay)).collect();
    let directory = target_directory(root).join("conformance");
    match &arguments.out {
        Some(out) => measure(root, &targets, arguments.random, &root.join(out).join("conformance.json")),
        None if arguments.vectors => {
            let files = [vectors::recordings(root)?, vectors::transcripts(root)?].concat();
            compare(&targets, &files)
        }
        None => arguments.random.compare(&targets, &directory),
    }
}

/// Replays vectors and random recordings, and writes the result.
fn measure(root: &Path, targets: &[&dyn Replay], random: Random, path: &Path) -> steps::Outcome {
    let (vectors, transcripts) = (vectors::recordings(root)?, vectors::transcripts(root)?);
    let mut sets = vec![
        Set::of("vectors", targets, &vectors)?,
        Set::of("vectors of both nodes", targets, &transcripts)?,
    ];
    let (made, files) = random.sets(targets, &target_directory(root).join("conformance"))?;
    sets.extend(made);
    let conformance = Conformance {
        command: format!(
            "cargo xtask conformance --count {} --first {} --ticks {} --out docs/evidence",
            random.count, random.first, random.ticks
        ),
        commit: figures::commit(root),
        targets: targets.iter().map(|target| target.name().to_owned()).collect(),
        sets,
        covered: evidence::covered(&[vectors, files].concat()),
    };
    figures::write(path, &conformance)?;
    let closing = format!("{} digests equal, written to {}", conformance.digests(), path.display());
    Ok([closing].into_iter().chain(conformance.sets.iter().map(|set| set.times(targets))).collect())
}

/// Replays `files` on every target; the others are compared with the first one.
///
/// # Errors
/// Fails with every digest that differs from the recorded one, with the first tick and output that differ.
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
