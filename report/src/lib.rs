//! Steps of a command with their closing lines, and measured figures with their goals: shared by every
//! program of the developers.

#![forbid(unsafe_code)]

pub mod figures;
pub mod steps;

use std::env;
use std::path::{Path, PathBuf};

/// Root of the working copy in which the programs were built.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

/// Folder for everything that commands install, build or measure.
pub fn target_directory(root: &Path) -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from)
}
