//! The tasks of each millisecond, one a tick. A tick with an edge, a crossing or a commutation leaves its
//! task to a later one.

use super::Drive;
use crate::motor::clock::Instant;
use crate::motor::control::Demand;
use crate::motor::machine::state::State;
use crate::motor::rotor::Source;
use crate::motor::sense::samples::Samples;
use crate::units::{Amps, Duty};
use serde::{Deserialize, Serialize};

/// The tasks of a millisecond in their order; the last one checks the rails and makes the report due.
const RATINGS: u32 = 0;
const RAMPS: u32 = 1;
/// Number of tasks.
const TASKS: u32 = 3;

/// Progress within this millisecond.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Tasks {
    /// The tick of the next task.
    due: Instant,
    next: u32,
    /// The first tick of the next millisecond, and the part of a tick by which the millisecond is longer,
    /// 1/256.
    end: Instant,
    rest: u8,
    /// Speed of a closed loop as the speed loop has seen it last, a magnitude in the direction of torque, raw
    /// I16F16 electrical rev/s.
    speed: i32,
}

impl Tasks {
    #[inline]
    pub(super) const fn are_due(&self, now: Instant) -> bool {
        self.due.is_due(now)
    }
}

impl Drive {
    /// Does the next task. A `busy` tick leaves it to a later one while the millisecond has more ticks than
    /// tasks.
    #[inline(never)]
    pub(super) fn do_task(&mut self, busy: bool, samples: &Samples, current: Amps) {
        let (now, next) = (self.now, self.tasks.next);
        self.tasks.due = now.next();
        if next == RATINGS {
            let ticks = u32::from(self.coefficients.control.ticks_per_ms) >> 8;
            if ticks < TASKS {
                return self.do_all(ticks, samples, current);
            }
        }
        // The first round after power-up has no end yet, so a second one follows at once; nothing turns then,
        // and no tick is busy.
        let ticks_left = self.tasks.end.since(now);
        if busy && ticks_left > TASKS - next {
            return;
        }
        self.tasks.next = next + 1;
        match next {
            RATINGS => self.update_ratings(current),
            RAMPS => self.run_ramps(current),
            _ => {
                let Tasks { end, rest, speed, .. } = self.tasks;
                let ticks = u32::from(self.coefficients.control.ticks_per_ms) + u32::from(rest);
                self.tasks =
                    Tasks { due: end, next: RATINGS, end: end.after(ticks >> 8), rest: ticks as u8, speed };
                self.check_rails();
                self.make_due(samples);
            }
        }
    }

    /// Does all tasks in one tick, on a board whose millisecond has fewer ticks than tasks.
    #[inline(never)]
    fn do_all(&mut self, ticks: u32, samples: &Samples, current: Amps) {
        self.tasks.due = self.now.after(ticks);
        self.update_ratings(current);
        self.run_ramps(current);
        self.check_rails();
        self.make_due(samples);
    }

    #[inline(never)]
    fn update_ratings(&mut self, current: Amps) {
        if matches!(self.machine.state(), State::Initialization | State::Standby) {
            self.measurement.find_zero(&self.coefficients.measurement, current);
        }
        if self.detects_open_phases()
            && self.open_phase.rest(self.applied.step, self.applied.duty, self.rotor.may_stand())
        {
            self.watch_next();
        }
        let stands = matches!(self.pattern.demand, Demand::Speed(_)) && self.tasks.speed == 0;
        let temperature = self.slow.temperature;
        self.control.update_ratings(&self.coefficients.control, &self.measurement, temperature, !stands);
    }

    /// The speed loop of a closed loop, or the level and the field of a start.
    #[inline(never)]
    fn run_ramps(&mut self, current: Amps) {
        if let Demand::Speed(_) = self.pattern.demand {
            return self.run_speed_loop(current);
        }
        let (c, torque, run) = (&self.coefficients, self.machine.direction(), !self.machine.reversing());
        let mut changed = self.rotor.advance(c, self.now, torque, run);
        if self.machine.state() == State::RotorLock && self.machine.calibrating() {
            changed |= self.lock.advance(c.machine.lock_level, c.machine.lock_rate);
        }
        if changed {
            self.choose_next();
        }
    }

    #[inline(never)]
    fn run_speed_loop(&mut self, current: Amps) {
        let speed = self.speed_forward();
        self.tasks.speed = speed;
        let c = &self.coefficients;
        let mode = c.mode(self.machine.state());
        // A rotor that is found late, or has leapt ahead, comes to the ramp of open loop at twice its rate.
        let rises = self.machine.state() == State::OpenLoop && !self.rotor.sensorless.is_caught();
        let (wanted, rate) = if rises {
            let ticks = self.machine.age(self.now).min(u32::MAX >> 8);
            let milliseconds = (ticks << 8) / u32::from(c.control.ticks_per_ms.max(1));
            (c.open_loop.setpoint(milliseconds), c.open_loop.rate.saturating_mul(2))
        } else {
            let commanded = self.machine.command().speed.to_bits();
            (commanded.min(mode.speed_max).max(mode.speed_min), c.control.speed_rate)
        };
        let target = if self.machine.reversing() { 0 } else { wanted };
        self.control.run_speed_loop(&c.control, mode, (target, rate), speed, (&self.measurement, current));
    }

    #[inline(never)]
    fn check_rails(&mut self) {
        if self.rotor.source() != Source::Terminals {
            return;
        }
        let c = &self.coefficients;
        let driven = self.control.output().duty != Duty::ZERO;
        let applied = self.control.applied(&c.control, self.measurement.bus_voltage());
        let current = self.control.phase_current();
        let speed = self.tasks.speed;
        self.rotor.sensorless.check(&c.sensorless, self.now, driven, applied, current, speed);
        // The check may have ended the episode.
        if !self.rotor.sensorless.is_running() {
            self.watch_next();
            self.choose_next();
        }
    }
}
