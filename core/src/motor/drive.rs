//! The control tick: samples in, PWM command out, one straight line.

mod calm;
mod reports;
mod signals;

use super::coefficients::Coefficients;
use super::commutation::Step;
use super::commutator::Commutator;
use super::control::{Control, Demand};
use super::event::{Event, HallCalibration, Health, SlowMeasurements};
use super::hall::HallEvents;
use super::hall_calibration::HallCalibrator;
use super::machine::{Change, Inputs, Machine};
use super::measurement::{Measured, Measurement};
use super::open_phase::OpenPhase;
use super::protection::{Evidence, Protection, Seen};
use super::pwm::{Commutations, PwmCommand, Rectification};
use super::ramp::Ramp;
use super::rotor::Rotor;
use super::samples::{SampleMode, Samples};
use super::sensorless::{Plan, Sensorless};
use super::state::State;
use crate::units::{Amps, Duty};
use calm::Calm;
use reports::Reports;
use serde::{Deserialize, Serialize};

/// Layout of the serialised [`Drive`] and of [`Event`]: changes with any field of theirs.
pub const LAYOUT_VERSION: u16 = 4;

/// What the drive does with its inputs: rises with every change that moves a digest.
pub const BEHAVIOUR_VERSION: u16 = 4;

/// The drive: everything that the control tick owns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    coefficients: Coefficients,
    parameters_fit: bool,
    slow: SlowMeasurements,
    health: Health,
    measurement: Measurement,
    rotor: Rotor,
    sensorless: Sensorless,
    protection: Protection,
    open_phase: OpenPhase,
    machine: Machine,
    control: Control,
    commutator: Commutator,
    lock: Ramp,
    calibrator: HallCalibrator,
    calibration: HallCalibration,
    /// Somebody listens to the terminals.
    listens: bool,
    /// Duty from which the on-time is sampled, and below which the off-time is, raw U1F15.
    on_time: (u16, u16),
    /// Speed by back-EMF, 2^-32 turn a tick, and the same as raw I16F16 electrical rev/s: converted when it changes.
    sensorless_turns: i32,
    sensorless_rate: i32,
    calm: Calm,
    /// What was applied in the last tick.
    applied: PwmCommand,
    reports: Reports,
}

/// The places in a millisecond of what needs no tick of its own.
mod place {
    pub(super) const RATINGS: u16 = 0;
    pub(super) const SPEED_LOOP: u16 = 1;
    pub(super) const RAILS: u16 = 2;
    pub(super) const REPORT: u16 = 3;
    pub(super) const LAST: u16 = REPORT;
}

/// The pattern of one tick and what drives it.
struct Pattern {
    demand: Demand,
    step: Step,
    commutations: Commutations,
    /// A duty of 0 is meant: the low sides short the windings.
    short: bool,
}

impl Pattern {
    const OFF: Self =
        Self { demand: Demand::Off, step: Step::Coast, commutations: Commutations::NONE, short: false };

    fn hold(demand: Demand, step: Step) -> Self {
        Self { demand, step, ..Self::OFF }
    }

    /// The step after the last commutation.
    fn last(&self) -> Step {
        self.commutations.last().map_or(self.step, |last| last.step)
    }
}

impl Drive {
    /// A drive at power-up with a parameter set that builds.
    pub fn new(coefficients: Coefficients) -> Self {
        Self {
            coefficients,
            parameters_fit: true,
            slow: SlowMeasurements::default(),
            health: Health::default(),
            measurement: Measurement::default(),
            rotor: Rotor::default(),
            sensorless: Sensorless::default(),
            protection: Protection::default(),
            open_phase: OpenPhase::default(),
            machine: Machine::default(),
            control: Control::default(),
            commutator: Commutator::default(),
            lock: Ramp::default(),
            calibrator: HallCalibrator::default(),
            calibration: HallCalibration::None,
            listens: false,
            on_time: (0, 0),
            sensorless_turns: 0,
            sensorless_rate: 0,
            calm: Calm::default(),
            applied: PwmCommand::default(),
            reports: Reports::default(),
        }
        .settled()
    }

