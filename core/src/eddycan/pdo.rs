//! Timing of PDO1.

use super::configuration::{Configuration, UpdateTime};
use super::objects::Entry;
use crate::bus::eddycan::{Bitrate, Layout, NodeId};

/// The timer of PDO1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Timer {
    /// Time of the next PDO1, microseconds; `None` before the first.
    due: Option<u64>,
}

impl Timer {
    /// Returns whether PDO1 is due; the first is due `offset` after the first call. If several were missed,
    /// only one is sent, and the next comes at its regular time.
    pub(super) fn is_due(&mut self, now: u64, period: Option<u64>, offset: u64) -> bool {
        let Some(period) = period.filter(|period| *period > 0) else { return false };
        let due = *self.due.get_or_insert(now.saturating_add(offset));
        let late = now.checked_sub(due);
        if let Some(late) = late {
            self.due = Some(due.saturating_add((late / period + 1).saturating_mul(period)));
        }
        late.is_some()
    }

    /// Time of the next PDO1, microseconds; `None` before the first.
    pub(super) const fn due(&self) -> Option<u64> {
        self.due
    }
}

/// Period of PDO1 in microseconds; `None` if it is not sent.
pub(super) fn period(configuration: &Configuration, layout: Layout, bitrate: Bitrate) -> Option<u64> {
    match configuration.update_time() {
        UpdateTime::Off => None,
        UpdateTime::Every(milliseconds) => Some(u64::from(milliseconds) * 1000),
        // All nodes together: nodes * longest frame / period = 1/2.
        UpdateTime::HalfLoad => {
            let frame = bitrate.longest_frame_us(layout.length());
            Some(2 * u64::from(configuration.acting(Entry::NrOfNodes)) * u64::from(frame))
        }
    }
}

/// Delay of the first PDO1 after Operational is entered, microseconds. Nodes that share half of the bus take
/// turns by their node-ids: started by one command they would all send at once, and a drive's frames would
/// have to wait until up to 127 nodes have sent.
pub(super) fn offset(configuration: &Configuration, node: NodeId, period: Option<u64>) -> u64 {
    match (configuration.update_time(), period) {
        (UpdateTime::HalfLoad, Some(period)) => {
            let nodes = u64::from(configuration.acting(Entry::NrOfNodes)).max(1);
            u64::from(node.raw() - 1) % nodes * (period / nodes)
        }
        _ => 0,
    }
}
