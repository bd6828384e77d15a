//! The control tick: samples in, PWM command out, one road.
//!
//! Most ticks ask no station. A station that was asked answers with its next *deadline*, the tick by which it
//! has to be asked again although its inputs stay the same, and with the *band* of inputs within which it
//! would answer the same.
//!
//! The law: before its deadline and within its bands, asking a station changes nothing. So a deadline may be
//! early and a band narrow, but never late or wide. From the law follows:
//!
//! * Stations keep instants and not counters, unless they are due in every tick while the counter counts.
//! * Whoever changes an input of a station behind its back makes it due: [`Drive::wake`] for all of them, and
//!   `choose_next` and `watch_next` for the pattern and the state machine.
//! * At the end of a tick `due` is no later than any station's deadline.
//!
//! The hall calibration alone counts its ticks, so `steers` holds while it runs.
//!
//! A new station needs: a deadline in `deadline`, a line in `wake`, a guard in `ask`, and a band in `quiet`
//! if its inputs are samples. A check that may wait for a millisecond is simpler: it is a line of a task
//! (`tasks.rs`).

mod layout;
mod pattern;
mod quiet;
mod reports;
mod signals;
mod tasks;
mod transitions;

use super::band::Band;
use super::clock::Instant;
use super::coefficients::Coefficients;
use super::commutate::commutation::{Direction, Step};
use super::commutate::commutator::Commutator;
use super::commutate::pulses::Pulses;
use super::commutate::pwm::{Commutations, PwmCommand};
use super::control::{Control, Demand};
use super::guard::open_phase::OpenPhase;
use super::guard::protection::{Evidence, Protection};
use super::machine::Machine;
use super::machine::event::{Command, Event, HallCalibration, Health, SlowMeasurements};
use super::machine::state::State;
use super::modes::{HALL, OTHER_SOURCE};
use super::ramp::Ramp;
use super::rotor::hall::HallEvents;
use super::rotor::hall_calibration::HallCalibrator;
use super::rotor::{Rotor, Source};
use super::sense::measurement::Measurement;
use super::sense::samples::{SampleMode, Samples};
use crate::units::{Amps, ElectricalSpeed};
use core::borrow::Borrow;
pub use layout::{BEHAVIOUR_VERSION, LAYOUT_VERSION};
use pattern::{Pattern, sampling_limits};
use quiet::Quiet;
use reports::Reports;
use serde::{Deserialize, Serialize};
use tasks::Tasks;

/// The drive: everything that the control tick owns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    coefficients: Coefficients,
    /// Ticks since power-up.
    now: Instant,
    /// The earliest deadline: the tick in which the stations are asked, whatever the samples say.
    due: Instant,
    /// The deadline of the pattern: the next commutation, or the next move of a start without sensors.
    pattern_due: Instant,
    /// Samples that concern no station.
    quiet: Quiet,
    /// For now the state machine is asked in every tick, and the fault logic if `has_fault`: a fault of the
    /// rotor or an open phase is present, the rotor of a closed loop may stand, or its hall sensors are mute.
    watchful: bool,
    /// For now the pattern is chosen anew in every tick: a hall calibration, or sensors in doubt.
    steers: bool,
    /// The demand or the step has changed within this tick, so `watchful` and `steers` may no longer hold.
    stale: bool,
    /// The last tick that asked the stations.
    asked: Instant,
    parameters_fit: bool,
    slow: SlowMeasurements,
    health: Health,
    measurement: Measurement,
    rotor: Rotor,
    protection: Protection,
    open_phase: OpenPhase,
    machine: Machine,
    control: Control,
    commutator: Commutator,
    pulses: Pulses,
    lock: Ramp,
    calibrator: HallCalibrator,
    calibration: HallCalibration,
    /// Pulse from which the on-time is sampled, and below which the off-time is, raw U1F15.
    on_time: (u16, u16),
    tasks: Tasks,
    /// The demand and step that are repeated until the stations are asked again.
    pattern: Pattern,
    /// The command of the last tick.
    applied: PwmCommand,
    reports: Reports,
}

impl Drive {
    /// A drive at power-up with a parameter set that builds.
    #[inline(never)]
    pub fn new(coefficients: Coefficients) -> Self {
        Self {
            now: Instant::default(),
            due: Instant::default(),
            pattern_due: Instant::default(),
            quiet: Quiet::default(),
            watchful: true,
            steers: false,
            stale: true,
            asked: Instant::default(),
            parameters_fit: true,
            slow: SlowMeasurements::default(),
            health: Health::default(),
            measurement: Measurement::default(),
            rotor: Rotor::default(),
            protection: Protection::default(),
            open_phase: OpenPhase::default(),
            machine: Machine::default(),
            control: Control::default(),
            commutator: Commutator::default(),
            pulses: Pulses::default(),
            lock: Ramp::default(),
            calibrator: HallCalibrator::default(),
            calibration: HallCalibration::None,
            on_time: sampling_limits(Source::Both, &coefficients),
            tasks: Tasks::default(),
            pattern: Pattern::OFF,
            applied: PwmCommand::default(),
            reports: Reports::default(),
            coefficients,
        }
    }

