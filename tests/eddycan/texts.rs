//! Test of the texts that a bus monitor prints of errors and answers.

use core::fmt::Display;
use narx_core::bus::eddycan::{AbortCode, DecodeError, ErrorCode, Target};

/// Each code of Tables 10 and 13 has its number and its meaning in its text.
#[test]
fn codes_are_told_with_their_numbers() {
    let cases: [(&dyn Display, &str); 10] = [
        (&ErrorCode::Generic, "1000h: generic error"),
        (&ErrorCode::Passive, "8120h: CAN controller error passive"),
        (&ErrorCode::Protocol, "8200h: protocol error"),
        (&AbortCode::CommandUnknown, "05040001h: command unknown"),
        (&AbortCode::IndexUnknown, "06020000h: index does not exist"),
        (&AbortCode::SubindexUnknown, "06090011h: subindex does not exist"),
        (&AbortCode::RangeExceeded, "06090030h: value out of range"),
        (&AbortCode::WriteOnly, "06010001h: entry cannot be read"),
        (&AbortCode::ReadOnly, "06010002h: entry cannot be written"),
        (&AbortCode::General, "08000000h: not in this state, or wrong size"),
    ];
    for (code, text) in cases {
        assert_eq!(code.to_string(), text);
    }
}

#[test]
fn a_frame_that_is_no_message_is_told_why() {
    for (error, text) in [
        (DecodeError::ExtendedId, "a 29-bit identifier"),
        (DecodeError::Identifier, "an identifier that does not exist in this direction"),
        (DecodeError::Remote, "a remote frame in place of data, or the reverse"),
        (DecodeError::Length, "the wrong number of data bytes"),
        (DecodeError::NmtCommand(Target::All), "an NMT command that does not exist"),
        (DecodeError::Value, "a field with an undefined value"),
    ] {
        assert_eq!(error.to_string(), text);
    }
}
