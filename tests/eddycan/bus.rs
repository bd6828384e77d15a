//! Tests of the driver's computation of frame lengths against the bus model's, whose frames are laid out bit
//! by bit.

use crate::bench::BITRATES;
use narx_core::bus::eddycan::{CobId, FromNode, Layout, PdoKind, Position, Reading};
use narx_sim::can::{frame_bits, worst_case_bits};
use proptest::prelude::*;

#[test]
fn longest_frames_are_those_of_the_bus() {
    for (bitrate, bits_per_second) in BITRATES {
        for bytes in 0..=8 {
            let bits = worst_case_bits(false, bytes);
            assert_eq!(bitrate.longest_frame_us(bytes) * (bits_per_second / 1000), bits * 1000);
        }
    }
}

proptest! {
    /// No PDO takes longer than computed, with any content: so half of the bus is never exceeded.
    #[test]
    fn no_pdo_is_longer(first: i32, second: i32, encoder: u16, node in 1..=127_u8, layout in 0..4_usize) {
        let layout = Layout::ALL[layout];
        let reading = Reading { positions: [first, second].map(Position::from_raw), encoder };
        let frame = FromNode::Pdo { kind: PdoKind::Timer, reading }.encode(crate::bench::node(node), layout);
        prop_assert_eq!(CobId::decode(frame.id()).is_ok(), true);
        prop_assert!(frame_bits(&frame) <= worst_case_bits(false, layout.length()));
    }
}
