//! A scripted drive with downloads, and a master that takes them, shared by the suites about downloads.

use crate::pair::said;
use narx_core::bus::narmotion::{FromDrive, ParameterStatus, ToDrive, XmlCommand};
use narx_core::dictionary::number;
use narx_core::master::{Config, Download, DownloadError, Master};
use narx_core::storage::{Entry, Record};
use std::collections::{BTreeSet, HashMap, VecDeque};

const TICK: u64 = 100;

/// The drive's side by PROTOCOL.md: it answers a request at once, and sends streams frame by frame.
pub(crate) struct Device {
    pub(crate) description: Vec<u16>,
    pub(crate) scope: Vec<u16>,
    pub(crate) log: Vec<u16>,
    pub(crate) parameters: HashMap<u16, i32>,
    armed: bool,
    answers: VecDeque<FromDrive>,
    pub(crate) stream: VecDeque<FromDrive>,
    /// Number of data frames so far.
    streamed: usize,
    /// Numbers of the data frames that are lost.
    pub(crate) lost: BTreeSet<usize>,
    /// Frames of the master that were neither parameters nor commands.
    pub(crate) asked: Vec<ToDrive>,
}

impl Device {
    pub(crate) fn new(words: u16, record_bytes: i32) -> Self {
        Self {
            description: (0..words).map(|word| word ^ 0x1111).collect(),
            scope: (0..words).map(|word| word ^ 0x2222).collect(),
            log: log_of(record_bytes),
            parameters: HashMap::from([(number::LOG_RECORD_BYTES, record_bytes)]),
            armed: false,
            answers: VecDeque::new(),
            stream: VecDeque::new(),
            streamed: 0,
            lost: BTreeSet::new(),
            asked: Vec::new(),
        }
    }

    fn receive(&mut self, message: ToDrive) {
        match message {
            ToDrive::DownloadXml(XmlCommand::Length) => {
                self.stream.clear();
                self.answers
                    .push_back(FromDrive::XmlLength { words: self.description.len() as u16, check: 0 });
            }
            ToDrive::DownloadXml(XmlCommand::Start) => {
                self.stream = frames(&self.description, |address, data| FromDrive::XmlData { address, data });
            }
            ToDrive::DownloadScope => {
                self.stream = frames(&self.scope, |address, data| FromDrive::ScopeData { address, data });
            }
            ToDrive::SetParameter { number, value } => self.write(number, value),
            ToDrive::RequestParameter { number } => self.tell(number),
            _ => return,
        }
        self.asked.push(message);
    }

    fn write(&mut self, number: u16, value: i32) {
        let edge = number == number::LOG_READ_REQUEST && value == 1 && self.armed;
        if number == number::LOG_READ_REQUEST {
            self.armed = value == 0;
            if value == 0 {
                self.stream.clear();
            }
        }
        self.parameters.insert(number, value);
        self.tell(number);
        if edge {
            let [first, count, bytes] =
                [number::LOG_READ_START, number::LOG_READ_COUNT, number::LOG_RECORD_BYTES].map(|number| {
                    usize::try_from(self.parameters.get(&number).copied().unwrap_or(0)).unwrap()
                });
            let size = bytes / 2;
            let records = &self.log[first * size..(first + count) * size];
            self.stream = frames(records, |counter, data| FromDrive::LogData { counter, data });
        }
    }

    fn tell(&mut self, number: u16) {
        let value = self.parameters.get(&number).copied().unwrap_or(0);
        self.answers.push_back(FromDrive::Parameter { number, value, status: ParameterStatus::Done });
    }

    /// Next message of the drive, unless it is lost.
    fn speak(&mut self) -> Option<FromDrive> {
        if let Some(answer) = self.answers.pop_front() {
            return Some(answer);
        }
        let data = self.stream.pop_front()?;
        self.streamed += 1;
        (!self.lost.contains(&(self.streamed - 1))).then_some(data)
    }
}

