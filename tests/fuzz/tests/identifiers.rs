//! Every identifier of 11 and of 29 bits, with every data length code, as data and as remote frame: a node
//! reacts as PROTOCOL.md says, and every other frame causes no answer and no change. The frames' data are
//! zeros.
//!
//! The ignored tests run all 9.7 thousand million frames to both nodes (`cargo xtask fuzz --identifiers`).
//! The others are exhaustive by fields: priority, source and destination in all combinations with some types
//! and opcodes, and all of these with every frame to the drive or of its master.

use narx_core::bus::eddycan::{Channels, FromNode, NmtCommand, NmtState, Position, Target, ToNode};
use narx_core::bus::narmotion::{Addresses, FromDrive, ToDrive, XmlCommand};
use narx_core::bus::{Frame, Id};
use narx_core::dictionary::number;
use narx_core::eddycan::{Configuration, MeasuringRange, Sample, TxDriver, Variant};
use narx_core::motor::{Board, State, Status};
use narx_core::node::{Identity, Node};
use std::ops::Range;
use std::thread;
use std::time::Instant;

/// Number of frames per identifier: data length codes, each as data and as remote frame.
const SHAPES: u32 = 9 * 2;
/// Number of identifiers with the same priority, source and destination: every type and opcode.
const BLOCK: u32 = 1 << 11;
/// Number of blocks of 29-bit identifiers.
const BLOCKS: u32 = 1 << 18;
const DRIVE: u8 = Addresses::FACTORY.drive;
const MASTER: u8 = Addresses::FACTORY.master;

/// Reaction of a drive to a frame of zeros (PROTOCOL.md, sections 1.3 and 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    /// None: the frame is for another device.
    Ignored,
    /// Counted as malformed (parameter 275).
    Malformed,
    /// Counted as refused (parameter 274).
    Refused,
    /// Counted as refused (parameter 274), with the reason in parameter 306.
    Explained,
    /// Carried out, without an answer.
    Accepted,
    /// Carried out, and answered with this opcode.
    Answered(u16),
}

/// Type, opcode, and the reaction in Standby without flash, scope and slots.
const MESSAGES: [(u32, u32, Fate); 24] = [
    (1, 2, Fate::Accepted),
    (1, 101, Fate::Answered(101)),
    (1, 102, Fate::Answered(102)),
    (1, 103, Fate::Accepted),
    (1, 104, Fate::Accepted),
    (1, 110, Fate::Answered(110)),
    (1, 112, Fate::Accepted),
    // Serial number 0 belongs to another board.
    (1, 113, Fate::Refused),
    (2, 0, Fate::Answered(0)),
    (2, 1, Fate::Answered(1)),
    (2, 110, Fate::Answered(110)),
    (2, 112, Fate::Explained),
    (2, 130, Fate::Answered(130)),
    // Programming of a drive that has no slots.
    (2, 160, Fate::Refused),
    (2, 161, Fate::Refused),
    (1, 162, Fate::Refused),
    (1, 163, Fate::Refused),
    (2, 164, Fate::Refused),
    (1, 165, Fate::Refused),
    (1, 166, Fate::Refused),
    (1, 167, Fate::Refused),
    // Unknown opcodes, and opcodes of the other type.
    (1, 0, Fate::Refused),
    (2, 2, Fate::Refused),
    (1, 511, Fate::Refused),
];

fn fate(id: Id, dlc: u8, remote: bool) -> Fate {
    let raw = id.raw();
    let (source, destination, kind, opcode) = ((raw >> 19) as u8, (raw >> 11) as u8, raw >> 9 & 3, raw & 511);
    if !id.is_extended() || kind == 3 {
        return Fate::Malformed;
    }
    if destination != DRIVE {
        return Fate::Ignored;
    }
    if remote || dlc != 8 || kind == 0 {
        return Fate::Malformed;
    }
    if source != MASTER {
        return Fate::Refused;
    }
    let row = MESSAGES.iter().find(|(type_, number, _)| (*type_, *number) == (kind, opcode));
    row.map_or(Fate::Refused, |(_, _, fate)| *fate)
}

fn frame(id: Id, shape: u32) -> (Frame, u8, bool) {
    let (dlc, remote) = ((shape % 9) as u8, shape >= 9);
    let frame = if remote { Frame::remote(id, dlc) } else { Frame::data(id, &[0; 8][..dlc.into()]) };
    (frame.unwrap(), dlc, remote)
}

