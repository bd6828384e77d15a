//! First inputs of every target, made of real data: frames, texts, files, and the steps of ordinary
//! operation. They are the files of the corpus whose name begins with `real-`; `UPDATE=1` writes them.

use narx_core::bus::eddycan::{
    FromNode, Layout, NmtCommand, NmtState, NodeId, PdoKind, Reading, SdoAction, SdoRequest, Target, ToNode,
};
use narx_core::bus::narmotion::{Addresses, Field, MESSAGES, MessageKind, MotorMode, ToDrive, Words};
use narx_core::bus::slcan;
use narx_core::bus::{Frame, candump};
use narx_core::description::Document;
use narx_core::dictionary::{Dictionary, number};
use narx_core::node::Identity;
use narx_core::storage::{Entry, Record};
use narx_fuzz::program::write_frame;
use std::path::Path;
use std::{env, fs};

/// Name of a target, description of the input, its bytes.
type Seed = (&'static str, &'static str, Vec<u8>);

/// Every message of the drive's protocol, with fields of 1 where possible.
fn narmotion() -> Vec<Frame> {
    let frame = |message: &narx_core::bus::narmotion::Message| {
        let mut words = Words::default();
        for field in message.fields() {
            let Field { bits, .. } = field;
            field.put(i64::from(bits > 1 || message.kind == MessageKind::SlaveTx), &mut words).unwrap();
        }
        words.frame(message.id(Addresses::FACTORY))
    };
    MESSAGES.iter().map(frame).collect()
}

/// Every message of a TX-Driver and to it.
fn eddycan() -> Vec<Frame> {
    let node = NodeId::FACTORY;
    let layout = Layout::ALL[1];
    let sdo = |action| ToNode::Sdo { node, request: SdoRequest { index: 0x2003, subindex: 0, action } };
    let to_node = [
        ToNode::Nmt { command: NmtCommand::Start, target: Target::All },
        ToNode::Sync,
        ToNode::RequestPdo { node, bytes: layout.length() },
        sdo(SdoAction::Read),
        sdo(SdoAction::Write { size: Some(2), data: [10, 0, 0, 0] }),
    ];
    let from_node = [
        FromNode::Heartbeat(NmtState::BootUp),
        FromNode::Pdo { kind: PdoKind::Timer, reading: Reading::default() },
        FromNode::Error { code: 0x8130 },
    ];
    let to_node = to_node.into_iter().map(ToNode::encode);
    to_node.chain(from_node.into_iter().map(|message| message.encode(node, layout))).collect()
}

fn program(frames: &[Frame]) -> Vec<u8> {
    let mut bytes = Vec::new();
    frames.iter().for_each(|frame| write_frame(frame, &mut bytes));
    bytes
}

/// Steps that give these frames to a node, each after the byte `kind`.
fn given(kind: u8, frames: &[Frame]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for frame in frames {
        bytes.push(kind);
        write_frame(frame, &mut bytes);
    }
    bytes
}

/// A step of `tests/fuzz/src/drive.rs` that writes a parameter.
fn write(number: u16, value: i32) -> Vec<u8> {
    let place = Dictionary::rows().position(|row| row.number == number).unwrap() as u16;
    [vec![3], place.to_le_bytes().to_vec(), value.to_le_bytes().to_vec()].concat()
}

/// Steps that write 0 and then 1: a command.
fn command(number: u16) -> Vec<u8> {
    [vec![4], number.to_le_bytes().to_vec()].concat()
}

/// Step that waits these many milliseconds and a half.
fn wait(milliseconds: u8) -> Vec<u8> {
    vec![6, (u32::from(milliseconds) * 10 / 16).min(255) as u8]
}

fn ask(mode: MotorMode) -> Vec<u8> {
    vec![2, mode as u8]
}

fn scope(request: ToDrive) -> Vec<u8> {
    given(0, &[request.encode(Addresses::FACTORY)])
}

