//! Messages that wait for the bus. Each kind has one place, answers have four: so nothing grows, and a newer
//! message of a kind replaces an older one.

use super::errors::Errors;
use crate::bus::eddycan::{FromNode, NmtState, PdoKind, Reading, SdoAnswer};
use heapless::Vec;

/// Answers that may wait.
const ANSWERS: usize = 4;

/// Messages that wait.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Outbox {
    /// The boot-up message has been sent.
    booted: bool,
    pub(super) errors: Errors,
    heartbeat: bool,
    /// PDO1, PDO2, PDO3.
    pdos: [Option<Reading>; 3],
    answers: Vec<SdoAnswer, ANSWERS>,
    /// Kind that comes first for the next frame: 0 to 2 the PDOs, 3 the answers.
    turn: u8,
}

/// PDOs and answers take turns.
const TURNS: u8 = 4;

impl Outbox {
    /// Replaces the PDO of this kind.
    pub(super) fn put_pdo(&mut self, kind: PdoKind, reading: Reading) {
        let [timer, sync, remote] = &mut self.pdos;
        let place = match kind {
            PdoKind::Timer => timer,
            PdoKind::Sync => sync,
            PdoKind::Remote => remote,
        };
        *place = Some(reading);
    }

    pub(super) const fn put_heartbeat(&mut self) {
        self.heartbeat = true;
    }

    /// Returns whether there is room for another answer.
    pub(super) fn has_room(&self) -> bool {
        !self.answers.is_full()
    }

    pub(super) fn put_answer(&mut self, answer: SdoAnswer) {
        // The SDO server has checked that there is room.
        let _ = self.answers.push(answer);
    }

    pub(super) const fn discard_pdos(&mut self) {
        self.pdos = [None; 3];
    }

    pub(super) fn discard_answers(&mut self) {
        self.answers.clear();
    }

    /// Drops messages that would be out of date when the bus comes back. A waiting boot-up or error message
    /// is kept: it has not been sent yet.
    pub(super) fn discard_present(&mut self) {
        self.discard_pdos();
        self.discard_answers();
        self.heartbeat = false;
    }

    /// Takes the next message: boot-up, errors and heartbeat are rare and come first. PDOs and answers take
    /// turns, because either could come so fast that the other would never be sent.
    pub(super) fn pop(&mut self, state: NmtState, now: u64) -> Option<FromNode> {
        if !core::mem::replace(&mut self.booted, true) {
            return Some(FromNode::Heartbeat(NmtState::BootUp));
        }
        if let Some(code) = self.errors.pop(now) {
            return Some(FromNode::Error { code: code as u16 });
        }
        if core::mem::take(&mut self.heartbeat) {
            return Some(FromNode::Heartbeat(state));
        }
        let first = self.turn;
        for place in (0..TURNS).map(|step| (first + step) % TURNS) {
            if let Some(message) = self.take(place) {
                self.turn = (place + 1) % TURNS;
                return Some(message);
            }
        }
        None
    }

    fn take(&mut self, place: u8) -> Option<FromNode> {
        let [timer, sync, remote] = &mut self.pdos;
        let (kind, pdo) = match place {
            0 => (PdoKind::Timer, timer),
            1 => (PdoKind::Sync, sync),
            2 => (PdoKind::Remote, remote),
            _ if self.answers.is_empty() => return None,
            _ => return Some(FromNode::Sdo(self.answers.remove(0))),
        };
        pdo.take().map(|reading| FromNode::Pdo { kind, reading })
    }
}
