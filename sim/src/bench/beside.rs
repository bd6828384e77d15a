//! Two drives on one bus: each on a bench of its own, the bus on the first one's.

use super::Bench;
use core::mem::swap;

impl Bench {
    /// Moves this bench's drive to the bus of `first`, where it gets a place of its own; host, listener and
    /// other node are those of `first`. False if the bus has no place left. Both drives must have just been
    /// powered up and tick at the same rate, and need different addresses.
    #[must_use]
    pub fn move_beside(&mut self, first: &mut Self) -> bool {
        let Some(own) = first.bus.attach() else { return false };
        (self.own, self.host, self.monitor, self.other) = (own, first.host, first.monitor, first.other);
        true
    }

    /// One control tick on the bus of `first`, after that bench's own [`step`](Self::step).
    pub fn step_beside(&mut self, first: &mut Self) {
        swap(&mut self.bus, &mut first.bus);
        self.step();
        swap(&mut self.bus, &mut first.bus);
    }
}
