//! Bulk downloads from a scripted drive: lengths, streams, gaps, refusals, aborts.

use crate::pair::said;
use narx_core::bus::narmotion::{Addresses, FromDrive, ParameterStatus, ToDrive, XmlCommand};
use narx_core::dictionary::number;
use narx_core::master::{Config, Download, DownloadError, Master, NotTaken, Progress, Request};
use proptest::prelude::*;
use std::collections::{BTreeSet, HashMap, VecDeque};

const TICK: u64 = 100;

/// The drive's side as PROTOCOL.md has it: what is asked is answered at once, streams come frame by frame.
struct Device {
    description: Vec<u16>,
    scope: Vec<u16>,
    log: Vec<u16>,
    parameters: HashMap<u16, i32>,
    armed: bool,
    answers: VecDeque<FromDrive>,
    stream: VecDeque<FromDrive>,
    /// Data frames sent so far.
    streamed: usize,
    /// Data frames that get lost, by their number.
    lost: BTreeSet<usize>,
    /// Frames of the master that were neither parameters nor commands.
    asked: Vec<ToDrive>,
}

impl Device {
    fn new(words: u16, record_bytes: i32) -> Self {
        Self {
            description: (0..words).map(|word| word ^ 0x1111).collect(),
            scope: (0..words).map(|word| word ^ 0x2222).collect(),
            log: (0..200_000_u32).map(|word| word as u16 ^ 0x3333).collect(),
            parameters: HashMap::from([(number::LOG_RECORD_BYTES, record_bytes)]),
            armed: false,
            answers: VecDeque::new(),
            stream: VecDeque::new(),
            streamed: 0,
            lost: BTreeSet::new(),
            asked: Vec::new(),
        }
    }

    fn hear(&mut self, message: ToDrive) {
        match message {
            ToDrive::DownloadXml(XmlCommand::Length) => {
                self.stream.clear();
                self.answers.push_back(FromDrive::XmlLength { words: self.description.len() as u16 });
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
            let size = bytes.div_ceil(2);
            let records = &self.log[first * size..(first + count) * size];
            self.stream = frames(records, |counter, data| FromDrive::LogData { counter, data });
        }
    }

    fn tell(&mut self, number: u16) {
        let value = self.parameters.get(&number).copied().unwrap_or(0);
        self.answers.push_back(FromDrive::Parameter { number, value, status: ParameterStatus::Done });
    }

    /// What goes out next, if it is not lost.
    fn speak(&mut self) -> Option<FromDrive> {
        if let Some(answer) = self.answers.pop_front() {
            return Some(answer);
        }
        let data = self.stream.pop_front()?;
        self.streamed += 1;
        (!self.lost.contains(&(self.streamed - 1))).then_some(data)
    }
}

/// Three words a frame, the last one filled with zeros; addresses wrap.
fn frames(words: &[u16], frame: impl Fn(u16, [u16; 3]) -> FromDrive) -> VecDeque<FromDrive> {
    let word = |chunk: &[u16], place: usize| chunk.get(place).copied().unwrap_or(0);
    let data = |chunk: &[u16]| [word(chunk, 0), word(chunk, 1), word(chunk, 2)];
    words.chunks(3).enumerate().map(|(place, chunk)| frame((place * 3) as u16, data(chunk))).collect()
}

/// A master with a download under way, and the words it has got.
struct Bench {
    master: Master,
    device: Device,
    now: u64,
    words: Vec<Option<u16>>,
    /// Chunks taken each tick.
    appetite: usize,
}

impl Bench {
    fn new(device: Device) -> Self {
        let config = Config { read_parameters: false, ..Config::default() };
        Self { master: Master::new(config), device, now: 0, words: Vec::new(), appetite: 10 }
    }

