//! Instructions of a simulated tick and of the control tick in it, on this machine: golden figures in
//! `tests/golden/callgrind.toml`.

use crate::driven;
use crate::install::{self, Package};
use narx_report::steps::{self, Outcome};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Number of ticks that are counted.
const TICKS: u32 = 5000;
/// Largest difference from the golden figure, as a share of it. The code is the same wherever the toolchain
/// is, but the system's `memcpy` chooses its instructions by the processor and is about 3 % of a tick; half
/// of that is allowed.
const TOLERANCE: f64 = 0.015;
const HEAD: &str = "\
# Instructions on x86-64 (release profile), counted by callgrind over 5000 ticks at 3000 rpm under rated load: the program is
# sim/examples/driven.rs. Made anew by `cargo xtask callgrind`, compared within 1.5 % by `cargo xtask test rust`: the system's
# memcpy differs between processors.
#
# tick      all of a simulated tick: drive, plant, node, CAN bus
# control   `Drive::step` of it
# plant     motor, power stage and sensors of it
";

/// Counts, and writes the golden file or, with `check`, compares it.
pub(crate) fn command(root: &Path, check: bool) -> ExitCode {
    steps::finish(regenerate(root, check))
}

/// Counts everything and writes the golden file or, with `check`, compares it. If valgrind is missing and
/// cannot be installed, or the processor is not an x86-64, nothing is compared, and the closing line says so.
///
/// # Errors
/// Fails if a figure differs from the golden one.
pub(crate) fn regenerate(root: &Path, check: bool) -> Outcome {
    if !cfg!(target_arch = "x86_64") {
        return Ok(vec!["not compared: the golden figures are of x86-64".into()]);
    }
    if let Err(advice) = install::debian(&[VALGRIND]) {
        return Ok(vec![format!("not compared: {}", advice.replace('\n', "; "))]);
    }
    let mut rows = Vec::new();
    for mode in driven::MODES {
        rows.push(Counts::new(root, mode)?);
    }
    let path = root.join("tests/golden/callgrind.toml");
    if !check {
        fs::write(&path, render(&rows)).map_err(|error| format!("{}: {error}", path.display()))?;
        return Ok(rows.iter().map(Counts::line).collect());
    }
    let golden = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let wrong: Vec<String> = rows.iter().flat_map(|row| row.misses(&golden)).collect();
    if wrong.is_empty() { Ok(rows.iter().map(Counts::line).collect()) } else { Err(wrong.join("\n")) }
}

/// Package of the program that counts.
pub(crate) const VALGRIND: Package = Package { name: "valgrind", provides: "valgrind" };

/// Instructions of a tick.
pub(crate) struct Counts {
    mode: &'static str,
    tick: f64,
    control: f64,
    plant: f64,
}

impl Counts {
    /// Builds the program and counts its instructions.
    pub(crate) fn new(root: &Path, mode: &'static str) -> Result<Self, String> {
        Self::measure(&narx_report::target_directory(root), &driven::build(root)?, mode)
    }

    fn measure(directory: &Path, program: &Path, mode: &'static str) -> Result<Self, String> {
        let profile: PathBuf = directory.join(format!("callgrind.{mode}"));
        let mut valgrind = Command::new("valgrind");
        valgrind.args(["--tool=callgrind", "--toggle-collect=driven::measured*"]);
        valgrind.arg(format!("--callgrind-out-file={}", profile.display()));
        steps::output(valgrind.arg(program).args([mode, &TICKS.to_string()]))?;
        let text = fs::read_to_string(&profile).map_err(|error| format!("{}: {error}", profile.display()))?;
        let each = |count: u64| count as f64 / f64::from(TICKS);
        let tick = total(&text).ok_or("no summary in the profile")?;
        let control = calls(&text, "::drive::Drive::step");
        let plant = calls(&text, "::Plant::sample") + calls(&text, "::Plant::finish_period");
        // A function that was inlined cannot be counted: no figure is better than a wrong one.
        if control == 0 || plant == 0 {
            return Err("the control tick or the plant is not a function of its own in this build".into());
        }
        Ok(Self { mode, tick: each(tick), control: each(control), plant: each(plant) })
    }

