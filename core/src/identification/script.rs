//! The next actions of an identification, one after the other, and the parameters that it changes.

use super::record::{Record, channels};
use super::{IdentificationError, MARGIN, PATIENCE};
use crate::commissioning::WRITTEN;
use crate::dictionary::number;
use crate::master::{CriticalFault, Download, Job, JobError, Master, Received, Request, ScopeSetup};
use crate::motor::State;
use crate::motor::signal::Signal;
use heapless::{Deque, Vec};
use libm::fabs;

/// One action.
#[derive(Clone, Copy, Debug)]
pub(super) enum Action {
    /// Waits until the drive is in Standby: it may still be booting.
    Ready,
    /// Reads a parameter; its raw value is the next of the answers.
    Read(u16),
    /// Writes a parameter, and remembers what it was.
    Write(u16, i32),
    /// Waits, microseconds.
    Wait(u64),
    /// Starts the motor at a speed, rpm.
    Start(i32),
    /// Sets another speed, rpm.
    Speed(u16),
    /// Calibrates the hall sensors.
    CalibrateHall,
    /// Waits until the motor turns at this speed.
    Settle { rpm: f64, within: u64 },
    /// Waits until the turns of the rotor are marked.
    Count,
    /// Requests Standby and waits for it.
    Stop,
    /// Arms the scope.
    Arm(ScopeSetup),
    /// Forces the armed scope.
    Force,
    /// Waits for the record.
    AwaitRecord,
    /// Downloads it.
    Download(u32),
}

/// Kind of the scope's trigger that waits for another state (parameter 290).
const STATE_CHANGE: u8 = 5;
/// Time in which the drive acts on a request for Standby, or acknowledges a fault, microseconds.
const STOPS: u64 = 2_000_000;
/// A rotor that was turning has come to rest after this time, as a rule, microseconds.
const REST_AFTER_FAULT: u64 = 300_000;
/// The speed counts as reached within this share of the set-point, for so long, microseconds.
const NEAR: f64 = 0.04;
const CALM: u64 = 250_000;

impl Action {
    /// Arms the scope for these signals; it begins when the state changes.
    pub(super) fn arm(signals: &[Signal], samples: u16, prescaler: u16, before: u16) -> Self {
        let channels = channels(signals);
        Self::Arm(ScopeSetup {
            channels,
            samples,
            prescaler,
            before,
            trigger: STATE_CHANGE,
            ..Default::default()
        })
    }

    /// Arms the scope for these signals; it begins when it is forced.
    pub(super) fn arm_forced(signals: &[Signal], samples: u16, prescaler: u16) -> Self {
        Self::Arm(ScopeSetup { channels: channels(signals), samples, prescaler, ..Default::default() })
    }
}

/// Turns that are marked, at the begin of the first and at the end of each.
pub(super) const TURNS: u8 = 2;
/// A mark that follows sooner is the same one, of a rotor that swings, microseconds.
const SAME: u64 = 200_000;
/// Longest wait for them, microseconds: two turns with 50 pole pairs take 50 s.
const UNMARKED: u64 = 180_000_000;

/// Longest script: a commissioning with a run, or every parameter that was written.
const ACTIONS: usize = 64;
const _: () = assert!(WRITTEN.len() + 24 <= ACTIONS);

/// The actions to come.
#[derive(Clone, Debug, Default)]
pub(super) struct Script {
    actions: Deque<Action, ACTIONS>,
    /// The action under way, and when it began.
    under_way: Option<(Action, u64)>,
    /// Its value is being read before it is written.
    reads_first: bool,
    /// A request that was given up has not been answered yet, or a download has not ended.
    stray: bool,
    stray_words: bool,
    /// Since when the speed is near the set-point.
    near: Option<u64>,
    /// Marks of the rotor's turns so far, and the time from the first to the last.
    marks: u8,
    first: u64,
    span: u64,
    /// Parameters that were written, and their values before.
    originals: Vec<(u16, i32), ACTIONS>,
    answers: Vec<i32, 4>,
    /// The last record.
    pub(super) record: Record,
}

/// An action's outcome.
type Done = Result<bool, IdentificationError>;

