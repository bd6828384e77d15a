//! Jobs: conversations of several messages, which the caller begins and whose end he takes.
//!
//! ```text
//!  Start          Standby, two periods, Drive or Reverse, then the state: a loop, or Fault, or still Standby
//!  CalibrateHall  the request, a start as above, rotor lock and open loop, Standby, the result
//!  Reboot         the request, Initialization, Standby or Fault
//!  CaptureScope   room, state, settings, the request; samples before a forced trigger, the request; the state
//!  EraseLog       the request, then the state and the number of records
//! ```
//!
//! A job sends its messages as the caller would, one at a time; the caller's own requests come first. One job
//! of the motor and one of the scope or the log can be under way, so that a start can be recorded.

mod error;
mod motor;
mod record;

pub use error::{ErrorKind, JobError};
pub use record::ScopeSetup;

use super::error::RequestError;
use super::requests::{Current, Request, Service, Todo};
use crate::bus::narmotion::{FromDrive, MotorMode};
use crate::dictionary::number;
use crate::motor::guard::fault::FaultWord;
use crate::motor::machine::state::State;

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
    /// Sets the scope up and arms it.
    ArmScope(ScopeSetup),
    /// Triggers the armed scope now.
    ForceScope,
    /// Waits until the scope's record is complete.
    AwaitScope {
        /// Longest time, microseconds.
        within: u64,
    },
    /// Arms the scope and waits for its record. Without a trigger (kind 0) it forces the scope as soon as the
    /// samples before the trigger were taken.
    CaptureScope {
        /// Settings of the record.
        setup: ScopeSetup,
        /// Longest time from the arming, or the forced trigger, until the record is complete, microseconds.
        within: u64,
    },
    /// Erases every record of the log. Ends when that is done, after minutes for a full memory.
    EraseLog,
}

impl Job {
    /// Name of the job, as programs call it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Start { .. } | Self::AwaitStart { .. } => "start",
            Self::CalibrateHall => "hall calibration",
            Self::Reboot => "reboot",
            Self::ArmScope(_) | Self::ForceScope | Self::AwaitScope { .. } | Self::CaptureScope { .. } => {
                "scope's record"
            }
            Self::EraseLog => "erase of the log",
        }
    }

    /// Returns whether this is a job of the scope or the log. It neither ends a job of the motor nor is ended
    /// by a command for the motor.
    pub const fn is_record(self) -> bool {
        !matches!(self, Self::Start { .. } | Self::AwaitStart { .. } | Self::CalibrateHall | Self::Reboot)
    }

    const fn first_step(self) -> Step {
        match self {
            Self::Start { .. } => Step::Prepare,
            Self::AwaitStart { .. } => Step::Requested,
            Self::CalibrateHall => Step::Awake,
            Self::Reboot => Step::Reboot,
            Self::ArmScope(setup) | Self::CaptureScope { setup, .. } if setup.channels == 0 => {
                Step::ExpectIdle
            }
            Self::ArmScope(_) | Self::CaptureScope { .. } => Step::ReadRoom,
            Self::ForceScope => Step::ExpectArmed,
            Self::AwaitScope { .. } => Step::ExpectDone,
            Self::EraseLog => Step::Erase,
        }
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
    /// Logging state of the status word.
    pub(super) logging: Option<u8>,
    /// A frame of the drive was received lately.
    pub(super) connected: bool,
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
    /// Reads the size of the scope's memory.
    ReadRoom,
    /// Expects that no record is under way.
    ExpectIdle,
    /// Writes a setting of the scope, then arms it.
    Set(u8),
    Arm,
    /// Lets the samples before a forced trigger be taken, expects an armed scope, and forces it.
    ReadSamplingTime,
    Fill,
    ExpectArmed,
    Force,
    /// Reads why the scope was not armed or forced.
    ReadScopeRefusal,
    /// Expects a complete record, now and then.
    ExpectDone,
    Pause,
    /// Asks for the erase of the log, and looks now and then whether that is done.
    Erase,
    Erasing,
    ReadLength,
    ReadFull,
}

