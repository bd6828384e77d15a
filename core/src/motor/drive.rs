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
use super::protection::{Evidence, Protection};
use super::pwm::{Commutations, PwmCommand, Rectification};
use super::ramp::Ramp;
use super::rotor::Rotor;
use super::samples::{SampleMode, Samples};
use super::sensorless::{Plan, Sensorless};
use super::state::State;
use crate::units::{Amps, Duty, ElectricalAngle, ElectricalSpeed, Volts, Watts};
use serde::{Deserialize, Serialize};

/// Layout of the serialised [`Drive`] and of [`Event`]: changes with any field of theirs.
pub const LAYOUT_VERSION: u16 = 2;

/// What the drive does with its inputs: rises with every change that moves a digest.
pub const BEHAVIOUR_VERSION: u16 = 2;

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
    /// What was applied in the last tick.
    applied: PwmCommand,
    reported: Reported,
    status: Option<Status>,
}

/// What makes a status due: its age, and what changed since.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Reported {
    age: u16,
    state: State,
    faults: u32,
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
            applied: PwmCommand::default(),
            reported: Reported::default(),
            status: None,
        }
    }

    /// Takes one event; call before [`step`](Self::step), at most once a tick.
    pub fn handle_event(&mut self, event: Event) {
        match event {
            Event::Command(command) => self.machine.handle_command(command),
            Event::SetPoint(speed) => self.machine.handle_set_point(speed),
            Event::Coefficients(coefficients) => {
                self.rotor.change_wiring(&self.coefficients.hall, &coefficients.hall);
                self.coefficients = coefficients;
                self.parameters_fit = true;
            }
            Event::CoefficientsRejected => self.parameters_fit = false,
            Event::Slow(slow) => self.slow = slow,
            Event::Health(health) => self.health = health,
            Event::CalibrateHall(run) => self.machine.handle_calibration(run),
        }
    }

    /// One control tick.
    pub fn step(&mut self, samples: &Samples) -> PwmCommand {
        let idle = self.machine.state() == State::Initialization;
        let mut measured = self.measurement.step(&self.coefficients.measurement, samples, idle);
        let hall = self.rotor.step(&self.coefficients, samples);
        if self.listens() {
            let torque = self.machine.direction();
            measured.phase_voltage = self.coefficients.measurement.phase_voltage(samples);
            self.sensorless.observe(&self.coefficients.sensorless, samples, &measured, &self.applied, torque);
        }
        let critical = self.protect(samples, &measured, hall);
        self.advance_state(critical, samples);
        let pattern = self.pattern(samples);
        let output = self.control.step(
            &self.coefficients.control,
            pattern.demand,
            &measured,
            &self.measurement,
            self.slow.temperature,
        );
        self.applied = self.command(pattern, output.duty, output.rectification);
        self.report(samples, &measured);
        self.applied
    }

    /// The report of the last tick, if one is due: every millisecond, and when state or fault word change.
    pub fn poll_status(&mut self) -> Option<Status> {
        self.status.take()
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

    fn protect(&mut self, samples: &Samples, measured: &Measured, hall: HallEvents) -> bool {
        let state = self.machine.state();
        let driving = state.is_driving();
        let stopped = match state {
            State::HallClosedLoop => self.rotor.hall_stopped(&self.coefficients),
            _ => !(self.machine.is_sensorless() && self.sensorless.is_running()),
        };
        let open_phase = driving
            && !self.machine.calibrating()
            && self.open_phase.step(
                &self.coefficients.open_phase,
                self.applied.step,
                self.applied.duty,
                measured.bus_current,
                stopped,
            );
        let evidence = Evidence {
            measured: *measured,
            slow: self.slow,
            lines: samples.lines,
            health: self.health,
            request: self.machine.command().request,
            hall,
            hall_stopped: self.rotor.hall_stopped(&self.coefficients),
            speed: match state {
                State::HallClosedLoop => self.rotor.hall_speed().abs().to_bits(),
                _ if self.machine.is_sensorless() => self.sensorless_speed().saturating_abs(),
                _ => self.rotor.hall_speed().abs().to_bits(),
            },
            hall_driving: state == State::HallClosedLoop,
            driving: driving || self.machine.starting(),
            torque: self.applied.step != Step::Coast,
            torque_sign: self.machine.direction().sign() as i8,
            open_phase,
            sensorless: self.sensorless.fault(),
        };
        self.protection.step(&self.coefficients.protection, &evidence)
    }

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
        let inputs = Inputs {
            critical,
            unhealthy: self.health.self_test_failed || !self.health.store_faults.is_empty(),
            causes_gone: self.protection.causes_gone(),
            stopped,
            calibrated: matches!(self.calibration, HallCalibration::Done(_) | HallCalibration::Failed),
            parameters_fit: self.parameters_fit,
        };
        if let Some(change) = self.machine.step(&self.coefficients.machine, &inputs) {
            self.enter(change, samples);
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

    /// The back-EMF of a coasting motor is listened to before a start, too; a hall drive has no use for it.
    fn listens(&self) -> bool {
        let c = &self.coefficients.machine;
        if self.machine.state().is_driving() {
            self.machine.is_sensorless()
        } else {
            c.sensorless_enable && !c.hall_enable
        }
    }

    fn sensorless_speed(&self) -> i32 {
        self.coefficients.speed_of_turns.apply32(self.sensorless.speed(&self.coefficients.sensorless))
    }

    /// What the sequence from standstill to closed loop wants now.
    fn sensorless(&mut self) -> Pattern {
        let direction = self.machine.direction();
        let state = self.machine.state();
        let speed = self.sensorless_speed().saturating_mul(direction.sign()).max(0);
        let c = &self.coefficients;
        let current = self.control.phase_current();
        if self.control.is_millisecond() {
            self.sensorless.check(
                &c.sensorless,
                self.applied.step != Step::Coast,
                self.control.applied(),
                current,
                speed,
            );
        }
        // Nothing is brought up in a direction that is no longer wanted.
        if self.machine.reversing() && !self.sensorless.is_running() {
            return Pattern::OFF;
        }
        let plan = self.sensorless.step(&c.sensorless, state, direction);
        match self.sensorless.take_begun() {
            Some(true) => self.control.start(&c.control, speed),
            // A light rotor may have leapt beyond what is ever asked of it: the set-point does not.
            Some(false) => self.control.hand_over(speed.min(c.sensorless_mode.speed_max), 0),
            None => {}
        }
        let mode = &c.sensorless_mode;
        let demand = match plan {
            Plan::Coast => return Pattern::OFF,
            Plan::Short => {
                let demand = Demand::Voltage { voltage: 0, duty_max: 0 };
                return Pattern { short: true, ..Pattern::hold(demand, Step::LockA) };
            }
            Plan::Hold(step, voltage) => {
                return Pattern::hold(Demand::Voltage { voltage, duty_max: mode.duty_max }, step);
            }
            Plan::Level(voltage) => Demand::Voltage { voltage, duty_max: mode.duty_max },
            Plan::Speed(fade) => {
                let command = self.machine.command().speed.to_bits();
                let ramped = state == State::OpenLoop && !self.sensorless.is_caught();
                let wanted = if ramped { c.open_loop.speed } else { command };
                let wanted = wanted.min(mode.speed_max).max(mode.speed_min);
                let target = if self.machine.reversing() { 0 } else { wanted };
                Demand::Speed {
                    gains: mode.speed,
                    target,
                    measured: speed,
                    duty_max: mode.duty_max,
                    fade,
                    sparse: true,
                }
            }
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
        Pattern::hold(self.level(voltage), if second { HallCalibrator::LOCK } else { Step::LockB })
    }

    fn hall_calibration(&mut self, samples: &Samples) -> Pattern {
        let c = &self.coefficients.hall_calibration;
        let (step, calibration) = self.calibrator.step(c, samples.hall);
        self.calibration = calibration;
        Pattern::hold(self.level(c.voltage), step)
    }

    fn open_loop(&mut self) -> Pattern {
        let direction = self.machine.direction();
        let run = !self.machine.reversing();
        let field = self.rotor.step_open_loop(&self.coefficients, direction, run);
        let (step, commutations) =
            self.commutator.step(&self.coefficients.commutator, field.angle, field.speed, direction);
        Pattern { demand: self.level(field.voltage), step, commutations, short: false }
    }

    fn level(&self, voltage: i32) -> Demand {
        Demand::Voltage { voltage, duty_max: self.coefficients.hall_mode.duty_max }
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
        let wanted = self.machine.command().speed.to_bits().min(mode.speed_max).max(mode.speed_min);
        let target = if self.machine.reversing() { 0 } else { wanted };
        let position = self.rotor.hall_position();
        let (step, commutations) =
            self.commutator.step(&self.coefficients.commutator, position.angle, position.speed, direction);
        let demand = Demand::Speed {
            gains: mode.speed,
            target,
            measured: speed.max(0),
            duty_max: mode.duty_max,
            fade: 0,
            sparse: false,
        };
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
            if self.listens() { (shortest, shortest - shortest / 8) } else { (ON_ABOVE, OFF_BELOW) };
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

    fn report(&mut self, samples: &Samples, measured: &Measured) {
        self.reported.age = self.reported.age.saturating_add(1);
        let now = Reported {
            age: self.reported.age,
            state: self.machine.state(),
            faults: self.protection.word().bits(),
        };
        let changed = now.state != self.reported.state || now.faults != self.reported.faults;
        if changed || now.age >= self.coefficients.control.ticks_per_ms {
            self.reported = Reported { age: 0, ..now };
            self.status = Some(self.status_now(samples, measured));
        }
    }

    #[inline(never)]
    fn status_now(&self, samples: &Samples, measured: &Measured) -> Status {
        let c = &self.coefficients;
        let direction = self.machine.direction();
        let state = self.machine.state();
        let hall = self.rotor.hall_diagnostics();
        let power =
            (measured.bus_voltage.to_bits() as i64 * measured.bus_current_filtered.to_bits() as i64) >> 16;
        let closed = match state {
            State::HallClosedLoop => true,
            State::SensorlessClosedLoop | State::SensorlessAutoRestart => self.sensorless.is_running(),
            _ => false,
        };
        let setpoint = if closed { self.control.setpoint() } else { 0 };
        let sensorless = self.listens();
        let angle =
            if sensorless { self.sensorless.rotor().angle() } else { self.rotor.hall_position().angle };
        let (crossing, crossing_margin, crossings) = self.sensorless.why();
        Status {
            tick: samples.tick,
            state,
            faults: self.protection.word(),
            critical: self.protection.critical(),
            extended_code: self.protection.code(),
            command_expired: self.machine.command_expired(&c.machine),
            refusal: self.machine.refusal(),
            supply_low: measured.bus_voltage.to_bits() < c.protection.supply_low,
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
            bus_voltage: Volts::from_bits(measured.bus_voltage.to_bits()),
            bus_current: Amps::from_bits(measured.bus_current_filtered.to_bits()),
            power: Watts::from_bits(crate::units::saturate64(power)),
            phase_voltage: c.measurement.phase_voltage(samples),
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
