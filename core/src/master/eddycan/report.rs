//! Last messages of the node.

use crate::bus::eddycan::{FromNode, NmtState, PdoKind, Reading};
use crate::dictionary::Decimal;
use crate::eddycan::Entry;

/// Last message of each kind, and counters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// State of the last heartbeat.
    pub state: Option<NmtState>,
    /// Time of the last message, microseconds.
    pub received: Option<u64>,
    /// Boot-up messages, saturating.
    pub boots: u32,
    /// Error messages, saturating.
    pub errors: u32,
    /// Code of the last error; [`crate::bus::eddycan::ErrorCode::decode`] knows those of Table 13.
    pub last_error: Option<u16>,
    /// Frames of the node that cannot be decoded, saturating: mostly PDOs of another layout.
    pub malformed: u32,
    /// Known data of its encoder.
    pub encoder: Encoder,
    pub(super) reading: Option<(Reading, PdoKind, u64)>,
}

/// Data of a node's encoder, as far as this master has read or written its entries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Encoder {
    /// Rotary, or else linear (bit 1 of 2005h).
    pub rotary: Option<bool>,
    /// Length of a linear encoder's count, nm (2009h).
    pub resolution: Option<u16>,
}

impl Encoder {
    /// Counts of the encoder: two's complement for a linear one, unsigned for a rotary one and while the kind
    /// is unknown.
    pub const fn counts(&self, reading: &Reading) -> i32 {
        match self.rotary {
            Some(false) => reading.encoder as i16 as i32,
            _ => reading.encoder as i32,
        }
    }

    /// Position of a linear encoder, mm: counts times resolution. `None` for a rotary one, and while 2005h or
    /// 2009h is not known.
    pub const fn position(&self, reading: &Reading) -> Option<Decimal> {
        match (self.rotary, self.resolution) {
            // 10^-6 mm are 1 nm.
            (Some(false), Some(resolution)) => {
                Some(Decimal { digits: self.counts(reading) as i64 * resolution as i64, exponent: -6 })
            }
            _ => None,
        }
    }

    pub(super) fn note(&mut self, entry: Entry, value: u32) {
        match entry {
            Entry::BasicConfig => self.rotary = Some(value & 2 != 0),
            Entry::EncoderResolution => self.resolution = u16::try_from(value).ok(),
            _ => {}
        }
    }
}

impl Report {
    pub(super) fn note(&mut self, message: &FromNode, now: u64) {
        self.received = Some(now);
        match *message {
            FromNode::Heartbeat(state) => {
                self.state = Some(state);
                if state == NmtState::BootUp {
                    self.boots = self.boots.saturating_add(1);
                    // A reading from before the boot no longer counts.
                    self.reading = None;
                }
            }
            FromNode::Error { code } => {
                self.errors = self.errors.saturating_add(1);
                self.last_error = Some(code);
            }
            FromNode::Pdo { kind, reading } => self.reading = Some((reading, kind, now)),
            FromNode::Sdo(_) => {}
        }
    }
}
