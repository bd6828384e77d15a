//! How fast the bench is from Python, beside the Rust bench and beside what else simulates motors there (`python/benches/speed.py`), all in the same run.

use super::report::Row;
use crate::{driven, install, steps};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs of each, in turns: a machine with other work only ever makes a run slower, so the fastest counts.
const ROUNDS: usize = 5;
/// Measured ticks of a run of the Rust bench.
const TICKS: &str = "40000";
/// Goal: share of the Rust bench's rate, neither of them keeping anything.
const RATIO_MIN: f64 = 0.9;
/// Others, as the script names them; each runs once in a round, but the slow ones once in all.
const OTHERS: [(&str, usize); 3] = [("numba", ROUNDS), ("motulator", 1), ("gym-electric-motor", 1)];

/// The rate in hall and sensorless mode, then the others'.
pub(super) fn rows(_: &[u64]) -> Vec<Row> {
    let root = super::root();
    match prepare(root) {
        Ok(programs) => measure(&programs),
        Err(reason) => vec![Row {
            promise: "simulation from Python",
            goal: ">= 0.9 of the Rust bench",
            measured: "not measured".into(),
            met: false,
            figures: Vec::new(),
            failures: vec![reason],
        }],
    }
}

struct Programs {
    /// The Rust bench.
    driven: PathBuf,
    python: PathBuf,
    script: PathBuf,
}

/// Builds what is measured, the package in an environment of its own.
fn prepare(root: &Path) -> Result<Programs, String> {
    let driven = driven::build(root)?;
    let (target, benches) = (install::target_directory(root), root.join("python/benches"));
    let python =
        install::python_environment(&target.join("python-benches"), &benches.join("requirements.txt"))?;
    let mut pip = Command::new(&python);
    pip.args(["-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps"]).arg(root.join("python"));
    steps::run(pip.env("CARGO_TARGET_DIR", &target))?;
    Ok(Programs { driven, python, script: benches.join("speed.py") })
}

/// The fastest of several runs: its rate, and what the program says of itself.
#[derive(Default)]
struct Best {
    rate: f64,
    what: String,
    failure: Option<String>,
}

impl Best {
    fn keep(&mut self, command: &mut Command) {
        match run(command) {
            Ok((rate, _)) if rate <= self.rate => {}
            Ok((rate, what)) => (self.rate, self.what) = (rate, what),
            Err(reason) => self.failure = Some(reason),
        }
    }
}

/// The first number that a program prints, and what follows.
fn run(command: &mut Command) -> Result<(f64, String), String> {
    let text = driven::output(command)?;
    let (first, what) = text.trim().split_once(' ').unwrap_or((text.trim(), ""));
    let rate = first.parse().map_err(|_| format!("no figure in: {text}"))?;
    Ok((rate, what.to_owned()))
}

fn measure(programs: &Programs) -> Vec<Row> {
    let script = |contender: &str| {
        let mut command = Command::new(&programs.python);
        command.arg(&programs.script).arg(contender).env("PYTHONDONTWRITEBYTECODE", "1");
        command
    };
    let [mut rust, mut bare, mut kept] = [(); 3].map(|()| driven::MODES.map(|_| Best::default()));
    let mut others = OTHERS.map(|_| Best::default());
    for round in 0..ROUNDS {
        for (index, mode) in driven::MODES.into_iter().enumerate() {
            rust[index].keep(Command::new(&programs.driven).args([mode, TICKS]));
            bare[index].keep(&mut script(mode));
            kept[index].keep(&mut script(&format!("{mode}-kept")));
        }
        for (best, (name, rounds)) in others.iter_mut().zip(OTHERS) {
            if round < rounds {
                best.keep(&mut script(name));
            }
        }
    }
    let own = ["simulation from Python, hall sensors", "simulation from Python, sensorless"];
    let own = own.into_iter().enumerate().map(|(mode, promise)| {
        let ([rust, bare, kept], names) = ([&rust[mode], &bare[mode], &kept[mode]], RATES[mode]);
        let share = |rate: f64| rate / rust.rate;
        Row {
            promise,
            goal: ">= 0.9 of the Rust bench",
            measured: format!(
                "{:.1} simulated seconds a second, {:.2} of the Rust bench's {:.1}; {:.1} ({:.2}) with trace and recording kept",
                bare.rate,
                share(bare.rate),
                rust.rate,
                kept.rate,
                share(kept.rate)
            ),
            met: share(bare.rate) >= RATIO_MIN,
            figures: [bare.rate, share(bare.rate), kept.rate].into_iter().zip(names).map(|(figure, name)| (name, figure)).collect(),
            failures: [rust, bare, kept].into_iter().filter_map(|best| best.failure.clone()).collect(),
        }
    });
    let narx = bare[0].rate;
    let others = others.into_iter().zip(COMPARED).map(|(best, promise)| Row {
        promise,
        goal: "for comparison",
        measured: match &best.failure {
            // What cannot be installed is no fault of ours, but it is said.
            Some(_) if best.rate == 0.0 => "not measured".into(),
            _ => format!(
                "{} simulated seconds a second, {} of narx's in Python; {}",
                short(best.rate),
                short(best.rate / narx),
                best.what
            ),
        },
        met: true,
        figures: vec![("rate", best.rate)],
        failures: best.failure.into_iter().collect(),
    });
    own.chain(others).collect()
}

const RATES: [[&str; 3]; 2] = [
    ["hall rate", "hall ratio", "hall rate kept"],
    ["sensorless rate", "sensorless ratio", "sensorless rate kept"],
];
const COMPARED: [&str; 3] = ["a loop in numba", "motulator", "gym-electric-motor"];

/// With three digits or so.
fn short(value: f64) -> String {
    if value >= 1.0 { format!("{value:.1}") } else { format!("{value:.4}") }
}
