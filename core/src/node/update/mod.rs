//! Programming over the bus: what the bootloader's slot and the node say to each other, the receiver of an
//! image, and the loader, which is a drive's bus without the drive.

mod loader;
mod receiver;

pub use loader::Loader;
pub use receiver::PIECE;
pub(crate) use receiver::{Moment, Next, Receiver};

use super::requests::Refused;

use super::Node;
use crate::bus::narmotion::FromDrive;
use crate::bus::narmotion::update::{ImageVersion, UpdateCode, UpdateRequest};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// State of the slots at power-up, from the shell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Slots {
    /// Hardware id that an image must have.
    pub hardware: u32,
    /// Longest image, header included, bytes.
    pub room: u32,
    /// Bytes that one [`SlotTask::Erase`] erases; 0 if the running program stands where the image will be,
    /// and has to leave for the bootloader, which receives it ([`SlotTask::Leave`]).
    pub page: u32,
    /// Version of the running image; zeros if the running program is no image.
    pub running: ImageVersion,
    /// State that the bootloader has left.
    pub condition: Condition,
}

/// State that the bootloader has left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Condition {
    /// Nothing is under way. The code is the reason why the last image does not run, or [`UpdateCode::Done`].
    Settled(UpdateCode),
    /// An image is marked for the next boot.
    Marked,
    /// The running image needs a confirmation.
    Trial,
}

impl Default for Condition {
    fn default() -> Self {
        Self::Settled(UpdateCode::Done)
    }
}

/// Task of the shell for the slot. Offsets are bytes from the slot's beginning.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SlotTask {
    /// Remove the mark, if there is one.
    Clear,
    /// Erase a page.
    Erase {
        /// Beginning of the page.
        offset: u32,
    },
    /// Write into erased flash. The last piece is filled up with ones to a whole number of 32 bytes.
    Write {
        /// Place of the data.
        offset: u32,
        /// The data.
        data: Vec<u8, PIECE>,
    },
    /// Read back bytes and continue the CRC-32 (ISO-HDLC) with them; at offset 0 the CRC begins anew.
    Sum {
        /// Place of the bytes: behind those of the request before.
        offset: u32,
        /// Number of bytes.
        length: u32,
    },
    /// Look at the header, and mark the image for the next boot.
    Mark {
        /// Length of the image, bytes.
        length: u32,
    },
    /// Keep the running image.
    Confirm,
    /// Have the next boot receive an image. The restart follows.
    Leave,
}

/// Reply to a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SlotReply {
    /// Done.
    Done,
    /// The CRC-32 so far.
    Sum(u32),
    /// Not done.
    Failed(UpdateCode),
}

impl Node {
    /// Connects the node to its slots, at power-up: from now on [`Node::poll_update`] returns requests. The
    /// device reports the version of the running image as its own (BUILD_INFO, DEVICE_INFO, parameters 5 and
    /// 6).
    pub fn attach_update(&mut self, slots: &Slots) {
        self.update = Receiver::new(slots);
        if slots.running != ImageVersion::default() {
            let ImageVersion { major, minor, build, .. } = slots.running;
            (self.identity.software_release, self.identity.build_number) =
                (u16::from_be_bytes([major, minor]), build);
            self.show_identity();
        }
    }

    /// Returns the next request about the slot; at most one is under way.
    pub fn poll_update(&mut self) -> Option<SlotTask> {
        if self.update.is_quiet() {
            return None;
        }
        let moment = self.moment();
        self.update.poll(moment).unwrap_or_else(|code| {
            self.tell_update(code);
            None
        })
    }

    /// Takes the report on the last request.
    pub fn handle_update(&mut self, report: SlotReply) {
        let moment = self.moment();
        let next = self.update.handle_reply(report, moment);
        self.go_on_with_update(next);
    }

    /// Handles a message. A refused one is answered with the reason, so it is not counted.
    pub(super) fn handle_update_message(&mut self, request: UpdateRequest) -> Result<(), Refused> {
        let moment = self.moment();
        if let Some(answer) = self.update.handle(request, moment)? {
            self.send(FromDrive::Update(answer));
        }
        Ok(())
    }

    /// Checks the time-outs of receiving and of the trial.
    pub(super) fn run_update(&mut self) {
        if self.update.is_quiet() {
            return;
        }
        let moment = self.moment();
        let next = self.update.run(moment);
        self.go_on_with_update(next);
    }

    fn moment(&self) -> Moment {
        Moment { now: self.flash.now(), tick_rate: self.board.tick_rate, is_stopped: self.is_stopped() }
    }

    fn go_on_with_update(&mut self, next: Next) {
        match next {
            Next::Nothing => {}
            Next::Tell(code) => self.tell_update(code),
            Next::Restart => self.pending.reboot = true,
        }
    }

    fn tell_update(&mut self, code: UpdateCode) {
        self.send(FromDrive::Update(self.update.status(code)));
    }
}
