//! Tests of the master, with a driver at the other end of the bus or with answers of other nodes.

use crate::bench::{Bench, SAMPLE, frame, mm, node};
use narx_core::bus::eddycan::{AbortCode, Channels, Layout, NmtCommand, NmtState, PdoKind, Reading};
use narx_core::bus::{Frame, Id};
use narx_core::eddycan::{Entry, OBJECTS, Sample};
use narx_core::master::NotTaken;
use narx_core::master::eddycan::{Answer, Config, Request, RequestError, TxMaster};

/// A master and its driver on a bus that takes no time and loses selected frames.
struct Pair {
    bench: Bench,
    master: TxMaster,
}

impl Pair {
    fn new(channels: Channels, values: &[(Entry, u32)]) -> Self {
        let bench = Bench::new(channels, values);
        let master = TxMaster::new(Config::new(node(1), bench.driver.layout()));
        Self { bench, master }
    }

    /// Lets frames pass for a time, in steps of a millisecond; those that `lost` selects are lost. Returns
    /// the frames that the master has sent.
    fn run(&mut self, milliseconds: u64, mut lost: impl FnMut(&Frame) -> bool) -> Vec<Frame> {
        let mut sent = Vec::new();
        for _ in 0..milliseconds {
            let now = self.bench.now;
            for frame in std::iter::from_fn(|| self.master.poll_frame(now)) {
                sent.push(frame);
                if !lost(&frame) {
                    self.bench.give(&frame);
                }
            }
            for frame in self.bench.wait(1000) {
                if !lost(&frame) {
                    self.master.handle_frame(&frame, self.bench.now);
                }
            }
        }
        sent
    }

    fn answers(&mut self) -> Vec<Result<u32, RequestError>> {
        std::iter::from_fn(|| self.master.poll_answer()).map(|answer| answer.result).collect()
    }
}

/// Every entry can be written and read back over the bus.
#[test]
fn configures_a_driver() {
    let mut pair = Pair::new(Channels::Dual, &[]);
    for row in &OBJECTS {
        let value = row.max.min(6);
        pair.master.request(Request::Write(row.entry, value)).unwrap();
        pair.master.request(Request::Read(row.entry)).unwrap();
        pair.run(10, |_| false);
        let expected = match row.entry {
            Entry::ResetEncoder => [Ok(6), Err(RequestError::Refused(AbortCode::WriteOnly))],
            Entry::FirmwareVersion => {
                [Err(RequestError::Refused(AbortCode::ReadOnly)), Ok(crate::bench::FIRMWARE.into())]
            }
            _ => [Ok(value), Ok(value)],
        };
        assert_eq!(pair.answers(), expected, "{}", row.name);
    }
}

#[test]
fn commands_watches_and_reads() {
    let mut pair = Pair::new(Channels::Dual, &[(Entry::CanConfig, 4), (Entry::UpdateTime, 10)]);
    assert!(!pair.master.is_present(pair.bench.now));
    assert_eq!(pair.master.reading(), None);
    for (command, state) in [
        (NmtCommand::Start, NmtState::Operational),
        (NmtCommand::Stop, NmtState::Stopped),
        (NmtCommand::PreOperational, NmtState::PreOperational),
    ] {
        pair.master.command(command).unwrap();
        pair.run(2001, |_| false);
        assert_eq!(pair.master.report().state, Some(state));
        assert!(pair.master.is_present(pair.bench.now));
    }
    let reading = Reading { positions: SAMPLE.positions, encoder: 0 };
    let (found, kind, _) = pair.master.reading().unwrap();
    assert_eq!((found, kind), (reading, PdoKind::Timer));
    assert_eq!(found.positions.map(|position| position.picometres()), [1_000_000_000, -2_000_000_000]);
    // The node counts as gone after 5 s of silence.
    pair.run(4000, |_| true);
    assert!(pair.master.is_present(pair.bench.now));
    pair.run(1001, |_| true);
    assert!(!pair.master.is_present(pair.bench.now));
}

#[test]
fn sync_and_remote_requests() {
    let mut pair = Pair::new(Channels::Single, &[]);
    pair.master.command_all(NmtCommand::Start).unwrap();
    pair.run(1, |_| false);
    for (ask, kind) in [
        (TxMaster::sync as fn(&mut TxMaster) -> Result<(), NotTaken>, PdoKind::Sync),
        (TxMaster::ask_positions, PdoKind::Remote),
    ] {
        ask(&mut pair.master).unwrap();
        pair.run(2, |_| false);
        assert_eq!(pair.master.reading().unwrap().1, kind);
    }
}

