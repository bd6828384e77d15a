//! The self-tests against memories and clocks that are broken in every way they claim to find.

use narx_board::self_test::clock::{TickMonitor, Tolerance, agree};
use narx_board::self_test::march::{Cells, march, march_keeping};
use narx_board::self_test::walk::Walk;
use proptest::prelude::*;

/// Defect of a memory.
#[derive(Clone, Copy, Debug)]
enum Defect {
    None,
    /// A bit keeps its value.
    Stuck {
        word: usize,
        bit: u32,
        at: bool,
    },
    /// A bit does not follow in one direction.
    Lazy {
        word: usize,
        bit: u32,
        rising: bool,
    },
    /// A bit that changes turns another.
    Inverts {
        word: usize,
        bit: u32,
        victim: usize,
    },
    /// A bit that changes so sets another.
    Sets {
        word: usize,
        bit: u32,
        rising: bool,
        victim: usize,
        to: bool,
    },
    /// An address leads to another's word.
    Alias {
        word: usize,
        other: usize,
    },
    /// An address leads to its own word and another's.
    Both {
        word: usize,
        other: usize,
    },
}

#[derive(Clone)]
struct Memory {
    words: Vec<u32>,
    defect: Defect,
}

impl Memory {
    fn new(words: usize, defect: Defect) -> Self {
        Self { words: (0..words as u32).map(|word| word.wrapping_mul(0x9E37_79B9)).collect(), defect }
    }

    fn put(&mut self, index: usize, value: u32) {
        let before = self.words[index];
        let rises = |bit: u32| (before >> bit & 1, value >> bit & 1);
        self.words[index] = value;
        match self.defect {
            Defect::Stuck { word, bit, at } if word == index => {
                self.words[index] = value & !(1 << bit) | u32::from(at) << bit;
            }
            Defect::Lazy { word, bit, rising }
                if word == index && rises(bit) == (u32::from(!rising), u32::from(rising)) =>
            {
                self.words[index] = value & !(1 << bit) | before & 1 << bit;
            }
            Defect::Inverts { word, bit, victim } if word == index && rises(bit).0 != rises(bit).1 => {
                self.words[victim] ^= 1 << bit;
            }
            Defect::Sets { word, bit, rising, victim, to }
                if word == index && rises(bit) == (u32::from(!rising), u32::from(rising)) =>
            {
                self.words[victim] = self.words[victim] & !(1 << bit) | u32::from(to) << bit;
            }
            _ => {}
        }
    }
}

impl Cells for Memory {
    fn len(&self) -> usize {
        self.words.len()
    }

    fn read(&self, index: usize) -> u32 {
        match self.defect {
            Defect::Alias { word, other } if word == index => self.words[other],
            Defect::Both { word, other } if word == index => self.words[word] & self.words[other],
            Defect::Stuck { word, bit, at } if word == index => {
                self.words[index] & !(1 << bit) | u32::from(at) << bit
            }
            _ => self.words[index],
        }
    }

    fn write(&mut self, index: usize, value: u32) {
        match self.defect {
            Defect::Alias { word, other } if word == index => self.put(other, value),
            Defect::Both { word, other } if word == index => {
                self.put(word, value);
                self.put(other, value);
            }
            _ => self.put(index, value),
        }
    }
}

const WORDS: usize = 16;

fn defects() -> impl Strategy<Value = Defect> {
    let two = (0..WORDS, 1..WORDS).prop_map(|(word, away)| (word, (word + away) % WORDS));
    let bit = 0..32_u32;
    prop_oneof![
        (0..WORDS, bit.clone(), any::<bool>()).prop_map(|(word, bit, at)| Defect::Stuck { word, bit, at }),
        (0..WORDS, bit.clone(), any::<bool>()).prop_map(|(word, bit, rising)| Defect::Lazy {
            word,
            bit,
            rising
        }),
        (two.clone(), bit.clone()).prop_map(|((word, victim), bit)| Defect::Inverts { word, bit, victim }),
        (two.clone(), bit, any::<bool>(), any::<bool>())
            .prop_map(|((word, victim), bit, rising, to)| Defect::Sets { word, bit, rising, victim, to }),
        two.clone().prop_map(|(word, other)| Defect::Alias { word, other }),
        two.prop_map(|(word, other)| Defect::Both { word, other }),
    ]
}

