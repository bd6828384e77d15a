//! Tests of identifiers and frames: the published ones in both directions, and those that must be refused.

use embedded_can::Frame as _;
use narx_core::bus::narmotion::{
    Addresses, ControlMode, DecodeError, DigitalOutputs, FromDrive, Measurement, MessageId, MessageKind,
    MotorMode, Opcode, ParameterStatus, Priority, RequestWord, SIGNALS, StatusWord, ToDrive, XmlCommand,
};
use narx_core::bus::{Frame, Id};
use narx_core::motor::guard::fault::FaultWord;
use proptest::prelude::*;

/// Identifiers of Figure 14: published number, priority, source, destination, type, opcode.
const PRINTED: [(u32, u8, u8, u8, u8, u16); 32] = [
    (0x1552_A800, 2, 0xAA, 0x55, 0, 0),
    (0x0AAD_5400, 1, 0x55, 0xAA, 2, 0),
    (0x1552_A801, 2, 0xAA, 0x55, 0, 1),
    (0x0AAD_5401, 1, 0x55, 0xAA, 2, 1),
    (0x0AAD_5202, 1, 0x55, 0xAA, 1, 2),
    (0x1552_A803, 2, 0xAA, 0x55, 0, 3),
    (0x1552_A804, 2, 0xAA, 0x55, 0, 4),
    (0x1552_A805, 2, 0xAA, 0x55, 0, 5),
    (0x1552_A865, 2, 0xAA, 0x55, 0, 101),
    (0x1552_A866, 2, 0xAA, 0x55, 0, 102),
    (0x0AAD_5266, 1, 0x55, 0xAA, 1, 102),
    (0x0AAD_5267, 1, 0x55, 0xAA, 1, 103),
    (0x0AAD_5268, 1, 0x55, 0xAA, 1, 104),
    (0x1552_A86E, 2, 0xAA, 0x55, 0, 110),
    (0x0AAD_526E, 1, 0x55, 0xAA, 1, 110),
    (0x0AAD_546E, 1, 0x55, 0xAA, 2, 110),
    (0x1552_A870, 2, 0xAA, 0x55, 0, 112),
    (0x0AAD_5270, 1, 0x55, 0xAA, 1, 112),
    (0x0AAD_5470, 1, 0x55, 0xAA, 2, 112),
    (0x0AAD_5271, 1, 0x55, 0xAA, 1, 113),
    (0x0AAD_5482, 1, 0x55, 0xAA, 2, 130),
    (0x1552_A882, 2, 0xAA, 0x55, 0, 130),
    (0x1552_A883, 2, 0xAA, 0x55, 0, 131),
    (0x1552_A88C, 2, 0xAA, 0x55, 0, 140),
    (0x1552_A8C8, 2, 0xAA, 0x55, 0, 200),
    (0x1552_A8C9, 2, 0xAA, 0x55, 0, 201),
    (0x1552_A8CA, 2, 0xAA, 0x55, 0, 202),
    (0x1552_A8CB, 2, 0xAA, 0x55, 0, 203),
    (0x1552_A8CC, 2, 0xAA, 0x55, 0, 204),
    (0x1552_A8CD, 2, 0xAA, 0x55, 0, 205),
    (0x1552_A8CF, 2, 0xAA, 0x55, 0, 207),
    (0x1552_A8D0, 2, 0xAA, 0x55, 0, 208),
];

