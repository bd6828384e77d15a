//! Tests of the arbitration: order and instants of frames.

use crate::frames::{extended, standard};
use narx_core::bus::{Frame, Id};
use narx_sim::can::{Attachment, Bus, NotQueued, frame_bits, worst_case_bits};
use proptest::prelude::*;

type TestBus = Bus<8, 16>;
const BIT_NS: u64 = 2_000;

#[test]
fn the_lowest_identifier_wins() {
    let id = 0x123;
    // Listed in the order in which arbitration must let them pass.
    let order = [
        standard(id - 1, &[1]),
        standard(id, &[2]),
        Frame::remote(Id::standard(id).unwrap(), 2).unwrap(),
        extended(u32::from(id) << 18, &[3]),
        Frame::remote(Id::extended(u32::from(id) << 18).unwrap(), 3).unwrap(),
        extended(u32::from(id) << 18 | 1, &[4]),
        standard(id + 1, &[5]),
    ];
    let mut bus = TestBus::new(500_000);
    let listener = bus.attach().unwrap();
    let nodes = order.map(|_| bus.attach().unwrap());
    for (node, frame) in nodes.iter().zip(&order).rev() {
        bus.send(*node, *frame, 1_000).unwrap();
    }
    bus.advance(10_000_000);
    let mut end = 1_000;
    for (node, frame) in nodes.iter().zip(&order) {
        let received = bus.receive(listener).unwrap();
        end += u64::from(frame_bits(frame)) * BIT_NS;
        assert_eq!((received.frame, received.sender), (*frame, *node));
        // A frame ends one intermission before the next start.
        assert_eq!(received.time_ns, end - 3 * BIT_NS);
    }
    assert_eq!(bus.receive(listener), None);
    assert_eq!(bus.statistics().frames, order.len() as u64);
    assert_eq!(bus.statistics().busy_ns, end - 1_000);
}

#[test]
fn a_frame_under_way_is_not_interrupted() {
    let mut bus = TestBus::new(500_000);
    let [a, b, c] = [0; 3].map(|_| bus.attach().unwrap());
    bus.send(a, standard(0x700, &[0; 8]), 0).unwrap();
    bus.advance(50_000);
    bus.send(b, standard(0x001, &[]), 50_000).unwrap();
    bus.advance(1_000_000);
    assert_eq!(bus.receive(c).unwrap().sender, a);
    assert_eq!(bus.receive(c).unwrap().sender, b);
    // A node does not receive its own frame.
    assert_eq!(bus.receive(a).unwrap().sender, b);
    assert_eq!(bus.receive(a), None);
}

#[test]
fn a_late_frame_cannot_change_what_is_settled() {
    let mut bus = TestBus::new(500_000);
    let [a, b] = [0; 2].map(|_| bus.attach().unwrap());
    bus.advance(1_000_000);
    bus.send(a, standard(1, &[]), 3).unwrap();
    bus.advance(2_000_000);
    let expected = 1_000_000 + u64::from(frame_bits(&standard(1, &[])) - 3) * BIT_NS;
    assert_eq!(bus.receive(b).unwrap().time_ns, expected);
}

#[test]
fn equal_frames_merge() {
    let mut bus = TestBus::new(500_000);
    let [a, b, c] = [0; 3].map(|_| bus.attach().unwrap());
    bus.send(a, standard(5, &[9]), 0).unwrap();
    bus.send(b, standard(5, &[9]), 0).unwrap();
    bus.advance(1_000_000);
    assert!(bus.receive(c).is_some());
    assert!(bus.receive(c).is_none() && bus.receive(a).is_none() && bus.receive(b).is_none());
    assert_eq!((bus.queued(a), bus.queued(b)), (0, 0));
}

#[test]
fn full_queues_say_so() {
    let mut bus = Bus::<3, 4>::new(500_000);
    let [a, b, idle] = [0; 3].map(|_| bus.attach().unwrap());
    assert!(bus.attach().is_none());
    for _ in 0..4 {
        bus.send(a, standard(5, &[]), 0).unwrap();
    }
    assert_eq!(bus.send(a, standard(5, &[]), 0), Err(NotQueued::Full));
    bus.advance(1_000_000);
    bus.send(a, standard(6, &[]), 1_000_000).unwrap();
    bus.advance(2_000_000);
    assert_eq!((bus.overruns(b), bus.overruns(idle)), (1, 1));
    assert_eq!(std::iter::from_fn(|| bus.receive(b)).count(), 4);
}

#[test]
fn listeners_receive_and_detached_nodes_do_not() {
    let mut bus = TestBus::new(500_000);
    let [a, b, monitor, gone] = [0; 4].map(|_| bus.attach().unwrap());
    bus.set_attachment(monitor, Attachment::ListenOnly);
    bus.set_attachment(gone, Attachment::Detached);
    bus.send(gone, standard(0, &[]), 0).unwrap();
    bus.send(monitor, standard(0, &[]), 0).unwrap();
    bus.send(a, standard(5, &[]), 0).unwrap();
    bus.advance(1_000_000);
    assert!(bus.receive(monitor).is_some() && bus.receive(b).is_some());
    assert_eq!(bus.receive(gone), None);
    assert_eq!(bus.statistics().frames, 1);
}

#[test]
fn load_of_periodic_frames() {
    // Ten worst-case frames of 160 bits at most in 50 ms are at most 6.4 % of 500 kbit/s.
    let mut bus = TestBus::new(500_000);
    let [drive, master] = [0; 2].map(|_| bus.attach().unwrap());
    let frame = extended(0x1552_A8C9, &[0x12, 0x34, 0x56, 0x78, 0x9a, 0xbc, 0xde, 0xf0]);
    for k in 0..20u64 {
        for _ in 0..10 {
            bus.send(drive, frame, k * 50_000_000).unwrap();
        }
        bus.advance((k + 1) * 50_000_000);
        while bus.receive(master).is_some() {}
    }
    let statistics = bus.statistics();
    let load = statistics.load_since(&Default::default(), 1_000_000_000);
    let expected = 200.0 * f64::from(frame_bits(&frame)) / 500_000.0;
    assert!((load - expected).abs() < 1e-12, "{load} {expected}");
    assert!(load <= 200.0 * f64::from(worst_case_bits(true, 8)) / 500_000.0);
    println!("load {:.2} %", load * 100.0);
}

proptest! {
    // Frames and their instants do not depend on the steps in which time advances.
    #[test]
    fn steps_do_not_matter(
        sends in prop::collection::vec((0..4usize, 0..1u16 << 11, 0..3_000_000u64), 1..40),
        steps in prop::collection::vec(1..400_000u64, 1..100),
    ) {
        let mut sends = sends;
        sends.sort_by_key(|(_, _, at)| *at);
        let run = |instants: &[u64]| {
            let mut bus = Bus::<5, 64>::new(500_000);
            let nodes = [0; 5].map(|_| bus.attach().unwrap());
            let mut pending = sends.iter().peekable();
            let mut received = Vec::new();
            for now in instants {
                while let Some((node, id, at)) = pending.next_if(|(_, _, at)| at <= now) {
                    bus.send(nodes[*node], standard(*id, &[*node as u8]), *at).unwrap();
                }
                bus.advance(*now);
                received.extend(std::iter::from_fn(|| bus.receive(nodes[4])));
            }
            (received, bus.statistics())
        };
        let mut instants: Vec<u64> = steps.iter().scan(0, |t, step| { *t += step; Some(*t) }).collect();
        instants.push(60_000_000);
        instants.sort_unstable();
        prop_assert_eq!(run(&instants), run(&[60_000_000]));
    }
}
