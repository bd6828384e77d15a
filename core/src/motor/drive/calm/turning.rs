//! The short ways of a tick in which a motor that just runs turns on: a commutation, a hall edge, a crossing. What the other stations have not seen
//! of the calm before they are not told then either, where that makes no difference.

use super::{SAVES_TIME, Sleep};
use crate::motor::commutation::Step;
use crate::motor::drive::Drive;
use crate::motor::pwm::Commutations;
use crate::motor::samples::Samples;
use crate::units::Amps;

impl Drive {
    /// A commutation is due, and nothing else: the stations sleep on.
    #[inline(never)]
    pub(super) fn commutate(&mut self) -> Step {
        let slept = self.calm.slept().wrapping_add(1);
        let (angle, speed) = self.place();
        let angle = angle.wrapping_add((speed as u32).wrapping_mul(slept));
        let (c, torque) = (&self.coefficients.commutator, self.machine.direction());
        let mut step = self.commutator.present();
        let (commutations, ticks) = match self.commutator.pass(c, angle, speed, torque) {
            Some((commutation, ticks)) => (Commutations::one(commutation), ticks),
            None => {
                let (first, commutations) = self.commutator.step(c, angle, speed, torque);
                step = first;
                (commutations, self.commutator.calm(angle, speed))
            }
        };
        self.applied.commutations = commutations;
        self.count_commutation();
        let present = self.commutator.present();
        self.calm.step = present;
        self.sensorless.beware();
        self.open_phase.change(present);
        if self.open_phase.is_shown() {
            self.calm.all = Sleep { granted: slept, left: 0 };
            self.calm.end();
            return step;
        }
        // The estimator expects another crossing now.
        if self.listens {
            let held = self.sensorless.calm_in(present, torque, angle);
            self.calm.others = self.calm.others.min(slept.saturating_add(held));
        }
        let left = ticks.min(self.calm.others.saturating_sub(slept));
        self.calm.all = Sleep { granted: slept.wrapping_add(left), left };
        step
    }

    /// A tick in which the rotor of a motor that just runs shows that it has turned on, and nothing else asks for a look: the step that it begins with.
    #[inline]
    pub(in crate::motor::drive) fn turns(
        &mut self,
        samples: &Samples,
        current: Amps,
        in_lane: bool,
    ) -> Option<Step> {
        if self.calm.machine.0 <= self.calm.slept() || !self.goes_unnoticed(samples, current, in_lane) {
            return None;
        }
        if self.listens { self.crosses(samples, current) } else { self.passes_edge(samples, current) }
    }

    /// The same with hall sensors: their edge.
    #[inline(never)]
    fn passes_edge(&mut self, samples: &Samples, current: Amps) -> Option<Step> {
        let ticks = self.calm.slept().wrapping_add(1);
        let (c, torque) = (&self.coefficients, self.machine.direction());
        if !self.protection.goes_forward() || !self.rotor.turns(c, samples, torque, ticks) {
            return None;
        }
        let speed = torque.signed(self.rotor.hall_speed().to_bits());
        if !self.protection.stays_quiet(speed) {
            return self.leave_to_all(ticks);
        }
        let position = self.rotor.hall_position();
        let (step, left) = self.follow(position.angle, position.speed);
        let own = self.rotor.calm(&self.coefficients);
        (self.calm.hall, self.calm.speed) = (samples.hall, speed);
        self.sleep_on(current, ticks, left, own);
        Some(step)
    }

    /// The same without: a crossing.
    #[inline(never)]
    fn crosses(&mut self, samples: &Samples, current: Amps) -> Option<Step> {
        let ticks = self.calm.slept().wrapping_add(1);
        let c = &self.coefficients;
        if !self.sensorless.crosses(&c.sensorless, samples, &self.applied, ticks) {
            return if SAVES_TIME { self.nears(samples, current) } else { None };
        }
        self.heed_speed_now();
        let speed = self.sensorless_forward();
        if !self.protection.stays_quiet(speed) || !self.sensorless.runs_on(&self.coefficients.sensorless) {
            return self.leave_to_all(ticks);
        }
        if !self.halls_sleep(samples) {
            self.attend_halls(samples);
        }
        let rotor = self.sensorless.rotor();
        let (step, left) = self.follow(rotor.angle(), rotor.speed());
        let own = self.estimator_calm();
        (self.calm.hall, self.calm.speed, self.calm.fade) = (samples.hall, speed, 0);
        self.sleep_on(current, ticks, left, own);
        Some(step)
    }

    /// A crossing is overdue, or begins to show. What comes of it the next tick tells; this one may be as calm as the one before.
    #[inline(never)]
    fn nears(&mut self, samples: &Samples, current: Amps) -> Option<Step> {
        let ticks = self.calm.slept().wrapping_add(1);
        let sight = self.sensorless.nears(&self.coefficients.sensorless, samples, &self.applied, ticks)?;
        if !self.halls_sleep(samples) {
            self.attend_halls(samples);
        }
        if self.calm.rests() {
            return Some(self.go_on(current));
        }
        // It is overdue: it bounds the speed, which nobody minds, and the commutation may be taken without it.
        self.sensorless.wait(&self.coefficients.sensorless, &sight, ticks);
        self.heed_speed();
        let rotor = self.sensorless.rotor();
        let (step, left) = self.follow(rotor.angle(), rotor.speed());
        let own = self.estimator_calm();
        (self.calm.hall, self.calm.speed) = (samples.hall, self.sensorless_forward());
        self.sleep_on(current, ticks, left, own);
        Some(step)
    }

    /// What has been taken turns out to be for all stations, the tick that is under way included in `ticks` of calm: they find it taken.
    #[inline(never)]
    fn leave_to_all(&mut self, ticks: u32) -> Option<Step> {
        self.machine.sleep(ticks.wrapping_sub(1));
        self.forget_calm();
        self.calm.taken = true;
        None
    }

    /// The pattern of a rotor that is at `angle` and turns at another `speed` (u32 turn, 2^-32 turn a tick): the step that the tick begins with, and for
    /// how many ticks from now the last one goes on.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn follow(&mut self, angle: u32, speed: i32) -> (Step, u32) {
        let (c, torque) = (&self.coefficients.commutator, self.machine.direction());
        if let Some(ticks) = self.commutator.follow(c, angle, speed, torque) {
            self.applied.commutations = Commutations::NONE;
            return (self.commutator.present(), ticks);
        }
        let (step, commutations) = self.commutator.step(c, angle, speed, torque);
        self.applied.commutations = commutations;
        self.count_commutation();
        self.sensorless.beware();
        (step, self.commutator.calm(angle, speed))
    }

    /// After `ticks` of calm, this one included, it goes on: until the next commutation, in `left` ticks, but no longer than the estimator (`own`) and the
    /// state machine allow.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn sleep_on(&mut self, current: Amps, ticks: u32, left: u32, own: u32) {
        self.machine.sleep(ticks);
        let present = self.commutator.present();
        self.calm.step = present;
        self.open_phase.count(current);
        self.open_phase.change(present);
        self.calm.machine.0 = self.calm.machine.0.wrapping_sub(ticks);
        self.calm.others = own.min(self.calm.machine.0);
        self.calm.all = Sleep::new(left.min(self.calm.others));
        if self.open_phase.is_shown() {
            self.calm.end();
        }
    }

    /// The edge or crossing of this tick has been taken, and is nobody's to take again.
    #[inline]
    pub(in crate::motor::drive) const fn is_taken(&mut self) -> bool {
        core::mem::replace(&mut self.calm.taken, false)
    }
}
