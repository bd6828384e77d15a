//! Branches of the core: `cargo xtask branches`.

use super::{FIGURES, Section, cell, read};
use crate::branches::{Branches, File};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

const COMMAND: &str = "cargo xtask branches";

const HEAD: &str = "\
Every condition of the core has two ways out. These are the ways that the Rust tests of the public surfaces take (`narx-tests` and `narx-boot`; the tests of the other targets, worlds and fuzzing come on top and are not in it). Of generic code, what one of its copies takes is taken; what only the compiler runs is not. What is not taken is explained in `docs/evidence/gaps.toml`, file by file, or it is *open*.

";

/// Reasons by file of the core: why it has branches that no test takes.
type Why = BTreeMap<String, String>;

/// Section with a line for each folder of the core, then the gaps.
pub(super) fn section(root: &Path) -> Result<Section, String> {
    let text = match read::<Branches>(root, "branches.json")? {
        Some(branches) => {
            let path = root.join(FIGURES).join("gaps.toml");
            let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
            let why = toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
            table(&branches, &why)?
        }
        None => format!("Not measured: `{COMMAND}`.\n"),
    };
    Ok(Section { title: "Branches of the core", text })
}

fn table(branches: &Branches, why: &Why) -> Result<String, String> {
    let missed = |name: &str| branches.files.get(name).is_some_and(|file| file.missed() > 0);
    if let Some(name) = why.keys().find(|name| !missed(name)) {
        return Err(format!("{name:?} is explained in {FIGURES}/gaps.toml but misses no branch"));
    }
    let mut rooms: BTreeMap<&str, (u64, File)> = BTreeMap::new();
    let mut all = File::default();
    for (name, file) in &branches.files {
        let (files, sum) = rooms.entry(room(name)).or_default();
        *files += 1;
        for sum in [sum, &mut all] {
            sum.branches += file.branches;
            sum.covered += file.covered;
        }
    }
    let mut text = String::from(HEAD);
    // Writing to a string cannot fail.
    let _ = writeln!(text, "`{}`, at commit {}:\n", branches.command, branches.commit);
    let _ = writeln!(text, "| room of `core/src` | files | branches | taken | |\n|---|---:|---:|---:|---:|");
    for (name, (files, sum)) in rooms {
        row(&mut text, &format!("`{name}`"), files, sum);
    }
    row(&mut text, "all", branches.files.len() as u64, all);
    let gaps = branches.files.iter().filter(|(_, file)| file.missed() > 0);
    let (closed, open): (Vec<_>, Vec<_>) = gaps.partition(|(name, _)| why.contains_key(*name));
    let _ = writeln!(text, "\n| file | not taken | of | why |\n|---|---:|---:|---|");
    for (name, file) in closed.into_iter().chain(open) {
        let why = why.get(name).map_or("*open*", String::as_str);
        let _ = writeln!(text, "| `{name}` | {} | {} | {} |", file.missed(), file.branches, cell(why));
    }
    Ok(text)
}

fn row(text: &mut String, name: &str, files: u64, File { branches, covered }: File) {
    // A folder without conditions has no branch to miss.
    let share = if branches == 0 { 100.0 } else { 100.0 * covered as f64 / branches as f64 };
    // Writing to a string cannot fail.
    let _ = writeln!(text, "| {name} | {files} | {branches} | {covered} | {share:.1} % |");
}

/// Folder below `core/src` to which a file belongs: `motor.rs` beside `motor/` belongs to that folder.
fn room(name: &str) -> &str {
    name.split('/').next().unwrap_or(name).trim_end_matches(".rs")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rooms_add_up_and_every_gap_is_explained_or_open() {
        let files = [("motor/control/pi.rs", 4, 4), ("motor/ramp.rs", 6, 5), ("units.rs", 2, 0)];
        let files = files.map(|(name, branches, covered)| (name.to_owned(), File { branches, covered }));
        let branches = Branches { command: COMMAND.into(), commit: "c".into(), files: files.into() };
        let why = |name: &str| Why::from([(name.to_owned(), "const".to_owned())]);
        let text = table(&branches, &why("units.rs")).unwrap();
        for line in [
            "| `motor` | 2 | 10 | 9 | 90.0 % |",
            "| `units` | 1 | 2 | 0 | 0.0 % |",
            "| all | 3 | 12 | 9 | 75.0 % |",
            "| `units.rs` | 2 | 2 | const |",
            "| `motor/ramp.rs` | 1 | 6 | *open* |",
        ] {
            assert!(text.lines().any(|found| found == line), "no {line} in\n{text}");
        }
        assert!(!text.contains("| `motor/control/pi.rs`"), "{text}");
        assert!(table(&branches, &why("motor/control/pi.rs")).unwrap_err().contains("misses no branch"));
    }
}
