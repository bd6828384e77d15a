//! The bench's bus from outside: the host's place on it, a listener's, and that of another node.

use super::Bench;
use crate::can::{Attachment, NodeIndex, NotQueued, Received};
use narx_core::bus::Frame;

impl Bench {
    /// Queues a frame of the host; it takes part in the arbitration from now on.
    ///
    /// # Errors
    /// The host's queue of 64 is full.
    pub fn send(&mut self, frame: Frame) -> Result<(), NotQueued> {
        self.bus.send(self.host, frame, self.now_ns())
    }

    /// Frames of the host that still wait for the bus.
    pub fn host_queued(&self) -> usize {
        self.bus.queued(self.host)
    }

    /// The next frame that arrived at the host.
    pub fn receive(&mut self) -> Option<Received> {
        self.bus.receive(self.host)
    }

    /// The next frame that passed on the bus, whoever sent it.
    pub fn monitor(&mut self) -> Option<Received> {
        self.bus.receive(self.monitor)
    }

    /// The host's place: who sent what [`Bench::send`] took.
    pub const fn host(&self) -> NodeIndex {
        self.host
    }

    /// The drive's place.
    pub const fn own(&self) -> NodeIndex {
        self.own
    }

    /// Cuts the host off the bus, or connects it again.
    pub fn set_host(&mut self, attachment: Attachment) {
        self.bus.set_attachment(self.host, attachment);
    }

    /// Puts another node on the bus, or takes it away as at the start.
    pub fn set_other(&mut self, attachment: Attachment) {
        self.bus.set_attachment(self.other, attachment);
    }

    /// Queues a frame of the other node.
    ///
    /// # Errors
    /// Its queue of 64 is full.
    pub fn send_as_other(&mut self, frame: Frame) -> Result<(), NotQueued> {
        self.bus.send(self.other, frame, self.now_ns())
    }

    /// Frames of the other node that still wait for the bus.
    pub fn other_queued(&self) -> usize {
        self.bus.queued(self.other)
    }

    /// The next frame that arrived at the other node.
    pub fn receive_as_other(&mut self) -> Option<Received> {
        self.bus.receive(self.other)
    }

    /// Disturbs the next `frames` frames on the bus at bit `bit`, whoever sends them; 0 ends it.
    pub fn disturb_bus(&mut self, frames: u32, bit: u32) {
        self.bus.inject_errors(frames, bit);
    }

    /// Frames that the drive's controller has lost because nobody took them.
    pub fn overruns(&self) -> u32 {
        self.bus.overruns(self.own)
    }
}
