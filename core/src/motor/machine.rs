//! The state machine's memory around the transition table: time in the state, the fresh start request, the
//! modes sampled at the start, direction, acknowledgement.

pub mod event;
pub mod state;

use super::clock::Instant;
use super::commutate::commutation::Direction;
use super::machine::state::{Conditions, State, Transition, transition};
use super::modes::{HALL_CALIBRATION, SENSORLESS};
use crate::units::ElectricalSpeed;
use serde::{Deserialize, Serialize};

/// Command of the master.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Command {
    /// Motor mode of the request word.
    pub request: RunRequest,
    /// Magnitude of the speed set-point. The drive clamps it to the saturation of its control mode.
    pub speed: ElectricalSpeed,
}

/// Requested motor mode: REQUEST_WORD, bits 0 to 3 (Table 8).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum RunRequest {
    /// 0: PWM off.
    #[default]
    Standby,
    /// 1: run forward.
    Drive,
    /// 2: run in reverse.
    Reverse,
    /// 3: commanded shutdown, fault bit 28.
    Shutdown,
}

/// Reason why a Drive request did not start the motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Refusal {
    /// It was not refused.
    #[default]
    None = 0,
    /// All three control modes are disabled (Table 6).
    NoMode = 1,
    /// The parameter set does not build.
    Parameters = 2,
    /// Standby was not requested since the last stop, fault or reset.
    NoFreshRequest = 4,
}

/// Coefficients of the state machine. Durations are in ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct MachineCoefficients {
    /// Open loop may run the motor (Table 6).
    pub open_loop_enable: bool,
    /// The sensorless loop may run the motor (Table 6).
    pub sensorless_enable: bool,
    /// The hall loop may run the motor (Table 6), before the others.
    pub hall_enable: bool,
    /// Boot-up time (T01): 0.5 s.
    pub boot: u32,
    /// Rotor lock (T23).
    pub lock: u32,
    /// Rotor lock level (parameter 89).
    pub lock_level: i32,
    /// Its rise a millisecond with 16 extra bits: a quarter of the lock.
    pub lock_rate: i64,
    /// Open loop before sensorless (T34).
    pub open_loop: u32,
    /// Auto-restart time (T71, T74): 2 s.
    pub auto_restart: u32,
    /// Wait before a fault can be acknowledged (T61).
    pub fault_wait: u32,
    /// Command time-out.
    pub command_timeout: u32,
    /// A closed loop goes on by the other one's source where its own fails (parameter 308); both are enabled.
    pub other_source: bool,
}

/// Inputs of the machine in one tick.
#[derive(Clone, Copy, Debug)]
pub struct Inputs {
    /// A critical fault is present.
    pub critical: bool,
    /// Self-tests or store failed.
    pub unhealthy: bool,
    /// None of the latched faults' causes is present.
    pub causes_gone: bool,
    /// Estimated speed is 0, as the running mode judges it.
    pub stopped: bool,
    /// The calibration has a result.
    pub calibrated: bool,
    /// The present parameter set builds.
    pub parameters_fit: bool,
}

/// A change of state.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    /// The row of the table.
    pub row: &'static Transition,
    /// It fired because of the command time-out.
    pub timed_out: bool,
}

/// State of the state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    state: State,
    /// The tick as of which the ages are.
    at: Instant,
    /// Ticks in this state, saturating.
    age: u32,
    command: Command,
    /// Ticks since the last valid command, saturating; saturated at boot: no master yet.
    command_age: u32,
    /// Time at which a row of the table may hold by time alone.
    due: Instant,
    /// A Drive request would be a fresh edge.
    armed: bool,
    /// Standby was requested since the fault.
    acknowledged: bool,
    direction: Direction,
    /// HALL, SENSORLESS, OPEN_LOOP and CALIBRATION as sampled when leaving Standby.
    mode: Conditions,
    /// This start is a sensorless one.
    sensorless: bool,
    /// The next start runs the hall calibration.
    calibrate: bool,
    refusal: Refusal,
    /// The rotor's other source may go on.
    other_source: bool,
}

