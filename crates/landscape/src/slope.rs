//! The slope of a line's values in its middle, by least squares over some points to either side:
//!
//! ```text
//! slope = sum t_i f_i / sum t_i^2,   t_i from the middle, over its next points to either side
//! ```
//!
//! It's the finite difference that noise harms least; what is even about the middle, as curvature, has no
//! part in it.

use crate::{Estimate, Repeats};

/// The slope by the `reach` points to either side of the middle, whose places are `t`, `[n_points]`; none
/// if there aren't so many, or they aren't apart.
#[must_use]
pub fn slope(repeats: &Repeats, t: &[f64], reach: usize) -> Option<Estimate> {
    let middle = repeats.n_points() / 2;
    let points = middle.checked_sub(reach)?..(middle + reach + 1).min(t.len());
    let places: Vec<f64> = points.clone().map(|i| t[i] - t[middle]).collect();
    let squares: f64 = places.iter().map(|t| t * t).sum();
    let of = |repeat: &Vec<f64>| {
        let sum: f64 = places.iter().zip(&repeat[points.clone()]).map(|(t, f)| t * f).sum();
        sum / squares
    };
    let slopes: Vec<f64> = repeats.values().iter().map(of).collect();
    (squares > 0.0).then(|| Estimate::mean(&slopes))
}
