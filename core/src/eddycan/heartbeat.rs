//! The heartbeat's clock (section 3.4.1).

/// Period, microseconds.
pub(super) const PERIOD_US: u64 = 2_000_000;

/// Timer of the heartbeat. It runs from the boot-up on, whether heartbeats are sent or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Heartbeat {
    /// Time of the next heartbeat, microseconds; `None` before the first `poll`.
    due: Option<u64>,
}

impl Heartbeat {
    /// Returns whether a heartbeat is due. The first is due 2 s after the boot-up, but at once if the node
    /// has gone on to Operational by itself. Missed heartbeats are not sent later.
    pub(super) fn is_due(&mut self, now: u64, autostart: bool) -> bool {
        let Some(due) = self.due else {
            self.due = Some(now.saturating_add(PERIOD_US));
            return autostart;
        };
        let late = now.checked_sub(due);
        if let Some(late) = late {
            self.due = Some(due.saturating_add((late / PERIOD_US + 1).saturating_mul(PERIOD_US)));
        }
        late.is_some()
    }

    /// Time of the next heartbeat, microseconds.
    pub(super) const fn due(&self) -> Option<u64> {
        self.due
    }
}
