//! The sensorless rotor from standstill to closed loop: listen, align, kick, run; the states 2, 3, 4 and 7 are labels on this
//! one sequence.
//!
//! ```text
//!            turns forward                                       lost
//!   Listen -----------------------------------------> Run ---------------> Listen  (state 4 goes to 7)
//!     |  \ turns backward -> Brake -> Listen           ^
//!     |                                                | 6 consistent crossings of both polarities
//!     +-- at rest --> Align (two locks) --> Kick ------+
//! ```

use super::back_emf::{BackEmf, BackEmfCoefficients, OperatingPoint, Sight};
use super::commutation::{Direction, Step};
use super::gain::Gain;
use super::interval::TICK;
use super::listening::Listening;
use super::pwm::PwmCommand;
use super::rails::{Rail, RailCoefficients, Rails};
use super::ramp::Ramp;
use super::samples::Samples;
use super::state::State;
use super::zero_crossing::{Why, ZeroCrossing};
use serde::{Deserialize, Serialize};

/// Coefficients of the sensorless station. Times are in ticks, levels as
/// [`ControlCoefficients::initial_level`](super::control::ControlCoefficients::initial_level) has them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SensorlessCoefficients {
    /// The floating phase.
    pub back_emf: BackEmfCoefficients,
    /// Desynchronisation and stall.
    pub rails: RailCoefficients,
    /// Volts of back-EMF per 2^-32 turn a tick, 0 unknown.
    pub emf_of_turns: Gain,
    /// No crossing for this long is speed 0 (parameter 85), 1/65 536 tick.
    pub timeout: u32,
    /// Nothing heard for this long is a rotor at rest.
    pub rest: u32,
    /// Two locks together.
    pub align: u32,
    /// Rise of the lock level a tick, 16 extra bits.
    pub align_rate: i64,
    /// Level of the locks (parameter 89).
    pub align_level: i32,
    /// Rise of the kick a tick, 16 extra bits.
    pub kick_rate: i64,
    /// Level at which the kick ends (parameter 87).
    pub kick_level: i32,
    /// Without any crossing at the full level the field steps on after this.
    pub kick_patience: u32,
    /// A kick that has not led to closed loop within this is given up.
    pub kick_limit: u32,
    /// Largest back-EMF that is braked by a short circuit, 2^-32 turn a tick: what the phase current limit allows.
    pub brake_max: i32,
}

/// Where the sequence stands.
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

/// What the bridge is to do.
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

/// State of the station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sensorless {
    back_emf: BackEmf,
    rotor: ZeroCrossing,
    listening: Listening,
    rails: Rails,
    phase: Phase,
    /// Ticks in this phase.
    age: u32,
    level: Ramp,
    /// Ticks since the kick saw anything.
    idle: u32,
    /// Back-EMF, raw I16F16 V, at the speed (2^-32 turn a tick) that it was last asked for.
    emf: i32,
    emf_at: i32,
    /// Closed loop has just begun, from a rotor that was caught coasting (true) or brought up (false).
    begun: Option<bool>,
    /// This episode's rotor turned already when it was taken.
    caught: bool,
}

/// Rests (5 ms) for which the same terminal is the highest, in which a rotor at 333 electrical rpm would have shown another: what is slower
/// is brought to rest by the locks.
const STILL: u32 = 12;
/// Where the second lock leaves the rotor: 120 degrees, the middle of an odd sector, whose crossing rises and shows in the off-time too.
const ALIGNED_AT: u32 = (u32::MAX / 3) + 1;

impl Sensorless {
    /// One tick of the sensors, whatever the state. `applied` was in force until this period's boundary.
    pub fn observe(
        &mut self,
        c: &SensorlessCoefficients,
        samples: &Samples,
        bus_voltage: i32,
        applied: &PwmCommand,
        torque: Direction,
    ) {
        self.rotor.advance();
        if applied.step == Step::Coast && applied.commutations.is_empty() {
            self.back_emf = BackEmf::default();
            self.rotor.begin_coasting();
            if self.phase == Phase::Kick {
                return;
            }
            let voltage = c.back_emf.terminal.convert_all(&samples.phase_voltage);
            let heard = self.listening.step(&voltage, c.back_emf.noise, applied.sample_at);
            if let Some(heard) = heard
                && (heard.direction == self.rotor.direction() || self.listening.agrees())
            {
                self.rotor.observe_coasting(heard.place, heard.age, heard.direction);
            }
            return;
        }
        self.listening.reset();
        let point = self.operating_point(c, torque);
        let sight = self.back_emf.step(&c.back_emf, samples, bus_voltage, applied, &point);
        if !matches!(self.phase, Phase::Kick | Phase::Run) || (self.phase == Phase::Kick && self.age < c.rest)
        {
            return;
        }
        let starting = self.phase == Phase::Kick;
        if !self.rotor.observe(&sight, c.emf_of_turns, starting) {
            self.back_emf.reject();
        }
        if sight.crossing.is_some() || sight.late {
            self.idle = 0;
        }
    }

