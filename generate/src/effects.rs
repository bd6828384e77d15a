//! Disables the effect of each row of the specification in turn, runs the tests that the coverage table names
//! for the row, and records which of them fail: `tests/effects.toml`, from which `tests/coverage.md` is made.
//!
//! The tests are built once with the feature `blind` (`core/src/blind.rs`); an environment variable selects
//! the effect. A row therefore takes only the time of its tests.

use crate::coverage::{self, Effect, Record};
use narx_report::steps::{self, Outcome};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Environment variable that `core/src/blind.rs` reads.
const VARIABLE: &str = "NARX_BLIND";
/// Longest time of a test. A test that takes longer waits for an event that no longer comes.
const LONGEST: Duration = Duration::from_secs(60);

/// Selection of effects.
#[derive(clap::Args)]
pub struct Arguments {
    /// Effects to disable, named as in tests/effects.toml ("parameter 13"), or a whole table of them
    /// ("transition"); without a name all
    effects: Vec<String>,
    /// Run every test of these suites, not only those that name the row
    #[arg(long, value_name = "SUITE")]
    every: Vec<String>,
    /// Write nothing; fail if an effect is not noticed by the tests that tests/effects.toml has for it
    #[arg(long)]
    check: bool,
}

/// Runs `cargo xtask effects`.
pub fn command(root: &Path, arguments: &Arguments) -> ExitCode {
    steps::finish(take_out(root, arguments))
}

/// An effect with the tests that may notice it.
struct Task {
    effect: Effect,
    what: String,
    tests: Vec<String>,
}

fn take_out(root: &Path, arguments: &Arguments) -> Outcome {
    let suites = Suite::build(root)?;
    let start = Instant::now();
    let mut record = Record::read(root)?;
    let all = coverage::effects(root)?;
    let known: BTreeSet<Effect> = all.iter().map(|(effect, ..)| effect.clone()).collect();
    let chosen = |effect: &Effect| {
        let name = effect.to_string();
        let table = name.split(' ').next().unwrap_or_default();
        arguments.effects.is_empty() || arguments.effects.iter().any(|asked| *asked == name || asked == table)
    };
    let every: Vec<String> = suites
        .iter()
        .filter(|suite| arguments.every.contains(&suite.name))
        .flat_map(|suite| suite.tests.keys().map(|test| format!("{}::{test}", suite.name)))
        .collect();
    let mut tasks = Vec::new();
    for (effect, what, mut tests) in all {
        if !chosen(&effect) {
            continue;
        }
        if arguments.check {
            tests = record.of(&effect).into_iter().flatten().cloned().collect();
        }
        tests.extend(every.iter().cloned());
        tasks.push(Task { effect, what, tests });
    }
    let failed = without_any(&suites, &tasks)?;
    if !failed.is_empty() {
        return Err(format!("these fail with every effect in place: {}", failed.join(", ")));
    }
    let found = each(&suites, &tasks)?;
    let mut unnoticed = Vec::new();
    for (task, noticed) in tasks.iter().zip(found) {
        if noticed.is_empty() {
            unnoticed.push(format!("not noticed: {}, {}", task.effect, task.what));
        }
        let before = if arguments.every.is_empty() { None } else { record.of(&task.effect) };
        let noticed = noticed.into_iter().chain(before.into_iter().flatten().cloned()).collect();
        record.set(&task.effect, noticed);
    }
    if !arguments.check {
        record.keep_only(&known);
        record.write(root)?;
    }
    let (count, seconds) = (tasks.len(), start.elapsed().as_secs());
    let summary = format!("{} of {count} effects noticed, in {seconds} s", count - unnoticed.len());
    if unnoticed.is_empty() {
        Ok(vec![summary])
    } else {
        unnoticed.push(summary);
        Err(unnoticed.join("\n"))
    }
}

/// Returns the tests that fail although nothing is disabled.
fn without_any(suites: &[Suite], tasks: &[Task]) -> Result<Vec<String>, String> {
    let tests: BTreeSet<String> = tasks.iter().flat_map(|task| task.tests.iter().cloned()).collect();
    let tests: Vec<String> = tests.into_iter().collect();
    let mut failed = BTreeSet::new();
    for suite in suites {
        failed.append(&mut suite.failing(
            None,
            &tests,
            thread::available_parallelism().map_or(1, usize::from),
        )?);
    }
    Ok(failed.into_iter().collect())
}

