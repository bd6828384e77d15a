//! The control tick: samples in, PWM command out, one straight line.

mod calm;
mod layout;
mod pattern;
mod reports;
mod signals;
mod transitions;

use super::coefficients::Coefficients;
use super::commutation::{Direction, Step};
use super::commutator::Commutator;
use super::control::{Control, Demand};
use super::event::{Event, HallCalibration, Health, SlowMeasurements};
use super::fault::Cause;
use super::hall::HallEvents;
use super::hall_calibration::HallCalibrator;
use super::machine::Machine;
use super::measurement::{Measured, Measurement};
use super::open_phase::OpenPhase;
use super::protection::{Evidence, Protection};
use super::pwm::PwmCommand;
use super::ramp::Ramp;
use super::rotor::Rotor;
use super::samples::Samples;
use super::sensorless::Sensorless;
use super::state::State;
use crate::units::{Amps, ElectricalSpeed};
use calm::{Calm, SHORTCUTS};
use core::borrow::Borrow;
pub use layout::{BEHAVIOUR_VERSION, LAYOUT_VERSION};
use pattern::Pattern;
use reports::Reports;
use serde::{Deserialize, Serialize};

/// The drive: everything that the control tick owns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self")]
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
    pub(super) const RATINGS: u32 = 0;
    pub(super) const SPEED_LOOP: u32 = 1;
    pub(super) const RAILS: u32 = 2;
    pub(super) const REPORT: u32 = 3;
    pub(super) const LAST: u32 = REPORT;
}

impl Drive {
    /// A drive at power-up with a parameter set that builds.
    #[inline(never)]
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

    /// What follows from state and coefficients, and is asked for in every tick. The terminals are listened to with the bridge off, too: they
    /// tell whether the rotor stands.
    fn settle(&mut self) {
        self.wake_halls();
        let listens = !self.machine.state().is_driving() || self.machine.is_sensorless();
        if listens && !self.listens {
            self.sensorless.begin_listening();
        }
        self.listens = listens;
        self.on_time = self.sampling_limits();
        self.settle_calm();
    }

    /// Takes one event; call before [`step`](Self::step), at most once a tick.
    pub fn handle_event(&mut self, event: impl Borrow<Event>) {
        self.heed(event.borrow());
    }

    /// By reference: an event is as large as the coefficients, and moving it takes longer than what most of them ask for.
    fn heed(&mut self, event: &Event) {
        // A drive is told again and again what it knows, and that it is well. Then what changes is the set-point or the temperature, which are
        // read once a millisecond, and no station need be woken.
        match *event {
            Event::Command(command) if self.machine.knows(command.request) => {
                return self.hear(command.speed);
            }
            Event::SetPoint(speed) => return self.hear(speed),
            Event::Slow(slow) if self.protection.stays_quiet_at(&self.coefficients.protection, &slow) => {
                self.slow = slow;
                return;
            }
            Event::Health(health) if health == self.health => return,
            _ => {}
        }
        self.wake();
        self.leave_lane();
        self.protection.wake();
        match event {
            Event::Command(command) => self.machine.handle_command(*command),
            Event::SetPoint(_) => {}
            Event::Coefficients(coefficients) => {
                self.rotor.change_wiring(&self.coefficients.hall, &coefficients.hall);
                self.coefficients = *coefficients;
                self.parameters_fit = true;
                self.settle();
            }
            Event::CoefficientsRejected => self.parameters_fit = false,
            Event::Slow(slow) => self.slow = *slow,
            Event::Health(health) => self.health = *health,
            Event::CalibrateHall(run) => self.machine.handle_calibration(*run),
        }
    }

    /// The master is there, and nothing is new but the set-point.
    #[inline]
    fn hear(&mut self, speed: ElectricalSpeed) {
        self.machine.handle_set_point(speed, self.calm.slept());
        self.rest_anew();
    }

