//! Jobs of the motor: start, hall calibration, reboot.

use super::{Command, Job, JobError, Next, Running, Step, View, fail};
use crate::bus::narmotion::MotorMode;
use crate::motor::machine::state::State;

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

impl Running {
    /// Looks at the drive; returns the continuation, and the command that is due. waited: time since the step
    /// was first looked at, which is now if `first`.
    pub(super) fn look_at_motor(
        &mut self,
        view: &View,
        now: u64,
        waited: u64,
        first: bool,
    ) -> (Next, Option<Command>) {
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
    pub(super) fn take_of_motor(&mut self, value: i32, view: &View, now: u64) -> Next {
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
            _ => 1,
        }
    }
}