impl Step {
    /// The request of the step; `None` where it only looks.
    fn request(self, job: Job) -> Option<Request> {
        let read = |number| Request::Read { number };
        Some(match self {
            Self::ReadHall => read(number::HALL_ENABLE),
            Self::ReadSensorless => read(number::SENSORLESS_ENABLE),
            Self::ReadRefusal => read(number::START_REFUSAL),
            Self::ReadRejected => read(number::REJECTED_PARAMETER),
            Self::ReadCode => read(number::EXTENDED_FAULT_CODE),
            Self::Calibrate => Request::Run(Service::CalibrateHall),
            Self::ReadResult => read(number::HALL_CALIBRATION_STATE),
            Self::Withdraw => Request::Write { number: number::HALL_CALIBRATE, raw: 0 },
            Self::Reboot => Request::Reboot,
            Self::ReadRoom => read(number::SCOPE_ROOM),
            Self::ExpectIdle | Self::ExpectArmed | Self::ExpectDone => read(number::SCOPE_STATE),
            Self::Set(place) => return job.setup()?.write(place),
            Self::Arm | Self::Force => Request::TriggerScope,
            Self::ReadSamplingTime => read(number::SCOPE_SAMPLING_TIME),
            Self::ReadScopeRefusal => read(number::SCOPE_REFUSAL),
            Self::Erase => Request::Run(Service::EraseLog),
            Self::ReadLength => read(number::LOG_WRITE_INDEX),
            Self::ReadFull => read(number::LOG_MEMORY_FULL),
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
pub(super) struct Running {
    job: Job,
    step: Step,
    /// Time at which the step was first looked at.
    since: Option<u64>,
    /// Time at which the start was begun, or the wait for a record.
    begun: Option<u64>,
    /// Time at which the drive takes a start, then at which it was requested; time of a forced trigger.
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
    /// Number of looks in turn that have found no erase under way.
    idle: u8,
}

impl Running {
    const fn new(job: Job) -> Self {
        Self {
            job,
            step: job.first_step(),
            since: None,
            begun: None,
            at: None,
            request: None,
            closed: None,
            refusal: 0,
            ended: None,
            code: None,
            found: false,
            idle: 0,
        }
    }

    /// Looks at the drive; returns the continuation, and the command that is due.
    fn look(&mut self, view: &View, now: u64) -> (Next, Option<Command>) {
        let first = self.since.is_none();
        let waited = now.saturating_sub(*self.since.get_or_insert(now));
        if self.job.is_record() {
            (self.look_at_record(view, now, waited), None)
        } else {
            self.look_at_motor(view, now, waited, first)
        }
    }

    /// Takes the result of the step's request.
    fn answered(&mut self, result: Result<i32, RequestError>, view: &View, now: u64) -> Next {
        match result {
            Ok(value) if self.job.is_record() => self.take_of_record(value, now),
            Ok(value) => self.take_of_motor(value, view, now),
            Err(error) => self.refused(error),
        }
    }

    /// Continues after a request that was not done.
    fn refused(&self, error: RequestError) -> Next {
        match (self.step, error) {
            (Step::Arm | Step::Force, RequestError::NotObeyed) => Next::Step(Step::ReadScopeRefusal),
            (Step::ReadLength | Step::ReadFull, RequestError::NoAnswer) => fail(JobError::LostErasing),
            (step, error) => match step.request(self.job) {
                Some(request) => fail(JobError::Request(request, error)),
                None => Next::Step(step),
            },
        }
    }
}

/// A job of a master, and its end until it is taken.
#[derive(Clone, Debug, Default)]
pub(super) enum Jobs {
    #[default]
    Idle,
    Running(Running),
    Ended(Result<(), JobError>),
}

impl Jobs {
    /// Begins a job.
    pub(super) const fn begin(&mut self, job: Job) {
        *self = Self::Running(Running::new(job));
    }

    /// Ends the job, because another command was given.
    pub(super) const fn abort(&mut self) {
        if let Self::Running(Running { job, .. }) = *self {
            *self = Self::Ended(Err(JobError::Aborted(job)));
        }
    }

    /// Takes note of a start by the caller: a job that does not wait for it ends.
    pub(super) fn start_requested(&mut self) {
        if !matches!(self, Self::Running(Running { step: Step::Requested, .. })) {
            self.abort();
        }
    }

    pub(super) const fn poll_end(&mut self) -> Option<Result<(), JobError>> {
        let Self::Ended(end) = *self else { return None };
        *self = Self::Idle;
        Some(end)
    }

    pub(super) const fn is_running(&self) -> bool {
        matches!(self, Self::Running(_))
    }

    /// Speed of a start that waits until the drive accepts it.
    pub(super) const fn pending_speed(&mut self) -> Option<&mut i32> {
        match self {
            Self::Running(Running { job: Job::Start { rpm }, step: Step::Prepare, .. }) => Some(rpm),
            _ => None,
        }
    }

    /// Looks at the drive; returns the command that is due.
    pub(super) fn look(&mut self, view: &View, now: u64) -> Option<Command> {
        let Self::Running(running) = self else { return None };
        let (next, command) = running.look(view, now);
        self.go(next);
        command
    }

    /// Returns the next message.
    pub(super) fn next(&mut self) -> Option<Todo> {
        let Self::Running(running) = self else { return None };
        if running.request.is_none() {
            running.request = Some(Current::new(running.step.request(running.job)?));
        }
        running.request.as_mut().map(Current::next)
    }

    /// Takes the answer to the message under way, `None` if none came.
    pub(super) fn finish(&mut self, answer: Option<&FromDrive>, view: &View, now: u64) {
        let Self::Running(running) = self else { return };
        let Some(current) = &mut running.request else { return };
        let result = match answer {
            Some(answer) => current.finish(answer),
            None => Some(Err(RequestError::NoAnswer)),
        };
        let Some(result) = result else { return };
        running.request = None;
        let next = running.answered(result, view, now);
        self.go(next);
    }

    fn go(&mut self, next: Next) {
        match (next, &mut *self) {
            (Next::End(end), _) => *self = Self::Ended(end),
            (Next::Step(step), Self::Running(running)) if running.step != step => {
                (running.step, running.since) = (step, None);
            }
            _ => {}
        }
    }
}
