//! Least squares with a few unknowns.

use libm::{fabs, sqrt};

/// Most unknowns of a fit.
pub(super) const UNKNOWNS: usize = 6;

/// Sums of a linear fit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Fit {
    normal: [[f64; UNKNOWNS]; UNKNOWNS],
    right: [f64; UNKNOWNS],
    square: f64,
    unknowns: usize,
    count: usize,
}

/// Unknowns with their standard errors; 0 beyond those of the fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solution {
    pub(super) value: [f64; UNKNOWNS],
    pub(super) error: [f64; UNKNOWNS],
}

impl Fit {
    /// Adds `y = sum(row * unknowns)`, which counts `weight` times. All rows are equally long.
    pub(super) fn add(&mut self, row: &[f64], y: f64, weight: f64) {
        for (sums, a) in self.normal.iter_mut().zip(row) {
            for (sum, b) in sums.iter_mut().zip(row) {
                *sum += weight * a * b;
            }
        }
        for (sum, a) in self.right.iter_mut().zip(row) {
            *sum += weight * a * y;
        }
        self.square += weight * y * y;
        self.unknowns = row.len();
        self.count += 1;
    }

    /// Adds that the unknown at `place` is `value`, which counts `weight` times.
    pub(super) fn know(&mut self, place: usize, value: f64, weight: f64) {
        let row: [f64; UNKNOWNS] = core::array::from_fn(|at| if at == place { 1.0 } else { 0.0 });
        self.add(&row, value, weight);
    }

    /// The unknowns; `None` if the rows do not determine them.
    pub(super) fn solve(&self) -> Option<Solution> {
        let mut normal = self.normal;
        for (place, row) in normal.iter_mut().enumerate().skip(self.unknowns) {
            *row.get_mut(place)? = 1.0;
        }
        let freedom = self.count.checked_sub(self.unknowns)?.max(1) as f64;
        let value = solve(normal, self.right)?;
        let explained: f64 = value.iter().zip(self.right).map(|(x, b)| x * b).sum();
        let variance = libm::fmax(self.square - explained, 0.0) / freedom;
        let mut error = [0.0; UNKNOWNS];
        for (place, error) in error.iter_mut().enumerate().take(self.unknowns) {
            let unit = core::array::from_fn(|at| if at == place { 1.0 } else { 0.0 });
            *error = sqrt(libm::fmax(solve(normal, unit)?.get(place)? * variance, 0.0));
        }
        Some(Solution { value, error })
    }
}

/// Gaussian elimination with the largest pivot of each column.
fn solve(mut a: [[f64; UNKNOWNS]; UNKNOWNS], mut b: [f64; UNKNOWNS]) -> Option<[f64; UNKNOWNS]> {
    for column in 0..UNKNOWNS {
        let size = |row: usize| a.get(row).and_then(|row| row.get(column)).map_or(0.0, |cell| fabs(*cell));
        let pivot = (column..UNKNOWNS).max_by(|x, y| size(*x).total_cmp(&size(*y)))?;
        if pivot >= UNKNOWNS {
            return None;
        }
        a.swap(column, pivot);
        b.swap(column, pivot);
        let (top, right) = (*a.get(column)?, *b.get(column)?);
        let head = *top.get(column)?;
        if head == 0.0 || !head.is_finite() {
            return None;
        }
        for (row, value) in a.iter_mut().zip(&mut b).skip(column + 1) {
            let factor = row.get(column)? / head;
            for (cell, above) in row.iter_mut().zip(top) {
                *cell -= factor * above;
            }
            *value -= factor * right;
        }
    }
    let mut x = [0.0; UNKNOWNS];
    for place in (0..UNKNOWNS).rev() {
        let row = a.get(place)?;
        let known: f64 = row.iter().zip(x).skip(place + 1).map(|(cell, x)| cell * x).sum();
        *x.get_mut(place)? = (b.get(place)? - known) / row.get(place)?;
    }
    x.iter().all(|x| x.is_finite()).then_some(x)
}
