//! Exact numbers of instructions of every control tick on a Cortex-M4F: golden figures in
//! `tests/golden/instructions.toml`.

use crate::firmware;
use crate::image::Image;
use crate::programs::LAB;
use crate::{floor, qemu, vectors};
use narx_report::steps::{self, Outcome};
use narx_report::target_directory;
use serde::Deserialize;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// Beginning of the file.
const HEAD: &str = "\
# Instructions on a Cortex-M4F (thumbv7em-none-eabihf, opt-level 3), counted by the emulator: exact, and the same on every run. Wait states of a
# flash and stalls of the pipeline are not in it. Made anew by `cargo xtask generate`, compared by `cargo xtask test firmware`.
#
# Memory on this processor, bytes: of the drive without its coefficients (state), and of these; of the control tick's half, of the queues, of the
# background's half and the node in it; of these three together (device); of storing and logging (storage); of all that (whole). Of a scope, and
# of the samples in it; of a master; of the task that serves the flash. stack_NAME: the most that one call took, of what the vectors ask of a
# drive, and of a device with motor, flash and scope that a master asks for everything (firmware/gauges/stack.rs).
#
# vector.NAME    every `Drive::step` of a conformance vector
# state.NAME     every `Drive::step` of all vectors that ends in a state (Table 6 of the specification)
# running.NAME   every `Drive::step` of a motor that just runs, from 0.2 s after its closed loop began to the end of the run
# scope.NAME     what a virtual scope of eight signals adds to every tick of that motor, waiting for an edge or recording
# inputs.NAME    the same of a scope that records the inputs of every tick; the worst takes a checkpoint
# loaded.NAME    what that scope of signals and a command in every third tick, as many as the bus can carry, add together
# floor.NAME     every call of a bare tick by hand in C, without any of our features (lab/floor/tick.c, -O3), fed with the speed of running.NAME
# plant.NAME     every period of the simulated motor and power stage of the virtual drive
# standby.period everything between two sleeps of a drive in Standby whose master speaks every 50 ms: control interrupt and background
";

/// Builds the images and writes the golden file. With `check` it writes nothing, and fails if a figure
/// differs.
pub(crate) fn command(root: &Path, check: bool) -> Outcome {
    firmware::build(root).and_then(|_| firmware::emulator()).and_then(|_| regenerate(root, check))
}

/// Counts everything with images that are built, prints it, and writes the golden file or, with `check`,
/// compares it.
///
/// # Errors
/// Fails if the images do not run, or a figure differs from the golden one.
pub(crate) fn regenerate(root: &Path, check: bool) -> Outcome {
    let counted = Counted::new(root)?;
    steps::say(table(&counted.rows));
    let (mut closing, path) = (closing(&counted.rows), path(root));
    let old = fs::read_to_string(&path).unwrap_or_default();
    let fresh = counted.render();
    if !check {
        fs::write(&path, fresh).map_err(|error| format!("{}: {error}", path.display()))?;
        return Ok(closing);
    }
    let mut changed = differences(&old, &fresh);
    let compiler = counted.compiler_line();
    if old.lines().any(|line| line.starts_with(COMPILER) && line != compiler) {
        // Another version of the C compiler generates other instructions from the same C; that is not a
        // change of ours.
        changed.retain(|line| !line.starts_with("[floor.") && !line.contains(COMPILER));
        closing.push(format!("floor not compared: the golden figures are not of {}", counted.compiler));
    }
    if changed.is_empty() { Ok(closing) } else { Err(changed.join("\n")) }
}

fn path(root: &Path) -> PathBuf {
    root.join("tests/golden/instructions.toml")
}

/// Counts of one item.
pub(crate) struct Row {
    /// Kind and name, separated by a point.
    pub(crate) name: String,
    ticks: u64,
    total: u64,
    /// Largest count of one tick.
    pub(crate) worst: u64,
}

impl Row {
    /// Reads `KIND NAME TICKS TOTAL WORST`.
    fn parse(line: &str) -> Option<Self> {
        let mut words = line.split_whitespace();
        let (kind, name) = (words.next()?, words.next()?);
        let mut number = || words.next()?.parse().ok();
        let (ticks, total, worst) = (number()?, number()?, number()?);
        Some(Self { name: format!("{kind}.{name}"), ticks, total, worst })
    }

    /// Mean count of a tick.
    pub(crate) fn average(&self) -> f64 {
        self.total as f64 / self.ticks.max(1) as f64
    }
}

/// The demonstration's motor in steady running: recordings that narx-lab makes for counting.
#[derive(Deserialize)]
struct Running {
    paths: Vec<PathBuf>,
    /// Descriptions of the runs: a line for each.
    labels: Vec<String>,
    /// The motor's electrical speed, mHz.
    millihertz: u32,
}

impl Running {
    fn record(root: &Path) -> Result<Self, String> {
        let directory = target_directory(root).join("running");
        LAB.run(root, &["running".as_ref(), directory.as_os_str()])?;
        let path = directory.join("running.json");
        let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
    }
}

/// Key of the C compiler's version in the golden file.
const COMPILER: &str = "floor_compiler";

/// Everything that was counted.
pub(crate) struct Counted {
    /// Rows in the order in which they were counted.
    pub(crate) rows: Vec<Row>,
    /// Names and sizes in bytes.
    pub(crate) memory: Vec<(String, u64)>,
    /// Descriptions of the runs in `running.*`.
    labels: Vec<String>,
    /// Compiler of the floor.
    pub(crate) compiler: String,
}