impl Default for Machine {
    fn default() -> Self {
        Self {
            state: State::Initialization,
            at: Instant::default(),
            age: 0,
            command: Command::default(),
            command_age: u32::MAX,
            due: Instant::default(),
            armed: true,
            acknowledged: false,
            direction: Direction::Forward,
            mode: Conditions::empty(),
            sensorless: false,
            calibrate: false,
            refusal: Refusal::None,
            other_source: false,
        }
    }
}

impl Machine {
    /// A valid command has arrived.
    pub fn handle_command(&mut self, now: Instant, command: Command) {
        self.wake(now);
        self.handle_set_point(now, command.speed);
        self.command.request = command.request;
        match command.request {
            RunRequest::Standby => {
                self.armed |= !self.state.is_driving();
                self.acknowledged |= self.state == State::Fault;
                self.refusal = Refusal::None;
            }
            // Asked for Drive before it could: a drive that resets under a running master must not start by
            // itself.
            RunRequest::Drive | RunRequest::Reverse => self.armed &= self.state != State::Initialization,
            RunRequest::Shutdown => {}
        }
    }

    /// A set-point has arrived: the request stays. The master may be silent as long as before, so a deadline
    /// is early now, never late.
    pub const fn handle_set_point(&mut self, now: Instant, speed: ElectricalSpeed) {
        self.pass(now);
        self.command.speed = speed;
        self.command_age = 0;
    }

    /// Arms or withdraws the hall calibration; acts at the next start.
    pub fn handle_calibration(&mut self, run: bool) {
        self.calibrate = run && HALL_CALIBRATION;
    }

    /// The source of the rotor's position that is not in use may go on (true), or not.
    pub const fn offer_other_source(&mut self, offered: bool) {
        self.other_source = offered;
    }

    /// True in the ordinary tick of a state, in which no row of the table can hold; else
    /// [`advance`](Self::advance) looks. Of the rows that ask for standstill T47 and T45 alone wait for
    /// nothing else; T54 for the other source.
    #[inline]
    pub fn rests(&self, now: Instant, critical: bool, stopped: bool) -> bool {
        let stalls = stopped && self.state == State::SensorlessClosedLoop;
        let changes = self.other_source && self.state == State::HallClosedLoop;
        !(self.due.is_due(now) || critical || stalls || changes)
    }

    /// Time at which a row of the table may hold by time alone.
    #[inline]
    pub const fn due(&self) -> Instant {
        self.due
    }

    /// [`due`](Self::due), after everything was looked at.
    fn deadline(&self, c: &MachineCoefficients) -> Instant {
        let left = match self.state {
            State::Initialization => c.boot.saturating_sub(self.age).max(1),
            State::Standby if self.wants_to_run() && self.refusal == Refusal::None => 1,
            State::Fault if self.acknowledged => c.fault_wait.saturating_sub(self.age).max(1),
            State::Standby | State::Fault => u32::MAX,
            _ if !self.wants_to_run() || self.reversing() => 1,
            _ => {
                // A duration that has elapsed was looked at just now, and no row fired: time changes nothing
                // more.
                let elapses =
                    self.duration(c).checked_sub(self.age).filter(|left| *left > 0).unwrap_or(u32::MAX);
                elapses.min(c.command_timeout.saturating_sub(self.command_age)).max(1)
            }
        };
        self.at.after(left)
    }

    /// The ages are told the ticks until `now`.
    #[inline]
    const fn pass(&mut self, now: Instant) {
        let ticks = now.since(self.at);
        self.age = self.age.saturating_add(ticks);
        self.command_age = self.command_age.saturating_add(ticks);
        self.at = now;
    }

