//! Instructions of every control tick on a Cortex-M4F, exactly: golden figures in `tests/golden/instructions.toml`.

use crate::firmware::{self, Image};
use crate::steps::{self, Outcome};
use crate::{qemu, vectors};
use narx_core::motor::State;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What the file begins with.
const HEAD: &str = "\
# Instructions on a Cortex-M4F (thumbv7em-none-eabihf, opt-level 3), counted by the emulator: exact, and the same on every run. Wait states of a
# flash and stalls of the pipeline are not in it. Made anew by `cargo xtask generate`, compared by `cargo xtask test firmware`.
#
# vector.NAME    every `Drive::step` of a conformance vector
# state.NAME     every `Drive::step` of all vectors that ends in a state (Table 6 of the specification)
# plant.NAME     every period of the simulated motor and power stage of the virtual drive
";

/// Builds the images and makes the golden file anew; with `check` nothing is written, and any other figure is a failure.
pub fn command(root: &Path, check: bool) -> ExitCode {
    let built = firmware::build(root).and_then(|_| firmware::emulator());
    steps::finish(built.and_then(|_| regenerate(root, check)))
}

/// With the images built, counts everything, prints it, and writes the golden file, or with `check` compares it.
///
/// # Errors
/// The images do not run, or a figure is not the golden one.
pub fn regenerate(root: &Path, check: bool) -> Outcome {
    let rows = rows(root)?;
    let fresh = render(&rows);
    println!("{}", table(&rows));
    let closing = closing(&rows);
    let path = path(root);
    let old = fs::read_to_string(&path).unwrap_or_default();
    if !check {
        fs::write(&path, fresh).map_err(|error| format!("{}: {error}", path.display()))?;
        return Ok(closing);
    }
    let changed = differences(&old, &fresh);
    if changed.is_empty() { Ok(closing) } else { Err(changed) }
}

fn path(root: &Path) -> PathBuf {
    root.join("tests/golden/instructions.toml")
}

/// What was counted of one thing.
struct Row {
    name: String,
    ticks: u64,
    total: u64,
    worst: u64,
}

impl Row {
    /// Reads `KIND NAME TICKS TOTAL WORST`.
    fn parse(line: &str) -> Option<Self> {
        let mut words = line.split_whitespace();
        let (kind, name) = (words.next()?, words.next()?);
        let mut number = || words.next()?.parse().ok();
        let (ticks, total, worst) = (number()?, number()?, number()?);
        let name = match kind {
            "state" => {
                let state = State::ALL.get(name.parse::<usize>().ok()?)?;
                format!("state.{state:?}")
            }
            kind => format!("{kind}.{name}"),
        };
        Some(Self { name, ticks, total, worst })
    }

    fn average(&self) -> f64 {
        self.total as f64 / self.ticks.max(1) as f64
    }
}

fn rows(root: &Path) -> Result<Vec<Row>, String> {
    let files: Vec<String> =
        vectors::recordings(root)?.iter().map(|file| file.display().to_string()).collect();
    let files: Vec<&str> = files.iter().map(String::as_str).collect();
    let mut rows = Vec::new();
    for (image, arguments) in [(Image::Count, files.as_slice()), (Image::Plant, &[])] {
        let mut command = qemu::counting(&image.path(root), arguments);
        let output = command.output().map_err(|error| format!("{}: {error}", qemu::PROGRAM))?;
        let text = String::from_utf8_lossy(&output.stdout);
        if !output.status.success() {
            return Err(format!("{}: {}\n{text}", image.name(), output.status));
        }
        for line in text.lines().filter(|line| !line.starts_with("bracket ")) {
            rows.push(Row::parse(line).ok_or_else(|| format!("{}: {line}", image.name()))?);
        }
    }
    Ok(rows)
}

fn render(rows: &[Row]) -> String {
    let mut text = String::from(HEAD);
    for row in rows {
        let Row { name, ticks, total, worst } = row;
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "\n[{name}]\nticks = {ticks}\ntotal = {total}\naverage = {:.1}\nworst = {worst}\n",
            row.average()
        );
    }
    text
}

fn table(rows: &[Row]) -> String {
    let mut text = format!("{:<28} {:>8} {:>10} {:>9}\n", "instructions", "ticks", "average", "worst");
    for row in rows {
        let _ = writeln!(text, "{:<28} {:>8} {:>10.1} {:>9}", row.name, row.ticks, row.average(), row.worst);
    }
    text
}

/// The figures to quote: hall closed loop, and the worst tick of all.
fn closing(rows: &[Row]) -> Vec<String> {
    let worst =
        rows.iter().filter(|row| row.name.starts_with("vector.")).map(|row| row.worst).max().unwrap_or(0);
    let hall = format!("state.{:?}", State::HallClosedLoop);
    rows.iter()
        .filter(|row| row.name == hall)
        .map(|row| {
            format!(
                "instructions a tick: {:.1} on average in hall closed loop, {worst} at most in any state",
                row.average()
            )
        })
        .collect()
}

/// The lines in which the golden file is another one, each under its heading.
fn differences(old: &str, fresh: &str) -> String {
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
    lines.join("\n")
}
