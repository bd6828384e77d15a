//! Target: logs of can-utils, as single lines and as whole logs in columns.

use narx_core::bus::candump::{self, Content, Line};
use narx_core::bus::narmotion::MESSAGES;
use narx_host::can_log::{CanLog, Config, Ends, Kind, Values, flag, node};

/// Runs an input: a log.
pub fn run(data: &[u8]) {
    let lines: Vec<&[u8]> = data.split(|byte| *byte == b'\n').collect();
    let frames = lines.iter().filter(|text| is_frame(text)).count();
    for ends in [Ends { slave: None, monitor: None }, Ends { slave: Some(0xAA), monitor: Some(0x55) }] {
        let mut log = CanLog::new(Config { ends, encoders: u128::from(data.len() as u64) });
        log.read_candump(data, 2);
        check(&log);
        // All of its lines are frames, errors or empty; the lines before it decide whether the last one
        // counts.
        assert!(log.frames.time.len() == frames || log.frames.time.len() + 1 == frames, "{frames}");
        assert!(log.lines <= lines.len());

        // Two logs in sequence are one log if the last line is complete: the lines before an incomplete line
        // decide whether it counts.
        let whole = data.ends_with(b"\n");
        let cut = data.iter().position(|byte| *byte == b'\n').map_or(data.len(), |at| at + 1);
        let (first, second) = data.split_at(cut);
        if whole && first.ends_with(b"\n") {
            let mut parts = CanLog::new(Config { ends, encoders: u128::from(data.len() as u64) });
            parts.read_candump(first, 1);
            parts.read_candump(second, 1);
            assert_eq!((parts.frames.id, parts.errors), (log.frames.id, log.errors));
        }
    }
}

/// Returns whether a line is a frame; if so, checks that the line that we write has the same content.
fn is_frame(text: &[u8]) -> bool {
    let Ok(Some(line)) = Line::parse(text) else { return false };
    assert!(line.time.is_finite());
    if let Content::Frame(frame) = line.content {
        let written = candump::line(1_500_000, line.channel, &frame).to_string();
        let again = Line::parse(written.as_bytes()).expect("our own line").expect("not an empty one");
        assert_eq!((again.content, again.channel, again.time), (line.content, line.channel, 1.5e-3));
    }
    true
}

/// Checks that all columns have equal length, and that every row of a table is a frame that refers to it.
fn check(log: &CanLog) {
    let frames = &log.frames;
    let rows = frames.time.len();
    let lengths = [frames.id.len(), frames.flags.len(), frames.channel.len(), frames.dlc.len()];
    assert_eq!((lengths, frames.message.len(), frames.data.len()), ([rows; 4], rows, rows));
    assert!(frames.channel.iter().all(|place| usize::from(*place) < frames.channels.len()));
    assert_eq!(log.tables.len(), MESSAGES.len() + node::MESSAGES.len());
    for (place, table) in log.tables.iter().enumerate() {
        let said = frames.message.iter().filter(|message| usize::from(**message) == place).count();
        assert_eq!(table.time.len(), said, "{}", table.name);
        for values in &table.columns {
            let length = match values {
                Values::Quantity(values) => values.len(),
                Values::Number(values) => values.len(),
                Values::Code(values) => values.len(),
                Values::Flag(values) => values.len(),
                Values::Faults(values) => values.len(),
            };
            assert_eq!(length, said, "{}", table.name);
        }
    }
    let unknown = [Kind::Unknown, Kind::Malformed, Kind::Error].map(|kind| kind as u8);
    for (message, flags) in frames.message.iter().zip(&frames.flags) {
        assert!(usize::from(*message) < log.tables.len() || unknown.contains(message));
        assert_eq!(*message == Kind::Error as u8, flags & flag::ERROR != 0);
    }
    let numbers: Vec<usize> = log.errors.iter().map(|error| error.line).collect();
    assert!(numbers.is_sorted_by(|before, after| before < after));
    assert!(numbers.iter().all(|number| (1..=log.lines).contains(number)));
}
