//! Jobs: conversations of several messages, which the master carries out by itself.

use super::{check_speed, narx_master_t};
use crate::handle;
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use narx_core::master::{Job, JobError, RequestError};
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
}

/// Details of a job that has failed; 0, or 255 for an unknown state, where there are none.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct narx_job_failure_t {
    /// Faults of a drive in Fault: sum of NARX_FAULT_*.
    pub faults: u32,
    /// Extended fault code: NARX_CAUSE_*.
    pub cause: u16,
    /// Parameter that does not fit the others, for refusal 2.
    pub parameter: u16,
    /// Reason of a refused start: parameter 276.
    pub refusal: u8,
    /// State of the drive: a narx_state_t, or 255 while unknown.
    pub state: u8,
}

/// Begins a job: a narx_job_kind_t, and for a start its speed, mechanical rpm, negative in reverse. A job
/// that is under way ends without a result; narx_master_start, narx_master_stop and narx_master_shut_down end
/// one, too. Returns NARX_ERROR_SILENT for a silent master, NARX_ERROR_SPEED as narx_master_start does, and
/// NARX_ERROR_REQUEST for an undefined kind.
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

/// Returns the result of the job: NARX_OK, NARX_NOTHING before its end, or the error, with its details in
/// `failure` (which may be NULL): NARX_ERROR_FAULT, NARX_ERROR_START_REFUSED, NARX_ERROR_TIMED_OUT,
/// NARX_ERROR_NOT_CALIBRATED, NARX_ERROR_ABORTED, NARX_ERROR_NO_ANSWER, NARX_ERROR_NOT_OBEYED, or the reason
/// of the drive's refusal of a parameter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_poll_job(
    master: *mut narx_master_t,
    failure: *mut narx_job_failure_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let master = handle::object(master)?;
        if !failure.is_null() {
            pointer::check(failure)?;
        }
        master.poll_job().ok_or(NARX_NOTHING)?.or_else(|error| {
            pointer::write_unless_null(failure, error.into())?;
            Err(error.into())
        })
    };
    pointer::status(run())
}

impl From<JobError> for narx_job_failure_t {
    fn from(error: JobError) -> Self {
        let number = |state: Option<State>| state.map_or(u8::MAX, |state| state as u8);
        match error {
            JobError::Fault { faults, code } => {
                Self { faults: faults.bits(), cause: code, state: State::Fault as u8, ..Self::default() }
            }
            JobError::StartRefused { reason, parameter } => Self {
                refusal: reason as u8,
                parameter: parameter.unwrap_or_default(),
                state: State::Standby as u8,
                ..Self::default()
            },
            JobError::TimedOut { state, .. } => Self { state: number(state), ..Self::default() },
            JobError::NotCalibrated { state, code } => {
                Self { cause: code.unwrap_or_default(), state: number(state), ..Self::default() }
            }
            JobError::Request(_) | JobError::Aborted(_) => Self { state: u8::MAX, ..Self::default() },
        }
    }
}

impl From<JobError> for narx_status_t {
    fn from(error: JobError) -> Self {
        match error {
            JobError::Fault { .. } => NARX_ERROR_FAULT,
            JobError::StartRefused { .. } => NARX_ERROR_START_REFUSED,
            JobError::TimedOut { .. } => NARX_ERROR_TIMED_OUT,
            JobError::NotCalibrated { .. } => NARX_ERROR_NOT_CALIBRATED,
            JobError::Aborted(_) => NARX_ERROR_ABORTED,
            JobError::Request(RequestError::NoAnswer) => NARX_ERROR_NO_ANSWER,
            JobError::Request(RequestError::NotObeyed) => NARX_ERROR_NOT_OBEYED,
            JobError::Request(RequestError::Refused(refusal)) => refusal.status.into(),
        }
    }
}
