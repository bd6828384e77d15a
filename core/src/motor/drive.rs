//! The control tick: samples in, PWM command out, one straight line.

use super::coefficients::Coefficients;
use super::commutation::Step;
use super::commutator::Commutator;
use super::control::{Control, Demand};
use super::event::{Event, HallCalibration, Health, Limiter, SlowMeasurements, Status};
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
use crate::units::{Amps, Duty, ElectricalAngle, ElectricalSpeed, Volts, Watts};
use serde::{Deserialize, Serialize};

/// Layout of the serialised [`Drive`] and of [`Event`]: changes with any field of theirs.
pub const LAYOUT_VERSION: u16 = 3;

/// What the drive does with its inputs: rises with every change that moves a digest.
pub const BEHAVIOUR_VERSION: u16 = 3;

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
    /// Speed by back-EMF, 2^-32 turn a tick, and the same as raw I16F16 electrical rev/s: converted when it changes.
    sensorless_turns: i32,
    sensorless_rate: i32,
    calm: Calm,
    /// What was applied in the last tick.
    applied: PwmCommand,
    reports: Reports,
}

/// What goes on by itself. Most ticks of a running motor lie between two edges, or crossings, and two commands: nothing but the loops has to
/// be looked at, and the whole tick before them knows how long that lasts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Calm {
    /// Ticks left of it, and those of it that have passed without the stations' knowledge.
    left: u32,
    slept: u32,
    /// The hall code that lasts.
    hall: u8,
    step: Step,
    /// Estimated speed in the direction of torque, raw I16F16 electrical rev/s, and what the voltage fades by.
    speed: i32,
    fade: u8,
}

/// When a status is due: every millisecond, and when state or fault word change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Reports {
    age: u16,
    state: State,
    faults: u32,
    /// Something happened that may have changed one of them.
    stirred: bool,
    due: bool,
    /// The tick that is to be reported, and its terminals.
    tick: u64,
    terminals: [u16; 3],
}

