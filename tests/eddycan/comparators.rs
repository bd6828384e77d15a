//! Tests of the switching outputs.

use crate::bench::{Bench, mm};
use narx_core::bus::eddycan::{Channels, NmtState, Position};
use narx_core::eddycan::{Configuration, Entry, MeasuringRange, Sample, TxDriver, Variant};
use proptest::prelude::*;

const ONE: u32 = 1 << 30;

fn outputs(bench: &mut Bench, first: Position, second: Position) -> [bool; 2] {
    bench.driver.handle_sample(Sample { positions: [first, second], counter: 0 });
    bench.driver.outputs()
}

/// Half of the range of 0 to 4 mm is 2 mm, and exactly there the output is still low.
#[test]
fn two_channels_have_one_comparator_each() {
    let values = [(Entry::Comparator1, ONE / 2), (Entry::Comparator2, ONE / 4)];
    let mut bench = Bench::new(Channels::Dual, &values);
    let above = |position: Position| Position::from_raw(position.raw() + 1);
    for (first, second, expected) in [
        (mm(0), mm(0), [false, false]),
        (mm(2), mm(1), [false, false]),
        (above(mm(2)), mm(1), [true, false]),
        (mm(2), above(mm(1)), [false, true]),
        (mm(4), mm(4), [true, true]),
        (Position::MAX, Position::MIN, [true, false]),
        (Position::MIN, Position::MAX, [false, true]),
    ] {
        assert_eq!(outputs(&mut bench, first, second), expected, "{first:?} {second:?}");
    }
}

/// A driver of one channel has a low and a high threshold for it; the other position does not count.
#[test]
fn one_channel_has_both() {
    let values = [(Entry::Comparator1, ONE / 4), (Entry::Comparator2, ONE / 4 * 3)];
    let mut bench = Bench::new(Channels::Single, &values);
    for (position, expected) in
        [(0, [false, false]), (1, [false, false]), (2, [true, false]), (4, [true, true])]
    {
        assert_eq!(outputs(&mut bench, mm(position), mm(4 - position)), expected, "{position} mm");
    }
}

/// Each channel is compared within its own range; in a driver of one channel only the first counts.
#[test]
fn ranges_of_their_own() {
    let range = |start, end| MeasuringRange::new(mm(start), mm(end)).unwrap();
    for (channels, expected) in [(Channels::Single, [false, false]), (Channels::Dual, [false, true])] {
        let variant = Variant { ranges: [range(0, 4), range(-8, 0)], ..crate::bench::variant(channels) };
        let mut driver = TxDriver::new(variant, Configuration::new());
        driver.handle_sample(Sample { positions: [mm(1), mm(-2)], counter: 0 });
        assert_eq!(driver.outputs(), expected, "{channels:?}");
    }
}

#[test]
fn ends_of_the_range() {
    let mut bench = Bench::new(Channels::Single, &[(Entry::Comparator1, 0), (Entry::Comparator2, ONE)]);
    for (raw, expected) in [
        (-1, [false, false]),
        (0, [false, false]),
        (1, [true, false]),
        (4 << 27, [true, false]),
        ((4 << 27) + 1, [true, true]),
    ] {
        assert_eq!(outputs(&mut bench, Position::from_raw(raw), mm(0)), expected, "{raw}");
    }
}

/// The outputs work in every network state, and are low before the first sample.
#[test]
fn independent_of_the_network() {
    let mut bench = Bench::dark(Channels::Single, &[(Entry::Comparator1, 0)]);
    assert_eq!(bench.driver.outputs(), [false, false]);
    for state in [NmtState::Stopped, NmtState::Operational, NmtState::PreOperational] {
        bench.enter(state);
        assert_eq!(outputs(&mut bench, mm(3), mm(0)), [true, true]);
        assert_eq!(outputs(&mut bench, mm(-1), mm(0)), [false, false]);
    }
}

#[test]
fn a_written_value_acts_with_the_next_sample() {
    let mut bench = Bench::new(Channels::Single, &[]);
    assert_eq!(outputs(&mut bench, mm(1), mm(0)), [false, false]);
    bench.put(Entry::Comparator1, ONE / 8);
    assert_eq!(outputs(&mut bench, mm(1), mm(0)), [true, false]);
}

proptest! {
    /// The output follows the definition in exact arithmetic: position - start > fraction * range.
    #[test]
    fn any_range_position_and_fraction(start: i32, end: i32, position: i32, fraction in 0..=ONE) {
        let [start, end, position] = [start, end, position].map(Position::from_raw);
        let range = MeasuringRange::new(start, end);
        prop_assert_eq!(range.is_some(), start < end);
        if let Some(range) = range {
            let wide = |position: Position| i128::from(position.raw());
            let left = (wide(position) - wide(start)) * i128::from(ONE);
            let right = (wide(end) - wide(start)) * i128::from(fraction);
            prop_assert_eq!(range.is_above(position, fraction), left > right);
        }
    }
}