    /// Nobody has listened: what was heard before is of another time.
    pub fn begin_listening(&mut self) {
        self.listening.reset();
    }

    /// The ordinary tick of a running motor: true if its terminals show nothing that [`observe`](Self::observe) and [`step`](Self::step) would act
    /// on; then they need not be called.
    #[inline]
    pub fn passes(
        &mut self,
        c: &SensorlessCoefficients,
        samples: &Samples,
        bus_voltage: i32,
        applied: &PwmCommand,
        torque: Direction,
    ) -> bool {
        match self.back_emf.passes(&c.back_emf, samples, applied) {
            Some(passes) => passes,
            None => self.passes_at_all(c, samples, bus_voltage, applied, torque),
        }
    }

    #[inline(never)]
    fn passes_at_all(
        &mut self,
        c: &SensorlessCoefficients,
        samples: &Samples,
        bus_voltage: i32,
        applied: &PwmCommand,
        torque: Direction,
    ) -> bool {
        if self.back_emf.is_changed_by(applied) {
            let point = self.operating_point(c, torque);
            self.back_emf.turns_over(&c.back_emf, applied, &point)
        } else {
            self.back_emf.passes_at_all(&c.back_emf, samples, bus_voltage, applied)
        }
    }

    /// Another step may have been applied than the one that is watched.
    #[inline]
    pub const fn beware(&mut self) {
        self.back_emf.beware();
    }

    /// What [`observe`](Self::observe) does in the tick of a running motor that finds the ordinary crossing, `ticks` after the last that was told: true. Else
    /// nothing is done.
    #[inline]
    pub fn crosses(
        &mut self,
        c: &SensorlessCoefficients,
        samples: &Samples,
        applied: &PwmCommand,
        ticks: u32,
    ) -> bool {
        if self.phase != Phase::Run {
            return false;
        }
        let Some(crossing) = self.back_emf.crosses(&c.back_emf, samples, applied) else { return false };
        if !self.rotor.crosses(&crossing, c.emf_of_turns, ticks) {
            return false;
        }
        self.back_emf.take(samples, &crossing, applied.sample_at);
        self.age = self.age.saturating_add(ticks).wrapping_sub(1);
        self.idle = 0;
        true
    }

    /// The ordinary tick of a running motor in which its crossing is near, or begins to show, `ticks` after the last that was told: what it saw. Else
    /// nothing is done.
    #[inline]
    pub fn nears(
        &mut self,
        c: &SensorlessCoefficients,
        samples: &Samples,
        applied: &PwmCommand,
        ticks: u32,
    ) -> Option<Sight> {
        let silent = self.rotor.since().saturating_add(ticks.saturating_mul(TICK));
        if silent >= c.timeout { None } else { self.back_emf.nears(&c.back_emf, samples, applied) }
    }

    /// The crossing of which no more is in `sight` is overdue: what [`observe`](Self::observe) and [`step`](Self::step) do, `ticks` after the last that was
    /// told.
    pub fn wait(&mut self, c: &SensorlessCoefficients, sight: &Sight, ticks: u32) {
        self.sleep(ticks);
        self.rotor.observe(sight, c.emf_of_turns, false);
    }

    /// What a step that begins now may expect.
    fn operating_point(&mut self, c: &SensorlessCoefficients, torque: Direction) -> OperatingPoint {
        if self.rotor.speed() != self.emf_at {
            self.emf_at = self.rotor.speed();
            self.emf = c.emf_of_turns.apply32(self.emf_at.saturating_abs());
        }
        OperatingPoint { torque, interval: self.rotor.expected(), emf: self.emf }
    }

