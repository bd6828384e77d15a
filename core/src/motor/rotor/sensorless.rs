//! The sensorless rotor from standstill to closed loop: listen, align, kick, run; the states 2, 3, 4 and 7
//! are labels on this one sequence.
//!
//! ```text
//!            turns forward                                       lost
//!   Listen -----------------------------------------> Run ---------------> Listen  (state 4 goes to 7)
//!     |  \ turns backward -> Brake -> Listen           ^
//!     |                                                | 6 consistent crossings of both polarities
//!     +-- at rest --> Align (two locks) --> Kick ------+
//! ```

use super::back_emf::{BackEmf, BackEmfCoefficients, End, Observation, OperatingPoint};
use super::listening::Listening;
use super::zero_crossing::{Why, ZeroCrossing};
use crate::motor::clock::Instant;
use crate::motor::commutate::commutation::{Direction, Step};
use crate::motor::commutate::pwm::PwmCommand;
use crate::motor::guard::rails::{Rail, RailCoefficients, Rails};
use crate::motor::machine::state::State;
use crate::motor::ramp::Ramp;
use crate::motor::sense::samples::Samples;
use serde::{Deserialize, Serialize};

/// Coefficients of the sensorless station. Times are in ticks, levels as `initial_level` of the control's
/// coefficients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct SensorlessCoefficients {
    /// The floating phase.
    pub back_emf: BackEmfCoefficients,
    /// Desynchronisation and stall.
    pub rails: RailCoefficients,
    /// No crossing for this long is speed 0 (parameter 85), 1/65 536 tick.
    pub timeout: u32,
    /// Silent terminals for this long mean a rotor at rest.
    pub rest: u32,
    /// Two locks together.
    pub align: u32,
    /// Rise of the lock level a millisecond, 16 extra bits.
    pub align_rate: i64,
    /// Level of the locks (parameter 89).
    pub align_level: i32,
    /// Rise of the kick a millisecond, 16 extra bits.
    pub kick_rate: i64,
    /// Level at which the kick ends (parameter 87).
    pub kick_level: i32,
    /// Without any crossing at the full level the field steps on after this.
    pub kick_patience: u32,
    /// A kick that has not led to closed loop within this is given up.
    pub kick_limit: u32,
    /// Largest back-EMF that is braked by a short circuit, 2^-32 turn a tick: what the phase current limit
    /// allows.
    pub brake_max: i32,
}

/// Phase of the start sequence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Bridge off, ear at the terminals.
    #[default]
    Listen,
    /// The rotor turns the other way: windings shorted where the current allows it.
    Brake,
    /// Held by one lock, then by the other.
    Align,
    /// A level that rises in the step beside the lock, commutated on what is seen.
    Kick,
    /// Closed loop.
    Run,
}

/// Orders for the bridge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plan {
    /// All off.
    Coast,
    /// Windings shorted by the low-side switches.
    Short,
    /// A fixed pattern at this level.
    Hold(Step, i32),
    /// Commutate by the estimator at this level.
    Level(i32),
    /// Commutate by the estimator in the speed loop; the voltage fades by so many 1/16.
    Speed(u8),
}

/// The part of the terminals' signal that is being watched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Watched {
    /// Perhaps another pattern than in the tick before.
    #[default]
    Change,
    /// A step that goes on.
    Step,
    /// The coasting motor.
    Coasting,
}

/// State of the station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sensorless {
    watched: Watched,
    back_emf: BackEmf,
    estimator: ZeroCrossing,
    listening: Listening,
    rails: Rails,
    phase: Phase,
    /// The tick in which this phase began.
    since: Instant,
    level: Ramp,
    /// The last tick in which the kick saw anything.
    seen: Instant,
    /// Closed loop has just begun, from a rotor that was caught coasting (true) or brought up (false).
    begun: Option<bool>,
    /// This episode's rotor turned already when it was taken.
    caught: bool,
    /// Time at which the sequence must go on.
    due: Instant,
}

/// Number of rest times (5 ms each) after which a highest terminal that stays the same means standstill: a
/// rotor at 333 electrical rpm would have shown another, and what is slower is brought to rest by the locks.
const STILL: u32 = 12;
/// Number of rest times for which a rotor that turns backward is braked before the drive listens again.
const BRAKE: u32 = 5;
/// Angle at which the second lock leaves the rotor: 120 degrees, the middle of an odd sector, whose crossing
/// rises and shows in the off-time too.
const ALIGNED_AT: u32 = (u32::MAX / 3) + 1;

