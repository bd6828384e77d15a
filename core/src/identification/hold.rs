//! The rotor held with direct current in two phases at rising levels, each let go: resistance and inductance.

use super::channel::Channel;
use super::script::Action;
use super::winding::{self, Lock, OFF_TIME, ON_TIME};
use super::{CONTINUOUS, HEAT, Identification, IdentificationError, MARGIN};
use crate::dictionary::number;
use crate::master::Master;
use crate::motor::signal::Signal;
use libm::{fmax, fmin, sqrt};

/// The strongest level takes this share of the largest current.
const STRONG: f64 = 0.85;
/// The bus stays this much below the voltage at which the drive trips, V.
const BELOW_TRIP: f64 = 0.3;
/// The strongest level is held again while the charge that shows L is less sure than this.
const DOUBT: f64 = 0.06;
/// Duty of the first level, and the largest.
pub(super) const FIRST_DUTY: f64 = 0.01;
const LARGEST_DUTY: f64 = 0.6;
/// A rotor that is held has come to rest after this time, microseconds: the first time, and where it already
/// lies in the field.
const REST: [u64; 2] = [350_000, 120_000];
/// Rows of a lock's record after the stop.
const AFTER: u16 = 200;
/// Signals of a rotor that is held, in the order of their bits.
const HELD: [Signal; 3] = [Signal::BusVoltage, Signal::Duty, Signal::PeriodCurrent];

impl Identification {
    /// Open loop with a field that stands: direct current through two phases, as a duty of the bus.
    pub(super) fn prepare_holds(&mut self) -> Result<(), IdentificationError> {
        let current = self.asked.current.unwrap_or(CONTINUOUS);
        for (number, value) in [
            (number::HALL_ENABLE, 0.0),
            (number::SENSORLESS_ENABLE, 0.0),
            (number::OPEN_LOOP_ENABLE, 1.0),
            (number::NOMINAL_SUPPLY, 0.0),
            (number::OPEN_LOOP_SPEED, 0.0),
            (number::OPEN_LOOP_RAMP, 0.1),
            (number::DUTY_MAX_SL, 95.0),
            // Every period has its pulse: nothing is sampled within it.
            (number::ON_TIME_MIN, 0.0),
            (number::PHASE_CURRENT_MAX, current),
        ] {
            self.set(number, value)?;
        }
        Ok(())
    }

    /// Rows of a lock's record from before the stop.
    fn held_rows(&self) -> u16 {
        (self.found.room / 3).min(800) - AFTER
    }

    /// Holds the rotor at a level, records it, and lets it go.
    pub(super) fn hold(&mut self, duty: f64) -> Result<(), IdentificationError> {
        let rest = REST[usize::from(self.level > 0.0)];
        self.level = duty;
        self.set(number::LOCK_DUTY, 100.0 * duty)?;
        self.set(number::OPEN_LOOP_DUTY, 100.0 * duty)?;
        let before = self.held_rows();
        let filled = (f64::from(before) * self.found.period * 1e6) as u64 + MARGIN;
        self.script.add(&[
            Action::Start(0),
            Action::Wait(rest),
            Action::arm(&HELD, before + AFTER, 1, before),
            Action::Wait(filled),
            Action::Stop,
            Action::AwaitRecord,
            Action::Download(u32::from(before + AFTER) * 3),
        ]);
        self.script.record.begin(&HELD, self.found.period);
        Ok(())
    }

    /// A lock is recorded: the next level, or R and L.
    pub(super) fn held(&mut self, master: &mut Master) -> Result<(), IdentificationError> {
        let Some(lock) = Lock::of(&self.script.record, self.held_rows().into(), self.level) else {
            return self.stronger();
        };
        if self.locks.is_empty() {
            self.found.supply = lock.voltage;
        }
        // Against the noise of the mean over the record.
        if lock.current <= 5.0 * lock.noise / sqrt(f64::from(self.held_rows())) {
            return self.stronger();
        }
        // Current of the phases as far as it is known without the dead time.
        let phase = lock.current / lock.duty;
        let power = lock.voltage * lock.current;
        let limit = self.asked.current.unwrap_or(CONTINUOUS);
        // The energy that a level returns to the bus grows with its square.
        let square = |volts: f64| volts * volts;
        let rise = fmax(square(lock.raised) - square(lock.voltage), square(0.02) * lock.voltage);
        let left = fmax(square(self.found.bus_max - BELOW_TRIP) - square(lock.voltage), 0.0);
        let heat = if self.asked.current.is_none() { HEAT / power } else { f64::INFINITY };
        let room = fmin(limit / phase, sqrt(fmin(heat, left / rise)));
        if self.locks.push(lock).is_err() {
            return Err(IdentificationError::Unsteady(self.stage));
        }
        let duty = lock.level;
        let next = level(duty * fmin(STRONG * room, 3.0));
        if next > 1.15 * duty {
            return self.hold(next);
        }
        if self.locks.len() < 3 {
            return self.hold(level(0.6 * duty));
        }
        if winding::doubt(&self.locks) > DOUBT && !self.locks.is_full() {
            return self.hold(duty);
        }
        self.winding(master, fmin(limit, phase / STRONG))
    }

    /// A level has failed because so little current flows that the drive takes a phase for open: a higher
    /// one.
    pub(super) fn hold_again(&mut self, master: &mut Master) {
        self.retries = true;
        self.script.give_up(master);
        self.script.record.begin(&HELD, 1.0);
    }

    /// No current was seen: the next level.
    fn stronger(&mut self) -> Result<(), IdentificationError> {
        if self.level >= 0.99 * LARGEST_DUTY {
            return Err(IdentificationError::NoMotor { duty: self.level });
        }
        self.hold(level(2.0 * self.level))
    }

    /// R and L are there.
    fn winding(&mut self, master: &mut Master, current: f64) -> Result<(), IdentificationError> {
        self.found.channel = Channel::of(&mut self.locks);
        let locks = &self.locks;
        let (low, high) = locks
            .iter()
            .fold((f64::MAX, 0.0), |(low, high), lock| (fmin(low, lock.voltage), fmax(high, lock.voltage)));
        if low < 0.85 * high {
            return Err(IdentificationError::Sags { from: high, to: low });
        }
        let winding =
            winding::solve(locks, self.found.period).ok_or(IdentificationError::Unsteady(self.stage))?;
        if winding.resistance <= self.asked.bridge {
            return Err(IdentificationError::Short { resistance: winding.resistance });
        }
        (self.found.winding, self.found.current) = (Some(winding), current);
        if !self.asked.turn {
            self.conclude(master);
            return Ok(());
        }
        if self.found.pole_pairs == 0 { self.count() } else { self.first_spin() }
    }
}

/// The largest level up to this duty at which it is known when the drive reads the current.
fn level(duty: f64) -> f64 {
    if (OFF_TIME..ON_TIME).contains(&duty) { OFF_TIME } else { fmin(duty, LARGEST_DUTY) }
}
