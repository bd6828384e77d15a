//! Transcripts of a TX-Driver: its set-up and the shell's calls.

use super::{Answers, Transcribable};
use crate::bus::{BusState, Frame};
use crate::eddycan::{Configuration, Sample, TxDriver, Variant};
use crate::recording::{Kind, ReplayError};
use serde::{Deserialize, Serialize};

/// Set-up of a TX-Driver at power-up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TxDriverSetup {
    /// Hardware and firmware of the driver.
    pub variant: Variant,
    /// The configuration that was stored.
    pub configuration: Configuration,
}

/// Call of a shell to a TX-Driver: see [`TxDriver`]. Times are microseconds after the last time that was
/// passed in. A call that asks for an answer is recorded only if there was one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "each is the call of the same name")]
pub enum TxDriverCall {
    Frame(Frame, i64),
    BusState(BusState),
    Sample(Sample),
    Store(bool),
    Poll(i64),
    /// A sample, and `poll` at once: a driver gets these 40 000 times a second.
    SampleAndPoll(Sample, i64),
    PollFrame,
    PollStore,
    TakeReset,
    /// Levels that differ from those before.
    Outputs,
}

impl Transcribable for TxDriver {
    const KIND: Kind = Kind::TxDriver;
    type Setup = TxDriverSetup;
    type Call = TxDriverCall;

    fn power_up(setup: TxDriverSetup) -> Result<Self, ReplayError> {
        Ok(Self::new(setup.variant, setup.configuration))
    }

    fn call(&mut self, call: &TxDriverCall, clock: &mut u64, answers: &mut Answers) {
        let mut at = |after: i64| {
            *clock = clock.wrapping_add_signed(after);
            *clock
        };
        match call {
            TxDriverCall::Frame(frame, after) => self.handle_frame(frame, at(*after)),
            TxDriverCall::BusState(state) => self.handle_bus_state(*state),
            TxDriverCall::Sample(sample) => self.handle_sample(*sample),
            TxDriverCall::Store(done) => self.handle_store(*done),
            TxDriverCall::Poll(after) => self.poll(at(*after)),
            TxDriverCall::SampleAndPoll(sample, after) => {
                self.handle_sample(*sample);
                self.poll(at(*after));
            }
            TxDriverCall::PollFrame => answers.answer(call, &self.poll_frame()),
            TxDriverCall::PollStore => answers.answer(call, &self.poll_store()),
            TxDriverCall::TakeReset => answers.answer(call, &self.take_reset()),
            TxDriverCall::Outputs => answers.answer(call, &self.outputs()),
        }
    }

    /// Notes its configuration, state and lines.
    fn show(&self, answers: &mut Answers) {
        answers.note(self.configuration());
        answers.note(&(self.state() as u8));
        answers.note(&self.outputs());
    }
}
