//! A whole drive with its flash: node, control tick at standstill, storage; and its master.

use crate::support::{Chip, now, open};
use narx_core::bus::narmotion::{
    Addresses, FromDrive, MotorMode, ParameterStatus, RequestWord, StatusWord, ToDrive,
};
use narx_core::dictionary::number;
use narx_core::motor::guard::fault::FaultWord;
use narx_core::motor::{Board, Coefficients, Drive, Samples, State};
use narx_core::node::{Action, Identity, Node};
use narx_core::storage::{FlashReply, FlashTask, Record, Storage};

pub(crate) struct Device {
    pub(crate) node: Node,
    pub(crate) storage: Storage<Chip>,
    drive: Drive,
    pub(crate) now: u64,
    /// Holds back reports of the flash, as if it never answered.
    pub(crate) hold: bool,
    held: Option<FlashReply>,
    /// Number of stores that the drive has requested.
    pub(crate) stores: u32,
    /// Download frames taken per tick.
    pub(crate) download_rate: usize,
    pub(crate) received: Vec<FromDrive>,
}

impl Device {
    /// Powers up.
    pub(crate) fn new(chip: Chip) -> Self {
        let mut storage = Storage::new(chip);
        storage.flash().restore_power();
        let opened = open(&mut storage);
        let board = Board::BENCH;
        let drive = Drive::new(Coefficients::build(&opened.parameters, &board).unwrap());
        let mut node = Node::with_parameters(Identity::default(), board, opened.parameters.clone());
        node.attach_storage(&opened);
        Self {
            node,
            storage,
            drive,
            now: 0,
            hold: false,
            held: None,
            stores: 0,
            download_rate: 3,
            received: Vec::new(),
        }
    }

    /// Powers up, until Standby, or the state in which a fault keeps the drive.
    pub(crate) fn booted(chip: Chip) -> Self {
        let mut device = Self::new(chip);
        device.run(510);
        device
    }

    /// Reboots by a request on the bus: values that wait are stored first.
    pub(crate) fn reboot(mut self) -> Self {
        self.send(ToDrive::Reboot);
        for _ in 0..1000 {
            self.tick();
            if self.node.poll_action() == Some(Action::Reboot) {
                return self.power_cut();
            }
        }
        panic!("no reboot within 100 ms");
    }

    /// Cuts the power without warning, and restores it.
    pub(crate) fn power_cut(self) -> Self {
        Self::booted(self.storage.into_flash())
    }

    pub(crate) fn run(&mut self, milliseconds: u64) {
        (0..milliseconds * 10).for_each(|_| self.tick());
    }

    pub(crate) fn tick(&mut self) {
        if let Some(event) = self.node.poll_event() {
            self.drive.handle_event(event);
        }
        let bus_voltage = 2458;
        let samples = Samples {
            tick: self.now,
            bus_voltage,
            bus_current: 2048,
            phase_voltage: [bus_voltage / 2; 3],
            hall: 0b001,
            ..Samples::default()
        };
        self.drive.step(&samples);
        if let Some(status) = self.drive.poll_status() {
            self.node.handle_status(status);
        }
        self.node.poll(self.now);
        self.serve();
        while let Some(frame) = self.node.poll_frame() {
            self.received.push(FromDrive::decode(&frame).unwrap().1);
        }
        for _ in 0..self.download_rate {
            let frame = self.node.poll_bulk_frame();
            self.received.extend(frame.map(|frame| FromDrive::decode(&frame).unwrap().1));
        }
        self.now += 1;
    }

    /// Serves one request and its report, unless that is held back.
    fn serve(&mut self) {
        if let Some(request) = self.node.poll_storage() {
            assert!(self.held.is_none(), "one request at a time");
            self.stores += u32::from(matches!(request, FlashTask::Store(..)));
            self.held = Some(now(self.storage.execute(request)));
        }
        if !self.hold
            && let Some(report) = self.held.take()
        {
            self.node.handle_storage(report);
        }
    }

    pub(crate) fn send(&mut self, message: ToDrive) {
        self.node.handle_frame(&message.encode(self.node.addresses()));
        assert_eq!(self.node.addresses(), Addresses::FACTORY);
    }

    pub(crate) fn request(&mut self, mode: MotorMode) {
        self.send(ToDrive::RequestWord(RequestWord { mode }));
    }

    /// Writes a parameter; returns the answer, if it comes within 100 ms.
    pub(crate) fn write(&mut self, number: u16, value: i32) -> Option<(i32, ParameterStatus)> {
        self.received.clear();
        self.send(ToDrive::SetParameter { number, value });
        self.answer(number)
    }

    /// Writes 0 and then 1; returns the answer to the 1.
    pub(crate) fn command(&mut self, number: u16) -> Option<ParameterStatus> {
        assert_eq!(self.write(number, 0), Some((0, ParameterStatus::Done)));
        self.write(number, 1).map(|(_, status)| status)
    }

    pub(crate) fn answer(&mut self, asked: u16) -> Option<(i32, ParameterStatus)> {
        for _ in 0..1000 {
            self.tick();
            let answer = self.received.iter().find_map(|message| match message {
                FromDrive::Parameter { number, value, status } if *number == asked => Some((*value, *status)),
                _ => None,
            });
            if answer.is_some() {
                return answer;
            }
        }
        None
    }

    pub(crate) fn set(&mut self, number: u16, value: i32) {
        assert_eq!(self.write(number, value), Some((value, ParameterStatus::Done)), "parameter {number}");
    }

    pub(crate) fn get(&self, number: u16) -> i32 {
        self.node.read_parameter(number).unwrap()
    }

    pub(crate) fn state(&self) -> State {
        self.node.status().state
    }

    pub(crate) fn faults(&self) -> FaultWord {
        self.node.status().faults
    }

    /// Waits for the next status word on the bus.
    pub(crate) fn status(&mut self) -> StatusWord {
        self.received.clear();
        for _ in 0..600 {
            self.tick();
            if let Some(FromDrive::Status(word)) =
                self.received.iter().find(|message| matches!(message, FromDrive::Status(_)))
            {
                return *word;
            }
        }
        panic!("no status word in a broadcast period");
    }

    /// Downloads until no more frames come; returns the records, and the counters of their frames.
    pub(crate) fn download(&mut self, start: i32, count: i32) -> (Vec<Record>, Vec<u16>) {
        self.set(number::LOG_READ_START, start);
        self.set(number::LOG_READ_COUNT, count);
        assert_eq!(self.command(number::LOG_READ_REQUEST), Some(ParameterStatus::Done));
        let mut silent = 0;
        while silent < 50 {
            let before = self.received.len();
            self.tick();
            let frames =
                self.received[before..].iter().filter(|message| matches!(message, FromDrive::LogData { .. }));
            silent = if frames.count() > 0 { 0 } else { silent + 1 };
        }
        self.records()
    }

    /// Records in the frames received so far.
    pub(crate) fn records(&self) -> (Vec<Record>, Vec<u16>) {
        let mut bytes = Vec::new();
        let mut counters = Vec::new();
        for message in &self.received {
            if let FromDrive::LogData { counter, data } = message {
                counters.push(*counter);
                bytes.extend(data.iter().flat_map(|word| word.to_be_bytes()));
            }
        }
        let mut records = Vec::new();
        let mut rest = bytes.as_slice();
        while let Some(record) = Record::parse(rest) {
            rest = &rest[record.bytes().len()..];
            records.push(record);
        }
        assert!(rest.len() < 240, "a record that is not whole was sent");
        (records, counters)
    }
}
