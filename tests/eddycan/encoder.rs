//! Tests of the encoder's value: linear and rotary, both directions, reset, and the ends of its sixteen bits.

use crate::bench::{Bench, mm};
use narx_core::bus::eddycan::{Channels, FromNode, NmtState, SdoAction, SdoOutcome, ToNode};
use narx_core::eddycan::{Entry, Sample};
use proptest::prelude::*;

const ROTARY: u32 = 2;
const REVERSE: u32 = 4;

/// A driver whose PDOs carry the encoder; its counter begins at `counter`.
fn bench(register: u32, counts: u32, counter: u16) -> Bench {
    let values =
        [(Entry::CanConfig, 2), (Entry::BasicConfig, register), (Entry::CountsPerRevolution, counts)];
    let mut bench = Bench::dark(Channels::Single, &values);
    count(&mut bench, counter);
    bench
}

fn count(bench: &mut Bench, counter: u16) {
    bench.driver.handle_sample(Sample { positions: [mm(0); 2], counter });
}

/// Encoder value in a PDO; the node is Pre-Operational before and after.
fn told(bench: &mut Bench) -> u16 {
    bench.enter(NmtState::Operational);
    bench.send(ToNode::Sync);
    let messages = bench.messages();
    bench.enter(NmtState::PreOperational);
    match messages.as_slice() {
        [FromNode::Pdo { reading, .. }] => reading.encoder,
        other => panic!("{other:?}"),
    }
}

fn reset(bench: &mut Bench) {
    assert_eq!(bench.write(0x200A, 0, 0), SdoOutcome::Written);
}

#[test]
fn the_place_at_power_up_is_0_whatever_the_counter_says() {
    for counter in [0, 1, 40_000, u16::MAX] {
        assert_eq!(told(&mut bench(0, 4096, counter)), 0);
    }
}

/// Four setups give their values for one walk of the counter, which crosses its own wrap.
#[test]
fn four_setups_of_one_walk() {
    let walk = [65_500_u16, 65_535, 0, 100, 64_000];
    // Counts from the start: 35, 36, 136, -1500.
    for (register, expected) in [
        (0, [0_u16, 35, 36, 136, 0xFA24]),
        (REVERSE, [0, 0xFFDD, 0xFFDC, 0xFF78, 1500]),
        // Of 1000 counts: -1500 is 500.
        (ROTARY, [0, 35, 36, 136, 500]),
        (ROTARY | REVERSE, [0, 965, 964, 864, 500]),
    ] {
        let mut bench = bench(register, 1000, walk[0]);
        for (counter, expected) in walk.into_iter().zip(expected) {
            count(&mut bench, counter);
            assert_eq!(told(&mut bench), expected, "{register} at {counter}");
        }
    }
}

/// An overrun stays at the end of the range and comes back with the encoder; a reset sets the position to 0
/// (section 3.3.2).
#[test]
fn a_linear_encoder_stops_at_the_ends() {
    for (register, up, end, begin) in
        [(0, true, 0x7FFF, 0x8000_u16), (REVERSE, true, 0x8000, 0x7FFF), (0, false, 0x8000, 0x7FFF)]
    {
        let mut bench = bench(register, 4096, 0);
        let mut counter = 0_u16;
        let step = |bench: &mut Bench, counter: &mut u16, up| {
            *counter = if up { counter.wrapping_add(10_000) } else { counter.wrapping_sub(10_000) };
            count(bench, *counter);
        };
        for _ in 0..5 {
            step(&mut bench, &mut counter, up);
        }
        assert_eq!(told(&mut bench), end, "50000 counts");
        step(&mut bench, &mut counter, !up);
        assert_eq!(told(&mut bench), end, "40000 counts");
        step(&mut bench, &mut counter, !up);
        let back = if end == 0x7FFF { 30_000 } else { -30_000_i16 as u16 };
        assert_eq!(told(&mut bench), back);
        for _ in 0..8 {
            step(&mut bench, &mut counter, !up);
        }
        assert_eq!(told(&mut bench), begin, "an underrun likewise");
        reset(&mut bench);
        assert_eq!(told(&mut bench), 0);
        step(&mut bench, &mut counter, true);
        let ten = if register == REVERSE { -10_000_i16 as u16 } else { 10_000 };
        assert_eq!(told(&mut bench), ten);
    }
}

/// The reset accepts any number of data bytes and any of the write commands; a rotary encoder, which cannot
/// overrun, keeps its position.
#[test]
fn reset_is_written_and_not_read() {
    for (register, after) in [(0, 0), (ROTARY, 77)] {
        for size in [None, Some(1), Some(2), Some(3), Some(4)] {
            let mut bench = bench(register, 4096, 0);
            count(&mut bench, 77);
            assert_eq!(told(&mut bench), 77);
            let action = SdoAction::Write { size, data: [0xFF; 4] };
            assert_eq!(bench.ask(0x200A, 0, action), SdoOutcome::Written);
            assert_eq!(told(&mut bench), after);
            assert_eq!(bench.read(0x200A, 0), SdoOutcome::Aborted { code: 0x0601_0001 });
            assert_eq!(bench.driver.poll_store(), None, "nothing of it is stored");
        }
    }
}

proptest! {
    /// Steps of up to half of the counter's range add up, in any sequence.
    #[test]
    fn any_walk(steps in prop::collection::vec(-32_768..=32_767_i32, 1..60), counts in 1..=65_535_u32, reverse: bool) {
        let register = if reverse { REVERSE } else { 0 };
        let mut linear = bench(register, counts, 0);
        let mut rotary = bench(register | ROTARY, counts, 0);
        let (mut counter, mut sum) = (0_u16, 0_i64);
        for step in steps {
            counter = counter.wrapping_add(step as u16);
            sum += i64::from(if reverse { -step } else { step });
            for bench in [&mut linear, &mut rotary] {
                count(bench, counter);
            }
            let expected = sum.clamp(-32_768, 32_767) as i16 as u16;
            prop_assert_eq!(told(&mut linear), expected);
            prop_assert_eq!(i64::from(told(&mut rotary)), sum.rem_euclid(i64::from(counts)));
        }
    }
}
