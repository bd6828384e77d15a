//! Tests of whole logs: every line is a frame or an error, with any number of threads, and wherever the file
//! ends.

use narx_core::bus::candump::{Line, line};
use narx_core::bus::narmotion::{Addresses, FromDrive, Measurement, ToDrive};
use narx_host::can_log::{CanLog, Config, Ends, Kind, LineError, Values};
use proptest::prelude::*;

const CONFIG: Config = Config { ends: Ends { slave: Some(170), monitor: Some(85) }, encoders: 0 };

fn read(text: &[u8], threads: usize) -> CanLog {
    let mut log = CanLog::new(CONFIG);
    log.read_candump(text, threads);
    log
}

/// Strategy of lines of many kinds.
fn some_line() -> impl Strategy<Value = String> {
    let stamp = (0_u32..2_000_000_000, 0_u32..1_000_000).prop_map(|(s, us)| format!("({s}.{us:06})"));
    let frame = prop_oneof![
        8 => (0_u32..1 << 11, "[0-9A-F]{16}").prop_map(|(low, data)| format!("1{:07X}#{data}", 0x055_2A800 | low)),
        4 => "[0-7][0-9A-F]{2}#([0-9A-F]{2}){0,8}",
        1 => "[0-7][0-9A-F]{2}##[0-7]([0-9A-F]{2}){0,64}",
        1 => "[0-9A-F]{1,9}#R?[0-9]{0,3}",
        1 => "[ -~]{0,20}",
    ];
    let channel = prop_oneof![5 => Just("can0".to_owned()), 1 => "[a-z]{1,4}[0-3]"];
    let direction = prop_oneof![Just(""), Just(" R"), Just(" T")];
    let whole = (stamp, channel, frame, direction);
    let whole =
        whole.prop_map(|(stamp, channel, frame, direction)| format!("{stamp} {channel} {frame}{direction}"));
    prop_oneof![20 => whole, 1 => Just(String::new()), 1 => "[ -~]{0,40}"]
}

fn is_blank(line: &&str) -> bool {
    line.trim_ascii().is_empty()
}

