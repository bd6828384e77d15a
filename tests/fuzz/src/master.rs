//! Target: the drive's master, with frames of a bus and orders of its caller in any order, among them
//! downloads and updates.

use crate::program::Program;
use narx_core::bus::Frame;
use narx_core::bus::narmotion::update::{ImageVersion, UpdateAnswer, UpdateCode, UpdateState, UpdateStatus};
use narx_core::bus::narmotion::{
    Addresses, FromDrive, MessageId, MotorMode, ParameterStatus, RequestWord, ToDrive,
};
use narx_core::dictionary::{Dictionary, PARAMETER_COUNT, number};
use narx_core::master::{Config, Download, Image, Master, Progress, Request, Service};
use narx_core::storage::Record;
use std::collections::BTreeMap;

/// Image of an update; its bytes do not matter.
const IMAGE: [u8; 1000] = [0x5A; 1000];

/// Runs an input. First byte: bit 0 for a master that reads parameters, bits 0 to 2 for a silent one. Steps
/// follow.
pub fn run(data: &[u8]) {
    let mut program = Program(data);
    let first = program.byte();
    let config = Config { silent: first & 7 == 7, read_parameters: first & 1 != 0, ..Config::default() };
    let mut caller = Caller {
        master: Master::new(config),
        now: 0,
        asked: Vec::new(),
        mode: None,
        last: None,
        download: None,
        words: BTreeMap::new(),
        updates: false,
    };
    while !program.is_over() {
        caller.handle(&mut program);
    }
    caller.finish();
}

struct Caller {
    master: Master,
    now: u64,
    /// Requests that were accepted, in their order.
    asked: Vec<Request>,
    /// Motor mode that was last commanded.
    mode: Option<MotorMode>,
    /// Last request to the drive.
    last: Option<ToDrive>,
    download: Option<Download>,
    /// Words of the download by their position.
    words: BTreeMap<u32, u16>,
    updates: bool,
}

impl Caller {
    fn handle(&mut self, program: &mut Program<'_>) {
        match program.byte() % 10 {
            0 => self.master.handle_frame(&program.frame(), self.now),
            1 => self.pass(u64::from(program.byte()) * 200),
            2 => self.order(program),
            3 => self.ask(program),
            // An answer to the last request, as a drive would send it.
            4 => {
                let (status, value) = (program.byte(), program.long());
                self.answer(status, value);
            }
            5 => {
                let (kind, address, data) = (program.byte(), program.word(), program.array::<6>());
                self.stream(kind, address, data);
            }
            6 => self.begin(program),
            // A record of the log with a correct CRC, in consecutive frames.
            7 => {
                let (counter, values, seed) = (program.word(), program.byte() % 38, program.long());
                self.record(counter, values.into(), seed);
            }
            8 => self.update(program),
            _ => self.take(),
        }
    }

    fn order(&mut self, program: &mut Program<'_>) {
        let (what, rpm) = (program.byte(), program.word() as i16);
        match what % 5 {
            0 => {
                self.master.start(rpm.into());
                self.mode = Some(if rpm < 0 { MotorMode::Reverse } else { MotorMode::Drive });
            }
            1 => self.master.set_speed(rpm.unsigned_abs()),
            2 => {
                self.master.stop();
                self.mode = Some(MotorMode::Standby);
            }
            3 => {
                self.master.shut_down();
                self.mode = Some(MotorMode::Fault);
            }
            _ => self.master.read_parameters(),
        }
        assert_eq!(self.master.requested(), self.mode);
    }

    fn ask(&mut self, program: &mut Program<'_>) {
        let (what, number, raw) = (program.byte(), program.word(), program.long() as i32);
        let request = match what % 4 {
            0 => Request::Read { number },
            1 => Request::Write { number, raw },
            2 => Request::Run(Service::ALL[usize::from(number) % Service::ALL.len()]),
            _ => match number % 15 {
                13 => Request::RestoreFactory { serial: raw as u16 },
                14 => Request::Read {
                    number: Dictionary::rows()
                        .nth(raw as usize % PARAMETER_COUNT)
                        .expect("there are as many")
                        .number,
                },
                place => Request::NAMED[usize::from(place)].1,
            },
        };
        match self.master.request(request) {
            Ok(()) => self.asked.push(request),
            Err(_) => assert!(self.asked.len() == 8 || self.master.config().silent),
        }
    }

