//! The inner product of two means, without what noise adds to it:
//!
//! ```text
//! <mx, my> = 1 / (R (R - 1)) sum_{r != s} <x_r, y_s>
//! ```
//!
//! for R repeats, each with an x and a y. No noise meets itself in it, so it's unbiased even where the x
//! and the y of one repeat have the same noise: the U-statistic of W. Hoeffding, *A class of statistics
//! with asymptotically normal distribution*, Annals of Mathematical Statistics 19 (1948).

/// The inner product of the means of `x` and `y`, `[n_repeats x n]` both; NaN of fewer than two repeats.
/// It can be negative even for x = y.
#[must_use]
pub fn inner(x: &[Vec<f64>], y: &[Vec<f64>]) -> f64 {
    let n = x.len() as f64;
    let same: f64 = x.iter().zip(y).map(|(x, y)| dot(x, y)).sum();
    (dot(&sum(x), &sum(y)) - same) / (n * (n - 1.0))
}

pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

pub(crate) fn sum(rows: &[Vec<f64>]) -> Vec<f64> {
    let mut sum = vec![0.0; rows.first().map_or(0, Vec::len)];
    for row in rows {
        sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
    }
    sum
}
