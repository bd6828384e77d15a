//! Tests of every target, a file each: the tools that it needs, and its steps.

pub(crate) mod ffi;
pub(crate) mod firmware;
pub(crate) mod python;
pub(crate) mod rust;
pub(crate) mod wasm;

use crate::conformance;
use crate::replayer::Replayer;
use clap::ValueEnum;
use narx_report::steps::{Outcome, Step, run_groups};
use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

/// Targets that can be tested alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Target {
    /// Formatting, lints, Rust tests, the build without std, and our files in other people's tools
    Rust,
    /// The C library: on this machine and on an emulated Cortex-M4F
    Ffi,
    /// The Python package
    Python,
    /// The WebAssembly build: in Node and in Chromium
    Wasm,
    /// The firmware image on an emulated Cortex-M4F
    Firmware,
}

/// Tests one target, or all of them, two side by side; ends with the recordings on every tested target.
pub(crate) fn run(root: &Path, target: Option<Target>) -> ExitCode {
    let targets: &[Target] = match &target {
        Some(target) => std::slice::from_ref(target),
        None => &ORDER,
    };
    let groups = targets.iter().map(|target| match target {
        Target::Rust => rust::steps(root),
        Target::Ffi => ffi::steps(root),
        Target::Python => python::steps(root),
        Target::Wasm => wasm::steps(root),
        Target::Firmware => firmware::steps(root),
    });
    let last = vec![
        Step::new("conformance", || conformance::run(root, &replayers(root, targets), &["--vectors"])),
        Step::new("random recordings", || conformance::run(root, &replayers(root, targets), &[] as &[&str])),
    ];
    run_groups(groups.collect(), last)
}

/// Programs that replay recordings on these targets.
fn replayers(root: &Path, targets: &[Target]) -> Vec<Replayer> {
    let of = |target: &Target| match target {
        Target::Rust => Vec::new(),
        Target::Ffi => ffi::replayers(root),
        Target::Python => python::replayers(root),
        Target::Wasm => wasm::replayers(root),
        Target::Firmware => firmware::replayers(root),
    };
    targets.iter().flat_map(of).collect()
}

/// Runs `cargo xtask conformance` on every target.
pub(crate) fn conformance(root: &Path, arguments: &[OsString]) -> Outcome {
    conformance::run(root, &replayers(root, &ORDER), arguments)
}

/// Order in which the targets begin: the longest first, so that none is left alone at the end.
const ORDER: [Target; 5] = [Target::Rust, Target::Python, Target::Firmware, Target::Wasm, Target::Ffi];
