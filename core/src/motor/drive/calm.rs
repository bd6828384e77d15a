//! Ticks in which nothing but the loops has to be looked at.
//!
//! Most ticks of a running motor lie between two edges, or crossings, and two commands. The whole tick before them knows how long that
//! lasts; until then a tick compares what it measures with what would end the calm, and the stations sleep. What they have not seen is
//! told to them when it is over. A calm tick answers what a whole one would, bit for bit.

mod turning;

use super::Drive;
use super::pattern::Pattern;
use crate::motor::band::Band;
use crate::motor::commutation::Step;
use crate::motor::control::{Demand, Lane};
use crate::motor::hall::HallEvents;
use crate::motor::measurement::BUS_MIN;
use crate::motor::pwm::{Commutations, PwmCommand, Rectification};
use crate::motor::samples::{Lines, SampleMode, Samples};
use crate::motor::state::State;
use crate::units::Amps;
use serde::{Deserialize, Serialize};

/// A small board has time but no room: there all of these ways are left out. The answers are the same.
pub(super) const SHORTCUTS: bool = cfg!(feature = "shortcuts");
/// A page leaves out the shortest ones.
const SAVES_TIME: bool = SHORTCUTS && cfg!(not(target_arch = "wasm32"));

/// Sleep of the stations, and what must not change while they sleep.
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
    /// For so many ticks from the last that the stations were told of, no row of the state machine's table can hold by time alone; at least.
    #[serde(skip)]
    machine: Known<u32>,
    /// This tick's edge or crossing has been taken before it turned out to be for all stations.
    #[serde(skip)]
    taken: bool,
    /// They follow from the coefficients: a recording is without them.
    #[serde(skip)]
    bounds: Bounds,
    /// Bounds within which the loops need no decision until their next turn.
    #[serde(skip)]
    lane: Known<Lane>,
}

/// What is known of the calm. It follows from the rest of the drive and saves looking: drives that differ in nothing else answer alike, so
/// it takes no part in a comparison, and one that comes out of a recording knows nothing yet.
#[derive(Clone, Copy, Debug, Default)]
struct Known<T>(T);

impl<T> PartialEq for Known<T> {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl<T> Eq for Known<T> {}

/// What a calm tick stays within, made when coefficients or mode change, or a drive comes out of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Bounds {
    lane: Lane,
    /// Digital inputs that end it.
    lines: Lines,
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
        (self.others, self.machine) = (0, Known(0));
    }

    /// Ticks that the stations have not been told of.
    #[inline]
    pub(super) const fn slept(&self) -> u32 {
        self.all.granted.wrapping_sub(self.all.left)
    }

    /// What it keeps asking for.
    #[inline]
    const fn demand(&self) -> Demand {
        Demand::Speed { measured: self.speed, fade: self.fade }
    }

    /// In this tick, too, time alone changes no state.
    #[inline]
    const fn rests(&self) -> bool {
        self.all.left > 0 || self.others > self.slept()
    }
}

impl Drive {
    /// Nothing that this tick measures asks for a look, and but for a commutation nothing is due. Then the floating terminal's sample has been taken.
    #[inline]
    pub(super) fn is_calm(&mut self, samples: &Samples, current: Amps, in_lane: bool) -> bool {
        if !self.calm.rests() || !self.goes_unnoticed(samples, current, in_lane) {
            return false;
        }
        if !self.listens {
            return samples.hall == self.calm.hall && samples.edges.is_empty();
        }
        let (c, torque) = (&self.coefficients.sensorless, self.machine.direction());
        if !self.sensorless.passes(c, samples, self.measurement.bus_voltage(), &self.applied, torque) {
            return false;
        }
        if !self.halls_sleep(samples) {
            self.attend_halls(samples);
        }
        true
    }

    /// The bus voltage is no fault and no limit.
    #[inline]
    pub(super) fn has_plain_voltage(&self) -> bool {
        self.calm.bounds.lane.voltage.contains(self.measurement.bus_voltage())
    }

    /// Voltage and current lie where a settled loop has nothing to do with them.
    #[inline]
    pub(super) fn is_in_lane(&self, current: Amps) -> bool {
        let Lane { voltage, current: currents, .. } = self.calm.lane.0;
        SAVES_TIME && voltage.contains(self.measurement.bus_voltage()) && currents.contains(current.to_bits())
    }

