//! What the scope is asked to record, and when.

use super::Refusal;
use crate::motor::signal::{DRIVE_SIGNALS, ShaftScale, Signal};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Signals that are read in one tick. More share as many further ticks: a tick's time is the control's.
pub const SIGNALS_A_TICK: usize = 4;

/// A recording that is asked for. It does not follow later changes of the parameters.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Setup {
    /// The signals of a sample, in the order of their bits (parameter 22).
    pub signals: Vec<Signal, { DRIVE_SIGNALS.len() }>,
    /// Instead of signals the inputs of every tick (parameter 300). `samples` are then ticks, and more go before than `before`: what the
    /// memory has room for.
    pub inputs: bool,
    /// Control ticks a second, which a recording tells.
    pub tick_rate: u32,
    /// Samples of each (parameter 23).
    pub samples: u16,
    /// Ticks from one to the next (parameter 24), at least as many as reading it takes: [`period`](Self::period).
    pub prescaler: u16,
    /// Samples from before the trigger (parameter 26), fewer than all.
    pub before: u16,
    /// What the scope waits for.
    pub trigger: Trigger,
    /// Of the speeds.
    pub speed: ShaftScale,
}

/// What begins the recording. A second trigger request does so, too, whatever is chosen here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Trigger {
    /// Nothing else does.
    #[default]
    Forced,
    /// The signal is above the level, or below it.
    Level(Threshold),
    /// It comes to be above the level, or below it.
    Edge(Threshold),
    /// The drive's state changes.
    StateChange,
    /// A bit of FAULT_WORD appears.
    Fault,
}

/// A side of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Threshold {
    /// What is compared.
    pub signal: Signal,
    /// Sample, Q3.12 of the signal's base.
    pub level: i16,
    /// Above it, else below.
    pub above: bool,
}

impl Setup {
    /// Whether all samples of signals have room in a memory of so many words.
    pub(crate) fn fits(&self, room: usize) -> bool {
        let words = self.signals.len() * usize::from(self.samples);
        (1..=room).contains(&words)
    }

    /// What a drive whose memory holds so many words, if that is known, would not keep of it as it was asked for.
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

/// Ticks from one sample of so many signals to the next.
pub fn period(signals: usize, prescaler: u16) -> u16 {
    (signals.div_ceil(SIGNALS_A_TICK) as u16).max(prescaler).max(1)
}