    fn settled(mut self) -> Self {
        self.settle();
        self
    }

    /// What follows from state and coefficients, and is asked for in every tick. The back-EMF of a coasting motor is listened to before a
    /// start, too; a hall drive has no use for it.
    fn settle(&mut self) {
        self.wake_halls();
        let c = &self.coefficients.machine;
        self.listens = if self.machine.state().is_driving() {
            self.machine.is_sensorless()
        } else {
            c.sensorless_enable && !c.hall_enable
        };
        // Without an eye on back-EMF there is no need to go that far.
        let shortest = self.coefficients.control.duty_min.max(ON_TIME_LEAST);
        self.on_time = if self.listens { (shortest, shortest - shortest / 8) } else { (ON_ABOVE, OFF_BELOW) };
    }

    /// Takes one event; call before [`step`](Self::step), at most once a tick.
    pub fn handle_event(&mut self, event: Event) {
        self.wake();
        self.protection.wake();
        match event {
            Event::Command(command) => self.machine.handle_command(command),
            Event::SetPoint(speed) => self.machine.handle_set_point(speed),
            Event::Coefficients(coefficients) => {
                self.rotor.change_wiring(&self.coefficients.hall, &coefficients.hall);
                self.coefficients = coefficients;
                self.parameters_fit = true;
                self.settle();
            }
            Event::CoefficientsRejected => self.parameters_fit = false,
            Event::Slow(slow) => self.slow = slow,
            Event::Health(health) => self.health = health,
            Event::CalibrateHall(run) => self.machine.handle_calibration(run),
        }
    }

    /// One control tick.
    pub fn step(&mut self, samples: &Samples) -> PwmCommand {
        let place = self.control.tick(&self.coefficients.control);
        let idle = self.machine.state() == State::Initialization;
        let measured = self.measurement.step(&self.coefficients.measurement, samples, idle);
        let pattern = if !self.is_calm(samples, &measured) {
            self.look(samples, &measured)
        } else if self.calm.commutates() {
            self.commutate(&measured)
        } else {
            return self.goes_on(place, samples, &measured);
        };
        if place <= place::LAST {
            self.rest_of_millisecond(place, pattern.demand, samples, measured.bus_current);
        }
        if !self.cruises(pattern.demand, pattern.step, pattern.commutations, &measured) {
            self.finish(&pattern, &measured);
        }
        self.applied
    }

    /// From what is wanted to what is applied.
    #[inline(never)]
    fn finish(&mut self, pattern: &Pattern, measured: &Measured) {
        let mode =
            if self.listens { &self.coefficients.sensorless_mode } else { &self.coefficients.hall_mode };
        let output =
            self.control.step(&self.coefficients.control, mode, pattern.demand, measured, &self.measurement);
        self.applied = self.command(pattern, output.duty, output.rectification);
    }

    /// The whole tick: every station in turn, up to what is to be applied.
    #[inline(never)]
    fn look(&mut self, samples: &Samples, measured: &Measured) -> Pattern {
        let rests = self.calm.is_told_to_rest();
        self.wake();
        let hall = self.sense_halls(samples);
        if self.listens {
            self.listen(samples, measured);
        }
        if rests && let Some(pattern) = self.glance(samples, measured, hall) {
            return pattern;
        }
        let critical = self.protect(samples, measured, hall);
        self.advance_state(critical, samples);
        let pattern = self.pattern(samples);
        self.open_phase.change(pattern.last());
        self.calm_down(samples, pattern.demand);
        if self.reports.stirred {
            self.find_change(samples);
        }
        pattern
    }

    #[inline(never)]
    fn listen(&mut self, samples: &Samples, measured: &Measured) {
        let torque = self.machine.direction();
        let bus_voltage = measured.bus_voltage.to_bits();
        self.sensorless.observe(&self.coefficients.sensorless, samples, bus_voltage, &self.applied, torque);
        self.heed_speed();
    }

    /// The estimator's speed may have changed.
    fn heed_speed(&mut self) {
        let turns = self.sensorless.speed(&self.coefficients.sensorless);
        if turns != self.sensorless_turns {
            self.sensorless_rate = self.coefficients.speed_of_turns.apply32(turns);
            self.sensorless_turns = turns;
        }
    }

