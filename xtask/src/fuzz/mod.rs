//! Search for inputs that break a promise: libFuzzer over the targets of `tests/fuzz`, one after the other;
//! and a run that gives every identifier to both nodes.

pub(crate) mod report;
mod sweep;

use crate::install::{self, Package};
use narx_report::figures;
use narx_report::steps;
use narx_report::target_directory;
use report::{Report, Row, total};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;
use std::{env, fs};

/// Version of cargo-fuzz.
const VERSION: &str = "0.13.2";
/// Package of the C++ compiler, which libFuzzer needs.
const COMPILER: Package = Package { name: "g++", provides: "c++" };
/// Longest input, bytes: some hundred steps of a program.
const LENGTH_MAX: u32 = 4096;
/// Longest time of an input, s; a longer one is a finding.
const TIME_MAX: u32 = 20;

/// Targets to fuzz, and the time for each.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Targets to fuzz (files of tests/fuzz/fuzz_targets); without a name all of them
    targets: Vec<String>,
    /// Time for each target
    #[arg(long, default_value_t = 60)]
    seconds: u64,
    /// Run this input of one target again instead
    #[arg(long, requires = "targets")]
    input: Option<PathBuf>,
    /// Give both nodes every identifier with every length as data and remote frame instead: 19 thousand
    /// million frames
    #[arg(long, conflicts_with_all = ["targets", "input"])]
    identifiers: bool,
    /// Folder for fuzz.json; its figures of other code are replaced, target by target, and those of the same
    /// code are added to
    #[arg(long, default_value = "target")]
    out: PathBuf,
}

/// Runs `cargo xtask fuzz`.
pub(crate) fn command(root: &Path, arguments: Arguments) -> ExitCode {
    let file = arguments.out.join("fuzz.json");
    let done =
        if arguments.identifiers { sweep::identifiers(root, &file) } else { fuzz(root, &arguments, &file) };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::FAILURE
        }
    }
}

fn fuzz(root: &Path, arguments: &Arguments, file: &Path) -> Result<(), String> {
    let all = targets(root)?;
    if let Some(unknown) = arguments.targets.iter().find(|name| !all.contains(name)) {
        return Err(format!("no target {unknown:?}; there are {}", all.join(" ")));
    }
    let chosen = if arguments.targets.is_empty() { &all } else { &arguments.targets };
    install::debian(&[COMPILER])?;
    install::nightly(&["rustc"])?;
    install::cargo_program("cargo-fuzz", VERSION)?;
    // Commit of the code that is built now, whatever is committed meanwhile.
    let commit = report::commit(root)?;
    steps::run(cargo_fuzz(root, "build").args(if let [one] = chosen.as_slice() { Some(one) } else { None }))?;
    if let Some(input) = &arguments.input {
        let input = fs::canonicalize(input).map_err(|error| format!("{}: {error}", input.display()))?;
        return steps::run(cargo_fuzz(root, "run").arg(&chosen[0]).arg(input)).map(drop);
    }
    let mut rows = Vec::new();
    let mut broken = Vec::new();
    println!(
        "{}",
        line(["target", "seconds", "executions", "a second", "coverage", "corpus", "new", "findings"])
    );
    for name in chosen {
        let (row, finding) = one(root, name, arguments.seconds)?;
        let row = Row { commit: commit.clone(), ..row };
        println!("{}", line(cells(&row).each_ref().map(String::as_str)));
        // Each target is written as soon as it has run, beside those that others have written meanwhile: an
        // hour is not lost with one failure.
        let mut report = Report::resume(file)?;
        report.add(row.clone());
        figures::write(file, &report)?;
        broken.extend(finding);
        rows.push(row);
    }
    println!("{}", line(cells(&total(&rows)).each_ref().map(String::as_str)));
    println!("commit {commit}, written to {}", file.display());
    if broken.is_empty() { Ok(()) } else { Err(format!("\n{}", broken.join("\n\n"))) }
}

/// Formats a line of the table.
fn line(cells: [&str; 8]) -> String {
    let [target, seconds, executions, rate, coverage, corpus, new, findings] = cells;
    format!(
        "{target:<12} {seconds:>7} {executions:>12} {rate:>10} {coverage:>9} {corpus:>7} {new:>6} {findings:>9}"
    )
}

