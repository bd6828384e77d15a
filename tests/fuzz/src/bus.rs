//! Target: frames. Every frame that a decoder accepts is encoded to itself again, in both protocols and in
//! every text form.

use crate::program::Program;
use narx_core::bus::candump::{self, Content};
use narx_core::bus::eddycan::{CobId, FromNode, Layout, SdoAction, SdoOutcome, ToNode};
use narx_core::bus::narmotion::{
    Addresses, DecodeError, FromDrive, Message, MessageId, MessageKind, Priority, ToDrive, Words,
};
use narx_core::bus::slcan;
use narx_core::bus::{Frame, eddycan};

/// Runs an input: any frames.
pub fn run(data: &[u8]) {
    let mut program = Program(data);
    while !program.is_over() {
        let frame = program.frame();
        texts(&frame, program.0.len());
        narmotion(&frame);
        eddycan(&frame);
    }
}

/// Checks that slcan, candump and the serialised form give the frame back.
fn texts(frame: &Frame, number: usize) {
    let stamp = (number % 2 == 1).then_some(number as u16);
    let line = slcan::encode_frame(frame, stamp);
    let (text, end) = line.split_at(line.len() - 1);
    assert_eq!((slcan::decode_frame(text), end), (Some((*frame, stamp)), &b"\r"[..]));

    let time = number as u64 * 1_000;
    let line = candump::line(time, "can0", frame).to_string();
    let read = candump::Line::parse(line.as_bytes()).expect("our own line").expect("not an empty one");
    assert_eq!((read.content, read.channel, read.received), (Content::Frame(*frame), "can0", true));
    assert_eq!(read.time, number as f64 / 1e6);

    let bytes = postcard::to_stdvec(frame).expect("it has room");
    assert_eq!(postcard::from_bytes(&bytes), Ok(*frame));
}

fn narmotion(frame: &Frame) {
    let id = MessageId::of(frame);
    match id {
        Ok(id) => assert_eq!(id.encode(), frame.id()),
        Err(error) => assert!(matches!(error, DecodeError::StandardId | DecodeError::Kind)),
    }
    let (to_drive, from_drive) = (ToDrive::decode(frame), FromDrive::decode(frame));
    let shaped = id.is_ok() && frame.full_payload().is_some();
    let malformed = |error: DecodeError| error.is_malformed();
    match (&to_drive, &from_drive) {
        (Err(to), Err(from)) => assert!(shaped || (malformed(*to) && malformed(*from))),
        (Ok(_), Ok(_)) => panic!("a message in both directions"),
        _ => assert!(shaped),
    }
    if let Ok((id, message)) = to_drive {
        assert_ne!(id.kind, MessageKind::SlaveTx);
        let addresses = Addresses { drive: id.destination, master: id.source };
        let again = message.encode(addresses);
        assert_eq!(ToDrive::decode(&again), Ok((MessageId { priority: Priority::High, ..id }, message)));
        by_table(id, frame, &again);
    }
    if let Ok((id, message)) = from_drive {
        assert_eq!((id.kind, id.opcode), (MessageKind::SlaveTx, message.opcode()));
        let addresses = Addresses { drive: id.source, master: id.destination };
        let again = message.encode(addresses);
        assert_eq!(FromDrive::decode(&again), Ok((MessageId { priority: Priority::Low, ..id }, message)));
        by_table(id, frame, &again);
    }
}

/// Checks that the codec writes what the table of messages gives for the frame's fields: both agree about the
/// message, and nothing besides its fields is kept.
fn by_table(id: MessageId, frame: &Frame, again: &Frame) {
    let message = Message::of(id).expect("what has a decoder stands in the table");
    let (_, words) = Words::of(frame).expect("it was decoded");
    let mut canonical = Words::default();
    for field in message.fields() {
        field.put(field.raw(words), &mut canonical).expect("as many bits as were read");
    }
    // Reserved measurements have no known fields; all of their content is kept.
    if message.fields().next().is_none() && message.kind == MessageKind::SlaveTx {
        canonical = words;
    }
    let (_, encoded) = Words::of(again).expect("our own frame");
    assert_eq!(encoded, canonical, "{}", message.name);
}

fn eddycan(frame: &Frame) {
    if let Ok(id) = CobId::decode(frame.id()) {
        assert_eq!(id.encode(), frame.id());
    }
    let to_node = ToNode::decode(frame);
    if let Ok(message) = to_node {
        let again = message.encode();
        assert_eq!(ToNode::decode(&again), Ok(message));
        // Data that a request does not use are sent as zeros.
        let bare = |message| {
            let ToNode::Sdo { request, .. } = message else { return false };
            matches!(request.action, SdoAction::Read | SdoAction::Unknown { .. })
        };
        assert!(again == *frame || bare(message), "{frame:?} {again:?}");
    }
    for layout in Layout::ALL {
        let Ok((node, message)) = FromNode::decode(frame, layout) else { continue };
        assert!(to_node.is_err(), "a message in both directions");
        let again = message.encode(node, layout);
        assert_eq!(FromNode::decode(&again, layout), Ok((node, message)));
        // Errors of other nodes are longer, and their answers have unused bytes, or another command for the
        // same value.
        let bare = match message {
            FromNode::Error { .. } => frame.dlc() > 2,
            FromNode::Sdo(eddycan::SdoAnswer { outcome, .. }) => {
                !matches!(outcome, SdoOutcome::Aborted { .. })
            }
            _ => false,
        };
        assert!(again == *frame || bare, "{frame:?} {again:?}");
    }
}
