//! Tests of the master's downloads from the real drive over the bench's bus, with frames lost on the way.

use crate::bench::config;
use crate::support::now;
use narx_core::bus::narmotion::{Addresses, FromDrive, ParameterStatus, ToDrive};
use narx_core::description::Document;
use narx_core::dictionary::{Dictionary, PARAMETER_COUNT, number};
use narx_core::master::{
    Config, Described, DescriptionReader, Download, DownloadError, Master, Reason, Request, Service,
};
use narx_core::motor::State;
use narx_core::storage::{self, FlashReply, Record, Storage};
use narx_sim::bench::{Bench, IDENTITY};
use proptest::prelude::*;
use std::collections::BTreeSet;

struct Rig {
    bench: Bench,
    master: Master,
    /// Number of data frames of downloads that have left the drive.
    data: usize,
    /// Numbers of the data frames that are lost.
    lost: BTreeSet<usize>,
    /// Words of the download that were received.
    words: Vec<Option<u16>>,
    /// Values that were written to parameters 67 and 68.
    ranges: Vec<(u16, i32)>,
    reader: DescriptionReader,
    /// Number of parameters that the reader has returned.
    described: usize,
}

impl Rig {
    fn new() -> Self {
        let bench = Bench::new(&config(None)).without_recording();
        let master = Master::new(Config::default());
        let mut rig = Self {
            bench,
            master,
            data: 0,
            lost: BTreeSet::new(),
            words: Vec::new(),
            ranges: Vec::new(),
            reader: DescriptionReader::new(),
            described: 0,
        };
        rig.run(1000);
        assert_eq!(rig.master.state(), Some(State::Standby));
        rig
    }

    fn step(&mut self) {
        let now = self.bench.now_ns() / 1000;
        while let Some(frame) = self.master.poll_frame(now) {
            if let Ok((_, ToDrive::SetParameter { number, value })) = ToDrive::decode(&frame)
                && [number::LOG_READ_START, number::LOG_READ_COUNT].contains(&number)
            {
                self.ranges.push((number, value));
            }
            self.bench.send(frame).unwrap();
        }
        self.bench.step();
        while let Some(received) = self.bench.receive() {
            let message = FromDrive::decode(&received.frame).unwrap().1;
            if matches!(message, FromDrive::XmlData { .. } | FromDrive::LogData { .. }) {
                self.data += 1;
                if self.lost.contains(&(self.data - 1)) {
                    continue;
                }
            }
            self.master.handle_frame(&received.frame, received.time_ns / 1000);
        }
        while self.bench.monitor().is_some() {}
    }

    fn run(&mut self, milliseconds: u64) {
        (0..milliseconds * 10).for_each(|_| self.step());
    }

    fn ask(&mut self, request: Request) -> Result<i32, narx_core::master::RequestError> {
        self.master.request(request).unwrap();
        for _ in 0..100_000 {
            if let Some(answer) = self.master.poll_answer() {
                return answer.result;
            }
            self.step();
        }
        panic!("every request is answered in time");
    }

    fn set(&mut self, number: u16, raw: i32) {
        assert_eq!(self.ask(Request::Write { number, raw }), Ok(raw));
    }

    /// Downloads now; returns the words.
    fn download(&mut self, what: Download) -> Result<Vec<u16>, DownloadError> {
        (self.data, self.words) = (0, Vec::new());
        self.ranges.clear();
        self.master.download(what).unwrap();
        for _ in 0..600_000 {
            self.step();
            while let Some(chunk) = self.master.poll_chunk() {
                let begin = chunk.offset as usize;
                let end = begin + chunk.words().len();
                self.words.resize(self.words.len().max(end), None);
                for (place, word) in self.words[begin..end].iter_mut().zip(chunk.words()) {
                    *place = Some(*word);
                }
                if what == Download::Description
                    && let Ok(Some(Described::Parameter(parameter))) = self.reader.handle_chunk(&chunk)
                {
                    let row = Dictionary::rows().nth(self.described).unwrap();
                    assert_eq!((row.number, row.exponent), (parameter.number, parameter.exponent));
                    self.described += 1;
                }
            }
            if let Some(end) = self.master.poll_download() {
                return end.map(|total| {
                    assert_eq!(self.words.len(), total as usize);
                    self.words.iter().map(|word| word.expect("no gap is left")).collect()
                });
            }
        }
        panic!("a download ends within a minute");
    }

    /// Logs three signals for some time, then stops; returns the number of records.
    fn log(&mut self, milliseconds: u64) -> u32 {
        self.set(number::LOG_PERIOD, 5);
        for (number, slot) in [(29, 0x2000 + 202 * 4), (30, 0x3_2000 + 203 * 4), (31, 111)] {
            self.set(number, slot);
        }
        self.run(milliseconds);
        for number in 29..=31 {
            self.set(number, 0xFFFF);
        }
        self.ask(Request::Read { number: number::LOG_WRITE_INDEX }).unwrap() as u32
    }
}

fn bytes(words: &[u16]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_be_bytes()).collect()
}

/// The description as the renderer writes it, in whole words.
fn text() -> String {
    let mut text = String::new();
    let document = Document { identity: IDENTITY, addresses: Addresses::FACTORY, tick_rate: 10_000 };
    document.write(&mut text).unwrap();
    if text.len() % 2 == 1 {
        text.push('\n');
    }
    text
}

#[test]
fn the_description_comes_byte_for_byte_and_is_read_as_it_comes() {
    let mut rig = Rig::new();
    let begin = rig.bench.time();
    let words = rig.download(Download::Description).unwrap();
    assert!(bytes(&words) == text().as_bytes());
    assert_eq!((rig.described, rig.reader.clone().finish()), (PARAMETER_COUNT, Ok(())));
    let seconds = rig.bench.time() - begin;
    assert!(seconds < 4.0, "{seconds} s");
    assert_eq!(rig.ask(Request::Read { number: number::FRAMES_LOST }), Ok(0));
}

