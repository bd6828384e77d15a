//! A master and a node with nothing between them but frames, some of which are lost; no motor, no bench.

use crate::support::{Flash, HARDWARE, Hasty, MAP, NEW, slot};
use narx_boot::{Outcome, Server, Slot};
use narx_core::bus::Frame;
use narx_core::bus::narmotion::update::{UpdateAnswer, UpdateRequest, UpdateStatus};
use narx_core::bus::narmotion::{Addresses, FromDrive, MotorMode, RequestWord, ToDrive};
use narx_core::dictionary::number;
use narx_core::master::{Config, Image, Master, UpdateError};
use narx_core::motor::{Board, State, Status};
use narx_core::node::{Action, Identity, Node};
use narx_sim::random::Random;
use std::collections::VecDeque;

/// A drive with its slots, served by a shell.
pub(crate) struct Drive {
    pub(crate) node: Node,
    pub(crate) server: Server<Slot<Flash>>,
    /// Control ticks.
    now: u64,
    /// The shell does not serve its flash.
    pub(crate) is_stuck: bool,
}

impl Drive {
    pub(crate) fn new(flash: Flash) -> Self {
        let server = Server::new(Slot::new(flash, MAP, HARDWARE).unwrap());
        let node = Node::new(Identity::default(), Board::BENCH);
        let mut drive = Self { node, server, now: 0, is_stuck: false };
        drive.power_up();
        drive
    }

    fn power_up(&mut self) {
        self.node = Node::new(Identity::default(), Board::BENCH);
        self.node.attach_update(&self.server.slots().unwrap());
        self.set_state(State::Standby);
        while self.node.poll_frame().is_some() {}
    }

    pub(crate) fn set_state(&mut self, state: State) {
        self.node.handle_status(Status { state, standstill: true, ..Status::default() });
    }

    /// Runs the bootloader on the drive's flash, then powers the drive up anew.
    pub(crate) fn reboot(&mut self) {
        let flash = self.server.slot().flash();
        assert!(matches!(Hasty::boot(flash), Ok(Outcome::Run { .. })));
        self.power_up();
    }

    /// A pass of the shell's loop, a millisecond later; true if the drive has restarted.
    pub(crate) fn pass(&mut self) -> bool {
        self.now += 10;
        self.node.poll(self.now);
        if !self.is_stuck
            && let Some(request) = self.node.poll_update()
        {
            let report = self.server.execute(&request);
            self.node.handle_update(report);
        }
        self.node.poll_action() == Some(Action::Reboot)
    }

    /// Lets it work for so many milliseconds.
    pub(crate) fn run(&mut self, milliseconds: u64) {
        (0..milliseconds).for_each(|_| assert!(!self.pass()));
    }

    pub(crate) fn tell(&mut self, request: UpdateRequest) {
        self.node.handle_frame(&ToDrive::Update(request).encode(Addresses::FACTORY));
    }

    pub(crate) fn request(&mut self, mode: MotorMode) {
        let word = RequestWord { mode };
        self.node.handle_frame(&ToDrive::RequestWord(word).encode(Addresses::FACTORY));
    }

    /// Everything of programming that it has said, in order.
    pub(crate) fn received(&mut self) -> Vec<UpdateAnswer> {
        let frames = std::iter::from_fn(|| self.node.poll_frame());
        let messages = frames.map(|frame| FromDrive::decode(&frame).unwrap().1);
        messages
            .filter_map(|message| match message {
                FromDrive::Update(answer) => Some(answer),
                _ => None,
            })
            .collect()
    }

    /// Sends a request and returns the drive's last status after it.
    pub(crate) fn ask(&mut self, request: UpdateRequest) -> UpdateStatus {
        self.received();
        self.tell(request);
        match self.received().last() {
            Some(UpdateAnswer::Status(status)) => *status,
            other => panic!("{request:?}: {other:?}"),
        }
    }

    /// Frames that it has refused: parameter 274, as a master reads it.
    pub(crate) fn refused(&mut self) -> i32 {
        self.received();
        let read = ToDrive::RequestParameter { number: number::REFUSED_FRAMES };
        self.node.handle_frame(&read.encode(Addresses::FACTORY));
        let answer = self.node.poll_frame().and_then(|frame| FromDrive::decode(&frame).ok());
        match answer {
            Some((_, FromDrive::Parameter { value, .. })) => value,
            other => panic!("{other:?}"),
        }
    }

