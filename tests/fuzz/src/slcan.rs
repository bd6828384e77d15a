//! Target: the slcan adapter, with any bytes of a host, and frames of the bus between them.

use narx_core::bus::slcan::{Adapter, Channel, Command, LINE_MAX, NO, YES, decode_frame, encode_frame};
use narx_core::bus::{Frame, Id};

/// Runs an input: bytes of a host.
pub fn run(data: &[u8]) {
    let mut adapter = Adapter::default();
    let mut line = Vec::new();
    for byte in data {
        let before = adapter.settings();
        let answer = adapter.handle_byte(*byte);
        assert_eq!(answer.is_some(), *byte == YES, "one answer to each line");
        let Some(answer) = answer else {
            line.push(*byte);
            continue;
        };
        let command = (line.len() <= LINE_MAX).then(|| Command::decode(&line)).flatten();
        match (command, answer.reply.last()) {
            (_, Some(&YES)) => assert!(command.is_some(), "{line:?}"),
            (_, Some(&NO)) => assert_eq!((answer.reply.len(), adapter.settings()), (1, before)),
            other => panic!("{other:?}"),
        }
        if let Some(command) = command {
            // A command that is understood has one text form.
            let text = command.encode();
            assert_eq!(Command::decode(&text[..text.len() - 1]), Some(command));
            assert!(text[..text.len() - 1].eq_ignore_ascii_case(&line));
        }
        let sends = match command {
            Some(Command::Send(frame)) if before.channel == Channel::Open => Some(frame),
            _ => None,
        };
        assert_eq!(answer.frame, sends);
        // In the other direction, with a time stamp if the host has requested one.
        let frame = sends.unwrap_or(Frame::full(Id::standard(0x123).expect("eleven bits"), [0xA5; 8]));
        let received = adapter.handle_frame(&frame, line.len() as u64 * 7_919);
        assert_eq!(received.is_some(), adapter.settings().channel != Channel::Closed);
        if let Some(text) = received {
            let (read, stamp) = decode_frame(&text[..text.len() - 1]).expect("our own line");
            assert_eq!((read, stamp.is_some()), (frame, adapter.settings().timestamps));
            assert_eq!(text, encode_frame(&frame, stamp));
        }
        line.clear();
    }
}
