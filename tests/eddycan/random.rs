//! Tests with any frame at any time: no panic, no growth, and no change that must not be.

use crate::bench::{Bench, CHANNELS, STATES};
use narx_core::bus::eddycan::{Channels, NmtState};
use narx_core::bus::{BusState, ErrorState, Frame, Id};
use narx_core::eddycan::{Configuration, Entry, OBJECTS, STORED, Sample};
use proptest::prelude::*;

/// Strategy of frames of every kind, most of them similar to those that the node takes.
fn frames() -> impl Strategy<Value = Frame> {
    let ids = prop_oneof![
        4 => prop::sample::select(vec![0_u16, 0x80, 0x381, 0x601, 0x602, 0x181, 0x701]),
        1 => 0..0x800_u16,
    ];
    let bytes = prop_oneof![
        2 => (prop::sample::select(vec![0x22_u8, 0x40, 0x2B, 0x80, 1, 2, 0x7F]), 0..4_u8, any::<[u8; 4]>())
            .prop_map(|(command, subindex, [a, b, c, d])| vec![command, a % 13, 0x20, subindex, a, b, c, d]),
        2 => prop::collection::vec(0..4_u8, 0..=8),
        1 => prop::collection::vec(any::<u8>(), 0..=8),
    ];
    (ids, bytes, prop::bool::weighted(0.1), prop::bool::weighted(0.1)).prop_map(
        |(id, bytes, remote, extended)| {
            let id = if extended { Id::extended(id.into()) } else { Id::standard(id) }.unwrap();
            if remote { Frame::remote(id, bytes.len() as u8) } else { Frame::data(id, &bytes) }.unwrap()
        },
    )
}

fn valid(configuration: Configuration) -> bool {
    let values = <[u32; STORED]>::from(configuration);
    OBJECTS.iter().zip(values).all(|(row, value)| row.accepts(value))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Only a write changes the configuration, only NMT the state, and only in the states that allow it.
    #[test]
    fn what_each_frame_may_change(state in 0..3_usize, dual: bool, frame in frames()) {
        let mut bench = Bench::in_state(STATES[state], CHANNELS[usize::from(dual)], &[(Entry::CanConfig, 6)]);
        let before = bench.driver.clone();
        bench.give(&frame);
        let id = if frame.id().is_extended() { None } else { Some(frame.id().raw()) };
        let listened = match id {
            Some(0) => !frame.is_remote() && frame.dlc() == 2,
            Some(0x80) => STATES[state] == NmtState::Operational && !frame.is_remote() && frame.dlc() == 0,
            Some(0x381) => STATES[state] == NmtState::Operational && frame.is_remote() && frame.dlc() == before.layout().length(),
            Some(0x601) => STATES[state] != NmtState::Stopped && !frame.is_remote() && frame.dlc() == 8,
            _ => false,
        };
        if !listened {
            prop_assert_eq!(&bench.driver, &before);
        }
        if id != Some(0) {
            prop_assert_eq!(bench.driver.state(), before.state());
        }
        let write = id == Some(0x601)
            && STATES[state] == NmtState::PreOperational
            && [0x22, 0x23, 0x27, 0x2B, 0x2F].contains(&frame.payload().first().copied().unwrap_or(0));
        if !write {
            prop_assert_eq!(bench.driver.configuration(), before.configuration());
        }
        prop_assert!(valid(*bench.driver.configuration()));
        prop_assert_eq!((bench.driver.node(), bench.driver.bitrate()), (before.node(), before.bitrate()));
    }

    /// After any events at most twelve frames wait, all of them of this node, and a restart ends in silence.
    #[test]
    fn any_life(events in prop::collection::vec((frames(), 0..6_u8, any::<u64>(), any::<[i32; 2]>()), 1..60)) {
        let mut bench = Bench::new(Channels::Dual, &[(Entry::UpdateTime, 1)]);
        for (frame, kind, number, positions) in events {
            match kind {
                0 => bench.driver.handle_sample(Sample {
                    positions: positions.map(narx_core::bus::eddycan::Position::from_raw),
                    counter: number as u16,
                }),
                1 => {
                    let error = [ErrorState::Active, ErrorState::Passive, ErrorState::BusOff][(number % 3) as usize];
                    bench.driver.handle_bus_state(BusState { error, ..BusState::default() });
                }
                // Time may take any value, even an earlier one.
                2 => bench.driver.poll(number),
                3 => {
                    let _ = bench.driver.poll_store();
                    bench.driver.handle_store(number % 2 == 0);
                }
                _ => {}
            }
            bench.give(&frame);
            prop_assert!(valid(*bench.driver.configuration()));
            if kind == 5 {
                let frames = bench.frames();
                // Boot-up, three errors, heartbeat, three PDOs, four answers.
                prop_assert!(frames.len() <= 12);
                for frame in frames {
                    prop_assert_eq!(frame.id().raw() & 0x7F, 1);
                    prop_assert!(!frame.is_remote() && !frame.id().is_extended());
                }
                if bench.driver.take_reset() {
                    prop_assert_eq!(bench.frames(), []);
                }
            }
        }
    }
}