impl Script {
    pub(super) fn add(&mut self, actions: &[Action]) {
        for action in actions {
            // There is room (`ACTIONS`).
            let _ = self.actions.push_back(*action);
        }
    }

    /// Drops everything: the motor stops, a fault is acknowledged, and the rotor comes to rest.
    pub(super) fn give_up(&mut self, master: &mut Master) {
        self.stop(master);
        self.add(&[Action::Wait(REST_AFTER_FAULT)]);
    }

    /// Drops everything, and stops the motor.
    fn stop(&mut self, master: &mut Master) {
        self.drop_all(master);
        // At once, even if an answer is still waited for.
        master.stop();
        self.add(&[Action::Stop]);
    }

    /// Drops everything, also the action under way.
    pub(super) fn drop_all(&mut self, master: &mut Master) {
        self.actions.clear();
        match self.under_way.take() {
            Some((Action::Read(_) | Action::Write(..), _)) => self.stray = true,
            Some((Action::Download(_), _)) => {
                master.abort_download();
                self.stray_words = true;
            }
            Some((Action::Arm(_) | Action::Force | Action::AwaitRecord, _)) => {
                master.abort_record();
                // This end is no result.
                let _ = master.poll_record();
            }
            _ => {}
        }
    }

    /// A mark on the rotor passes. False, and nothing happens, if this is not counted now.
    pub(super) fn mark(&mut self, now: u64) -> bool {
        let counts = matches!(self.under_way, Some((Action::Count, _)));
        if counts && self.marks == 0 {
            (self.first, self.marks) = (now, 1);
        }
        let span = now.saturating_sub(self.first);
        if counts && self.marks <= TURNS && span > self.span + SAME {
            (self.span, self.marks) = (span, self.marks + 1);
        }
        counts
    }

    /// Time of [`TURNS`] turns, by the marks, s.
    pub(super) fn time_of_turns(&self) -> f64 {
        self.span as f64 * 1e-6
    }

    /// The values that were read.
    pub(super) fn answers<const N: usize>(&mut self) -> [i32; N] {
        let answers = core::array::from_fn(|at| self.answers.get(at).copied().unwrap_or(0));
        self.answers.clear();
        answers
    }

    /// Everything else is dropped: the motor stops, and every parameter gets its value back.
    pub(super) fn restore(&mut self, master: &mut Master) {
        self.stop(master);
        // The last one first: what was written first holds.
        while let Some((number, raw)) = self.originals.pop() {
            let _ = self.actions.push_back(Action::Write(number, raw));
        }
    }

    /// Goes on; true once every action is done.
    pub(super) fn step(&mut self, master: &mut Master, now: u64) -> Done {
        self.stray = self.stray && master.poll_answer().is_none();
        self.stray_words = self.stray_words && master.poll_download().is_none();
        if self.stray || self.stray_words {
            return Ok(false);
        }
        loop {
            if self.under_way.is_none() {
                let Some(action) = self.actions.pop_front() else { return Ok(true) };
                self.begin(action, master)?;
                self.under_way = Some((action, now));
            }
            let Some((action, since)) = self.under_way else { continue };
            let done = self.is_done(action, master, now, now.saturating_sub(since));
            if matches!(done, Ok(false)) {
                return Ok(false);
            }
            self.under_way = None;
            done?;
        }
    }

    fn begin(&mut self, action: Action, master: &mut Master) -> Result<(), IdentificationError> {
        let taken = match action {
            Action::Read(number) => master.request(Request::Read { number }),
            Action::Write(number, raw) => {
                self.reads_first = !self.originals.iter().any(|(known, _)| *known == number);
                if self.reads_first {
                    master.request(Request::Read { number })
                } else {
                    master.request(Request::Write { number, raw })
                }
            }
            Action::Start(rpm) => master.begin(Job::Start { rpm }),
            Action::CalibrateHall => master.begin(Job::CalibrateHall),
            Action::Speed(rpm) => {
                master.set_speed(rpm);
                Ok(())
            }
            Action::Settle { .. } => {
                self.near = None;
                Ok(())
            }
            Action::Stop => {
                master.stop();
                // A job that this ends is not a result.
                let _ = master.poll_job();
                Ok(())
            }
            Action::Arm(setup) => master.begin(Job::ArmScope(setup)),
            Action::Force => master.begin(Job::ForceScope),
            Action::AwaitRecord => master.begin(Job::AwaitScope { within: PATIENCE }),
            Action::Download(words) => master.download(Download::Scope { words }),
            Action::Ready | Action::Wait(_) | Action::Count => Ok(()),
        };
        taken.map_err(IdentificationError::NotTaken)
    }

