//! The rails that keep a sensorless motor from running wrong unnoticed. Each ends the episode (the drive
//! listens and starts again); episodes fill a leaky bucket, and a full one is a fault with the name of what
//! filled it.

use super::fault::Cause;
use crate::motor::gain::Gain;
use crate::units::saturate64;
use serde::{Deserialize, Serialize};

/// Coefficients of the rails.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct RailCoefficients {
    /// Volts per raw ampere (parameter 268), 0 unknown.
    pub resistance: Gain,
    /// Volts that turning the current over in six commutations a revolution costs, per raw ampere and raw
    /// rev/s: 3 L (parameter 283) with 16 extra bits, 0 unknown.
    pub commutation: Gain,
    /// Volts per electrical rev/s (parameter 267), 0 unknown.
    pub back_emf: Gain,
    /// Milliseconds in which the bucket loses one episode.
    pub leak: u32,
}

/// End of a driven episode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Rail {
    /// It has not.
    #[default]
    None = 0,
    /// Crossing time-out, or the budget of blind steps is spent.
    Stall = 1,
    /// Intervals jump by more than half.
    Desynchronised = 2,
    /// Speed and voltage do not fit together.
    WrongLock = 3,
}

impl Rail {
    /// The fault that a full bucket is reported as.
    pub const fn cause(self) -> Option<Cause> {
        match self {
            Self::None => None,
            Self::Stall => Some(Cause::SensorlessStall),
            Self::Desynchronised => Some(Cause::Desynchronisation),
            Self::WrongLock => Some(Cause::WrongLock),
        }
    }
}

/// Episodes that make a fault.
const BUCKET: u8 = 5;
/// Milliseconds for which speed and voltage must disagree.
const WRONG: u16 = 150;

/// State of the rails.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rails {
    bucket: u8,
    leak: u32,
    wrong: u16,
    last: Rail,
}

impl Rails {
    /// Once a millisecond while driven: the bucket leaks.
    pub fn leak(&mut self, c: &RailCoefficients) {
        self.leak = if self.bucket > 0 { self.leak + 1 } else { 0 };
        if self.leak >= c.leak.max(1) {
            (self.leak, self.bucket) = (0, self.bucket - 1);
        }
    }

    /// An episode has ended by `rail`.
    pub fn count(&mut self, rail: Rail) {
        self.bucket = self.bucket.saturating_add(1).min(BUCKET);
        (self.leak, self.wrong, self.last) = (0, 0, rail);
    }

    /// The fault, when the bucket is full.
    pub const fn fault(&self) -> Option<Cause> {
        if self.bucket >= BUCKET { self.last.cause() } else { None }
    }

    /// A new start by the master: the bucket is empty.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Once a millisecond in closed loop: `voltage` applied, mean phase `current`, and the speed that the
    /// crossings claim; all raw I16F16. What the resistance leaves of the voltage is back-EMF; a copper
    /// between 0.85 and 1.9 times nominal (cold, and at 190 degrees) and a back-EMF between 0.72 and 1.3
    /// times what the speed claims are believed (hot magnets leave 0.8, a strong lot has 1.05). True when
    /// they have disagreed for long.
    pub fn is_wrong_lock(&mut self, c: &RailCoefficients, voltage: i32, current: i32, speed: i32) -> bool {
        if c.back_emf == Gain::ZERO || c.resistance == Gain::ZERO {
            return false;
        }
        let current = current.max(0);
        let claimed = c.back_emf.apply32(speed);
        let fall = c.resistance.apply32(current);
        // 1/8 V for what dead time and switches take.
        let low = voltage.saturating_sub(fall - fall / 8) < share(claimed, 18, 25).saturating_sub(1 << 14);
        let turns = || c.commutation.apply32(saturate64((i64::from(current) * i64::from(speed)) >> 16));
        let left = voltage.saturating_sub(fall.saturating_add(share(fall, 9, 10))).saturating_sub(1 << 15);
        let most = claimed.saturating_add(share(claimed, 3, 10));
        let high = left > most && left.saturating_sub(turns().saturating_mul(2)) > most;
        self.wrong = if low || high { self.wrong.saturating_add(1) } else { self.wrong.saturating_sub(2) };
        self.wrong >= WRONG
    }
}

/// `value x numerator / denominator`, less than 1, by multiplication.
const fn share(value: i32, numerator: i64, denominator: i64) -> i32 {
    ((value as i64 * ((numerator << 16) / denominator)) >> 16) as i32
}