/// A drive in Standby with nothing to send.
fn drive() -> Node {
    let mut node = Node::new(Identity::default(), Board::BENCH);
    node.handle_status(Status { state: State::Standby, ..Status::default() });
    while node.poll_frame().is_some() || node.poll_event().is_some() {}
    // The first request for the description's length measures it.
    node.handle_frame(&ToDrive::DownloadXml(XmlCommand::Length).encode(Addresses::FACTORY));
    (0..10_000).for_each(|now| node.poll(now));
    while node.poll_frame().is_some() {}
    node
}

/// Gives a drive the frames of these identifiers, and a twin as many of the simplest malformed and refused
/// ones: both must then be equal. For a frame that is carried out, a fresh drive is used each time. Returns
/// the number of frames.
fn sweep_drive(node: &mut Node, ids: impl Iterator<Item = Id>) -> u64 {
    let malformed = Frame::full(Id::standard(0x123).unwrap(), [0; 8]);
    let refused = ToDrive::RequestBuildInfo.encode(Addresses { master: !MASTER, drive: DRIVE });
    let mut twin = node.clone();
    let (mut given, mut explained) = (0, false);
    for id in ids {
        for shape in 0..SHAPES {
            let (frame, dlc, remote) = frame(id, shape);
            given += 1;
            match fate(id, dlc, remote) {
                Fate::Ignored => {}
                Fate::Malformed => twin.handle_frame(&malformed),
                Fate::Refused => twin.handle_frame(&refused),
                Fate::Explained => {
                    twin.handle_frame(&frame);
                    explained = true;
                }
                fate => {
                    accepts(node, &frame, fate);
                    continue;
                }
            }
            node.handle_frame(&frame);
        }
    }
    assert!(*node == twin, "a frame that is not accepted has changed more than its counter");
    assert!(node.poll_frame().is_none(), "it has said something");
    let reason = node.read_parameter(number::SCOPE_REFUSAL);
    assert!(!explained || reason == Some(1), "a download without a record: {reason:?}");
    given
}

fn accepts(node: &Node, frame: &Frame, fate: Fate) {
    let mut fresh = node.clone();
    fresh.handle_frame(frame);
    let answers: Vec<u16> = std::iter::from_fn(|| fresh.poll_frame())
        .map(|frame| FromDrive::decode(&frame).unwrap().1.opcode().raw())
        .collect();
    let wanted = if let Fate::Answered(opcode) = fate { vec![opcode] } else { Vec::new() };
    assert_eq!(answers, wanted, "{frame:?}");
    let counted = |node: &Node| [274, 275].map(|number| node.read_parameter(number));
    assert_eq!(counted(&fresh), counted(node), "{frame:?} is counted");
}

/// Prints the figures for `cargo xtask fuzz --identifiers`: bits, frames, seconds, node.
fn tell(bits: u32, given: u64, begun: Instant, node: &str) {
    println!("swept {bits} {given} {} {node}", begun.elapsed().as_secs());
}

fn extended(block: u32) -> impl Iterator<Item = Id> {
    (block * BLOCK..(block + 1) * BLOCK).map(|raw| Id::extended(raw).unwrap())
}

fn is_near(block: u32) -> bool {
    let (source, destination) = ((block >> 8) as u8, block as u8);
    source == MASTER || destination == DRIVE
}

#[test]
fn every_11_bit_identifier_to_the_drive() {
    let begun = Instant::now();
    let given = sweep_drive(&mut drive(), (0..1 << 11).map(|raw| Id::standard(raw).unwrap()));
    assert_eq!(given, 2048 * 18);
    tell(11, given, begun, "a drive");
}

#[test]
fn every_29_bit_identifier_to_the_drive_or_of_its_master() {
    let mut node = drive();
    let given: u64 = (0..BLOCKS)
        .filter(|block| is_near(*block))
        .map(|block| sweep_drive(&mut node, extended(block)))
        .sum();
    // 511 pairs of addresses with at least one right, four priorities.
    assert_eq!(given, 511 * 4 * 2048 * 18);
}

#[test]
fn every_priority_source_and_destination_to_the_drive() {
    let mut node = drive();
    for block in 0..BLOCKS {
        // Each type with one opcode of a message, and with another opcode that changes from block to block.
        let ids =
            (0..4).flat_map(|kind| [110, block % 509].map(|opcode| block * BLOCK + kind * 512 + opcode));
        sweep_drive(&mut node, ids.map(|raw| Id::extended(raw).unwrap()));
    }
}

/// Runs the frames of `blocks`, on both threads of a small machine.
fn halves(sweep: impl Fn(Range<u32>) -> u64 + Sync) -> u64 {
    thread::scope(|scope| {
        let first = scope.spawn(|| sweep(0..BLOCKS / 2));
        sweep(BLOCKS / 2..BLOCKS) + first.join().unwrap()
    })
}

