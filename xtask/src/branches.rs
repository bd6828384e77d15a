//! Branches of the core that no Rust test takes: docs/evidence/branches.json.

use crate::steps::{self, Outcome};
use crate::{figures, install};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{fs, io};

/// Arguments of `branches`.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Where branches.json goes
    #[arg(long, default_value = "docs/evidence")]
    out: PathBuf,
}

/// What measures.
const PROGRAM: &str = "cargo-llvm-cov";
/// The version whose figures these are.
const VERSION: &str = "0.9.1";
/// Whose tests run.
const PACKAGES: [&str; 2] = ["narx-tests", "narx-boot"];
/// What is looked at.
const CORE: &str = "core/src";

/// The branches of one file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct File {
    /// Ways out of its conditions: two each.
    pub branches: u64,
    /// Of these, taken.
    pub covered: u64,
}

impl File {
    /// Not taken.
    pub const fn missed(self) -> u64 {
        self.branches - self.covered
    }
}

/// Every file of the core.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Branches {
    /// What measures again.
    pub command: String,
    /// The code that was measured.
    pub commit: String,
    /// By path from `core/src`.
    pub files: BTreeMap<String, File>,
}

/// Runs the tests of the core and of the bootloader with every branch counted, and writes what they took.
pub fn command(root: &Path, arguments: &Arguments) -> ExitCode {
    steps::finish(measure(root, &root.join(&arguments.out).join("branches.json")))
}

fn measure(root: &Path, path: &Path) -> Outcome {
    install::nightly(&["rustc", "llvm-tools"])?;
    install::cargo_program(PROGRAM, VERSION)?;
    let export = install::target_directory(root).join("branches.json");
    // Whoever names packages for the report gets those alone, and the core is none of those whose tests run.
    let mut tests = llvm_cov(root, &["--no-report", "--branch"]);
    tests.args(PACKAGES.iter().flat_map(|package| ["-p", package])).arg("--tests");
    steps::run(&mut tests)?;
    let mut report = llvm_cov(root, &["report", "--branch", "--json", "--summary-only", "--output-path"]);
    steps::run(report.arg(&export))?;
    let failed = |error: io::Error| format!("{}: {error}", export.display());
    let text = fs::read_to_string(&export).map_err(failed)?;
    let files = read(&text, root).map_err(|reason| format!("{}: {reason}", export.display()))?;
    let sum = |of: fn(&File) -> u64| files.values().map(of).sum::<u64>();
    let (branches, missed) = (sum(|file| file.branches), sum(|file| file.missed()));
    let closing = format!("{branches} branches of {} files, {missed} not taken", files.len());
    let measured = Branches { command: "cargo xtask branches".into(), commit: figures::commit(root), files };
    figures::write(path, &measured)?;
    Ok(vec![closing, format!("written to {}", path.display())])
}

fn llvm_cov(root: &Path, arguments: &[&str]) -> Command {
    let mut cargo = Command::new("cargo");
    cargo.args(["+nightly", "llvm-cov"]).args(arguments).current_dir(root);
    // Debug information would fill the disk and says nothing here.
    cargo.env("CARGO_PROFILE_TEST_DEBUG", "0").env("CARGO_PROFILE_DEV_DEBUG", "0");
    cargo
}

/// What `llvm-cov export` tells of a file, as far as it is read.
#[derive(Deserialize)]
struct Export {
    data: Vec<Data>,
}

#[derive(Deserialize)]
struct Data {
    files: Vec<Told>,
}

#[derive(Deserialize)]
struct Told {
    filename: PathBuf,
    summary: Summary,
}

#[derive(Deserialize)]
struct Summary {
    branches: Count,
}

#[derive(Deserialize)]
struct Count {
    count: u64,
    covered: u64,
}

/// The files of the core.
fn read(text: &str, root: &Path) -> Result<BTreeMap<String, File>, String> {
    let export: Export = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let core = root.join(CORE);
    let files: BTreeMap<String, File> = export
        .data
        .into_iter()
        .flat_map(|data| data.files)
        .filter_map(|told| {
            let path = told.filename.strip_prefix(&core).ok()?.to_string_lossy().into_owned();
            let Count { count, covered } = told.summary.branches;
            Some((path, File { branches: count, covered }))
        })
        .collect();
    if files.values().all(|file| file.branches == 0) {
        return Err(format!("no branch of {CORE} in it"));
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_the_core_are_read_and_no_others() {
        let file = |name: &str, count: u64| {
            let covered = count.min(3);
            let branches = format!(r#""branches":{{"count":{count},"covered":{covered}}}"#);
            format!(r#"{{"filename":"{name}","summary":{{{branches},"lines":{{}}}}}}"#)
        };
        let text = |files: &[String]| format!(r#"{{"data":[{{"files":[{}]}}],"type":"x"}}"#, files.join(","));
        let root = Path::new("/narx");
        let all = text(&[file("/narx/core/src/motor/pi.rs", 4), file("/narx/sim/src/lib.rs", 8)]);
        let files = read(&all, root).unwrap();
        assert_eq!(files, BTreeMap::from([("motor/pi.rs".to_owned(), File { branches: 4, covered: 3 })]));
        assert_eq!(files["motor/pi.rs"].missed(), 1);
        // A toolchain that counts no branches must not look like one whose branches are all taken.
        assert!(read(&text(&[file("/narx/core/src/motor/pi.rs", 0)]), root).is_err());
        assert!(read("{}", root).is_err());
    }
}
