//! Proportional-integral controller with back-calculation: `u = Kp e + integral of Ki e dt`.

use crate::motor::gain::Gain;
use crate::units::saturate64;
use serde::{Deserialize, Serialize};

/// Largest proportional part: 2^15 volts with 16 + 16 fraction bits, far above any output, far below
/// overflow.
const HEADROOM: i64 = 1 << 47;

/// Less than that, by the upper word.
#[inline]
const fn is_small(part: i64) -> bool {
    const HIGH: i32 = (HEADROOM >> 32) as i32;
    let high = (part >> 32) as i32;
    -HIGH <= high && high < HIGH
}

/// Gains of a PI controller, built for one step rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct PiGains {
    /// Output per error.
    pub proportional: Gain,
    /// Output per error and step: Ki x step time.
    pub integral: Gain,
}

/// State of a PI controller. Error and output are raw I16F16; the integrator has 16 fraction bits more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pi {
    integrator: i64,
}

impl Pi {
    /// The output for `error`, within `minimum..=maximum`. The integrator never holds more than brings the
    /// output to one of them.
    #[inline]
    pub fn step(&mut self, gains: &PiGains, error: i32, minimum: i32, maximum: i32) -> i32 {
        let (low, high) = (i64::from(minimum) << 16, i64::from(maximum.max(minimum)) << 16);
        let proportional = gains.proportional.apply_extended(error);
        let integral = gains.integral.apply_extended(error);
        // Most steps come nowhere near a limit.
        let integrator = self.integrator.wrapping_add(integral);
        let output = integrator.wrapping_add(proportional);
        let within = |value: i64| low <= value && value <= high;
        if is_small(proportional) && is_small(integral) && within(integrator) && within(output) {
            self.integrator = integrator;
            return (output >> 16) as i32;
        }
        let proportional = proportional.clamp(-HEADROOM, HEADROOM);
        self.integrator = self
            .integrator
            .saturating_add(integral)
            // Not `clamp`, which can panic: the compiler does not see that `low` is not above `high`.
            .min(high - proportional.min(0))
            .max(low - proportional.max(0));
        saturate64((self.integrator + proportional).min(high).max(low) >> 16)
    }

    /// Back-calculation: something else decided `applied`, so the integrator goes to what would have given
    /// that output for the present `error`, by this `share` (1/65 536) of the way: a limit that is touched by
    /// the current's ripple, a few ticks in every step, must not set back the mean. The controller takes over
    /// again when its error asks for it, without a bump.
    #[inline]
    pub fn track(&mut self, gains: &PiGains, applied: i32, error: i32, share: u16) {
        let proportional = gains.proportional.apply_extended(error).clamp(-HEADROOM, HEADROOM);
        let target = (i64::from(applied) << 16) - proportional;
        self.integrator += ((target - self.integrator) * i64::from(share)) >> 16;
    }

    /// The integrator alone gives `output`.
    #[inline]
    pub fn is_at_least(&self, output: i32) -> bool {
        self.integrator >= i64::from(output) << 16
    }

    /// The integrator alone gives exactly `output`: it waits there.
    #[inline]
    pub fn waits_at(&self, output: i32) -> bool {
        self.integrator == i64::from(output) << 16
    }

    /// Waits beside `applied`: a limiter that is not needed keeps its integrator there, and its proportional
    /// part alone is the distance to intervening.
    #[inline]
    pub fn wait(&mut self, applied: i32) {
        self.integrator = i64::from(applied) << 16;
    }
}
