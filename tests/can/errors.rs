//! Tests of disturbed frames, single nodes, wrong bitrates, and the error counters.

use crate::frames::standard;
use narx_sim::can::{Bus, ErrorState, frame_bits};

type TestBus = Bus<4, 64>;
const BIT_NS: u64 = 2_000;

#[test]
fn a_disturbed_frame_is_sent_again() {
    let mut bus = TestBus::new(500_000);
    let [a, b] = [0; 2].map(|_| bus.attach().unwrap());
    let frame = standard(0x123, &[1, 2, 3]);
    bus.inject_errors(2, 20);
    bus.send(a, frame, 0).unwrap();
    bus.advance(10_000_000);
    let received = bus.receive(b).unwrap();
    // Twice: 21 bits, flag 6 + 6, delimiter 8, intermission 3.
    let retries = 2 * (21 + 12 + 8 + 3);
    assert_eq!(received.time_ns, u64::from(retries + frame_bits(&frame) - 3) * BIT_NS);
    assert_eq!(bus.receive(b), None);
    assert_eq!((bus.statistics().frames, bus.statistics().errors), (1, 2));
    assert_eq!(bus.error_counters(a), Some((2 * 8 - 1, 0)));
    assert_eq!(bus.error_counters(b), Some((0, 2 - 1)));
}

#[test]
fn a_lone_node_turns_passive_and_keeps_trying() {
    let mut bus = TestBus::new(500_000);
    let a = bus.attach().unwrap();
    bus.send(a, standard(0x123, &[1]), 0).unwrap();
    bus.advance(100_000_000);
    assert_eq!(bus.error_state(a), Some(ErrorState::Passive));
    assert_eq!(bus.error_counters(a), Some((128, 0)));
    assert_eq!(bus.statistics().frames, 0);
    // A second node is connected: the frame arrives.
    let b = bus.attach().unwrap();
    bus.advance(101_000_000);
    assert!(bus.receive(b).unwrap().time_ns > 100_000_000);
    assert_eq!(bus.queued(a), 0);
}

#[test]
fn thirty_two_errors_lead_to_bus_off_and_it_recovers() {
    let mut bus = TestBus::new(500_000);
    let [a, b] = [0; 2].map(|_| bus.attach().unwrap());
    bus.inject_errors(32, 0);
    bus.send(a, standard(0x123, &[1]), 0).unwrap();
    while bus.statistics().errors < 32 {
        bus.advance(bus.next_event().unwrap());
    }
    let off_since = bus.next_event().unwrap() - 128 * 11 * BIT_NS;
    assert_eq!(bus.error_state(a), Some(ErrorState::BusOff));
    bus.advance(off_since + 128 * 11 * BIT_NS - 1);
    assert_eq!(bus.error_state(a), Some(ErrorState::BusOff));
    bus.advance(off_since + 2 * 128 * 11 * BIT_NS);
    assert_eq!(bus.error_state(a), Some(ErrorState::Active));
    assert!(bus.receive(b).is_some());
}

/// A node recovers from bus-off on a bus that others fill: the ends of frames have the required 11 recessive
/// bits.
#[test]
fn a_full_bus_lets_a_node_recover_after_128_frames() {
    let mut bus = TestBus::new(500_000);
    let [a, b, c] = [0; 3].map(|_| bus.attach().unwrap());
    bus.inject_errors(32, 0);
    bus.send(a, standard(0, &[1]), 0).unwrap();
    while bus.error_state(a) != Some(ErrorState::BusOff) {
        bus.advance(bus.next_event().unwrap());
    }
    let before = bus.statistics().frames;
    let begin = bus.next_event().unwrap() - 128 * 11 * BIT_NS;
    for _ in 0..40 {
        bus.send(b, standard(0x123, &[1; 8]), 0).unwrap();
    }
    while bus.error_state(a) == Some(ErrorState::BusOff) {
        assert!(bus.statistics().frames - before <= 128, "it never recovers");
        if bus.queued(b) < 8 {
            bus.send(b, standard(0x123, &[1; 8]), 0).unwrap();
        }
        bus.advance(bus.next_event().unwrap());
        while bus.receive(c).is_some() {}
    }
    assert_eq!(bus.statistics().frames - before, 128);
    let length = u64::from(frame_bits(&standard(0x123, &[1; 8]))) * BIT_NS;
    assert!(bus.next_event().unwrap() >= begin + 128 * length, "far longer than on an idle bus");
}

#[test]
fn what_is_taken_back_is_not_sent() {
    let mut bus = TestBus::new(500_000);
    let [a, b] = [0; 2].map(|_| bus.attach().unwrap());
    for byte in 0..3 {
        bus.send(a, standard(5, &[byte]), 0).unwrap();
    }
    // The first frame is on the wire and stays.
    bus.advance(10_000);
    bus.discard(a);
    bus.advance(10_000_000);
    assert_eq!(bus.receive(b).map(|received| received.frame), Some(standard(5, &[0])));
    assert_eq!((bus.receive(b), bus.queued(a)), (None, 0));
}

#[test]
fn one_identifier_for_two_is_an_error() {
    let mut bus = TestBus::new(500_000);
    let [a, b, c] = [0; 3].map(|_| bus.attach().unwrap());
    bus.send(a, standard(5, &[0]), 0).unwrap();
    bus.send(b, standard(5, &[1]), 0).unwrap();
    bus.advance(1_000_000);
    assert!(bus.statistics().errors > 0);
    assert_eq!(bus.receive(c), None);
}

#[test]
fn a_node_at_a_wrong_bitrate() {
    // While it listens, it destroys frames until its error flags no longer count; then the bus runs without
    // it.
    let mut bus = TestBus::new(500_000);
    let [a, b, foreign] = [0; 3].map(|_| bus.attach().unwrap());
    bus.set_bitrate(foreign, 250_000);
    for _ in 0..30 {
        bus.send(a, standard(5, &[7; 8]), 0).unwrap();
    }
    bus.advance(1_000_000_000);
    assert_eq!(bus.receive(foreign), None);
    assert_eq!(bus.error_state(foreign), Some(ErrorState::Passive));
    assert_eq!(std::iter::from_fn(|| bus.receive(b)).count(), 30);
    assert!(bus.statistics().errors >= 32, "{:?}", bus.statistics());

    // When it sends, it goes bus-off.
    bus.send(foreign, standard(0, &[]), 1_000_000_000).unwrap();
    let before = bus.statistics();
    while bus.error_state(foreign) != Some(ErrorState::BusOff) {
        bus.advance(bus.next_event().unwrap());
    }
    assert_eq!(bus.statistics().frames, before.frames);
}
