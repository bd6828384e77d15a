//! Jobs: conversations of several messages, which the caller begins and whose end he takes.
//!
//! ```text
//!  Start          Standby, two periods, Drive or Reverse, then the state: a loop, or Fault, or still Standby
//!  CalibrateHall  the request, a start as above, rotor lock and open loop, Standby, the result
//!  Reboot         the request, Initialization, Standby or Fault
//! ```
//!
//! A job sends its messages as the caller would, one at a time; the caller's own requests come first.

use super::error::RequestError;
use super::requests::{Current, Request, Service, Todo};
use crate::bus::narmotion::{FromDrive, MotorMode};
use crate::dictionary::{Dictionary, number};
use crate::motor::guard::fault::{Cause, FaultWord};
use crate::motor::machine::state::State;
use core::fmt::{self, Write as _};

/// Longest time from the begin of a start until the motor is in the loop of its mode, microseconds.
const START_MAX: u64 = 10_000_000;
/// Longest time until a command was sent and the drive has acted on it.
const ANSWER: u64 = 50_000;
/// Longest times until a hall calibration turns the motor, and until the motor is at rest again.
const CALIBRATION_BEGIN: u64 = 3_000_000;
const CALIBRATION_MAX: u64 = 60_000_000;
/// Longest time from a reboot until the drive has left its former state, and until it is ready.
const RESTART: u64 = 200_000;
const READY_MAX: u64 = 5_000_000;
/// Value of the parameter Hall calibration state after a calibration that has found the sensors.
const CALIBRATED: i32 = 2;
/// Value of the parameter Rejected parameter if there is none.
const NONE_REJECTED: i32 = 0xFFFF;

/// A conversation of several messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Job {
    /// Starts the motor at a speed, mechanical rpm, negative in reverse, as soon as the drive accepts a
    /// start. Ends when the motor is in closed loop, or in open loop where no closed loop is enabled.
    Start {
        /// Speed, rpm.
        rpm: i32,
    },
    /// Watches a start that [`Master::start`](super::Master::start) requests, before or after this, and ends
    /// like [`Job::Start`].
    AwaitStart {
        /// Speed, rpm.
        rpm: i32,
    },
    /// Calibrates the hall sensors: the motor turns one electrical revolution each way. Ends when the motor
    /// is at rest again; the drive uses the result from then on, and stores it like every other parameter.
    CalibrateHall,
    /// Restarts a stopped drive. Ends when the drive is in Standby or Fault again.
    Reboot,
}

impl Job {
    /// Name of the job, as programs call it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Start { .. } | Self::AwaitStart { .. } => "start",
            Self::CalibrateHall => "hall calibration",
            Self::Reboot => "reboot",
        }
    }
}

/// Reason why a job has failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobError {
    /// The drive is in Fault.
    Fault {
        /// Latched faults.
        faults: FaultWord,
        /// Extended code of the last critical fault.
        code: u16,
    },
    /// The drive refuses the start.
    StartRefused {
        /// Value of the parameter Start refusal.
        reason: i32,
        /// Parameter that does not fit the others, for reason 2.
        parameter: Option<u16>,
    },
    /// The job has taken too long.
    TimedOut {
        /// The job.
        job: Job,
        /// Its longest time, microseconds.
        within: u64,
        /// State of the drive; `None` while unknown.
        state: Option<State>,
    },
    /// The hall calibration has not found the sensors.
    NotCalibrated {
        /// State in which it ended.
        state: Option<State>,
        /// Extended code of the fault in which it ended.
        code: Option<u16>,
    },
    /// A request of the job was not done.
    Request(RequestError),
    /// Another command has ended this job.
    Aborted(Job),
}

impl fmt::Display for JobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let state = |state: Option<State>| state.map_or("an unknown state", State::name);
        match *self {
            Self::Fault { faults, code } => {
                f.write_str("the drive is in Fault: ")?;
                write_cause(f, code)?;
                for (place, (name, _)) in faults.iter_names().enumerate() {
                    f.write_str(if place == 0 { " (" } else { ", " })?;
                    name.chars().try_for_each(|letter| f.write_char(letter.to_ascii_lowercase()))?;
                }
                f.write_str(if faults.is_empty() { "" } else { ")" })
            }
            Self::StartRefused { reason: 2, parameter: Some(number) } => {
                let name = Dictionary::row(number).map_or("", |row| row.name());
                write!(
                    f,
                    "the drive refused the start: parameter {number} \"{name}\" does not fit the others"
                )
            }
            Self::StartRefused { reason, .. } => {
                f.write_str("the drive refused the start: ")?;
                match reason {
                    1 => f.write_str("no mode is enabled"),
                    2 => f.write_str("parameters do not fit together"),
                    4 => f.write_str("Standby was not requested before"),
                    _ => write!(f, "reason {reason}"),
                }
            }
            Self::TimedOut { job, within, state } => {
                let what = match job {
                    Job::Start { .. } | Job::AwaitStart { .. } | Job::CalibrateHall => "no start",
                    Job::Reboot => "not ready after a reboot",
                };
                write!(f, "{what} within {} s: ", within / 1_000_000)?;
                match state {
                    Some(state) => write!(f, "the drive is in {}", state.name()),
                    None => f.write_str("no frames were received from the drive"),
                }
            }
            Self::NotCalibrated { state: ended, code } => {
                write!(f, "the hall calibration failed: the drive is in {}", state(ended))?;
                match code {
                    Some(code) => f.write_str(": ").and_then(|()| write_cause(f, code)),
                    None => Ok(()),
                }
            }
            Self::Request(error) => error.fmt(f),
            Self::Aborted(job) => write!(f, "the {} was ended by another command", job.name()),
        }
    }
}