#[test]
#[ignore = "minutes: cargo xtask fuzz --identifiers"]
fn every_29_bit_identifier_to_the_drive() {
    let begun = Instant::now();
    let given = halves(|blocks| {
        let mut node = drive();
        blocks.map(|block| sweep_drive(&mut node, extended(block))).sum()
    });
    assert_eq!(given, (1 << 29) * 18);
    tell(29, given, begun, "a drive");
}

const STATES: [NmtState; 3] = [NmtState::PreOperational, NmtState::Operational, NmtState::Stopped];

/// A TX-Driver with node-id 1 that has measured, with nothing to send.
fn tx_driver(state: NmtState) -> TxDriver {
    let range = MeasuringRange::new(Position::MIN, Position::MAX).unwrap();
    let variant = Variant { channels: Channels::Dual, ranges: [range; 2], sample_rate: 40_000, firmware: 1 };
    let mut driver = TxDriver::new(variant, Configuration::new());
    driver.handle_sample(Sample::default());
    let command = match state {
        NmtState::Operational => NmtCommand::Start,
        NmtState::Stopped => NmtCommand::Stop,
        _ => NmtCommand::PreOperational,
    };
    driver.handle_frame(&ToNode::Nmt { command, target: Target::All }.encode(), 0);
    while driver.poll_frame().is_some() {}
    assert_eq!(driver.state(), state);
    driver
}

/// Identifier of a TX-Driver's answer to a frame of zeros (PROTOCOL.md, section 10), if there is one.
fn answer(id: Id, dlc: u8, remote: bool, state: NmtState) -> Option<u32> {
    if id.is_extended() {
        return None;
    }
    match (id.raw(), dlc, remote, state) {
        // SYNC, and the remote request for two positions.
        (0x080, 0, false, NmtState::Operational) => Some(0x281),
        (0x381, 8, true, NmtState::Operational) => Some(0x381),
        // No SDO has command 0: the answer is an abort.
        (0x601, 8, false, NmtState::PreOperational | NmtState::Operational) => Some(0x581),
        _ => None,
    }
}

fn sweep_tx_driver(quiet: &TxDriver, ids: impl Iterator<Item = Id>) -> u64 {
    let mut driver = quiet.clone();
    let mut given = 0;
    for id in ids {
        for shape in 0..SHAPES {
            let (frame, dlc, remote) = frame(id, shape);
            given += 1;
            let Some(wanted) = answer(id, dlc, remote, quiet.state()) else {
                driver.handle_frame(&frame, 0);
                continue;
            };
            let mut fresh = quiet.clone();
            fresh.handle_frame(&frame, 0);
            let answers: Vec<u32> =
                std::iter::from_fn(|| fresh.poll_frame()).map(|frame| frame.id().raw()).collect();
            assert_eq!(answers, [wanted], "{frame:?} in {:?}", quiet.state());
            let said = Frame::full(Id::standard(wanted as u16).unwrap(), [0; 8]);
            assert!(wanted == 0x581 || FromNode::decode(&said, quiet.layout()).is_ok());
            assert_eq!((fresh.state(), fresh.configuration()), (quiet.state(), quiet.configuration()));
        }
    }
    assert!(driver == *quiet, "a frame that it does not listen to has changed it");
    given
}

#[test]
fn every_11_bit_identifier_to_the_tx_driver() {
    for state in STATES {
        let begun = Instant::now();
        let given = sweep_tx_driver(&tx_driver(state), (0..1 << 11).map(|raw| Id::standard(raw).unwrap()));
        assert_eq!(given, 2048 * 18);
        tell(11, given, begun, &format!("a TX-Driver, {state:?}"));
    }
}

/// No 29-bit identifier reaches the TX-Driver: neither with any pattern of the low eleven bits, where a
/// function and a node-id would be, nor with any single bit above them.
#[test]
fn no_29_bit_identifier_to_the_tx_driver() {
    for state in STATES {
        let above = (11..29).map(|bit| 1 << bit).chain([0, 0x1FFF_F800]);
        let ids = above.flat_map(|high| (0..1 << 11).map(move |low| Id::extended(high | low).unwrap()));
        sweep_tx_driver(&tx_driver(state), ids);
    }
}

#[test]
#[ignore = "minutes: cargo xtask fuzz --identifiers"]
fn every_29_bit_identifier_to_the_tx_driver() {
    let begun = Instant::now();
    let given = halves(|blocks| {
        let quiet = tx_driver(NmtState::Operational);
        blocks.map(|block| sweep_tx_driver(&quiet, extended(block))).sum()
    });
    assert_eq!(given, (1 << 29) * 18);
    tell(29, given, begun, "a TX-Driver, Operational");
}
