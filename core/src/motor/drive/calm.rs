//! Ticks in which nothing but the loops has to be looked at.
//!
//! Most ticks of a running motor lie between two edges, or crossings, and two commands. The whole tick before them knows how long that
//! lasts; until then a tick compares what it measures with what would end the calm, and the stations sleep. What they have not seen is
//! told to them when it is over. A calm tick answers what a whole one would, bit for bit.

use super::{Drive, Pattern, place};
use crate::motor::commutation::Step;
use crate::motor::control::Demand;
use crate::motor::hall::HallEvents;
use crate::motor::measurement::Measured;
use crate::motor::protection::Seen;
use crate::motor::pwm::{Commutations, PwmCommand, Rectification};
use crate::motor::samples::Samples;
use crate::motor::state::State;
use serde::{Deserialize, Serialize};

/// What goes on by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Calm {
    /// Of all stations, and of all but the commutator.
    all: Sleep,
    others: u32,
    /// Of the hall sensors, in a drive that has no use for them.
    halls: Sleep,
    /// The hall code that lasts.
    hall: u8,
    step: Step,
    /// Estimated speed in the direction of torque, raw I16F16 electrical rev/s, and what the voltage fades by.
    speed: i32,
    fade: u8,
}

/// So many ticks may pass without a look; so many of them are left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Sleep {
    granted: u32,
    left: u32,
}

impl Sleep {
    const fn new(ticks: u32) -> Self {
        Self { granted: ticks, left: ticks }
    }

    /// How many have passed since it was granted, or asked for last. It goes on.
    const fn take(&mut self) -> u32 {
        let slept = self.granted.wrapping_sub(self.left);
        self.granted = self.left;
        slept
    }
}

impl Calm {
    /// The next tick is a whole one.
    pub(super) const fn end(&mut self) {
        self.all = Sleep { granted: self.all.granted.wrapping_sub(self.all.left), left: 0 };
        self.others = 0;
    }

    /// Ticks that the stations have not been told of.
    #[inline]
    pub(super) const fn slept(&self) -> u32 {
        self.all.granted.wrapping_sub(self.all.left)
    }

    /// Nothing but a commutation is due.
    #[inline]
    pub(super) const fn commutates(&self) -> bool {
        self.all.left == 0
    }

    /// In this tick, too, time alone changes no state.
    pub(super) const fn is_told_to_rest(&self) -> bool {
        self.others > self.all.granted.wrapping_sub(self.all.left)
    }
}

impl Drive {
    /// Nothing that this tick measures asks for a look, and but for a commutation nothing is due. Then the floating terminal's sample has been taken.
    #[inline]
    pub(super) fn is_calm(&mut self, samples: &Samples, measured: &Measured) -> bool {
        let rests = self.calm.all.left > 0 || self.calm.is_told_to_rest();
        let (c, current) = (&self.coefficients.protection, measured.bus_current.to_bits());
        if !rests || !self.protection.stays_calm(c, measured.bus_voltage.to_bits(), current, samples.lines) {
            return false;
        }
        if !self.listens {
            return samples.hall == self.calm.hall && samples.edges.is_empty();
        }
        let (c, torque) = (&self.coefficients.sensorless, self.machine.direction());
        let bus_voltage = measured.bus_voltage.to_bits();
        if !self.sensorless.passes(c, samples, bus_voltage, &self.applied, torque) {
            return false;
        }
        self.sense_halls(samples);
        true
    }

    /// Voltage, current, `speed` (a magnitude, raw I16F16 electrical rev/s) and digital inputs are within all limits, as before.
    #[inline]
    fn is_quiet(&self, samples: &Samples, measured: &Measured, speed: i32) -> bool {
        let seen = Seen {
            bus_voltage: measured.bus_voltage.to_bits(),
            bus_current: measured.bus_current.to_bits(),
            speed,
            lines: samples.lines,
        };
        self.protection.stays_quiet(&self.coefficients.protection, &seen)
    }

    /// A calm tick.
    #[inline]
    pub(super) fn goes_on(&mut self, place: u16, samples: &Samples, measured: &Measured) -> PwmCommand {
        self.calm.all.left -= 1;
        self.open_phase.count(measured.bus_current);
        let Calm { step, speed, fade, .. } = self.calm;
        let demand = Demand::Speed { measured: speed, fade };
        if place <= place::LAST {
            self.rest_of_millisecond(place, demand, samples, measured.bus_current);
        }
        if !self.cruises(demand, step, Commutations::NONE, measured) {
            self.finish(&Pattern::hold(demand, step), measured);
        }
        self.applied
    }

    /// A commutation is due, and nothing else.
    #[inline(never)]
    pub(super) fn commutate(&mut self, measured: &Measured) -> Pattern {
        self.open_phase.count(measured.bus_current);
        self.calm.all.granted = self.calm.all.granted.wrapping_add(1);
        self.tell();
        let Calm { speed, fade, .. } = self.calm;
        let pattern = self.turn_on(Demand::Speed { measured: speed, fade });
        // The estimator expects another crossing now.
        if self.listens {
            self.calm.others = self.calm.others.min(self.estimator_calm());
        }
        self.grant();
        pattern
    }

    /// The hall sensors. In a drive that has no use for them they sleep apart from the other stations.
    #[inline]
    pub(super) fn sense_halls(&mut self, samples: &Samples) -> HallEvents {
        let same = samples.hall == self.calm.hall && samples.edges.is_empty();
        if self.listens && same && self.calm.halls.left > 0 {
            self.calm.halls.left -= 1;
            return HallEvents::default();
        }
        self.attend_halls(samples)
    }

