//! Set-up of a record: the signals or inputs, and the trigger.

use super::Refusal;
use crate::motor::signal::{DRIVE_SIGNALS, ShaftScale, Signal};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Signals that are read in one tick. More signals take further ticks, because a tick's time belongs to the
/// control.
pub const SIGNALS_A_TICK: usize = 4;

/// A requested record. It does not follow later changes of the parameters.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Setup {
    /// The signals of a sample, in the order of their bits (parameter 22).
    pub signals: Vec<Signal, { DRIVE_SIGNALS.len() }>,
    /// Records the inputs of every tick instead of signals (parameter 300). `samples` are then ticks, and the
    /// record holds more ticks before the trigger than `before`: as many as the memory has room for.
    pub inputs: bool,
    /// Control ticks a second, stored in a recording.
    pub tick_rate: u32,
    /// Samples of each signal (parameter 23).
    pub samples: u16,
    /// Ticks from one sample to the next (parameter 24), at least as many as reading it takes:
    /// [`period`](Self::period).
    pub prescaler: u16,
    /// Samples from before the trigger (parameter 26), fewer than all.
    pub before: u16,
    /// Trigger that the scope waits for.
    pub trigger: Trigger,
    /// Scale of the speeds.
    pub speed: ShaftScale,
}

/// Condition that begins the recording. A second trigger request begins it, too, whatever is chosen here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Trigger {
    /// Only a second trigger request.
    #[default]
    Forced,
    /// The signal is above the level, or below it.
    Level(Threshold),
    /// The signal rises above the level, or falls below it.
    Edge(Threshold),
    /// The drive's state changes.
    StateChange,
    /// A bit of FAULT_WORD appears.
    Fault,
}

/// A side of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Threshold {
    /// Signal that is compared.
    pub signal: Signal,
    /// Sample, Q3.12 of the signal's base.
    pub level: i16,
    /// Above it, else below.
    pub above: bool,
}

impl Setup {
    /// Returns whether all samples of the signals have room in a memory of `room` words.
    pub(crate) fn fits(&self, room: usize) -> bool {
        let words = self.signals.len() * usize::from(self.samples);
        (1..=room).contains(&words)
    }

    /// Returns the reason why a drive with a memory of `room` words (`None` if unknown) could not record as
    /// requested.
    pub(crate) fn refusal(&self, room: Option<u16>) -> Result<(), Refusal> {
        match room {
            _ if self.inputs => Ok(()),
            Some(0) => Err(Refusal::NoMemory),
            Some(room) if !self.fits(room.into()) => Err(Refusal::TooLong),
            _ if self.period() > self.prescaler => Err(Refusal::TooFast),
            _ if self.before >= self.samples => Err(Refusal::TooEarly),
            _ => Ok(()),
        }
    }

    /// Ticks from one sample to the next.
    pub fn period(&self) -> u16 {
        period(self.signals.len(), self.prescaler)
    }
}

/// Ticks from one sample of `signals` signals to the next.
pub fn period(signals: usize, prescaler: u16) -> u16 {
    (signals.div_ceil(SIGNALS_A_TICK) as u16).max(prescaler).max(1)
}
