//! Worlds: a drive under many simultaneous faults, for any simulated time.
//!
//! A world is a number. From it follow a motor, its load and supply, an operator who makes mistakes, broken
//! cables and sensors, a disturbed bus and power cuts; in every fourth world a second drive on the bus. The
//! invariants are checked in every tick. The same
//! number gives the same world on every machine.

mod mishap;
mod neighbour;
mod never;
mod peace;
mod total;
mod windows;
mod world;

pub use mishap::{KINDS, Kind};
pub use never::{Broken, NEVER, Never};
pub use total::{Counts, Total};
pub use windows::{Window, long, windows};
pub use world::{Story, run};

use narx_host::parallel::{for_each, threads};
use narx_report::figures;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `worlds`.
#[derive(Clone, Debug, clap::Args)]
pub struct Arguments {
    /// Total simulated time, hours
    #[arg(long, default_value_t = 1.0)]
    hours: f64,
    /// First world
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// Run this world alone, and print every event
    #[arg(long)]
    world: Option<u64>,
    /// Folder for worlds.json; without it nothing is written
    #[arg(long)]
    out: Option<PathBuf>,
    /// Go on from the worlds that worlds.json has, with the same code
    #[arg(long, requires = "out", conflicts_with_all = ["first", "world"])]
    resume: bool,
}

/// Runs worlds until their simulated time adds up; fails if an invariant was broken.
pub fn command(root: &Path, arguments: &Arguments) -> ExitCode {
    if let Some(seed) = arguments.world {
        let story = run(seed, true);
        println!("{story}");
        return if story.broken.is_none() { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    }
    let path = arguments.out.as_ref().map(|out| root.join(out).join("worlds.json"));
    let mut total = Total::new(String::new(), figures::commit(root), arguments.first);
    if let Some(path) = path.as_ref().filter(|_| arguments.resume) {
        match resumed(path, &total.commit) {
            Ok(before) => total = before,
            Err(reason) => {
                eprintln!("{reason}");
                return ExitCode::FAILURE;
            }
        }
    }
    let mut written = Ok(());
    let total = live(arguments.hours, total, |total| {
        if let Some(path) = &path {
            written = figures::write(path, total);
        }
    });
    println!("{total}");
    if let Err(reason) = written {
        eprintln!("{reason}");
        return ExitCode::FAILURE;
    }
    if total.failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The sum that a former run has left, of the same code.
fn resumed(path: &Path, commit: &str) -> Result<Total, String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let total: Total = serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    if total.commit == commit {
        return Ok(total);
    }
    Err(format!("{}: its worlds ran at commit {}, this is {commit}", path.display(), total.commit))
}

/// Runs worlds until their hours are full. They end in any order and are added in the order of their numbers,
/// so that the sum is the same on every machine. `keep` gets the sum after every simulated hour, so that a
/// run that is stopped early leaves a result, and at the end.
fn live(hours: f64, mut total: Total, mut keep: impl FnMut(&Total)) -> Total {
    let first = total.first;
    let command =
        |hours: f64| format!("cargo xtask worlds --hours {hours} --first {first} --out docs/evidence");
    total.command = command(hours);
    // A world lasts about half a minute, so this is more than enough; the last ones are never begun.
    let worlds = (hours * 3600.0 / 20.0).ceil() as u64;
    let seeds: Vec<u64> = (first + total.worlds..first + worlds).collect();
    let mut ended: BTreeMap<usize, Story> = BTreeMap::new();
    let mut next = 0;
    for_each(
        &seeds,
        threads(),
        |seed, _| run(*seed, false),
        |finished| {
            ended.extend(finished);
            while total.hours < hours
                && let Some(story) = ended.remove(&next)
            {
                if story.broken.is_some() {
                    println!("{story}\n  commit {}", total.commit);
                }
                let hour = total.hours.floor();
                total.add(&story);
                next += 1;
                if total.hours.floor() > hour {
                    // The command that repeats the worlds so far.
                    total.command = command(total.hours.floor());
                    keep(&total);
                }
            }
            total.hours < hours
        },
    );
    total.command = command(hours);
    keep(&total);
    total
}
