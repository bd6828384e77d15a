//! The control tick: samples in, PWM command out, one road.

mod layout;
mod pattern;
mod reports;
mod rest;
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
use super::measurement::Measurement;
use super::open_phase::OpenPhase;
use super::protection::{Evidence, Protection};
use super::pwm::{Commutations, PwmCommand};
use super::ramp::Ramp;
use super::rotor::Rotor;
use super::samples::Samples;
use super::sensorless::Sensorless;
use super::state::State;
use crate::units::Amps;
use core::borrow::Borrow;
pub use layout::{BEHAVIOUR_VERSION, LAYOUT_VERSION};
use pattern::Pattern;
use reports::Reports;
use rest::Rest;
use serde::{Deserialize, Serialize};

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
    rest: Rest,
    /// What goes on until the stations are asked again.
    pattern: Pattern,
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
            rest: Rest::default(),
            pattern: Pattern::OFF,
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
        let listens = !self.machine.state().is_driving() || self.machine.is_sensorless();
        if listens && !self.listens {
            self.sensorless.begin_listening();
        }
        self.listens = listens;
        self.on_time = self.sampling_limits();
        self.control.beware();
        self.rest.stay_within(&self.coefficients.protection, self.machine.state());
    }

    /// Takes one event; call before [`step`](Self::step), at most once a tick.
    pub fn handle_event(&mut self, event: impl Borrow<Event>) {
        self.heed(event.borrow());
    }

    /// By reference: an event is as large as the coefficients, and moving it takes longer than what most of them ask for.
    fn heed(&mut self, event: &Event) {
        self.pass_time();
        self.rest.end();
        // A drive is told again and again what it knows, and that it is well: then the fault logic sleeps on.
        let news = match event {
            Event::Command(command) => !self.machine.knows(command.request),
            Event::SetPoint(_) => false,
            Event::Slow(slow) => !self.protection.stays_quiet_at(&self.coefficients.protection, slow),
            Event::Health(health) => *health != self.health,
            Event::Coefficients(_) | Event::CoefficientsRejected | Event::CalibrateHall(_) => true,
        };
        if news {
            self.protection.wake();
            self.machine.wake();
        }
        match event {
            Event::Command(command) => self.machine.handle_command(*command),
            Event::SetPoint(speed) => self.machine.handle_set_point(*speed),
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

    /// The next tick asks every station and every limit, whether or not one has anything to do. A deadline may be early and never late, so this changes no
    /// answer.
    pub const fn wake(&mut self) {
        self.rest.end();
        self.control.beware();
    }

    /// One control tick.
    pub fn step(&mut self, samples: &Samples) -> PwmCommand {
        let place = self.control.tick(&self.coefficients.control);
        let current = self.measurement.step(&self.coefficients.measurement, samples);
        if matches!(self.machine.state(), State::Initialization | State::Standby) {
            self.measurement.find_zero(&self.coefficients.measurement, current);
        }
        let (step, commutations) = if self.rests(samples, current) {
            (self.pattern.step, Commutations::NONE)
        } else {
            self.ask(samples, current)
        };
        self.do_due(place, samples);
        self.apply(step, commutations, current);
        self.applied
    }

    /// The stations whose deadline has come, or that something new concerns, in turn, up to what is wanted: the step that this period begins with, and
    /// its commutations. The last of them goes on.
    #[inline(never)]
    fn ask(&mut self, samples: &Samples, current: Amps) -> (Step, Commutations) {
        self.pass_time();
        let hall = self.sense_halls(samples);
        let mut news = hall.is_some();
        if self.listens {
            news |= self.listen(samples);
        }
        news |= !self.is_closed_loop();
        let stands = self.stands();
        let critical = self.protect(samples, current, hall.unwrap_or_default(), (news, stands));
        let moved = self.advance_state(critical, stands, samples);
        let before = self.pattern.step;
        let mut wanted = (before, Commutations::NONE);
        if news || moved || self.commutator.is_due() {
            wanted = self.choose_pattern(samples);
        }
        if self.reports.stirred {
            self.find_change(samples);
        }
        self.rest.hall = samples.hall;
        let uneasy =
            moved || !self.protection.is_quiet() || self.open_phase.is_found(&self.coefficients.open_phase);
        self.rest.grant(if uneasy { 0 } else { self.due(stands) });
        wanted
    }

    /// The hall sensors, if their code is another or their deadline has come.
    #[inline]
    fn sense_halls(&mut self, samples: &Samples) -> Option<HallEvents> {
        let quiet = samples.hall == self.rest.hall
            && samples.edges.is_empty()
            && self.rotor.rest() > 0
            && (self.listens || !self.rotor.hall_mute());
        if quiet { None } else { Some(self.rotor.step(&self.coefficients, samples)) }
    }

    /// A closed loop whose rotor turns on as it does.
    #[inline]
    fn is_closed_loop(&self) -> bool {
        match self.machine.state() {
            State::HallClosedLoop => true,
            state => state.is_driving() && self.machine.is_sensorless() && self.sensorless.is_running(),
        }
    }

    #[inline]
    fn choose_pattern(&mut self, samples: &Samples) -> (Step, Commutations) {
        let (pattern, commutations) = self.pattern(samples);
        self.pattern = pattern;
        if let Some(last) = commutations.last() {
            self.pattern.step = last.step;
        }
        self.count_commutation();
        self.open_phase.change(self.pattern.step);
        (pattern.step, commutations)
    }

    /// From what is wanted to what is applied.
    #[inline]
    fn apply(&mut self, step: Step, commutations: Commutations, current: Amps) {
        let c = &self.coefficients;
        let mode = c.mode(self.machine.state());
        let output = self.control.step(&c.control, mode, self.pattern.demand, current, &self.measurement);
        self.applied = self.command(step, commutations, output.duty, output.rectification);
    }

    /// True if the terminals tell anything new.
    #[inline]
    fn listen(&mut self, samples: &Samples) -> bool {
        let news = self.sensorless.observe(&self.coefficients.sensorless, samples, &self.applied);
        self.heed_speed() || news
    }

    /// The estimator's speed may have changed: true if it has.
    #[inline]
    fn heed_speed(&mut self) -> bool {
        let turns = self.sensorless.speed(&self.coefficients.sensorless);
        let changed = turns != self.sensorless_turns;
        if changed {
            self.sensorless_rate = self.coefficients.speed_of_turns.apply32(turns);
            self.sensorless_turns = turns;
        }
        changed
    }

    /// What is done once a millisecond, spread over its ticks.
    #[inline]
    fn do_due(&mut self, place: u32, samples: &Samples) {
        if place > place::LAST {
            return;
        }
        // A board with fewer ticks does more in its last.
        let is_last = place + 1 >= u32::from(self.coefficients.control.ticks_per_ms);
        let end = if is_last { place::LAST } else { place };
        for task in place..=end {
            self.do_task(task, samples);
        }
    }

    #[inline(never)]
    fn do_task(&mut self, task: u32, samples: &Samples) {
        match task {
            place::RATINGS => self.rate(),
            place::SPEED_LOOP => self.run_speed_loop(),
            place::RAILS => self.check_rails(),
            _ => self.make_due(samples),
        }
    }

    fn rate(&mut self) {
        let stands = matches!(self.pattern.demand, Demand::Speed { measured: 0, .. });
        let temperature = self.slow.temperature;
        self.control.rate(&self.coefficients.control, &self.measurement, temperature, !stands);
    }

    fn run_speed_loop(&mut self) {
        let Demand::Speed { measured: speed, .. } = self.pattern.demand else { return };
        let c = &self.coefficients;
        let mode = c.mode(self.machine.state());
        // A rotor that is found late, or has leapt ahead, comes to the ramp of open loop at twice its rate.
        let rises = self.machine.state() == State::OpenLoop && !self.sensorless.is_caught();
        let (wanted, rate) = if rises {
            let age = self.machine.age().saturating_add(self.rest.passed());
            let rate = c.open_loop.rate.saturating_mul(2 * i64::from(c.control.ticks_per_ms));
            (c.open_loop.setpoint(age), rate)
        } else {
            let commanded = self.machine.command().speed.to_bits();
            (commanded.min(mode.speed_max).max(mode.speed_min), c.control.speed_rate)
        };
        let target = if self.machine.reversing() { 0 } else { wanted };
        self.control.turn(mode, (target, rate), speed, self.measurement.bus_voltage());
    }

    /// This tick's commutation tells where the rotor is.
    #[inline]
    fn count_commutation(&mut self) {
        let backward = self.machine.direction() == Direction::Reverse;
        self.rotor.count_commutation(self.commutator.sector(), backward);
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
                self.rest.end();
            }
        }
    }

    /// True when a critical fault is present now. `news`: a station has told something; `stands`: the rotor is not known to turn.
    #[inline]
    fn protect(
        &mut self,
        samples: &Samples,
        current: Amps,
        hall: HallEvents,
        (news, stands): (bool, bool),
    ) -> bool {
        let state = self.machine.state();
        let driving = state.is_driving();
        let mut stirs = !self.rest.allows(samples, self.measurement.bus_voltage())
            || current.abs().to_bits() > self.coefficients.protection.over_current.trip;
        let mut open_phase = false;
        if driving && !self.machine.calibrating() {
            self.open_phase.count(current);
            self.open_phase.rest(self.applied.step, self.applied.duty, current, stands);
            open_phase = self.open_phase.is_found(&self.coefficients.open_phase);
        }
        if news {
            let sensors = state == State::HallClosedLoop && self.minds(hall);
            let speed = if driving { self.speed() } else { 0 };
            stirs |= sensors || self.sensorless_fault().is_some() || !self.protection.stays_quiet(speed);
        }
        // Torque on a rotor that stands is counted tick by tick.
        let stalls = stands && state == State::HallClosedLoop;
        let noted = stirs || stalls || open_phase || !self.protection.is_quiet();
        noted && self.judge(samples, current, hall, open_phase)
    }

    /// The hall sensors' events are for the fault logic: everything but an edge forward.
    #[inline]
    fn minds(&self, hall: HallEvents) -> bool {
        let forward =
            i32::from(hall.sectors) == self.machine.direction().sign() && self.protection.goes_forward();
        hall.invalid || hall.jump || (hall.sectors != 0 && !forward)
    }

    #[inline(never)]
    fn judge(&mut self, samples: &Samples, current: Amps, hall: HallEvents, open_phase: bool) -> bool {
        let state = self.machine.state();
        let evidence = Evidence {
            measured: self.measurement.measured(current),
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
