//! Which legs conduct, told in coordinates in which the circuit falls apart.
//!
//! Whatever legs conduct, their currents sum to zero: two conducting legs leave one free current, three leave
//! two.
//!
//! ```text
//!   i = s along + d across          s = k along . i          d = across . i / 2
//! ```
//!
//! `s` is the DC-link current where some legs are tied to the bus and some to ground, and the only one that
//! the bus sees; `d` is half of the difference of two legs on the same side and decays with L / R on its own.
//! There is one entry for every combination of idle, high and low.

use super::circuit::Leg;
use super::network::Loop;

/// Entries of the table: 27 combinations, and room for an index of five bits.
pub(crate) const COUNT: usize = 32;

/// The coordinates of one combination.
#[derive(Debug)]
pub(crate) struct Wiring {
    /// Its place in the table.
    pub(crate) index: usize,
    /// Legs tied to bus or ground.
    pub(crate) conducting: u8,
    /// Path of their current at the bus: none, two legs or three.
    pub(crate) topology: Loop,
    /// Part of `s` that each leg carries.
    pub(crate) along: [f64; 3],
    /// Part of `d` that each leg carries.
    pub(crate) across: [f64; 3],
    /// 1 / (along . along): 1/2 or 2/3, 0 without a free current.
    pub(crate) k: f64,
    /// Share of the conducting legs that are tied to the bus: the neutral's part of the bus voltage.
    pub(crate) high_share: f64,
    /// 1 / `conducting` for each leg that conducts: the neutral is their mean.
    pub(crate) mean: [f64; 3],
    /// The one leg that does not conduct beside two that do, less their mean; 0 elsewhere.
    pub(crate) aside: [f64; 3],
}

impl Wiring {
    /// The wiring of these legs.
    #[inline]
    pub(crate) fn of(legs: &[Leg; 3]) -> &'static Self {
        let index = legs[0].side() + 3 * legs[1].side() + 9 * legs[2].side();
        // Sides are 0 to 2, so the index is below 27; the mask tells the compiler that it is below 32.
        Self::numbered(index & 31)
    }

    /// The wiring at a place of the table, below [`COUNT`].
    #[inline]
    pub(crate) fn numbered(index: usize) -> &'static Self {
        &TABLE[index]
    }

    /// The coordinate `s` of three currents.
    #[inline]
    pub(crate) fn s_of(&self, i: &[f64; 3]) -> f64 {
        self.k * dot(&self.along, i)
    }

    /// The coordinate `d` of three currents.
    #[inline]
    pub(crate) fn d_of(&self, i: &[f64; 3]) -> f64 {
        0.5 * dot(&self.across, i)
    }

    /// Three currents of their coordinates.
    #[inline]
    pub(crate) fn currents(&self, s: f64, d: f64) -> [f64; 3] {
        let (a, b) = (&self.along, &self.across);
        [s * a[0] + d * b[0], s * a[1] + d * b[1], s * a[2] + d * b[2]]
    }
}

/// Scalar product.
#[inline]
pub(crate) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Sides as [`Leg::side`] numbers them.
const HIGH: usize = 1;
const LOW: usize = 2;

static TABLE: [Wiring; COUNT] = table();

const fn table() -> [Wiring; COUNT] {
    let mut table = [const { wiring(0, [0; 3]) }; COUNT];
    let mut index = 0;
    while index < 27 {
        table[index] = wiring(index, [index % 3, index / 3 % 3, index / 9]);
        index += 1;
    }
    table
}

const fn wiring(index: usize, sides: [usize; 3]) -> Wiring {
    let (mut high, mut low) = (0u8, 0u8);
    let mut x = 0;
    while x < 3 {
        match sides[x] {
            HIGH => high += 1,
            LOW => low += 1,
            _ => {}
        }
        x += 1;
    }
    let conducting = high + low;
    let (mut mean, mut aside) = ([0.0; 3], [0.0; 3]);
    x = 0;
    while x < 3 {
        if sides[x] != 0 {
            mean[x] = 1.0 / conducting as f64;
        }
        if conducting == 2 {
            aside[x] = if sides[x] == 0 { 1.0 } else { -0.5 };
        }
        x += 1;
    }
    let (along, across) = free_currents(sides, high, low);
    Wiring {
        index,
        conducting,
        topology: match (high, low) {
            (0, _) | (_, 0) => Loop::Open,
            (1, 1) => Loop::TwoLegs,
            _ => Loop::ThreeLegs,
        },
        along,
        across,
        k: match conducting {
            0 | 1 => 0.0,
            2 => 0.5,
            _ => 2.0 / 3.0,
        },
        high_share: if conducting == 0 { 0.0 } else { high as f64 / conducting as f64 },
        mean,
        aside,
    }
}

/// `along` and `across`. A leg that is alone on its side comes first; its current, or minus that of one on
/// the low side, is `s`.
const fn free_currents(sides: [usize; 3], high: u8, low: u8) -> ([f64; 3], [f64; 3]) {
    let (mut along, mut across) = ([0.0; 3], [0.0; 3]);
    if high + low < 2 {
        return (along, across);
    }
    // Alone on the high side, else alone on the low side, else (all on one side) any that conducts.
    let wanted = if high == 1 || low == 0 { HIGH } else { LOW };
    let mut first = 0;
    while sides[first] != wanted {
        first += 1;
    }
    let sign = if wanted == LOW && high > 0 { -1.0 } else { 1.0 };
    let (y, z) = ((first + 1) % 3, (first + 2) % 3);
    along[first] = sign;
    if high + low == 2 {
        let other = if sides[y] != 0 { y } else { z };
        along[other] = -sign;
    } else {
        along[y] = -0.5 * sign;
        along[z] = -0.5 * sign;
        across[y] = 1.0;
        across[z] = -1.0;
    }
    (along, across)
}
