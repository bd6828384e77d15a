//! A commissioned drive on the bench, run tick by tick, with the observations of a test engineer.

use crate::pwm_rate;
use narx_core::commissioning::Commissioning;
use narx_core::master::{Config, Master};
use narx_core::motor::State;
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::commutations::Commutations;
use narx_sim::plant::{Observation, PlantConfig};
use std::f64::consts::TAU;

/// Time from power-up until the drive accepts requests, s: boot (0.5 s) and two of the master's periods.
const BOOT: f64 = 0.6;

/// A run.
pub(crate) struct Trial {
    pub(crate) bench: Bench,
    master: Master,
    seen: Observation,
    /// Largest magnitude of a phase current so far, A.
    pub(crate) peak: f64,
    /// Highest bus voltage so far, V.
    pub(crate) bus_highest: f64,
    commutations: Commutations,
    /// Duration of a control tick, s.
    pub(crate) tick_seconds: f64,
}

impl Trial {
    /// Powers up and waits until the drive accepts requests. `keep` turns trace and recording on.
    pub(crate) fn new(plant: &PlantConfig, commissioning: &Commissioning, label: &str, keep: bool) -> Self {
        let bench = Bench::new(&BenchConfig {
            plant: plant.clone(),
            parameters: commissioning.parameters.clone(),
            label: label.into(),
            trace: keep,
        });
        let bench = if keep { bench } else { bench.without_recording() };
        let addresses = bench.node().addresses();
        let mut master = Master::new(Config { addresses, ..Config::default() });
        master.stop();
        let seen = bench.plant().observe();
        let commutations = Commutations::default();
        let tick_seconds = pwm_rate::tick(&plant.board);
        let mut trial = Self { bench, master, seen, peak: 0.0, bus_highest: 0.0, commutations, tick_seconds };
        trial.run_while(BOOT, |_| true);
        trial
    }

    /// Requests a speed, rpm, negative in reverse.
    pub(crate) fn start(&mut self, rpm: i32) {
        self.master.start(rpm);
    }

    /// Requests motor mode 3.
    pub(crate) fn shut_down(&mut self) {
        self.master.shut_down();
    }

    /// Runs one control tick.
    pub(crate) fn tick(&mut self) {
        while let Some(frame) = self.master.poll_frame(self.bench.now_ns() / 1000) {
            // Two frames every 50 ms do not fill a queue of 64.
            let _ = self.bench.send(frame);
        }
        self.bench.step();
        while self.bench.receive().is_some() {}
        while self.bench.monitor().is_some() {}
        self.seen = self.bench.plant().observe();
        self.peak = self.peak.max(self.seen.peak_current);
        self.bus_highest = self.bus_highest.max(self.seen.bus_voltage);
        self.commutations.watch(&self.bench);
    }

    /// Runs `seconds` of ticks; returns false as soon as `holds` is false.
    pub(crate) fn run_while(&mut self, seconds: f64, holds: impl Fn(&Self) -> bool) -> bool {
        let ticks = (seconds / self.tick_seconds).round() as u32;
        (0..ticks).all(|_| {
            self.tick();
            holds(self)
        })
    }

    /// Returns the seconds until `holds` is true, if that takes at most `most`.
    pub(crate) fn until(&mut self, most: f64, holds: impl Fn(&Self) -> bool) -> Option<f64> {
        let ticks = (most / self.tick_seconds).round() as u32;
        let found = (1..=ticks).find(|_| {
            self.tick();
            holds(self)
        });
        found.map(|ticks| f64::from(ticks) * self.tick_seconds)
    }

    /// Runs `seconds`; returns the mean true speed, rpm.
    pub(crate) fn mean_rpm(&mut self, seconds: f64) -> f64 {
        let from = self.seen;
        self.run_while(seconds, |_| true);
        (self.seen.angle - from.angle) / (self.seen.time - from.time) * 60.0 / TAU
    }

    /// Runs `seconds`; returns the pattern changes.
    pub(crate) fn commutations(&mut self, seconds: f64) -> &Commutations {
        self.commutations.clear();
        self.run_while(seconds, |_| true);
        &self.commutations
    }

    /// State that the drive reports.
    pub(crate) fn state(&self) -> State {
        self.bench.status().state
    }

    /// True values at the end of the last tick.
    pub(crate) const fn seen(&self) -> &Observation {
        &self.seen
    }
}
