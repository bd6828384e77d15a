//! The bus current that may flow: the least of every rating, and the name of the one that binds.

use crate::motor::gain::Gain;
use crate::motor::ramp::Ramp;
use crate::units::{Celsius, Volts};
use serde::{Deserialize, Serialize};

/// The limit that bounds the duty in this tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Limiter {
    /// The bridge is off.
    #[default]
    Off = 0,
    /// A fixed level: rotor lock or open loop.
    Fixed = 1,
    /// The speed loop.
    Speed = 2,
    /// The bus current limit of Table 11 or the input current rating.
    Current = 3,
    /// The phase current bound.
    PhaseCurrent = 4,
    /// The output power rating.
    Power = 5,
    /// The temperature derating.
    Temperature = 6,
    /// Maximum duty cycle.
    Duty = 7,
    /// The duty's slew limit.
    Slew = 8,
    /// The bus must not be fed: the motor coasts.
    Return = 9,
    /// The voltage fades over zero crossings that were not seen.
    Fade = 10,
}

/// Coefficients of the current limits, raw I16F16.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct LimitCoefficients {
    /// Limit at the beginning of a start (parameter 105), A.
    pub soft_start: i32,
    /// Limit afterwards (parameter 106), at most the 7 A input rating of Table 1, A.
    pub maximum: i32,
    /// Slope from one to the other (parameter 96), A per millisecond with 16 extra bits.
    pub rate: i64,
    /// Estimated mean phase current (parameter 269), A.
    pub phase_current_max: i32,
    /// From this temperature the limits fall (parameter 121), degrees C.
    pub derating_start: i32,
    /// Per degree above it: 1 / (shutdown - warning).
    pub derating: Gain,
    /// Resistance of the two switches that conduct, raw I16F16 ohm.
    pub bridge: i32,
}

/// Output power rating (Table 1), W: 150 W up to and including a bus of [`POWER_STEP`], 300 W above. What
/// leaves the bridge is what enters it less the loss in its switches, I^2 R; losses that the drive cannot
/// know make the motor's share smaller still.
#[inline]
pub const fn power_rating(bus: Volts) -> u32 {
    if bus.to_bits() > POWER_STEP.to_bits() { 300 } else { 150 }
}
/// The 48 V of Table 1. A supply of 48 V that reads a little high is still 48 V: 0.5 V of measurement
/// tolerance.
pub const POWER_STEP: Volts = Volts::from_milli(48_500);

/// Continuous phase current (Table 2): 6 A rms, which six-step current with two phases of three in turn
/// reaches at 6 sqrt(3/2) = 7.35 A; raw I16F16.
const CONTINUOUS: i32 = 481_589;
/// Its square, A^2 with 16 fraction bits.
const CONTINUOUS_SQUARE: i64 = 54 << 16;
/// A current whose upper 24 bits do not exceed this heats nothing.
const COLD: u32 = CONTINUOUS as u32 >> 8;
const _: () = assert!((COLD as i64) * (COLD as i64) <= CONTINUOUS_SQUARE);
/// Excess of I^2 over that, summed each millisecond, at which the continuous current alone is left: 12 A for
/// 2 s.
const HEAT_MAX: i64 = (180 * 1000) << 16;

/// State: the ramped limit of Table 11.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CurrentLimit {
    ramp: Ramp,
    /// Current that the power rating leaves, raw I16F16 A with 16 extra bits.
    power: i64,
    /// Sum of I^2 above the continuous square, A^2 ms with 16 fraction bits, 0 to [`HEAT_MAX`].
    heat: i64,
    bound: i32,
    /// Phase current that the temperature leaves, raw I16F16 A.
    phase: i32,
    limiter: Limiter,
}

impl CurrentLimit {
    /// A start begins: back to the soft-start limit. Windings and switches stay as warm as they are.
    pub fn start(&mut self, c: &LimitCoefficients) {
        self.ramp.set(c.soft_start);
        self.power = (c.maximum as i64) << 16;
        (self.bound, self.limiter) = (c.soft_start, Limiter::Current);
        self.phase = c.phase_current_max;
    }