    /// [`stays_within_bounds`](Self::stays_within_bounds), of which a lane is part.
    #[inline]
    fn goes_unnoticed(&self, samples: &Samples, current: Amps, in_lane: bool) -> bool {
        if in_lane {
            !samples.lines.intersects(self.calm.bounds.lines)
        } else {
            self.stays_within_bounds(samples, current)
        }
    }

    /// Voltage, current and digital inputs are no fault.
    #[inline]
    fn stays_within_bounds(&self, samples: &Samples, current: Amps) -> bool {
        let bounds = &self.calm.bounds;
        self.has_plain_voltage()
            && bounds.lane.current.contains(current.to_bits())
            && !samples.lines.intersects(bounds.lines)
    }

    /// Nothing qualifies or waits to clear, and neither these nor `speed` (a magnitude, raw I16F16 electrical rev/s) would change that.
    #[inline]
    pub(super) fn is_quiet(&self, samples: &Samples, current: Amps, speed: i32) -> bool {
        self.protection.stays_quiet(speed) && self.stays_within_bounds(samples, current)
    }

    /// A calm tick: another, or the commutation that is due. The step that it begins with.
    #[inline]
    pub(super) fn go_on(&mut self, current: Amps) -> Step {
        self.open_phase.count(current);
        if self.calm.all.left == 0 {
            return self.commutate();
        }
        self.calm.all.left -= 1;
        self.applied.commutations = Commutations::NONE;
        self.calm.step
    }

