//! Tests of every target, a file each: the tools that it needs, and its steps.

pub mod ffi;
pub mod firmware;
pub mod python;
pub mod rust;
pub mod wasm;

use crate::parity::{self, Random};
use crate::steps::{Step, run_all};
use clap::ValueEnum;
use std::path::Path;
use std::process::ExitCode;

/// Targets that can be tested alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Target {
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

/// Tests one target, or all of them; each ends with the conformance vectors on it.
pub fn run(root: &Path, target: Option<Target>) -> ExitCode {
    let targets: &[Target] = match &target {
        Some(target) => std::slice::from_ref(target),
        None => Target::value_variants(),
    };
    let mut steps: Vec<Step<'_>> = targets
        .iter()
        .flat_map(|target| match target {
            Target::Rust => rust::steps(root),
            Target::Ffi => ffi::steps(root),
            Target::Python => python::steps(root),
            Target::Wasm => wasm::steps(root),
            Target::Firmware => firmware::steps(root),
        })
        .collect();
    steps.push(Step::new("parity", || parity::run(root, targets)));
    steps.push(Step::new("random parity", || parity::run_random(root, targets, Random::default())));
    run_all(steps)
}