/// A frame of every row that a master sends: message, identifier, bytes.
const TO_DRIVE: [(ToDrive, u32, u64); 17] = [
    (ToDrive::RequestBuildInfo, 0x0AAD_5400, 0),
    (ToDrive::RequestDeviceInfo, 0x0AAD_5401, 0),
    (ToDrive::RequestWord(RequestWord { mode: MotorMode::Drive }), 0x0AAD_5202, 0x0000_0001_0000_0000),
    (ToDrive::RequestWord(RequestWord { mode: MotorMode::Fault }), 0x0AAD_5202, 0x0000_0003_0000_0000),
    (ToDrive::RequestWord(RequestWord { mode: MotorMode::Reverse }), 0x0AAD_5202, 0x0000_0002_0000_0000),
    // Figure 14 has only the answer; the request is type 1 of the same opcode.
    (ToDrive::Reboot, 0x0AAD_5265, 0),
    (ToDrive::MotorCommand { speed: 4000 }, 0x0AAD_5266, 0x0FA0_0000_0000_0000),
    (
        ToDrive::DigitalOutputs(DigitalOutputs {
            enable1: true,
            value1: false,
            enable2: false,
            value2: true,
        }),
        0x0AAD_5267,
        0x0001_0000_0000_0001,
    ),
    (ToDrive::DisableHallSupply(true), 0x0AAD_5268, 0x0001_0000_0000_0000),
    (ToDrive::SetParameter { number: 114, value: 250 }, 0x0AAD_526E, 0x0072_0000_00FA_0000),
    (ToDrive::SetParameter { number: 80, value: -2 }, 0x0AAD_526E, 0x0050_FFFF_FFFE_0000),
    (ToDrive::RequestParameter { number: 261 }, 0x0AAD_546E, 0x0105_0000_0000_0000),
    (ToDrive::TriggerScope, 0x0AAD_5270, 0),
    (ToDrive::DownloadScope, 0x0AAD_5470, 0),
    (ToDrive::RestoreFactory { serial: 0x1234 }, 0x0AAD_5271, 0x1234_0000_0000_0000),
    (ToDrive::DownloadXml(XmlCommand::Length), 0x0AAD_5482, 0),
    (ToDrive::DownloadXml(XmlCommand::Start), 0x0AAD_5482, 0x0001_0000_0000_0000),
];

/// A frame of every row that a drive sends.
fn from_drive() -> Vec<(FromDrive, u32, u64)> {
    use FromDrive as F;
    let faults = FaultWord::OVER_VOLTAGE | FaultWord::STORE_VERSION;
    let status = StatusWord { mode: MotorMode::Reverse, control: ControlMode::Hall, ..StatusWord::default() };
    let log = StatusWord {
        logging: 11,
        memory_full: true,
        memory_erased: true,
        read_enable: true,
        erase_enable: true,
        ..StatusWord::default()
    };
    let m = F::Measurement;
    vec![
        (F::BuildInfo { number: 7, modified: true, date: 20_261_120 }, 0x1552_A800, 0x0007_0001_0135_2900),
        (
            F::DeviceInfo { hardware: 3, software: 0x0102, device_number: 9, address: 170 },
            0x1552_A801,
            0x0003_0102_0009_00AA,
        ),
        (F::Status(status), 0x1552_A803, 0x0000_0302_0000_0000),
        (F::Status(log), 0x1552_A803, 0x01EB_0000_0000_0000),
        (F::Faults(faults), 0x1552_A804, 0x8000_0004_0000_0000),
        (F::CriticalFault { faults, code: 0x0201 }, 0x1552_A805, 0x8000_0004_0201_0000),
        (F::Reboot, 0x1552_A865, 0x0001_0000_0000_0000),
        (F::MotorCommand { speed: 500 }, 0x1552_A866, 0x01F4_0000_0000_0000),
        (
            F::Parameter { number: 114, value: 250, status: ParameterStatus::OutOfRange },
            0x1552_A86E,
            0x0072_0000_00FA_0003,
        ),
        (F::ScopeData { address: 3, data: [1, 2, 0xFFFF] }, 0x1552_A870, 0x0003_0001_0002_FFFF),
        (F::XmlLength { words: 4321, check: 0xCBF4_3926 }, 0x1552_A882, 0x10E1_0000_CBF4_3926),
        (F::XmlData { address: 0, data: [0x3C3F, 0x786D, 0x6C20] }, 0x1552_A883, 0x0000_3C3F_786D_6C20),
        (F::LogData { counter: 6, data: [1, 2, 3] }, 0x1552_A88C, 0x0006_0001_0002_0003),
        (m(Measurement::M0 { accel: [-1000, 2, 3], dsi1: true }), 0x1552_A8C8, 0xFC18_0002_0003_0001),
        (
            m(Measurement::M1 { speed_sensorless: -4000, position: -2, power: 1500 }),
            0x1552_A8C9,
            0xF060_FFFF_FFFE_05DC,
        ),
        (
            m(Measurement::M2 { bus_voltage: 4800, bus_current: -7, rail_6v: 6000, rail_14v: 14_000 }),
            0x1552_A8CA,
            0x12C0_FFF9_1770_36B0,
        ),
        (
            m(Measurement::M3 { temperature: 1850, accel_reference: 1800, reference: 383, asi: -1 }),
            0x1552_A8CB,
            0x073A_0708_017F_FFFF,
        ),
        (m(Measurement::M4 { phase_voltage: [1, -1, 2], pressure: 55 }), 0x1552_A8CC, 0x0001_FFFF_0002_0037),
        (m(Measurement::M5 { speed_hall: 4000, dsi2: false }), 0x1552_A8CD, 0x0FA0_0000_0000_0000),
        (m(Measurement::M7([1, 2, 3, 4])), 0x1552_A8CF, 0x0001_0002_0003_0004),
        (m(Measurement::M8([0; 4])), 0x1552_A8D0, 0),
    ]
}