    /// What is done once a millisecond, spread over its ticks.
    #[inline(never)]
    fn rest_of_millisecond(&mut self, place: u16, demand: Demand, samples: &Samples, current: Amps) {
        if self.coefficients.control.ticks_per_ms > place::LAST {
            return self.do_task(place, demand, samples, current);
        }
        // A board with fewer ticks does more in its last.
        let last = self.coefficients.control.ticks_per_ms.max(1) - 1;
        for task in place..=if place == last { place::LAST } else { place } {
            self.do_task(task, demand, samples, current);
        }
    }

    #[inline]
    fn do_task(&mut self, task: u16, demand: Demand, samples: &Samples, current: Amps) {
        match task {
            place::RATINGS => {
                let turns = !matches!(demand, Demand::Speed { measured: 0, .. });
                let temperature = self.slow.temperature;
                self.control.rate(&self.coefficients.control, &self.measurement, temperature, turns);
            }
            place::SPEED_LOOP => self.run_speed_loop(demand, current),
            place::RAILS => self.check_rails(),
            _ => self.make_due(samples),
        }
    }

    fn run_speed_loop(&mut self, demand: Demand, current: Amps) {
        let c = &self.coefficients;
        if let Demand::Speed { measured: speed, .. } = demand {
            let mode = if self.listens { &c.sensorless_mode } else { &c.hall_mode };
            let brought_up = self.machine.state() != State::OpenLoop || self.sensorless.is_caught();
            let wanted = if brought_up { self.machine.command().speed.to_bits() } else { c.open_loop.speed };
            let wanted = wanted.min(mode.speed_max).max(mode.speed_min);
            let target = if self.machine.reversing() { 0 } else { wanted };
            let bus = (self.measurement.bus_voltage(), current.to_bits());
            self.control.turn(&c.control, mode, target, speed, bus);
        }
    }

    fn check_rails(&mut self) {
        let c = &self.coefficients;
        if self.listens && self.machine.state().is_driving() {
            let speed = self.sensorless_forward();
            let driven = self.applied.step != Step::Coast;
            let applied = self.control.applied(&c.control, self.measurement.bus_voltage());
            self.sensorless.check(&c.sensorless, driven, applied, self.control.phase_current(), speed);
            if !self.sensorless.is_running() {
                self.heed_speed();
                self.calm.end();
            }
        }
    }

    /// True when a critical fault is present now.
    #[inline]
    fn protect(&mut self, samples: &Samples, measured: &Measured, hall: HallEvents) -> bool {
        let state = self.machine.state();
        let driving = state.is_driving();
        let open_phase = driving && !self.machine.calibrating() && {
            self.open_phase.count(measured.bus_current);
            self.open_phase.rest(self.applied.step, self.applied.duty, measured.bus_current, self.stands());
            self.open_phase.is_found(&self.coefficients.open_phase)
        };
        let sensors = state == State::HallClosedLoop && self.minds(hall);
        let seen = Seen {
            bus_voltage: measured.bus_voltage.to_bits(),
            bus_current: measured.bus_current.to_bits(),
            speed: if driving { self.speed() } else { 0 },
            lines: samples.lines,
        };
        let quiet = !sensors
            && !open_phase
            && self.sensorless.fault().is_none()
            && self.protection.stays_quiet(&self.coefficients.protection, &seen);
        !quiet && self.judge(samples, measured, hall, open_phase)
    }

    /// The hall sensors' events, or their silence, are for the fault logic: everything but an edge forward.
    #[inline]
    fn minds(&self, hall: HallEvents) -> bool {
        let forward =
            i32::from(hall.sectors) == self.machine.direction().sign() && self.protection.goes_forward();
        hall.invalid
            || hall.jump
            || (hall.sectors != 0 && !forward)
            || self.rotor.hall_stopped(&self.coefficients)
    }

