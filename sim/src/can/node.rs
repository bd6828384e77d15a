//! A controller on the bus: its queues and its error counters.

use heapless::Deque;
use narx_core::bus::Frame;

/// A node of one [`Bus`](super::Bus), as [`attach`](super::Bus::attach) numbered it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct NodeIndex(pub(super) usize);

/// How a node takes part.
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

/// Fault confinement state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorState {
    /// Takes part and signals errors with dominant flags.
    Active,
    /// An error counter has passed 127: takes part, but its error flags no longer disturb others.
    Passive,
    /// The transmit error counter has passed 255: does not take part for 128 x 11 bit times.
    BusOff,
}

/// A frame as a node received it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received {
    /// The frame.
    pub frame: Frame,
    /// End of its last bit (end of frame), ns.
    pub time_ns: u64,
    /// Who sent it.
    pub sender: NodeIndex,
}

/// A frame that waits for the bus.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending {
    pub(super) frame: Frame,
    /// Since when, ns.
    pub(super) since: u64,
}

/// One controller.
#[derive(Debug)]
pub(super) struct Node<const QUEUE: usize> {
    pub(super) bitrate: u32,
    pub(super) attachment: Attachment,
    pub(super) outgoing: Deque<Pending, QUEUE>,
    pub(super) incoming: Deque<Received, QUEUE>,
    /// Received frames that found no room, saturating.
    pub(super) overruns: u32,
    pub(super) transmit_errors: u16,
    pub(super) receive_errors: u16,
    /// Sends nothing before this instant, ns: bus-off, or an error-passive sender's suspension.
    pub(super) held_until: u64,
    bus_off: bool,
}

impl<const QUEUE: usize> Node<QUEUE> {
    pub(super) fn new(bitrate: u32) -> Self {
        Self {
            bitrate,
            attachment: Attachment::Normal,
            outgoing: Deque::new(),
            incoming: Deque::new(),
            overruns: 0,
            transmit_errors: 0,
            receive_errors: 0,
            held_until: 0,
            bus_off: false,
        }
    }

    pub(super) fn error_state(&self) -> ErrorState {
        if self.bus_off {
            ErrorState::BusOff
        } else if self.transmit_errors > 127 || self.receive_errors > 127 {
            ErrorState::Passive
        } else {
            ErrorState::Active
        }
    }

    /// Takes part in sending and acknowledging.
    pub(super) fn is_sender(&self) -> bool {
        self.attachment == Attachment::Normal && !self.bus_off
    }

    /// Sees what happens on the bus.
    pub(super) fn is_listener(&self) -> bool {
        self.attachment != Attachment::Detached && !self.bus_off
    }

    /// When its oldest frame may start, ns; after bus-off that is when it has recovered.
    pub(super) fn ready_at(&self) -> Option<u64> {
        let pending = self.outgoing.front().filter(|_| self.attachment == Attachment::Normal)?;
        Some(pending.since.max(self.held_until))
    }

    /// A frame of its own was destroyed. `acknowledge` says that nobody acknowledged it: an error-passive node
    /// does not count that, so a lone node keeps trying and never goes bus-off.
    pub(super) fn count_transmit_error(&mut self, acknowledge: bool, bus_off_until: u64) {
        if acknowledge && self.error_state() == ErrorState::Passive {
            return;
        }
        self.transmit_errors += 8;
        if self.transmit_errors > 255 {
            self.bus_off = true;
            self.held_until = bus_off_until;
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

    /// Ends bus-off once its time is over.
    pub(super) fn recover(&mut self, now: u64) {
        if self.bus_off && now >= self.held_until {
            self.bus_off = false;
            self.transmit_errors = 0;
            self.receive_errors = 0;
        }
    }
}
