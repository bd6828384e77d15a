//! Messages waiting for the bus: two bounded queues, the urgent one first.

use crate::blind;
use crate::bus::narmotion::{Addressless, FromDrive, Opcode};
use heapless::Deque;
use serde::{Deserialize, Serialize};

/// Answers, status and fault words that may wait.
const URGENT: usize = 32;
/// Measurements that may wait: more than one broadcast.
const MEASUREMENTS: usize = 8;

/// The output queue. A message that finds no room is dropped and counted.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Outbox {
    urgent: Deque<Addressless, URGENT>,
    measurements: Deque<Addressless, MEASUREMENTS>,
    lost: u32,
}

impl Outbox {
    /// Queues an answer, a status or a fault word.
    pub(super) fn push(&mut self, message: FromDrive) {
        if is_blind(message) {
            return;
        }
        if self.urgent.push_back(message.addressless()).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// Queues a measurement.
    pub(super) fn push_measurement(&mut self, message: FromDrive) {
        if is_blind(message) {
            return;
        }
        if self.measurements.push_back(message.addressless()).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// Drops the measurements that were not sent: newer ones follow.
    pub(super) fn discard_measurements(&mut self) {
        self.lost = self.lost.saturating_add(self.measurements.len() as u32);
        self.measurements.clear();
    }

    /// Drops the status and fault words that were not sent: newer ones follow.
    pub(super) fn discard_words(&mut self) {
        for _ in 0..self.urgent.len() {
            if let Some(message) = self.urgent.pop_front() {
                if [Opcode::STATUS_WORD, Opcode::FAULT_WORD].contains(&message.opcode()) {
                    self.lost = self.lost.saturating_add(1);
                } else {
                    // There is room: the message was just taken out.
                    let _ = self.urgent.push_back(message);
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

    /// The next message for the bus.
    pub(super) fn pop(&mut self) -> Option<Addressless> {
        self.urgent.pop_front().or_else(|| self.measurements.pop_front())
    }

    /// Returns whether no message waits.
    pub(super) fn is_empty(&self) -> bool {
        self.urgent.is_empty() && self.measurements.is_empty()
    }

    /// Messages dropped since power-up, saturating.
    pub(super) const fn lost(&self) -> u32 {
        self.lost
    }
}

fn is_blind(message: FromDrive) -> bool {
    blind::to("message", message.opcode().raw().into())
}

impl PartialEq for Outbox {
    fn eq(&self, other: &Self) -> bool {
        self.urgent.iter().eq(other.urgent.iter())
            && self.measurements.iter().eq(other.measurements.iter())
            && self.lost == other.lost
    }
}