impl core::error::Error for JobError {}

/// Writes the meaning of an extended fault code, or the code itself.
fn write_cause(f: &mut fmt::Formatter<'_>, code: u16) -> fmt::Result {
    match Cause::TABLE.into_iter().find(|row| row.cause as u16 == code) {
        Some(row) => f.write_str(row.meaning),
        None => write!(f, "code {code:#06x}"),
    }
}

/// The drive as a job sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub(super) state: Option<State>,
    /// Motor mode of the status word.
    pub(super) mode: Option<MotorMode>,
    /// The master requests a mode that turns the motor.
    pub(super) requested: bool,
    pub(super) faults: FaultWord,
    /// Period of the set-points, microseconds.
    pub(super) period: u64,
}

/// A command that a job gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Command {
    Standby,
    /// Drive or Reverse at this speed, rpm.
    Turn(i32),
}

/// Step of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// Waits until the drive takes a start: it must have received Standby since it last stopped or booted.
    Prepare,
    /// The caller requests a start.
    Requested,
    /// Watches the start.
    Watch,
    /// Reads whether a closed loop is enabled, with hall sensors and without.
    ReadHall,
    ReadSensorless,
    /// Reads why the drive stays in Standby.
    ReadRefusal,
    ReadRejected,
    /// Reads the code of the fault.
    ReadCode,
    /// The drive may still be booting.
    Awake,
    /// Asks for a hall calibration.
    Calibrate,
    /// The motor begins to turn, and comes to rest.
    Turning,
    Resting,
    /// Reads the result of the calibration.
    ReadResult,
    /// Standby is on its way to the drive: the next start requires it.
    Standby,
    /// Takes the request for a calibration back.
    Withdraw,
    /// Asks for a reboot, sees the drive leave its state, and waits for it.
    Reboot,
    Leaving,
    Ready,
}

impl Step {
    /// The request of the step; `None` where it only looks.
    const fn request(self) -> Option<Request> {
        Some(match self {
            Self::ReadHall => Request::Read { number: number::HALL_ENABLE },
            Self::ReadSensorless => Request::Read { number: number::SENSORLESS_ENABLE },
            Self::ReadRefusal => Request::Read { number: number::START_REFUSAL },
            Self::ReadRejected => Request::Read { number: number::REJECTED_PARAMETER },
            Self::ReadCode => Request::Read { number: number::EXTENDED_FAULT_CODE },
            Self::Calibrate => Request::Run(Service::CalibrateHall),
            Self::ReadResult => Request::Read { number: number::HALL_CALIBRATION_STATE },
            Self::Withdraw => Request::Write { number: number::HALL_CALIBRATE, raw: 0 },
            Self::Reboot => Request::Reboot,
            _ => return None,
        })
    }
}

/// Continuation of a job.
enum Next {
    /// This step, which may be the present one.
    Step(Step),
    End(Result<(), JobError>),
}

const fn fail(error: JobError) -> Next {
    Next::End(Err(error))
}

/// A job under way. Times are in microseconds.
#[derive(Clone, Copy, Debug)]
struct Running {
    job: Job,
    step: Step,
    /// Time at which the step was first looked at.
    since: Option<u64>,
    /// Time at which the start was begun.
    begun: Option<u64>,
    /// Time at which the drive takes a start, then at which it was requested.
    at: Option<u64>,
    /// The request of the step, while it is under way.
    request: Option<Current>,
    /// A start ends in closed loop; `None` until that was read.
    closed: Option<bool>,
    /// Value of the parameter Start refusal.
    refusal: i32,
    /// State in which a calibration ended, and its code if that is Fault.
    ended: Option<State>,
    code: Option<u16>,
    /// The calibration has found the sensors.
    found: bool,
}