    /// One control tick.
    pub fn step(&mut self, samples: &Samples) -> PwmCommand {
        let place = self.control.tick(&self.coefficients.control);
        let current = self.measurement.step(&self.coefficients.measurement, samples);
        if !SHORTCUTS {
            self.look(place, samples, current);
            return self.applied;
        }
        let in_lane = self.is_in_lane(current);
        let step = if self.is_calm(samples, current, in_lane) {
            Some(self.go_on(current))
        } else {
            self.turns(samples, current, in_lane)
        };
        match step {
            Some(step) => self.keep_on(step, place, samples, current, in_lane),
            None => self.look(place, samples, current),
        }
        self.applied
    }

    /// From what is wanted to what is applied, with what is due in this `place` of the millisecond before it.
    #[inline(never)]
    fn conclude(&mut self, place: u32, pattern: &Pattern, samples: &Samples, current: Amps) {
        let speed = match pattern.demand {
            Demand::Speed { measured, .. } => Some(measured),
            Demand::Off | Demand::Voltage { .. } => None,
        };
        self.do_due(place, speed, samples, current);
        let speeds = matches!(pattern.demand, Demand::Speed { fade: 0, .. });
        if SHORTCUTS && speeds && self.has_plain_voltage() && self.cruises(pattern.step, current) {
            self.applied.commutations = pattern.commutations;
        } else {
            self.finish(pattern, current);
        }
    }

    /// The loops with every limit.
    #[inline(never)]
    fn finish(&mut self, pattern: &Pattern, current: Amps) {
        self.sensorless.beware();
        self.leave_lane();
        let measured = &self.measurement.measured(current);
        let c = &self.coefficients;
        let (c, mode) = (&c.control, c.mode(self.machine.state()));
        let output = self.control.step(c, mode, pattern.demand, measured, &self.measurement);
        self.applied = self.command(pattern, output.duty, output.rectification);
    }

    /// The whole tick.
    #[inline(never)]
    fn look(&mut self, place: u32, samples: &Samples, current: Amps) {
        self.sensorless.beware();
        if matches!(self.machine.state(), State::Initialization | State::Standby) {
            self.measurement.find_zero(&self.coefficients.measurement, current);
        }
        let pattern = self.survey(samples, &self.measurement.measured(current));
        self.conclude(place, &pattern, samples, current);
    }

    /// Every station in turn, up to what is to be applied.
    #[inline]
    fn survey(&mut self, samples: &Samples, measured: &Measured) -> Pattern {
        self.wake();
        let taken = self.is_taken();
        let hall = if taken && !self.listens {
            HallEvents { sectors: self.machine.direction().sign() as i8, ..HallEvents::default() }
        } else {
            self.sense_halls(samples)
        };
        if self.listens && !taken {
            self.listen(samples, measured);
        }
        let critical = self.protect(samples, measured, hall);
        self.advance_state(critical, samples);
        let pattern = self.pattern(samples);
        self.count_commutation();
        self.open_phase.change(pattern.last());
        self.calm_down(samples, pattern.demand);
        if self.reports.stirred {
            self.find_change(samples);
        }
        pattern
    }

    #[inline(never)]
    fn listen(&mut self, samples: &Samples, measured: &Measured) {
        let bus_voltage = measured.bus_voltage.to_bits();
        let (c, torque) = (&self.coefficients.sensorless, self.machine.direction());
        self.sensorless.observe(c, samples, bus_voltage, &self.applied, torque);
        self.heed_speed();
    }

    /// The estimator's speed may have changed.
    #[inline(never)]
    fn heed_speed(&mut self) {
        self.heed_speed_now();
    }

    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn heed_speed_now(&mut self) {
        let turns = self.sensorless.speed(&self.coefficients.sensorless);
        if turns != self.sensorless_turns {
            self.sensorless_rate = self.coefficients.speed_of_turns.apply32(turns);
            self.sensorless_turns = turns;
        }
    }

    /// Does the work of the millisecond that falls into this tick. `speed` is that of a closed loop.
    #[cfg_attr(target_arch = "wasm32", inline(never))]
    #[cfg_attr(not(target_arch = "wasm32"), inline)]
    fn do_due(&mut self, place: u32, speed: Option<i32>, samples: &Samples, current: Amps) {
        if place > place::LAST {
            return;
        }
        if u32::from(self.coefficients.control.ticks_per_ms) <= place::LAST {
            return self.share_out(place, speed, samples, current);
        }
        self.do_task(place, speed, samples, current);
    }

