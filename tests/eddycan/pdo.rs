//! Tests of PDOs: the instants at which positions are sent, and their content.

use crate::bench::{BITRATES, Bench, CHANNELS, SAMPLE, mm, node};
use narx_core::bus::eddycan::{Channels, FromNode, Layout, NmtState, PdoKind, Position, Reading, ToNode};
use narx_core::bus::{Frame, Id};
use narx_core::eddycan::{Entry, Sample};

fn instants(pdos: &[(u64, PdoKind, Reading)]) -> Vec<u64> {
    assert!(pdos.iter().all(|(_, kind, _)| *kind == PdoKind::Timer));
    pdos.iter().map(|(at, ..)| *at).collect()
}

#[test]
fn update_times_in_milliseconds() {
    for milliseconds in [1, 2, 10, 1000, 65_534] {
        let values = [(Entry::UpdateTime, milliseconds)];
        let mut bench = Bench::in_state(NmtState::Operational, Channels::Single, &values);
        let start = bench.now;
        let period = u64::from(milliseconds) * 1000;
        let found = instants(&bench.pdos(period * 20));
        let expected: Vec<u64> = (0..20).map(|n| start + n * period).collect();
        assert_eq!(found, expected, "{milliseconds} ms");
    }
}

#[test]
fn update_time_0_sends_nothing_by_itself() {
    let mut bench = Bench::in_state(NmtState::Operational, Channels::Single, &[(Entry::UpdateTime, 0)]);
    assert_eq!(bench.pdos(200_000_000), []);
    bench.send(ToNode::Sync);
    assert_eq!(bench.messages().len(), 1, "SYNC works all the same");
}

/// Longest frame of a PDO of these many bytes in bits, worked by hand: 34 + 8 n bits from start to CRC take a
/// stuff bit after the fifth and then after every fourth; 13 follow with the gap. 34 + 32 = 66 bits and 16
/// stuff bits; 82 and 20; 98 and 24.
const LONGEST: [(u8, u64); 3] = [(4, 66 + 16 + 13), (6, 82 + 20 + 13), (8, 98 + 24 + 13)];

/// All nodes together fill half of the bus with their longest frames: counted over 1000 periods, within 2 %
/// (none of which is used).
#[test]
fn half_of_the_bus_for_all_nodes_together() {
    for (index, (bitrate, bits_per_second)) in BITRATES.into_iter().enumerate() {
        for channels in CHANNELS {
            for register in [0, 2] {
                for nodes in [1, 2, 10, 127_u32] {
                    let values = [
                        (Entry::BitrateIndex, index as u32),
                        (Entry::CanConfig, register),
                        (Entry::NrOfNodes, nodes),
                        (Entry::UpdateTime, 65_535),
                    ];
                    let mut bench = Bench::in_state(NmtState::Operational, channels, &values);
                    assert_eq!(bench.driver.bitrate(), bitrate);
                    let length = bench.driver.layout().length();
                    let bits = LONGEST.iter().find(|(bytes, _)| *bytes == length).unwrap().1;
                    let start = bench.now;
                    let period = bench.driver.period().unwrap();
                    let found = instants(&bench.pdos(1000 * period));
                    let steps = (found.len() - 1) as f64;
                    let seconds = (found[found.len() - 1] - start) as f64 * 1e-6;
                    let load =
                        f64::from(nodes) * steps * bits as f64 / (seconds * f64::from(bits_per_second));
                    let what = format!("{bitrate:?}, {length} bytes, {nodes} nodes: {load}");
                    assert!((load - 0.5).abs() < 0.5 * 0.02, "{what}");
                    assert!(
                        (load - 0.5).abs() < 1e-9,
                        "{what}: every period is a whole number of microseconds"
                    );
                }
            }
        }
    }
}

/// The number of nodes only stretches the period. A listener to ten such nodes, started by one command,
/// therefore sees what each of them does alone.
#[test]
fn the_number_of_nodes_stretches_the_period_only() {
    let period = |nodes| {
        let values = [(Entry::NrOfNodes, nodes), (Entry::UpdateTime, 65_535)];
        Bench::new(Channels::Single, &values).driver.period().unwrap()
    };
    // 95 bits of 2 us, twice.
    assert_eq!(period(1), 380);
    assert!((1..=127).all(|nodes| period(nodes) == 380 * u64::from(nodes)));
}