impl Running {
    /// Looks at the drive; returns the continuation, and the command that is due.
    fn look(&mut self, view: &View, now: u64) -> (Next, Option<Command>) {
        let first = self.since.is_none();
        let waited = now.saturating_sub(*self.since.get_or_insert(now));
        let turning = matches!(view.state, Some(State::RotorLock | State::OpenLoop));
        let next = match self.step {
            Step::Prepare => return self.prepare(view, now),
            Step::Requested => self.requested(view, now),
            Step::Watch => self.watch(view, now),
            Step::Awake
                if waited < CALIBRATION_BEGIN && matches!(view.state, None | Some(State::Initialization)) =>
            {
                Next::Step(Step::Awake)
            }
            Step::Awake => Next::Step(Step::Calibrate),
            Step::Turning if turning => Next::Step(Step::Resting),
            Step::Turning if view.state != Some(State::Fault) && waited < CALIBRATION_BEGIN => {
                Next::Step(Step::Turning)
            }
            Step::Resting if (view.state.is_none() || turning) && waited < CALIBRATION_MAX => {
                Next::Step(Step::Resting)
            }
            Step::Turning | Step::Resting => self.end_in(view.state),
            Step::Standby if waited < 2 * view.period => {
                return (Next::Step(Step::Standby), first.then_some(Command::Standby));
            }
            Step::Standby if self.found => Next::End(Ok(())),
            Step::Standby => Next::Step(Step::Withdraw),
            Step::Leaving if view.state != Some(State::Initialization) && waited < RESTART => {
                Next::Step(Step::Leaving)
            }
            Step::Leaving => Next::Step(Step::Ready),
            Step::Ready if matches!(view.state, Some(State::Standby | State::Fault)) => Next::End(Ok(())),
            Step::Ready if waited >= READY_MAX => {
                fail(JobError::TimedOut { job: self.job, within: READY_MAX, state: view.state })
            }
            step => Next::Step(step),
        };
        (next, None)
    }

    /// Waits until the drive accepts a start, and requests it.
    fn prepare(&mut self, view: &View, now: u64) -> (Next, Option<Command>) {
        let stay = Next::Step(Step::Prepare);
        if self.is_late(now) {
            return (self.late(view), None);
        }
        match (view.state, self.at) {
            (None, _) => (stay, None),
            (Some(State::Fault), _) => (self.end_in(view.state), None),
            (Some(State::Standby), Some(at)) if now < at => (stay, None),
            (Some(State::Initialization), _) | (Some(State::Standby), None) => {
                let command = self.at.is_none().then_some(Command::Standby);
                self.at = Some(now.saturating_add(2 * view.period));
                (stay, command)
            }
            _ => {
                self.at = Some(now);
                let next = if self.job == Job::CalibrateHall { Step::Turning } else { Step::Watch };
                (Next::Step(next), Some(Command::Turn(self.rpm())))
            }
        }
    }

    /// Waits until the caller has requested a start.
    fn requested(&mut self, view: &View, now: u64) -> Next {
        match view.state {
            Some(State::Fault) => self.end_in(view.state),
            _ if view.requested => self.watch_from(now),
            _ if self.is_late(now) => self.late(view),
            _ => Next::Step(Step::Requested),
        }
    }

    /// Watches the start that was requested.
    fn watch(&mut self, view: &View, now: u64) -> Next {
        let wanted = if self.rpm() < 0 { MotorMode::Reverse } else { MotorMode::Drive };
        let turns = view.mode == Some(wanted);
        let since = now.saturating_sub(self.at.unwrap_or(now));
        match view.state {
            Some(State::Fault) => self.end_in(view.state),
            _ if self.is_late(now) => self.late(view),
            _ if since < ANSWER => Next::Step(Step::Watch),
            Some(State::HallClosedLoop | State::SensorlessClosedLoop) if turns => Next::End(Ok(())),
            Some(State::OpenLoop) if turns && self.closed.is_none() => Next::Step(Step::ReadHall),
            Some(State::OpenLoop) if turns && self.closed == Some(false) => Next::End(Ok(())),
            Some(State::Standby) if since >= 4 * ANSWER => Next::Step(Step::ReadRefusal),
            _ => Next::Step(Step::Watch),
        }
    }

    const fn watch_from(&mut self, now: u64) -> Next {
        self.at = Some(now);
        Next::Step(Step::Watch)
    }

    /// Returns whether the start has taken too long.
    fn is_late(&mut self, now: u64) -> bool {
        now.saturating_sub(*self.begun.get_or_insert(now)) >= START_MAX
    }