impl Sensorless {
    /// The terminals in one tick, whatever the state; `applied` was in force until this period's boundary.
    /// True if the estimate has changed.
    #[inline]
    pub fn sense(
        &mut self,
        c: &SensorlessCoefficients,
        now: Instant,
        samples: &Samples,
        bus_voltage: i32,
        applied: &PwmCommand,
        torque: Direction,
    ) -> bool {
        let rests = match self.watched {
            Watched::Step => self.back_emf.rests(now, samples, applied.sample_at),
            Watched::Coasting => {
                self.listening.rests(&c.back_emf, now, &samples.phase_voltage, applied.sample_at)
            }
            Watched::Change => false,
        };
        if rests && samples.edges.is_empty() {
            return false;
        }
        self.observe(c, now, samples, bus_voltage, applied, torque)
    }

    /// A tick whose terminals may say something new.
    #[inline(never)]
    fn observe(
        &mut self,
        c: &SensorlessCoefficients,
        now: Instant,
        samples: &Samples,
        bus_voltage: i32,
        applied: &PwmCommand,
        torque: Direction,
    ) -> bool {
        if coasts(applied) {
            self.watched = Watched::Coasting;
            return self.coast(c, now, samples, applied);
        }
        self.watched = Watched::Step;
        let mut end = End::Seen;
        if !self.back_emf.goes_on(applied) {
            end = self.watch_step(c, now, samples, applied, torque);
            let hidden = samples.edges.is_empty() && self.back_emf.rests(now, samples, applied.sample_at);
            if hidden && matches!(end, End::Seen) {
                return false;
            }
        }
        let observation = self.back_emf.look(&c.back_emf, now, samples, bus_voltage, applied.sample_at);
        let changed = self.is_trusted(c, now) && self.update(c, now, end, observation);
        self.expect_crossing();
        changed
    }

    /// Another step has begun in the period that has ended: it is watched from now on.
    #[inline]
    fn watch_step(
        &mut self,
        c: &SensorlessCoefficients,
        now: Instant,
        samples: &Samples,
        applied: &PwmCommand,
        torque: Direction,
    ) -> End {
        if self.back_emf.coasts() {
            self.listening.reset(now);
            // A crossing is expected within half a turn of the angle, which must be this tick's.
            self.estimator.pass(now);
        }
        let accelerates = self.phase == Phase::Kick;
        let point = OperatingPoint { torque, interval: self.estimator.expected(), accelerates };
        let end = self.back_emf.follow(&c.back_emf, now, samples, applied, &point);
        self.expect_crossing();
        end
    }

    /// The terminals are trusted: in closed loop, and once the kick's current flows.
    #[inline]
    fn is_trusted(&self, c: &SensorlessCoefficients, now: Instant) -> bool {
        self.phase == Phase::Run || (self.phase == Phase::Kick && now.since(self.since) > c.rest)
    }

    /// The estimator takes how the step before ended, and what this one shows. True if the estimate has
    /// changed.
    #[inline]
    fn update(
        &mut self,
        c: &SensorlessCoefficients,
        now: Instant,
        end: End,
        observation: Observation,
    ) -> bool {
        let blind = matches!(end, End::Missed);
        if blind {
            self.estimator.step_blind(now);
        }
        let (sector, observation) = match end {
            End::Crossing { sector, age } => (Some(sector), Observation::Crossing { age, threshold: 0 }),
            End::Seen | End::Missed => (self.back_emf.sector(), observation),
        };
        sector.is_some_and(|sector| self.apply_observation(c, now, sector, observation)) || blind
    }

    /// The estimator takes what the step of `sector` shows. True if the estimate has changed.
    #[inline]
    fn apply_observation(
        &mut self,
        c: &SensorlessCoefficients,
        now: Instant,
        sector: u8,
        observation: Observation,
    ) -> bool {
        let starting = self.phase == Phase::Kick;
        let found = self.back_emf.is_found();
        match observation {
            Observation::Crossing { age, threshold } => {
                self.seen = now;
                let crossing = (age, threshold);
                let accepted = self.estimator.cross(now, sector, crossing, c.back_emf.emf_of_turns, starting);
                if !accepted {
                    self.back_emf.reject(now);
                }
                accepted
            }
            Observation::Late => {
                self.seen = now;
                self.estimator.cross_late(now, sector, starting);
                true
            }
            // After a crossing that was found this tells that it was none.
            Observation::Before if starting || found || self.back_emf.is_overdue(now) => {
                self.estimator.wait(now, sector, starting)
            }
            Observation::Nothing if starting && !found => self.estimator.wait(now, sector, true),
            Observation::Before | Observation::Nothing => false,
        }
    }

