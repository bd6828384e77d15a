//! The program that drives one motor with the real core in the loop (`sim/examples/driven.rs`), on which
//! speed and instruction counts are measured.

use crate::install;
use crate::steps;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Measured control modes, as the program names them.
pub const MODES: [&str; 2] = ["hall", "sensorless"];

/// Builds the program in its release profile; returns its path.
///
/// # Errors
/// Fails with the compiler's message.
pub fn build(root: &Path) -> Result<PathBuf, String> {
    let mut build = Command::new("cargo");
    build.args(["build", "--release", "--quiet", "-p", "narx-sim", "--example", "driven"]);
    steps::run(build.current_dir(root))?;
    Ok(install::target_directory(root).join("release/examples/driven"))
}

/// Runs a program; returns its output.
///
/// # Errors
/// Fails if the program does not start, or fails.
pub fn output(command: &mut Command) -> Result<String, String> {
    let program = command.get_program().display().to_string();
    let output = command.output().map_err(|error| format!("{program}: {error}"))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(format!("{program}: {}: {}", output.status, String::from_utf8_lossy(&output.stderr)))
    }
}
