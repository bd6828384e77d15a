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

    /// Close to Gaussian, mean 0, standard deviation 1, never beyond +-3.47: the sum of four uniform 16-bit
    /// numbers of one draw (variance 4/12 before scaling), because a logarithm costs more than it tells here.
    pub fn gaussian(&mut self) -> f64 {
        const SQRT_3: f64 = 1.732_050_807_568_877_2;
        let bits = self.bits();
        let sum = (bits & 0xFFFF) + ((bits >> 16) & 0xFFFF) + ((bits >> 32) & 0xFFFF) + (bits >> 48);
        // Below 2^18: a conversion from 32 bits is one instruction.
        (f64::from(sum as u32) * (1.0 / 65_536.0) - (2.0 - 2.0 / 65_536.0)) * SQRT_3
    }
}
