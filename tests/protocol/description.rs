//! Tests of the description: its text, and its download from node and bench.

use crate::bench::{Bench, IDENTITY, frame};
use narx_core::bus::narmotion::{
    Addresses, FromDrive, MESSAGES, MotorMode, NAMES, RequestWord, ToDrive, XmlCommand,
};
use narx_core::commissioning::{Mode, Nameplate};
use narx_core::description::{Cursor, Document, LOG_RECORD, Measure};
use narx_core::dictionary::{Dictionary, Parameters, number};
use narx_core::motor::guard::fault::Cause;
use narx_core::motor::machine::state::State;
use narx_core::motor::signal::DRIVE_SIGNALS;
use narx_sim::bench::{Bench as BusBench, BenchConfig};
use narx_sim::plant::PlantConfig;
use narx_sim::presets::preset;
use proptest::prelude::*;

const DOCUMENT: Document = Document { identity: IDENTITY, addresses: Addresses::FACTORY, tick_rate: 10_000 };

fn text() -> String {
    let mut text = String::new();
    DOCUMENT.write(&mut text).unwrap();
    text
}

/// Reads the document in pieces of these sizes, in turn.
fn read(sizes: &[usize]) -> Vec<u8> {
    let mut cursor = Cursor::default();
    let mut read = Vec::new();
    for size in sizes.iter().cycle() {
        let mut piece = vec![0; *size];
        let length = DOCUMENT.read(&mut cursor, &mut piece);
        read.extend(&piece[..length]);
        if length < *size {
            return read;
        }
    }
    read
}

#[test]
fn text_of_the_description() {
    insta::assert_snapshot!(text());
}

/// CRC-32 (ISO-HDLC), as in zlib, of the text in whole words.
fn crc32(text: &[u8]) -> u32 {
    let fill: &[u8] = if text.len().is_multiple_of(2) { b"" } else { b"\n" };
    !text.iter().chain(fill).fold(!0_u32, |check, byte| {
        (0..8).fold(check ^ u32::from(*byte), |check, _| {
            if check & 1 == 1 { check >> 1 ^ 0xEDB8_8320 } else { check >> 1 }
        })
    })
}

#[test]
fn the_length_fits_the_answer() {
    assert_eq!((crc32(b"1234567890"), crc32(b"123456789")), (0x261D_AEE5, crc32(b"123456789\n")));
    let mut measure = Measure::default();
    let lines = (0..).take_while(|line| DOCUMENT.measure_line(*line, &mut measure)).count();
    // The head has two lines.
    assert_eq!((lines + 1, measure.words() as usize), (text().lines().count(), text().len().div_ceil(2)));
    assert_eq!(measure.check(), crc32(text().as_bytes()));
    assert!(measure.words() <= 65_535, "{measure:?}");
    let longest = text().lines().map(str::len).max();
    assert!(longest < Some(1024), "one line is the most that is rendered for a frame: {longest:?}");
}

#[test]
fn every_parameter_is_there_once() {
    let text = text();
    for row in Dictionary::rows() {
        let tag = format!("<parameter number=\"{}\" ", row.number);
        assert_eq!(text.matches(&tag).count(), 1, "{tag}");
    }
    assert_eq!(text.matches("<parameter ").count(), Dictionary::rows().count());
}

