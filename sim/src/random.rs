//! A small seeded generator: the same seed gives the same numbers on every platform.

/// xorshift64* (Vigna, "An experimental exploration of Marsaglia's xorshift generators, scrambled", 2016).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// A generator for `seed`; any seed is good, 0 too.
    pub const fn new(seed: u64) -> Self {
        // One step of splitmix64 spreads small seeds over all bits and never leaves the state at 0.
        let mut z = seed.wrapping_add(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        Self(if z == 0 { 1 } else { z })
    }

    /// 64 random bits.
    pub const fn bits(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Close to Gaussian, mean 0, standard deviation 1, never beyond +-5.07.
    pub fn gaussian(&mut self) -> f64 {
        self.gaussians()[0]
    }

    /// Two independent ones of one draw. Each takes 32 bits of it: how many of 24 are set (variance 24/4),
    /// and a uniform number of 8 bits that fills the steps between (1/12), because a logarithm costs more
    /// than it tells here.
    #[inline]
    pub fn gaussians(&mut self) -> [f64; 2] {
        const COUNTED: u64 = 0x00FF_FFFF_00FF_FFFF;
        const BYTES: u64 = 0x0101_0101_0101_0101;
        // The square root of 256^2 24/4 + (256^2 - 1)/12.
        const PER_DEVIATION: f64 = 1.0 / 631.408_940_386_497_9;
        let bits = self.bits();
        // The set bits of each byte, then of three bytes in the lowest one of each half.
        let mut count = bits & COUNTED;
        count -= count >> 1 & (0x55 * BYTES);
        count = (count & (0x33 * BYTES)) + (count >> 2 & (0x33 * BYTES));
        count = (count + (count >> 4)) & (0x0F * BYTES);
        count += (count >> 8) + (count >> 16);
        let sample = |half: u32| {
            let (count, fill) = ((count >> half) as u32 & 0xFF, (bits >> (half + 24)) as u32 & 0xFF);
            // A conversion from 32 bits is one instruction.
            (f64::from((count << 8 | fill) as i32) - (12.0 * 256.0 + 127.5)) * PER_DEVIATION
        };
        [sample(0), sample(32)]
    }
}