    /// From when on the crossing that is watched is overdue.
    #[inline]
    fn expect_crossing(&mut self) {
        let watched = self.back_emf.sector().filter(|_| !self.back_emf.is_found());
        self.back_emf.expect(watched.map(|sector| self.estimator.overdue_at(sector)));
    }

    /// A tick with the bridge off in which a terminal has become the highest, or the bridge has just gone
    /// off.
    #[inline(never)]
    fn coast(
        &mut self,
        c: &SensorlessCoefficients,
        now: Instant,
        samples: &Samples,
        applied: &PwmCommand,
    ) -> bool {
        if !self.back_emf.coasts() {
            self.back_emf = BackEmf::default();
            self.listening.reset(now);
        }
        self.estimator.begin_coasting(now);
        if self.phase == Phase::Kick {
            self.listening.reset(now);
            return false;
        }
        let codes = &samples.phase_voltage;
        self.listening.inform(&mut self.estimator, &c.back_emf, now, codes, applied.sample_at)
    }

    /// Begins to listen: observations from before are forgotten.
    pub fn begin_listening(&mut self, now: Instant) {
        self.listening.reset(now);
        self.estimator.skip(now);
        self.wake();
    }

    /// The next tick looks at everything: the terminals may show another pattern.
    #[inline]
    pub const fn wake(&mut self) {
        self.watched = Watched::Change;
    }

    /// Notes the command that is `applied` from here on: it may be another pattern.
    #[inline]
    pub fn note(&mut self, applied: &PwmCommand) {
        if !self.back_emf.goes_on(applied) {
            self.wake();
        }
    }

    /// Keeps the distance of its instants below the clock's range while nothing else is asked of it.
    pub fn renew(&mut self, now: Instant) {
        self.listening.renew(now);
        self.estimator.pass(now);
    }

    /// Time at which the sequence must go on even if the terminals show nothing new. It holds while the
    /// bridge is on.
    #[inline]
    pub const fn due(&self) -> Instant {
        self.due
    }

    /// Time at which a phase before closed loop has to go on by time alone.
    fn deadline(&self, c: &SensorlessCoefficients, now: Instant) -> Instant {
        let began = self.since;
        match self.phase {
            Phase::Listen => self
                .listening
                .settles(c.rest, began, STILL * c.rest)
                .earlier(self.estimator.silent_at(c.timeout)),
            Phase::Brake => began.after(BRAKE * c.rest + 1),
            Phase::Align => {
                let half = began.after(c.align / 2 + 1);
                if half.is_due(now) { began.after(c.align + 1) } else { half }
            }
            Phase::Kick if now.since(began) < c.rest => began.after(c.rest),
            Phase::Kick if self.level.value() < c.kick_level => began.after(c.kick_limit + 1),
            Phase::Kick => began.after(c.kick_limit + 1).earlier(self.seen.after(c.kick_patience + 1)),
            Phase::Run => self.estimator.silent_at(c.timeout),
        }
    }

    /// Once a millisecond: the level of the lock, or of the kick. True if it has changed.
    pub fn advance(&mut self, c: &SensorlessCoefficients, now: Instant) -> bool {
        match self.phase {
            Phase::Align => self.level.advance(c.align_level, c.align_rate),
            Phase::Kick if now.since(self.since) >= c.rest => self.level.advance(c.kick_level, c.kick_rate),
            Phase::Listen | Phase::Brake | Phase::Kick | Phase::Run => false,
        }
    }

    /// The master starts the motor (`State::RotorLock`), or T47 wants it caught or restarted.
    pub fn start(&mut self, now: Instant, fresh: bool) {
        if fresh {
            self.rails.reset();
        }
        self.go(now, Phase::Listen);
        self.begun = None;
    }

    /// The hall loop begins with a rotor that may stand at `angle`, and the terminals are watched beside it:
    /// from a coasting rotor the estimate goes on.
    pub fn accompany(&mut self, now: Instant, angle: u32, torque: Direction) {
        if !self.listening.is_turning() || self.estimator.direction() != torque {
            self.estimator.start(now, angle, torque);
        }
        self.rails.reset();
        self.go(now, Phase::Run);
        self.begun = None;
    }

