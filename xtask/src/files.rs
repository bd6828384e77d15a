//! Files and folders, with errors that name them.

use narx_report::steps::{self, Outcome};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Returns the text of a file.
///
/// # Errors
/// Fails with the file's name.
pub(crate) fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// Writes a file, and makes its folder.
///
/// # Errors
/// Fails with the file's name.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), String> {
    make_parent(path)?;
    fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}

/// Copies a file, or a folder with everything in it, and makes the folder of the copy.
///
/// # Errors
/// Fails with the name of the file.
pub(crate) fn copy(from: &Path, to: &Path) -> Result<(), String> {
    let failed = |error| format!("{}: {error}", from.display());
    if from.is_dir() {
        let entries = fs::read_dir(from).map_err(failed)?;
        return entries.flatten().try_for_each(|entry| copy(&entry.path(), &to.join(entry.file_name())));
    }
    make_parent(to)?;
    fs::copy(from, to).map(drop).map_err(failed)
}

/// Packs a folder: equal files give equal bytes.
///
/// # Errors
/// Fails with the message of tar.
pub(crate) fn pack(folder: &Path, to: &Path) -> Outcome {
    let (parent, name) = (folder.parent().unwrap_or(folder), folder.file_name().unwrap_or_default());
    let mut tar = Command::new("tar");
    tar.args(["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "--mtime=@0"]);
    tar.args(["--mode=u+rw,go+r,go-w", "--use-compress-program=gzip -9n", "-cf"]);
    steps::run(tar.arg(to).arg("-C").arg(parent).arg(name))
}

fn make_parent(path: &Path) -> Result<(), String> {
    let parent = path.parent().unwrap_or(path);
    fs::create_dir_all(parent).map_err(|error| format!("{}: {error}", parent.display()))
}
