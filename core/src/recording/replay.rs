//! Running a recording again.

use super::{Digest, Recording, ReplayError};
use crate::motor::event::{Event, Status};
use crate::motor::{Drive, PwmCommand, Samples};
use serde::de::DeserializeOwned;

/// What can be replayed: the drive, seen as events and samples in, commands and status out.
pub trait Replayable {
    /// Takes an event; at most one before each tick.
    fn handle_event(&mut self, event: Event);
    /// One control tick.
    fn step(&mut self, samples: &Samples) -> PwmCommand;
    /// The status, if this tick reported one.
    fn poll_status(&mut self) -> Option<Status>;
}

impl Replayable for Drive {
    fn handle_event(&mut self, event: Event) {
        self.handle_event(event);
    }
    fn step(&mut self, samples: &Samples) -> PwmCommand {
        self.step(samples)
    }
    fn poll_status(&mut self) -> Option<Status> {
        self.poll_status()
    }
}

/// What a replay found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Ticks run.
    pub ticks: u64,
    /// Digest of the outputs when they were recorded.
    pub recorded_digest: u64,
    /// Digest of the outputs now.
    pub digest: u64,
    /// A warning: the behaviour version that recorded, where it is another one than ours. The digests may then
    /// rightly differ.
    pub other_behaviour: Option<u16>,
}

impl Outcome {
    /// Whether the outputs were the same, bit for bit.
    pub const fn is_identical(&self) -> bool {
        self.recorded_digest == self.digest
    }
}

/// Runs a drive from the recording's initial state through all of its ticks.
pub fn replay<D: Replayable + DeserializeOwned>(recording: &Recording<'_>) -> Result<Outcome, ReplayError> {
    replay_with::<D>(recording, |_, _, _| {})
}

/// The same, showing `observe` the drive after each tick with the samples and its command.
pub fn replay_with<D: Replayable + DeserializeOwned>(
    recording: &Recording<'_>,
    mut observe: impl FnMut(&D, &Samples, &PwmCommand),
) -> Result<Outcome, ReplayError> {
    let Ok((mut drive, [])) = postcard::take_from_bytes::<D>(recording.state()) else {
        return Err(ReplayError::State);
    };
    let mut digest = Digest::default();
    let mut ticks = recording.ticks();
    for tick in &mut ticks {
        let tick = tick?;
        if let Some(event) = tick.event {
            drive.handle_event(event);
        }
        let command = drive.step(&tick.samples);
        digest.update(&command, drive.poll_status().as_ref());
        observe(&drive, &tick.samples, &command);
    }
    let end = match ticks.end() {
        Some(end) => end,
        None => recording.verify()?,
    };
    Ok(Outcome {
        ticks: end.ticks,
        recorded_digest: end.digest,
        digest: digest.value(),
        other_behaviour: (!recording.same_behaviour()).then_some(recording.header().behaviour_version),
    })
}