    /// A board with fewer ticks does more in its last.
    #[inline(never)]
    fn share_out(&mut self, place: u32, speed: Option<i32>, samples: &Samples, current: Amps) {
        let is_last = place + 1 >= u32::from(self.coefficients.control.ticks_per_ms);
        let end = if is_last { place::LAST } else { place };
        for task in place..=end {
            self.do_task(task, speed, samples, current);
        }
    }

    #[inline]
    fn do_task(&mut self, task: u32, speed: Option<i32>, samples: &Samples, current: Amps) {
        match task {
            place::RATINGS => self.rate(speed != Some(0)),
            place::SPEED_LOOP => {
                if let Some(speed) = speed {
                    self.run_speed_loop(speed, current);
                }
            }
            place::RAILS => {
                if self.listens {
                    self.check_rails();
                }
            }
            _ => {
                self.make_due(samples);
                self.renew_lane();
            }
        }
    }

    /// `turns`: the rotor is not known to stand.
    #[inline(never)]
    fn rate(&mut self, turns: bool) {
        let temperature = self.slow.temperature;
        if self.control.rate(&self.coefficients.control, &self.measurement, temperature, turns) {
            self.leave_lane();
        }
    }

    #[inline(never)]
    fn run_speed_loop(&mut self, speed: i32, current: Amps) {
        let c = &self.coefficients;
        let mode = c.mode(self.machine.state());
        // A rotor that is found late, or has leapt ahead, comes to the ramp of open loop at twice its rate.
        let rises = self.machine.state() == State::OpenLoop && !self.sensorless.is_caught();
        let (wanted, rate) = if rises {
            let age = self.machine.age().saturating_add(self.calm.slept());
            let rate = c.open_loop.rate.saturating_mul(2 * i64::from(c.control.ticks_per_ms));
            (c.open_loop.setpoint(age), rate)
        } else {
            let commanded = self.machine.command().speed.to_bits();
            (commanded.min(mode.speed_max).max(mode.speed_min), c.control.speed_rate)
        };
        let target = if self.machine.reversing() { 0 } else { wanted };
        let bus = (self.measurement.bus_voltage(), current.to_bits());
        self.control.turn(&c.control, mode, (target, rate), speed, bus);
        self.keep_lane();
    }

    /// Volts of a level that is a share of the bus voltage or, with a nominal supply (parameter 266), volts already; raw I16F16.
    #[inline]
    fn volts(&self, level: i32) -> i32 {
        if self.coefficients.control.levels_of_bus {
            ((i64::from(self.measurement.bus_voltage()) * i64::from(level)) >> 16) as i32
        } else {
            level
        }
    }

    /// This tick's commutation tells where the rotor is.
    #[inline]
    fn count_commutation(&mut self) {
        let backward = self.machine.direction() == Direction::Reverse;
        self.rotor.count_commutation(self.commutator.sector(), backward);
    }

    #[inline(never)]
    fn check_rails(&mut self) {
        let c = &self.coefficients;
        if self.machine.state().is_driving() {
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
        let speed = if driving { self.speed() } else { 0 };
        let quiet = !sensors
            && !open_phase
            && self.sensorless.fault().is_none()
            && self.is_quiet(samples, measured.bus_current, speed);
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
            sensorless: self.sensorless_fault(),
        };
        self.reports.stirred = true;
        self.protection.step(&self.coefficients.protection, &evidence)
    }

    /// What ended too many episodes. Once the bridge is off that is over, and the next start begins with an empty bucket.
    fn sensorless_fault(&self) -> Option<Cause> {
        let driven = self.machine.state().is_driving() && self.machine.is_sensorless();
        if driven { self.sensorless.fault() } else { None }
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

    /// Signed, raw I16F16 electrical rev/s.
    #[inline]
    const fn sensorless_speed(&self) -> i32 {
        self.sensorless_rate
    }

    /// The same in the direction of torque.
    #[inline]
    fn sensorless_forward(&self) -> i32 {
        self.machine.direction().signed(self.sensorless_rate).max(0)
    }
}
