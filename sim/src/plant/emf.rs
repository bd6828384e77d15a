//! Back-EMF per unit of speed against the electrical angle.

use super::angle::{Rotation, fraction};
use super::config::{BackEmf, MotorConfig};
use super::segment::Shape;
use super::wiring::{self, Wiring, dot};

const SQRT_3: f64 = 1.732_050_807_568_877_2;
const PI: f64 = core::f64::consts::PI;

/// The back-EMF's shape, scaled to V s/rad of mechanical speed and ordered by leg.
#[derive(Clone, Debug)]
pub(crate) struct EmfShape {
    /// Amplitude of one phase at 25 degrees Celsius, V s/rad.
    nominal: f64,
    /// Amplitude now.
    peak: f64,
    /// Half a flank in turns; 0 for a sine.
    flank: f64,
    /// Each leg's winding lags by this, turns, and its cosine and sine.
    lag: [f64; 3],
    lag_cos: [f64; 3],
    lag_sin: [f64; 3],
    /// For every [`Wiring`].
    mixes: [Mix; wiring::COUNT],
}

/// Parts of the angle's sine and cosine in a sinusoidal motor's back-EMF along two coordinates of a wiring:
/// `s`, and `d` where three legs conduct or the idle leg beside two that do.
#[derive(Clone, Copy, Debug, Default)]
struct Mix {
    sin: [f64; 2],
    cos: [f64; 2],
}

/// A quantity that runs linearly over an interval: `start + slope t`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Line {
    pub(crate) start: f64,
    pub(crate) slope: f64,
}

impl Line {
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn at(&self, t: f64) -> f64 {
        self.start + self.slope * t
    }
}

/// A quantity that runs linearly over an interval, by its value in the middle: `middle + slope (t - h / 2)`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Chord {
    pub(crate) middle: f64,
    pub(crate) slope: f64,
}

impl EmfShape {
    pub(crate) fn new(motor: &MotorConfig) -> Self {
        let k = motor.torque_constant;
        let (nominal, flank) = match motor.back_emf {
            // Line-to-line peak (pi / 3) k, phase peak 1 / sqrt 3 of it.
            BackEmf::Sinusoidal => (k * PI / (3.0 * SQRT_3), 0.0),
            BackEmf::Trapezoidal { flat_top_deg } => {
                let flank_deg = 90.0 - 0.5 * flat_top_deg.clamp(0.0, 179.0);
                (0.5 * k / mean_over_conduction(flank_deg), flank_deg / 360.0)
            }
        };
        let winding = motor.phase_order;
        let lag_cos = winding.map(|phase| [1.0, -0.5, -0.5][phase]);
        let lag_sin = winding.map(|phase| [0.0, 0.5 * SQRT_3, -0.5 * SQRT_3][phase]);
        Self {
            nominal,
            peak: nominal,
            flank,
            lag: winding.map(|phase| [0.0, 1.0 / 3.0, 2.0 / 3.0][phase]),
            lag_cos,
            lag_sin,
            mixes: core::array::from_fn(|index| Mix::new(Wiring::numbered(index), &lag_cos, &lag_sin)),
        }
    }

    /// Applies the magnets' drift: `factor` times the value at 25 degrees Celsius.
    pub(crate) fn set_drift(&mut self, factor: f64) {
        self.peak = self.nominal * factor;
    }

    /// Amplitude of one phase now, V s/rad.
    pub(crate) fn peak(&self) -> f64 {
        self.peak
    }

    /// The shape is a sine.
    #[inline]
    pub(crate) fn is_sine(&self) -> bool {
        self.flank == 0.0
    }

    /// Largest difference of two phases, V s/rad or less.
    pub(crate) fn line_peak(&self) -> f64 {
        2.0 * self.peak
    }