    /// After a change of state (and after `enter`) or of the coefficients: the source of the rotor, and what
    /// depends on both alone.
    fn refresh(&mut self) {
        let halls = self.machine.state() == State::HallClosedLoop;
        let accompanied = OTHER_SOURCE && halls && self.coefficients.machine.other_source;
        self.rotor.follow(self.now, self.source(), accompanied);
        let watched = if accompanied { Source::Terminals } else { self.rotor.source() };
        self.on_time = sampling_limits(watched, &self.coefficients);
        self.control.decide_anew();
    }

    /// The source of the rotor's position. With the bridge off the terminals are observed, too: they tell
    /// whether it stands.
    fn source(&self) -> Source {
        match self.machine.state() {
            state if !state.is_driving() => Source::Both,
            State::HallClosedLoop if HALL => Source::Halls,
            _ if self.machine.is_sensorless() => Source::Terminals,
            _ if self.machine.calibrating() => Source::Halls,
            _ => Source::Field,
        }
    }

    /// Takes one event; call before [`step`](Self::step).
    pub fn handle_event(&mut self, event: impl Borrow<Event>) {
        self.take_event(event.borrow());
    }

    /// By reference: an event is as large as the coefficients, and moving it takes longer than what most of
    /// them ask for.
    fn take_event(&mut self, event: &Event) {
        match event {
            Event::Command(command) => self.handle_command(*command),
            Event::SetPoint(speed) => self.handle_set_point(*speed),
            Event::Coefficients(coefficients) => self.change_coefficients(coefficients),
            Event::CoefficientsRejected => {
                self.parameters_fit = false;
                self.wake();
            }
            Event::Slow(slow) => self.handle_slow(*slow),
            Event::Health(health) => {
                if *health != self.health {
                    self.health = *health;
                    self.wake();
                }
            }
            Event::CalibrateHall(run) => self.calibrate_hall(*run),
        }
    }

    /// Takes a command. Most repeat the last request: they wake nobody, and the set-point is read once a
    /// millisecond.
    pub fn handle_command(&mut self, command: Command) {
        if self.machine.knows(command.request) {
            self.machine.handle_set_point(self.now, command.speed);
        } else {
            self.machine.handle_command(self.now, command);
            self.wake();
        }
    }

    /// Takes a set-point magnitude; the request stays.
    pub const fn handle_set_point(&mut self, speed: ElectricalSpeed) {
        self.machine.handle_set_point(self.now, speed);
    }

    /// Takes slow measurements. Most say that all is well: they wake nobody.
    pub fn handle_slow(&mut self, slow: SlowMeasurements) {
        let is_calm = self.protection.stays_calm_at(&self.coefficients.protection, &slow);
        self.slow = slow;
        if !is_calm {
            self.wake();
        }
    }

    /// Takes other coefficients.
    pub fn change_coefficients(&mut self, coefficients: &Coefficients) {
        self.rotor.change_wiring(self.now, &self.coefficients.hall, &coefficients.hall);
        self.coefficients = *coefficients;
        self.parameters_fit = true;
        self.refresh();
        self.wake();
    }

    /// The next start runs the hall calibration instead of the control mode (true), or not (false).
    pub fn calibrate_hall(&mut self, run: bool) {
        self.machine.handle_calibration(run);
        self.wake();
    }

    /// Makes everything due: the next tick asks every station and every limit. By the law of the tick this
    /// changes no answer.
    #[inline(never)]
    pub fn wake(&mut self) {
        let now = self.now;
        (self.due, self.pattern_due) = (now, now);
        (self.watchful, self.steers) = (true, true);
        self.rotor.wake(now);
        self.protection.wake(now);
        self.machine.wake(now);
        self.control.decide_anew();
    }

    /// The next tick chooses the pattern anew.
    const fn choose_next(&mut self) {
        (self.due, self.pattern_due) = (self.now, self.now);
    }

    /// The next tick asks the state machine, and the fault logic if the rotor shows a fault.
    const fn watch_next(&mut self) {
        (self.due, self.watchful) = (self.now, true);
    }

