//! A controller on the bus: its queues and its error counters.

use heapless::Deque;
use narx_core::bus::{ErrorState, Frame};

/// A node of one [`Bus`](super::Bus), as [`attach`](super::Bus::attach) numbered it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct NodeIndex(pub(super) usize);

/// Participation of a node in the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Attachment {
    /// Sends, receives and acknowledges.
    #[default]
    Normal,
    /// Receives and disturbs nobody.
    ListenOnly,
    /// Unpowered or cut off: neither sees nor is seen.
    Detached,
}

/// A frame as a node received it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received {
    /// The frame.
    pub frame: Frame,
    /// End of its last bit (end of frame), ns.
    pub time_ns: u64,
    /// Sender of the frame.
    pub sender: NodeIndex,
}

/// A frame that waits for the bus.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending {
    pub(super) frame: Frame,
    /// Since when, ns.
    pub(super) since: u64,
}

/// Times 11 recessive bits until a node recovers from bus-off.
pub(super) const RECOVERY: u32 = 128;

/// One controller.
#[derive(Clone, Debug)]
pub(super) struct Node<const QUEUE: usize> {
    pub(super) bitrate: u32,
    pub(super) attachment: Attachment,
    /// Sends the frame under way: one node, unless several chose the same identifier.
    pub(super) sends: bool,
    pub(super) outgoing: Deque<Pending, QUEUE>,
    pub(super) incoming: Deque<Received, QUEUE>,
    /// Received frames that found no room, saturating.
    pub(super) overruns: u32,
    pub(super) transmit_errors: u16,
    pub(super) receive_errors: u16,
    /// Sends nothing before this instant, ns: bus-off on a bus that stays idle, or an error-passive sender's
    /// suspension.
    pub(super) held_until: u64,
    /// Number of times that a node off the bus has still to see 11 recessive bits; 0 while it takes part.
    to_see: u32,
}

impl<const QUEUE: usize> Node<QUEUE> {
    pub(super) fn new(bitrate: u32) -> Self {
        Self {
            bitrate,
            attachment: Attachment::Normal,
            sends: false,
            outgoing: Deque::new(),
            incoming: Deque::new(),
            overruns: 0,
            transmit_errors: 0,
            receive_errors: 0,
            held_until: 0,
            to_see: 0,
        }
    }

    pub(super) fn error_state(&self) -> ErrorState {
        if self.to_see > 0 {
            ErrorState::BusOff
        } else if self.transmit_errors > 127 || self.receive_errors > 127 {
            ErrorState::Passive
        } else {
            ErrorState::Active
        }
    }

    /// Takes part in sending and acknowledging.
    pub(super) fn is_sender(&self) -> bool {
        self.attachment == Attachment::Normal && self.to_see == 0
    }

    /// Sees what happens on the bus.
    pub(super) fn is_listener(&self) -> bool {
        self.attachment != Attachment::Detached && self.to_see == 0
    }

    /// Earliest start of its oldest frame, ns; after bus-off that is the end of the recovery.
    pub(super) fn ready_at(&self) -> Option<u64> {
        let pending = self.outgoing.front().filter(|_| self.attachment == Attachment::Normal)?;
        Some(pending.since.max(self.held_until))
    }

    /// A frame of its own was destroyed. `acknowledge` says that nobody acknowledged it: an error-passive
    /// node does not count that, so a lone node keeps trying and never goes bus-off.
    pub(super) fn count_transmit_error(&mut self, acknowledge: bool, until_recovered: u64) {
        if acknowledge && self.error_state() == ErrorState::Passive {
            return;
        }
        self.transmit_errors += 8;
        if self.transmit_errors > 255 {
            self.to_see = RECOVERY;
            self.held_until = until_recovered;
        }
    }

    /// Another node's frame was destroyed.
    pub(super) fn count_receive_error(&mut self) {
        self.receive_errors = (self.receive_errors + 1).min(255);
    }

    /// Its oldest frame has arrived.
    pub(super) fn count_sent(&mut self) {
        self.outgoing.pop_front();
        self.transmit_errors = self.transmit_errors.saturating_sub(1);
    }

    pub(super) fn receive(&mut self, received: Received) {
        // From error passive, a good frame leads back to the top of error active.
        self.receive_errors = self.receive_errors.min(128).saturating_sub(1);
        if self.incoming.push_back(received).is_err() {
            self.overruns = self.overruns.saturating_add(1);
        }
    }

    /// The bus has been idle for so many times 11 bits, and is now taken by another node: what is still to
    /// see waits for its end.
    pub(super) fn watch_idle(&mut self, seen: u32) {
        if self.to_see > 0 {
            self.to_see = self.to_see.saturating_sub(seen).max(1);
            self.held_until = u64::MAX;
        }
    }

    /// Another node's frame ends, with 11 recessive bits: acknowledge or error delimiter, end of frame,
    /// intermission. `idle` tells when so many times 11 bits more have passed if nobody sends.
    pub(super) fn watch_end(&mut self, idle: impl FnOnce(u32) -> u64) {
        if self.to_see > 0 {
            self.to_see -= 1;
            self.held_until = idle(self.to_see);
            if self.to_see == 0 {
                self.rejoin();
            }
        }
    }

    /// Ends bus-off once its time is over. Returns the instant of that end, ns; `u64::MAX` for a node that is
    /// not bus-off.
    pub(super) fn recover(&mut self, now: u64) -> u64 {
        if self.to_see == 0 {
            return u64::MAX;
        }
        if now >= self.held_until {
            self.rejoin();
        }
        self.held_until
    }

    fn rejoin(&mut self) {
        self.to_see = 0;
        self.transmit_errors = 0;
        self.receive_errors = 0;
    }
}
