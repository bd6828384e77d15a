//! Jobs: conversations of several messages, which the master carries out by itself.

use super::{check_speed, narx_master_t};
use crate::handle;
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use narx_core::dictionary::number;
use narx_core::master::{Job, JobError, Master, RequestError, ScopeSetup};
use narx_core::motor::State;

/// A conversation of several messages.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum narx_job_kind_t {
    /// Starts the motor as soon as the drive accepts a start; ends when it is in closed loop, or in open loop
    /// where no closed loop is enabled.
    Start = 0,
    /// Calibrates the hall sensors: the motor turns one electrical revolution each way. Ends when it is at
    /// rest again.
    CalibrateHall = 1,
    /// Restarts a stopped drive; ends when it is in Standby or Fault again.
    Reboot = 2,
    /// Sets the scope up and arms it.
    ArmScope = 3,
    /// Triggers the armed scope now.
    ForceScope = 4,
    /// Waits until the scope's record is complete.
    AwaitScope = 5,
    /// Arms the scope and waits for its record; without a trigger it forces the scope as soon as the samples
    /// before the trigger were taken.
    CaptureScope = 6,
    /// Erases the log; ends when that is done, after minutes for a full memory.
    EraseLog = 7,
}

/// Settings of a record of the scope: raw values of its parameters.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct narx_scope_setup_t {
    /// Recorded signals, a bit each (parameter 22); 0 records the inputs of every control tick instead.
    pub channels: u32,
    /// Level of the triggers 1 to 4, thousandths of the signal's base (parameter 292).
    pub level: i32,
    /// Samples of each signal (parameter 23); of a record of inputs, control ticks.
    pub samples: u16,
    /// Control ticks from one sample to the next (parameter 24).
    pub prescaler: u16,
    /// Samples from before the trigger (parameter 26), fewer than all.
    pub before: u16,
    /// Kind of the trigger (parameter 290); 0 for none.
    pub trigger: u8,
    /// Signal of the triggers 1 to 4 (parameter 291).
    pub signal: u8,
}

/// Details of a job that has failed; 0, or 255 for a state that is unknown or does not matter, where there
/// are none.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_job_failure_t {
    /// Faults of a drive in Fault: sum of NARX_FAULT_*.
    pub faults: u32,
    /// Extended fault code: NARX_CAUSE_*.
    pub cause: u16,
    /// Parameter that does not fit the others, for refusal 2 of a start; setting of the scope that is out of
    /// range; parameter that the drive refuses.
    pub parameter: u16,
    /// Reason of a refused start: parameter 276; of a refused record: parameter 306.
    pub refusal: u8,
    /// State of the drive: a narx_state_t, or 255.
    pub state: u8,
    /// State of the scope: parameter 260, or 255.
    pub scope: u8,
}

/// No details.
const NO_DETAILS: narx_job_failure_t =
    narx_job_failure_t { faults: 0, cause: 0, parameter: 0, refusal: 0, state: u8::MAX, scope: u8::MAX };

/// Begins a job of the motor: a narx_job_kind_t, and for a start its speed, mechanical rpm, negative in
/// reverse. One that is under way ends without a result; narx_master_start, narx_master_stop and
/// narx_master_shut_down end one, too. Returns NARX_ERROR_SILENT for a silent master, NARX_ERROR_SPEED as
/// narx_master_start does, and NARX_ERROR_REQUEST for another kind.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_begin(master: *mut narx_master_t, kind: u8, rpm: i32) -> narx_status_t {
    use narx_job_kind_t as Kind;
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let master = handle::object(master)?;
        let job = match kind {
            kind if kind == Kind::Start as u8 => {
                check_speed(master, rpm)?;
                Job::Start { rpm }
            }
            kind if kind == Kind::CalibrateHall as u8 => Job::CalibrateHall,
            kind if kind == Kind::Reboot as u8 => Job::Reboot,
            _ => return Err(NARX_ERROR_REQUEST),
        };
        Ok(master.begin(job)?)
    };
    pointer::status(run())
}

/// Begins a job of the scope or the log: a narx_job_kind_t, its settings (which may be NULL where it arms
/// nothing), and the longest wait for a record, microseconds. One that is under way ends without a result;
/// jobs of the motor go on. Returns NARX_ERROR_SILENT for a silent master, and NARX_ERROR_REQUEST for another
/// kind.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_begin_record(
    master: *mut narx_master_t,
    kind: u8,
    setup: *const narx_scope_setup_t,
    within: u64,
) -> narx_status_t {
    use narx_job_kind_t as Kind;
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let master = handle::object(master)?;
        let setup = || pointer::read(setup).map(|setup| ScopeSetup::from(*setup));
        let job = match kind {
            kind if kind == Kind::ArmScope as u8 => Job::ArmScope(setup()?),
            kind if kind == Kind::ForceScope as u8 => Job::ForceScope,
            kind if kind == Kind::AwaitScope as u8 => Job::AwaitScope { within },
            kind if kind == Kind::CaptureScope as u8 => Job::CaptureScope { setup: setup()?, within },
            kind if kind == Kind::EraseLog as u8 => Job::EraseLog,
            _ => return Err(NARX_ERROR_REQUEST),
        };
        Ok(master.begin(job)?)
    };
    pointer::status(run())
}