#[test]
fn what_is_lost_of_the_description_comes_once_more() {
    let mut rig = Rig::new();
    rig.lost = [0, 1, 500, 501, 4000].into();
    let words = rig.download(Download::Description).unwrap();
    assert!(bytes(&words) == text().as_bytes());
    let error = rig.reader.finish().unwrap_err();
    assert_eq!((error.byte, error.reason), (0, Reason::Gap), "what is read as it comes has to begin anew");
}

/// Content of a flash, read directly.
fn on_the_flash(bench: Bench, records: std::ops::Range<u32>) -> Vec<u8> {
    let mut storage = Storage::new(bench.into_flash());
    let FlashReply::Opened(_) = now(storage.execute(storage::FlashTask::Open)) else { panic!("opened") };
    let record = |index| match now(storage.execute(storage::FlashTask::Read(index))) {
        FlashReply::Record(Some(record)) => record.bytes().to_vec(),
        other => panic!("{other:?}"),
    };
    records.flat_map(record).collect()
}

#[test]
fn a_range_of_the_log_is_repaired_record_by_record() {
    let mut rig = Rig::new();
    let written = rig.log(1500);
    assert!(written > 250, "{written}");
    // Six frames a record: the first frame, one in the middle, the last one, and two neighbours.
    rig.lost = [0, 6 * 50 + 3, 6 * 100, 6 * 101 + 5, 6 * 200 - 1].into();
    let words = rig.download(Download::Log { first: 10, records: 200 }).unwrap();
    let asked: Vec<(i32, i32)> = rig.ranges.chunks(2).map(|pair| (pair[0].1, pair[1].1)).collect();
    assert_eq!(asked, [(10, 200), (10, 1), (60, 1), (110, 2), (209, 1)]);
    assert_eq!(bytes(&words).len(), 200 * Record::size(3));
    assert!(bytes(&words) == on_the_flash(rig.bench, 10..210));
}

#[test]
fn the_log_ends_where_it_was_written() {
    let mut rig = Rig::new();
    let written = rig.log(300);
    let words = rig.download(Download::Log { first: 0, records: written }).unwrap();
    assert_eq!(bytes(&words).len(), written as usize * Record::size(3));
    for (first, records) in [(written, 1), (0, written + 1), (written - 1, 2), (u32::MAX >> 1, 1)] {
        let Err(DownloadError::Refused(refusal)) = rig.download(Download::Log { first, records }) else {
            panic!("{first} {records}");
        };
        assert_eq!((refusal.number, refusal.status), (number::LOG_READ_REQUEST, ParameterStatus::OutOfRange));
    }
    assert_eq!(rig.download(Download::Log { first: written, records: 0 }), Ok(vec![]));
    assert_eq!(rig.ask(Request::Run(Service::EraseLog)), Ok(1));
    let Err(DownloadError::Refused(refusal)) = rig.download(Download::Log { first: 0, records: 1 }) else {
        panic!("refused while it is erased");
    };
    assert_eq!(refusal.status, ParameterStatus::Storage);
    rig.run(2000);
    let Err(DownloadError::Refused(refusal)) = rig.download(Download::Log { first: 0, records: 1 }) else {
        panic!("nothing is left");
    };
    assert_eq!(refusal.status, ParameterStatus::OutOfRange);
}

/// Records with a fallen bit on the flash are sent as zeros, and the rest unchanged.
#[test]
fn a_record_that_is_spoiled_on_the_flash_is_told_by_zeros() {
    let mut rig = Rig::new();
    let written = rig.log(300);
    rig.bench.flash().flip(7 * storage::record::PAGE + 15, 1);
    let words = rig.download(Download::Log { first: 0, records: written }).unwrap();
    for (index, bytes) in bytes(&words).chunks(Record::size(3)).enumerate() {
        let record = Record::parse(bytes);
        assert_eq!(record.is_none(), index == 7);
        assert!(record.is_none_or(|record| record.index() as usize == index));
    }
}

#[test]
fn an_abort_ends_both_kinds() {
    let mut rig = Rig::new();
    let written = rig.log(300);
    for what in [Download::Description, Download::Log { first: 0, records: written }] {
        rig.master.download(what).unwrap();
        rig.run(20);
        assert!(rig.master.download_progress().is_some_and(|progress| progress.received > 0), "{what:?}");
        rig.master.abort_download();
        rig.run(10);
        assert_eq!(rig.master.poll_download(), Some(Err(DownloadError::Aborted)));
        let before = rig.data;
        rig.run(50);
        assert_eq!(rig.data, before, "{what:?}");
        while rig.master.poll_chunk().is_some() {}
    }
    assert!(rig.download(Download::Log { first: 0, records: written }).is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// With any losses the received records are those on the flash in the end. A range fails only after three
    /// requests in vain.
    #[test]
    fn a_lossy_line_costs_time_and_no_record(lost in prop::collection::btree_set(0..900_usize, 0..60)) {
        let mut rig = Rig::new();
        rig.log(500);
        rig.lost = lost;
        let what = Download::Log { first: 3, records: 80 };
        let words = match rig.download(what) {
            Ok(words) => words,
            Err(error) => {
                prop_assert_eq!(error, DownloadError::NoAnswer);
                rig.lost.clear();
                rig.download(what).unwrap()
            }
        };
        prop_assert!(bytes(&words) == on_the_flash(rig.bench, 3..83));
    }
}