/// Ten nodes that one command starts send one after the other, as far apart as half of the bus allows, for
/// any first node-id. Without the half load they all send at once.
#[test]
fn nodes_that_share_half_of_the_bus_take_turns() {
    for first in [1, 8, 118_u32] {
        let mut begins: Vec<u64> = (first..first + 10)
            .map(|id| {
                let values = [(Entry::NodeId, id), (Entry::NrOfNodes, 10), (Entry::UpdateTime, 65_535)];
                let mut bench = Bench::in_state(NmtState::Operational, Channels::Single, &values);
                let start = bench.now;
                let found = instants(&bench.pdos(3800 * 3));
                assert_eq!(found.len(), 3, "{id}");
                assert_eq!(found[1] - found[0], 3800, "{id}");
                found[0] - start
            })
            .collect();
        begins.sort();
        assert!(begins.iter().copied().eq((0..10).map(|turn| turn * 380)), "{first}: {begins:?}");
    }
    for id in [1, 7, 127] {
        let values = [(Entry::NodeId, id), (Entry::NrOfNodes, 10), (Entry::UpdateTime, 10)];
        let mut bench = Bench::in_state(NmtState::Operational, Channels::Single, &values);
        let start = bench.now;
        assert_eq!(instants(&bench.pdos(10_000)), [start], "{id}");
    }
}

#[test]
fn a_late_poll_sends_one_and_keeps_the_beat() {
    let mut bench = Bench::in_state(NmtState::Operational, Channels::Single, &[(Entry::UpdateTime, 10)]);
    assert_eq!(bench.poll().len(), 1);
    assert_eq!(bench.wait(9_999).len(), 0);
    assert_eq!(bench.wait(1).len(), 1);
    assert_eq!(bench.wait(37_000).len(), 1, "three were due");
    assert_eq!(bench.wait(2_999).len(), 0);
    assert_eq!(bench.wait(1).len(), 1, "50 ms after the first");
}

/// Operational begins with a PDO1, however briefly it was left.
#[test]
fn every_start_begins_a_beat_of_its_own() {
    let mut bench = Bench::in_state(NmtState::Operational, Channels::Single, &[(Entry::UpdateTime, 10)]);
    assert_eq!(bench.poll().len(), 1);
    bench.now += 3000;
    bench.enter(NmtState::Stopped);
    bench.enter(NmtState::Operational);
    let start = bench.now;
    assert_eq!(instants(&bench.pdos(20_000)), [start, start + 10_000]);
}

#[test]
fn what_waits_is_overwritten() {
    let mut bench = Bench::in_state(NmtState::Operational, Channels::Single, &[(Entry::UpdateTime, 10)]);
    for millimetres in 0..4 {
        bench.driver.handle_sample(Sample { positions: [mm(millimetres); 2], counter: 0 });
        bench.driver.poll(bench.now);
        bench.now += 10_000;
    }
    let messages = bench.messages();
    assert!(
        matches!(messages[..], [FromNode::Pdo { kind: PdoKind::Timer, reading }] if reading.positions[0] == mm(3)),
        "{messages:?}"
    );
}

/// The positions are those of the instant of the SYNC, however late the frame is sent.
#[test]
fn a_sync_takes_the_positions_of_its_instant() {
    let mut bench = Bench::in_state(NmtState::Operational, Channels::Dual, &[]);
    bench.send(ToNode::Sync);
    bench.driver.handle_sample(Sample { positions: [mm(3), mm(3)], counter: 0 });
    let reading = Reading { positions: SAMPLE.positions, encoder: 0 };
    assert_eq!(bench.messages(), [FromNode::Pdo { kind: PdoKind::Sync, reading }]);
}

#[test]
fn sync_has_no_data() {
    let bench = Bench::in_state(NmtState::Operational, Channels::Dual, &[]);
    let id = Id::standard(0x80).unwrap();
    for length in 1..=8 {
        let mut driver = bench.driver.clone();
        driver.handle_frame(&Frame::data(id, &[0; 8][..length]).unwrap(), bench.now);
        assert_eq!(driver, bench.driver, "{length} bytes");
    }
    let mut driver = bench.driver.clone();
    driver.handle_frame(&Frame::remote(id, 0).unwrap(), bench.now);
    assert_eq!(driver, bench.driver);
}

