//! Tests of the serial line protocol of CAN adapters: lines that are written, read and refused.

use crate::frames::{extended, standard};
use narx_core::bus::slcan::{Adapter, Channel, Command, Lines, NO, Settings, decode_frame, encode_frame};
use narx_core::bus::{Frame, Id};
use proptest::prelude::*;

/// Gives all of `text` to an adapter. Returns its answer as text, with `!` for a refusal and `/` for the end
/// of a line, and the frames that it sends.
fn say(adapter: &mut Adapter, text: &str) -> (String, Vec<Frame>) {
    let mut replies = String::new();
    let mut frames = Vec::new();
    for answer in text.replace('/', "\r").bytes().filter_map(|byte| adapter.handle_byte(byte)) {
        replies.extend(answer.reply.iter().map(|byte| match *byte {
            NO => '!',
            b'\r' => '/',
            other => char::from(other),
        }));
        frames.extend(answer.frame);
    }
    (replies, frames)
}

fn open() -> Adapter {
    Adapter::with_settings(Settings { channel: Channel::Open, ..Settings::default() })
}

#[test]
fn frames_are_written_and_read_as_the_manual_of_the_adapter_prints_them() {
    let remote = |id: Option<Id>, dlc| Frame::remote(id.unwrap(), dlc).unwrap();
    for (text, frame) in [
        ("t1002AA55", standard(0x100, &[0xAA, 0x55])),
        ("t0000", standard(0, &[])),
        ("t7FF80123456789ABCDEF", standard(0x7FF, &[0x01, 0x23, 0x45, 0x67, 0x89, 0xAB, 0xCD, 0xEF])),
        ("T0AAD520280000000100000000", extended(0x0AAD_5202, &[0, 0, 0, 1, 0, 0, 0, 0])),
        ("T1FFFFFFF17F", extended(0x1FFF_FFFF, &[0x7F])),
        ("T000001231FF", extended(0x123, &[0xFF])),
        ("r1233", remote(Id::standard(0x123), 3)),
        ("R1FFFFFFF8", remote(Id::extended(0x1FFF_FFFF), 8)),
    ] {
        assert_eq!(decode_frame(text.as_bytes()), Some((frame, None)), "{text}");
        assert_eq!(encode_frame(&frame, None), format!("{text}\r").as_bytes());
        assert_eq!(encode_frame(&frame, Some(59_999)), format!("{text}EA5F\r").as_bytes());
    }
    assert_eq!(decode_frame(b"t1001aa"), Some((standard(0x100, &[0xAA]), None)), "small letters are read");
}

#[test]
fn what_is_no_command_is_refused_and_sends_nothing() {
    for text in [
        "t",
        "t10",
        "t100",
        "t1009",
        "t8000",
        "t10021122334",
        "t1001A",
        "t1001G0",
        "t10010",
        "t1001AA0",
        "T200000000",
        "T0AAD5202",
        "T0AAD52029",
        "r1239",
        "r1231AA",
        "R1FFFFFFF",
        "t1001AAEA5F",
        "x",
        "S",
        "S9",
        "S66",
        "Z",
        "Z2",
        "OO",
        "o",
        "s031C",
        "d1000",
        "T0AAD520280000000100000000T0AAD5202800000001000000000",
    ] {
        assert_eq!(say(&mut open(), &format!("{text}/")), ("!".into(), vec![]), "{text}");
    }
}

#[test]
fn python_can_opens_asks_and_closes() {
    let mut adapter = Adapter::default();
    let drive = "T0AAD520280000000100000000/";
    assert_eq!(say(&mut adapter, "C/S6//O/O/"), ("/////".into(), vec![]));
    assert_eq!(adapter.bitrate(), 500_000);
    assert_eq!(
        say(&mut adapter, &format!("V/N/F/{drive}")),
        ("V1010/NNARX/F00//".into(), vec![extended(0x0AAD_5202, &[0, 0, 0, 1, 0, 0, 0, 0])])
    );
    assert_eq!(say(&mut adapter, "S8/"), ("!".into(), vec![]), "the bitrate of an open channel");
    assert_eq!(adapter.bitrate(), 500_000);
    assert_eq!(say(&mut adapter, &format!("C/{drive}F/")), ("/!!".into(), vec![]));
    assert_eq!(
        say(&mut adapter, &format!("S8/L/{drive}")),
        ("//!".into(), vec![]),
        "who listens only does not send"
    );
    assert_eq!(adapter.bitrate(), 1_000_000);
}

