//! Tests of programming on the wire: every message as bytes, in both directions (PROTOCOL.md, sections 2 and
//! 11).

use crate::bench::frame;
use narx_core::bus::narmotion::update::{
    ImageVersion, UpdateAnswer, UpdateCode, UpdateRequest, UpdateState, UpdateStatus,
};
use narx_core::bus::narmotion::{Addresses, DecodeError, FromDrive, NAMES, ToDrive};

const REQUESTS: [(UpdateRequest, u32, u64); 8] = [
    (UpdateRequest::Device, 0x0AAD_54A0, 0),
    (UpdateRequest::Version, 0x0AAD_54A1, 0),
    (UpdateRequest::Begin { length: 0x9E40, hardware: 0x4E58_0002 }, 0x0AAD_52A2, 0x0000_9E40_4E58_0002),
    (UpdateRequest::Data { block: 0x0102, data: [3, 4, 5, 6, 7, 8] }, 0x0AAD_52A3, 0x0102_0304_0506_0708),
    (UpdateRequest::Status, 0x0AAD_54A4, 0),
    // The check value of CRC-32: that of "123456789".
    (UpdateRequest::End { crc: 0xCBF4_3926 }, 0x0AAD_52A5, 0xCBF4_3926_0000_0000),
    (UpdateRequest::Abort, 0x0AAD_52A6, 0),
    (UpdateRequest::Confirm, 0x0AAD_52A7, 0),
];

const fn status(state: UpdateState, code: UpdateCode, window: u16, offset: u32) -> UpdateAnswer {
    UpdateAnswer::Status(UpdateStatus { state, code, window, offset })
}

const ANSWERS: [(UpdateAnswer, u32, u64); 5] = [
    (UpdateAnswer::Device { hardware: 0x4E58_0002, room: 0xB800 }, 0x1552_A8A0, 0x4E58_0002_0000_B800),
    (
        UpdateAnswer::Version(ImageVersion { major: 1, minor: 4, patch: 0x203, build: 231 }),
        0x1552_A8A1,
        0x0104_0203_00E7_0000,
    ),
    (status(UpdateState::Receiving, UpdateCode::Sequence, 32, 0x1_0002), 0x1552_A8A4, 0x0206_0020_0001_0002),
    (status(UpdateState::Idle, UpdateCode::Reverted, 0, 0), 0x1552_A8A4, 0x000E_0000_0000_0000),
    (status(UpdateState::Trial, UpdateCode::Done, 0, 0), 0x1552_A8A4, 0x0500_0000_0000_0000),
];

#[test]
fn programming_both_ways() {
    for (request, id, bytes) in REQUESTS {
        let (message, frame) = (ToDrive::Update(request), frame(id, bytes));
        assert_eq!(message.encode(Addresses::FACTORY), frame, "{request:?}");
        assert_eq!(ToDrive::decode(&frame).map(|(_, message)| message), Ok(message));
    }
    for (answer, id, bytes) in ANSWERS {
        let (message, frame) = (FromDrive::Update(answer), frame(id, bytes));
        assert_eq!(message.encode(Addresses::FACTORY), frame, "{answer:?}");
        assert_eq!(FromDrive::decode(&frame).map(|(_, message)| message), Ok(message));
    }
}

/// Opcodes of the other type or of none, and values without a meaning, are no messages of programming.
#[test]
fn programming_that_is_none() {
    for id in [0x0AAD_52A0, 0x0AAD_52A1, 0x0AAD_54A2, 0x0AAD_54A3, 0x0AAD_52A4, 0x0AAD_54A7, 0x0AAD_52A8] {
        assert_eq!(ToDrive::decode(&frame(id, 0)), Err(DecodeError::Opcode), "{id:08X}");
    }
    for id in [0x1552_A8A2, 0x1552_A8A3, 0x1552_A8A5, 0x1552_A8A8] {
        assert_eq!(FromDrive::decode(&frame(id, 0)), Err(DecodeError::Opcode), "{id:08X}");
    }
    for bytes in [0x0600_0000_0000_0000, 0x000F_0000_0000_0000, 0xFF00_0000_0000_0000] {
        assert_eq!(FromDrive::decode(&frame(0x1552_A8A4, bytes)), Err(DecodeError::Value), "{bytes:016X}");
    }
}

/// The table of names and the enumerations have the same numbers: a name has the value that a decoder reads.
#[test]
fn states_and_codes_have_their_names() {
    let names = |of| NAMES.iter().find(|names| names.of == of).unwrap().values;
    for (state, name) in names("update state") {
        let frame = frame(0x1552_A8A4, u64::from(*state) << 56);
        let Ok((_, FromDrive::Update(UpdateAnswer::Status(status)))) = FromDrive::decode(&frame) else {
            panic!("{name}")
        };
        assert_eq!(format!("{:?}", status.state), *name);
    }
    let codes = names("update code");
    assert_eq!(codes.len(), 15);
    for (code, name) in codes {
        let frame = frame(0x1552_A8A4, u64::from(*code) << 48);
        let Ok((_, FromDrive::Update(UpdateAnswer::Status(status)))) = FromDrive::decode(&frame) else {
            panic!("{name}")
        };
        let said = format!("{:?}", status.code).to_lowercase();
        let name = name.replace("On trial", "Trial").replace(' ', "").to_lowercase();
        assert_eq!(said, name);
    }
}
