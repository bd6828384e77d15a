//! Back-EMF per unit of speed against the electrical angle.

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
    /// Winding of each leg.
    order: [usize; 3],
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
        Self { nominal, peak: nominal, flank, order: motor.phase_order.map(|phase| phase.index()) }
    }

    /// Applies the magnets' drift: `factor` times the value at 25 degrees Celsius.
    pub(crate) fn set_drift(&mut self, factor: f64) {
        self.peak = self.nominal * factor;
    }

    /// Amplitude of one phase now, V s/rad.
    pub(crate) fn peak(&self) -> f64 {
        self.peak
    }

    /// Values at the two Gauss points of an interval of length `h` joined by straight lines, so that the flux
    /// linkage over the interval is exact to the third order. `middle` is the angle in the interval's middle,
    /// `span` the angle it covers, both in turns.
    pub(crate) fn over(&self, middle: f64, span: f64, h: f64) -> Linear3 {
        // Gauss points lie h / (2 sqrt 3) to either side of the middle.
        let aside = span * (0.5 / SQRT_3);
        let (first, second) = if self.flank == 0.0 {
            sine_pair(middle, aside)
        } else {
            (self.trapezoids(middle - aside), self.trapezoids(middle + aside))
        };
        let per_h = SQRT_3 / h;
        let mut line = Linear3::default();
        for leg in 0..3 {
            let winding = self.order[leg];
            let mean = 0.5 * self.peak * (first[winding] + second[winding]);
            let slope = self.peak * (second[winding] - first[winding]) * per_h;
            line.slope[leg] = slope;
            line.start[leg] = mean - 0.5 * h * slope;
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

    fn trapezoids(&self, angle: f64) -> [f64; 3] {
        let scale = 1.0 / self.flank;
        [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|lag| {
            let x = fraction(angle - lag);
            let ramp = if x < 0.25 {
                x
            } else if x < 0.75 {
                0.5 - x
            } else {
                x - 1.0
            };
            (ramp * scale).clamp(-1.0, 1.0)
        })
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

/// The three sines at `middle - aside` and at `middle + aside` (turns).
fn sine_pair(middle: f64, aside: f64) -> ([f64; 3], [f64; 3]) {
    let (sin_m, cos_m) = sin_cos(middle);
    let (sin_a, cos_a) = if aside.abs() < 0.016 { tiny_sin_cos(aside) } else { sin_cos(aside) };
    let (ss, cs, sc, cc) = (sin_m * sin_a, cos_m * sin_a, sin_m * cos_a, cos_m * cos_a);
    (three_sines(sc - cs, cc + ss), three_sines(sc + cs, cc - ss))
}

/// sin x, sin (x - 120), sin (x + 120) degrees.
fn three_sines(sin: f64, cos: f64) -> [f64; 3] {
    let (half, rest) = (-0.5 * sin, 0.5 * SQRT_3 * cos);
    [sin, half - rest, half + rest]
}

/// The part of `x` above the next lower whole number, in [0, 1).
pub(crate) fn fraction(x: f64) -> f64 {
    let rest = x - x as i64 as f64;
    if rest < 0.0 { rest + 1.0 } else { rest }
}

/// Sine and cosine of an angle in turns, to 1e-11: the nearest quarter turn, then the series.
pub(crate) fn sin_cos(turns: f64) -> (f64, f64) {
    let x = fraction(turns);
    let quarter = (4.0 * x + 0.5) as i32;
    let (s, c) = small_sin_cos(x - 0.25 * f64::from(quarter));
    match quarter & 3 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// The same, for angles up to 0.1 rad, to 1e-11.
fn tiny_sin_cos(turns: f64) -> (f64, f64) {
    let x = turns * (2.0 * PI);
    let y = x * x;
    let s = 1.0 - y * (1.0 / 6.0) * (1.0 - y * (1.0 / 20.0) * (1.0 - y * (1.0 / 42.0)));
    let c = 1.0 - y * 0.5 * (1.0 - y * (1.0 / 12.0) * (1.0 - y * (1.0 / 30.0) * (1.0 - y * (1.0 / 56.0))));
    (x * s, c)
}

/// Taylor series about 0, for angles up to an eighth of a turn.
fn small_sin_cos(turns: f64) -> (f64, f64) {
    let x = turns * (2.0 * PI);
    let y = x * x;
    let s = 1.0
        - y * (1.0 / 6.0)
            * (1.0
                - y * (1.0 / 20.0)
                    * (1.0
                        - y * (1.0 / 42.0)
                            * (1.0
                                - y * (1.0 / 72.0) * (1.0 - y * (1.0 / 110.0) * (1.0 - y * (1.0 / 156.0))))));
    let c = 1.0
        - y * 0.5
            * (1.0
                - y * (1.0 / 12.0)
                    * (1.0
                        - y * (1.0 / 30.0)
                            * (1.0
                                - y * (1.0 / 56.0) * (1.0 - y * (1.0 / 90.0) * (1.0 - y * (1.0 / 132.0))))));
    (x * s, c)
}