/// The encoder's part of a PDO comes and goes with the register.
#[test]
fn the_layout_follows_the_register() {
    let mut pair = Pair::new(Channels::Dual, &[]);
    for (register, encoder, counts) in [(3, true, 33), (1, false, 0), (2, true, 33)] {
        pair.master.command(NmtCommand::PreOperational).unwrap();
        pair.master.request(Request::Write(Entry::CanConfig, register)).unwrap();
        pair.run(5, |_| false);
        assert_eq!(pair.master.config().layout.encoder, encoder);
        pair.bench.driver.handle_sample(Sample { positions: [mm(2); 2], counter: SAMPLE.counter + 33 });
        pair.master.command(NmtCommand::Start).unwrap();
        pair.master.sync().unwrap();
        pair.run(5, |_| false);
        assert_eq!(pair.master.reading().unwrap().0, Reading { positions: [mm(2); 2], encoder: counts });
    }
    assert_eq!(pair.master.report().malformed, 0);
}

/// Counts of a linear encoder are signed, and its resolution turns them into a length; values that were
/// neither read nor written are unknown.
#[test]
fn a_linear_encoder_has_a_position() {
    let mut pair = Pair::new(Channels::Single, &[(Entry::CanConfig, 2), (Entry::EncoderResolution, 250)]);
    let backwards = Reading { positions: [mm(2); 2], encoder: (-3000_i16) as u16 };
    let known = |pair: &Pair| {
        let encoder = pair.master.report().encoder;
        (encoder.counts(&backwards), encoder.position(&backwards).map(|length| length.to_string()))
    };
    assert_eq!(known(&pair), (62_536, None));
    for (request, expected) in [
        (Request::Read(Entry::BasicConfig), (-3000, None)),
        (Request::Read(Entry::EncoderResolution), (-3000, Some("-0.75"))),
        (Request::Write(Entry::EncoderResolution, 1), (-3000, Some("-0.003"))),
        (Request::Write(Entry::EncoderResolution, 65_535), (-3000, Some("-196.605"))),
        (Request::Write(Entry::BasicConfig, 2), (62_536, None)),
        (Request::Write(Entry::BasicConfig, 4), (-3000, Some("-196.605"))),
    ] {
        pair.master.request(request).unwrap();
        pair.run(5, |_| false);
        assert!(pair.answers()[0].is_ok());
        assert_eq!(known(&pair), (expected.0, expected.1.map(str::to_owned)), "{request:?}");
    }
}

/// Any two of three attempts may be lost, in either direction; the third loss is an error. A reset of the
/// encoder has one attempt.
#[test]
fn repeats_what_gets_no_answer() {
    for (entry, attempts) in [(Entry::UpdateTime, 3), (Entry::ResetEncoder, 1)] {
        for back in [false, true] {
            for losses in 0..=3_usize {
                let mut pair = Pair::new(Channels::Single, &[]);
                pair.master.request(Request::Write(entry, 77)).unwrap();
                let mut left = losses;
                let direction = if back { 0x581 } else { 0x601 };
                let sent = pair.run(500, |frame| {
                    let hit = frame.id().raw() == direction && left > 0;
                    left -= usize::from(hit);
                    hit
                });
                let done = losses < attempts;
                let expected = if done { Ok(77) } else { Err(RequestError::NoAnswer) };
                assert_eq!(pair.answers(), [expected], "{entry:?}, {losses} lost");
                assert_eq!(sent.len(), attempts.min(losses + 1));
            }
        }
    }
}

#[test]
fn an_operational_node_refuses_and_a_stopped_one_is_silent() {
    let mut pair = Pair::new(Channels::Single, &[]);
    for (command, error) in [
        (NmtCommand::Start, RequestError::Refused(AbortCode::General)),
        (NmtCommand::Stop, RequestError::NoAnswer),
    ] {
        pair.master.command(command).unwrap();
        pair.master.request(Request::Read(Entry::NodeId)).unwrap();
        pair.run(400, |_| false);
        assert_eq!(pair.answers(), [Err(error)]);
    }
}

