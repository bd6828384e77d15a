//! Gate signals of one period: the on-time is centred on the period's boundary, dead time delays turning on.

use super::phase::Phase;
use narx_core::motor::{Leg as Role, PwmCommand, Rectification, SampleMode, Step};
use narx_core::units::Duty;

/// Switch of a leg that its gate signals call for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gate {
    /// Both switches off.
    #[default]
    Off,
    /// High side on.
    High,
    /// Low side on.
    Low,
}

impl Gate {
    /// The other switch of the leg.
    #[inline]
    pub(crate) const fn other(self) -> Self {
        match self {
            Self::Off => Self::Off,
            Self::High => Self::Low,
            Self::Low => Self::High,
        }
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Driver {
    /// The switch that was on last.
    last_on: Gate,
    /// Time at which it turned off, s from the start of this period.
    off_since: f64,
    /// Waits for the dead time.
    waiting: bool,
}

/// The modulator and the drivers of three legs.
#[derive(Clone, Debug)]
pub(crate) struct Gates {
    step: Step,
    legs: [Role; 3],
    switched: bool,
    /// The switched leg, where there is just one.
    only_switched: Option<Phase>,
    rectification: Rectification,
    period: f64,
    dead_time: f64,
    /// The on-time ends here and starts again there, s.
    on_until: f64,
    on_from: f64,
    gates: [Gate; 3],
    drivers: [Driver; 3],
    /// Any of them waits.
    waits: bool,
    sample_at: u16,
    sample_mode: SampleMode,
}

impl Gates {
    pub(crate) fn new(period: f64, dead_time: f64) -> Self {
        let mut gates = Self {
            step: Step::Coast,
            legs: Step::Coast.legs(),
            switched: false,
            only_switched: None,
            rectification: Rectification::Diode,
            period,
            dead_time,
            on_until: 0.0,
            on_from: period,
            gates: [Gate::Off; 3],
            drivers: [Driver { off_since: -1.0, ..Driver::default() }; 3],
            waits: false,
            sample_at: 0,
            sample_mode: SampleMode::OffTime,
        };
        gates.set_duty(Duty::ZERO);
        gates
    }

    pub(crate) fn asked(&self) -> [Gate; 3] {
        self.gates
    }

    /// Sampling instant of this period, 1/65 536 of the period.
    pub(crate) fn sample_at(&self) -> u16 {
        self.sample_at
    }

    pub(crate) fn sample_mode(&self) -> SampleMode {
        self.sample_mode
    }

    pub(crate) fn set_step(&mut self, step: Step) {
        self.step = step;
        self.legs = step.legs();
        let mut switched = Phase::ALL.into_iter().filter(|leg| self.legs[*leg] == Role::Switched);
        let first = switched.next();
        self.switched = first.is_some();
        self.only_switched = if switched.next().is_none() { first } else { None };
    }

    /// Legs that the step leaves floating.
    pub(crate) fn floating(&self) -> [bool; 3] {
        self.legs.map(|role| role == Role::Floating)
    }

    pub(crate) fn step(&self) -> Step {
        self.step
    }

    /// At the boundary: what the last command asked for takes effect. Returns when the next gate changes: 0
    /// if one may at once.
    pub(crate) fn latch(&mut self, command: &PwmCommand) -> f64 {
        self.set_duty(command.duty);
        self.rectification = command.rectification;
        self.sample_at = command.sample_at;
        self.sample_mode = command.sample_mode;
        for driver in &mut self.drivers {
            driver.off_since -= self.period;
        }
        let goes_on = match self.only_switched {
            Some(leg) => self.gates[leg] == Gate::High && self.on_until > 0.0,
            None => !self.switched,
        };
        if goes_on && !self.waits { self.next_change(0.0, f64::INFINITY) } else { 0.0 }
    }

    /// If at the edge `t` nothing happens but that one leg changes sides: the leg, the switch that is to turn
    /// on, and when its dead time will be over, s.
    #[inline]
    pub(crate) fn side_change(&self, t: f64) -> Option<(Phase, Gate, f64)> {
        let leg = self.only_switched?;
        if self.waits || self.rectification != Rectification::Synchronous {
            return None;
        }
        let over = t + self.dead_time;
        match self.gates[leg] {
            Gate::High if t == self.on_until && over <= self.on_from => Some((leg, Gate::Low, over)),
            Gate::Low if t == self.on_from => Some((leg, Gate::High, over)),
            _ => None,
        }
    }

    /// `leg` changes sides at `t`, without waiting out its dead time. Returns when the next gate changes.
    #[inline]
    pub(crate) fn change_sides(&mut self, leg: Phase, gate: Gate, t: f64) -> f64 {
        self.drivers[leg].last_on = self.gates[leg];
        self.drivers[leg].off_since = t;
        self.gates[leg] = gate;
        if gate == Gate::Low { self.on_from } else { f64::INFINITY }
    }

    fn set_duty(&mut self, duty: Duty) {
        let half_on = f64::from(duty.to_bits()) * (0.5 / 32_768.0) * self.period;
        self.on_until = half_on;
        self.on_from = if duty == Duty::ONE { half_on } else { self.period - half_on };
    }

    /// Returns the switch that a switched leg's gate signals call for at `t`.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn switched_gate(&self, t: f64) -> Gate {
        if t < self.on_until || t >= self.on_from {
            Gate::High
        } else if self.rectification == Rectification::Synchronous {
            Gate::Low
        } else {
            Gate::Off
        }
    }

    /// The gates from `t` on, s after the start of the period. A `dead` leg stays off.
    #[inline]
    pub(crate) fn at(&mut self, t: f64, dead: &[bool; 3]) -> [Gate; 3] {
        let switched = self.switched_gate(t);
        let wanted = self.legs.map(|role| match role {
            Role::Floating => Gate::Off,
            Role::Low => Gate::Low,
            Role::Switched => switched,
        });
        // Most often all is as it was.
        if wanted != self.gates || self.waits || *dead != [false; 3] {
            self.change(&wanted, t, dead);
        }
        self.gates
    }

    fn change(&mut self, wanted: &[Gate; 3], t: f64, dead: &[bool; 3]) {
        self.waits = false;
        for leg in 0..3 {
            let wanted = if dead[leg] { Gate::Off } else { wanted[leg] };
            let (gate, driver) = (&mut self.gates[leg], &mut self.drivers[leg]);
            driver.waiting = false;
            if wanted == *gate {
                continue;
            }
            if *gate != Gate::Off {
                driver.last_on = *gate;
                driver.off_since = t;
                *gate = Gate::Off;
            }
            let crosses = wanted != driver.last_on && driver.last_on != Gate::Off && wanted != Gate::Off;
            driver.waiting = crosses && t < driver.off_since + self.dead_time;
            self.waits |= driver.waiting;
            if !driver.waiting {
                *gate = wanted;
            }
        }
    }

    /// `leg` turned off at `t`, and waits.
    pub(crate) fn turn_off(&mut self, leg: Phase, t: f64) {
        let driver = &mut self.drivers[leg];
        driver.last_on = core::mem::take(&mut self.gates[leg]);
        driver.off_since = t;
    }

    /// The next instant after `t` at which a gate may change by itself, at most `until`.
    #[inline]
    pub(crate) fn next_change(&self, t: f64, until: f64) -> f64 {
        let edge = if t < self.on_until { self.on_until } else { self.on_from };
        let mut next = if self.switched && edge > t && edge < until { edge } else { until };
        if self.waits {
            for driver in &self.drivers {
                if driver.waiting {
                    next = next.min(driver.off_since + self.dead_time);
                }
            }
        }
        next
    }
}
