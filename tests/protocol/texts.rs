//! Tests of the texts that a bus monitor or a master prints of frames and answers.

use narx_core::bus::frame::InvalidFrame;
use narx_core::bus::narmotion::update::{ImageVersion, UpdateCode};
use narx_core::bus::narmotion::{DecodeError, ParameterStatus};
use std::collections::HashSet;

#[test]
fn a_frame_that_is_no_message_is_told_why() {
    for (error, text, is_malformed) in [
        (DecodeError::StandardId, "an 11-bit identifier", true),
        (DecodeError::Remote, "a remote frame", true),
        (DecodeError::Length, "not 8 data bytes", true),
        (DecodeError::Kind, "a message type that does not exist in this direction", true),
        (DecodeError::Opcode, "an opcode that does not exist in this direction", false),
        (DecodeError::Value, "a field with an undefined value", false),
    ] {
        assert_eq!((error.to_string().as_str(), error.is_malformed()), (text, is_malformed));
    }
    assert_eq!(InvalidFrame.to_string(), "not a CAN frame: identifier or length out of range");
}

#[test]
fn an_answer_to_a_parameter_is_told_in_words() {
    for (status, text) in [
        (ParameterStatus::Done, "done"),
        (ParameterStatus::UnknownNumber, "there is no such parameter"),
        (ParameterStatus::ReadOnly, "only the drive writes it"),
        (ParameterStatus::OutOfRange, "out of range"),
        (ParameterStatus::WrongState, "not in this state of the drive"),
        (ParameterStatus::Storage, "the parameter store or log memory is missing, busy or failed"),
        (ParameterStatus::NotEquipped, "the board lacks what this value needs"),
    ] {
        assert_eq!(status.to_string(), text);
    }
}

/// Each code has words of its own, in whatever state it is reported.
#[test]
fn an_update_is_told_in_words() {
    use UpdateCode as C;
    let codes = [
        (C::Done, "done"),
        (C::WrongState, "the drive is not in Standby, nor in Fault at standstill"),
        (C::NotNow, "not in this state of the update"),
        (C::Trial, "the running image has not been confirmed"),
        (C::Hardware, "the image is for other hardware"),
        (C::Length, "the image does not have the announced length, or exceeds the slot"),
        (C::Sequence, "a part of the image is missing"),
        (C::Flash, "the flash failed"),
        (C::Checksum, "the data written differ from the data sent"),
        (C::NoImage, "the data sent are not an image"),
        (C::Older, "the image is older than the running one"),
        (C::TimedOut, "no data arrived for ten seconds"),
        (C::Aborted, "the update was aborted"),
        (C::Signature, "the board's bootloader does not accept the signature"),
        (C::Reverted, "the image was not confirmed, and does not run any more"),
    ];
    for (code, text) in codes {
        assert_eq!(code.to_string(), text);
    }
    assert_eq!(codes.map(|(code, _)| code as u8).into_iter().collect::<HashSet<_>>().len(), 15);
    assert_eq!(ImageVersion { major: 1, minor: 2, patch: 3, build: 4 }.to_string(), "1.2.3+4");
}