    /// One control tick.
    pub fn step(&mut self, samples: &Samples) -> PwmCommand {
        self.now = self.now.next();
        let current = self.measurement.step(&self.coefficients.measurement, samples);
        let sensed = self.sense_terminals(samples);
        self.open_phase.count(current);
        let rests = !sensed && self.is_quiet(samples, current) && !self.due.is_due(self.now);
        let busy = if rests {
            self.go_on();
            false
        } else {
            self.ask(samples, current, sensed)
        };
        if self.tasks.are_due(self.now) {
            self.do_task(busy, samples, current);
        }
        self.apply(current);
        self.applied
    }

    /// The terminals: true if the estimate of the rotor has changed.
    #[inline]
    fn sense_terminals(&mut self, samples: &Samples) -> bool {
        let (c, bus, torque) = (&self.coefficients, self.measurement.bus_voltage(), self.machine.direction());
        self.rotor.sense_terminals(c, self.now, samples, bus, &self.applied, torque)
    }

    /// Asks the stations in turn, each if its deadline has come or something new concerns it. It ends with
    /// the pattern of this period and the next deadline. True if the tick brought an edge, a crossing, a
    /// commutation or another state.
    #[inline(never)]
    fn ask(&mut self, samples: &Samples, current: Amps, sensed: bool) -> bool {
        let now = self.now;
        self.asked = now;
        let hall = self.sense_halls(samples);
        let turned = hall.sectors != 0 || sensed;
        let irregular = self.is_irregular(hall);
        if OTHER_SOURCE {
            self.compare_sources(irregular);
        }
        let concerns_faults = self.protection.due().is_due(now)
            || !self.is_electrically_quiet(samples, current)
            || irregular
            || (turned && self.overspeeds())
            || (self.watchful && self.has_fault());
        if concerns_faults {
            self.judge(samples, current, hall);
        }
        let critical = self.protection.is_critical();
        let moved = (critical || self.watchful || self.machine.due().is_due(now))
            && self.advance_state(critical, samples);
        if turned || moved || self.steers || self.pattern_due.is_due(now) {
            self.choose_pattern(samples);
        } else {
            self.go_on();
        }
        if self.reports.stirred {
            self.find_change(samples);
        }
        if concerns_faults || moved || self.watchful || self.stale {
            self.look_ahead();
        }
        self.rotor.note(&self.applied);
        self.due = self.deadline();
        turned || moved || !self.applied.commutations.is_empty()
    }

    /// The hall sensors, if they show anything or their deadline has come.
    #[inline]
    fn sense_halls(&mut self, samples: &Samples) -> HallEvents {
        let mute = HALL && self.watchful && self.rotor.is_mute();
        if !(mute || !self.quiet.repeats(samples) || self.rotor.hall.due().is_due(self.now)) {
            return HallEvents::default();
        }
        self.quiet.hall = samples.hall;
        let events = self.rotor.sense_halls(&self.coefficients, self.now, samples);
        if self.rotor.is_mute() {
            // From here on the commutation counts the sectors, and it does so only where the pattern is
            // chosen.
            self.pattern_due = self.now;
        }
        if events.sectors == 0 && self.machine.state() == State::HallClosedLoop {
            // The sensors were asked and no sector has passed: a code was lost, there is a doubt, or a
            // deadline has come.
            (self.pattern_due, self.watchful) = (self.now, true);
        }
        events
    }

    /// Decides whether the state machine, or the pattern, has to be asked in every tick from now on.
    #[inline(never)]
    fn look_ahead(&mut self) {
        let state = self.machine.state();
        let halls = state == State::HallClosedLoop;
        self.watchful = self.open_phase.is_found()
            || self.rotor.fault().is_some()
            || ((halls || state == State::SensorlessClosedLoop) && self.rotor.may_stand())
            || (halls && self.rotor.is_mute());
        let idles = self.machine.calibrating() || (halls && matches!(self.pattern.demand, Demand::Off));
        self.steers = state.is_driving() && idles;
        self.stale = false;
    }

    /// Repeats the present step, without a commutation.
    #[inline]
    fn go_on(&mut self) {
        (self.applied.step, self.applied.commutations) = (self.pattern.step, Commutations::NONE);
    }

    /// Chooses what the state wants, and the commutations of this period.
    #[inline]
    fn choose_pattern(&mut self, samples: &Samples) {
        self.pattern_due = self.now.after(u32::MAX);
        if let Some(rotor) = self.choose_demand(samples) {
            let (c, torque) = (&self.coefficients.commutator, self.machine.direction());
            let (step, commutations) = self.commutator.step(c, rotor.angle, rotor.speed, torque);
            (self.applied.step, self.applied.commutations) = (step, commutations);
            self.pattern.step = self.commutator.present();
            self.pattern_due = self.pattern_due.earlier(self.now.after(self.commutator.ticks_left()));
            self.count_commutation();
        } else {
            self.go_on();
        }
        if self.open_phase.change(self.pattern.step) {
            self.stale = true;
        }
    }