/// No text of a table has markup: texts go into the document unchanged.
#[test]
fn no_text_of_a_table_has_markup() {
    let mut texts: Vec<&str> = Vec::new();
    texts.extend(
        Dictionary::rows().flat_map(|row| [row.name(), row.unit(), row.description(), row.category.label()]),
    );
    for message in &MESSAGES {
        texts.push(message.name);
        texts.extend(message.fields().flat_map(|field| [field.name, field.unit]));
    }
    for names in NAMES {
        texts.push(names.of);
        texts.extend(names.values.iter().map(|(_, name)| name));
    }
    texts.extend(State::ALL.map(State::name));
    texts.extend(Cause::TABLE.iter().map(|row| row.meaning));
    texts.extend(DRIVE_SIGNALS.iter().flat_map(|signal| [signal.name, signal.unit]));
    texts.extend(LOG_RECORD.iter().map(|entry| entry.name));
    for text in texts {
        assert!(!text.contains(['&', '<', '>', '"']) && !text.chars().any(char::is_control), "{text}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(30))]

    #[test]
    fn every_chunking_reads_the_same_bytes(sizes in prop::collection::vec(1..700_usize, 1..40)) {
        prop_assert!(read(&sizes) == text().as_bytes());
    }
}

#[test]
fn single_bytes_and_the_whole_are_the_same() {
    for size in [1, 6, 100_000] {
        assert!(read(&[size]) == text().as_bytes(), "{size}");
    }
}

/// Collects received words at their positions, up to the end of the text.
#[derive(Default)]
struct Received {
    bytes: Vec<u8>,
}

impl Received {
    fn take(&mut self, address: u16, data: [u16; 3]) {
        let at = usize::from(address) * 2;
        assert_eq!(at, self.bytes.len(), "in order and without a gap");
        self.bytes.extend(data.iter().flat_map(|word| word.to_be_bytes()));
    }

    /// Text of the words, cut at its length.
    fn text(mut self, words: u16) -> String {
        assert!(self.bytes.len() >= usize::from(words) * 2);
        let filled = self.bytes.split_off(usize::from(words) * 2);
        assert!(filled.len() < 6 && filled.iter().all(|byte| *byte == 0), "{filled:?}");
        String::from_utf8(self.bytes).unwrap()
    }
}

/// Frames of the download that the node has, at most `count`.
fn bulk(bench: &mut Bench, count: usize) -> Vec<(u16, [u16; 3])> {
    let frames = std::iter::from_fn(|| bench.node.poll_bulk_frame()).take(count);
    frames
        .map(|frame| match FromDrive::decode(&frame).unwrap().1 {
            FromDrive::XmlData { address, data } => (address, data),
            other => panic!("{other:?}"),
        })
        .collect()
}

fn length(bench: &mut Bench) -> u16 {
    bench.send(ToDrive::DownloadXml(XmlCommand::Length));
    for now in 0..100 {
        bench.node.poll(now);
        let answers: Vec<_> = bench
            .messages()
            .into_iter()
            .filter_map(|message| match message {
                FromDrive::XmlLength { words, check } => {
                    assert_eq!(check, crc32(text().as_bytes()));
                    Some(words)
                }
                _ => None,
            })
            .collect();
        if let [words] = answers[..] {
            return words;
        }
        assert!(answers.is_empty(), "{answers:?}");
    }
    panic!("no answer within 10 ms");
}

fn start(bench: &mut Bench) {
    bench.send(ToDrive::DownloadXml(XmlCommand::Start));
}

#[test]
fn length_then_text() {
    let mut bench = Bench::new();
    let expected = text();
    let words = length(&mut bench);
    assert_eq!(usize::from(words), expected.len().div_ceil(2));
    assert_eq!(length(&mut bench), words, "known by now");
    assert_eq!(bulk(&mut bench, 1), [], "nothing flows unasked");
    start(&mut bench);
    let mut received = Received::default();
    for (address, data) in bulk(&mut bench, usize::MAX) {
        received.take(address, data);
    }
    assert_eq!(received.text(words).trim_end(), expected.trim_end());
    assert_eq!(bench.refused(), 0);
}

#[test]
fn a_download_begins_anew_and_ends_with_a_request_for_the_length() {
    let mut bench = Bench::new();
    start(&mut bench);
    let first = bulk(&mut bench, 50);
    start(&mut bench);
    assert_eq!(bulk(&mut bench, 50), first);
    length(&mut bench);
    assert_eq!(bulk(&mut bench, 1), []);
    start(&mut bench);
    assert_eq!(bulk(&mut bench, 50), first);
}

#[test]
fn everything_else_goes_first() {
    let mut bench = Bench::new();
    start(&mut bench);
    bench.node.poll(0);
    bench.send(ToDrive::RequestBuildInfo);
    assert_eq!(bulk(&mut bench, 1), [], "status, faults, answer and measurements wait");
    assert_eq!(bench.messages().len(), 2 + 1 + 6);
    assert_eq!(bulk(&mut bench, 1).len(), 1);
}

#[test]
fn downloads_are_refused_where_they_make_no_sense() {
    let mut bench = Bench::new();
    bench.node.handle_frame(&frame(0x0AAD_5482, 2 << 48));
    assert_eq!(bench.refused(), 1, "there is no third command");
    bench.send(ToDrive::Reboot);
    start(&mut bench);
    assert_eq!(bench.refused(), 2, "the drive is about to leave");
    assert_eq!(bench.messages(), [FromDrive::Reboot]);
    assert_eq!(bulk(&mut bench, 1), []);
    let mut bench = Bench::new();
    bench.enter(State::HallClosedLoop);
    start(&mut bench);
    assert_eq!((bench.refused(), bulk(&mut bench, 1).len()), (0, 1), "a motor that runs is no hindrance");
}

#[test]
fn identity_and_addresses_are_the_drives_own() {
    let mut parameters = Parameters::new();
    parameters.set(number::SLAVE_CAN_ADDRESS, 7).unwrap();
    parameters.set(number::MASTER_CAN_ADDRESS, 9).unwrap();
    let addresses = Addresses { drive: 7, master: 9 };
    let mut bench = Bench::with_parameters(parameters);
    bench.node.handle_frame(&ToDrive::DownloadXml(XmlCommand::Start).encode(addresses));
    let bytes: Vec<u8> =
        bulk(&mut bench, 1000).iter().flat_map(|(_, data)| data.map(u16::to_be_bytes)).flatten().collect();
    let text = String::from_utf8_lossy(&bytes);
    let head = "<description format=\"1\" build=\"42\" modified=\"0\" date=\"20261120\" hardware=\"3\" software=\"1.2\" \
                drive=\"7\" master=\"9\" rate=\"10000\">";
    assert!(text.contains(head), "{}", &text[..300]);
}

/// A commissioned hall drive on its bus.
fn on_the_bus(autosend: i32) -> BusBench {
    let motor = preset("ec45-flat-50w-18v").unwrap();
    let plate = Nameplate {
        motor: motor.motor.figures(),
        rated_current: motor.data.rated_current,
        supply: motor.data.nominal_voltage,
        open_loop_speed: None,
    };
    let mut parameters = plate.commission(Mode::Hall).unwrap().parameters;
    parameters.set(number::AUTOSEND_PERIOD, autosend).unwrap();
    let plant = PlantConfig::new(motor.motor, motor.data.nominal_voltage);
    BusBench::new(&BenchConfig { plant, parameters, label: String::new(), trace: false }).without_recording()
}

fn send(bench: &mut BusBench, message: ToDrive) {
    bench.send(message.encode(Addresses::FACTORY)).unwrap();
}

/// Returns whether the text has ended, apart from the bytes that fill the last frame.
fn is_whole(bytes: &[u8]) -> bool {
    bytes.windows(END.len()).rev().take(6).any(|end| end == END)
}

const END: &[u8] = b"</description>\n";

/// Steps until the whole description has arrived, and calls `each` for every tick and message. Returns its
/// text without the fill bytes, and the ends of its first and last frame, ns.
fn download(
    bench: &mut BusBench,
    mut each: impl FnMut(&mut BusBench, Option<(u64, FromDrive)>),
) -> (Vec<u8>, u64, u64) {
    send(bench, ToDrive::DownloadXml(XmlCommand::Start));
    let mut received = Received::default();
    let (mut first, mut last) = (None, 0);
    for _ in 0..60_000 {
        bench.step();
        each(bench, None);
        while let Some(arrived) = bench.receive() {
            let Ok((_, message)) = FromDrive::decode(&arrived.frame) else { continue };
            each(bench, Some((arrived.time_ns, message)));
            if let FromDrive::XmlData { address, data } = message {
                first.get_or_insert(arrived.time_ns);
                last = arrived.time_ns;
                received.take(address, data);
            }
        }
        // This drive's description has another identity than that of `text`, and another length.
        if is_whole(&received.bytes) {
            return (received.bytes, first.unwrap(), last);
        }
    }
    panic!("{} bytes in 6 s", received.bytes.len());
}

#[test]
fn alone_on_the_bus_a_download_takes_all_of_it() {
    let mut bench = on_the_bus(60_000);
    for _ in 0..10_000 {
        bench.step();
    }
    let before = bench.bus_statistics();
    let (bytes, first, last) = download(&mut bench, |_, _| ());
    let after = bench.bus_statistics();
    let frames = bytes.len() / 6;
    // The request is a frame, too; the first frame of data was complete at `first`.
    assert_eq!(after.frames - before.frames, frames as u64 + 1);
    let busy = after.busy_ns - before.busy_ns;
    let load = busy as f64 / (last - first) as f64 * (frames - 1) as f64 / (frames + 1) as f64;
    assert!(load >= 0.95, "{load}");
    let (bytes, words) = (text().len(), text().len().div_ceil(2));
    let seconds = (last - first) as f64 / 1e9;
    let load = load * 100.0;
    insta::assert_snapshot!(format!(
        "{bytes} bytes, {words} words, {frames} frames, {seconds:.3} s, bus load {load:.1} %"
    ));
}

#[test]
fn a_download_while_driving_delays_nothing() {
    let mut bench = on_the_bus(9);
    let hold = |bench: &mut BusBench, tick: u64, mode| {
        if tick.is_multiple_of(500) {
            send(bench, ToDrive::RequestWord(RequestWord { mode }));
        } else if tick.is_multiple_of(50) {
            send(bench, ToDrive::RequestBuildInfo);
        }
    };
    for tick in 0..20_000 {
        hold(&mut bench, tick, if tick < 10_000 { MotorMode::Standby } else { MotorMode::Drive });
        if tick == 10_000 {
            send(&mut bench, ToDrive::MotorCommand { speed: 2000 });
        }
        bench.step();
        while bench.receive().is_some() {}
    }
    assert_eq!(bench.status().state, State::HallClosedLoop);
    let (mut asked, mut waits, mut statuses, mut tick) = (Vec::new(), Vec::new(), Vec::new(), 0);
    let (_, first, last) = download(&mut bench, |bench, message| match message {
        None => {
            tick += 1;
            hold(bench, tick, MotorMode::Drive);
            if !tick.is_multiple_of(500) && tick.is_multiple_of(50) {
                asked.push(bench.now_ns());
            }
        }
        Some((at, FromDrive::BuildInfo { .. })) => waits.push(at - asked.remove(0)),
        Some((at, FromDrive::Status(_))) => statuses.push(at),
        Some(_) => {}
    });
    assert_eq!(bench.status().state, State::HallClosedLoop);
    assert!(waits.len() > 200, "{}", waits.len());
    // A frame of 160 bits on the bus and the request itself; a tick for the node and one for sending; two
    // frames in the controller, a broadcast of 8 before it, and the answer itself.
    let frame_ns = 320_000;
    let bound = 2 * frame_ns + 200_000 + (2 + 8 + 1) * frame_ns;
    let longest = *waits.iter().max().unwrap();
    assert!(longest <= bound, "{longest}");
    waits.sort_unstable();
    let median = waits[waits.len() / 2];
    assert!(median <= 2 * frame_ns + 200_000 + 3 * frame_ns, "{median}");
    // Broadcasts keep their period: only a frame on the bus and those in the controller can delay one.
    let gaps: Vec<u64> = statuses.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(gaps.iter().all(|gap| gap.abs_diff(9_000_000) <= 4 * frame_ns), "{gaps:?}");
    assert!(last - first < 6_000_000_000);
}

#[test]
fn an_interrupted_download_begins_anew_on_the_bus() {
    let mut bench = on_the_bus(50);
    send(&mut bench, ToDrive::DownloadXml(XmlCommand::Start));
    for _ in 0..3_000 {
        bench.step();
    }
    send(&mut bench, ToDrive::DownloadXml(XmlCommand::Length));
    // The frames in the controller are still sent.
    for _ in 0..300 {
        bench.step();
    }
    while bench.receive().is_some() {}
    for _ in 0..1_000 {
        bench.step();
        while let Some(received) = bench.receive() {
            let message = FromDrive::decode(&received.frame).unwrap().1;
            assert!(!matches!(message, FromDrive::XmlData { .. }), "{message:?}");
        }
    }
    let (bytes, ..) = download(&mut bench, |_, _| ());
    assert!(bytes.starts_with(b"<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<description "));
}
