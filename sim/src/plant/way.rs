//! The way of the plant through a period: from one stop to the next, in courses of the shaft and intervals of
//! the circuit between two switching events.

use super::gates::Gate;
use super::phase::Phase;
use super::{INSTANT, Plant};
use narx_core::motor::Step;

/// A dead time goes without an interval of its own if the current would outlast so many: a small one stops,
/// and lets other diodes conduct beside it.
const DEAD_TIME_MARGIN: f64 = 8.0;

impl Plant {
    /// A part of the period, 1/65 536, in s.
    pub(super) fn instant(&self, part: u16) -> f64 {
        f64::from(part) * (1.0 / 65_536.0) * self.period
    }

    /// Runs to `target`, s from the start of the period; nothing if that has passed.
    pub(super) fn advance(&mut self, target: f64) {
        while target - self.t > INSTANT {
            // A course goes on over stops that leave the legs as they are.
            if self.stage.course.is_done() {
                self.stage.set_out(self.period - self.t, self.period);
            }
            let goal = self.t + self.stage.course.rest();
            let goal = if target - goal > INSTANT { goal } else { target };
            while goal - self.t > INSTANT {
                self.run(goal);
            }
            if self.stage.course.is_done() {
                self.stage.arrive();
            } else {
                self.stage.go_on();
            }
            self.follow_halls();
        }
    }

    /// Runs to `instant` and goes on with `step`; a change to the same step needs no stop.
    pub(super) fn advance_and_set(&mut self, instant: f64, step: Step) {
        if step != self.gates.step() {
            self.advance(instant);
            self.stage.arrive();
            self.gates.set_step(step);
            self.gates_until = 0.0;
        }
    }

    /// One interval of the stage, to `goal` at most.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn run(&mut self, goal: f64) {
        if self.t >= self.gates_until {
            self.switch(goal);
        }
        let mut until = goal;
        if self.gates_until <= goal {
            until = self.gates_until;
            if until - self.t <= INSTANT {
                // A dead time that ends with the period is a rounding error away from its end.
                self.t = until;
                return;
            }
            if let Some((leg, gate, over)) = self.gates.side_change(until)
                && self.may_skip_dead_time(leg, gate.other(), over - self.t, over, goal)
            {
                return self.run_through_dead_time(leg, gate, over);
            }
        }
        self.run_to(until);
    }

    /// One interval of the stage, to `until` or to what happens before. The gates stay as they are.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn run_to(&mut self, until: f64) {
        let from = self.t;
        let h = self.stage.interval(until - from);
        self.t = if h >= until - from { until } else { from + h };
        if let Some(comparators) = &mut self.comparators
            && self.t > from
        {
            let [start, end] = &self.stage.against_mean;
            comparators.follow(&self.gates.floating(), start, end, from, self.t);
        }
    }

    /// During a dead time the current leads through the diode beside the switch that was on, or beside the
    /// one that will be on: the circuit is then the same as with that switch, but for the diode's drop, and
    /// where nothing else can happen the dead time needs no interval of its own. True if that is so beside
    /// the switch `gate` for `h` seconds.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn may_skip_dead_time(&self, leg: Phase, gate: Gate, h: f64, over: f64, goal: f64) -> bool {
        over <= goal && !self.injected.driver[leg] && self.stage.stays(leg, gate, h)
    }

    /// An interval that goes on beyond the edge at which `leg` begins to change sides to `gate`, to the end
    /// of its dead time.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn run_through_dead_time(&mut self, leg: Phase, gate: Gate, over: f64) {
        let edge = self.gates_until;
        self.run_to(over);
        if self.t > edge {
            self.stage.drop_of_dead_time(leg, gate.other(), self.t - edge);
            if self.t == over {
                self.gates_until = self.gates.change_sides(leg, gate, edge);
                self.stage.turn_on(leg, gate);
            } else {
                self.gates_until = 0.0;
                self.gates.turn_off(leg, edge);
            }
        }
    }

    /// Sets the gates for the time from now on.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn switch(&mut self, goal: f64) {
        // A step that changes together with the edge sets `gates_until` to 0: then more than one leg may
        // change.
        if self.gates_until == self.t
            && let Some((leg, gate, over)) = self.gates.side_change(self.t)
            && self.may_skip_dead_time(leg, gate, DEAD_TIME_MARGIN * (over - self.t), over, goal)
        {
            self.gates_until = self.gates.change_sides(leg, gate, self.t);
            self.stage.drop_of_dead_time(leg, gate, over - self.t);
            self.stage.turn_on(leg, gate);
        } else {
            self.switch_all();
        }
    }

    #[inline(never)]
    fn switch_all(&mut self) {
        let gates = self.gates.at(self.t, &self.injected.driver);
        self.stage.set_gates(&gates);
        self.gates_until = self.gates.next_change(self.t, f64::INFINITY);
    }

    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn follow_halls(&mut self) {
        let angle = self.stage.angle();
        let (before, from) = core::mem::replace(&mut self.followed, (angle, self.t));
        if !self.halls.are_quiet(angle) {
            let per_period = self.parts_per_second;
            self.halls.follow(
                (before, angle),
                (from * per_period, self.t * per_period),
                &self.injected,
                &mut self.random,
                &mut self.capture,
            );
        }
    }
}