    /// Once a millisecond: the ramp moves from the soft-start value once the rotor `turns`, and the ratings
    /// are looked at. Bus voltage and filtered bus current, raw I16F16; `phase_current` is the estimated mean
    /// phase current, raw I16F16 A. True if a bound changed.
    pub fn update(
        &mut self,
        c: &LimitCoefficients,
        (voltage, current): (i32, i32),
        phase_current: i32,
        temperature: Celsius,
        turns: bool,
    ) -> bool {
        let before = (self.bound, self.phase);
        let target = if turns { c.maximum } else { c.soft_start.min(c.maximum) };
        let table = self.ramp.step(target, c.rate);
        let power = self.update_power_bound(c, (voltage, current), phase_current);
        (self.bound, self.limiter) =
            if power < table { (power, Limiter::Power) } else { (table, Limiter::Current) };
        self.phase = self.update_thermal_bound(c, phase_current);
        let excess = temperature.to_bits().saturating_sub(c.derating_start);
        if excess > 0 {
            let left = (1_i64 << 16).saturating_sub(c.derating.apply(excess)).max(0);
            self.bound = ((self.bound as i64 * left) >> 16) as i32;
            self.phase = ((self.phase as i64 * left) >> 16) as i32;
            self.limiter = Limiter::Temperature;
        }
        before != (self.bound, self.phase)
    }

    /// The power rating is one of heat, not of an instant, and the current swings with every commutation. So
    /// an integrator of 20 ms moves the bound until the filtered power is the rating.
    fn update_power_bound(
        &mut self,
        c: &LimitCoefficients,
        (voltage, current): (i32, i32),
        phase_current: i32,
    ) -> i32 {
        let voltage = voltage.max(1 << 16);
        let amperes = i64::from(phase_current >> 8);
        // W with 16 fraction bits; at most 255 W, where the switches are the least worry.
        let lost = (((amperes * amperes) * i64::from(c.bridge)) >> 16).min(0xFF_FFFF) as u32;
        // Watts over volts in 32 bits: the divisor keeps 11 and more from 18 V on.
        let rating = ((power_rating(Volts::from_bits(voltage)) << 22) + (lost << 6)) / (voltage as u32 >> 10);
        let room = rating as i32 - current;
        let most = (c.maximum as i64) << 16;
        if room >= 0 && self.power == most {
            return c.maximum;
        }
        self.power = (self.power + i64::from(room) * (65_536 / 20)).min(most).max(0);
        (self.power >> 16) as i32
    }

    /// Phase current that the heat store leaves: all of it when cold, the continuous rating when full.
    fn update_thermal_bound(&mut self, c: &LimitCoefficients, phase_current: i32) -> i32 {
        let current = phase_current >> 8;
        // Cold, and it stays so.
        if self.heat == 0 && current.unsigned_abs() <= COLD {
            return c.phase_current_max;
        }
        let current = i64::from(current);
        self.heat = (self.heat + current * current - CONTINUOUS_SQUARE).clamp(0, HEAT_MAX);
        let above = i64::from(c.phase_current_max.saturating_sub(CONTINUOUS)).max(0);
        // In 2^-20ths, and by a constant reciprocal.
        const FULL: i64 = (1 << 32) / (HEAT_MAX >> 20);
        c.phase_current_max - ((above * (((self.heat >> 20) * FULL) >> 16)) >> 16) as i32
    }

    /// Bound of the mean bus current in this tick, raw I16F16 A, with its name. A bus shunt sees the phase
    /// current times the duty, so the phase bound is that much smaller here.
    #[inline]
    pub fn bound(&self, duty: u16) -> (i32, Limiter) {
        let phase = ((self.phase as i64 * duty as i64) >> 15) as i32;
        if phase < self.bound { (phase, Limiter::PhaseCurrent) } else { (self.bound, self.limiter) }
    }
}
