//! Looks for inputs that break a promise: libFuzzer over the targets of `tests/fuzz`, one after the other.

use crate::install::{self, Package, target_directory};
use crate::steps::{self, Step, run_all};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, fs};

/// Of cargo-fuzz.
const VERSION: &str = "0.13.2";
/// libFuzzer is C++.
const COMPILER: Package = Package { name: "g++", provides: "c++" };
/// Longest input, bytes: lives of some hundred steps.
const LENGTH_MAX: u32 = 4096;
/// An input that takes longer is a finding, s.
const TIME_MAX: u32 = 20;

/// What to look at, and for how long.
#[derive(clap::Args)]
pub struct Arguments {
    /// Targets (files of tests/fuzz/fuzz_targets); without a name all of them
    targets: Vec<String>,
    /// For each target
    #[arg(long, default_value_t = 60)]
    seconds: u64,
    /// Run this input of one target again instead
    #[arg(long, requires = "targets")]
    input: Option<PathBuf>,
    /// Give both nodes every identifier with every length as data and remote frame instead: 19 thousand million frames
    #[arg(long, conflicts_with_all = ["targets", "input"])]
    identifiers: bool,
}

/// `cargo xtask fuzz`.
pub fn command(root: &Path, arguments: Arguments) -> ExitCode {
    if arguments.identifiers {
        return run_all(vec![Step::command(root, "identifiers", "cargo", &IDENTIFIERS)]);
    }
    match fuzz(root, &arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::FAILURE
        }
    }
}

const IDENTIFIERS: [&str; 10] = [
    "test",
    "--release",
    "-p",
    "narx-fuzz",
    "--test",
    "identifiers",
    "--",
    "--ignored",
    "--nocapture",
    "--test-threads=1",
];

fn fuzz(root: &Path, arguments: &Arguments) -> Result<(), String> {
    let all = targets(root)?;
    if let Some(unknown) = arguments.targets.iter().find(|name| !all.contains(name)) {
        return Err(format!("no target {unknown:?}; there are {}", all.join(" ")));
    }
    let chosen = if arguments.targets.is_empty() { &all } else { &arguments.targets };
    install::debian(&[COMPILER])?;
    install::nightly(&["rustc"])?;
    install::cargo_program("cargo-fuzz", VERSION)?;
    steps::run(cargo_fuzz(root, "build").args(if let [one] = chosen.as_slice() { Some(one) } else { None }))?;
    if let Some(input) = &arguments.input {
        let input = fs::canonicalize(input).map_err(|error| format!("{}: {error}", input.display()))?;
        return steps::run(cargo_fuzz(root, "run").arg(&chosen[0]).arg(input)).map(drop);
    }
    println!("{:<12} {:>12} {:>10} {:>9} {:>7}", "target", "executions", "a second", "coverage", "corpus");
    let mut findings = Vec::new();
    let mut executions = 0;
    for name in chosen {
        match one(root, name, arguments.seconds) {
            Ok(figures) => {
                let Figures { executed, per_second, coverage, corpus } = figures;
                println!("{name:<12} {executed:>12} {per_second:>10} {coverage:>9} {corpus:>7}");
                executions += executed;
            }
            Err(reason) => {
                println!("{name:<12} {reason}");
                findings.push(name.as_str());
            }
        }
    }
    println!("{:<12} {executions:>12}", "all");
    if findings.is_empty() { Ok(()) } else { Err(format!("findings: {}", findings.join(" "))) }
}

/// The targets that there are, by name.
fn targets(root: &Path) -> Result<Vec<String>, String> {
    let folder = root.join("tests/fuzz/fuzz_targets");
    let files = fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let names = files.flatten().filter_map(|file| Some(file.path().file_stem()?.to_str()?.to_owned()));
    let mut names: Vec<String> = names.collect();
    names.sort();
    Ok(names)
}

/// cargo-fuzz, with optimisation, overflow checks and debug assertions. Without AddressSanitizer: what is looked at forbids unsafe code, and runs twice as often.
fn cargo_fuzz(root: &Path, what: &str) -> Command {
    let mut command = Command::new("cargo");
    command.args(["+nightly", "fuzz", what, "--fuzz-dir", "tests/fuzz", "--features", "libfuzzer"]);
    command.args(["--sanitizer", "none", "--codegen-units", "16", "--target-dir"]);
    command.arg(folder(root, "")).current_dir(root);
    // Fourteen programs are linked, and linking takes longer than it gains. The toolchain is the command line's.
    command.env("CARGO_PROFILE_RELEASE_LTO", "off").env_remove("RUSTUP_TOOLCHAIN");
    command
}

fn folder(root: &Path, what: &str) -> PathBuf {
    let target =
        env::current_dir().map_or_else(|_| target_directory(root), |here| here.join(target_directory(root)));
    target.join("fuzz").join(what)
}

/// What libFuzzer says at its end.
struct Figures {
    executed: u64,
    per_second: u64,
    coverage: String,
    corpus: String,
}

/// Begins with the corpus of the repository and what earlier runs have found.
fn one(root: &Path, name: &str, seconds: u64) -> Result<Figures, String> {
    let (found, artifacts) = (folder(root, "corpus").join(name), folder(root, "artifacts").join(name));
    for folder in [&found, &artifacts] {
        fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    let mut command = cargo_fuzz(root, "run");
    command.arg(name).arg(&found).arg(root.join("tests/fuzz/corpus").join(name)).arg("--");
    command.arg(format!("-max_total_time={seconds}")).arg(format!("-max_len={LENGTH_MAX}"));
    command.arg(format!("-timeout={TIME_MAX}")).arg(format!("-artifact_prefix={}/", artifacts.display()));
    let output = command.arg("-print_final_stats=1").output().map_err(|error| format!("cargo: {error}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    if output.status.success() {
        return figures(&said).ok_or_else(|| format!("no figures in what it said:\n{said}"));
    }
    Err(finding(name, &said))
}

fn figures(said: &str) -> Option<Figures> {
    let stat = |name: &str| said.lines().rev().find_map(|line| line.strip_prefix(name)?.trim().parse().ok());
    let last = said.lines().rev().find(|line| line.starts_with('#') && line.contains("cov: "))?;
    let word = |name: &str| last.split(name).nth(1)?.split_whitespace().next().map(str::to_owned);
    Some(Figures {
        executed: stat("stat::number_of_executed_units:")?,
        per_second: stat("stat::average_exec_per_sec:")?,
        coverage: word("cov: ")?,
        corpus: word("corp: ")?,
    })
}

/// The promise that is broken, the input that breaks it, and how to see it again.
fn finding(name: &str, said: &str) -> String {
    let panic = said.lines().skip_while(|line| !line.contains("panicked at"));
    let broken: Vec<&str> = panic.take_while(|line| *line != "stack backtrace:").collect();
    let written = said.lines().find_map(|line| line.split("Test unit written to ").nth(1));
    match written {
        Some(file) => {
            format!("{}\n  input {file}\n  again cargo xtask fuzz {name} --input {file}", broken.join("\n  "))
        }
        None => format!("it did not run:\n{said}"),
    }
}