#[test]
fn a_host_receives_the_bus_while_the_channel_is_open() {
    let frame = standard(0x100, &[0xAA]);
    let mut adapter = Adapter::default();
    assert_eq!(adapter.handle_frame(&frame, 1), None);
    say(&mut adapter, "O/");
    assert_eq!(adapter.handle_frame(&frame, 1).unwrap(), b"t1001AA\r");
    assert_eq!(say(&mut adapter, "Z1/").0, "!", "time stamps of an open channel");
    say(&mut adapter, "C/Z1/L/");
    assert_eq!(
        adapter.handle_frame(&frame, 60_001).unwrap(),
        b"t1001AA0001\r",
        "the time starts again every minute"
    );
}

#[test]
fn a_lost_frame_shows_in_the_flags_once() {
    let mut adapter = open();
    adapter.note_lost();
    assert_eq!(say(&mut adapter, "F/F/").0, "F08/F00/");
}

#[test]
fn a_line_that_never_ends_is_one_refusal_and_the_next_is_read() {
    let (replies, _) = say(&mut open(), &format!("{}/V/", "t".repeat(10_000)));
    assert_eq!(replies, "!V1010/");
}

fn frames() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![
        (0..1u16 << 11).prop_map(|raw| Id::standard(raw).unwrap()),
        (0..1u32 << 29).prop_map(|raw| Id::extended(raw).unwrap()),
    ];
    prop_oneof![
        (id.clone(), proptest::collection::vec(any::<u8>(), 0..=8))
            .prop_map(|(id, data)| Frame::data(id, &data).unwrap()),
        (id, 0..=8u8).prop_map(|(id, dlc)| Frame::remote(id, dlc).unwrap()),
    ]
}

proptest! {
    #[test]
    fn any_frame_comes_back(frame in frames(), time in proptest::option::of(any::<u16>())) {
        let line = encode_frame(&frame, time);
        let mut lines = Lines::default();
        let read: Vec<_> = line.iter().filter_map(|byte| lines.push(*byte)).collect();
        prop_assert_eq!(read.len(), 1);
        let text = read[0].as_deref().unwrap();
        prop_assert_eq!(decode_frame(text), Some((frame, time)));
    }

    #[test]
    fn any_command_comes_back(frame in frames(), index in 0..=8u8, on: bool) {
        for command in [
            Command::Nothing, Command::Bitrate(index), Command::Open, Command::ListenOnly, Command::Close, Command::Send(frame),
            Command::Flags, Command::Version, Command::SerialNumber, Command::Timestamps(on),
        ] {
            let line = command.encode();
            let (end, text) = line.split_last().unwrap();
            prop_assert_eq!(*end, b'\r');
            prop_assert_eq!(Command::decode(text), Some(command));
        }
    }

    #[test]
    fn any_bytes_are_answered_line_by_line(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let mut adapter = open();
        let answers = bytes.iter().filter_map(|byte| adapter.handle_byte(*byte)).count();
        prop_assert_eq!(answers, bytes.iter().filter(|byte| **byte == b'\r').count());
    }

    #[test]
    fn what_is_read_as_a_frame_would_be_written_like_it(text in "[tTrR][0-9A-F]{3,14}") {
        if let Some((frame, time)) = decode_frame(text.as_bytes()) {
            let line = format!("{text}\r");
            prop_assert_eq!(encode_frame(&frame, time), line.as_bytes());
        }
    }
}