    /// Something has changed beside time.
    pub const fn wake(&mut self, now: Instant) {
        self.due = now;
    }

    /// This request was the last one, too, and has had its effect: once more it only says that the master is
    /// there. Drive and Reverse do the rest of their work the first time.
    pub fn knows(&self, request: RunRequest) -> bool {
        let is_done = match request {
            RunRequest::Standby => self.armed && (self.acknowledged || self.state != State::Fault),
            RunRequest::Drive | RunRequest::Reverse | RunRequest::Shutdown => true,
        };
        is_done && request == self.command.request
    }

    #[inline]
    fn wants_to_run(&self) -> bool {
        matches!(self.command.request, RunRequest::Drive | RunRequest::Reverse)
    }

    /// One tick: at most one transition fires.
    pub fn step(&mut self, c: &MachineCoefficients, now: Instant, inputs: &Inputs) -> Option<Change> {
        if self.rests(now, inputs.critical, inputs.stopped) { None } else { self.advance(c, now, inputs) }
    }

    /// Runs a tick that does not [rest](Self::rests): at most one transition fires.
    #[inline(never)]
    pub fn advance(&mut self, c: &MachineCoefficients, now: Instant, inputs: &Inputs) -> Option<Change> {
        self.pass(now);
        let conditions = self.conditions(c, inputs);
        let Some(row) = transition(self.state, conditions) else {
            self.due = self.deadline(c);
            return None;
        };
        match row.to {
            State::Standby => {
                let reversal = conditions.contains(Conditions::REVERSAL) && self.state.is_driving();
                self.armed =
                    reversal || self.command.request == RunRequest::Standby || self.fresh_after_boot();
            }
            State::Fault => self.acknowledged = false,
            _ => {}
        }
        if self.state == State::Standby && row.to != State::Fault {
            self.leave_standby(conditions);
        }
        match (row.from, row.to) {
            (State::HallClosedLoop, State::SensorlessClosedLoop) => self.sensorless = true,
            (State::SensorlessClosedLoop, State::HallClosedLoop) => self.sensorless = false,
            _ => {}
        }
        let timed_out = row.to == State::Fault && row.all == Conditions::EXPIRED;
        (self.state, self.age, self.due, self.other_source) = (row.to, 0, now, false);
        Some(Change { row, timed_out })
    }

    /// After boot the power-up's Standby still counts, unless Drive was asked for meanwhile.
    fn fresh_after_boot(&self) -> bool {
        self.state == State::Initialization && self.armed
    }

    fn leave_standby(&mut self, conditions: Conditions) {
        let modes = Conditions::HALL
            .union(Conditions::SENSORLESS)
            .union(Conditions::OPEN_LOOP)
            .union(Conditions::CALIBRATION);
        self.mode = conditions.intersection(modes);
        let others = Conditions::HALL.union(Conditions::CALIBRATION);
        self.sensorless = self.mode.contains(Conditions::SENSORLESS) && !self.mode.intersects(others);
        self.armed = false;
        self.calibrate = false;
        self.direction = self.requested_direction();
    }

    fn requested_direction(&self) -> Direction {
        match self.command.request {
            RunRequest::Reverse => Direction::Reverse,
            _ => Direction::Forward,
        }
    }

