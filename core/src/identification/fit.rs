//! Least squares with a few unknowns.

use libm::{fabs, sqrt};

/// Sums of a linear fit of `N` unknowns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit<const N: usize> {
    normal: [[f64; N]; N],
    right: [f64; N],
    square: f64,
    count: u32,
}

/// Unknowns with their standard errors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solution<const N: usize> {
    pub(super) value: [f64; N],
    pub(super) error: [f64; N],
}

impl<const N: usize> Default for Fit<N> {
    fn default() -> Self {
        Self { normal: [[0.0; N]; N], right: [0.0; N], square: 0.0, count: 0 }
    }
}

impl<const N: usize> Fit<N> {
    /// Adds `y = sum(row * unknowns)`, which counts `weight` times.
    pub(super) fn add(&mut self, row: [f64; N], y: f64, weight: f64) {
        for (sums, a) in self.normal.iter_mut().zip(row) {
            for (sum, b) in sums.iter_mut().zip(row) {
                *sum += weight * a * b;
            }
        }
        for (sum, a) in self.right.iter_mut().zip(row) {
            *sum += weight * a * y;
        }
        self.square += weight * y * y;
        self.count += 1;
    }

    /// The unknowns; `None` if the rows do not determine them.
    pub(super) fn solve(&self) -> Option<Solution<N>> {
        if (self.count as usize) < N {
            return None;
        }
        let value = solve(self.normal, self.right)?;
        let explained: f64 = value.iter().zip(self.right).map(|(x, b)| x * b).sum();
        let freedom = (self.count as usize - N).max(1) as f64;
        let variance = libm::fmax(self.square - explained, 0.0) / freedom;
        let mut error = [0.0; N];
        for (place, error) in error.iter_mut().enumerate() {
            let unit = core::array::from_fn(|at| if at == place { 1.0 } else { 0.0 });
            *error = sqrt(libm::fmax(solve(self.normal, unit)?.get(place)? * variance, 0.0));
        }
        Some(Solution { value, error })
    }
}

/// Gaussian elimination with the largest pivot of each column.
fn solve<const N: usize>(mut a: [[f64; N]; N], mut b: [f64; N]) -> Option<[f64; N]> {
    for column in 0..N {
        let pivot = (column..N).max_by(|x, y| fabs(a[*x][column]).total_cmp(&fabs(a[*y][column])))?;
        a.swap(column, pivot);
        b.swap(column, pivot);
        let (top, right) = (a[column], b[column]);
        if top[column] == 0.0 || !top[column].is_finite() {
            return None;
        }
        for row in column + 1..N {
            let factor = a[row][column] / top[column];
            for (cell, above) in a[row].iter_mut().zip(top) {
                *cell -= factor * above;
            }
            b[row] -= factor * right;
        }
    }
    let mut x = [0.0; N];
    for row in (0..N).rev() {
        let known: f64 = (row + 1..N).map(|at| a[row][at] * x[at]).sum();
        x[row] = (b[row] - known) / a[row][row];
    }
    x.iter().all(|x| x.is_finite()).then_some(x)
}