    #[inline(never)]
    fn judge(&mut self, samples: &Samples, measured: &Measured, hall: HallEvents, open_phase: bool) -> bool {
        let state = self.machine.state();
        let evidence = Evidence {
            measured: *measured,
            slow: self.slow,
            lines: samples.lines,
            health: self.health,
            request: self.machine.command().request,
            hall,
            hall_stopped: self.rotor.hall_stopped(&self.coefficients),
            speed: self.speed(),
            hall_driving: state == State::HallClosedLoop,
            driving: state.is_driving() || self.machine.starting(),
            torque: self.applied.step != Step::Coast,
            torque_sign: self.machine.direction().sign() as i8,
            open_phase,
            sensorless: self.sensorless.fault(),
        };
        self.reports.stirred = true;
        self.protection.step(&self.coefficients.protection, &evidence)
    }

    /// Magnitude of the speed by the running mode, raw I16F16 electrical rev/s.
    #[inline]
    fn speed(&self) -> i32 {
        match self.machine.state() {
            State::HallClosedLoop => self.rotor.hall_speed().abs().to_bits(),
            _ if self.machine.is_sensorless() => self.sensorless_speed().saturating_abs(),
            _ => self.rotor.hall_speed().abs().to_bits(),
        }
    }

    /// The rotor is not known to turn.
    #[inline]
    fn stands(&self) -> bool {
        match self.machine.state() {
            State::HallClosedLoop => self.rotor.hall_stopped(&self.coefficients),
            _ => !(self.machine.is_sensorless() && self.sensorless.is_running()),
        }
    }

    #[inline]
    fn advance_state(&mut self, critical: bool, samples: &Samples) {
        let stopped = match self.machine.state() {
            State::HallClosedLoop => self.rotor.hall_stopped(&self.coefficients),
            // A calibration's field is slow enough to count as standing.
            State::OpenLoop if self.machine.is_sensorless() => !self.sensorless.is_running(),
            State::OpenLoop => self.machine.calibrating() || self.rotor.field_stopped(),
            // What was not brought up by the end of open loop (T34) has the time-out to show a crossing.
            State::SensorlessClosedLoop if self.sensorless.is_kicking() => {
                self.machine.age() << 16 > self.coefficients.sensorless.timeout
            }
            State::SensorlessClosedLoop | State::SensorlessAutoRestart => !self.sensorless.is_running(),
            _ => true,
        };
        let unhealthy = self.health.self_test_failed || !self.health.store_faults.is_empty();
        if !self.machine.rests(&self.coefficients.machine, critical, stopped, unhealthy) {
            self.change_state(critical, stopped, unhealthy, samples);
        }
    }

    #[inline(never)]
    fn change_state(&mut self, critical: bool, stopped: bool, unhealthy: bool, samples: &Samples) {
        let inputs = Inputs {
            critical,
            unhealthy,
            causes_gone: self.protection.causes_gone(),
            stopped,
            calibrated: matches!(self.calibration, HallCalibration::Done(_) | HallCalibration::Failed),
            parameters_fit: self.parameters_fit,
        };
        if let Some(change) = self.machine.advance(&self.coefficients.machine, &inputs) {
            self.protection.wake();
            self.reports.stirred = true;
            self.enter(change, samples);
            self.settle();
            self.heed_speed();
        }
    }