fn cells(row: &Row) -> [String; 8] {
    // Coverage and corpus are left out of the sum of all targets: they do not add up.
    let own = |count: u64| if row.coverage == 0 { String::new() } else { count.to_string() };
    [
        row.target.clone(),
        row.seconds.to_string(),
        row.executions.to_string(),
        (row.executions / row.seconds.max(1)).to_string(),
        own(row.coverage),
        own(row.corpus),
        row.new_inputs.to_string(),
        row.findings.len().to_string(),
    ]
}

/// Names of the existing targets.
pub(crate) fn targets(root: &Path) -> Result<Vec<String>, String> {
    let folder = root.join("tests/fuzz/fuzz_targets");
    let files = fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let names = files.flatten().filter_map(|file| Some(file.path().file_stem()?.to_str()?.to_owned()));
    let mut names: Vec<String> = names.collect();
    names.sort();
    Ok(names)
}

/// Returns a call of cargo-fuzz, with optimisation, overflow checks and debug assertions. AddressSanitizer is
/// off: the code under test forbids unsafe code, and runs twice as fast without it.
fn cargo_fuzz(root: &Path, what: &str) -> Command {
    let mut command = Command::new("cargo");
    command.args(["+nightly", "fuzz", what, "--fuzz-dir", "tests/fuzz", "--features", "libfuzzer"]);
    command.args(["--sanitizer", "none", "--codegen-units", "16", "--target-dir"]);
    command.arg(folder(root, "")).current_dir(root);
    // Without link-time optimisation: fourteen programs are linked, which takes longer than it gains. The
    // command line selects the toolchain.
    command.env("CARGO_PROFILE_RELEASE_LTO", "off").env_remove("RUSTUP_TOOLCHAIN");
    command
}

fn folder(root: &Path, what: &str) -> PathBuf {
    let target =
        env::current_dir().map_or_else(|_| target_directory(root), |here| here.join(target_directory(root)));
    target.join("fuzz").join(what)
}