    /// The terminals could run the motor.
    pub fn is_established(&self, c: &SensorlessCoefficients, now: Instant) -> bool {
        self.phase == Phase::Run && self.estimator.is_established() && self.estimator.since(now) < c.timeout
    }

    /// A start was ended: the rotor that was being brought up coasts, and is listened to.
    pub fn end_start(&mut self, now: Instant) {
        if self.phase == Phase::Kick {
            self.go(now, Phase::Listen);
        }
    }

    fn go(&mut self, now: Instant, phase: Phase) {
        // A phase that another one ends in its step goes on in the next tick.
        (self.phase, self.since, self.seen, self.due) = (phase, now, now, now.next());
        self.wake();
        if !self.back_emf.coasts() {
            self.listening.reset(now);
        }
        self.level = Ramp::default();
        self.caught = false;
    }

    /// The sequence's next move in `state`.
    #[inline]
    pub fn step(
        &mut self,
        c: &SensorlessCoefficients,
        now: Instant,
        state: State,
        torque: Direction,
    ) -> Plan {
        if self.phase == Phase::Run {
            self.due = self.estimator.silent_at(c.timeout);
            return self.run(c, now);
        }
        // Before the phase acts: what it changes of its own deadline (`go`, or a forced step) only makes it
        // earlier.
        self.due = self.deadline(c, now);
        // In rotor lock the rotor is not yet turned.
        self.lead(c, now, state != State::RotorLock, torque)
    }

    /// The sequence up to closed loop.
    #[inline(never)]
    fn lead(&mut self, c: &SensorlessCoefficients, now: Instant, released: bool, torque: Direction) -> Plan {
        match self.phase {
            Phase::Listen => self.listen(c, now, released, torque),
            Phase::Brake => self.brake(c, now),
            Phase::Align if now.since(self.since) > c.align && released => self.kick_off(c, now, torque),
            Phase::Align => self.align(c, now, torque),
            Phase::Kick => self.kick(c, now),
            Phase::Run => self.run(c, now),
        }
    }

    fn listen(
        &mut self,
        c: &SensorlessCoefficients,
        now: Instant,
        released: bool,
        torque: Direction,
    ) -> Plan {
        if self.listening.is_turning() && self.estimator.since(now) < c.timeout {
            if self.listening.direction() != torque {
                self.go(now, Phase::Brake);
            } else if released && self.estimator.is_prepared() {
                self.go(now, Phase::Run);
                (self.begun, self.caught) = (Some(true), true);
                return Plan::Speed(0);
            }
        } else if self.listening.quiet(now) >= c.rest
            || now.since(self.since).min(self.listening.still(now)) >= STILL * c.rest
        {
            // Stillness counts from here: what was at rest for long before may just have begun to turn.
            self.go(now, Phase::Align);
        }
        Plan::Coast
    }

    /// A rotor that turns backward: shorted where that gives no more than the phase current limit, else left
    /// to coast. Nothing is returned to the bus either way. What is slow enough is brought to rest by the
    /// locks.
    fn brake(&mut self, c: &SensorlessCoefficients, now: Instant) -> Plan {
        let speed = self.estimator.speed().saturating_abs();
        if now.since(self.since) > BRAKE * c.rest {
            self.go(now, Phase::Listen);
        }
        if speed < c.brake_max { Plan::Short } else { Plan::Coast }
    }

    /// Two locks, 60 degrees apart, the second from the side that the rotor is to turn to: one that rests on
    /// the dead point of the first is off that of the second. Three-phase, which damps the swing.
    fn align(&mut self, c: &SensorlessCoefficients, now: Instant, torque: Direction) -> Plan {
        let level = self.level.value();
        let step = match torque {
            _ if now.since(self.since) > c.align / 2 => Step::LockCA,
            Direction::Forward => Step::LockC,
            Direction::Reverse => Step::LockA,
        };
        Plan::Hold(step, level)
    }

    fn kick_off(&mut self, c: &SensorlessCoefficients, now: Instant, torque: Direction) -> Plan {
        self.go(now, Phase::Kick);
        self.seen = now.after(c.rest);
        self.estimator.start(now, ALIGNED_AT, torque);
        self.kick(c, now)
    }

