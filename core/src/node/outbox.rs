//! Frames waiting for the bus: two bounded queues, the urgent one first.

use crate::bus::Frame;
use heapless::Deque;
use serde::{Deserialize, Serialize};

/// Answers, status and fault words that may wait.
const URGENT: usize = 32;
/// Measurements that may wait: more than one broadcast.
const MEASUREMENTS: usize = 8;

/// The output queue. A frame that finds no room is dropped and counted.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Outbox {
    urgent: Deque<Frame, URGENT>,
    measurements: Deque<Frame, MEASUREMENTS>,
    lost: u32,
}

impl Outbox {
    /// Queues an answer, a status or a fault word.
    pub(super) fn push(&mut self, frame: Frame) {
        if self.urgent.push_back(frame).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// Queues a measurement.
    pub(super) fn push_measurement(&mut self, frame: Frame) {
        if self.measurements.push_back(frame).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// Drops the measurements that were not sent: newer ones follow.
    pub(super) fn discard_measurements(&mut self) {
        self.lost = self.lost.saturating_add(self.measurements.len() as u32);
        self.measurements.clear();
    }

    /// Drops the status and fault words that were not sent: newer ones follow.
    pub(super) fn discard_words(&mut self, is_word: impl Fn(&Frame) -> bool) {
        for _ in 0..self.urgent.len() {
            if let Some(frame) = self.urgent.pop_front() {
                if is_word(&frame) {
                    self.lost = self.lost.saturating_add(1);
                } else {
                    // It has just left this place.
                    let _ = self.urgent.push_back(frame);
                }
            }
        }
    }

    /// Drops everything.
    pub(super) fn clear(&mut self) {
        self.lost = self.lost.saturating_add(self.urgent.len() as u32);
        self.urgent.clear();
        self.discard_measurements();
    }

    /// The next frame for the bus.
    pub(super) fn pop(&mut self) -> Option<Frame> {
        self.urgent.pop_front().or_else(|| self.measurements.pop_front())
    }

    /// Nothing waits.
    pub(super) fn is_empty(&self) -> bool {
        self.urgent.is_empty() && self.measurements.is_empty()
    }

    /// Frames dropped since power-up, saturating.
    pub(super) const fn lost(&self) -> u32 {
        self.lost
    }
}

impl PartialEq for Outbox {
    fn eq(&self, other: &Self) -> bool {
        self.urgent.iter().eq(other.urgent.iter())
            && self.measurements.iter().eq(other.measurements.iter())
            && self.lost == other.lost
    }
}
