//! What the node has said of itself.

use crate::bus::eddycan::{FromNode, NmtState, PdoKind, Reading};

/// The last of everything, and how often.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// The state that the last heartbeat told.
    pub state: Option<NmtState>,
    /// When the last message came, microseconds.
    pub heard: Option<u64>,
    /// Boot-up messages, saturating.
    pub boots: u32,
    /// Error messages, saturating.
    pub errors: u32,
    /// Code of the last one; [`crate::bus::eddycan::ErrorCode::decode`] knows those of Table 13.
    pub last_error: Option<u16>,
    /// Frames of the node that mean nothing, saturating: PDOs of another layout, above all.
    pub malformed: u32,
    pub(super) reading: Option<(Reading, PdoKind, u64)>,
}

impl Report {
    pub(super) fn note(&mut self, message: &FromNode, now: u64) {
        self.heard = Some(now);
        match *message {
            FromNode::Heartbeat(state) => {
                self.state = Some(state);
                if state == NmtState::BootUp {
                    self.boots = self.boots.saturating_add(1);
                    // What it measured before is of another life.
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
