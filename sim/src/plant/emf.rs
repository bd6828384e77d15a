//! Back-EMF per unit of speed against the electrical angle.

use super::angle::{Sweep, fraction};
use super::config::{BackEmf, MotorConfig};

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
}

/// A quantity of each leg that runs linearly over an interval: `start + slope t`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Linear3 {
    pub(crate) start: [f64; 3],
    pub(crate) slope: [f64; 3],
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
        let winding = motor.phase_order.map(|phase| phase.index());
        Self {
            nominal,
            peak: nominal,
            flank,
            lag: winding.map(|x| [0.0, 1.0 / 3.0, 2.0 / 3.0][x]),
            lag_cos: winding.map(|x| [1.0, -0.5, -0.5][x]),
            lag_sin: winding.map(|x| [0.0, 0.5 * SQRT_3, -0.5 * SQRT_3][x]),
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

    /// Values over an interval of `h` seconds that begins at `angle` (turns; `sweep` has its sine and cosine) and turns by
    /// `rate` turns a second: the straight line through the values at the interval's two Gauss points, so that the flux
    /// linkage is exact to the third order. A trapezoid is straight between its corners.
    #[inline]
    pub(crate) fn over(&self, angle: f64, sweep: &Sweep, rate: f64, h: f64) -> Linear3 {
        if self.flank != 0.0 {
            return self.trapezoids(angle + 0.5 * rate * h, rate, h);
        }
        let half = PI * rate * h;
        let middle = &sweep.middle;
        // Gauss points lie a = half / sqrt 3 to either side of the middle m. Mean of both: sin m cos a; slope: cos m
        // sin a / a times the angular speed.
        let y = half * half * (1.0 / 3.0);
        let mean = self.peak * (1.0 - y * 0.5 * (1.0 - y * (1.0 / 12.0)));
        let per_second = self.peak * (1.0 - y * (1.0 / 6.0) * (1.0 - y * (1.0 / 20.0))) * (2.0 * PI) * rate;
        let (sin, cos) = (mean * middle.sin, mean * middle.cos);
        let (sin_slope, cos_slope) = (per_second * middle.cos, per_second * middle.sin);
        let mut line = Linear3::default();
        for leg in 0..3 {
            let slope = sin_slope * self.lag_cos[leg] + cos_slope * self.lag_sin[leg];
            line.slope[leg] = slope;
            line.start[leg] = sin * self.lag_cos[leg] - cos * self.lag_sin[leg] - 0.5 * h * slope;
        }
        line
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

    fn trapezoids(&self, middle: f64, rate: f64, h: f64) -> Linear3 {
        let scale = 1.0 / self.flank;
        let mut line = Linear3::default();
        for leg in 0..3 {
            let x = fraction(middle - self.lag[leg]);
            let (ramp, sign) = if x < 0.25 {
                (x, 1.0)
            } else if x < 0.75 {
                (0.5 - x, -1.0)
            } else {
                (x - 1.0, 1.0)
            };
            let value = ramp * scale;
            let slope = if value.abs() < 1.0 { self.peak * sign * scale * rate } else { 0.0 };
            line.slope[leg] = slope;
            line.start[leg] = self.peak * value.clamp(-1.0, 1.0) - 0.5 * h * slope;
        }
        line
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