/// Returns the result of the motor's job: NARX_OK, NARX_NOTHING before its end, or the error, with its
/// details in `failure` (which may be NULL): NARX_ERROR_FAULT, NARX_ERROR_START_REFUSED,
/// NARX_ERROR_TIMED_OUT, NARX_ERROR_NOT_CALIBRATED, NARX_ERROR_ABORTED, NARX_ERROR_NO_ANSWER,
/// NARX_ERROR_NOT_OBEYED, or the reason of the drive's refusal of a parameter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_poll_job(
    master: *mut narx_master_t,
    failure: *mut narx_job_failure_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { poll(master, failure, Master::poll_job) }
}

/// Returns the result of the job of the scope or the log, as narx_master_poll_job does. Its own errors:
/// NARX_ERROR_OUT_OF_RANGE for a setting (`parameter`), NARX_ERROR_SCOPE_REFUSED (`refusal`, or `scope` where
/// its state forbids the job), NARX_ERROR_NOT_EQUIPPED without a memory, NARX_ERROR_TIMED_OUT for a record
/// that was not complete in time (`scope`).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_poll_record(
    master: *mut narx_master_t,
    failure: *mut narx_job_failure_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { poll(master, failure, Master::poll_record) }
}

/// Ends the job of the scope or the log; its result is NARX_ERROR_ABORTED. What the drive has begun goes on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_abort_record(master: *mut narx_master_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(master) }.map(Master::abort_record))
}

/// Takes the result of a job.
///
/// # Safety
/// The rule for pointers at the head of narx.h.
unsafe fn poll(
    master: *mut narx_master_t,
    failure: *mut narx_job_failure_t,
    end: impl FnOnce(&mut Master) -> Option<Result<(), JobError>>,
) -> narx_status_t {
    // SAFETY: the caller's.
    let run = || unsafe {
        let master = handle::object(master)?;
        if !failure.is_null() {
            pointer::check(failure)?;
        }
        end(master).ok_or(NARX_NOTHING)?.or_else(|error| {
            pointer::write_unless_null(failure, error.into())?;
            Err(error.into())
        })
    };
    pointer::status(run())
}

impl From<narx_scope_setup_t> for ScopeSetup {
    fn from(setup: narx_scope_setup_t) -> Self {
        let narx_scope_setup_t { channels, level, samples, prescaler, before, trigger, signal } = setup;
        Self { channels, samples, prescaler, before, trigger, signal, level }
    }
}

impl From<JobError> for narx_job_failure_t {
    fn from(error: JobError) -> Self {
        let number = |state: Option<State>| state.map_or(u8::MAX, |state| state as u8);
        match error {
            JobError::Fault { faults, code } => {
                Self { faults: faults.bits(), cause: code, state: State::Fault as u8, ..NO_DETAILS }
            }
            JobError::StartRefused { reason, parameter } => Self {
                refusal: reason as u8,
                parameter: parameter.unwrap_or_default(),
                state: State::Standby as u8,
                ..NO_DETAILS
            },
            JobError::TimedOut { state, .. } => Self { state: number(state), ..NO_DETAILS },
            JobError::NotCalibrated { state, code } => {
                Self { cause: code.unwrap_or_default(), state: number(state), ..NO_DETAILS }
            }
            JobError::ScopeBusy(state) | JobError::NotArmed(state) | JobError::NoTrigger { state, .. } => {
                Self { scope: state as u8, ..NO_DETAILS }
            }
            JobError::Samples { .. } => Self { parameter: number::SCOPE_SAMPLES, ..NO_DETAILS },
            JobError::Prescaler { .. } => Self { parameter: number::SCOPE_PRESCALER, ..NO_DETAILS },
            JobError::Before { .. } => Self { parameter: number::SCOPE_TRIGGER_PHASE, ..NO_DETAILS },
            JobError::ScopeRefused(refusal) => Self { refusal: refusal as u8, ..NO_DETAILS },
            JobError::Request(_, RequestError::Refused(refusal)) => {
                Self { parameter: refusal.number, ..NO_DETAILS }
            }
            JobError::Request(..)
            | JobError::Aborted(_)
            | JobError::NoScopeMemory
            | JobError::LostErasing => NO_DETAILS,
        }
    }
}

impl From<JobError> for narx_status_t {
    fn from(error: JobError) -> Self {
        match error {
            JobError::Fault { .. } => NARX_ERROR_FAULT,
            JobError::StartRefused { .. } => NARX_ERROR_START_REFUSED,
            JobError::TimedOut { .. } | JobError::NoTrigger { .. } => NARX_ERROR_TIMED_OUT,
            JobError::NotCalibrated { .. } => NARX_ERROR_NOT_CALIBRATED,
            JobError::ScopeBusy(_) | JobError::NotArmed(_) | JobError::ScopeRefused(_) => {
                NARX_ERROR_SCOPE_REFUSED
            }
            JobError::NoScopeMemory => NARX_ERROR_NOT_EQUIPPED,
            JobError::Samples { .. } | JobError::Prescaler { .. } | JobError::Before { .. } => {
                NARX_ERROR_OUT_OF_RANGE
            }
            JobError::Aborted(_) => NARX_ERROR_ABORTED,
            JobError::LostErasing | JobError::Request(_, RequestError::NoAnswer) => NARX_ERROR_NO_ANSWER,
            JobError::Request(_, RequestError::NotObeyed) => NARX_ERROR_NOT_OBEYED,
            JobError::Request(_, RequestError::Refused(refusal)) => refusal.status.into(),
        }
    }
}
