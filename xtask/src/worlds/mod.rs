//! Worlds: a drive among everything that goes wrong at once, for as long as somebody likes to wait.
//!
//! A world is a number. From it follow a motor, its load and supply, an operator who makes mistakes, broken cables and sensors, a disturbed
//! bus and cut power; and what may never happen is checked in every tick. The same number is the same world on every machine.

mod mishap;
mod never;
mod peace;
mod windows;
mod world;

pub use mishap::{KINDS, Kind};
pub use never::Broken;
pub use windows::{Window, long, windows};
pub use world::{Story, run};

use narx_core::motor::State;
use narx_host::parallel::{for_each, threads};
use std::collections::BTreeMap;
use std::process::ExitCode;

/// What `worlds` is asked for.
#[derive(Clone, Debug, clap::Args)]
pub struct Arguments {
    /// Simulated hours in all
    #[arg(long, default_value_t = 1.0)]
    hours: f64,
    /// The first world
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// This world alone, told event by event
    #[arg(long)]
    world: Option<u64>,
}

/// Runs worlds until their simulated time adds up; fails if something happened that may not.
pub fn command(arguments: &Arguments) -> ExitCode {
    if let Some(seed) = arguments.world {
        let story = run(seed, true);
        println!("{story}");
        return if story.broken.is_none() { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    }
    // Worlds last about half a minute: enough of them, and the last are not begun.
    let worlds = (arguments.hours * 3600.0 / 20.0).ceil() as u64;
    let seeds: Vec<u64> = (arguments.first..arguments.first + worlds).collect();
    let mut total = Total::default();
    for_each(
        &seeds,
        threads(),
        |seed, _| run(*seed, false),
        |finished| {
            if let Some((_, story)) = finished {
                if story.broken.is_some() {
                    println!("{story}");
                }
                total.add(&story);
            }
            total.seconds < arguments.hours * 3600.0
        },
    );
    println!("{total}");
    if total.broken == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// What many worlds come to.
#[derive(Default)]
struct Total {
    worlds: u64,
    broken: u64,
    unable: u64,
    seconds: f64,
    boots: u64,
    frames: u64,
    mishaps: BTreeMap<&'static str, u64>,
    states: [u64; 8],
    faults: u32,
}

impl Total {
    fn add(&mut self, story: &Story) {
        self.worlds += 1;
        self.broken += u64::from(story.broken.is_some());
        self.unable += u64::from(story.unable);
        self.seconds += story.seconds;
        self.boots += story.boots;
        self.frames += story.frames;
        self.faults |= story.faults;
        for (kind, count) in story.mishaps.iter().enumerate() {
            *self.mishaps.entry(KINDS[kind].name()).or_default() += count;
        }
        for (all, ticks) in self.states.iter_mut().zip(story.states) {
            *all += ticks;
        }
    }
}

impl std::fmt::Display for Total {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { worlds, broken, unable, seconds, boots, frames, .. } = self;
        writeln!(
            f,
            "{worlds} worlds, {:.2} simulated hours, {boots} boots, {frames} frames",
            seconds / 3600.0
        )?;
        let states = State::ALL.iter().zip(self.states);
        let shares = states.map(|(state, ticks)| format!("{} {:.0} s", state.name(), ticks as f64 * 1e-4));
        writeln!(f, "states: {}", shares.collect::<Vec<_>>().join(", "))?;
        writeln!(f, "fault bits seen: {:#010x}", self.faults)?;
        let kinds = self.mishaps.iter().map(|(name, count)| format!("{name} {count}"));
        writeln!(f, "mishaps: {}", kinds.collect::<Vec<_>>().join(", "))?;
        writeln!(
            f,
            "{unable} worlds whose motor does not start in a drive to which nothing has happened either"
        )?;
        write!(f, "{broken} worlds in which something happened that may not")
    }
}
