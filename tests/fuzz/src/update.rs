//! Target: programming over the bus. A drive's node, the server of its slots and its bootloader get messages,
//! time and power cuts in any order.

use crate::board::{Flash, HARDWARE, MAP, active, blank, boot, image, slot, version};
use crate::program::Program;
use crc::{CRC_32_ISO_HDLC, Crc};
use narx_boot::{Outcome, Server, Slot, Version};
use narx_core::bus::narmotion::update::{BLOCK, UpdateAnswer, UpdateRequest, UpdateState};
use narx_core::bus::narmotion::{Addresses, FromDrive, MotorMode, RequestWord, ToDrive};
use narx_core::motor::{Board, Event, State, Status};
use narx_core::node::{Action, Identity, Node};
use narx_sim::flash::Tear;

static CRC32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Runs an input: steps of a drive whose factory image has version 1.8.
pub fn run(data: &[u8]) {
    let mut program = Program(data);
    let mut flash = blank();
    flash.load(MAP.active.start, &image(HARDWARE, version(8), 100));
    let mut drive = Drive::power_up(flash, version(8));
    while !program.is_over() {
        drive.handle(&mut program);
    }
    drive.reboot();
}

struct Drive {
    node: Node,
    server: Server<Slot<Flash>>,
    now: u64,
    /// Version of the image that the last boot entered.
    running: Version,
    /// True if that image is not confirmed.
    trial: bool,
    state: State,
    /// Content of the active slot, which only the bootloader may change.
    active: Vec<u8>,
    /// Image that is being sent, and its next block.
    sending: (Vec<u8>, u16),
}

impl Drive {
    fn power_up(mut flash: Flash, running: Version) -> Self {
        let active = active(&mut flash);
        let mut server = Server::new(Slot::new(flash, MAP, HARDWARE).expect("the map fits"));
        let slots = server.slots().expect("it has its power");
        let mut node = Node::new(Identity::default(), Board::BENCH);
        node.attach_update(&slots);
        node.handle_status(Status { state: State::Standby, ..Status::default() });
        let trial = server.slot().condition().expect("it has its power").trial;
        Self { node, server, now: 0, running, trial, state: State::Standby, active, sending: (Vec::new(), 0) }
    }

    fn handle(&mut self, program: &mut Program<'_>) {
        let what = program.byte();
        match what % 10 {
            0 => self.tell(UpdateRequest::Begin {
                length: program.long(),
                hardware: HARDWARE ^ u32::from(what >> 4 & 1),
            }),
            // An image to be sent, valid or not.
            1 => {
                let (minor, words) = (program.byte(), program.byte());
                let mut image =
                    image(HARDWARE ^ u32::from(what >> 4 & 1), version(minor), usize::from(words % 192) + 1);
                if what & 0x20 != 0 {
                    image[usize::from(program.word()) % 512] ^= 1;
                }
                self.tell(UpdateRequest::Begin { length: image.len() as u32, hardware: HARDWARE });
                self.sending = (image, 0);
            }
            2 => self.send(program.byte()),
            3 => {
                let (block, data) = (program.word(), program.array());
                self.tell(UpdateRequest::Data { block, data });
            }
            4 => {
                let crc = CRC32.checksum(&self.sending.0) ^ u32::from(what >> 7);
                self.tell(UpdateRequest::End { crc });
            }
            5 => self.tell(match what >> 4 {
                0..=3 => UpdateRequest::Confirm,
                4..=7 => UpdateRequest::Status,
                8 => UpdateRequest::Device,
                9 => UpdateRequest::Version,
                _ => UpdateRequest::Abort,
            }),
            6 => (0..=program.byte()).for_each(|_| self.pass()),
            7 => {
                self.state =
                    [State::Standby, State::Fault, State::HallClosedLoop][usize::from(what >> 4) % 3];
                self.node.handle_status(Status { state: self.state, standstill: true, ..Status::default() });
            }
            8 => self.drive(),
            _ if what & 0x10 != 0 => {
                let tear = [Tear::Nothing, Tear::Partial, Tear::Garbage][usize::from(what >> 5) % 3];
                self.server.slot().flash().cut_after(program.word().into(), tear);
            }
            _ => self.reboot(),
        }
    }

