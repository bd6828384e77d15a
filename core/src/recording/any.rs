//! Replays a recording of any kind.

use super::transcript::{self, Transcript};
use super::{Kind, Outcome, Prefix, Recording, ReplayError, header, replay, replay_until};
use crate::eddycan::TxDriver;
use crate::motor::Drive;
use crate::node::Node;

/// Replays a recording of a drive, its node or a TX-Driver. For a [transcript], `ticks` are calls.
///
/// # Errors
/// The file cannot be read, or is not of this build.
pub fn replay_any(file: &[u8]) -> Result<Outcome, ReplayError> {
    match header(file)?.kind {
        Kind::Drive => replay::<Drive>(&Recording::open(file)?),
        Kind::Node => transcript::replay::<Node>(&Transcript::open(file)?),
        Kind::TxDriver => transcript::replay::<TxDriver>(&Transcript::open(file)?),
    }
}

/// Replays the first `count` ticks or calls of a recording of any kind.
///
/// # Errors
/// As [`replay_any`], for as much of the file as is read.
pub fn replay_any_until(file: &[u8], count: u64) -> Result<Prefix, ReplayError> {
    match header(file)?.kind {
        Kind::Drive => replay_until::<Drive>(&Recording::open(file)?, count),
        Kind::Node => transcript::replay_until::<Node>(&Transcript::open(file)?, count),
        Kind::TxDriver => transcript::replay_until::<TxDriver>(&Transcript::open(file)?, count),
    }
}
