//! Proportional-integral controller with back-calculation: `u = Kp e + integral of Ki e dt`.

use super::gain::Gain;
use crate::units::saturate64;
use serde::{Deserialize, Serialize};

/// Gains of a [`Pi`], built for one step rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
    /// The output for `error`, within `minimum..=maximum`; the integrator stays within them too.
    #[inline]
    pub fn step(&mut self, gains: &PiGains, error: i32, minimum: i32, maximum: i32) -> i32 {
        let (low, high) = ((minimum as i64) << 16, (maximum.max(minimum) as i64) << 16);
        self.integrator =
            self.integrator.saturating_add(gains.integral.apply_extended(error)).clamp(low, high);
        let output = gains.proportional.apply(error).saturating_add(self.integrator >> 16);
        saturate64(output.clamp(low >> 16, high >> 16))
    }

    /// Back-calculation with unit gain: another controller decided `applied`, so that is what this one's integrator
    /// takes over; its proportional part alone stays as the distance to taking over.
    #[inline]
    pub fn track(&mut self, applied: i32) {
        self.integrator = (applied as i64) << 16;
    }

    /// The integral part, raw I16F16.
    pub const fn integral(&self) -> i32 {
        saturate64(self.integrator >> 16)
    }
}
