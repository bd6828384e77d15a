//! Writing a transcript, call by call.

use super::{AGAIN, Answers, CALLS_VERSION, Transcribable};
use crate::recording::bytes::{Payload, push_varint};
use crate::recording::write::{Output, Sink};
use crate::recording::{BEHAVIOUR_VERSION, Header, RecordError, tag};
use serde::Serialize;

/// Room for the set-up of a device, bytes; most of it is a parameter set.
const SETUP_MAX: usize = 1024;

/// Records the calls of a shell to a device: [`new`](Self::new) at power-up, [`told`](Self::told) or
/// [`asked`](Self::asked) for every call, [`finish`](Self::finish).
#[derive(Debug)]
pub struct Transcriber<D: Transcribable, S> {
    output: Output<S>,
    payload: Payload,
    /// The last call, and the number of its repetitions.
    last: Option<D::Call>,
    again: u64,
    calls: u64,
    answers: Answers,
}

impl<D: Transcribable<Call: Clone>, S: Clone> Clone for Transcriber<D, S> {
    fn clone(&self) -> Self {
        Self {
            output: self.output.clone(),
            payload: self.payload.clone(),
            last: self.last.clone(),
            again: self.again,
            calls: self.calls,
            answers: self.answers.clone(),
        }
    }
}

impl<D: Transcribable, S: Sink> Transcriber<D, S> {
    /// Begins at power-up. `tick_rate`, Hz, and `label` go into the header.
    ///
    /// # Errors
    /// The label or the setup is too long, or the sink refuses.
    pub fn new(
        sink: S,
        tick_rate: u32,
        label: &str,
        setup: &D::Setup,
    ) -> Result<Self, RecordError<S::Error>> {
        let header = Header {
            kind: D::KIND,
            behaviour_version: BEHAVIOUR_VERSION,
            layout_version: CALLS_VERSION,
            tick_rate,
            label,
        };
        let mut room = [0; SETUP_MAX];
        let state = postcard::to_slice(setup, &mut room).map_err(|_| RecordError::StateTooLong)?;
        let output = Output::begin(sink, &header, state)?;
        let payload = Payload::new();
        Ok(Self { output, payload, last: None, again: 0, calls: 0, answers: Answers::default() })
    }

    /// Records a call without an answer.
    ///
    /// # Errors
    /// The call is too long, or the sink refuses.
    pub fn told(&mut self, call: D::Call) -> Result<(), RecordError<S::Error>> {
        self.calls = self.calls.saturating_add(1);
        if self.last.as_ref() == Some(&call) {
            self.again += 1;
            return Ok(());
        }
        self.repeat()?;
        if !append(&mut self.payload, &call) {
            self.flush()?;
            if !append(&mut self.payload, &call) {
                return Err(RecordError::EventTooLong);
            }
        }
        self.last = Some(call);
        Ok(())
    }

    /// Records a call and the device's answer.
    ///
    /// # Errors
    /// As [`told`](Self::told).
    pub fn asked(&mut self, call: D::Call, answer: &impl Serialize) -> Result<(), RecordError<S::Error>> {
        self.answers.answer(&call, answer);
        self.told(call)
    }

    /// Calls so far.
    pub const fn calls(&self) -> u64 {
        self.calls
    }

    /// Writes the end record and hands the sink back; `device` as it is after the last call.
    ///
    /// # Errors
    /// The sink refuses.
    pub fn finish(mut self, device: &D) -> Result<S, RecordError<S::Error>> {
        self.repeat()?;
        self.flush()?;
        device.show(&mut self.answers);
        self.output.end(self.calls, self.answers.value())
    }

    /// Writes the number of repetitions of the last call.
    fn repeat(&mut self) -> Result<(), RecordError<S::Error>> {
        if self.again == 0 {
            return Ok(());
        }
        let again = core::mem::take(&mut self.again);
        if !append_again(&mut self.payload, again) {
            self.flush()?;
            // An empty chunk has room for eleven bytes.
            append_again(&mut self.payload, again);
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), RecordError<S::Error>> {
        if !self.payload.is_empty() {
            self.output.chunk(tag::CALLS, &self.payload)?;
            self.payload.clear();
        }
        Ok(())
    }
}

/// Appends a call; false, with nothing changed, when it does not fit.
fn append(payload: &mut Payload, call: &impl Serialize) -> bool {
    let mark = payload.len();
    // Filling up to the capacity cannot fail. The room is zeroed once for each call; only the written bytes
    // are kept.
    let _ = payload.resize(payload.capacity(), 0);
    let room = payload.get_mut(mark..).unwrap_or_default();
    let written = postcard::to_slice(call, room).ok().map(|bytes| bytes.len());
    payload.truncate(mark + written.unwrap_or(0));
    written.is_some()
}

fn append_again(payload: &mut Payload, again: u64) -> bool {
    let mark = payload.len();
    let fits = payload.push(AGAIN).is_ok() && push_varint(payload, again).is_some();
    if !fits {
        payload.truncate(mark);
    }
    fits
}