    /// What a transition sets up.
    fn enter(&mut self, change: Change, samples: &Samples) {
        if change.timed_out {
            self.protection.raise_timeout();
        }
        let c = &self.coefficients;
        let direction = self.machine.direction();
        match change.row.to {
            // What was seen while supplies came up and has gone is nobody's fault; what has not is latched again.
            State::Standby if !change.row.from.is_driving() => self.protection.acknowledge(),
            State::Fault if change.row.from == State::Initialization => {
                self.protection.raise_boot_failure(self.health);
            }
            State::RotorLock => {
                self.lock = Ramp::default();
                self.control.start(&c.control, 0);
                if self.machine.calibrating() {
                    self.calibration = HallCalibration::Running;
                } else {
                    self.sensorless.start(true);
                }
            }
            State::OpenLoop if self.machine.is_sensorless() => {}
            State::SensorlessClosedLoop if self.sensorless.is_running() => {
                let brought_up = change.row.from == State::OpenLoop && !self.sensorless.is_caught();
                if brought_up && c.control.initial_voltage > 0 {
                    self.control.hand_over(self.control.setpoint(), c.control.initial_voltage);
                }
            }
            State::SensorlessAutoRestart => {
                self.sensorless.start(false);
                self.control.start(&c.control, 0);
            }
            State::OpenLoop => {
                if self.machine.calibrating() {
                    self.calibrator.start(samples.hall);
                } else {
                    self.rotor.start_open_loop(0, direction);
                    self.control.start(&c.control, 0);
                }
            }
            State::HallClosedLoop => {
                let speed = self.rotor.hall_speed().to_bits().saturating_mul(direction.sign());
                self.control.start(&c.control, speed.min(c.hall_mode.speed_max).max(0));
            }
            _ => {}
        }
        if !change.row.to.is_driving() || !change.row.from.is_driving() {
            self.protection.forget_episode();
            self.open_phase.reset();
            self.commutator.reset();
        }
        if !change.row.to.is_driving() && self.calibration == HallCalibration::Running {
            self.calibration = HallCalibration::Failed;
        }
    }

    /// What this state applies.
    fn pattern(&mut self, samples: &Samples) -> Pattern {
        match self.machine.state() {
            State::RotorLock if self.machine.calibrating() => self.calibration_lock(),
            State::OpenLoop if self.machine.calibrating() => self.hall_calibration(samples),
            State::OpenLoop if !self.machine.is_sensorless() => self.open_loop(),
            State::HallClosedLoop => self.hall_closed_loop(),
            State::RotorLock
            | State::OpenLoop
            | State::SensorlessClosedLoop
            | State::SensorlessAutoRestart => self.sensorless(),
            State::Initialization | State::Standby | State::Fault => Pattern::OFF,
        }
    }

    /// Signed, raw I16F16 electrical rev/s.
    #[inline]
    const fn sensorless_speed(&self) -> i32 {
        self.sensorless_rate
    }

    /// The same in the direction of torque.
    #[inline]
    fn sensorless_forward(&self) -> i32 {
        self.sensorless_rate.saturating_mul(self.machine.direction().sign()).max(0)
    }

    /// What the sequence from standstill to closed loop wants now.
    fn sensorless(&mut self) -> Pattern {
        let direction = self.machine.direction();
        let state = self.machine.state();
        let speed = self.sensorless_forward();
        let c = &self.coefficients;
        // Nothing is brought up in a direction that is no longer wanted.
        if self.machine.reversing() && !self.sensorless.is_running() {
            return Pattern::OFF;
        }
        let plan = self.sensorless.step(&c.sensorless, state, direction);
        self.heed_speed();
        let c = &self.coefficients;
        match self.sensorless.take_begun() {
            Some(true) => self.control.start(&c.control, speed),
            // A light rotor may have leapt beyond what is ever asked of it: the set-point does not.
            Some(false) => {
                let applied = self.control.applied(&c.control, self.measurement.bus_voltage());
                self.control.hand_over(speed.min(c.sensorless_mode.speed_max), applied);
            }
            None => {}
        }
        let demand = match plan {
            Plan::Coast => return Pattern::OFF,
            Plan::Short => {
                return Pattern { short: true, ..Pattern::hold(Demand::Voltage { voltage: 0 }, Step::LockA) };
            }
            Plan::Hold(step, voltage) => return Pattern::hold(Demand::Voltage { voltage }, step),
            Plan::Level(voltage) => Demand::Voltage { voltage },
            Plan::Speed(fade) => Demand::Speed { measured: speed, fade },
        };
        let rotor = self.sensorless.rotor();
        let (step, commutations) =
            self.commutator.step(&c.commutator, rotor.angle(), rotor.speed(), direction);
        // A current limit that takes the kick's duty to 0 freewheels: with the bridge off the winding's energy would go to the bus.
        let short = matches!(plan, Plan::Level(_));
        Pattern { demand, step, commutations, short }
    }

