//! Tilt and vibration from one second of acceleration.
//!
//! The only floats of the device: f32 sums, products, quotients and bit shifts, which are the same on every
//! processor. `F32` instead of `f32`, because on a host the standard library's roots and arcs have the same
//! names and would be used.

use micromath::F32;
use serde::{Deserialize, Serialize};

/// Readings of a window: one second of them, 10 ms apart.
const WINDOW: i32 = 100;
const CENTIDEGREES_PER_RADIAN: F32 = F32(18_000.0 / core::f32::consts::PI);

/// Sums of the window under way, and results of the last one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Motion {
    readings: i32,
    /// Sum of each axis, 0.001 g.
    sums: [i32; 3],
    /// Sum of the squares of all axes.
    squares: i64,
    tilt: u16,
    vibration: u16,
}

impl Motion {
    /// Takes a reading, 0.001 g.
    pub(super) fn note(&mut self, accel: [i16; 3]) {
        for (sum, reading) in self.sums.iter_mut().zip(accel) {
            // 100 readings of 16 bits stay below 2^22 each, and the sum of their squares below 2^39.
            *sum += i32::from(reading);
            self.squares += i64::from(reading) * i64::from(reading);
        }
        self.readings += 1;
        if self.readings >= WINDOW {
            *self = Self { tilt: tilt(self.sums), vibration: self.deviation(), ..Self::default() };
        }
    }

    /// Angle between the Z axis and the mean acceleration, 0.01 degrees, 0..=18 000; 0 before the first
    /// window.
    pub(super) const fn tilt(&self) -> u16 {
        self.tilt
    }

    /// Root mean square without the mean, all axes together, 0.001 g; 0 before the first window.
    pub(super) const fn vibration(&self) -> u16 {
        self.vibration
    }

    /// sqrt(n sum(x^2) - sum(x)^2) / n, all axes under the root: exact up to there.
    fn deviation(&self) -> u16 {
        let means: i64 = self.sums.iter().map(|sum| i64::from(*sum) * i64::from(*sum)).sum();
        let spread = i64::from(WINDOW) * self.squares - means;
        (root(F32(spread as f32)) / F32(WINDOW as f32) + F32(0.5)).0 as u16
    }
}

/// atan2(sqrt(x^2 + y^2), z).
fn tilt([x, y, z]: [i32; 3]) -> u16 {
    if [x, y, z] == [0; 3] {
        return 0;
    }
    let square = |value: i32| i64::from(value) * i64::from(value);
    let across = root(F32((square(x) + square(y)) as f32));
    let angle = across.atan2(F32(z as f32)) * CENTIDEGREES_PER_RADIAN;
    ((angle + F32(0.5)).0 as u16).min(18_000)
}

/// The square root to a few units of the last place: micromath's has an error of 6 %, and two Newton steps
/// reduce it to 10^-6.
fn root(square: F32) -> F32 {
    if square == F32::ZERO {
        return square;
    }
    let half = F32(0.5);
    let better = |guess: F32| half * (guess + square / guess);
    better(better(square.sqrt()))
}