fn drives() -> Vec<Seed> {
    let (standby, drive) = (ask(MotorMode::Standby), ask(MotorMode::Drive));
    let speed = vec![9, 0xE8, 3];
    // A shaft that turns, in one direction and in the other.
    let turning = |rate: u16| [vec![7, 7], rate.to_le_bytes().to_vec()].concat();
    let start =
        [vec![3], standby.clone(), wait(20), speed.clone(), drive.clone(), wait(10), turning(300)].concat();
    let stored = [
        vec![3],
        write(number::SPEED_RATE, 500),
        command(number::STORE),
        wait(20),
        command(number::STORE_ONCE),
        wait(200),
        given(0, &[ToDrive::Reboot.encode(Addresses::FACTORY)]),
        wait(5),
    ]
    .concat();
    let logged = [
        vec![3],
        write(number::LOG_PERIOD, 10),
        command(number::LOG_ERASE_REQUEST),
        wait(200),
        command(number::LOG_READ_REQUEST),
        wait(50),
    ]
    .concat();
    let mode = |sensorless, open_loop| {
        [
            vec![3],
            write(number::HALL_ENABLE, 0),
            write(number::SENSORLESS_ENABLE, sensorless),
            write(number::OPEN_LOOP_ENABLE, open_loop),
            standby.clone(),
            wait(20),
            drive.clone(),
            wait(100),
            speed.clone(),
            wait(100),
            drive.clone(),
            wait(100),
        ]
        .concat()
    };
    let capture = [
        scope(ToDrive::TriggerScope),
        wait(2),
        scope(ToDrive::TriggerScope),
        wait(30),
        scope(ToDrive::DownloadScope),
        wait(30),
    ]
    .concat();
    let scoped = [
        vec![3],
        write(number::SCOPE_SAMPLES, 100),
        capture.clone(),
        write(number::SCOPE_INPUTS, 1),
        capture,
    ]
    .concat();
    let trouble = [
        start.clone(),
        wait(100),
        vec![8, 0, 2],
        wait(20),
        vec![8, 0, 0],
        vec![7, 6, 2, 0],
        wait(20),
        standby.clone(),
        wait(200),
        vec![8, 2, 1],
        wait(2),
    ]
    .concat();
    vec![
        (
            "drive",
            "hall",
            [
                start.clone(),
                wait(100),
                drive.clone(),
                wait(100),
                ask(MotorMode::Reverse),
                turning(0x1F00),
                wait(200),
                standby.clone(),
                wait(50),
            ]
            .concat(),
        ),
        ("drive", "silent-master", [start, wait(250), wait(250)].concat()),
        ("drive", "sensorless", mode(1, 0)),
        ("drive", "open-loop", mode(0, 1)),
        (
            "drive",
            "calibration",
            [vec![3], command(number::HALL_CALIBRATE), standby, wait(20), drive, wait(200)].concat(),
        ),
        ("drive", "stored", stored),
        ("drive", "logged", logged),
        ("drive", "scope", scoped),
        ("drive", "trouble", trouble),
        ("drive", "every-message", [vec![3], given(0, &narmotion())].concat()),
        (
            "drive",
            "blank-flash",
            [vec![0], wait(250), wait(250), command(number::STORE), wait(250), vec![1, 1, 0]].concat(),
        ),
    ]
}

