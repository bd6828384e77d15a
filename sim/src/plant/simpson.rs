//! Integrals over one interval from the state at its start, middle and end.

use super::segment::{Linear2, Reduced};

/// Simpson's rule over an interval.
pub(crate) struct Simpson<'a> {
    pub(crate) h: f64,
    pub(crate) points: [&'a Reduced; 3],
}

impl Simpson<'_> {
    #[inline]
    pub(crate) fn integral(&self, value: impl Fn(&Reduced) -> f64) -> f64 {
        let [start, middle, end] = self.points;
        self.h * (1.0 / 6.0) * (value(start) + 4.0 * value(middle) + value(end))
    }

    /// Torque impulse, N m s: back-EMF per speed times current, along each coordinate.
    #[inline]
    pub(crate) fn impulse(&self, shape: &Linear2) -> f64 {
        let [start, middle, end] = self.points;
        let (s_half, d_half) = (0.5 * shape.s_slope * self.h, 0.5 * shape.d_slope * self.h);
        let (s, d) = (shape.s + s_half, shape.d + d_half);
        let sum = (shape.s * start.s + shape.d * start.d)
            + 4.0 * (s * middle.s + d * middle.d)
            + ((s + s_half) * end.s + (d + d_half) * end.d);
        self.h * (1.0 / 6.0) * sum
    }
}