    fn kick(&mut self, c: &SensorlessCoefficients, now: Instant) -> Plan {
        let age = now.since(self.since);
        // The locks' current dies away first.
        if age < c.rest {
            return Plan::Coast;
        }
        let level = self.level.value();
        if self.estimator.is_prepared() {
            self.go(now, Phase::Run);
            self.begun = Some(false);
            return Plan::Speed(0);
        }
        if age > c.kick_limit {
            self.end(now, Rail::Stall);
            return Plan::Coast;
        }
        if level >= c.kick_level && now.since(self.seen) > c.kick_patience {
            self.estimator.force_step();
            self.seen = now;
        }
        Plan::Level(level)
    }

    #[inline]
    fn run(&mut self, c: &SensorlessCoefficients, now: Instant) -> Plan {
        if self.estimator.is_lost() || self.estimator.since(now) >= c.timeout {
            self.end(now, Rail::Stall);
            return Plan::Coast;
        }
        if self.estimator.is_irregular() {
            self.end(now, Rail::Desynchronised);
            return Plan::Coast;
        }
        Plan::Speed(self.estimator.fade())
    }

    /// This episode is over: the bridge goes off and the drive listens.
    #[inline(never)]
    pub fn end(&mut self, now: Instant, rail: Rail) {
        self.rails.count(rail);
        self.go(now, Phase::Listen);
    }

    /// Once a millisecond while driving: the bucket, and in closed loop the voltage's testimony.
    pub fn check(
        &mut self,
        c: &SensorlessCoefficients,
        now: Instant,
        driven: bool,
        voltage: i32,
        current: i32,
        speed: i32,
    ) {
        self.rails.leak(&c.rails);
        if self.phase == Phase::Run && driven && self.rails.is_wrong_lock(&c.rails, voltage, current, speed) {
            self.end(now, Rail::WrongLock);
        }
    }

    /// The fault of a full bucket.
    pub const fn fault(&self) -> Option<crate::motor::guard::fault::Cause> {
        self.rails.fault()
    }

    /// Closed loop began with the last step: caught coasting (true) or brought up (false).
    pub const fn take_begun(&mut self) -> Option<bool> {
        self.begun.take()
    }

    /// Angle and speed (u32 turn, 2^-32 turn a tick) for the commutator. While a kick knows no speed, the
    /// angle stands in a sector's middle.
    pub const fn estimator(&self) -> &ZeroCrossing {
        &self.estimator
    }

    /// Age of the kick, ticks; 0 before it, while the rotor is braked or held. `None`: the rotor is not being
    /// brought up.
    pub const fn start_age(&self, now: Instant) -> Option<u32> {
        match self.phase {
            Phase::Brake | Phase::Align => Some(0),
            Phase::Kick => Some(now.since(self.since)),
            Phase::Listen | Phase::Run => None,
        }
    }

    /// The bridge holds the rotor or turns it: it does not coast.
    pub const fn is_led(&self) -> bool {
        matches!(self.phase, Phase::Align | Phase::Kick | Phase::Run)
    }

    /// The bridge is off, and no terminal has shown a turning rotor for long enough: it stands.
    pub fn observes_rest(&self, c: &SensorlessCoefficients, now: Instant) -> bool {
        let coasts = self.back_emf.coasts();
        coasts && (self.listening.quiet(now) >= c.rest || self.listening.still(now) >= STILL * c.rest)
    }

    /// The estimator runs the motor.
    pub const fn is_running(&self) -> bool {
        matches!(self.phase, Phase::Run)
    }

    /// The estimator runs a motor that turned already: there is no open-loop speed that it would have to be
    /// brought to.
    pub const fn is_caught(&self) -> bool {
        self.caught
    }

    /// Estimated speed, 2^-32 turn a tick, signed; 0 when none is known.
    #[inline]
    pub fn speed(&self, c: &SensorlessCoefficients, now: Instant) -> i32 {
        let moves = match self.phase {
            Phase::Run => true,
            Phase::Kick => self.estimator.is_prepared(),
            _ => self.listening.is_turning(),
        };
        if moves && self.estimator.since(now) < c.timeout { self.estimator.speed_bounded(now) } else { 0 }
    }

    /// The why-channel: the last step's crossing, its margin, crossings accepted.
    pub const fn why(&self) -> (Why, i16, u32) {
        self.estimator.why()
    }

    /// Present phase of the start sequence.
    pub const fn phase(&self) -> Phase {
        self.phase
    }
}

/// All six switches were off for the whole period.
#[inline]
const fn coasts(applied: &PwmCommand) -> bool {
    matches!(applied.step, Step::Coast) && applied.commutations.is_empty()
}
