//! Tests of a bus full of other nodes' frames: the master's requests and the drive's answers among them.

use super::wired::Wired;
use narx_core::bus::narmotion::{FromDrive, MessageId, MessageKind, Opcode, Priority, ToDrive};
use narx_core::bus::{Frame, Id};
use narx_core::dictionary::number;
use narx_core::motor::State;
use narx_core::motor::guard::fault::Cause;
use narx_sim::can::Attachment;

/// Longest time from a request to its answer, ns: 5 ms.
const ANSWER_MAX: u64 = 5_000_000;

/// Runs a tick with the other node's queue filled: at most one frame ends in 100 us.
fn step(wired: &mut Wired, flood: &impl Fn(u64) -> Frame) {
    while wired.bench.other_queued() < 4 {
        wired.bench.send_as_other(flood(wired.bench.plant().tick())).unwrap();
    }
    wired.step();
    while wired.bench.receive_as_other().is_some() {}
}

fn frame(id: u32, bytes: u64) -> Frame {
    Frame::full(Id::extended(id).unwrap(), bytes.to_be_bytes())
}

/// An identifier of the master with the lowest priority, which a drive ignores.
fn to_drive(kind: MessageKind, opcode: u16) -> MessageId {
    let opcode = Opcode::new(opcode).unwrap();
    MessageId { priority: Priority::Lowest, source: 0x55, destination: 0xAA, kind, opcode }
}

/// Sends a hundred requests in the flood; returns the longest time to an answer, ns.
fn ask(wired: &mut Wired, flood: &impl Fn(u64) -> Frame) -> u64 {
    let mut longest = 0;
    for question in 0..100_u16 {
        wired.received.clear();
        let asked = wired.bench.now_ns();
        wired.send(ToDrive::RequestParameter { number: question });
        // 17.3 ms: the requests come at all phases of the broadcasts.
        for _ in 0..173 {
            step(wired, flood);
        }
        let answers = wired.received.iter().filter(|(_, frame)| {
            let message = FromDrive::decode(frame).map(|(_, message)| message);
            matches!(message, Ok(FromDrive::Parameter { number, .. }) if number == question)
        });
        let answers: Vec<u64> = answers.map(|(time, _)| time - asked).collect();
        assert_eq!(answers.len(), 1, "request {question}");
        longest = longest.max(answers[0]);
    }
    longest
}

#[test]
fn requests_are_answered_in_5_ms_on_a_full_bus() {
    type Flood = fn(u64) -> Frame;
    let floods: [(&str, Flood); 3] = [
        ("others' traffic", |tick| frame(0x1FFF_0000 | tick as u32 & 0xFFFF, tick)),
        ("without stuff bits", |_| frame(0x1AAA_AAAA, 0xAAAA_AAAA_AAAA_AAAA)),
        ("junk for the drive", |tick| {
            let lowest = to_drive(MessageKind::DataSet, 400);
            Frame::full(lowest.encode(), tick.to_be_bytes())
        }),
    ];
    for (name, flood) in floods {
        let mut wired = Wired::turning();
        wired.bench.set_other(Attachment::Normal);
        for _ in 0..100 {
            step(&mut wired, &flood);
        }
        let before = (wired.bench.bus_statistics(), wired.bench.now_ns());
        let longest = ask(&mut wired, &flood);
        let load = wired.bench.bus_statistics().load_since(&before.0, wired.bench.now_ns() - before.1);
        println!("{name}: load {load:.4}, longest answer {longest} ns");
        assert!(load > 0.999, "{name}: {load}");
        assert!(longest <= ANSWER_MAX, "{name}: {longest} ns");
        assert_eq!(wired.bench.overruns(), 0, "{name}: every frame is taken in the tick it arrives");
        assert_eq!(wired.look(number::FRAMES_LOST), 0, "{name}");
        assert_eq!(wired.bench.status().state, State::HallClosedLoop, "{name}");
        assert!((wired.speed() - 1500.0).abs() < 20.0, "{name}");
    }
}

/// Valid requests with the lowest priority, as fast as the bus carries them, all get their answers.
#[test]
fn a_flood_of_requests_loses_none() {
    let mut wired = Wired::turning();
    wired.bench.set_other(Attachment::Normal);
    let id = to_drive(MessageKind::DataRequest, 110);
    let (mut asked, mut answered) = (0, 0);
    for tick in 0..20_000_u64 {
        while tick < 19_900 && wired.bench.other_queued() < 4 {
            wired
                .bench
                .send_as_other(Frame::full(id.encode(), ((asked % 122_u64) << 48).to_be_bytes()))
                .unwrap();
            asked += 1;
        }
        wired.step();
        let messages = wired.take_messages();
        answered +=
            messages.iter().filter(|message| matches!(message, FromDrive::Parameter { .. })).count() as u64;
        while wired.bench.receive_as_other().is_some() {}
    }
    println!("{asked} requests in 2 s, {answered} answers");
    assert!(asked > 2_500, "{asked}");
    assert_eq!((answered, wired.look(number::FRAMES_LOST)), (asked, 0));
    assert_eq!(wired.bench.status().state, State::HallClosedLoop);
}

/// By arbitration a node that sends the highest priority without a gap has the bus alone. The drive's
/// protection is the command time-out, and it answers as soon as there is room.
#[test]
fn a_flood_of_the_highest_priority_silences_everybody() {
    let mut wired = Wired::turning();
    wired.bench.set_other(Attachment::Normal);
    let flood = |tick: u64| frame(0, tick);
    for _ in 0..10 {
        step(&mut wired, &flood);
    }
    wired.received.clear();
    wired.send(ToDrive::RequestParameter { number: number::DEVICE_NUMBER });
    for _ in 0..3_000 {
        step(&mut wired, &flood);
    }
    let addresses = wired.bench.node().addresses();
    let from_drive = |frame: &Frame| MessageId::of(frame).is_ok_and(|id| id.source == addresses.drive);
    assert!(!wired.received.iter().any(|(_, frame)| from_drive(frame)));
    assert_eq!(wired.bench.status().state, State::Fault);
    assert_eq!(wired.look(number::EXTENDED_FAULT_CODE), Cause::CommandTimeout as i32);

    wired.received.clear();
    wired.asks = None;
    while wired.bench.other_queued() > 0 {
        wired.step();
    }
    let free = wired.bench.now_ns();
    wired.run(0.02);
    let answer = wired.received.iter().find(|(_, frame)| {
        matches!(
            FromDrive::decode(frame),
            Ok((_, FromDrive::Parameter { number: number::DEVICE_NUMBER, .. }))
        )
    });
    let took = answer.expect("it was not lost").0.saturating_sub(free);
    assert!(took <= ANSWER_MAX, "{took} ns");
}
