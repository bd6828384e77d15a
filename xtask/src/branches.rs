//! Branches of the core that no Rust test takes: docs/evidence/branches.json.

use crate::install;
use narx_report::figures;
use narx_report::steps::{self, Outcome};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{fs, io};

/// Arguments of `branches`.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct Arguments {
    /// Folder for branches.json
    #[arg(long, default_value = "docs/evidence")]
    out: PathBuf,
}

/// Program that measures.
const PROGRAM: &str = "cargo-llvm-cov";
/// Version of it for which the figures hold.
const VERSION: &str = "0.9.1";
/// Packages whose tests run.
const PACKAGES: [&str; 2] = ["narx-tests", "narx-boot"];
/// Folder whose branches count.
const CORE: &str = "core/src";

/// The branches of one file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct File {
    /// Outcomes of its conditions: two each.
    pub(crate) branches: u64,
    /// Outcomes that a test takes.
    pub(crate) covered: u64,
}

impl File {
    /// Outcomes that no test takes.
    pub(crate) const fn missed(self) -> u64 {
        self.branches - self.covered
    }
}

/// Branches of every file of the core.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Branches {
    /// Command that measures again.
    pub(crate) command: String,
    /// Commit that was measured.
    pub(crate) commit: String,
    /// Figures by path from `core/src`.
    pub(crate) files: BTreeMap<String, File>,
}

/// Runs the tests of the core and of the bootloader with every branch counted, and writes the branches that
/// they take.
pub(crate) fn command(root: &Path, arguments: &Arguments) -> ExitCode {
    steps::finish(measure(root, &root.join(&arguments.out).join("branches.json")))
}

fn measure(root: &Path, path: &Path) -> Outcome {
    install::nightly(&["rustc", "llvm-tools"])?;
    install::cargo_program(PROGRAM, VERSION)?;
    let export = narx_report::target_directory(root).join("branches.json");
    // Programs of earlier code would be read with today's sources, and have lines that no longer exist.
    steps::run(&mut llvm_cov(root, &["clean", "--workspace"]))?;
    // A report of named packages holds those packages alone, and the core is not among those whose tests
    // run.
    let mut tests = llvm_cov(root, &["--no-report", "--branch"]);
    tests.args(PACKAGES.iter().flat_map(|package| ["-p", package])).arg("--tests");
    steps::run(&mut tests)?;
    let mut report = llvm_cov(root, &["report", "--branch", "--json", "--output-path"]);
    steps::run(report.arg(&export))?;
    let failed = |error: io::Error| format!("{}: {error}", export.display());
    let text = fs::read_to_string(&export).map_err(failed)?;
    let (files, gaps) = read(&text, root).map_err(|reason| format!("{}: {reason}", export.display()))?;
    for Gap { file, line, column, ways } in gaps {
        println!("{CORE}/{file}:{line}:{column}: never {ways}");
    }
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
    // Debug information would fill the disk and is not needed here.
    cargo.env("CARGO_PROFILE_TEST_DEBUG", "0").env("CARGO_PROFILE_DEV_DEBUG", "0");
    // A function that is never called is reported in one codegen unit of its crate alone. Of several units
    // the linker takes only those with a function that is called.
    cargo.env("CARGO_PROFILE_TEST_CODEGEN_UNITS", "1").env("CARGO_PROFILE_DEV_CODEGEN_UNITS", "1");
    cargo
}

/// Fields of `llvm-cov export` that are read.
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
    /// One condition for each copy of the code that the compiler has made.
    branches: Vec<Condition>,
}

/// Line and column, from and to; number of times true, and false; then numbers that are not used.
type Condition = (u32, u32, u32, u32, u64, u64, u64, u64, u64);

/// A condition, and the outcomes that no copy of it has taken.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Gap {
    file: String,
    line: u32,
    column: u32,
    ways: &'static str,
}

/// Returns the files of the core, and every outcome of a condition in them that was not taken. Generic code
/// has a copy for each type that it is compiled for: an outcome that one copy takes is taken. The summary in
/// the export counts differently: it demands more of code with copies, and nothing of code that never ran.
fn read(text: &str, root: &Path) -> Result<(BTreeMap<String, File>, Vec<Gap>), String> {
    let export: Export = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let core = root.join(CORE);
    let (mut files, mut gaps) = (BTreeMap::new(), Vec::new());
    for told in export.data.into_iter().flat_map(|data| data.files) {
        let Ok(path) = told.filename.strip_prefix(&core) else { continue };
        let name = path.to_string_lossy().into_owned();
        let mut conditions: BTreeMap<(u32, u32, u32, u32), [bool; 2]> = BTreeMap::new();
        for (line, column, to_line, to_column, yes, no, ..) in told.branches {
            let taken = conditions.entry((line, column, to_line, to_column)).or_default();
            *taken = [taken[0] | (yes > 0), taken[1] | (no > 0)];
        }
        let covered = conditions.values().flatten().filter(|taken| **taken).count() as u64;
        let file = File { branches: 2 * conditions.len() as u64, covered };
        gaps.extend(conditions.into_iter().filter_map(|((line, column, ..), taken)| {
            let ways = match taken {
                [true, true] => return None,
                [true, false] => "false",
                [false, true] => "true",
                [false, false] => "reached",
            };
            Some(Gap { file: name.clone(), line, column, ways })
        }));
        files.insert(name, file);
    }
    if files.values().all(|file: &File| file.branches == 0) {
        return Err(format!("no branch of {CORE} in it"));
    }
    Ok((files, gaps))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_out_are_those_of_all_copies_together() {
        let condition = |line: u32, yes: u64, no: u64| format!("[{line},9,{line},20,{yes},{no},0,0,4]");
        let file = |name: &str, conditions: &[String]| {
            format!(r#"{{"filename":"{name}","branches":[{}]}}"#, conditions.join(","))
        };
        let text = |files: &[String]| format!(r#"{{"data":[{{"files":[{}]}}],"type":"x"}}"#, files.join(","));
        let root = Path::new("/narx");
        let copies = [
            condition(5, 3, 0),
            condition(7, 0, 0),
            condition(5, 0, 2),
            condition(6, 1, 0),
            condition(6, 4, 0),
        ];
        let all = text(&[
            file("/narx/core/src/motor/control/pi.rs", &copies),
            file("/narx/sim/src/lib.rs", &copies),
        ]);
        let (files, gaps) = read(&all, root).unwrap();
        assert_eq!(
            files,
            BTreeMap::from([("motor/control/pi.rs".to_owned(), File { branches: 6, covered: 3 })])
        );
        assert_eq!(files["motor/control/pi.rs"].missed(), 3);
        let gap = |line, ways| Gap { file: "motor/control/pi.rs".into(), line, column: 9, ways };
        assert_eq!(gaps, [gap(6, "false"), gap(7, "reached")]);
        // A toolchain that counts no branches must not look like one with all branches taken.
        assert!(read(&text(&[file("/narx/core/src/motor/control/pi.rs", &[])]), root).is_err());
        assert!(read("{}", root).is_err());
    }
}
