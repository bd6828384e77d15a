//! Transcript of a TX-Driver: the inputs and queries that it gets.

use crate::recording::RecordingBuffer;
use alloc::string::String;
use alloc::vec::Vec;
use narx_core::bus::{BusState, Frame};
use narx_core::eddycan::{Configuration, Sample, TxDriver, Variant};
use narx_core::recording::transcript::{Transcriber, TxDriverCall, TxDriverSetup};

/// A transcript in the making.
#[derive(Clone, Debug)]
pub(super) struct Notes {
    /// `None` once a call did not fit: what there is of it would be another story.
    transcriber: Option<Transcriber<TxDriver, RecordingBuffer>>,
    label: String,
    /// The last time that was told, microseconds.
    now: u64,
    bus: BusState,
    outputs: Option<[bool; 2]>,
    /// A sample that was not written down yet: most often time is told right after it.
    sample: Option<Sample>,
}

impl Notes {
    /// Begins at power-up.
    pub(super) fn new(variant: Variant, configuration: Configuration, label: &str) -> Option<Self> {
        let setup = TxDriverSetup { variant, configuration };
        let sink = RecordingBuffer::default();
        let transcriber = Transcriber::new(sink, variant.sample_rate, label, &setup).ok()?;
        Some(Self {
            transcriber: Some(transcriber),
            label: label.into(),
            now: 0,
            bus: BusState::default(),
            outputs: None,
            sample: None,
        })
    }

    /// The transcript so far.
    pub(super) fn finish(&self, driver: &TxDriver) -> Vec<u8> {
        let finished = self.transcriber.clone().and_then(|transcriber| transcriber.finish(driver).ok());
        finished.unwrap_or_default().0
    }

    /// It restarts: so does the transcript.
    pub(super) fn reset(&mut self, variant: Variant, configuration: Configuration) {
        let fresh = Self::new(variant, configuration, &self.label);
        *self = fresh.unwrap_or(Self { transcriber: None, ..self.clone() });
    }

    pub(super) fn frame(&mut self, frame: &Frame, now: u64) {
        let after = self.after(now);
        self.told(TxDriverCall::Frame(*frame, after));
    }

    /// Told in every pass, written down where it is another one.
    pub(super) fn bus_state(&mut self, state: BusState) {
        if core::mem::replace(&mut self.bus, state) != state {
            self.told(TxDriverCall::BusState(state));
        }
    }

    pub(super) fn sample(&mut self, sample: Sample) {
        self.catch_up();
        self.sample = Some(sample);
    }

    pub(super) fn poll(&mut self, now: u64) {
        let after = self.after(now);
        match self.sample.take() {
            Some(sample) => self.told(TxDriverCall::SampleAndPoll(sample, after)),
            None => self.told(TxDriverCall::Poll(after)),
        }
    }

    pub(super) fn stored(&mut self, configuration: Configuration) {
        self.write(|transcriber| transcriber.asked(TxDriverCall::PollStore, &Some(configuration)));
        self.told(TxDriverCall::Store(true));
    }

    pub(super) fn sent(&mut self, frame: Frame) {
        self.write(|transcriber| transcriber.asked(TxDriverCall::PollFrame, &Some(frame)));
    }

    /// Looked at in every pass, written down where they are other ones.
    pub(super) fn outputs(&mut self, outputs: [bool; 2]) {
        if self.outputs.replace(outputs) != Some(outputs) {
            self.write(|transcriber| transcriber.asked(TxDriverCall::Outputs, &outputs));
        }
    }

    fn after(&mut self, now: u64) -> i64 {
        now.wrapping_sub(core::mem::replace(&mut self.now, now)) as i64
    }

    fn told(&mut self, call: TxDriverCall) {
        self.write(|transcriber| transcriber.told(call));
    }

    /// Writes down the sample that waits, which came before the next call.
    fn catch_up(&mut self) {
        if let Some(sample) = self.sample.take() {
            self.told(TxDriverCall::Sample(sample));
        }
    }

    fn write<E>(&mut self, write: impl FnOnce(&mut Transcriber<TxDriver, RecordingBuffer>) -> Result<(), E>) {
        self.catch_up();
        if let Some(transcriber) = &mut self.transcriber
            && write(transcriber).is_err()
        {
            self.transcriber = None;
        }
    }
}
