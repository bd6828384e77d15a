//! Sines and cosines of angles in turns, and how they follow an angle that moves in small steps.

const TAU: f64 = 2.0 * core::f64::consts::PI;
/// Largest angle for which the short series of [`Rotation::by`] is good, rad.
const SMALL: f64 = 0.4;

/// Sine and cosine of an angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rotation {
    pub(crate) sin: f64,
    pub(crate) cos: f64,
}

impl Rotation {
    /// Of an angle in turns, to 1e-11.
    pub(crate) fn of(turns: f64) -> Self {
        let (sin, cos) = sin_cos(turns);
        Self { sin, cos }
    }

    /// Of an angle in radians; to 1e-12 for small ones, and those should be small.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn by(x: f64) -> Self {
        if x.abs() > SMALL {
            return Self::by_much(x);
        }
        let y = x * x;
        let y2 = y * y;
        let sin = x
            * ((1.0 - y * (1.0 / 6.0)) + y2 * ((1.0 / 120.0 - y * (1.0 / 5040.0)) + y2 * (1.0 / 362_880.0)));
        let cos = (1.0 - y * 0.5)
            + y2 * ((1.0 / 24.0 - y * (1.0 / 720.0)) + y2 * (1.0 / 40_320.0 - y * (1.0 / 3_628_800.0)));
        Self { sin, cos }
    }

    /// Of an angle up to an eighth of a radian, to 1e-10.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn by_little(x: f64) -> Self {
        let y = x * x;
        Self {
            sin: x - x * y * (1.0 / 6.0 - y * (1.0 / 120.0)),
            cos: 1.0 - y * (0.5 - y * (1.0 / 24.0 - y * (1.0 / 720.0))),
        }
    }

    #[cold]
    #[inline(never)]
    fn by_much(x: f64) -> Self {
        Self::of(x * (1.0 / TAU))
    }

    /// This angle and another one.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn and(&self, more: &Self) -> Self {
        Self {
            sin: self.sin * more.cos + self.cos * more.sin,
            cos: self.cos * more.cos - self.sin * more.sin,
        }
    }
}

/// An angle that moves on by an expected span.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sweep {
    /// rad.
    pub(crate) span: f64,
    half: Rotation,
    /// Half way.
    pub(crate) middle: Rotation,
}

impl Sweep {
    /// From `start` on by `span` rad.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn new(start: &Rotation, span: f64) -> Self {
        Self::by_halves(start, span, Rotation::by(0.5 * span))
    }

    /// From `start` on by `span` rad, a quarter of a radian or less.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn little(start: &Rotation, span: f64) -> Self {
        Self::by_halves(start, span, Rotation::by_little(0.5 * span))
    }

    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn by_halves(start: &Rotation, span: f64, half: Rotation) -> Self {
        Self { span, half, middle: start.and(&half) }
    }

    /// Rotation after a turn by `turned` rad, which is about the span.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn end(&self, turned: f64) -> Rotation {
        let more = turned - self.span;
        let end = self.middle.and(&self.half);
        // sin x = x, cos x = 1 - x^2 / 2.
        let rest = if more.abs() > 1e-4 {
            Rotation::by(more)
        } else {
            Rotation { sin: more, cos: 1.0 - 0.5 * more * more }
        };
        end.and(&rest)
    }
}

/// Sine and cosine of an angle that moves with constant acceleration, as a polynomial in time about a middle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Track {
    /// Sine and cosine of each power.
    powers: [[f64; 2]; 5],
}

impl Track {
    /// Through `middle` with `rate` rad/s, which grows by `gain` rad/s2; to 2e-8 within an eighth of a
    /// radian.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn new(middle: &Rotation, rate: f64, gain: f64) -> Self {
        // x = rate t + gain t^2 / 2 in sin(m + x) = sin m + x cos m - x^2 / 2 sin m - ..., and for the cosine
        // -sin in the place of cos.
        let (x2, x3) = (0.5 * rate * rate, (1.0 / 6.0) * rate * rate * rate);
        let (bend, skew, x4) = (0.5 * gain, 0.5 * gain * rate, (1.0 / 24.0) * rate * rate * rate * rate);
        let Rotation { sin, cos } = *middle;
        let power = |along: f64, ahead: f64| [along * sin + ahead * cos, along * cos - ahead * sin];
        let (first, fourth) = ([rate * cos, -rate * sin], [x4 * sin, x4 * cos]);
        Self { powers: [[sin, cos], first, power(-x2, bend), power(-skew, -x3), fourth] }
    }

    /// All of it is further by `x` rad, which is so little that the rates stay.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn turn(&mut self, x: f64) {
        let [sin, cos] = self.powers[0];
        self.powers[0] = [sin + x * cos, cos - x * sin];
    }

    /// `t` seconds after the middle.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn at(&self, t: f64) -> Rotation {
        let [a, b, c, d, e] = &self.powers;
        let t2 = t * t;
        let [sin, cos] = [0, 1].map(|n| (a[n] + t * b[n]) + t2 * ((c[n] + t * d[n]) + t2 * e[n]));
        Rotation { sin, cos }
    }
}

/// The part of `x` above the next lower whole number, in [0, 1).
#[inline]
pub(crate) fn fraction(x: f64) -> f64 {
    let rest = x - x as i64 as f64;
    if rest < 0.0 { rest + 1.0 } else { rest }
}

/// Sine of an angle in turns, to 1e-9: the series of the distance to the nearest half turn, a quarter turn at
/// most.
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
pub(crate) fn sine(turns: f64) -> f64 {
    let half = 0.5 - fraction(turns);
    let x = TAU * (0.25 - (half.abs() - 0.25).abs());
    let y = x * x;
    let y2 = y * y;
    let series = (1.0 - y * (1.0 / 6.0))
        + y2 * ((1.0 / 120.0 - y * (1.0 / 5040.0))
            + y2 * ((1.0 / 362_880.0 - y * (1.0 / 39_916_800.0)) + y2 * (1.0 / 6_227_020_800.0)));
    (x * series).copysign(half)
}

/// Sine and cosine of an angle in turns, to 1e-11: the nearest quarter turn, then the series.
pub(crate) fn sin_cos(turns: f64) -> (f64, f64) {
    let x = fraction(turns);
    let quarter = (4.0 * x + 0.5) as i32;
    let (s, c) = eighth_sin_cos(x - 0.25 * f64::from(quarter));
    match quarter & 3 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Taylor series about 0, for angles up to an eighth of a turn.
#[inline]
fn eighth_sin_cos(turns: f64) -> (f64, f64) {
    let x = turns * TAU;
    let y = x * x;
    let y2 = y * y;
    let y4 = y2 * y2;
    let s = (1.0 - y * (1.0 / 6.0))
        + y2 * (1.0 / 120.0 - y * (1.0 / 5040.0))
        + y4 * ((1.0 / 362_880.0 - y * (1.0 / 39_916_800.0)) + y2 * (1.0 / 6_227_020_800.0));
    let c = (1.0 - y * 0.5)
        + y2 * (1.0 / 24.0 - y * (1.0 / 720.0))
        + y4 * ((1.0 / 40_320.0 - y * (1.0 / 3_628_800.0)) + y2 * (1.0 / 479_001_600.0));
    (x * s, c)
}
