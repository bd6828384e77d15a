//! Integrals over one interval from the state at its start, middle and end.

use super::emf::Linear3;
use super::segment::Electric;

/// Simpson's rule over an interval.
pub(crate) struct Simpson<'a> {
    pub(crate) h: f64,
    pub(crate) points: [&'a Electric; 3],
}

impl Simpson<'_> {
    pub(crate) fn integral(&self, value: impl Fn(&Electric) -> f64) -> f64 {
        let [start, middle, end] = self.points;
        self.h * (1.0 / 6.0) * (value(start) + 4.0 * value(middle) + value(end))
    }

    /// Torque impulse, N m s: each phase's back-EMF per speed times its current.
    pub(crate) fn impulse(&self, shape: &Linear3) -> f64 {
        let [start, middle, end] = self.points;
        let mut sum = 0.0;
        for x in 0..3 {
            let first = shape.start[x];
            let rise = shape.slope[x] * self.h;
            sum += first * start.i[x] + 4.0 * (first + 0.5 * rise) * middle.i[x] + (first + rise) * end.i[x];
        }
        self.h * (1.0 / 6.0) * sum
    }
}