fn frame(id: u32, bytes: u64) -> Frame {
    Frame::full(Id::extended(id).unwrap(), bytes.to_be_bytes())
}

#[test]
fn printed_identifiers_both_ways() {
    for (printed, priority, source, destination, kind, opcode) in PRINTED {
        let id = Id::extended(printed).unwrap();
        let decoded = MessageId::decode(id).unwrap();
        let fields = (decoded.priority as u8, decoded.source, decoded.destination, decoded.kind as u8);
        assert_eq!(fields, (priority, source, destination, kind), "{printed:08X}");
        assert_eq!(decoded.opcode.raw(), opcode, "{printed:08X}");
        assert_eq!(decoded.encode(), id);
        let composed = if kind == 0 {
            Addresses::FACTORY.from_drive(decoded.opcode)
        } else {
            Addresses::FACTORY.to_drive(decoded.kind, decoded.opcode)
        };
        assert_eq!(composed.encode(), id, "{printed:08X}");
    }
}

#[test]
fn rows_of_the_master_both_ways() {
    for (message, id, bytes) in TO_DRIVE {
        let frame = frame(id, bytes);
        assert_eq!(message.encode(Addresses::FACTORY), frame, "{message:?}");
        assert_eq!(ToDrive::decode(&frame).map(|(_, message)| message), Ok(message));
        assert_eq!(FromDrive::decode(&frame), Err(DecodeError::Kind));
    }
}

#[test]
fn rows_of_the_drive_both_ways() {
    for (message, id, bytes) in from_drive() {
        let frame = frame(id, bytes);
        assert_eq!(message.encode(Addresses::FACTORY), frame, "{message:?}");
        assert_eq!(FromDrive::decode(&frame).map(|(_, message)| message), Ok(message));
        assert_eq!(ToDrive::decode(&frame), Err(DecodeError::Kind));
    }
}

#[test]
fn every_printed_identifier_has_a_vector() {
    let vectors: Vec<u32> =
        TO_DRIVE.iter().map(|(_, id, _)| *id).chain(from_drive().into_iter().map(|(_, id, _)| id)).collect();
    for (printed, ..) in PRINTED {
        assert!(vectors.contains(&printed), "{printed:08X}");
    }
}

#[test]
fn priority_is_ignored_when_decoding() {
    for priority in 0..4 {
        let id = 0x0AAD_5266 & 0x07FF_FFFF | priority << 27;
        let (decoded, message) = ToDrive::decode(&frame(id, 0x0FA0_0000_0000_0000)).unwrap();
        assert_eq!(decoded.priority as u32, priority);
        assert_eq!(message, ToDrive::MotorCommand { speed: 4000 });
    }
    assert_eq!(Priority::High as u8, 1);
}