    fn receive(&mut self, message: FromDrive) {
        self.master.handle_frame(&message.encode(Addresses::FACTORY), self.now);
        assert!(self.master.is_connected(self.now));
    }

    fn answer(&mut self, status: u8, value: u32) {
        use ParameterStatus::{Done, OutOfRange, ReadOnly, Storage, UnknownNumber, WrongState};
        let statuses = [Done, Done, Done, UnknownNumber, ReadOnly, OutOfRange, WrongState, Storage];
        let status = statuses[usize::from(status % 8)];
        let message = match self.last {
            Some(ToDrive::RequestParameter { number }) => {
                // The lengths of downloads are short, so that they end.
                let value = if number == number::SCOPE_WORDS || number == number::LOG_RECORD_BYTES {
                    value & 0xFF
                } else {
                    value
                };
                FromDrive::Parameter { number, value: value as i32, status }
            }
            Some(ToDrive::SetParameter { number, value: written }) => {
                let value = if status == Done { written } else { value as i32 };
                FromDrive::Parameter { number, value, status }
            }
            Some(ToDrive::RequestBuildInfo) => {
                FromDrive::BuildInfo { number: 1, modified: false, date: value }
            }
            Some(ToDrive::RequestDeviceInfo) => {
                FromDrive::DeviceInfo { hardware: 1, software: 2, device_number: 3, address: value as u16 }
            }
            Some(ToDrive::Reboot) => FromDrive::Reboot,
            Some(ToDrive::DownloadXml(_)) => {
                FromDrive::XmlLength { words: value as u16 & 0xFF, check: value }
            }
            _ => return,
        };
        self.receive(message);
    }

    fn stream(&mut self, kind: u8, address: u16, bytes: [u8; 6]) {
        let [a, b, c, d, e, f] = bytes;
        let data = [[a, b], [c, d], [e, f]].map(u16::from_be_bytes);
        // Mostly near the beginning, where a download is.
        let address = if kind & 0x80 != 0 { address } else { address & 0xFF };
        self.receive(match kind % 3 {
            0 => FromDrive::XmlData { address, data },
            1 => FromDrive::ScopeData { address, data },
            _ => FromDrive::LogData { counter: address, data },
        });
    }

    fn record(&mut self, counter: u16, values: usize, seed: u32) {
        let values =
            (0..values as u16).map(|what| (what, seed.wrapping_mul(u32::from(what) + 1) as i32)).collect();
        let record = Record::new(seed, &narx_core::storage::Entry { time: seed, values });
        for (place, data) in (0..).map_while(|place| record.frame(place)).enumerate() {
            self.receive(FromDrive::LogData { counter: counter.wrapping_add(3 * place as u16), data });
        }
    }

    fn begin(&mut self, program: &mut Program<'_>) {
        let (what, length) = (program.byte(), program.byte());
        let download = match what % 4 {
            0 => Download::Description,
            1 => Download::Scope { words: length.into() },
            2 => Download::Log { first: program.word().into(), records: u32::from(length % 8) },
            _ => return self.master.abort_download(),
        };
        if self.master.download(download).is_ok() {
            assert_eq!(self.download.replace(download), None, "one download at a time");
            self.words.clear();
        }
    }

    fn update(&mut self, program: &mut Program<'_>) {
        let (what, length) = (program.byte(), program.word());
        let version = ImageVersion { major: 1, minor: 0, patch: 0, build: length };
        match what % 8 {
            0 => {
                let taken = self.master.update(Image::new(7, version, &IMAGE)).is_ok();
                assert!(!(taken && self.updates), "one update at a time");
                self.updates |= taken;
            }
            1 => self.master.abort_update(),
            2 => self.receive(FromDrive::Update(UpdateAnswer::Device {
                hardware: u32::from(length & 7),
                room: 2000,
            })),
            3 => self.receive(FromDrive::Update(UpdateAnswer::Version(version))),
            place => {
                let state = [
                    UpdateState::Idle,
                    UpdateState::Erasing,
                    UpdateState::Receiving,
                    UpdateState::Verifying,
                    UpdateState::Marked,
                    UpdateState::Trial,
                ];
                let code = [UpdateCode::Done, UpdateCode::Sequence, UpdateCode::Flash, UpdateCode::NotNow];
                let status = UpdateStatus {
                    state: state[usize::from(what >> 3) % 6],
                    code: code[usize::from(place - 4)],
                    window: length & 0x3F,
                    offset: u32::from(length >> 4),
                };
                self.receive(FromDrive::Update(UpdateAnswer::Status(status)));
            }
        }
    }

