//! Files that contain `unsafe`: bindings to C and boards, nothing else.

use std::fs;
use std::path::Path;

/// Crates that must not contain it.
const SAFE: [&str; 5] = ["core/src", "boot/src", "board/src", "sim/src", "sim/host/src"];
/// Folders that may contain it, in the files that the golden list names.
const FIRMWARE: &str = "firmware";
const BOARDS: [&str; 4] =
    ["firmware/src/boards/", "firmware/src/bin/", "firmware/gauges/", "firmware/b-g431b-esc1/"];

/// Files of the firmware with `unsafe` in their code.
///
/// # Errors
/// Fails if one is not a file of a board, or if a crate that must not contain it does.
pub(super) fn find(root: &Path) -> Result<Vec<String>, String> {
    for directory in SAFE {
        if let Some(file) = files_with(root, &root.join(directory))?.first() {
            return Err(format!("{file} contains unsafe code"));
        }
    }
    let found = files_with(root, &root.join(FIRMWARE))?;
    match found.iter().find(|file| !BOARDS.iter().any(|board| file.starts_with(board))) {
        Some(file) => Err(format!("{file} contains unsafe code and is no file of a board")),
        None => Ok(found),
    }
}

fn files_with(root: &Path, directory: &Path) -> Result<Vec<String>, String> {
    let fail = |error| format!("{}: {error}", directory.display());
    let mut found = Vec::new();
    for entry in fs::read_dir(directory).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        if path.is_dir() {
            found.extend(files_with(root, &path)?);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
            if text.lines().any(is_unsafe) {
                found.push(path.strip_prefix(root).unwrap_or(&path).display().to_string());
            }
        }
    }
    found.sort();
    Ok(found)
}

/// Returns whether a line has the word outside of a comment, and not as part of another word.
fn is_unsafe(line: &str) -> bool {
    let code = line.split("//").next().unwrap_or(line);
    code.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == "unsafe")
}
