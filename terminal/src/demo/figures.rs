//! Figures that a run reached.

use super::START;
use super::settings::Settings;
use narx_core::commissioning::Mode;
use narx_core::motor::State;
use narx_sim::bench::Bench;
use narx_sim::commutations::Commutations;
use narx_sim::plant::{Ledger, Observation};
use std::f64::consts::TAU;
use std::fmt;

/// An observation from which the measurement begins.
pub(super) struct Mark(Observation);

impl Mark {
    pub(super) fn new(bench: &Bench) -> Self {
        Self(bench.plant().observe())
    }
}

/// Figures of a run for a test engineer.
pub(super) struct Figures {
    target: f64,
    state: State,
    /// Time from the Drive request to closed loop, s.
    closed: Option<f64>,
    /// Standard deviation of the commutations' true positions over the last quarter, share of a step; none in
    /// open loop.
    jitter: Option<f64>,
    /// Time from the Drive request to 90 % of the set-point, s.
    rise: Option<f64>,
    /// Overshoot, share of the set-point.
    overshoot: f64,
    /// Mean speed over the last quarter, rpm.
    mean: f64,
    /// Difference of highest and lowest speed over the last quarter, share of the set-point.
    ripple: f64,
    peak_current: f64,
    bus: (f64, f64),
    steady: Option<Steady>,
}

/// Mean powers over the last quarter, W.
struct Steady {
    input: f64,
    losses: f64,
    load: f64,
}

impl Figures {
    pub(super) fn new(
        settings: &Settings,
        bench: &Bench,
        mark: Option<Mark>,
        closed: Option<f64>,
        commutations: &Commutations,
    ) -> Self {
        let trace = bench.trace();
        let column =
            |name: &str| -> Vec<f64> { trace.column(name).map_or(Vec::new(), |c| c.iter().collect()) };
        let (time, speed, voltage) = (column("time"), column("speed"), column("bus_voltage"));
        let target = f64::from(settings.rpm);
        let along: Vec<f64> = speed.iter().map(|speed| speed * target.signum()).collect();
        let reached = along.iter().position(|speed| *speed >= 0.9 * target.abs());
        let highest = along.iter().copied().fold(0.0, f64::max);
        let from = time.partition_point(|time| *time < settings.steady_start());
        let (low, high) = extent(&along[from.min(along.len())..]);
        let peak = column("peak_current").into_iter().fold(0.0, f64::max);
        let now = bench.plant().observe();
        let mean = mark
            .as_ref()
            .map_or(0.0, |Mark(then)| (now.angle - then.angle) / (now.time - then.time) * 60.0 / TAU);
        Self {
            target,
            closed: closed.map(|time| time - START),
            jitter: Some(commutations.mean_and_jitter().1),
            state: bench.status().state,
            rise: reached.map(|row| time[row] - START),
            overshoot: highest / target.abs() - 1.0,
            mean,
            ripple: (high - low) / target.abs(),
            peak_current: peak,
            bus: extent(&voltage),
            steady: mark.map(|Mark(then)| Steady::between(&then, &now)),
        }
        .for_mode(settings.mode)
    }

    /// Removes figures that do not apply: in open loop the rotor swings about the field, and overshoot, rise
    /// and jitter are not the controller's.
    fn for_mode(self, mode: Mode) -> Self {
        if mode == Mode::OpenLoop { Self { rise: None, jitter: None, ..self } } else { self }
    }

    /// Returns whether the motor still runs at the end.
    pub(super) const fn running(&self) -> bool {
        self.state.is_driving()
    }

    fn error(&self) -> f64 {
        self.mean / self.target - 1.0
    }
}

impl Steady {
    fn between(then: &Observation, now: &Observation) -> Self {
        let time = now.time - then.time;
        let power = |of: fn(&Ledger) -> f64| (of(&now.ledger) - of(&then.ledger)) / time;
        Self {
            input: power(|ledger| ledger.source - ledger.source_loss),
            losses: power(|ledger| ledger.switches + ledger.diodes),
            load: power(|ledger| ledger.load),
        }
    }
}

fn extent(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(*value), high.max(*value)))
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(closed) = self.closed {
            writeln!(f, "closed loop    {closed:8.3} s      after the Drive request")?;
        }
        if let Some(rise) = self.rise {
            writeln!(f, "rise time      {rise:8.3} s      Drive request to 90 % of {:.0} rpm", self.target)?;
            writeln!(f, "overshoot      {:8.2} %", 100.0 * self.overshoot.max(0.0))?;
        }
        writeln!(f, "mean speed     {:8.1} rpm    over the last quarter", self.mean)?;
        let verdict = if self.error().abs() <= 0.005 { "" } else { "      set-point not held" };
        writeln!(f, "steady error   {:8.3} %{verdict}", 100.0 * self.error())?;
        writeln!(f, "speed ripple   {:8.2} %      peak to peak", 100.0 * self.ripple)?;
        if let Some(jitter) = self.jitter {
            writeln!(f, "jitter         {:8.2} %      of the commutations, rms, of a step", 100.0 * jitter)?;
        }
        writeln!(f, "phase current  {:8.2} A      peak, 12 A allowed", self.peak_current)?;
        write!(f, "bus voltage    {:8.2} V      lowest, {:.2} V highest", self.bus.0, self.bus.1)?;
        let Some(steady) = &self.steady else { return Ok(()) };
        write!(f, "\ninput power    {:8.2} W", steady.input)?;
        if steady.load > 0.0 && steady.input > 0.0 {
            let stage = 100.0 * (1.0 - steady.losses / steady.input);
            write!(f, "\nefficiency     {:8.1} %      power stage", stage)?;
            write!(
                f,
                "\n               {:8.1} %      supply to load, motor included",
                100.0 * steady.load / steady.input
            )?;
        }
        Ok(())
    }
}