    /// Duty and sampling of the next period.
    #[inline]
    fn apply(&mut self, current: Amps) {
        if self.control.repeat_decision(&self.coefficients.control, current, &self.measurement) {
            let duty = self.control.output().duty;
            self.applied.duty = duty;
            if self.applied.sample_mode == SampleMode::OffTime {
                self.applied.sample_at = self.after_pulse(duty.to_bits());
            }
        } else {
            self.decide(current);
        }
    }

    /// The full decision, with every limit.
    #[inline(never)]
    fn decide(&mut self, current: Amps) {
        let speed = self.speed_forward();
        let (c, demand) = (&self.coefficients, self.pattern.demand);
        let mode = c.mode(self.machine.state());
        let measured = self.measurement.measured(current);
        self.control.decide(&c.control, mode, demand, speed, &measured, &self.measurement);
        let output = self.control.output();
        self.command(output);
        self.rotor.note(&self.applied);
        let (duties, bus) = (self.duties_sampled_alike(), self.measurement.bus_voltage());
        let c = &self.coefficients;
        self.control.find_steady(&c.control, c.mode(self.machine.state()), demand, bus, duties);
    }

    /// Duties that are sampled in the same mode as the last one, raw U1F15.
    fn duties_sampled_alike(&self) -> Band {
        let (begins, lasts) = self.on_time;
        match self.applied.sample_mode {
            SampleMode::OnTime => Band::new(lasts.into(), i32::MAX - 1),
            SampleMode::OffTime => Band::new(0, i32::from(begins) - 1),
        }
    }

    /// Counts a commutation as a sector where the hall sensors show nothing.
    #[inline]
    fn count_commutation(&mut self) {
        let backward = self.machine.direction() == Direction::Reverse;
        self.rotor.count_commutation(self.commutator.sector(), backward);
    }

    /// The rotor shows a fault: an open phase, too many episodes that ended, or a stall of the hall sensors.
    /// The fault logic need not see them go: the first two cannot be masked, and a stall keeps it due.
    #[inline(never)]
    fn has_fault(&self) -> bool {
        self.has_open_phase()
            || self.rotor.fault().is_some()
            || (self.machine.state() == State::HallClosedLoop && self.rotor.may_stand())
    }

    /// In a calibration no phase is judged: its steps are too short.
    #[inline]
    fn has_open_phase(&self) -> bool {
        self.open_phase.is_found() && self.detects_open_phases()
    }

    #[inline]
    fn detects_open_phases(&self) -> bool {
        self.machine.state().is_driving() && !self.machine.calibrating()
    }

    /// The rotor has shown that it turns too fast.
    #[inline]
    fn overspeeds(&self) -> bool {
        self.rotor.turns().unsigned_abs() > self.quiet.overspeed && self.machine.state().is_driving()
    }

    /// The fault logic must see these events of the hall sensors: all but a plain edge forward.
    #[inline]
    fn is_irregular(&self, hall: HallEvents) -> bool {
        if !hall.happened() || self.machine.state() != State::HallClosedLoop {
            return false;
        }
        let forward =
            i32::from(hall.sectors) == self.machine.direction().sign() && self.protection.goes_forward();
        hall.invalid || hall.jump || !forward
    }

    #[inline(never)]
    fn judge(&mut self, samples: &Samples, current: Amps, hall: HallEvents) {
        let state = self.machine.state();
        let evidence = Evidence {
            measured: self.measurement.measured(current),
            slow: self.slow,
            lines: samples.lines,
            health: self.health,
            request: self.machine.command().request,
            hall,
            hall_stopped: self.rotor.hall.stopped(),
            speed: self.speed().saturating_abs(),
            hall_driving: state == State::HallClosedLoop,
            driving: state.is_driving() || self.machine.starting(),
            torque: self.applied.step != Step::Coast,
            torque_sign: self.machine.direction().sign() as i8,
            open_phase: self.has_open_phase(),
            sensorless: self.rotor.fault(),
        };
        let before = self.protection.word();
        let c = &self.coefficients.protection;
        self.protection.step(c, self.now, &evidence);
        self.quiet.stay_within(&self.protection, c, samples.lines);
        self.reports.stirred |= self.protection.word() != before;
        let overspeed = self.protection.overspeed_trip();
        self.quiet.overspeed = self.coefficients.open_loop.turns.apply32(overspeed).unsigned_abs();
    }

    /// Speed by whom shows the rotor, signed, raw I16F16 electrical rev/s.
    #[inline]
    fn speed(&self) -> i32 {
        self.rotor.speed(&self.coefficients, self.now)
    }

    /// [`speed`](Self::speed) counted in the direction of torque, 0 if the rotor turns backward.
    #[inline]
    fn speed_forward(&self) -> i32 {
        self.machine.direction().signed(self.speed()).max(0)
    }
}