/// Runs one target, beginning with the corpus of the repository and of earlier runs. Returns the figures, and
/// a finding.
fn one(root: &Path, name: &str, seconds: u64) -> Result<(Row, Option<String>), String> {
    let (found, artifacts) = (folder(root, "corpus").join(name), folder(root, "artifacts").join(name));
    for folder in [&found, &artifacts] {
        fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    let mut command = cargo_fuzz(root, "run");
    command.arg(name).arg(&found).arg(root.join("tests/fuzz/corpus").join(name)).arg("--");
    command.arg(format!("-max_total_time={seconds}")).arg(format!("-max_len={LENGTH_MAX}"));
    command.arg(format!("-timeout={TIME_MAX}")).arg(format!("-artifact_prefix={}/", artifacts.display()));
    let begun = Instant::now();
    let output = command.arg("-print_final_stats=1").output().map_err(|error| format!("cargo: {error}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    let did_not_run = || format!("{name} did not run:\n{said}");
    let figures = figures(&said).ok_or_else(did_not_run)?;
    let row = Row { target: name.into(), seconds: begun.elapsed().as_secs(), ..figures };
    if output.status.success() {
        return Ok((row, None));
    }
    let Finding { broken, input } = finding(&said).ok_or_else(did_not_run)?;
    let told = format!("{name}: {broken}\n  input {input}\n  again cargo xtask fuzz {name} --input {input}");
    Ok((Row { findings: vec![broken.lines().skip(1).collect::<Vec<_>>().join(" ")], ..row }, Some(told)))
}

/// Parses the figures that libFuzzer prints at its end, with or without a finding.
fn figures(said: &str) -> Option<Row> {
    let stat = |name: &str| said.lines().rev().find_map(|line| line.strip_prefix(name)?.trim().parse().ok());
    let last = said.lines().rev().find(|line| line.starts_with('#') && line.contains("cov: "))?;
    let word = |name: &str| last.split(name).nth(1)?.split([' ', '/']).next()?.parse().ok();
    Some(Row {
        executions: stat("stat::number_of_executed_units:")?,
        new_inputs: stat("stat::new_units_added:")?,
        coverage: word("cov: ")?,
        corpus: word("corp: ")?,
        ..Row::default()
    })
}

/// An input that breaks a promise.
#[derive(Debug, PartialEq, Eq)]
struct Finding {
    /// Place and kind of the failure.
    broken: String,
    /// File of the input.
    input: String,
}

fn finding(said: &str) -> Option<Finding> {
    let panic = said.lines().skip_while(|line| !line.contains("panicked at"));
    let broken: Vec<&str> = panic.take_while(|line| *line != "stack backtrace:").collect();
    // An input that takes too long, or too much memory, has no panic.
    let what = said.lines().find_map(|line| Some(line.split_once("ERROR: libFuzzer: ")?.1));
    let broken = if broken.is_empty() { format!("libFuzzer:\n{}", what?) } else { broken.join("\n  ") };
    let input = said.lines().find_map(|line| line.split("Test unit written to ").nth(1))?;
    Some(Finding { broken, input: input.into() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Output of libFuzzer, shortened.
    const DONE: &str = "\
INFO: seed corpus: files: 3 min: 8b max: 120b total: 300b rss: 28Mb
#4\tINITED cov: 90 ft: 95 corp: 3/300b exec/s: 0 rss: 28Mb
#700\tNEW    cov: 130 ft: 151 corp: 9/410b lim: 4096 exec/s: 350 rss: 29Mb L: 12/120 MS: 1 EraseBytes-
#1200\tDONE   cov: 131 ft: 152 corp: 10/430b lim: 4096 exec/s: 400 rss: 29Mb
Done 1200 runs in 3 second(s)
stat::number_of_executed_units: 1200
stat::average_exec_per_sec:     400
stat::new_units_added:          7
stat::slowest_unit_time_sec:    0
";
    const PANIC: &str = "\
#4\tINITED cov: 90 ft: 95 corp: 3/300b exec/s: 0 rss: 28Mb

thread '<unnamed>' (7) panicked at tests/fuzz/src/bus.rs:81:9:
assertion `left == right` failed: not the same frame
  left: 1
 right: 0
stack backtrace:
   0: __rustc::rust_begin_unwind
==7== ERROR: libFuzzer: deadly signal
stat::number_of_executed_units: 57
stat::new_units_added:          1
artifact_prefix='./'; Test unit written to ./crash-00
";
    const TIMEOUT: &str = "\
#4\tINITED cov: 90 ft: 95 corp: 3/300b exec/s: 0 rss: 28Mb
==7== ERROR: libFuzzer: timeout after 20 seconds
artifact_prefix='./'; Test unit written to ./timeout-00
stat::number_of_executed_units: 9
stat::new_units_added:          0
";

    #[test]
    fn figures_are_those_of_the_end() {
        let row = |executions, new_inputs, coverage, corpus| Row {
            executions,
            new_inputs,
            coverage,
            corpus,
            ..Row::default()
        };
        assert_eq!(figures(DONE), Some(row(1200, 7, 131, 10)));
        assert_eq!(figures(PANIC), Some(row(57, 1, 90, 3)));
        assert_eq!(figures(TIMEOUT), Some(row(9, 0, 90, 3)));
        assert_eq!(figures("error: could not compile `narx-core`"), None);
    }

    #[test]
    fn a_finding_is_a_broken_promise_and_its_input() {
        assert_eq!(finding(DONE), None);
        let Finding { broken, input } = finding(PANIC).unwrap();
        assert!(broken.contains("bus.rs:81:9:\n  assertion") && broken.ends_with("right: 0"), "{broken}");
        assert_eq!(input, "./crash-00");
        let late =
            Finding { broken: "libFuzzer:\ntimeout after 20 seconds".into(), input: "./timeout-00".into() };
        assert_eq!(finding(TIMEOUT), Some(late));
    }

    #[test]
    fn columns_of_the_table_are_under_each_other() {
        let row = Row { target: "tx_driver".into(), seconds: 210, executions: 1_234_567, ..Row::default() };
        for row in [Row { coverage: 900, corpus: 30, ..row.clone() }, row] {
            assert_eq!(line(cells(&row).each_ref().map(String::as_str)).len(), line([""; 8]).len());
        }
    }
}