    fn pass(&mut self, microseconds: u64) {
        self.now += microseconds;
        let mut sent = 0;
        loop {
            let frame = self.master.poll_frame(self.now);
            let Some(frame) = frame.or_else(|| self.master.poll_update_frame(self.now, &IMAGE)) else {
                break;
            };
            self.said(&frame);
            sent += 1;
            assert!(sent <= 64, "{sent} frames at once");
        }
        let next = self.master.next_poll(self.now);
        // Blocks of an update have a pace of their own.
        assert!(next > self.now || self.updates || self.master.config().silent, "{next}");
    }

    /// Checks a frame of the master: it goes to the drive in the master's name, and commands the motor only
    /// as requested.
    fn said(&mut self, frame: &Frame) {
        assert!(!self.master.config().silent);
        let (id, message) = ToDrive::decode(frame).expect("a message of a master");
        let (kind, opcode) = message.kind();
        assert_eq!(id, MessageId { ..Addresses::FACTORY.to_drive(kind, opcode) });
        match message {
            ToDrive::RequestWord(RequestWord { mode }) => assert_eq!(Some(mode), self.mode),
            ToDrive::MotorCommand { speed } => assert_eq!(speed, self.master.setpoint()),
            message => self.last = Some(message),
        }
    }

    /// Takes the results: answers in the order of their requests, chunks within their download, one end.
    fn take(&mut self) {
        if let Some(answer) = self.master.poll_answer() {
            assert_eq!(answer.request, self.asked.remove(0));
        }
        while let Some(chunk) = self.master.poll_chunk() {
            let download = self.download.expect("somebody has begun one");
            let end = chunk.offset + chunk.words().len() as u32;
            // Without progress the download has already ended.
            if let Some(Progress { received, total }) = self.master.download_progress() {
                assert!(end <= total && received <= total, "{chunk:?}: {received} of {total}");
            }
            if let Download::Scope { words } = download {
                assert!(end <= words);
            }
            self.words.extend((chunk.offset..).zip(chunk.words().iter().copied()));
        }
        if let Some(end) = self.master.poll_download() {
            let download = self.download.take().expect("somebody has begun one");
            if let Ok(words) = end {
                self.whole(download, words);
            }
        }
        if self.master.poll_update().is_some() {
            assert!(core::mem::take(&mut self.updates), "an end without an update");
        }
    }

    /// Checks that a successful download has every word and, of the log, every record.
    fn whole(&self, download: Download, words: u32) {
        assert!(
            self.words.keys().copied().eq(0..words),
            "{download:?}: {} of {words} words",
            self.words.len()
        );
        if let Download::Log { records, .. } = download
            && records > 0
        {
            let all: Vec<u16> = self.words.values().copied().collect();
            for record in all.chunks(words as usize / records as usize) {
                let bytes: Vec<u8> = record.iter().flat_map(|word| word.to_be_bytes()).collect();
                assert!(
                    record.iter().all(|word| *word == 0) || Record::parse(&bytes).is_some(),
                    "{record:x?}"
                );
            }
        }
    }

    /// Runs with a silent drive: everything must end.
    fn finish(&mut self) {
        self.master.abort_update();
        for _ in 0..2_000 {
            let idle = self.asked.is_empty() && self.download.is_none() && !self.updates;
            if idle {
                break;
            }
            self.pass(100_000);
            self.take();
        }
        assert_eq!(
            (self.asked.as_slice(), self.download, self.updates),
            (&[][..], None, false),
            "it never ends"
        );
    }
}
