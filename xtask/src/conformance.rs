//! Conformance of every target: narx-lab compares the programs that replay recordings there.

use crate::programs::LAB;
use crate::replayer::Replayer;
use narx_report::steps::Outcome;
use narx_report::{figures, target_directory};
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// Compares every digest on this machine and by these programs; `arguments` are those of narx-lab's
/// `conformance`.
///
/// # Errors
/// Fails with every digest that differs from the recorded one, with the first tick and output that differ.
pub(crate) fn run(root: &Path, programs: &[Replayer], arguments: &[impl AsRef<OsStr>]) -> Outcome {
    let file = target_directory(root).join("replayers.json");
    figures::write(&file, &programs)?;
    let mut all: Vec<OsString> = vec!["conformance".into(), "--targets".into(), file.into()];
    all.extend(arguments.iter().map(|argument| argument.as_ref().to_owned()));
    LAB.run(root, &all)
}
