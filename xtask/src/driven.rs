//! The program that drives one motor with the real core in the loop (`sim/examples/driven.rs`), on which
//! speed and instruction counts are measured.

use narx_report::steps;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Measured control modes, as the program names them.
pub(crate) const MODES: [&str; 2] = ["hall", "sensorless"];

/// Builds the program in its release profile; returns its path.
///
/// # Errors
/// Fails with the compiler's message.
pub(crate) fn build(root: &Path) -> Result<PathBuf, String> {
    let mut build = Command::new("cargo");
    build.args(["build", "--release", "--quiet", "-p", "narx-sim", "--example", "driven"]);
    steps::run(build.current_dir(root))?;
    Ok(narx_report::target_directory(root).join("release/examples/driven"))
}
