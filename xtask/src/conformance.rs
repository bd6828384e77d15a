//! Conformance of every target: the programs that replay recordings there, which narx-lab compares.

use crate::programs::LAB;
use crate::test::{self, Target};
use clap::ValueEnum;
use narx_report::steps::Outcome;
use narx_report::{figures, target_directory};
use serde::Serialize;
use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::Command;

/// Place of a replayer's arguments, `[--ticks N] FILE...`, in its command: see `narx_lab::conformance`.
pub(crate) const ARGUMENTS: &str = "{}";

/// A program that replays recordings on a target.
#[derive(Serialize)]
pub(crate) struct Replayer {
    name: &'static str,
    command: Vec<String>,
}

impl Replayer {
    /// Builds a replayer of a command with [`ARGUMENTS`] in it.
    pub(crate) fn new(name: &'static str, command: &Command) -> Self {
        let words = std::iter::once(command.get_program()).chain(command.get_args());
        Self { name, command: words.map(|word| word.to_string_lossy().into_owned()).collect() }
    }
}

/// Compares every digest on this machine and on the builds of these targets; `arguments` are those of
/// narx-lab's `conformance`.
///
/// # Errors
/// Fails with every digest that differs from the recorded one, with the first tick and output that differ.
pub(crate) fn run(root: &Path, targets: &[Target], arguments: &[impl AsRef<OsStr>]) -> Outcome {
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
    let file = target_directory(root).join("replayers.json");
    figures::write(&file, &programs)?;
    let mut all: Vec<OsString> = vec!["conformance".into(), "--targets".into(), file.into()];
    all.extend(arguments.iter().map(|argument| argument.as_ref().to_owned()));
    LAB.run(root, &all)
}

/// Runs `cargo xtask conformance` on every target.
pub(crate) fn command(root: &Path, arguments: &[OsString]) -> Outcome {
    run(root, Target::value_variants(), arguments)
}
