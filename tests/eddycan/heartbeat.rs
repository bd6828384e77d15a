//! Tests of boot-up and heartbeat.

use crate::bench::{Bench, STATES, configured, frame, variant};
use narx_core::bus::Frame;
use narx_core::bus::eddycan::{Channels, NmtState};
use narx_core::eddycan::{Entry, TxDriver};

/// Heartbeats within a time, polled every millisecond: time and state of each.
fn heartbeats(bench: &mut Bench, milliseconds: u64) -> Vec<(u64, u8)> {
    let mut found = Vec::new();
    for _ in 0..milliseconds {
        for frame in bench.wait(1000) {
            if frame.id().raw() == 0x701 {
                assert_eq!(frame.dlc(), 1);
                found.push((bench.now, frame.payload()[0]));
            }
        }
    }
    found
}

/// The boot-up message comes first and once in every configuration, as in Table 12.
#[test]
fn boot_up_comes_once_and_first() {
    for register in 0..8 {
        let configuration = configured(&[(Entry::CanConfig, register), (Entry::NodeId, 99)]);
        let mut driver = TxDriver::new(variant(Channels::Single), configuration);
        driver.poll(5);
        let frames: Vec<Frame> = std::iter::from_fn(|| driver.poll_frame()).collect();
        let state = |state: u8| frame(0x700 + 99, &[state]);
        // With autostart and heartbeat the state follows at once, else other nodes would assume
        // Pre-Operational for 2 s.
        let expected = if register & 5 == 5 { vec![state(0), state(5)] } else { vec![state(0)] };
        assert_eq!(frames, expected, "{register}");
    }
}

#[test]
fn every_two_seconds_in_every_state() {
    for state in STATES {
        let mut bench = Bench::in_state(state, Channels::Single, &[(Entry::CanConfig, 4)]);
        let start = bench.now;
        let expected: Vec<(u64, u8)> = (1..=5).map(|n| (start + n * 2_000_000, state as u8)).collect();
        assert_eq!(heartbeats(&mut bench, 10_500), expected);
    }
}

#[test]
fn none_unless_configured() {
    for register in [0, 1, 2, 3] {
        let mut bench = Bench::new(Channels::Single, &[(Entry::CanConfig, register)]);
        assert_eq!(heartbeats(&mut bench, 5000), []);
    }
}

#[test]
fn configured_at_run_time_and_late() {
    let mut bench = Bench::new(Channels::Single, &[]);
    assert_eq!(heartbeats(&mut bench, 3000), []);
    bench.put(Entry::CanConfig, 4);
    assert_eq!(heartbeats(&mut bench, 1500).len(), 1, "within 2 s");
    let late = bench.wait(7_000_000);
    assert_eq!(late.len(), 1, "what was missed is not made up for");
    assert_eq!(bench.wait(1), []);
    assert_eq!(heartbeats(&mut bench, 2000).len(), 1);
    bench.put(Entry::CanConfig, 0);
    assert_eq!(heartbeats(&mut bench, 5000), []);
}

#[test]
fn it_tells_the_state_of_the_moment_it_is_sent() {
    let mut bench = Bench::new(Channels::Single, &[(Entry::CanConfig, 4)]);
    bench.now += 2_000_000;
    bench.driver.poll(bench.now);
    bench.enter(NmtState::Stopped);
    assert_eq!(bench.frames(), [frame(0x701, &[4])]);
}