/// The places in a millisecond of what needs no tick of its own; a board with fewer ticks does more in its last.
mod place {
    pub(super) const RATINGS: u16 = 0;
    pub(super) const SPEED_LOOP: u16 = 1;
    pub(super) const RAILS: u16 = 2;
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
        let c = &self.coefficients.machine;
        self.listens = if self.machine.state().is_driving() {
            self.machine.is_sensorless()
        } else {
            c.sensorless_enable && !c.hall_enable
        };
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
        let pattern = if self.calm.left > 0 && self.is_calm(samples, &measured) {
            self.calm.left -= 1;
            self.calm.slept += 1;
            self.open_phase.count(measured.bus_current);
            let Calm { step, speed, fade, .. } = self.calm;
            Pattern::hold(Demand::Speed { measured: speed, fade }, step)
        } else {
            self.look(samples, &measured)
        };
        if place <= place::RAILS {
            self.rest_of_millisecond(place, pattern.demand, &measured);
        }
        let output = self.control.step(
            &self.coefficients.control,
            if self.listens { &self.coefficients.sensorless_mode } else { &self.coefficients.hall_mode },
            pattern.demand,
            &measured,
            &self.measurement,
        );
        self.applied = self.command(pattern, output.duty, output.rectification);
        self.report(samples);
        self.applied
    }

    /// Nothing that this tick measures asks for a look.
    #[inline]
    fn is_calm(&self, samples: &Samples, measured: &Measured) -> bool {
        let seen = Seen {
            bus_voltage: measured.bus_voltage.to_bits(),
            bus_current: measured.bus_current.to_bits(),
            speed: 0,
            lines: samples.lines,
        };
        samples.edges.is_empty()
            && samples.hall == self.calm.hall
            && self.protection.stays_quiet(&self.coefficients.protection, &seen)
    }

    /// The whole tick: every station in turn, up to what is to be applied.
    #[inline(never)]
    fn look(&mut self, samples: &Samples, measured: &Measured) -> Pattern {
        self.wake();
        let hall = self.rotor.step(&self.coefficients, samples);
        if self.listens {
            self.listen(samples, measured);
        }
        let critical = self.protect(samples, measured, hall);
        self.advance_state(critical, samples);
        let pattern = self.pattern(samples);
        self.open_phase.change(pattern.commutations.last().unwrap_or(pattern.step));
        self.calm_down(samples, &pattern);
        pattern
    }

    /// What the stations have not seen of a calm is told to them, and it is over.
    fn wake(&mut self) {
        let slept = core::mem::take(&mut self.calm.slept);
        self.calm.left = 0;
        if slept > 0 {
            self.rotor.sleep(slept);
            self.machine.sleep(slept);
        }
    }

    /// How long nothing but the loops has to be looked at.
    #[inline]
    fn calm_down(&mut self, samples: &Samples, pattern: &Pattern) {
        let c = &self.coefficients;
        let Demand::Speed { measured: speed, fade } = pattern.demand else { return };
        if self.machine.state() != State::HallClosedLoop
            || !self.protection.is_quiet()
            || self.rotor.hall_stopped(c)
            || self.open_phase.is_found(&c.open_phase)
        {
            return;
        }
        let position = self.rotor.hall_position();
        let left = self.commutator.calm(position.angle, position.speed);
        let left = left.min(self.rotor.calm(c)).min(self.machine.calm(&c.machine));
        let step = self.commutator.present();
        self.calm = Calm { left, slept: 0, hall: samples.hall, step, speed, fade };
    }

    /// The report of the last step, if one is due: every millisecond, and when state or fault word change.
    pub fn poll_status(&mut self) -> Option<Status> {
        if !core::mem::take(&mut self.reports.due) {
            return None;
        }
        let left = self.calm.left;
        self.wake();
        self.calm.left = left;
        Some(self.status())
    }

    /// What bounds the duty in the last tick.
    pub fn limiter(&self) -> Limiter {
        match self.control.output().limiter {
            Limiter::Return => Limiter::Return,
            _ if self.applied.step == Step::Coast => Limiter::Off,
            limiter => limiter,
        }
    }

    /// Exact state.
    pub const fn state(&self) -> State {
        self.machine.state()
    }

    #[inline(never)]
    fn listen(&mut self, samples: &Samples, measured: &Measured) {
        let mut measured = *measured;
        let torque = self.machine.direction();
        measured.phase_voltage = self.coefficients.measurement.phase_voltage(&samples.phase_voltage);
        self.sensorless.observe(&self.coefficients.sensorless, samples, &measured, &self.applied, torque);
        let turns = self.sensorless.speed(&self.coefficients.sensorless);
        if turns != self.sensorless_turns {
            self.sensorless_rate = self.coefficients.speed_of_turns.apply32(turns);
            self.sensorless_turns = turns;
        }
    }

    /// What is done once a millisecond, spread over its ticks.
    #[inline(never)]
    fn rest_of_millisecond(&mut self, place: u16, demand: Demand, measured: &Measured) {
        let c = &self.coefficients;
        let last = c.control.ticks_per_ms.max(1) - 1;
        let is = |task: u16| place == task.min(last);
        if is(place::RATINGS) {
            let turns = !matches!(demand, Demand::Speed { measured: 0, .. });
            self.control.rate(&c.control, measured, self.slow.temperature, turns);
        }
        if is(place::SPEED_LOOP)
            && let Demand::Speed { measured: speed, .. } = demand
        {
            let mode = if self.listens { &c.sensorless_mode } else { &c.hall_mode };
            let brought_up = self.machine.state() != State::OpenLoop || self.sensorless.is_caught();
            let wanted = if brought_up { self.machine.command().speed.to_bits() } else { c.open_loop.speed };
            let wanted = wanted.min(mode.speed_max).max(mode.speed_min);
            let target = if self.machine.reversing() { 0 } else { wanted };
            self.control.turn(&c.control, mode, target, speed, measured.bus_voltage.to_bits());
        }
        if is(place::RAILS) && self.listens && self.machine.state().is_driving() {
            let speed = self.sensorless_speed().saturating_mul(self.machine.direction().sign()).max(0);
            let driven = self.applied.step != Step::Coast;
            let applied = self.control.applied(&c.control, measured.bus_voltage.to_bits());
            self.sensorless.check(&c.sensorless, driven, applied, self.control.phase_current(), speed);
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
        let sensors = state == State::HallClosedLoop
            && (hall != HallEvents::default() || self.rotor.hall_stopped(&self.coefficients));
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
    fn sensorless_speed(&self) -> i32 {
        let turns = self.sensorless.speed(&self.coefficients.sensorless);
        if turns == self.sensorless_turns {
            self.sensorless_rate
        } else {
            self.coefficients.speed_of_turns.apply32(turns)
        }
    }

    /// What the sequence from standstill to closed loop wants now.
    fn sensorless(&mut self) -> Pattern {
        let direction = self.machine.direction();
        let state = self.machine.state();
        let speed = self.sensorless_speed().saturating_mul(direction.sign()).max(0);
        let c = &self.coefficients;
        // Nothing is brought up in a direction that is no longer wanted.
        if self.machine.reversing() && !self.sensorless.is_running() {
            return Pattern::OFF;
        }
        let plan = self.sensorless.step(&c.sensorless, state, direction);
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

    fn hall_closed_loop(&mut self) -> Pattern {
        let direction = self.machine.direction();
        let mode = &self.coefficients.hall_mode;
        let speed = self.rotor.hall_speed().to_bits().saturating_mul(direction.sign());
        // A rotor that turns the other way at speed is left to coast: torque now would brake it through the bridge,
        // where no current is measured. So is one whose sensors contradict themselves.
        if speed < -(mode.speed_min / 2) || self.rotor.hall_doubtful() {
            return Pattern::OFF;
        }
        let position = self.rotor.hall_position();
        let (step, commutations) =
            self.commutator.step(&self.coefficients.commutator, position.angle, position.speed, direction);
        let demand = Demand::Speed { measured: speed.max(0), fade: 0 };
        Pattern { demand, step, commutations, short: false }
    }

    /// A duty of 0 leaves the bridge off: with the low side on, a turning motor would brake itself.
    fn command(&self, pattern: Pattern, duty: Duty, rectification: Rectification) -> PwmCommand {
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
    fn sampling(&self, duty: u16) -> (u16, SampleMode) {
        let shortest = self.coefficients.control.duty_min.max(ON_TIME_LEAST);
        // Without an eye on back-EMF there is no need to go that far.
        let (above, below) =
            if self.listens { (shortest, shortest - shortest / 8) } else { (ON_ABOVE, OFF_BELOW) };
        let on = match self.applied.sample_mode {
            SampleMode::OnTime => duty >= below,
            SampleMode::OffTime => duty >= above,
        };
        if on {
            (0, SampleMode::OnTime)
        } else {
            // The pulse ends at D/2 of the period: duty (1/32 768) is that many 1/65 536.
            (duty.saturating_add(self.coefficients.sample_settle), SampleMode::OffTime)
        }
    }

    #[inline]
    fn report(&mut self, samples: &Samples) {
        self.reports.age = self.reports.age.saturating_add(1);
        if self.reports.stirred || self.reports.age >= self.coefficients.control.ticks_per_ms {
            self.find_due(samples);
        }
    }

    #[inline(never)]
    fn find_due(&mut self, samples: &Samples) {
        let (state, faults) = (self.machine.state(), self.protection.word().bits());
        let changed = state != self.reports.state || faults != self.reports.faults;
        self.reports.stirred = false;
        if changed || self.reports.age >= self.coefficients.control.ticks_per_ms {
            let (tick, terminals) = (samples.tick, samples.phase_voltage);
            self.reports = Reports { age: 0, state, faults, stirred: false, due: true, tick, terminals };
        }
    }

    fn status(&self) -> Status {
        let c = &self.coefficients;
        let direction = self.machine.direction();
        let state = self.machine.state();
        let hall = self.rotor.hall_diagnostics();
        let (voltage, current) = (self.measurement.bus_voltage(), self.measurement.bus_current());
        let power = (i64::from(voltage) * i64::from(current)) >> 16;
        let closed = match state {
            State::HallClosedLoop => true,
            State::SensorlessClosedLoop | State::SensorlessAutoRestart => self.sensorless.is_running(),
            _ => false,
        };
        let setpoint = if closed { self.control.setpoint() } else { 0 };
        let sensorless = self.listens;
        let angle =
            if sensorless { self.sensorless.rotor().angle() } else { self.rotor.hall_position().angle };
        let (crossing, crossing_margin, crossings) = self.sensorless.why();
        Status {
            tick: self.reports.tick,
            state,
            faults: self.protection.word(),
            critical: self.protection.critical(),
            extended_code: self.protection.code(),
            command_expired: self.machine.command_expired(&c.machine),
            refusal: self.machine.refusal(),
            supply_low: voltage < c.protection.supply_low,
            direction,
            setpoint: ElectricalSpeed::from_bits(setpoint.saturating_mul(direction.sign())),
            speed_hall: self.rotor.hall_speed(),
            speed_sensorless: ElectricalSpeed::from_bits(if sensorless {
                self.sensorless_speed()
            } else {
                0
            }),
            angle: ElectricalAngle((angle >> 16) as u16),
            sectors: self.rotor.sectors(),
            bus_voltage: Volts::from_bits(voltage),
            bus_current: Amps::from_bits(current),
            power: Watts::from_bits(crate::units::saturate64(power)),
            phase_voltage: c.measurement.phase_voltage(&self.reports.terminals),
            duty: self.applied.duty,
            limiter: self.limiter(),
            hall_invalid: hall.invalid,
            hall_jumps: hall.jumps,
            hall_calibration: self.calibration,
            crossing,
            crossing_margin,
            crossings,
        }
    }
}

/// Shortest pulse that is sampled in its middle if parameter 272 allows less: 1 us at 10 kHz, raw U1F15.
const ON_TIME_LEAST: u16 = 327;
/// Where nothing depends on it the mode changes at 25 and 20 % duty, raw U1F15.
const ON_ABOVE: u16 = 32_768 / 4 + 1;
const OFF_BELOW: u16 = 32_768 / 5;
