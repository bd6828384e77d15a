//! Tests of the filters against exact exponentials.

use crate::bench::{Bench, RATE, mm};
use narx_core::bus::eddycan::{Channels, FromNode, NmtState, Position, ToNode};
use narx_core::eddycan::{Entry, Sample};
use proptest::prelude::*;

/// Edge frequencies (Table 9), Hz.
const EDGES: [(u32, f64); 4] = [(1, 10.0), (2, 100.0), (3, 1000.0), (4, 10_000.0)];

/// Gives a sample to the driver; returns both positions from a PDO.
fn filtered(bench: &mut Bench, positions: [i32; 2]) -> [i32; 2] {
    bench.driver.handle_sample(Sample { positions: positions.map(Position::from_raw), counter: 0 });
    bench.send(ToNode::Sync);
    match bench.messages().as_slice() {
        [FromNode::Pdo { reading, .. }] => reading.positions.map(Position::raw),
        other => panic!("{other:?}"),
    }
}

/// A driver in Operational with this as its first sample.
fn bench(channels: Channels, values: &[(Entry, u32)], first: i32) -> Bench {
    let mut bench = Bench::dark(channels, values);
    bench.enter(NmtState::Operational);
    assert_eq!(filtered(&mut bench, [first; 2])[0], first, "the first sample passes");
    bench
}

#[test]
fn without_a_filter_every_sample_passes() {
    let mut bench = bench(Channels::Dual, &[], 0);
    for positions in [[i32::MAX, i32::MIN], [i32::MIN, i32::MAX], [1, -1], [0, 0]] {
        assert_eq!(filtered(&mut bench, positions), positions);
    }
}

/// A filter answers a step of 1 mm with y(t) = 1 - exp(-2 pi f t), to 3 steps of 2^-27 mm and the
/// coefficient's seven digits.
#[test]
fn answer_to_a_step() {
    for (index, edge) in EDGES {
        let mut bench = bench(Channels::Single, &[(Entry::Filter1, index)], 0);
        for sample in 1..=2 * RATE {
            let [found, _] = filtered(&mut bench, [mm(1).raw(); 2]);
            let time = f64::from(sample) / f64::from(RATE);
            let exact = f64::from(1 << 27) * (1.0 - (-std::f64::consts::TAU * edge * time).exp());
            assert!((f64::from(found) - exact).abs() < 15.0, "{edge} Hz, {sample}: {found}, exactly {exact}");
        }
        assert_eq!(filtered(&mut bench, [mm(1).raw(); 2])[0], mm(1).raw(), "{edge} Hz: it arrives");
    }
}

/// A sine at the edge frequency is attenuated to 1 / sqrt(2) where samples are dense; within 0.5 % for the
/// sampled filter.
#[test]
fn three_decibels_at_the_edge() {
    for (index, edge) in [EDGES[0], EDGES[1]] {
        let mut bench = bench(Channels::Single, &[(Entry::Filter1, index)], 0);
        let period = f64::from(RATE) / edge;
        let amplitude = f64::from(1 << 27);
        let mut peak = 0;
        for sample in 0..(period * 8.0) as u32 {
            let phase = std::f64::consts::TAU * f64::from(sample) / period;
            let [found, _] = filtered(&mut bench, [(amplitude * phase.sin()) as i32; 2]);
            if f64::from(sample) > period * 6.0 {
                peak = peak.max(found);
            }
        }
        let gain = f64::from(peak) / amplitude;
        assert!((gain - 0.5_f64.sqrt()).abs() < 0.005 * gain, "{edge} Hz: {gain}");
    }
}

#[test]
fn each_channel_has_its_own() {
    let mut bench = bench(Channels::Dual, &[(Entry::Filter2, 1)], 0);
    let [first, second] = filtered(&mut bench, [1 << 27; 2]);
    assert_eq!(first, 1 << 27);
    assert!(second > 0 && second < 1 << 20, "{second}");
}

/// The filter of a missing channel has no effect.
#[test]
fn the_second_filter_of_one_channel_has_no_effect() {
    let mut bench = bench(Channels::Single, &[(Entry::Filter2, 1)], 0);
    assert_eq!(filtered(&mut bench, [1 << 27; 2]), [1 << 27, 0]);
}

/// The outputs follow the filtered position, not the raw sample.
#[test]
fn comparators_see_the_filtered_position() {
    let mut bench = bench(Channels::Single, &[(Entry::Filter1, 1)], 0);
    filtered(&mut bench, [mm(4).raw(); 2]);
    assert_eq!(bench.driver.outputs(), [false, false]);
}

/// A written filter goes on from the present output, and acts with the next sample; so does switching it off.
#[test]
fn a_change_makes_no_jump() {
    let mut bench = bench(Channels::Single, &[], mm(1).raw());
    let write = |bench: &mut Bench, index| {
        bench.enter(NmtState::PreOperational);
        bench.put(Entry::Filter1, index);
        bench.enter(NmtState::Operational);
    };
    write(&mut bench, 1);
    assert_eq!(filtered(&mut bench, [mm(1).raw(); 2])[0], mm(1).raw());
    let [found, _] = filtered(&mut bench, [mm(2).raw(); 2]);
    assert!(found > mm(1).raw() && found < mm(1).raw() + (1 << 20), "{found}");
    write(&mut bench, 0);
    assert_eq!(filtered(&mut bench, [mm(2).raw(); 2])[0], mm(2).raw());
}

proptest! {
    /// The output never leaves the range of its input, for any input, and at rest equals it.
    #[test]
    fn between_old_and_new(index in 0..5_u32, samples in prop::collection::vec(any::<i32>(), 1..50)) {
        let mut bench = bench(Channels::Single, &[(Entry::Filter1, index)], samples[0]);
        let mut before = samples[0];
        for sample in samples {
            let [found, _] = filtered(&mut bench, [sample; 2]);
            prop_assert!(found >= before.min(sample) && found <= before.max(sample));
            before = found;
        }
    }
}
