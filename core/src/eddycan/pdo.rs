//! When PDO1 is sent.

use super::configuration::{Configuration, UpdateTime};
use super::objects::Entry;
use crate::bus::eddycan::{Bitrate, Layout, NodeId};

/// The timer of PDO1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Timer {
    /// When the next one is due; `None` before the first one.
    due: Option<u64>,
}

impl Timer {
    /// Whether one is due; the first one `offset` after the first call. Of several that were missed one is made, and the next comes when it
    /// would have come anyway.
    pub(super) fn is_due(&mut self, now: u64, period: Option<u64>, offset: u64) -> bool {
        let Some(period) = period.filter(|period| *period > 0) else { return false };
        let due = *self.due.get_or_insert(now.saturating_add(offset));
        let late = now.checked_sub(due);
        if let Some(late) = late {
            self.due = Some(due.saturating_add((late / period + 1).saturating_mul(period)));
        }
        late.is_some()
    }

    /// When the next one is due; `None` before the first.
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

/// How long after Operational was entered PDO1 begins, microseconds. Nodes that share half of the bus take turns by their node-ids: started by one command
/// they would all send at once, and a bus of 127 would be busy for as long as a drive's frames then have to wait.
pub(super) fn offset(configuration: &Configuration, node: NodeId, period: Option<u64>) -> u64 {
    match (configuration.update_time(), period) {
        (UpdateTime::HalfLoad, Some(period)) => {
            let nodes = u64::from(configuration.acting(Entry::NrOfNodes)).max(1);
            u64::from(node.raw() - 1) % nodes * (period / nodes)
        }
        _ => 0,
    }
}
