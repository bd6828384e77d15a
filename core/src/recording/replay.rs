//! Replays a recording.

use super::{Digest, Outputs, Recording, ReplayError, Ticks};
use crate::motor::machine::event::{Event, Status};
use crate::motor::{Drive, PwmCommand, Samples};
use serde::de::DeserializeOwned;

/// A device that can be replayed: the drive, with events and samples as inputs, commands and status as
/// outputs.
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

/// Result of a replay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Ticks run.
    pub ticks: u64,
    /// Digest of the outputs when they were recorded.
    pub recorded_digest: u64,
    /// Digest of the outputs now.
    pub digest: u64,
    /// Warning: the behaviour version of the recorder, if it is not that of this build. The digests may then
    /// rightly differ.
    pub other_behaviour: Option<u16>,
}

impl Outcome {
    /// Returns whether the outputs were the same, bit for bit.
    pub const fn is_identical(&self) -> bool {
        self.recorded_digest == self.digest
    }
}

/// Runs a drive from the recording's initial state through all of its ticks.
pub fn replay<D: Replayable + DeserializeOwned>(recording: &Recording<'_>) -> Result<Outcome, ReplayError> {
    replay_with::<D>(recording, |_, _, _| {})
}

/// Replays like [`replay`] and calls `observe` after each tick with the drive, the samples and its command.
pub fn replay_with<D: Replayable + DeserializeOwned>(
    recording: &Recording<'_>,
    mut observe: impl FnMut(&D, &Samples, &PwmCommand),
) -> Result<Outcome, ReplayError> {
    let mut player = Player::<D>::new(recording)?;
    while let Some((samples, outputs)) = player.step()? {
        observe(&player.drive, &samples, &outputs.command);
    }
    let end = match player.ticks.end() {
        Some(end) => end,
        None => recording.verify()?,
    };
    Ok(Outcome {
        ticks: end.ticks,
        recorded_digest: end.digest,
        digest: player.digest(),
        other_behaviour: (!recording.same_behaviour()).then_some(recording.header().behaviour_version),
    })
}

/// Runs a drive through the first `ticks` ticks of a recording. Bisection finds the tick in which two targets
/// differ: the shortest prefix with different digests ends with it.
///
/// # Errors
/// As [`replay`], for as much of the recording as is read.
pub fn replay_until<D: Replayable + DeserializeOwned>(
    recording: &Recording<'_>,
    ticks: u64,
) -> Result<Prefix, ReplayError> {
    let mut player = Player::<D>::new(recording)?;
    let mut prefix = Prefix { ticks: 0, digest: player.digest(), last: None };
    while prefix.ticks < ticks
        && let Some((_, outputs)) = player.step()?
    {
        prefix.ticks += 1;
        prefix.last = Some(outputs);
    }
    Ok(Prefix { digest: player.digest(), ..prefix })
}

/// The outputs of a recording's first ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Prefix {
    /// Ticks run: as many as asked for, or all of a shorter recording.
    pub ticks: u64,
    /// Digest of their outputs.
    pub digest: u64,
    /// Answer of the last of them; `None` if none was run.
    pub last: Option<Outputs>,
}

/// Runs a drive through a recording, tick by tick.
#[derive(Clone, Debug)]
pub struct Player<'a, D> {
    drive: D,
    ticks: Ticks<'a>,
    digest: Digest,
}

impl<'a, D: Replayable + DeserializeOwned> Player<'a, D> {
    /// A drive in the recording's initial state.
    ///
    /// # Errors
    /// The state is not one of this drive.
    pub fn new(recording: &Recording<'a>) -> Result<Self, ReplayError> {
        match postcard::take_from_bytes::<D>(recording.state()) {
            Ok((drive, [])) => Ok(Self { drive, ticks: recording.ticks(), digest: Digest::default() }),
            _ => Err(ReplayError::State),
        }
    }

    /// Runs the next tick; returns its samples and its answer, `None` after the last tick.
    ///
    /// # Errors
    /// The recording is damaged here.
    pub fn step(&mut self) -> Result<Option<(Samples, Outputs)>, ReplayError> {
        let Some(tick) = self.ticks.next().transpose()? else { return Ok(None) };
        if let Some(event) = tick.event {
            self.drive.handle_event(event);
        }
        let command = self.drive.step(&tick.samples);
        let status = self.drive.poll_status();
        self.digest.update(&command, status.as_ref());
        let outputs = Outputs { tick: tick.samples.tick, command, status };
        Ok(Some((tick.samples, outputs)))
    }

    /// The drive after the last tick.
    pub const fn drive(&self) -> &D {
        &self.drive
    }

    /// Digest of the outputs so far.
    pub fn digest(&self) -> u64 {
        self.digest.value()
    }
}