/// Words of a log with records of this size.
fn log_of(record_bytes: i32) -> Vec<u16> {
    let Some(values) = usize::try_from(record_bytes).unwrap().checked_sub(Record::size(0)) else {
        return vec![];
    };
    let value = |place| (0x2328 + place as u16, place as i32 - 7);
    let records = (0..200_000 / (record_bytes as u32 / 2)).map(|index| {
        let entry = Entry { time: index * 10, values: (0..values / 6).map(value).collect() };
        Record::new(index, &entry)
    });
    let bytes: Vec<u8> = records.flat_map(|record| record.bytes().to_vec()).collect();
    bytes.as_chunks().0.iter().copied().map(u16::from_be_bytes).collect()
}

/// Frames of three words, the last one filled with zeros; addresses wrap.
fn frames(words: &[u16], frame: impl Fn(u16, [u16; 3]) -> FromDrive) -> VecDeque<FromDrive> {
    let word = |chunk: &[u16], place: usize| chunk.get(place).copied().unwrap_or(0);
    let data = |chunk: &[u16]| [word(chunk, 0), word(chunk, 1), word(chunk, 2)];
    words.chunks(3).enumerate().map(|(place, chunk)| frame((place * 3) as u16, data(chunk))).collect()
}

/// A master with a download under way, and the words that it has received.
pub(crate) struct Bench {
    pub(crate) master: Master,
    pub(crate) device: Device,
    now: u64,
    words: Vec<Option<u16>>,
    /// Chunks taken per tick.
    pub(crate) appetite: usize,
}

impl Bench {
    pub(crate) fn new(device: Device) -> Self {
        let config = Config { read_parameters: false, ..Config::default() };
        Self { master: Master::new(config), device, now: 0, words: Vec::new(), appetite: 10 }
    }

    /// Runs a tick. Four frames of the drive per tick are more than a bus of 500 kbit/s carries.
    pub(crate) fn step(&mut self) {
        self.now += TICK;
        while let Some(frame) = self.master.poll_frame(self.now) {
            self.device.receive(ToDrive::decode(&frame).unwrap().1);
        }
        for message in (0..4).filter_map(|_| self.device.speak()) {
            self.master.handle_frame(&said(message), self.now);
        }
        for _ in 0..self.appetite {
            let Some(chunk) = self.master.poll_chunk() else { break };
            let begin = chunk.offset as usize;
            let end = begin + chunk.words().len();
            self.words.resize(self.words.len().max(end), None);
            for (place, word) in self.words[begin..end].iter_mut().zip(chunk.words()) {
                *place = Some(*word);
            }
        }
    }

    pub(crate) fn run(&mut self, milliseconds: u64) {
        (0..milliseconds * 10).for_each(|_| self.step());
    }

    /// Waits for the end; returns the result and its time, ms.
    pub(crate) fn end(&mut self) -> (Result<u32, DownloadError>, u64) {
        for _ in 0..1_000_000 {
            if let Some(end) = self.master.poll_download() {
                return (end, self.now / 1000);
            }
            self.step();
        }
        panic!("a download ends");
    }

    pub(crate) fn download(&mut self, what: Download) -> Result<Vec<u16>, DownloadError> {
        self.words.clear();
        self.master.download(what).unwrap();
        let total = self.end().0?;
        let words: Vec<u16> = self.words.iter().map(|word| word.expect("no gap is left")).collect();
        assert_eq!(words.len(), total as usize);
        Ok(words)
    }
}

/// Messages that a master alone sends at `now`.
pub(crate) fn sent(master: &mut Master, now: u64) -> Vec<ToDrive> {
    let frames = std::iter::from_fn(|| master.poll_frame(now));
    let messages = frames.map(|frame| ToDrive::decode(&frame).unwrap().1);
    messages.filter(|message| !matches!(message, ToDrive::MotorCommand { .. })).collect()
}