    #[inline(never)]
    fn attend_halls(&mut self, samples: &Samples) -> HallEvents {
        self.rotor.sleep(self.calm.halls.take());
        let events = self.rotor.step(&self.coefficients, samples);
        if self.listens {
            self.calm.hall = samples.hall;
            self.calm.halls = Sleep::new(self.rotor.calm(&self.coefficients));
        }
        events
    }

    /// The hall lines mean something else, or somebody has use for them again.
    pub(super) fn wake_halls(&mut self) {
        self.calm.halls = Sleep::default();
    }

    /// Most looks of a running motor find an edge forward or a crossing, and nothing else: `None` if this one does not.
    #[inline]
    pub(super) fn glance(
        &mut self,
        samples: &Samples,
        measured: &Measured,
        hall: HallEvents,
    ) -> Option<Pattern> {
        if !self.is_quiet(samples, measured, self.speed()) {
            return None;
        }
        let demand = if self.listens {
            let fade = self.sensorless.run_on(&self.coefficients.sensorless)?;
            Demand::Speed { measured: self.sensorless_forward(), fade }
        } else {
            if self.minds(hall) {
                return None;
            }
            self.hall_demand()?
        };
        self.machine.sleep(1);
        self.open_phase.count(measured.bus_current);
        let pattern = self.turn_on(demand);
        self.calm_down(samples, demand);
        Some(pattern)
    }

    /// The pattern at the rotor's place.
    #[inline]
    fn turn_on(&mut self, demand: Demand) -> Pattern {
        let (angle, speed) = self.place();
        let (step, commutations) =
            self.commutator.step(&self.coefficients.commutator, angle, speed, self.machine.direction());
        let pattern = Pattern { demand, step, commutations, short: false };
        self.open_phase.change(pattern.last());
        pattern
    }

    /// Where the rotor is by the running mode: angle and speed, u32 turn and 2^-32 turn a tick.
    #[inline]
    pub(super) fn place(&self) -> (u32, i32) {
        if self.listens {
            let rotor = self.sensorless.rotor();
            (rotor.angle(), rotor.speed())
        } else {
            let position = self.rotor.hall_position();
            (position.angle, position.speed)
        }
    }

    /// The tick of a settled loop, in full: true if nothing came near a limit.
    #[inline]
    pub(super) fn cruises(
        &mut self,
        demand: Demand,
        step: Step,
        commutations: Commutations,
        measured: &Measured,
    ) -> bool {
        if !matches!(demand, Demand::Speed { fade: 0, .. }) {
            return false;
        }
        let mode =
            if self.listens { &self.coefficients.sensorless_mode } else { &self.coefficients.hall_mode };
        let c = &self.coefficients.control;
        let Some(duty) = self.control.cruise(c, mode.duty_max, measured, &self.measurement) else {
            return false;
        };
        let (sample_at, sample_mode) = self.sampling(duty.to_bits());
        self.applied = PwmCommand {
            duty,
            rectification: Rectification::Synchronous,
            sample_at,
            sample_mode,
            step,
            commutations,
        };
        true
    }

    /// What the stations have not seen of a calm is told to them, and it is over.
    pub(super) fn wake(&mut self) {
        self.tell();
        (self.calm.all, self.calm.others) = (Sleep::default(), 0);
    }

    /// What the stations have not seen of a calm is told to them.
    pub(super) fn tell(&mut self) {
        let slept = self.calm.all.take();
        self.calm.others = self.calm.others.saturating_sub(slept);
        if slept > 0 {
            self.machine.sleep(slept);
            if self.listens {
                self.sensorless.sleep(slept);
            }
        }
        let halls = if self.listens { self.calm.halls.take() } else { slept };
        if halls > 0 {
            self.rotor.sleep(halls);
        }
    }

    /// How long nothing but the loops has to be looked at.
    #[inline]
    pub(super) fn calm_down(&mut self, samples: &Samples, demand: Demand) {
        let c = &self.coefficients;
        let Demand::Speed { measured: speed, fade } = demand else { return };
        if !self.protection.is_quiet() {
            return;
        }
        let own = match self.machine.state() {
            State::HallClosedLoop if !self.rotor.hall_stopped(c) && !self.rotor.hall_mute() => {
                self.rotor.calm(c)
            }
            State::OpenLoop | State::SensorlessClosedLoop | State::SensorlessAutoRestart
                if self.sensorless.fault().is_none() =>
            {
                self.estimator_calm()
            }
            _ => return,
        };
        (self.calm.hall, self.calm.speed, self.calm.fade) = (samples.hall, speed, fade);
        self.calm.others = own.min(self.machine.calm(&c.machine));
        self.grant();
    }

    /// Ticks for which the sensorless estimator needs no look.
    fn estimator_calm(&self) -> u32 {
        let (present, torque) = (self.commutator.present(), self.machine.direction());
        self.sensorless.calm(&self.coefficients.sensorless, present, torque)
    }

    /// Calm until the next commutation, but no longer than the others allow.
    fn grant(&mut self) {
        if self.open_phase.is_found(&self.coefficients.open_phase) {
            return self.calm.end();
        }
        let (angle, speed) = self.place();
        self.calm.all = Sleep::new(self.commutator.calm(angle, speed).min(self.calm.others));
        self.calm.step = self.commutator.present();
    }
}