/// Checks that every frame is in exactly one place: in a table, or marked as unknown, malformed or an error
/// frame.
fn assert_all_there(log: &CanLog) {
    let rows: usize = log.tables.iter().map(|table| table.time.len()).sum();
    let in_tables = log.frames.message.iter().filter(|kind| **kind < Kind::Error as u8).count();
    assert_eq!(rows, in_tables);
    for table in &log.tables {
        for column in &table.columns {
            let length = match column {
                Values::Quantity(values) => values.len(),
                Values::Number(values) => values.len(),
                Values::Code(values) => values.len(),
                Values::Flag(values) => values.len(),
                Values::Faults(values) => values.len(),
            };
            assert_eq!(length, table.time.len(), "{}", table.name);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_line_is_a_frame_or_an_error(lines in proptest::collection::vec(some_line(), 0..60)) {
        let text: String = lines.iter().map(|line| line.clone() + "\n").collect();
        let log = read(text.as_bytes(), 1);
        assert_all_there(&log);
        let blank = text.lines().filter(is_blank).count();
        prop_assert_eq!(log.lines, lines.len());
        prop_assert_eq!(log.frames.time.len() + log.errors.len() + blank, lines.len());
        for error in &log.errors {
            let text = lines[error.line - 1].as_bytes();
            prop_assert_eq!(Line::parse(text).unwrap_err().reason(), error.reason);
        }
    }

    #[test]
    fn parts_that_are_cut_anywhere_change_nothing(
        lines in proptest::collection::vec(some_line(), 0..30), cuts in proptest::collection::vec(0.0..1.0, 0..6), end in 0.5..=1.0,
    ) {
        let text: String = lines.iter().map(|line| line.clone() + "\n").collect();
        let text = &text.as_bytes()[..(text.len() as f64 * end) as usize];
        let whole = read(text, 1);
        let mut places: Vec<usize> = cuts.iter().map(|cut| (text.len() as f64 * cut) as usize).collect();
        places.sort_unstable();
        let mut log = CanLog::new(CONFIG);
        for (from, to) in [0].iter().chain(&places).zip(places.iter().chain([&text.len()])) {
            log.feed_candump(&text[*from..*to], 2);
        }
        log.end_candump();
        prop_assert_eq!(&log.frames, &whole.frames);
        // As text: a value that a message does not carry is no number, and equals nothing.
        let tables = [&log, &whole].map(|log| format!("{:?}", log.tables));
        prop_assert!(tables[0] == tables[1], "tables differ");
        prop_assert_eq!((&log.errors, log.lines), (&whole.errors, whole.lines));
    }

    #[test]
    fn a_log_that_ends_anywhere_loses_its_last_line_at_most(
        lines in proptest::collection::vec(some_line(), 1..20), part in 0.0..1.0,
    ) {
        let text: String = lines.iter().map(|line| line.clone() + "\n").collect();
        let end = (text.len() as f64 * part) as usize;
        let cut = read(&text.as_bytes()[..end], 1);
        let kept = cut.frames.time.len();
        // Lines before the cut are unchanged. The last, incomplete line is at most read as a frame with less
        // data, even where the whole line is none: "12#798" has half a byte too many, "12#79" has not.
        let complete = text[..end].matches('\n').count();
        let before = read(text[..end].rsplit_once('\n').map_or("", |(head, _)| &text[..head.len() + 1]).as_bytes(), 1);
        prop_assert_eq!(&cut.frames.id[..before.frames.id.len()], &before.frames.id[..]);
        prop_assert!(kept <= before.frames.time.len() + 1);
        prop_assert!(cut.lines <= complete + 1);
    }
}

#[test]
fn threads_change_nothing() {
    let mut text = String::new();
    let mut random = narx_sim::random::Random::new(7);
    let channels = ["can0", "can1", "vcan0"];
    for at in 0..60_000_u64 {
        let measurement = Measurement::M2 {
            bus_voltage: random.bits() as i16,
            bus_current: at as i16,
            rail_6v: 6000,
            rail_14v: 14_000,
        };
        let frame = match random.bits() % 4 {
            0 => ToDrive::MotorCommand { speed: at as u16 }.encode(Addresses::FACTORY),
            _ => FromDrive::Measurement(measurement).encode(Addresses::FACTORY),
        };
        // Channels begin late, and in other parts of the log in another order.
        let channel = channels[(at / 25_000) as usize];
        text += &format!("{}\n", line(at * 100_000, channel, &frame));
        if random.bits().is_multiple_of(1000) {
            text += "(1.0) can0 noise\n";
        }
    }
    let one = read(text.as_bytes(), 1);
    assert_eq!(one.frames.time.len(), 60_000);
    assert_eq!(one.frames.channels, channels);
    assert!(one.errors.len() > 20);
    assert_all_there(&one);
    for threads in [2, 3, 7, 64] {
        let many = read(text.as_bytes(), threads);
        assert!(one.frames == many.frames && one.tables == many.tables, "{threads} threads");
        assert_eq!(one.errors, many.errors, "{threads} threads");
        assert_eq!(one.lines, many.lines);
    }
}

#[test]
fn a_file_that_ends_within_a_line_says_so() {
    let cut = |text: &str| -> (usize, Vec<(usize, &'static str)>) {
        let log = read(text.as_bytes(), 1);
        (
            log.frames.time.len(),
            log.errors.iter().map(|LineError { line, reason, .. }| (*line, *reason)).collect(),
        )
    };
    let told = |line| vec![(line, "the file ends within this line")];
    let first = "(1.0) can0 182#00112233 R\n";
    assert_eq!(cut(first), (1, vec![]));
    assert_eq!(cut(&format!("{first}(2.0) can0 182#00112233 R")), (2, vec![]), "all there but the line end");
    assert_eq!(cut(&format!("{first}(2.0) can0 182#00112233")), (1, told(2)), "the direction is missing");
    assert_eq!(cut(&format!("{first}(2.0) can0 182#00112")), (1, told(2)));
    assert_eq!(cut(&format!("{first}(2.0) ca")), (1, told(2)));
    let bare = "(1.0) can0 182#00112233\n(1.5) can0 181#\n";
    assert_eq!(cut(&format!("{bare}(2.0) can0 182#00112233")), (3, vec![]));
    assert_eq!(cut(&format!("{bare}(2.0) can0 182#0011")), (2, told(3)), "shorter than the one before");
    assert_eq!(cut(&format!("{bare}(2.0) can0 183#0011")), (3, vec![]), "nothing says that it was longer");
    assert_eq!(cut(&format!("{bare}(2.0) can0 182#R")), (3, vec![]), "a request is no shorter answer");
}