    fn conditions(&mut self, c: &MachineCoefficients, inputs: &Inputs) -> Conditions {
        let modes = if self.state == State::Standby { self.enabled(c) } else { self.mode };
        let wanted = self.wants_to_run();
        if self.state == State::Standby && wanted && self.refusal == Refusal::None {
            self.refusal = self.refuse(modes, inputs);
            // A refused request is spent: it must not start the motor later, when what refused it has gone.
            self.armed &= self.refusal == Refusal::None;
        }
        let boot_passed = self.age >= c.boot && !inputs.unhealthy;
        let reversal = self.state.is_driving() && wanted && self.requested_direction() != self.direction;
        let acknowledged = self.acknowledged && self.age >= c.fault_wait && inputs.causes_gone;
        modes
            | when(boot_passed, Conditions::BOOTED)
            | when(inputs.critical, Conditions::CRITICAL)
            | when(inputs.unhealthy, Conditions::UNHEALTHY)
            | when(!wanted, Conditions::STANDBY)
            | when(wanted && self.refusal == Refusal::None, Conditions::START)
            | when(inputs.calibrated, Conditions::CALIBRATED)
            | when(self.command_age >= c.command_timeout, Conditions::EXPIRED)
            | when(self.age >= self.duration(c), Conditions::ELAPSED)
            | when(inputs.stopped, Conditions::STOPPED)
            | when(reversal, Conditions::REVERSAL)
            | when(acknowledged && !inputs.critical, Conditions::ACKNOWLEDGED)
            | when(self.other_source, Conditions::OTHER_SOURCE)
    }

    fn enabled(&self, c: &MachineCoefficients) -> Conditions {
        when(c.hall_enable, Conditions::HALL)
            | when(c.sensorless_enable, Conditions::SENSORLESS)
            | when(c.open_loop_enable, Conditions::OPEN_LOOP)
            | when(self.calibrate, Conditions::CALIBRATION)
    }

    /// Returns the reason why a start is refused now.
    fn refuse(&self, enabled: Conditions, inputs: &Inputs) -> Refusal {
        let modes = Conditions::HALL.union(Conditions::SENSORLESS).union(Conditions::OPEN_LOOP);
        if !self.armed {
            Refusal::NoFreshRequest
        } else if !inputs.parameters_fit {
            Refusal::Parameters
        } else if enabled.contains(Conditions::CALIBRATION) {
            Refusal::None
        } else if !enabled.intersects(modes) {
            Refusal::NoMode
        } else {
            Refusal::None
        }
    }

    /// The state's own duration; the others never elapse.
    fn duration(&self, c: &MachineCoefficients) -> u32 {
        match self.state {
            State::RotorLock => c.lock,
            State::OpenLoop => c.open_loop,
            State::SensorlessAutoRestart => c.auto_restart,
            _ => u32::MAX,
        }
    }

    /// Present state.
    pub const fn state(&self) -> State {
        self.state
    }

    /// Ticks in it by `now`, saturating.
    pub const fn age(&self, now: Instant) -> u32 {
        self.age.saturating_add(now.since(self.at))
    }

    /// The last command.
    pub const fn command(&self) -> Command {
        self.command
    }

    /// Direction of this start.
    pub const fn direction(&self) -> Direction {
        self.direction
    }

    /// The other direction is requested while driving: come to rest first.
    pub fn reversing(&self) -> bool {
        let wanted = self.wants_to_run();
        self.state.is_driving() && wanted && self.requested_direction() != self.direction
    }

    /// Drive is requested by a fresh edge in Standby: unless something refuses it, this tick turns the bridge
    /// on.
    pub fn starting(&self) -> bool {
        let wanted = self.wants_to_run();
        self.state == State::Standby && wanted && self.armed
    }

    /// This start is a hall calibration.
    pub const fn calibrating(&self) -> bool {
        HALL_CALIBRATION && self.mode.contains(Conditions::CALIBRATION)
    }

    /// This start is a sensorless one.
    pub const fn is_sensorless(&self) -> bool {
        SENSORLESS && self.sensorless
    }

    /// No valid command for the time-out.
    pub fn command_expired(&self, c: &MachineCoefficients, now: Instant) -> bool {
        self.command_age.saturating_add(now.since(self.at)) >= c.command_timeout
    }

    /// Reason why the last start was refused; stays until Standby is requested.
    pub const fn refusal(&self) -> Refusal {
        self.refusal
    }
}

/// `condition` if it `holds`.
const fn when(holds: bool, condition: Conditions) -> Conditions {
    if holds { condition } else { Conditions::empty() }
}
