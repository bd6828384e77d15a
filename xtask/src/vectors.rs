//! The recordings of the conformance vectors.

use std::fs;
use std::path::{Path, PathBuf};

/// Recordings of a drive, by name.
///
/// # Errors
/// Fails if their folder cannot be read.
pub(crate) fn recordings(root: &Path) -> Result<Vec<PathBuf>, String> {
    let folder = root.join("tests/vectors");
    let entries = fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.map_while(Result::ok).map(|entry| entry.path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "narxrec"));
    files.sort();
    Ok(files)
}
