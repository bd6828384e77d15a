//! The bus of a drive without the drive: a bootloader with it receives an image over CAN.

use super::{Moment, Next, Receiver, SlotReply, SlotTask, Slots};
use crate::bus::Frame;
use crate::bus::narmotion::update::{UpdateAnswer, UpdateCode, UpdateRequest};
use crate::bus::narmotion::{Addresses, MessageId, MessageKind, Opcode, Priority, Words};

/// Receives an image, and nothing else: of a drive's messages it knows those of programming (PROTOCOL.md,
/// section 11) and REBOOT. Time has milliseconds for ticks here.
#[derive(Clone, Debug)]
pub struct Loader {
    receiver: Receiver,
    addresses: Addresses,
    answer: Option<UpdateAnswer>,
    is_over: bool,
}

impl Loader {
    /// Over these slots, at the drive's addresses.
    pub fn new(slots: &Slots, addresses: Addresses) -> Self {
        Self { receiver: Receiver::new(slots), addresses, answer: None, is_over: false }
    }

    /// Takes a frame of the bus. Every frame that is not for this drive changes nothing.
    pub fn handle_frame(&mut self, frame: &Frame, now_ms: u64) {
        let Ok((id, words)) = Words::of(frame) else { return };
        if id.destination != self.addresses.drive || id.source != self.addresses.master {
            return;
        }
        let request = match id.kind {
            MessageKind::DataSet if id.opcode == Opcode::REBOOT => {
                self.is_over = true;
                return;
            }
            MessageKind::DataSet => UpdateRequest::decode_set(id.opcode, words),
            MessageKind::DataRequest => UpdateRequest::decode_request(id.opcode),
            MessageKind::SlaveTx => return,
        };
        if let Ok(request) = request
            && let Ok(Some(answer)) = self.receiver.handle(request, moment(now_ms))
        {
            self.answer = Some(answer);
        }
    }

    /// Returns the next task for the slot; at most one is under way.
    pub fn poll_task(&mut self, now_ms: u64) -> Option<SlotTask> {
        let next = self.receiver.run(moment(now_ms));
        self.go_on(next);
        self.receiver.poll(moment(now_ms)).ok().flatten()
    }

    /// Takes the reply to the last task.
    pub fn handle_reply(&mut self, reply: SlotReply, now_ms: u64) {
        let next = self.receiver.handle_reply(reply, moment(now_ms));
        self.go_on(next);
    }

    /// Returns the frame to send, if there is one. A newer status replaces one that has not been sent.
    pub fn poll_frame(&mut self) -> Option<Frame> {
        let answer = self.answer.take()?;
        let id = MessageId {
            priority: Priority::Low,
            source: self.addresses.drive,
            destination: self.addresses.master,
            kind: MessageKind::SlaveTx,
            opcode: answer.opcode(),
        };
        Some(answer.encode().frame(id))
    }

    /// Returns whether the device is to restart: the master has asked for it.
    pub const fn is_over(&self) -> bool {
        self.is_over
    }

    fn go_on(&mut self, next: Next) {
        match next {
            Next::Nothing => {}
            Next::Tell(code) => self.tell(code),
            Next::Restart => self.is_over = true,
        }
    }

    fn tell(&mut self, code: UpdateCode) {
        self.answer = Some(self.receiver.status(code));
    }
}

/// No motor turns under a bootloader.
const fn moment(now_ms: u64) -> Moment {
    Moment { now: now_ms, tick_rate: 1000, is_stopped: true }
}