    /// Two locks one after the other, 60 degrees apart: a rotor that rests on the dead point of the first is off that
    /// of the second.
    fn calibration_lock(&mut self) -> Pattern {
        let c = &self.coefficients.machine;
        let voltage = self.lock.step(c.lock_voltage, c.lock_rate);
        let second = self.machine.age() >= c.lock / 2;
        Pattern::hold(Demand::Voltage { voltage }, if second { HallCalibrator::LOCK } else { Step::LockB })
    }

    fn hall_calibration(&mut self, samples: &Samples) -> Pattern {
        let c = &self.coefficients.hall_calibration;
        let (step, calibration) = self.calibrator.step(c, samples.hall);
        self.calibration = calibration;
        Pattern::hold(Demand::Voltage { voltage: c.voltage }, step)
    }

    fn open_loop(&mut self) -> Pattern {
        let direction = self.machine.direction();
        let run = !self.machine.reversing();
        let field = self.rotor.step_open_loop(&self.coefficients, direction, run);
        let (step, commutations) =
            self.commutator.step(&self.coefficients.commutator, field.angle, field.speed, direction);
        Pattern { demand: Demand::Voltage { voltage: field.voltage }, step, commutations, short: false }
    }

    /// A rotor that turns the other way at speed is left to coast: torque now would brake it through the bridge,
    /// where no current is measured. So is one whose sensors contradict themselves.
    #[inline]
    fn hall_demand(&self) -> Option<Demand> {
        let least = -(self.coefficients.hall_mode.speed_min / 2);
        let speed = self.rotor.hall_speed().to_bits().saturating_mul(self.machine.direction().sign());
        let runs = speed >= least && !self.rotor.hall_doubtful();
        runs.then_some(Demand::Speed { measured: speed.max(0), fade: 0 })
    }

    fn hall_closed_loop(&mut self) -> Pattern {
        let direction = self.machine.direction();
        let Some(demand) = self.hall_demand() else { return Pattern::OFF };
        let position = self.rotor.hall_position();
        let (step, commutations) =
            self.commutator.step(&self.coefficients.commutator, position.angle, position.speed, direction);
        Pattern { demand, step, commutations, short: false }
    }

    /// A duty of 0 leaves the bridge off: with the low side on, a turning motor would brake itself.
    fn command(&self, pattern: &Pattern, duty: Duty, rectification: Rectification) -> PwmCommand {
        let now = self.applied.duty.to_bits();
        let idle =
            matches!(pattern.demand, Demand::Off) || (duty.to_bits() == 0 && now == 0 && !pattern.short);
        let (step, commutations) =
            if idle { (Step::Coast, Commutations::NONE) } else { (pattern.step, pattern.commutations) };
        let (sample_at, sample_mode) = self.sampling(duty.to_bits());
        PwmCommand {
            duty: if matches!(pattern.demand, Demand::Off) { Duty::ZERO } else { duty },
            rectification,
            sample_at,
            sample_mode,
            step,
            commutations,
        }
    }

    /// A pulse that is long enough for a valid sample (parameter 272) is sampled in its middle, a shorter one after it has ended; down to an eighth below the
    /// limit the mode stays.
    #[inline]
    fn sampling(&self, duty: u16) -> (u16, SampleMode) {
        let on = match self.applied.sample_mode {
            SampleMode::OnTime => duty >= self.on_time.1,
            SampleMode::OffTime => duty >= self.on_time.0,
        };
        if on {
            (0, SampleMode::OnTime)
        } else {
            // The pulse ends at D/2 of the period: duty (1/32 768) is that many 1/65 536.
            (duty.saturating_add(self.coefficients.sample_settle), SampleMode::OffTime)
        }
    }
}

/// Shortest pulse that is sampled in its middle if parameter 272 allows less: 1 us at 10 kHz, raw U1F15.
const ON_TIME_LEAST: u16 = 327;
/// Where nothing depends on it the mode changes at 25 and 20 % duty, raw U1F15.
const ON_ABOVE: u16 = 32_768 / 4 + 1;
const OFF_BELOW: u16 = 32_768 / 5;