#[test]
fn refused_frames() {
    let id = Id::extended(0x0AAD_5202).unwrap();
    let cases = [
        (Frame::full(Id::standard(0x202).unwrap(), [0; 8]), DecodeError::StandardId),
        (Frame::remote(id, 8).unwrap(), DecodeError::Remote),
        (Frame::data(id, &[0; 7]).unwrap(), DecodeError::Length),
        (Frame::data(id, &[]).unwrap(), DecodeError::Length),
        (frame(0x0AAD_5202 | 3 << 9, 0), DecodeError::Kind),
        (frame(0x0AAD_5002, 0), DecodeError::Kind),
        (frame(0x0AAD_5203, 0), DecodeError::Opcode),
        (frame(0x0AAD_5402, 0), DecodeError::Opcode),
        (frame(0x0AAD_5200 | 511, 0), DecodeError::Opcode),
        (frame(0x0AAD_5202, 0x0000_0004_0000_0000), DecodeError::Value),
        (frame(0x0AAD_5202, 0x0000_000F_0000_0000), DecodeError::Value),
        (frame(0x0AAD_5268, 0x0002_0000_0000_0000), DecodeError::Value),
        (frame(0x0AAD_5482, 0x0002_0000_0000_0000), DecodeError::Value),
    ];
    for (frame, error) in cases {
        assert_eq!(ToDrive::decode(&frame), Err(error), "{frame:?}");
    }
    let unknown = [0x1552_A8CE, 0x1552_A802, 0x1552_A8D1];
    for id in unknown {
        assert_eq!(FromDrive::decode(&frame(id, 0)), Err(DecodeError::Opcode), "{id:08X}");
    }
    for word in [0, 2] {
        assert_eq!(
            FromDrive::decode(&frame(0x1552_A865, word << 48)),
            Err(DecodeError::Value),
            "REBOOT {word}"
        );
    }
    assert_eq!(FromDrive::decode(&frame(0x1552_A803, 4 << 32)), Err(DecodeError::Value));
    assert_eq!(FromDrive::decode(&frame(0x1552_A803, 0x400 << 32)), Err(DecodeError::Value));
}

/// Word 3 of an answer has every status, and the status word every mode.
#[test]
fn every_status_and_every_mode() {
    for status in 0..8_u64 {
        let decoded = FromDrive::decode(&frame(0x1552_A86E, 0x0072_0000_00FA_0000 | status));
        let found = decoded.map(|(_, message)| match message {
            FromDrive::Parameter { number: 114, value: 250, status } => status as u64,
            other => panic!("{other:?}"),
        });
        assert_eq!(found, if status < 7 { Ok(status) } else { Err(DecodeError::Value) });
    }
    for (mode, control) in (0..16_u64).flat_map(|mode| (0..16_u64).map(move |control| (mode, control))) {
        let found = FromDrive::decode(&frame(0x1552_A803, (control << 8 | mode) << 32));
        let found = found.map(|(_, message)| match message {
            FromDrive::Status(word) => (word.mode as u64, word.control as u64),
            other => panic!("{other:?}"),
        });
        assert_eq!(
            found,
            if mode < 4 && control < 4 { Ok((mode, control)) } else { Err(DecodeError::Value) }
        );
    }
}

#[test]
fn only_the_motor_mode_of_a_request_counts() {
    for mode in 0..16_u64 {
        let bits = 0xFFFF_FFF0 | mode;
        let decoded = ToDrive::decode(&frame(0x0AAD_5202, bits << 32)).map(|(_, message)| message);
        let expected = [MotorMode::Standby, MotorMode::Drive, MotorMode::Reverse, MotorMode::Fault]
            .get(usize::try_from(mode).unwrap())
            .map(|mode| ToDrive::RequestWord(RequestWord { mode: *mode }));
        assert_eq!(decoded, expected.ok_or(DecodeError::Value));
    }
}

#[test]
fn signals_cover_each_measurement_word_once() {
    let mut words = Vec::new();
    for signal in SIGNALS {
        assert_eq!(signal.words == 2, signal.name == "Mechanical position");
        for word in signal.word..signal.word + signal.words {
            words.push((signal.opcode.raw(), word));
        }
    }
    let all = (200..=205).flat_map(|opcode| (0..4).map(move |word| (opcode, word)));
    assert_eq!(words, all.take(22).collect::<Vec<_>>());
}