fn seeds() -> Vec<Seed> {
    let mut text = String::new();
    let document =
        Document { identity: Identity::default(), addresses: Addresses::FACTORY, tick_rate: 10_000 };
    document.write(&mut text).unwrap();
    let head = &text[..text.match_indices("</parameter>").nth(1).map_or(1000, |(at, _)| at)];
    let frames = [narmotion(), eddycan()].concat();
    let log: String = frames
        .iter()
        .zip(0..)
        .map(|(frame, at)| candump::line(at * 320_000, "can0", frame).to_string() + "\n")
        .collect();
    let mut host = b"C\rS6\r\rO\rO\rV\rN\rF\rZ1\r".to_vec();
    frames.iter().for_each(|frame| host.extend(slcan::encode_frame(frame, None)));
    host.extend(b"C\rZ1\rS8\rL\rt1230\r");
    let record =
        Record::new(3, &Entry { time: 12_345, values: [(1, -1), (0x4002, 70_000)].into_iter().collect() });
    let others = vec![
        ("boot", "changed-body", vec![1, 0, 8, 100, 2, 0, 3, 1, 0x55, 6]),
        ("boot", "runs", vec![1, 0, 8, 100]),
        ("boot", "swaps-and-reverts", vec![1, 0, 8, 100, 8, 9, 120, 6, 12, 6, 6]),
        ("boot", "swaps-and-keeps", vec![1, 0, 8, 100, 8, 9, 120, 6, 12, 6, 28, 6]),
        ("boot", "power-cut", vec![1, 0, 8, 100, 8, 9, 120, 6, 12, 7, 80, 0, 15, 20, 0]),
        ("boot", "state-pages", vec![1, 0, 8, 100, 3, 0, 1, 0xF0, 3, 2, 8, 0]),
        ("bus", "narmotion", program(&narmotion())),
        ("bus", "eddycan", program(&eddycan())),
        ("candump", "log", log.into_bytes()),
        ("candump", "forms", b"(1436509052.249713) can0 1A2#DEADBEEF R\n(1.5) vcan0 1A2#R8 T\n(2) can0 0AAD5202##3DEADBEEF\n(3) can0 20000088#00040000\n\n(4) x 123#1".to_vec()),
        ("description", "document", vec![1]),
        ("description", "changed", [vec![1], 300_u16.to_le_bytes().to_vec(), b"\x03\x04\"10\"".to_vec()].concat()),
        ("description", "beginning", [&[0], head.as_bytes()].concat()),
        ("log", "record", [&[0], record.bytes()].concat()),
        ("log", "made-right", [&[1], record.bytes()].concat()),
        ("master", "commands", [vec![1], vec![2, 2, 0, 0, 1, 50, 2, 0, 0xE8, 3, 1, 250, 1, 250, 2, 3, 0, 0, 1, 250]].concat()),
        ("master", "receives", [vec![0], given(0, &narmotion())].concat()),
        ("master", "requests", vec![0, 3, 0, 2, 0, 0, 0, 0, 0, 1, 10, 4, 0, 5, 0, 0, 0, 9, 3, 2, 1, 0, 0, 0, 0, 0, 1, 10, 4, 0, 0, 0, 0, 0, 1, 10, 4, 0, 1, 0, 0, 0, 9]),
        ("master", "description", [vec![0, 6, 0, 0, 1, 10, 4, 0, 6, 0, 0, 0, 1, 10], vec![5, 0, 0, 0, 1, 2, 3, 4, 5, 6, 5, 0, 3, 0, 1, 2, 3, 4, 5, 6, 9, 1, 10, 9]].concat()),
        ("master", "scope", [vec![0, 6, 1, 6, 1, 10, 4, 0, 6, 0, 0, 0, 1, 10, 4, 0, 3, 0, 0, 0, 1, 10], vec![5, 1, 0, 0, 1, 2, 3, 4, 5, 6, 5, 1, 3, 0, 1, 2, 3, 4, 5, 6, 9, 1, 10, 9]].concat()),
        ("master", "log", vec![0, 6, 2, 1, 0, 0, 1, 10, 4, 0, 24, 0, 0, 0, 1, 10, 4, 0, 0, 0, 0, 0, 1, 10, 4, 0, 1, 0, 0, 0, 1, 10, 4, 0, 1, 0, 0, 0, 1, 10, 7, 0, 0, 1, 9, 0, 0, 0, 9, 1, 10, 9]),
        ("master", "update", vec![0, 8, 0, 1, 0, 1, 10, 8, 2, 7, 0, 1, 10, 8, 3, 0, 0, 1, 10, 8, 12, 0, 0, 1, 10, 8, 20, 63, 0, 1, 100, 8, 28, 0, 62, 1, 10, 8, 36, 0, 62, 1, 10]),
        ("recording", "ticks", [vec![2], [0x01, 8, 0x03, 4, 6, 0x20, 5, 0x00, 0x40, 1, 0, 0x80, 2, 5].to_vec()].concat()),
        ("recording", "changed", vec![1, 40, 3, 0, 1]),
        ("recording", "file", [&[0], &include_bytes!("../../vectors/no-mode.narxrec")[..1500]].concat()),
        ("scope", "real", vec![1]),
        ("scope", "changed", vec![1, 9, 0, 1, 0, 70, 0, 0x10, 0]),
        ("slcan", "host", host),
        ("storage", "blank", vec![0]),
        ("storage", "real", vec![1]),
        ("storage", "flipped", vec![1, 2, 0x10, 0x10, 3, 3, 0x20, 0x50, 1]),
        ("storage", "cut", vec![1, 14, 0, 0, 1, 200, 0, 14, 0, 0, 9, 100, 0]),
        ("storage", "erased", vec![1, 10, 0, 0, 0xFF, 255]),
        ("transcript", "node", [&[0], &include_bytes!("../../vectors/transcripts/node-identity.narxrec")[..3000]].concat()),
        ("transcript", "tx-driver", [&[0], &include_bytes!("../../vectors/transcripts/tx-driver-configuration.narxrec")[..3000]].concat()),
        ("transcript", "polls", vec![1, 10, 1, 0xff, 200, 1, 11, 10, 5, 17]),
        ("transcript", "samples", vec![2, 5, 2, 4, 6, 25, 0xff, 100, 6, 9]),
        ("tx_driver", "receives", [vec![1], given(0, &eddycan())].concat()),
        ("tx_driver", "measures", vec![1, 1, 3, 1, 10, 0, 0, 0, 5, 1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 2, 0, 3, 100, 2, 4, 3, 100, 2, 6, 4, 0, 1, 2, 2, 4, 0, 1]),
        ("tx_driver", "stores", vec![0, 1, 3, 1, 10, 0, 0, 0, 4, 0, 255, 7, 0, 7, 0, 2, 3, 4, 0, 255, 4, 0, 255]),
        ("tx_master", "requests", vec![1, 1, 2, 3, 0, 1, 1, 4, 4, 10, 0, 0, 0, 6, 2, 3, 1, 20, 0, 0, 0, 1, 1, 4, 0, 0, 0, 0, 0, 6, 5, 2, 3, 0, 1, 1]),
        ("tx_master", "receives", [vec![1, 1], given(0, &eddycan())].concat()),
        ("update", "programs", vec![1, 9, 100, 6, 20, 2, 252, 2, 252, 2, 252, 4, 6, 40, 9, 5, 6, 10, 9]),
        ("update", "reverts", vec![1, 9, 100, 6, 20, 2, 252, 2, 252, 2, 252, 4, 6, 40, 9, 8, 9]),
        ("update", "power-cut", vec![1, 9, 100, 6, 20, 2, 252, 2, 252, 2, 252, 4, 6, 40, 25, 100, 0, 9, 9]),
    ];
    [drives(), others].concat()
}

#[test]
fn the_corpus_holds_what_is_real() {
    for (target, what, bytes) in seeds() {
        let file =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target).join(format!("real-{what}"));
        if env::var_os("UPDATE").is_some() {
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(&file, &bytes).unwrap();
        }
        let kept = fs::read(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        assert!(kept == bytes, "{} is another one; UPDATE=1 writes it", file.display());
    }
}