    /// Sends blocks as a master does, some of them twice or not at all.
    fn send(&mut self, how: u8) {
        for count in 0..(how >> 2) {
            let (image, block) = &self.sending;
            let from = usize::from(*block) * BLOCK;
            let Some(bytes) = image.get(from..) else { return };
            let mut data = [0; BLOCK];
            data.iter_mut().zip(bytes).for_each(|(to, byte)| *to = *byte);
            let block = *block;
            self.tell(UpdateRequest::Data { block, data });
            let stays = how & 3 == 1 && count == 5;
            let skips = how & 3 == 2 && count == 9;
            self.sending.1 = block.wrapping_add(u16::from(!stays) + u16::from(skips));
            self.pass();
        }
    }

    fn tell(&mut self, request: UpdateRequest) {
        self.node.handle_frame(&ToDrive::Update(request).encode(Addresses::FACTORY));
        self.listen();
    }

    /// Requests Drive; on trial no motor may start.
    fn drive(&mut self) {
        let word = RequestWord { mode: MotorMode::Drive };
        while self.node.poll_event().is_some() {}
        self.node.handle_frame(&ToDrive::RequestWord(word).encode(Addresses::FACTORY));
        let commands = core::iter::from_fn(|| self.node.poll_event());
        let passed = commands.filter(|event| matches!(event, Event::Command(_))).count();
        self.tell(UpdateRequest::Status);
        if self.trial {
            assert_eq!(passed, 0, "on trial");
        }
    }

    fn listen(&mut self) {
        while let Some(frame) = self.node.poll_frame() {
            let (_, message) = FromDrive::decode(&frame).expect("a message of a drive");
            assert_eq!(message.encode(Addresses::FACTORY), frame);
            match message {
                FromDrive::Update(UpdateAnswer::Device { hardware, room }) => {
                    assert_eq!((hardware, room), (HARDWARE, MAP.room()));
                }
                FromDrive::Update(UpdateAnswer::Version(running)) => assert_eq!(running, self.running.into()),
                FromDrive::Update(UpdateAnswer::Status(status)) => {
                    assert!(status.offset <= MAP.room(), "{status:?}");
                    assert!(status.window == 0 || status.state == UpdateState::Receiving, "{status:?}");
                }
                _ => {}
            }
        }
    }

    /// Runs a pass of the shell's loop, a millisecond later.
    fn pass(&mut self) {
        self.now += 10;
        self.node.poll(self.now);
        if let Some(request) = self.node.poll_update() {
            let report = self.server.execute(&request);
            self.node.handle_update(report);
            // A confirmed image is no longer on trial.
            self.trial = self.server.slot().condition().map_or(self.trial, |condition| condition.trial);
        }
        self.listen();
        if self.node.poll_action() == Some(Action::Reboot) || self.server.slot().flash().is_off() {
            self.reboot();
        }
    }

    /// Reboots. Whatever was sent, a verified image must run: this one or a newer one, or the one before a
    /// trial.
    fn reboot(&mut self) {
        let flash = self.server.slot().flash();
        flash.restore_power();
        assert!(active(flash) == self.active, "the running image was altered");
        let marked = slot(flash).condition().expect("it has its power").marked;
        let outcome = boot(flash).expect("it has its power");
        let Outcome::Run { header, .. } = outcome else { panic!("{outcome:?}") };
        assert!(marked || self.trial || header.version == self.running, "{outcome:?}");
        assert!(self.trial || header.version >= self.running, "{outcome:?}");
        *self = Self::power_up(flash.clone(), header.version);
    }
}