#[test]
fn invalid_identifiers_and_frames_cannot_be_made() {
    assert_eq!(Id::standard(0x800), None);
    assert_eq!(Id::extended(0x2000_0000), None);
    let id = Id::standard(1).unwrap();
    assert_eq!(Frame::data(id, &[0; 9]), None);
    assert_eq!(Frame::remote(id, 9), None);
    assert!(Id::standard(0x100).unwrap() < Id::extended(0x100 << 18).unwrap());
    assert!(Id::extended(5).unwrap() < Id::extended(6).unwrap());
    assert_eq!(Opcode::new(512), None);
    for raw in [0, 200, 511, 512, u16::MAX] {
        let bytes = postcard::to_stdvec(&raw).unwrap();
        assert_eq!(postcard::from_bytes(&bytes).ok(), Opcode::new(raw), "{raw}");
        assert!(Opcode::new(raw).is_none_or(|opcode| postcard::to_stdvec(&opcode).unwrap() == bytes));
    }
    let bytes = postcard::to_stdvec(&(0x2000_0000_u32 | 1 << 31, false, 8_u8, [0_u8; 8])).unwrap();
    assert!(postcard::from_bytes::<Frame>(&bytes).is_err());
    let bytes = postcard::to_stdvec(&(1_u32, false, 9_u8, [0_u8; 8])).unwrap();
    assert!(postcard::from_bytes::<Frame>(&bytes).is_err());
}

proptest! {
    #[test]
    fn identifiers_survive(raw in 0..=0x1FFF_FFFF_u32) {
        let id = Id::extended(raw).unwrap();
        match MessageId::decode(id) {
            Ok(decoded) => prop_assert_eq!(decoded.encode(), id),
            Err(error) => prop_assert!(error == DecodeError::Kind && raw >> 9 & 3 == 3),
        }
    }

    /// A message that is decoded is encoded to a frame with the same meaning.
    #[test]
    fn messages_survive(opcode in prop_oneof![0..6_u32, 100..145_u32, 159..170_u32, 199..210_u32], kind in 0..3_u32, data: [u8; 8]) {
        let (source, destination) = if kind == 0 { (0xAA, 0x55) } else { (0x55, 0xAA) };
        let raw = 1 << 27 | source << 19 | destination << 11 | kind << 9 | opcode;
        let frame = Frame::full(Id::extended(raw).unwrap(), data);
        if let Ok((id, message)) = ToDrive::decode(&frame) {
            prop_assert!(id.kind != MessageKind::SlaveTx);
            let again = ToDrive::decode(&message.encode(Addresses::FACTORY)).unwrap().1;
            prop_assert_eq!(again, message);
        }
        if let Ok((_, message)) = FromDrive::decode(&frame) {
            let again = FromDrive::decode(&message.encode(Addresses::FACTORY)).unwrap().1;
            prop_assert_eq!(again, message);
        }
    }

    #[test]
    fn frames_survive_embedded_can_and_serde(raw: u32, extended: bool, remote: bool, data in prop::collection::vec(any::<u8>(), 0..=8)) {
        let id = if extended { Id::extended(raw & 0x1FFF_FFFF) } else { Id::standard((raw & 0x7FF) as u16) }.unwrap();
        let frame = if remote { Frame::remote(id, data.len() as u8) } else { Frame::data(id, &data) }.unwrap();
        let other = if frame.is_remote_frame() {
            <Frame as embedded_can::Frame>::new_remote(embedded_can::Frame::id(&frame), usize::from(frame.dlc()))
        } else {
            <Frame as embedded_can::Frame>::new(embedded_can::Frame::id(&frame), embedded_can::Frame::data(&frame))
        };
        prop_assert_eq!(other, Some(frame));
        prop_assert_eq!(usize::from(frame.dlc()), data.len());
        let bytes = postcard::to_stdvec(&frame).unwrap();
        prop_assert_eq!(postcard::from_bytes::<Frame>(&bytes), Ok(frame));
    }
}