/// For every node, PDO and length, only a request for PDO3 of this node with exactly the length of its layout
/// is answered.
#[test]
fn remote_frames() {
    for channels in CHANNELS {
        for register in [0, 2] {
            let bench = Bench::in_state(NmtState::Operational, channels, &[(Entry::CanConfig, register)]);
            let length = bench.driver.layout().length();
            for id in 0..0x800_u16 {
                for dlc in 0..=8 {
                    let mut driver = bench.driver.clone();
                    driver.handle_frame(&Frame::remote(Id::standard(id).unwrap(), dlc).unwrap(), bench.now);
                    if id == 0x381 && dlc == length {
                        let frame = driver.poll_frame().unwrap();
                        assert_eq!((frame.id(), frame.dlc()), (Id::standard(0x381).unwrap(), length));
                        assert!(!frame.is_remote());
                        assert_eq!(driver.poll_frame(), None);
                    } else {
                        assert_eq!(driver, bench.driver, "{id:03X}, {dlc}");
                    }
                }
            }
        }
    }
}

/// The whole device sends the four layouts of the figures in all three PDOs.
#[test]
fn layouts() {
    let sample =
        Sample { positions: [Position::from_raw(0x0403_0201), Position::from_raw(-2)], counter: 0x0605 };
    for (channels, register, expected) in [
        (Channels::Single, 0, &[1, 2, 3, 4][..]),
        (Channels::Dual, 0, &[1, 2, 3, 4, 0xFE, 0xFF, 0xFF, 0xFF]),
        (Channels::Single, 2, &[1, 2, 3, 4, 5, 1]),
        (Channels::Dual, 2, &[2, 3, 4, 0xFF, 0xFF, 0xFF, 5, 1]),
    ] {
        let values = [(Entry::CanConfig, register), (Entry::UpdateTime, 1)];
        let mut bench = Bench::dark(channels, &values);
        // The counter runs freely: its value before the first sample is no motion.
        bench.driver.handle_sample(Sample { counter: 0x0500, ..sample });
        bench.driver.handle_sample(sample);
        bench.enter(NmtState::Operational);
        bench.send(ToNode::Sync);
        bench.send(ToNode::RequestPdo { node: node(1), bytes: expected.len() as u8 });
        let frames = bench.poll();
        let ids: Vec<u32> = frames.iter().map(|frame| frame.id().raw()).collect();
        assert_eq!(ids, [0x181, 0x281, 0x381]);
        assert!(frames.iter().all(|frame| frame.payload() == expected), "{frames:?}");
    }
    assert_eq!(Layout::ALL.map(Layout::length), [4, 8, 6, 8]);
}

#[test]
fn nothing_is_sent_before_the_first_sample() {
    let mut bench = Bench::dark(Channels::Single, &[(Entry::UpdateTime, 1)]);
    bench.enter(NmtState::Operational);
    bench.send(ToNode::Sync);
    bench.send(ToNode::RequestPdo { node: node(1), bytes: 4 });
    assert_eq!(bench.pdos(10_000), []);
    bench.driver.handle_sample(SAMPLE);
    assert_eq!(bench.poll().len(), 1);
}

/// On a bus that is too slow, no PDO and no answer waits for more than three others.
#[test]
fn everybody_has_a_turn_on_a_bus_that_is_too_slow() {
    let mut bench = Bench::in_state(NmtState::Operational, Channels::Single, &[(Entry::UpdateTime, 1)]);
    let mut seen = std::collections::BTreeMap::new();
    for _ in 0..400 {
        bench.now += 5000;
        bench.driver.poll(bench.now);
        bench.send(ToNode::Sync);
        bench.send(ToNode::RequestPdo { node: node(1), bytes: 4 });
        bench.give(&crate::bench::frame(0x601, &[0x40, 0, 0x20, 0, 0, 0, 0, 0]));
        *seen.entry(bench.driver.poll_frame().unwrap().id().raw()).or_insert(0) += 1;
    }
    assert_eq!(
        seen.into_iter().collect::<Vec<_>>(),
        [(0x181, 100), (0x281, 100), (0x381, 100), (0x581, 100)]
    );
}