proptest! {
    #[test]
    fn a_march_finds_every_defect(defect in defects()) {
        prop_assert!(!march(&mut Memory::new(WORDS, defect)));
        let mut kept = [0; WORDS];
        prop_assert!(!march_keeping(&mut Memory::new(WORDS, defect), &mut kept));
    }

    #[test]
    fn a_memory_in_use_is_as_before(words in 0_usize..70, block in 1_usize..20) {
        let mut memory = Memory::new(words, Defect::None);
        let before = memory.words.clone();
        prop_assert!(march_keeping(&mut memory, &mut vec![0; block]));
        prop_assert_eq!(memory.words, before);
    }

    #[test]
    fn a_walk_finds_a_flipped_bit_within_its_round(length in 1_usize..600, place in any::<prop::sample::Index>(), bit in 0..8, step in 1_usize..80) {
        let program: Vec<u8> = (0..length).map(|at| (at * 7) as u8).collect();
        let mut broken = program.clone();
        broken[place.index(length)] ^= 1_u8 << bit;
        let steps = length.div_ceil(step);
        let mut walk = Walk::new(&program);
        prop_assert!((0..3 * steps).all(|_| walk.step(&program, step)));
        prop_assert!((1..steps).all(|_| walk.step(&broken, step)), "not before the end of the round");
        prop_assert!(!walk.step(&broken, step));
        prop_assert!(!walk.step(&program, step), "and it stays so");
    }
}

const TOLERANCE: Tolerance = Tolerance { slow: 20, fast: 10 };

#[test]
fn two_clocks_agree_within_their_tolerance() {
    // Counts at 10 kHz beside 50 000 counts at 50 kHz.
    for (counts, agrees) in
        [(9_798, false), (9_799, true), (10_000, true), (10_101, true), (10_102, false), (0, false)]
    {
        assert_eq!(agree(counts, 10_000, 50_000, 50_000, TOLERANCE), agrees, "{counts}");
        assert_eq!(
            agree(counts, 10_000, 32, 32, TOLERANCE),
            (9_488..=10_413).contains(&counts),
            "{counts}: a coarse clock"
        );
    }
    assert!(agree(0, 10_000, 5_000, 1_000, Tolerance { slow: 1000, fast: 0 }), "any slowness");
}

proptest! {
    /// Against the definition in 128 bits: over all that its arguments can say there is nothing that 64 do
    /// not hold.
    #[test]
    fn clocks_of_any_rates_are_compared_exactly(
        counts in ends_and_between(u32::MAX), rate in ends_and_between(u16::MAX),
        other_rate in ends_and_between(u16::MAX), off in -2_000_i64..2_000,
        slow in ends_and_between(u16::MAX), fast in ends_and_between(u16::MAX),
    ) {
        // Mostly near the borders, where an error would show.
        let nominal = i64::from(counts) * i64::from(other_rate) / i64::from(rate.max(1));
        for other_counts in [nominal + nominal / 1000 * off, nominal + off, i64::from(counts)] {
            let other_counts = other_counts.clamp(0, u32::MAX.into()) as u32;
            let expected = u128::from(other_counts) * u128::from(rate);
            let phase = 1000 * u128::from(rate.max(other_rate));
            let slowest = (expected * u128::from(1000_u16.saturating_sub(slow))).saturating_sub(phase);
            let fastest = expected * u128::from(fast.saturating_add(1000)) + phase;
            let passed = u128::from(counts) * u128::from(other_rate) * 1000;
            let tolerance = Tolerance { slow, fast };
            prop_assert_eq!(agree(counts, rate, other_counts, other_rate, tolerance), (slowest..=fastest).contains(&passed));
        }
    }
}

/// Any number up to this one, and the ends more often than chance would have them.
fn ends_and_between<T: Copy + From<u8> + std::fmt::Debug + 'static>(max: T) -> impl Strategy<Value = T>
where
    std::ops::RangeInclusive<T>: Strategy<Value = T>,
{
    prop_oneof![1 => Just(max), 1 => Just(T::from(0)), 6 => T::from(0)..=max]
}

#[test]
fn ticks_that_come_too_seldom_or_too_often_are_found_within_two_windows() {
    // Each: ticks a millisecond from 1 s on, and whether that is found.
    for (ticks, is_found) in [(10, false), (9, true), (11, true), (0, true), (20, true)] {
        let start = u32::MAX - 1_500;
        let mut monitor = TickMonitor::new(10_000, 1_000, TOLERANCE, 500, start);
        let mut now = 0;
        let steady: Vec<bool> = (1..=3_000_u32)
            .map(|ms| {
                now += if ms <= 1_000 { 10 } else { ticks };
                monitor.step(now, start.wrapping_add(ms))
            })
            .collect();
        assert!(steady[..1_000].iter().all(|steady| *steady), "{ticks}");
        assert_eq!(!steady[1_999], is_found, "{ticks}");
        assert_eq!(!steady[2_999], is_found, "{ticks}: and it stays so");
    }
}