    /// Takes the value of the step's request.
    fn answered(&mut self, value: i32, view: &View, now: u64) -> Next {
        match self.step {
            Step::ReadHall if value == 0 => Next::Step(Step::ReadSensorless),
            Step::ReadHall | Step::ReadSensorless => {
                self.closed = Some(value != 0);
                self.watch_from(now)
            }
            // A drive that is slow to act is asked again.
            Step::ReadRefusal if value == 0 => self.watch_from(now),
            Step::ReadRefusal => {
                self.refusal = value;
                Next::Step(Step::ReadRejected)
            }
            Step::ReadRejected => {
                let parameter = (value != NONE_REJECTED).then_some(value as u16);
                fail(JobError::StartRefused { reason: self.refusal, parameter })
            }
            Step::ReadCode if self.job == Job::CalibrateHall => {
                self.code = Some(value as u16);
                Next::Step(Step::ReadResult)
            }
            Step::ReadCode => fail(JobError::Fault { faults: view.faults, code: value as u16 }),
            Step::Calibrate => Next::Step(Step::Prepare),
            Step::ReadResult => {
                self.found = value == CALIBRATED && self.ended == Some(State::Standby);
                Next::Step(Step::Standby)
            }
            Step::Withdraw => fail(JobError::NotCalibrated { state: self.ended, code: self.code }),
            Step::Reboot => Next::Step(Step::Leaving),
            step => Next::Step(step),
        }
    }

    /// Ends a start in Fault, or a calibration in any state.
    fn end_in(&mut self, state: Option<State>) -> Next {
        self.ended = state;
        Next::Step(if state == Some(State::Fault) { Step::ReadCode } else { Step::ReadResult })
    }

    fn late(&self, view: &View) -> Next {
        fail(JobError::TimedOut { job: self.job, within: START_MAX, state: view.state })
    }

    /// Speed of the start. A calibration turns the motor at its own speed, whatever is asked for.
    const fn rpm(&self) -> i32 {
        match self.job {
            Job::Start { rpm } | Job::AwaitStart { rpm } => rpm,
            Job::CalibrateHall | Job::Reboot => 1,
        }
    }
}

/// The job of a master, and its end until it is taken.
#[derive(Clone, Debug, Default)]
pub(super) struct Jobs {
    running: Option<Running>,
    end: Option<Result<(), JobError>>,
}

impl Jobs {
    /// Begins a job.
    pub(super) fn begin(&mut self, job: Job) {
        let step = match job {
            Job::Start { .. } => Step::Prepare,
            Job::AwaitStart { .. } => Step::Requested,
            Job::CalibrateHall => Step::Awake,
            Job::Reboot => Step::Reboot,
        };
        self.end = None;
        self.running = Some(Running {
            job,
            step,
            since: None,
            begun: None,
            at: None,
            request: None,
            closed: None,
            refusal: 0,
            ended: None,
            code: None,
            found: false,
        });
    }

    /// Ends the job, because another command was given.
    pub(super) fn abort(&mut self) {
        if let Some(Running { job, .. }) = self.running.take() {
            self.end = Some(Err(JobError::Aborted(job)));
        }
    }

    /// Takes note of a start by the caller: a job that does not wait for it ends.
    pub(super) fn start_requested(&mut self) {
        let awaited = |running: &Running| running.step == Step::Requested;
        if !self.running.as_ref().is_some_and(awaited) {
            self.abort();
        }
    }

    pub(super) fn poll_end(&mut self) -> Option<Result<(), JobError>> {
        self.end.take()
    }

    pub(super) const fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Speed of a start that waits until the drive accepts it.
    pub(super) fn pending_speed(&mut self) -> Option<&mut i32> {
        match &mut self.running {
            Some(Running { job: Job::Start { rpm }, step: Step::Prepare, .. }) => Some(rpm),
            _ => None,
        }
    }

    /// Looks at the drive; returns the command that is due.
    pub(super) fn look(&mut self, view: &View, now: u64) -> Option<Command> {
        let (next, command) = self.running.as_mut()?.look(view, now);
        self.go(next);
        command
    }

    /// Returns the next message.
    pub(super) fn next(&mut self) -> Option<Todo> {
        let running = self.running.as_mut()?;
        if running.request.is_none() {
            running.request = Some(Current::new(running.step.request()?));
        }
        running.request.as_mut().map(Current::next)
    }

    /// Takes the answer to the message under way, `None` if none came.
    pub(super) fn finish(&mut self, answer: Option<&FromDrive>, view: &View, now: u64) {
        let Some(running) = &mut self.running else { return };
        let Some(current) = &mut running.request else { return };
        let result = match answer {
            Some(answer) => current.finish(answer),
            None => Some(Err(RequestError::NoAnswer)),
        };
        let Some(result) = result else { return };
        running.request = None;
        let next = match result {
            Ok(value) => running.answered(value, view, now),
            Err(error) => fail(JobError::Request(error)),
        };
        self.go(next);
    }

    fn go(&mut self, next: Next) {
        match next {
            Next::End(end) => {
                self.running = None;
                self.end = Some(end);
            }
            Next::Step(step) => {
                if let Some(running) = &mut self.running
                    && running.step != step
                {
                    (running.step, running.since) = (step, None);
                }
            }
        }
    }
}