    /// The loops of a tick that begins with `step` and has its commutations.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(super) fn keep_on(
        &mut self,
        step: Step,
        place: u32,
        samples: &Samples,
        current: Amps,
        in_lane: bool,
    ) {
        self.do_due(place, Some(self.calm.speed), samples, current);
        // Who left the lane meanwhile has none whose duties it could keep to.
        if in_lane && self.glides(step) {
            return;
        }
        if self.calm.fade > 0 || !self.cruises(step, current) {
            let commutations = self.applied.commutations;
            self.finish(&Pattern { commutations, ..Pattern::hold(self.calm.demand(), step) }, current);
        }
    }

    /// What a calm stays within.
    pub(super) fn settle_calm(&mut self) {
        let c = &self.coefficients;
        let lane = Lane {
            voltage: c.protection.bus_voltage(BUS_MIN + 1, c.control.bus_guard),
            current: c.protection.bus_current(),
            duty: c.control.duties(c.mode(self.machine.state()).duty_max),
        };
        self.calm.bounds = Bounds { lane, lines: c.protection.lines() };
        self.leave_lane();
    }

    /// The hall sensors. In a drive that has no use for them they sleep apart from the other stations.
    #[inline]
    pub(super) fn sense_halls(&mut self, samples: &Samples) -> HallEvents {
        if self.listens && self.halls_sleep(samples) {
            return HallEvents::default();
        }
        self.attend_halls(samples)
    }

    /// Hall sensors that nothing depends on show nothing new.
    #[inline]
    fn halls_sleep(&mut self, samples: &Samples) -> bool {
        let sleeps = samples.hall == self.calm.hall && samples.edges.is_empty() && self.calm.halls.left > 0;
        if sleeps {
            self.calm.halls.left -= 1;
        }
        sleeps
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

    /// Open loop turns its field, whatever the rotor does.
    #[inline]
    pub(super) const fn turns_field(&self) -> bool {
        matches!(self.machine.state(), State::OpenLoop)
            && !self.machine.calibrating()
            && !self.machine.is_sensorless()
    }

    /// Where the rotor is by the running mode: angle and speed, u32 turn and 2^-32 turn a tick.
    #[inline]
    pub(super) fn place(&self) -> (u32, i32) {
        if self.listens {
            let rotor = self.sensorless.rotor();
            (rotor.angle(), rotor.speed())
        } else if self.turns_field() {
            // Its ticks look at everything: nobody asks for the speed.
            (self.rotor.field_angle(), 0)
        } else {
            let position = self.rotor.hall_position();
            (position.angle, position.speed)
        }
    }

    /// The tick of a settled loop with a plain voltage, in full, but for its commutations: true if nothing came near a limit.
    #[inline]
    pub(super) fn cruises(&mut self, step: Step, current: Amps) -> bool {
        let (c, duties) = (&self.coefficients.control, self.calm.bounds.lane.duty);
        let Some(duty) = self.control.cruise(c, duties, current, &self.measurement) else {
            return false;
        };
        let (sample_at, sample_mode) = self.sampling(duty.to_bits());
        let commutations = self.applied.commutations;
        let rectification = Rectification::Synchronous;
        self.applied = PwmCommand { duty, rectification, sample_at, sample_mode, step, commutations };
        if SAVES_TIME && !self.calm.lane.0.duty.contains(duty.to_bits().into()) {
            self.leave_lane();
        }
        true
    }

    /// Once a millisecond: a lane, where there is none.
    #[inline]
    pub(super) fn renew_lane(&mut self) {
        if SAVES_TIME && self.calm.lane.0.voltage.is_empty() {
            self.lay_lane();
        }
    }

    /// Duties that are sampled like the last one, and all else that a settled loop stays within.
    #[inline(never)]
    fn lay_lane(&mut self) {
        let (begins, lasts) = self.on_time;
        let (least, most) = match self.applied.sample_mode {
            SampleMode::OnTime => (lasts.into(), i32::MAX),
            SampleMode::OffTime => (i32::MIN, i32::from(begins) - 1),
        };
        let within = self.calm.bounds.lane;
        let within = Lane { duty: within.duty.within(least, most), ..within };
        let voltage = self.measurement.bus_voltage();
        self.calm.lane.0 = self.control.lane(&self.coefficients.control, &within, voltage);
    }

    /// The same within the lane: what the last tick applied goes on, but for its commutations and this duty.
    #[inline]
    pub(super) fn glides(&mut self, step: Step) -> bool {
        let (c, lane) = (&self.coefficients.control, &self.calm.lane.0);
        let Some(duty) = self.control.glide(c, lane, &self.measurement) else { return false };
        (self.applied.duty, self.applied.step) = (duty, step);
        if self.applied.sample_mode == SampleMode::OffTime {
            self.applied.sample_at = self.after_pulse(duty.to_bits());
        }
        true
    }

    /// The speed loop has had its turn.
    #[inline]
    pub(super) fn keep_lane(&mut self) {
        if SAVES_TIME && !self.control.keeps(&self.calm.lane.0) {
            self.leave_lane();
        }
    }

    /// Something else than the bus voltage may have changed for the loops.
    #[inline]
    pub(super) fn leave_lane(&mut self) {
        if SAVES_TIME {
            (self.calm.lane.0.voltage, self.calm.lane.0.duty) = (Band::EMPTY, Band::EMPTY);
        }
    }

    /// What the stations have not seen of a calm is told to them, and it is over.
    pub(super) fn wake(&mut self) {
        self.tell();
        self.forget_calm();
    }

    fn forget_calm(&mut self) {
        (self.calm.all, self.calm.others, self.calm.machine) = (Sleep::default(), 0, Known(0));
    }

    /// What the stations have not seen of a calm is told to them.
    pub(super) fn tell(&mut self) {
        let slept = self.calm.all.take();
        self.calm.others = self.calm.others.saturating_sub(slept);
        self.calm.machine.0 = self.calm.machine.0.saturating_sub(slept);
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

    /// The master has been heard: it may be silent as long as before. The stations sleep on.
    #[inline]
    pub(super) fn rest_anew(&mut self) {
        if self.calm.machine.0 > 0 {
            self.calm.machine = Known(self.machine.calm_since(&self.coefficients.machine, self.calm.slept()));
        }
    }

    /// How long nothing but the loops has to be looked at.
    #[inline]
    pub(super) fn calm_down(&mut self, samples: &Samples, demand: Demand) {
        let c = &self.coefficients;
        let Demand::Speed { measured: speed, fade } = demand else { return };
        if !SHORTCUTS || !self.protection.is_quiet() {
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
        self.calm.machine = Known(self.machine.calm(&c.machine));
        self.calm.others = own.min(self.calm.machine.0);
        self.grant();
    }

    /// Ticks for which the sensorless estimator needs no look.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
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