    /// Four frames of the drive a tick are more than a bus of 500 kbit/s has.
    fn step(&mut self) {
        self.now += TICK;
        while let Some(frame) = self.master.poll_frame(self.now) {
            self.device.hear(ToDrive::decode(&frame).unwrap().1);
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

    fn run(&mut self, milliseconds: u64) {
        (0..milliseconds * 10).for_each(|_| self.step());
    }

    /// Waits for the end; what it was, and when it came, ms.
    fn end(&mut self) -> (Result<u32, DownloadError>, u64) {
        for _ in 0..1_000_000 {
            if let Some(end) = self.master.poll_download() {
                return (end, self.now / 1000);
            }
            self.step();
        }
        panic!("a download ends");
    }

    fn download(&mut self, what: Download) -> Result<Vec<u16>, DownloadError> {
        self.words.clear();
        self.master.download(what).unwrap();
        let total = self.end().0?;
        let words: Vec<u16> = self.words.iter().map(|word| word.expect("no gap is left")).collect();
        assert_eq!(words.len(), total as usize);
        Ok(words)
    }
}

#[test]
fn the_description_is_asked_for_its_length_and_then_streams() {
    // One, two and three words in the last frame.
    for words in [1, 2, 3, 100, 1000, 1001, u16::MAX] {
        let mut bench = Bench::new(Device::new(words, 0));
        assert_eq!(bench.download(Download::Description), Ok(bench.device.description.clone()));
        let asked = [XmlCommand::Length, XmlCommand::Start].map(ToDrive::DownloadXml);
        assert_eq!(bench.device.asked, asked, "{words}");
    }
    let mut bench = Bench::new(Device::new(0, 0));
    assert_eq!(bench.download(Download::Description), Ok(vec![]));
}

#[test]
fn text_is_packed_high_byte_first_and_samples_are_q3_12() {
    let mut bench = Bench::new(Device::new(0, 0));
    bench.appetite = 0;
    bench.device.description = vec![0x3C3F, 0x786D, 0x6C20, 0x7600];
    bench.device.scope = vec![0x1000, 0xF000, 0x0800, 0x8000];
    bench.master.download(Download::Description).unwrap();
    bench.run(10);
    let chunks: Vec<_> = std::iter::from_fn(|| bench.master.poll_chunk()).collect();
    let text: Vec<u8> = chunks.iter().flat_map(|chunk| chunk.bytes()).collect();
    assert_eq!(text, b"<?xml v\0");
    assert_eq!(bench.master.poll_download(), Some(Ok(4)));
    bench.master.download(Download::Scope { words: 4 }).unwrap();
    bench.run(10);
    let chunks: Vec<_> = std::iter::from_fn(|| bench.master.poll_chunk()).collect();
    let samples: Vec<f64> =
        chunks.iter().flat_map(|chunk| chunk.samples()).map(|sample| sample.to_num()).collect();
    assert_eq!(samples, [1.0, -1.0, 0.5, -8.0]);
}

#[test]
fn the_scope_streams_at_once() {
    for words in [0, 5, 768, 40_000] {
        let mut bench = Bench::new(Device::new(words, 0));
        assert_eq!(bench.download(Download::Scope { words: words.into() }), Ok(bench.device.scope.clone()));
        let asked: &[ToDrive] = if words == 0 { &[] } else { &[ToDrive::DownloadScope] };
        assert_eq!(bench.device.asked, asked, "{words}");
    }
}

#[test]
fn the_log_is_read_by_range() {
    let mut bench = Bench::new(Device::new(0, 14));
    let words = bench.download(Download::Log { first: 3, records: 5 }).unwrap();
    assert_eq!(words, bench.device.log[21..56]);
    let set = |number, value| ToDrive::SetParameter { number, value };
    let asked = [
        ToDrive::RequestParameter { number: number::LOG_RECORD_BYTES },
        set(number::LOG_READ_START, 3),
        set(number::LOG_READ_COUNT, 5),
        set(number::LOG_READ_REQUEST, 0),
        set(number::LOG_READ_REQUEST, 1),
    ];
    assert_eq!(bench.device.asked, asked);
    assert_eq!(bench.download(Download::Log { first: 0, records: 0 }), Ok(vec![]));
    // The word counter has 16 bits, and wraps.
    let words = bench.download(Download::Log { first: 0, records: 20_000 }).unwrap();
    assert_eq!(words, bench.device.log[..140_000]);
}

#[test]
fn gaps_are_asked_for_again() {
    // The first frame, the last one, one in the middle, several in a row, every seventh one.
    let losses: [&[usize]; 5] =
        [&[0], &[333], &[100], &[10, 11, 12, 200, 201], &[0, 7, 14, 21, 28, 35, 42, 49, 56]];
    for lost in losses {
        for what in
            [Download::Description, Download::Scope { words: 1000 }, Download::Log { first: 7, records: 100 }]
        {
            let mut bench = Bench::new(Device::new(1000, 20));
            bench.device.lost = lost.iter().copied().collect();
            let words = bench.download(what).unwrap();
            let expected = match what {
                Download::Description => bench.device.description.clone(),
                Download::Scope { .. } => bench.device.scope.clone(),
                Download::Log { .. } => bench.device.log[70..1070].to_vec(),
            };
            assert!(words == expected, "{what:?}, lost {lost:?}");
        }
    }
}

#[test]
fn of_the_log_only_the_gap_is_asked_for() {
    let mut bench = Bench::new(Device::new(0, 20));
    bench.device.lost = BTreeSet::from([50]);
    assert!(bench.download(Download::Log { first: 7, records: 100 }).is_ok());
    // Frame 50 has words 150 to 152: record 15 of the download, 22 of the log.
    let set = |number, value| ToDrive::SetParameter { number, value };
    let again = [
        set(number::LOG_READ_START, 22),
        set(number::LOG_READ_COUNT, 1),
        set(number::LOG_READ_REQUEST, 0),
        set(number::LOG_READ_REQUEST, 1),
    ];
    assert_eq!(bench.device.asked[5..], again);
}

/// A master alone; what it sends at `now`.
fn sent(master: &mut Master, now: u64) -> Vec<ToDrive> {
    let frames = std::iter::from_fn(|| master.poll_frame(now));
    let messages = frames.map(|frame| ToDrive::decode(&frame).unwrap().1);
    messages.filter(|message| !matches!(message, ToDrive::MotorCommand { .. })).collect()
}

/// CAN may double a frame, and the master asks again as soon as the last one has come.
#[test]
fn the_double_of_a_last_frame_does_not_end_the_next_stream() {
    let mut master = Master::new(Config { read_parameters: false, ..Config::default() });
    let data =
        |address: u16| said(FromDrive::ScopeData { address, data: [address, address + 1, address + 2] });
    master.download(Download::Scope { words: 9 }).unwrap();
    assert_eq!(sent(&mut master, 0), [ToDrive::DownloadScope]);
    master.handle_frame(&data(0), 1);
    master.handle_frame(&data(6), 2);
    assert_eq!(sent(&mut master, 3), [ToDrive::DownloadScope], "3 to 5 are missing");
    master.handle_frame(&data(6), 4);
    assert_eq!(sent(&mut master, 5), []);
    master.handle_frame(&data(0), 6);
    master.handle_frame(&data(3), 7);
    let offsets: Vec<u32> = std::iter::from_fn(|| master.poll_chunk()).map(|chunk| chunk.offset).collect();
    assert_eq!((offsets, master.poll_download()), (vec![0, 6, 3], Some(Ok(9))));
}

/// A log download whose stream has been asked for; the command's answer is still to come.
fn raised(records: u32) -> Master {
    let mut master = Master::new(Config { read_parameters: false, ..Config::default() });
    master.download(Download::Log { first: 0, records }).unwrap();
    loop {
        let (number, value) = match sent(&mut master, 0)[..] {
            [ToDrive::RequestParameter { number }] => (number, 6),
            [ToDrive::SetParameter { number: number::LOG_READ_REQUEST, value: 1 }] => return master,
            [ToDrive::SetParameter { number, value }] => (number, value),
            ref other => panic!("{other:?}"),
        };
        master.handle_frame(&said(FromDrive::Parameter { number, value, status: ParameterStatus::Done }), 0);
    }
}

const RAISED: FromDrive =
    FromDrive::Parameter { number: number::LOG_READ_REQUEST, value: 1, status: ParameterStatus::Done };

#[test]
fn log_words_find_their_place_in_any_order() {
    let mut master = raised(5);
    let data = |counter: u16| said(FromDrive::LogData { counter, data: [counter, counter + 1, counter + 2] });
    // The first words overtake the answer.
    master.handle_frame(&data(3), 1);
    master.handle_frame(&said(RAISED), 2);
    for counter in [0, 9, 6, 6, 12] {
        master.handle_frame(&data(counter), 3);
    }
    let chunks: Vec<(u32, u16)> =
        std::iter::from_fn(|| master.poll_chunk()).map(|chunk| (chunk.offset, chunk.words()[0])).collect();
    assert_eq!(chunks, [(3, 3), (0, 0), (9, 9), (6, 6), (12, 12)]);
    assert_eq!(master.poll_download(), Some(Ok(15)));
}

#[test]
fn a_stream_that_begins_after_its_abort_is_stopped() {
    let mut master = raised(5);
    master.abort_download();
    assert_eq!(sent(&mut master, 1), [], "one message at a time");
    master.handle_frame(&said(RAISED), 2);
    assert_eq!(sent(&mut master, 3), [ToDrive::SetParameter { number: number::LOG_READ_REQUEST, value: 0 }]);
    assert_eq!(master.poll_download(), None);
    let lowered =
        FromDrive::Parameter { number: number::LOG_READ_REQUEST, value: 0, status: ParameterStatus::Done };
    master.handle_frame(&said(lowered), 4);
    assert_eq!(master.poll_download(), Some(Err(DownloadError::Aborted)));
}

#[test]
fn a_slow_caller_gets_everything() {
    let mut bench = Bench::new(Device::new(500, 0));
    bench.appetite = 1;
    assert_eq!(bench.download(Download::Description), Ok(bench.device.description.clone()));
}

#[test]
fn a_drive_that_does_not_know_downloads_does_not_answer() {
    let config = Config { read_parameters: false, ..Config::default() };
    for (what, milliseconds) in [(Download::Description, 300), (Download::Scope { words: 30 }, 1500)] {
        let mut master = Master::new(config);
        master.download(what).unwrap();
        assert_eq!(master.download(what), Err(NotTaken::Full));
        let ended = (0..3_000_000).step_by(100).find(|now| {
            while master.poll_frame(*now).is_some() {}
            master.poll_download() == Some(Err(DownloadError::NoAnswer))
        });
        assert_eq!(ended.map(|now| now / 1000), Some(milliseconds), "{what:?}");
    }
    // Its log has no size; where it has one, 75 is answered with status 5.
    let mut bench = Bench::new(Device::new(0, 0));
    assert_eq!(bench.download(Download::Log { first: 0, records: 1 }), Err(DownloadError::NoLog));
    let mut master = Master::new(config);
    master.download(Download::Log { first: 0, records: 1 }).unwrap();
    while let Some(frame) = master.poll_frame(0) {
        let (number, value, status) = match ToDrive::decode(&frame).unwrap().1 {
            ToDrive::RequestParameter { number } => (number, 6, ParameterStatus::Done),
            ToDrive::SetParameter { number: number::LOG_READ_REQUEST, value: 1 } => {
                (number::LOG_READ_REQUEST, 0, ParameterStatus::Storage)
            }
            ToDrive::SetParameter { number, value } => (number, value, ParameterStatus::Done),
            _ => continue,
        };
        master.handle_frame(&said(FromDrive::Parameter { number, value, status }), 0);
    }
    let end = master.poll_download().unwrap().unwrap_err();
    assert_eq!(
        end.to_string(),
        "parameter 75 \"Logging read request\": the parameter store or log memory is missing, busy or failed"
    );
}

#[test]
fn a_stream_that_breaks_off_is_asked_for_three_times_more() {
    let mut bench = Bench::new(Device::new(300, 0));
    bench.device.lost = (50..100_000).collect();
    bench.master.download(Download::Description).unwrap();
    let (end, at) = bench.end();
    assert_eq!(end, Err(DownloadError::NoAnswer));
    // The first stream brings 50 frames; three more bring nothing.
    let starts = bench.device.asked.iter().filter(|asked| **asked == ToDrive::DownloadXml(XmlCommand::Start));
    assert_eq!(starts.count(), 4);
    assert!((2000..2100).contains(&at), "{at} ms");
}

#[test]
fn progress_is_told_and_a_download_can_be_aborted() {
    for what in
        [Download::Description, Download::Scope { words: 3000 }, Download::Log { first: 0, records: 300 }]
    {
        let mut bench = Bench::new(Device::new(3000, 20));
        bench.master.download(what).unwrap();
        assert_eq!(bench.master.download_progress().map(|progress| progress.received).unwrap_or(0), 0);
        bench.run(10);
        let Progress { received, total } = bench.master.download_progress().unwrap();
        assert!((300..2000).contains(&received) && total == 3000, "{received} of {total}");
        bench.master.abort_download();
        let (end, at) = bench.end();
        assert_eq!((end, at), (Err(DownloadError::Aborted), 10), "{what:?}");
        let stop = match what {
            Download::Description => Some(ToDrive::DownloadXml(XmlCommand::Length)),
            // Nothing stops the scope; nobody takes what still comes.
            Download::Scope { .. } => None,
            Download::Log { .. } => {
                Some(ToDrive::SetParameter { number: number::LOG_READ_REQUEST, value: 0 })
            }
        };
        assert_eq!(bench.device.stream.is_empty(), stop.is_some());
        assert!(stop.is_none_or(|stop| bench.device.asked.last() == Some(&stop)));
        bench.run(10);
        assert_eq!((bench.master.poll_chunk(), bench.master.poll_download()), (None, None));
        assert_eq!(bench.download(Download::Description), Ok(bench.device.description.clone()));
    }
}

#[test]
fn an_abort_is_in_time_at_any_time() {
    for ticks in 0..40 {
        let mut bench = Bench::new(Device::new(60, 20));
        bench.master.download(Download::Log { first: 0, records: 20 }).unwrap();
        (0..ticks).for_each(|_| bench.step());
        bench.master.abort_download();
        let (end, _) = bench.end();
        assert!(matches!(end, Err(DownloadError::Aborted) | Ok(200)), "{ticks}: {end:?}");
        assert_eq!(bench.device.stream.len(), 0, "{ticks}");
        assert_eq!(bench.download(Download::Scope { words: 60 }), Ok(bench.device.scope.clone()), "{ticks}");
    }
}

#[test]
fn commands_and_requests_go_before_the_download() {
    let mut bench = Bench::new(Device::new(0, 20));
    bench.master.download(Download::Log { first: 0, records: 10 }).unwrap();
    bench.master.request(Request::Read { number: 5 }).unwrap();
    bench.master.start(1000);
    let frames: Vec<ToDrive> = std::iter::from_fn(|| bench.master.poll_frame(0))
        .map(|frame| ToDrive::decode(&frame).unwrap().1)
        .collect();
    assert_eq!(frames.len(), 3);
    assert!(
        matches!(frames[0], ToDrive::MotorCommand { .. }) && matches!(frames[1], ToDrive::RequestWord(_))
    );
    assert_eq!(frames[2], ToDrive::RequestParameter { number: 5 });
}

#[test]
fn a_silent_master_downloads_nothing() {
    let mut master = Master::new(Config { silent: true, ..Config::default() });
    assert_eq!(master.download(Download::Description), Err(NotTaken::Silent));
    // Words that another master has asked for are not its own.
    let data = FromDrive::XmlData { address: 0, data: [1, 2, 3] };
    master.handle_frame(&data.encode(Addresses::FACTORY), 0);
    assert_eq!(master.poll_chunk(), None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Whatever is lost of the streams, nothing is missing in the end, and nothing is wrong.
    #[test]
    fn downloads_are_complete_or_fail(
        kind in 0..3_u8,
        words in 1..1500_u16,
        record in 1..70_i32,
        lost in prop::collection::btree_set(0..2000_usize, 0..300),
        appetite in 1..6_usize,
    ) {
        let mut bench = Bench::new(Device::new(words, record));
        (bench.device.lost, bench.appetite) = (lost, appetite);
        let records = u32::from(words) / u32::try_from((record + 1) / 2).unwrap();
        let (what, expected) = match kind {
            0 => (Download::Description, bench.device.description.clone()),
            1 => (Download::Scope { words: words.into() }, bench.device.scope.clone()),
            _ => {
                let size = (record + 1) / 2 * records as i32;
                (Download::Log { first: 0, records }, bench.device.log[..size as usize].to_vec())
            }
        };
        match bench.download(what) {
            Ok(words) => prop_assert!(words == expected),
            Err(error) => prop_assert_eq!(error, DownloadError::NoAnswer),
        }
        // With an undisturbed line it works.
        bench.device.lost.clear();
        prop_assert!(bench.download(what) == Ok(expected));
    }
}