/// Answers to other requests are ignored, and answers of nodes that follow the specification less strictly
/// are accepted.
#[test]
fn answers_of_other_nodes() {
    let read = Request::Read(Entry::UpdateTime);
    let ask = |request, data: &[u8]| {
        let mut master = TxMaster::new(Config::new(node(1), Layout::ALL[0]));
        master.request(request).unwrap();
        assert!(master.poll_frame(0).is_some());
        master.handle_frame(&frame(0x581, data), 10);
        master.poll_answer().map(|Answer { result, .. }| result)
    };
    for (data, result) in [
        ([0x4B, 3, 0x20, 0, 0x10, 0x27, 0, 0], Some(Ok(10_000))),
        // Four bytes for two, with random upper bytes; without a size; with another subindex.
        ([0x43, 3, 0x20, 0, 0x10, 0x27, 0xA5, 0xA5], Some(Ok(10_000))),
        ([0x42, 3, 0x20, 0, 0x10, 0x27, 0, 0], Some(Ok(10_000))),
        ([0x4B, 3, 0x20, 9, 0x10, 0x27, 0, 0], Some(Ok(10_000))),
        // Another entry; a confirmation; no answer at all.
        ([0x4B, 4, 0x20, 0, 0x10, 0x27, 0, 0], None),
        ([0x60, 3, 0x20, 0, 0, 0, 0, 0], None),
        ([0x55, 3, 0x20, 0, 0, 0, 0, 0], None),
        ([0x80, 3, 0x20, 0, 0, 0, 0x80, 0], Some(Err(RequestError::Refused(AbortCode::General)))),
        ([0x80, 3, 0x20, 0, 0x10, 0, 7, 6], Some(Err(RequestError::RefusedOtherwise { code: 0x0607_0010 }))),
    ] {
        assert_eq!(ask(read, &data), result, "{data:02X?}");
    }
    // For entries with subindices these count.
    let write = Request::Write(Entry::Filter2, 1);
    assert_eq!(ask(write, &[0x60, 6, 0x20, 1, 0, 0, 0, 0]), None);
    assert_eq!(ask(write, &[0x4F, 6, 0x20, 2, 1, 0, 0, 0]), None, "a value is no confirmation");
    assert_eq!(ask(write, &[0x60, 6, 0x20, 2, 0, 0, 0, 0]), Some(Ok(1)));
}

#[test]
fn counts_what_it_hears() {
    let mut master = TxMaster::new(Config::new(node(1), Layout::ALL[0]));
    for (id, data) in [
        (0x701, &[0][..]),
        (0x181, &[1, 2, 3, 4]),
        (0x181, &[1, 2, 3, 4, 5, 6]),
        (0x701, &[9]),
        (0x81, &[0x20, 0x81]),
        (0x81, &[0x00, 0x10, 1, 0, 0, 0, 0, 0]),
        // Frames of another node, and another master's request.
        (0x182, &[1, 2, 3, 4, 5, 6]),
        (0x82, &[0x20, 0x81]),
        (0x601, &[0x40, 0, 0x20, 0, 0, 0, 0, 0]),
    ] {
        master.handle_frame(&frame(id, data), 1);
    }
    let report = master.report();
    assert_eq!((report.boots, report.errors, report.last_error, report.malformed), (1, 2, Some(0x1000), 2));
    assert!(master.reading().is_some());
    // Another master requests the node's positions, under the node's own identifier.
    let asked = Frame::remote(Id::standard(0x381).unwrap(), 6).unwrap();
    master.handle_frame(&asked, 1);
    assert_eq!(master.report().malformed, 2);
    master.handle_frame(&frame(0x701, &[0]), 2);
    assert_eq!((master.report().boots, master.reading()), (2, None), "a new life");
}

/// Eight requests and four commands may wait; every answer that is taken makes room.
#[test]
fn bounds() {
    let mut pair = Pair::new(Channels::Single, &[]);
    let read = Request::Read(Entry::NodeId);
    for _ in 0..8 {
        pair.master.request(read).unwrap();
    }
    assert_eq!(pair.master.request(read), Err(NotTaken::Full));
    pair.run(20, |_| false);
    assert_eq!(pair.master.request(read), Err(NotTaken::Full), "eight answers wait");
    assert_eq!(pair.answers(), [Ok(1); 8]);
    pair.master.request(read).unwrap();
    for _ in 0..4 {
        pair.master.sync().unwrap();
    }
    assert_eq!(pair.master.sync(), Err(NotTaken::Full));
    assert_eq!(pair.master.next_poll(5), 5);
    pair.run(20, |_| false);
    let now = pair.bench.now;
    assert_eq!(pair.master.next_poll(now), u64::MAX);
    assert_eq!(pair.answers(), [Ok(1)]);
    pair.master.request(read).unwrap();
    assert_eq!(pair.master.next_poll(now), now, "what is asked for is due at once");
}
