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

    /// Close to Gaussian, mean 0, standard deviation 1, never beyond +-3.45.
    pub fn gaussian(&mut self) -> f64 {
        self.gaussians()[0]
    }

    /// Two such numbers of one draw: each the sum of four uniform bytes (variance 4/12 before scaling), in steps of 0.007,
    /// because a logarithm costs more than it tells here.
    #[inline]
    pub fn gaussians(&mut self) -> [f64; 2] {
        const SQRT_3: f64 = 1.732_050_807_568_877_2;
        const ODD_BYTES: u64 = 0x00FF_00FF_00FF_00FF;
        let bits = self.bits();
        // Four sums of two bytes each, then two of four.
        let pairs = (bits & ODD_BYTES) + (bits >> 8 & ODD_BYTES);
        let sums = pairs + (pairs >> 16);
        // A conversion from 32 bits is one instruction.
        [sums as u32 & 0xFFFF, (sums >> 32) as u32 & 0xFFFF]
            .map(|sum| (f64::from(sum as i32) - (512.0 - 2.0)) * (SQRT_3 / 256.0))
    }
}