    /// For how many ticks from now only time would pass, as long as every one [`passes`](Self::passes), with the step `present` applied.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub fn calm(&self, c: &SensorlessCoefficients, present: Step, torque: Direction) -> u32 {
        if !self.is_running() {
            return 0;
        }
        self.rotor.calm(c.timeout, self.back_emf.expects(present, torque))
    }

    /// For how many ticks from now the commutation to `present`, which this tick begins with the rotor at `angle` (u32 turn), leaves it so.
    #[inline]
    pub fn calm_in(&self, present: Step, torque: Direction, angle: u32) -> u32 {
        self.back_emf.expects(present, torque).map_or(u32::MAX, |sector| self.rotor.held(sector, angle))
    }

    /// So many of these ticks have passed.
    pub const fn sleep(&mut self, ticks: u32) {
        self.rotor.sleep(ticks);
        self.age = self.age.saturating_add(ticks);
        self.idle = self.idle.saturating_add(ticks);
    }

    /// The master starts the motor (`State::RotorLock`), or T47 wants it caught or restarted.
    pub fn start(&mut self, fresh: bool) {
        if fresh {
            self.rails.reset();
        }
        self.go(Phase::Listen);
        self.begun = None;
    }

    /// A start was ended: the rotor that was being brought up coasts, and is listened to.
    pub fn end_start(&mut self) {
        if self.is_kicking() {
            self.go(Phase::Listen);
        }
    }

    fn go(&mut self, phase: Phase) {
        (self.phase, self.age, self.idle) = (phase, 0, 0);
        self.level = Ramp::default();
        self.caught = false;
    }

    /// The sequence's next move in `state`.
    pub fn step(&mut self, c: &SensorlessCoefficients, state: State, torque: Direction) -> Plan {
        self.age = self.age.saturating_add(1);
        self.idle = self.idle.saturating_add(1);
        // In rotor lock the rotor is not yet turned.
        let released = state != State::RotorLock;
        match self.phase {
            Phase::Listen => self.listen(c, released, torque),
            Phase::Brake => self.brake(c),
            Phase::Align if self.age > c.align && released => self.kick_off(c, torque),
            Phase::Align => self.align(c, torque),
            Phase::Kick => self.kick(c),
            Phase::Run => self.run(c),
        }
    }

    fn listen(&mut self, c: &SensorlessCoefficients, released: bool, torque: Direction) -> Plan {
        if self.listening.is_turning() && self.rotor.since() < c.timeout {
            if self.listening.direction() != torque {
                self.go(Phase::Brake);
            } else if released && self.rotor.is_prepared() {
                self.go(Phase::Run);
                (self.begun, self.caught) = (Some(true), true);
                return Plan::Speed(0);
            }
        } else if self.listening.quiet() >= c.rest || self.age.min(self.listening.still()) >= STILL * c.rest {
            // Stillness counts from here: what was at rest for long before may just have begun to turn.
            self.go(Phase::Align);
        }
        Plan::Coast
    }

    /// A rotor that turns backward: shorted where that gives no more than the phase current limit, else left to coast. Nothing is
    /// returned to the bus either way. What is slow enough is brought to rest by the locks.
    fn brake(&mut self, c: &SensorlessCoefficients) -> Plan {
        const LISTEN_AGAIN: u32 = 64;
        let speed = self.rotor.speed().saturating_abs();
        if self.age > LISTEN_AGAIN {
            self.go(Phase::Listen);
        }
        if speed < c.brake_max { Plan::Short } else { Plan::Coast }
    }

    /// Two locks, 60 degrees apart, the second from the side that the rotor is to turn to: one that rests on the dead point of the
    /// first is off that of the second. Three-phase, which damps the swing.
    fn align(&mut self, c: &SensorlessCoefficients, torque: Direction) -> Plan {
        let level = self.level.step(c.align_level, c.align_rate);
        let step = match torque {
            _ if self.age > c.align / 2 => Step::LockCA,
            Direction::Forward => Step::LockC,
            Direction::Reverse => Step::LockA,
        };
        Plan::Hold(step, level)
    }

    fn kick_off(&mut self, c: &SensorlessCoefficients, torque: Direction) -> Plan {
        self.go(Phase::Kick);
        self.rotor.start(ALIGNED_AT, torque);
        self.kick(c)
    }

    fn kick(&mut self, c: &SensorlessCoefficients) -> Plan {
        // The locks' current dies away first.
        if self.age < c.rest {
            self.idle = 0;
            return Plan::Coast;
        }
        let level = self.level.step(c.kick_level, c.kick_rate);
        if self.rotor.is_prepared() {
            self.go(Phase::Run);
            self.begun = Some(false);
            return Plan::Speed(0);
        }
        if self.age > c.kick_limit {
            self.end(Rail::Stall);
            return Plan::Coast;
        }
        if level >= c.kick_level && self.idle > c.kick_patience {
            self.rotor.force_step();
            self.idle = 0;
        }
        Plan::Level(level)
    }

    /// One tick of a running motor that goes on behind a [`crossing`](Self::crosses), after which nothing fades: false, and nothing is done, if
    /// [`step`](Self::step) is to look.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub fn runs_on(&mut self, c: &SensorlessCoefficients) -> bool {
        if self.rotor.since() >= c.timeout || self.rotor.is_irregular() {
            return false;
        }
        self.age = self.age.saturating_add(1);
        self.idle = self.idle.saturating_add(1);
        true
    }

    fn run(&mut self, c: &SensorlessCoefficients) -> Plan {
        if self.rotor.is_lost() || self.rotor.since() >= c.timeout {
            self.end(Rail::Stall);
            return Plan::Coast;
        }
        if self.rotor.is_irregular() {
            self.end(Rail::Desynchronised);
            return Plan::Coast;
        }
        Plan::Speed(self.rotor.fade())
    }

    /// This episode is over: the bridge goes off and the drive listens.
    pub fn end(&mut self, rail: Rail) {
        self.rails.count(rail);
        self.go(Phase::Listen);
    }

    /// Once a millisecond while driving: the bucket, and in closed loop the voltage's testimony.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub fn check(
        &mut self,
        c: &SensorlessCoefficients,
        driven: bool,
        voltage: i32,
        current: i32,
        speed: i32,
    ) {
        self.rails.leak(&c.rails);
        if self.phase == Phase::Run && driven && self.rails.is_wrong_lock(&c.rails, voltage, current, speed) {
            self.end(Rail::WrongLock);
        }
    }

    /// The fault of a full bucket.
    pub const fn fault(&self) -> Option<super::fault::Cause> {
        self.rails.fault()
    }

    /// Closed loop began with the last step: caught coasting (true) or brought up (false).
    pub const fn take_begun(&mut self) -> Option<bool> {
        self.begun.take()
    }

    /// Angle and speed (u32 turn, 2^-32 turn a tick) for the commutator. While a kick knows no speed, the angle stands in a
    /// sector's middle.
    pub const fn rotor(&self) -> &ZeroCrossing {
        &self.rotor
    }

    /// The rotor is being brought up.
    pub const fn is_kicking(&self) -> bool {
        matches!(self.phase, Phase::Kick)
    }

    /// The bridge holds the rotor or turns it: it does not coast.
    pub const fn is_led(&self) -> bool {
        matches!(self.phase, Phase::Align | Phase::Kick | Phase::Run)
    }

    /// The bridge is off, and no terminal has shown a turning rotor for long enough: it stands.
    pub fn hears_rest(&self, c: &SensorlessCoefficients) -> bool {
        self.listening.quiet() >= c.rest || self.listening.still() >= STILL * c.rest
    }

    /// The estimator runs the motor.
    pub const fn is_running(&self) -> bool {
        matches!(self.phase, Phase::Run)
    }

    /// The estimator runs a motor that turned already: there is no open-loop speed that it would have to be brought to.
    pub const fn is_caught(&self) -> bool {
        self.caught
    }

    /// Estimated speed, 2^-32 turn a tick, signed; 0 when none is known.
    #[inline]
    pub fn speed(&self, c: &SensorlessCoefficients) -> i32 {
        let heard = match self.phase {
            Phase::Run => true,
            Phase::Kick => self.rotor.is_prepared(),
            _ => self.listening.is_turning(),
        };
        if heard && self.rotor.since() < c.timeout { self.rotor.speed_bounded() } else { 0 }
    }

    /// The why-channel: the last step's crossing, its margin, crossings accepted.
    pub const fn why(&self) -> (Why, i16, u32) {
        self.rotor.why()
    }

    /// Where the start sequence stands.
    pub const fn phase(&self) -> Phase {
        self.phase
    }
}
