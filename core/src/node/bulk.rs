//! Bulk frames: downloads, behind everything else that the drive sends.

use super::Node;
use crate::blind;
use crate::bus::Frame;
use serde::{Deserialize, Serialize};

/// The kinds of downloads: those under way take turns, frame by frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Turn {
    #[default]
    Description,
    Log,
    Scope,
}

impl Turn {
    const fn next(self) -> Self {
        match self {
            Self::Description => Self::Log,
            Self::Log => Self::Scope,
            Self::Scope => Self::Description,
        }
    }
}

impl Node {
    /// Returns the next bulk frame; none while anything else waits. Give the controller a second one while
    /// the first is on the bus, but no third: later frames wait behind them.
    #[inline(never)]
    pub fn poll_bulk_frame(&mut self) -> Option<Frame> {
        if self.link.state.is_off() || !self.outbox.is_empty() {
            return None;
        }
        let turn = self.turn;
        [turn, turn.next(), turn.next().next()].into_iter().find_map(|turn| {
            let frame = match turn {
                Turn::Description => self.next_of_description(),
                Turn::Log => self.next_of_log(),
                Turn::Scope => self.next_of_scope(),
            };
            self.turn = turn.next();
            frame.filter(|frame| !blind::to("message", frame.id().raw() & 0x7FF))
        })
    }
}