    /// Begins with an image and sends all of it; the node has acknowledged every byte.
    pub(crate) fn send(&mut self, image: &[u8]) {
        self.tell(UpdateRequest::Begin { length: image.len() as u32, hardware: HARDWARE });
        self.run(20);
        for (block, bytes) in image.chunks(6).enumerate() {
            let mut data = [0xA5; 6];
            data[..bytes.len()].copy_from_slice(bytes);
            self.tell(UpdateRequest::Data { block: block as u16, data });
            self.run(1);
        }
    }

    pub(crate) fn is_marked(&mut self) -> bool {
        slot(self.server.slot().flash()).condition().unwrap().marked
    }
}

/// The end of the wire that is programmed.
pub(crate) trait Programmed {
    fn handle_frame(&mut self, frame: &Frame);
    fn poll_frame(&mut self) -> Option<Frame>;
    /// A pass of its loop, a millisecond later; true if it restarts.
    fn pass(&mut self) -> bool;
    fn reboot(&mut self);
}

impl Programmed for Drive {
    fn handle_frame(&mut self, frame: &Frame) {
        self.node.handle_frame(frame);
    }

    fn poll_frame(&mut self) -> Option<Frame> {
        self.node.poll_frame()
    }

    fn pass(&mut self) -> bool {
        Self::pass(self)
    }

    fn reboot(&mut self) {
        Self::reboot(self);
    }
}

/// Both ends.
pub(crate) struct Wire<D = Drive> {
    pub(crate) drive: D,
    pub(crate) master: Master,
    pub(crate) bytes: Vec<u8>,
    /// Control ticks.
    pub(crate) now: u64,
    /// Frames lost of a thousand, each way.
    pub(crate) loss: u64,
    pub(crate) random: Random,
    /// Blocks that were sent, lost ones and repeated ones among them.
    pub(crate) blocks: usize,
    /// Until then the drive, or whoever carries its frames, does something else, control ticks; frames wait.
    pub(crate) busy_until: u64,
    /// Time that a frame to the drive takes, control ticks.
    pub(crate) latency: u64,
    /// Frames on their way to it, and when each is there.
    waiting: VecDeque<(u64, Frame)>,
}

impl Wire {
    pub(crate) fn new(flash: Flash, bytes: Vec<u8>) -> Self {
        Self::to(Drive::new(flash), bytes)
    }
}

impl<D: Programmed> Wire<D> {
    pub(crate) fn to(drive: D, bytes: Vec<u8>) -> Self {
        let config = Config { read_parameters: false, ..Config::default() };
        let master = Master::new(config);
        Self {
            drive,
            master,
            bytes,
            now: 0,
            loss: 0,
            random: Random::new(5),
            blocks: 0,
            busy_until: 0,
            latency: 0,
            waiting: VecDeque::new(),
        }
    }

    pub(crate) fn begin(&mut self) {
        let image = Image::new(HARDWARE, NEW.into(), &self.bytes);
        self.master.update(image).unwrap();
    }

    /// A millisecond.
    pub(crate) fn step(&mut self) {
        let now = self.now * 100;
        while let Some(frame) = self.poll_master(now) {
            if !self.is_lost() {
                self.waiting.push_back((self.now + self.latency, frame));
            }
        }
        self.now += 10;
        if self.now <= self.busy_until {
            return;
        }
        while let Some((_, frame)) = self.waiting.pop_front_if(|(due, _)| *due < self.now) {
            self.drive.handle_frame(&frame);
        }
        let restarts = self.drive.pass();
        while let Some(frame) = self.drive.poll_frame() {
            if !self.is_lost() {
                self.master.handle_frame(&frame, now);
            }
        }
        if restarts {
            self.drive.reboot();
        }
    }

    fn poll_master(&mut self, now: u64) -> Option<Frame> {
        self.master.poll_frame(now).or_else(|| {
            let block = self.master.poll_update_frame(now, &self.bytes)?;
            self.blocks += 1;
            Some(block)
        })
    }

    fn is_lost(&mut self) -> bool {
        self.random.bits() % 1000 < self.loss
    }

    /// The end, within so many seconds.
    pub(crate) fn finish(&mut self, seconds: u64) -> Option<Result<(), UpdateError>> {
        for _ in 0..seconds * 1000 {
            self.step();
            let end = self.master.poll_update();
            if end.is_some() {
                return end;
            }
        }
        None
    }
}