impl Counted {
    /// Runs images that are built.
    pub(crate) fn new(root: &Path) -> Result<Self, String> {
        let running = Running::record(root)?;
        let compiler = floor::compiler_version()?;
        let mut counted = Self {
            rows: Vec::new(),
            memory: Vec::new(),
            labels: running.labels,
            compiler: format!("gcc {compiler}"),
        };
        let vectors = vectors::recordings(root)?;
        let texts =
            |files: &[PathBuf]| files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>();
        let files: Vec<PathBuf> =
            vectors.iter().cloned().chain(["--running".into()]).chain(running.paths).collect();
        counted.read(&image(root, Image::Count, &texts(&files))?)?;
        counted.read(&image(root, Image::Stack, &texts(&vectors))?)?;
        counted.read(&floor::run(root, running.millihertz)?)?;
        counted.read(&image(root, Image::Plant, &[])?)?;
        counted.read(&image(root, Image::Standby, &[])?)?;
        Ok(counted)
    }

    /// Returns the row of that kind and name.
    pub(crate) fn row(&self, name: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.name == name)
    }

    /// Reads the lines of a program: rows, `bytes NAME NUMBER`, and notes that are only printed.
    fn read(&mut self, text: &str) -> Result<(), String> {
        for line in text.lines().filter(|line| !line.starts_with("bracket ")) {
            let invalid = || format!("not a row: {line}");
            if let Some(note) = line.strip_prefix("# ") {
                steps::say(note);
            } else if let Some(size) = line.strip_prefix("bytes ") {
                let (name, bytes) = size.split_once(' ').ok_or_else(invalid)?;
                self.memory.push((format!("{name}_bytes"), bytes.parse().map_err(|_| invalid())?));
            } else {
                self.rows.push(Row::parse(line).ok_or_else(invalid)?);
            }
        }
        Ok(())
    }

    fn compiler_line(&self) -> String {
        format!("{COMPILER} = \"{}\"", self.compiler)
    }

    fn render(&self) -> String {
        let mut text = String::from(HEAD);
        text.push_str("#\n# What just runs, from power-up:\n");
        // Writing to a string cannot fail.
        for label in &self.labels {
            let _ = writeln!(text, "# {label}");
        }
        text.push('\n');
        for (name, bytes) in &self.memory {
            let _ = writeln!(text, "{name} = {bytes}");
        }
        let _ = writeln!(text, "{}", self.compiler_line());
        for row in &self.rows {
            let Row { name, ticks, total, worst } = row;
            let _ = write!(
                text,
                "\n[{name}]\nticks = {ticks}\ntotal = {total}\naverage = {:.1}\nworst = {worst}\n",
                row.average()
            );
        }
        text
    }
}

/// Runs an image; returns its output.
fn image(root: &Path, image: Image, arguments: &[String]) -> Result<String, String> {
    let mut command = qemu::counting(&image.path(root), arguments);
    let output = command.output().map_err(|error| format!("{}: {error}", qemu::PROGRAM))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        Ok(text)
    } else {
        Err(format!("{}: {}\n{text}", image.name(), output.status))
    }
}

fn table(rows: &[Row]) -> String {
    let mut text = format!("{:<28} {:>8} {:>10} {:>9}\n", "instructions", "ticks", "average", "worst");
    for row in rows {
        let _ = writeln!(text, "{:<28} {:>8} {:>10.1} {:>9}", row.name, row.ticks, row.average(), row.worst);
    }
    text
}

/// Returns the figures to quote: a running motor beside the bare tick, and the worst tick of all.
fn closing(rows: &[Row]) -> Vec<String> {
    let row = |name: String| rows.iter().find(|row| row.name == name);
    let mut lines: Vec<String> = ["hall", "sensorless"]
        .into_iter()
        .filter_map(|mode| {
            let (ours, floor) = (row(format!("running.{mode}"))?, row(format!("floor.{mode}"))?);
            let (ours, floor) = (ours.average(), floor.average());
            let times = ours / floor;
            Some(format!("instructions a tick, {mode}: {ours:.1} on average, {times:.1} times a bare tick in C ({floor:.1})"))
        })
        .collect();
    let worst = rows.iter().filter(|row| row.name.starts_with("vector.")).map(|row| row.worst).max();
    lines.push(format!("{} at most in any state", worst.unwrap_or(0)));
    lines
}

/// Returns the lines in which the golden file differs, each with its heading.
fn differences(old: &str, fresh: &str) -> Vec<String> {
    let entries = |text: &str| -> Vec<(String, String)> {
        let mut heading = String::new();
        let mut entries = Vec::new();
        for line in text.lines() {
            if line.starts_with('[') {
                line.clone_into(&mut heading);
            } else if line.contains(" = ") {
                entries.push((heading.clone(), line.to_owned()));
            }
        }
        entries
    };
    let (old, fresh) = (entries(old), entries(fresh));
    let missing = old
        .iter()
        .filter(|entry| !fresh.contains(entry))
        .map(|(heading, line)| format!("{heading} golden {line}"));
    let new = fresh
        .iter()
        .filter(|entry| !old.contains(entry))
        .map(|(heading, line)| format!("{heading} now {line}"));
    let mut lines: Vec<String> = missing.chain(new).collect();
    lines.sort();
    lines
}