    fn is_done(&mut self, action: Action, master: &mut Master, now: u64, waited: u64) -> Done {
        match action {
            Action::Read(_) | Action::Write(..) => self.is_answered(action, master),
            Action::Ready => match master.state() {
                Some(State::Standby) => Ok(true),
                None | Some(State::Initialization) if waited < PATIENCE => Ok(false),
                state => Err(IdentificationError::NotInStandby(state)),
            },
            Action::Wait(time) => {
                has_no_fault(master)?;
                Ok(waited >= time)
            }
            Action::Start(_) | Action::CalibrateHall => match master.poll_job() {
                Some(end) => end.map(|()| true).map_err(IdentificationError::Job),
                None => Ok(false),
            },
            Action::Speed(_) => Ok(true),
            Action::Count => {
                has_no_fault(master)?;
                if waited > UNMARKED {
                    self.span = 0;
                }
                Ok(self.marks > TURNS || waited > UNMARKED)
            }
            Action::Settle { rpm, within } => self.has_settled(rpm, within, master, now, waited),
            Action::Stop => match master.state() {
                Some(State::Standby) if waited >= MARGIN => Ok(true),
                state if waited >= STOPS => {
                    has_no_fault(master)?;
                    Err(IdentificationError::NotInStandby(state))
                }
                _ => Ok(false),
            },
            Action::Arm(_) | Action::Force | Action::AwaitRecord => match master.poll_record() {
                Some(end) => end.map(|()| true).map_err(IdentificationError::Job),
                None => Ok(false),
            },
            Action::Download(_) => {
                while let Some(chunk) = master.poll_chunk() {
                    self.record.put(chunk.offset, chunk.words());
                }
                match master.poll_download() {
                    Some(end) => end.map(|_| true).map_err(IdentificationError::Download),
                    None => Ok(false),
                }
            }
        }
    }

    fn is_answered(&mut self, action: Action, master: &mut Master) -> Done {
        let Some(answer) = master.poll_answer() else { return Ok(false) };
        let value = answer.result.map_err(|error| IdentificationError::Request(answer.request, error))?;
        match action {
            Action::Write(number, raw) if self.reads_first => {
                self.reads_first = false;
                if value == raw {
                    return Ok(true);
                }
                // The scope's settings are everybody's.
                if number != number::SCOPE_PRESCALER {
                    let _ = self.originals.push((number, value));
                }
                master.request(Request::Write { number, raw }).map_err(IdentificationError::NotTaken)?;
                Ok(false)
            }
            Action::Write(..) => Ok(true),
            _ => {
                let _ = self.answers.push(value);
                Ok(true)
            }
        }
    }

    fn has_settled(&mut self, rpm: f64, within: u64, master: &Master, now: u64, waited: u64) -> Done {
        has_no_fault(master)?;
        let reached = master.speed().map_or(0, |received| received.value);
        let speed = f64::from(reached);
        if fabs(speed - rpm) > NEAR * rpm {
            self.near = None;
        } else if now.saturating_sub(*self.near.get_or_insert(now)) >= CALM {
            return Ok(true);
        }
        if waited < within {
            return Ok(false);
        }
        // A speed that is not held well is good enough to coast from.
        if speed > rpm / 4.0 { Ok(true) } else { Err(IdentificationError::NotReached { rpm, reached }) }
    }
}

fn has_no_fault(master: &Master) -> Result<(), IdentificationError> {
    if master.state() != Some(State::Fault) {
        return Ok(());
    }
    Err(match master.report().critical {
        Some(Received { value: CriticalFault { faults, code }, .. }) => {
            IdentificationError::Job(JobError::Fault { faults, code })
        }
        None => IdentificationError::NotInStandby(Some(State::Fault)),
    })
}
