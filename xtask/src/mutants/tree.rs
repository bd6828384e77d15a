//! A copy of the working copy in which mutants are written. It is kept, so that its build stays valid.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{fs, io};

/// Makes `copy` equal to the working copy at `root`. Files that are equal are not written: cargo compares
/// their times.
///
/// # Errors
/// Fails with git's message, or with the file that cannot be written.
pub(super) fn refresh(root: &Path, copy: &Path) -> Result<(), String> {
    let wanted = files(root)?;
    for file in &wanted {
        let (from, to) = (root.join(file), copy.join(file));
        copy_one(&from, &to).map_err(|error| format!("{}: {error}", to.display()))?;
    }
    remove_others(copy, copy, &wanted).map_err(|error| format!("{}: {error}", copy.display()))
}

/// Files that git tracks or would add: no build products.
fn files(root: &Path) -> Result<BTreeSet<PathBuf>, String> {
    let mut git = Command::new("git");
    git.args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"]).current_dir(root);
    let output = git.output().map_err(|error| format!("git: {error}"))?;
    if !output.status.success() {
        return Err(format!("git: {}", String::from_utf8_lossy(&output.stderr)));
    }
    let names = String::from_utf8_lossy(&output.stdout);
    let names = names.split('\0').filter(|name| !name.is_empty()).map(PathBuf::from);
    Ok(names.filter(|name| root.join(name).is_file()).collect())
}

fn copy_one(from: &Path, to: &Path) -> io::Result<()> {
    let content = fs::read(from)?;
    if fs::read(to).is_ok_and(|old| old == content) {
        return Ok(());
    }
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::write(to, content)
}

fn remove_others(folder: &Path, copy: &Path, wanted: &BTreeSet<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            remove_others(&path, copy, wanted)?;
        } else if path.strip_prefix(copy).is_ok_and(|name| !wanted.contains(name)) {
            fs::remove_file(path)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A refreshed copy has lost the changes of a mutant or a failed test, and equal files keep their time.
    #[test]
    fn a_copy_is_made_the_same_again() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/mutants");
        let copy = std::env::temp_dir().join(format!("narx-mutants-{}", std::process::id()));
        refresh(&root, &copy).unwrap();
        let time = || fs::metadata(copy.join("tree.rs")).unwrap().modified().unwrap();
        let before = time();
        fs::write(copy.join("areas.rs"), "mutant").unwrap();
        fs::write(copy.join("left.txt"), "").unwrap();
        refresh(&root, &copy).unwrap();
        assert_eq!(fs::read(copy.join("areas.rs")).unwrap(), fs::read(root.join("areas.rs")).unwrap());
        assert!(!copy.join("left.txt").exists());
        assert_eq!(time(), before);
        fs::remove_dir_all(copy).unwrap();
    }
}