/// Returns the tests that notice each effect; runs as many effects at a time as the machine has processors.
fn each(suites: &[Suite], tasks: &[Task]) -> Result<Vec<BTreeSet<String>>, String> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(vec![Ok(BTreeSet::new()); tasks.len()]);
    let work = || {
        while let Some((place, task)) = {
            let place = next.fetch_add(1, Ordering::Relaxed);
            tasks.get(place).map(|task| (place, task))
        } {
            let start = Instant::now();
            let noticed = notice(suites, task);
            if let Ok(noticed) = &noticed {
                let (effect, seconds) = (&task.effect, start.elapsed().as_secs_f64());
                println!(
                    "{effect:<18} {:>3} of {:<3} {seconds:>6.1} s  {}",
                    noticed.len(),
                    task.tests.len(),
                    task.what
                );
            }
            if let Ok(mut results) = results.lock() {
                results[place] = noticed;
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
    results.into_inner().map_err(|error| error.to_string())?.into_iter().collect()
}

fn notice(suites: &[Suite], task: &Task) -> Result<BTreeSet<String>, String> {
    let mut noticed = BTreeSet::new();
    for suite in suites {
        noticed.append(&mut suite.failing(Some(&task.effect), &task.tests, 1)?);
    }
    Ok(noticed)
}

/// A test program.
struct Suite {
    name: String,
    program: PathBuf,
    folder: PathBuf,
    /// Full names of its tests, by the last part of the name.
    tests: BTreeMap<String, Vec<String>>,
}

impl Suite {
    fn build(root: &Path) -> Result<Vec<Self>, String> {
        let mut cargo = Command::new("cargo");
        cargo.args(["test", "--package", "narx-tests", "--features", "blind", "--tests", "--no-run"]);
        cargo.arg("--message-format=json-render-diagnostics").current_dir(root).stderr(Stdio::inherit());
        let output = cargo.output().map_err(|error| format!("cargo: {error}"))?;
        if !output.status.success() {
            return Err("the tests do not build with the feature blind".into());
        }
        let text = String::from_utf8_lossy(&output.stdout);
        let messages = text.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
        let mut suites = Vec::new();
        for message in messages.filter(|message| message["target"]["kind"][0] == "test") {
            if let (Some(name), Some(program)) =
                (message["target"]["name"].as_str(), message["executable"].as_str())
            {
                suites.push(Self::list(name, program.into(), root.join("tests"))?);
            }
        }
        Ok(suites)
    }

    fn list(name: &str, program: PathBuf, folder: PathBuf) -> Result<Self, String> {
        let output =
            Command::new(&program).args(["--list", "--format", "terse"]).current_dir(&folder).output();
        let output = output.map_err(|error| format!("{}: {error}", program.display()))?;
        let mut tests: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for line in String::from_utf8_lossy(&output.stdout).lines() {
            let Some(test) = line.strip_suffix(": test") else { continue };
            let short = test.rsplit("::").next().unwrap_or(test);
            tests.entry(short.to_owned()).or_default().push(test.to_owned());
        }
        Ok(Self { name: name.to_owned(), program, folder, tests })
    }

    /// Returns those of the tests `suite::name` that belong to this suite and fail without the effect. A test
    /// that does not end counts as failed.
    fn failing(
        &self,
        effect: Option<&Effect>,
        tests: &[String],
        threads: usize,
    ) -> Result<BTreeSet<String>, String> {
        let own = tests.iter().filter_map(|test| test.strip_prefix(&self.name)?.strip_prefix("::"));
        let mut left: BTreeSet<String> =
            own.filter_map(|test| self.tests.get(test)).flatten().cloned().collect();
        let mut failed = BTreeSet::new();
        while !left.is_empty() {
            let before = left.len();
            let hangs = self.run(effect, &mut left, &mut failed, threads)?;
            if let Some(test) = hangs {
                left.remove(&test);
                failed.insert(test);
            } else if left.len() == before {
                return Err(format!("{}: {left:?} did not run", self.name));
            }
        }
        let short = |test: &String| format!("{}::{}", self.name, test.rsplit("::").next().unwrap_or(test));
        Ok(failed.iter().map(short).collect())
    }

    /// Runs the tests that are left. Removes from `left` those that have ended; returns one that has not
    /// ended.
    fn run(
        &self,
        effect: Option<&Effect>,
        left: &mut BTreeSet<String>,
        failed: &mut BTreeSet<String>,
        threads: usize,
    ) -> Result<Option<String>, String> {
        let mut command = Command::new(&self.program);
        command
            .args(["--exact", &format!("--test-threads={threads}")])
            .args(left.iter())
            .current_dir(&self.folder);
        // Tests that fail on purpose must not leave files behind.
        command.env("PROPTEST_DISABLE_FAILURE_PERSISTENCE", "1").env("PROPTEST_MAX_SHRINK_ITERS", "0");
        command
            .env("INSTA_UPDATE", "no")
            .env("RUST_BACKTRACE", "0")
            .env_remove("UPDATE")
            .env_remove(VARIABLE);
        if let Some(effect) = effect {
            command.env(VARIABLE, effect.to_string());
        }
        let failure = |error| format!("{}: {error}", self.program.display());
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().map_err(failure)?;
        let output = child.stdout.take().ok_or("no output")?;
        let (told, received) = std::sync::mpsc::channel();
        let reader = thread::spawn(move || {
            let mut output = BufReader::new(output);
            let mut line = Vec::new();
            // The name of a test is printed before the end of its line.
            while output.by_ref().take(1).read_to_end(&mut line).is_ok_and(|count| count == 1) {
                if line.ends_with(b" ... ") || line.ends_with(b"\n") {
                    if told.send(String::from_utf8_lossy(&line).trim_end().to_owned()).is_err() {
                        return;
                    }
                    if line.ends_with(b"\n") {
                        line.clear();
                    }
                }
                if output.fill_buf().is_ok_and(<[u8]>::is_empty) {
                    return;
                }
            }
        });
        let limit = if effect.is_some() { LONGEST } else { LONGEST * 10 };
        let mut running = None;
        let mut hangs = None;
        loop {
            match received.recv_timeout(limit) {
                Ok(line) => {
                    let Some((test, verdict)) =
                        line.strip_prefix("test ").and_then(|rest| rest.split_once(" ..."))
                    else {
                        continue;
                    };
                    // The line of a test that should panic has this after the name.
                    let test = test.split(" - ").next().unwrap_or(test);
                    match verdict.trim() {
                        "" => running = Some(test.to_owned()),
                        "ok" | "ignored" => drop(left.remove(test)),
                        _ => {
                            left.remove(test);
                            failed.insert(test.to_owned());
                        }
                    }
                }
                Err(std::sync::mpsc::RecvTimeoutError::Timeout) => {
                    hangs = running.or_else(|| left.first().cloned());
                    let _ = child.kill();
                    break;
                }
                Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => break,
            }
        }
        let _ = child.wait();
        let _ = reader.join();
        Ok(hangs)
    }
}
