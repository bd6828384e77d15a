//! A low-pass of first order: y += (x - y) (1 - exp(-2 pi f / rate)), whose answer to a step is exact at
//! every rate.

/// 1.
const ONE: u64 = 1 << 32;
/// 2 pi.
const TAU: u64 = 26_986_075_409;

/// One channel's filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Filter {
    /// 1 - exp(-2 pi f / rate), 2^-32; 1 without a filter.
    coefficient: u64,
    /// Output, 2^-32 of a position's step; `None` before the first sample.
    output: Option<i64>,
}

impl Filter {
    /// Without an edge frequency every sample passes.
    pub(super) const fn new() -> Self {
        Self { coefficient: ONE, output: None }
    }

    /// Sets the edge frequency and the rate of the samples, Hz. The output goes on from where it is.
    pub(super) fn set_edge(&mut self, edge: Option<u32>, rate: u32) {
        self.coefficient = edge.map_or(ONE, |edge| coefficient(edge, rate));
    }

    /// Takes a sample and answers the output. The first sample passes as it is.
    pub(super) fn step(&mut self, input: i32) -> i32 {
        let input = i64::from(input) << 32;
        let output = self.output.unwrap_or(input);
        let distance = i128::from(input) - i128::from(output);
        // Between output and input, because the coefficient is at most 1.
        let moved = (i128::from(output) + ((distance * i128::from(self.coefficient)) >> 32)) as i64;
        self.output = Some(moved);
        // To the nearest: an output that creeps towards its input from below arrives. Below the largest
        // position by half a step it cannot wrap.
        (moved.saturating_add(1 << 31) >> 32) as i32
    }
}

/// 1 - exp(-2 pi f / rate).
fn coefficient(edge: u32, rate: u32) -> u64 {
    // From exp(-32) on nothing is left in 32 bits.
    let mut x = (TAU * u64::from(edge) / u64::from(rate.max(1))).min(32 * ONE);
    let mut doublings = 0;
    while x > ONE / 16 {
        x /= 2;
        doublings += 1;
    }
    let square = (x * x) >> 32;
    let cube = (square * x) >> 32;
    let fourth = (cube * x) >> 32;
    let mut rise = x - square / 2 + cube / 6 - fourth / 24;
    for _ in 0..doublings {
        // 1 - exp(-2x) = (1 - exp(-x)) (1 + exp(-x))
        rise = ((u128::from(rise) * u128::from(2 * ONE - rise)) >> 32) as u64;
    }
    rise
}
