//! The correlation of value and distance from the centre:
//!
//! ```text
//! r = sum (f_i - mean f) (d_i - mean d) / ( |f - mean f| |d - mean d| )
//! ```
//!
//! of T. Jones and S. Forrest, *Fitness distance correlation as a measure of problem difficulty for genetic
//! algorithms*, ICGA 1995: -1 where all ways lead up to the centre, about 0 where nothing does. |f - mean
//! f| is without noise ([`inner`]), which else would pull r to 0.

use crate::{
    Estimate, Repeats, inner,
    inner::dot,
    repeats::{chosen, mean, norm},
};

/// The correlation with these distances, `[n_points]`, within -1 to 1; none if the values don't vary
/// beyond noise, or the distances not at all.
#[must_use]
pub fn distance_correlation(repeats: &Repeats, distances: &[f64]) -> Option<Estimate> {
    let centred = repeats.centred();
    let middle = distances.iter().sum::<f64>() / distances.len() as f64;
    let distances: Vec<f64> = distances.iter().map(|distance| distance - middle).collect();
    let spread = norm(&distances);
    Estimate::jackknife(repeats.n(), |which| {
        let rows = chosen(&centred, which);
        let varies = inner(&rows, &rows);
        let r = dot(&mean(&rows), &distances) / (varies.sqrt() * spread);
        (varies > 0.0 && spread > 0.0).then(|| r.clamp(-1.0, 1.0))
    })
}
