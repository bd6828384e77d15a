//! Jobs of the scope and the log: they record and erase, and leave the motor alone.

use super::{Job, JobError, Next, Running, Step, View, fail};
use crate::dictionary::number;
use crate::master::error::RequestError;
use crate::master::requests::Request;
use crate::scope::{Refusal, State, period};

/// Time from one look at a recording scope to the next, and at a log that is erased, microseconds.
const SCOPE_PAUSE: u64 = 10_000;
const LOG_PAUSE: u64 = 100_000;
/// Logging states of a drive that erases its log, or has just done so (Table 8).
const ERASING: [u8; 2] = [9, 10];
/// Number of looks in turn that must find no erase under way.
const IDLE: u8 = 2;

/// Settings of a record of the scope: raw values of its parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ScopeSetup {
    /// Recorded signals, a bit each (parameter 22); 0 records the inputs of every control tick instead
    /// (parameter 300).
    pub channels: u32,
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
    /// Level of the triggers 1 to 4, thousandths of the signal's base (parameter 292).
    pub level: i32,
}

impl ScopeSetup {
    /// Returns the request that writes the setting at this place; `None` after the last one.
    pub(super) fn write(&self, place: u8) -> Option<Request> {
        let inputs = self.channels == 0;
        let content = if inputs {
            (number::SCOPE_INPUTS, 1)
        } else {
            // Parameters of every type have 32 bits; the cast keeps them.
            (number::SCOPE_CHANNELS, self.channels as i32)
        };
        let settings = [
            (number::SCOPE_INPUTS, 0),
            (number::SCOPE_SAMPLES, self.samples.into()),
            (number::SCOPE_PRESCALER, self.prescaler.into()),
            (number::SCOPE_TRIGGER_PHASE, self.before.into()),
            content,
            (number::SCOPE_TRIGGER_SIGNAL, self.signal.into()),
            (number::SCOPE_TRIGGER_LEVEL, self.level),
            (number::SCOPE_TRIGGER, self.trigger.into()),
        ];
        let has_level = matches!(self.trigger, 1..=4);
        let place = usize::from(place);
        let place = if has_level || place < 5 { place } else { place.saturating_add(2) };
        settings.get(place).map(|&(number, raw)| Request::Write { number, raw })
    }

    /// Checks a record of signals against a memory of `room` words.
    fn check(&self, room: u16) -> Result<(), JobError> {
        let Self { samples, prescaler, before, .. } = *self;
        let signals = self.channels.count_ones() as u8;
        let words = u32::from(samples).saturating_mul(signals.into());
        if room == 0 {
            Err(JobError::NoScopeMemory)
        } else if samples == 0 || words > u32::from(room) {
            Err(JobError::Samples { samples, signals, room })
        } else if prescaler < period(signals.into(), 0) {
            Err(JobError::Prescaler { prescaler, signals })
        } else if before >= samples {
            Err(JobError::Before { before, samples })
        } else {
            Ok(())
        }
    }
}

impl Job {
    /// Settings of the record that it arms.
    pub(super) const fn setup(self) -> Option<ScopeSetup> {
        match self {
            Self::ArmScope(setup) | Self::CaptureScope { setup, .. } => Some(setup),
            _ => None,
        }
    }
}

impl Running {
    /// Looks at the drive. waited: time since the step was first looked at.
    pub(super) fn look_at_record(&mut self, view: &View, now: u64, waited: u64) -> Next {
        Next::Step(match self.step {
            Step::Fill if now >= self.at.unwrap_or(now) => Step::ExpectArmed,
            Step::Pause if waited >= SCOPE_PAUSE => Step::ExpectDone,
            Step::Erasing if !view.connected => return fail(JobError::LostErasing),
            Step::Erasing if waited >= LOG_PAUSE => {
                if view.logging.is_some_and(|logging| ERASING.contains(&logging)) {
                    (self.idle, self.since) = (0, Some(now));
                    Step::Erasing
                } else {
                    Step::ReadLength
                }
            }
            step => step,
        })
    }

    /// Takes the value of the step's request.
    pub(super) fn take_of_record(&mut self, value: i32, now: u64) -> Next {
        let setup = self.job.setup().unwrap_or_default();
        Next::Step(match self.step {
            Step::ReadRoom => match setup.check(value as u16) {
                Ok(()) => Step::ExpectIdle,
                Err(error) => return fail(error),
            },
            Step::ExpectIdle => match State::of(value) {
                state @ (State::Armed | State::Recording) => return fail(JobError::ScopeBusy(state)),
                State::Idle | State::Done => Step::Set(0),
            },
            Step::Set(place) => {
                let next = place.saturating_add(1);
                if setup.write(next).is_some() { Step::Set(next) } else { Step::Arm }
            }
            Step::Arm | Step::Force if matches!(self.job, Job::ArmScope(_) | Job::ForceScope) => {
                return Next::End(Ok(()));
            }
            Step::Arm if setup.trigger == 0 => Step::ReadSamplingTime,
            Step::Arm | Step::Force => Step::ExpectDone,
            Step::ReadSamplingTime => {
                // A forced trigger counts once the samples before it were taken, however long that takes.
                let fill = u64::from(setup.before).saturating_mul(u64::from(value as u32));
                self.at = Some(now.saturating_add(fill));
                Step::Fill
            }
            Step::ExpectArmed => match State::of(value) {
                State::Armed => Step::Force,
                state => return fail(JobError::NotArmed(state)),
            },
            Step::ReadScopeRefusal => {
                return fail(match Refusal::of(value) {
                    Refusal::None => JobError::Request(Request::TriggerScope, RequestError::NotObeyed),
                    refusal => JobError::ScopeRefused(refusal),
                });
            }
            Step::ExpectDone => return self.expect_done(State::of(value), now),
            Step::Erase => Step::Erasing,
            Step::ReadLength if value > 0 => Step::ReadFull,
            Step::ReadLength => return self.rest(true),
            Step::ReadFull => return self.rest(value == 0),
            step => step,
        })
    }

    /// Ends the wait for a record, or goes on with it.
    fn expect_done(&mut self, state: State, now: u64) -> Next {
        let (Job::AwaitScope { within } | Job::CaptureScope { within, .. }) = self.job else {
            return Next::End(Ok(()));
        };
        let waited = now.saturating_sub(*self.begun.get_or_insert(now));
        match state {
            State::Done => Next::End(Ok(())),
            state if waited >= within => fail(JobError::NoTrigger { state, within }),
            _ => Next::Step(Step::Pause),
        }
    }

    /// Counts a look at the log that has found no erase under way, if `idle`. The status word may be older
    /// than the request, so one look is not enough.
    const fn rest(&mut self, idle: bool) -> Next {
        self.idle = if idle { self.idle.saturating_add(1) } else { 0 };
        if self.idle >= IDLE { Next::End(Ok(())) } else { Next::Step(Step::Erasing) }
    }
}