    /// Values along the coordinates of `wiring` over `h` seconds, of a sine, that turn by `rate` electrical
    /// rad/s about the angle `middle`: the straight line through the values at the interval's two Gauss
    /// points, so that the flux linkage is exact to the third order.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn along(&self, wiring: &Wiring, three: bool, middle: &Rotation, rate: f64, h: f64) -> Shape {
        let (value, per_second) = self.gauss(rate, h);
        let Mix { sin, cos } = &self.mixes[wiring.index & 31];
        let middles = [0, 1].map(|n| value * (sin[n] * middle.sin + cos[n] * middle.cos));
        let slopes = [0, 1].map(|n| per_second * (sin[n] * middle.cos - cos[n] * middle.sin));
        let s = Chord { middle: middles[0], slope: slopes[0] };
        let (aside, none) = (Chord { middle: middles[1], slope: slopes[1] }, Chord::default());
        if three { Shape { s, d: aside, idle: none } } else { Shape { s, d: none, idle: aside } }
    }

    /// Returns the values of every leg over `h` seconds, as [`along`](Self::along) does along coordinates,
    /// but for a motor of any shape; `angle` is the middle in turns.
    pub(crate) fn legs(&self, angle: f64, middle: &Rotation, rate: f64, h: f64) -> [Chord; 3] {
        if self.flank != 0.0 {
            return self.trapezoids(angle, rate);
        }
        let (value, per_second) = self.gauss(rate, h);
        [0, 1, 2].map(|leg| {
            let (sin, cos) = (self.lag_cos[leg], -self.lag_sin[leg]);
            Chord {
                middle: value * (sin * middle.sin + cos * middle.cos),
                slope: per_second * (sin * middle.cos - cos * middle.sin),
            }
        })
    }

    /// Gauss points lie a = half / sqrt 3 to either side of the middle m. Mean of both: sin m cos a; slope:
    /// cos m sin a / a times the angular speed.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn gauss(&self, rate: f64, h: f64) -> (f64, f64) {
        let span = rate * h;
        let y = span * span;
        // The next terms are below 1e-6.
        (self.peak * (1.0 - y * (1.0 / 24.0)), self.peak * rate * (1.0 - y * (1.0 / 72.0)))
    }

    /// Values of every leg at an angle in turns, whose sine and cosine are `rotation`.
    pub(crate) fn now(&self, angle: f64, rotation: &Rotation) -> [f64; 3] {
        if self.flank != 0.0 {
            return self.trapezoids(angle, 0.0).map(|chord| chord.middle);
        }
        let Rotation { sin, cos } = rotation;
        [0, 1, 2].map(|leg| self.peak * (self.lag_cos[leg] * sin - self.lag_sin[leg] * cos))
    }

    /// Of a sine: the value of the idle leg beside two that conduct, less the mean of theirs.
    pub(crate) fn aside(&self, wiring: &Wiring, rotation: &Rotation) -> f64 {
        let Mix { sin, cos } = &self.mixes[wiring.index & 31];
        self.peak * (sin[1] * rotation.sin + cos[1] * rotation.cos)
    }

    /// Turns from `angle` to the shape's next corner in the direction of `sign`; none for a sine.
    pub(crate) fn turns_to_corner(&self, angle: f64, sign: f64) -> Option<f64> {
        if self.flank == 0.0 {
            return None;
        }
        // The corners of three phases repeat every sixth of a turn, `flank` before and after the crossings.
        let corner = fraction(6.0 * self.flank);
        let here = fraction(6.0 * angle);
        let ahead = |place: f64| {
            let distance = fraction(sign * (place - here));
            // Rounding leaves us a hair before a corner that we have just reached.
            if distance < 1e-9 { 1.0 } else { distance }
        };
        Some(ahead(corner).min(ahead(1.0 - corner)) * (1.0 / 6.0))
    }

    /// Values along the coordinates of `wiring` of a trapezoid, which is straight between its corners;
    /// `angle` is the middle in turns.
    #[inline(never)]
    pub(crate) fn trapezoids_along(&self, wiring: &Wiring, angle: f64, rate: f64) -> Shape {
        let legs = self.trapezoids(angle, rate);
        let (middle, slope) = (legs.map(|chord| chord.middle), legs.map(|chord| chord.slope));
        let chord = |parts: &[f64; 3]| Chord { middle: dot(parts, &middle), slope: dot(parts, &slope) };
        Shape { s: chord(&wiring.along), d: chord(&wiring.across), idle: chord(&wiring.aside) }
    }

    fn trapezoids(&self, middle: f64, rate: f64) -> [Chord; 3] {
        let scale = 1.0 / self.flank;
        self.lag.map(|lag| {
            let x = fraction(middle - lag);
            let (ramp, sign) = if x < 0.25 {
                (x, 1.0)
            } else if x < 0.75 {
                (0.5 - x, -1.0)
            } else {
                (x - 1.0, 1.0)
            };
            let value = ramp * scale;
            let slope = if value.abs() < 1.0 { self.peak * sign * scale * rate * (0.5 / PI) } else { 0.0 };
            Chord { middle: self.peak * value.clamp(-1.0, 1.0), slope }
        })
    }
}

impl Mix {
    fn new(wiring: &Wiring, lag_cos: &[f64; 3], lag_sin: &[f64; 3]) -> Self {
        let pair = [&wiring.along, if wiring.conducting == 3 { &wiring.across } else { &wiring.aside }];
        Self { sin: pair.map(|parts| dot(parts, lag_cos)), cos: pair.map(|parts| -dot(parts, lag_sin)) }
    }
}

/// Mean of a trapezoid of peak 1 over the 60 degrees in which its phase conducts with one partner (30 to 90),
/// for a flank that rises from 0 to 1 in `flank_deg`. The partner's share is its mirror image.
fn mean_over_conduction(flank_deg: f64) -> f64 {
    if flank_deg <= 30.0 {
        1.0
    } else {
        ((flank_deg * flank_deg - 900.0) / (2.0 * flank_deg) + 90.0 - flank_deg) / 60.0
    }
}