    /// Figures with their names.
    pub(crate) fn figures(&self) -> [(&'static str, f64); 3] {
        [("tick", self.tick), ("control", self.control), ("plant", self.plant)]
    }

    fn line(&self) -> String {
        let Self { mode, tick, control, plant } = self;
        format!(
            "{mode}: {tick:.0} instructions a simulated tick, {control:.0} of them control, {plant:.0} plant"
        )
    }

    /// Differences from the golden file.
    fn misses(&self, golden: &str) -> Vec<String> {
        let table: toml::Table = golden.parse().unwrap_or_default();
        let miss = |(name, now): (&str, f64)| {
            let before =
                table.get(self.mode).and_then(|mode| mode.get(name)).and_then(toml::Value::as_integer);
            let before = before.unwrap_or(0) as f64;
            let off = (now - before).abs() > TOLERANCE * before;
            off.then(|| {
                format!("{}.{name}: golden {before:.0}, now {now:.0}: cargo xtask callgrind", self.mode)
            })
        };
        self.figures().into_iter().filter_map(miss).collect()
    }
}

fn render(rows: &[Counts]) -> String {
    let mut text = String::from(HEAD);
    for row in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "\n[{}]", row.mode);
        for (name, figure) in row.figures() {
            let _ = writeln!(text, "{name} = {figure:.0}");
        }
    }
    text
}

/// All instructions of a profile.
fn total(profile: &str) -> Option<u64> {
    profile.lines().find_map(|line| line.strip_prefix("summary: ")?.trim().parse().ok())
}

/// Instructions of all calls of the functions whose name ends with `part`, callees included.
///
/// A call takes three lines: `cfn=(ID) NAME`, with the name only where the number is new; `calls=COUNT
/// TARGET`; and `POSITION INSTRUCTIONS`.
fn calls(profile: &str, part: &str) -> u64 {
    let mut wanted: Vec<&str> = Vec::new();
    let (mut callee, mut next, mut sum) = ("", false, 0);
    for line in profile.lines() {
        if next {
            let cost = line.split_whitespace().next_back().and_then(|word| word.parse::<u64>().ok());
            sum += cost.unwrap_or(0);
            next = false;
        } else if let Some(function) = line.strip_prefix("cfn=").or(line.strip_prefix("fn=")) {
            let (number, name) = function.split_once(' ').unwrap_or((function, ""));
            if name.ends_with(part) {
                wanted.push(number);
            }
            if line.starts_with('c') {
                callee = number;
            }
        } else if line.starts_with("calls=") {
            next = wanted.contains(&callee);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROFILE: &str = "events: Ir\nsummary: 1234\n\nfn=(1) a::measured\ncfn=(2) b::drive::Drive::step\ncalls=10 7\n5 \
                           600\n+1 30\ncfn=(3) c::other\ncalls=1 2\n* 70\nfn=(2)\n9 100\nfn=(3)\ncfn=(2)\ncalls=1 7\n8 40\n";

    #[test]
    fn a_profile_is_summed() {
        assert_eq!(total(PROFILE), Some(1234));
        assert_eq!(calls(PROFILE, "::drive::Drive::step"), 640);
        assert_eq!(calls(PROFILE, "nothing"), 0);
    }

    #[test]
    fn a_figure_beyond_the_tolerance_is_named() {
        let counts = Counts { mode: "hall", tick: 1000.0, control: 100.0, plant: 800.0 };
        assert!(counts.misses("[hall]\ntick = 1000\ncontrol = 100\nplant = 800\n").is_empty());
        let golden = "[hall]\ntick = 980\ncontrol = 99\nplant = 799\n";
        let misses = counts.misses(golden);
        assert_eq!(misses.len(), 1, "{misses:?}");
        assert!(misses[0].starts_with("hall.tick"));
    }
}
