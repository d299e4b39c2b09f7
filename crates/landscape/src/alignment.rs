//! How far one noisy gradient points to where another one does:
//!
//! ```text
//! cosine = <g, h> / ( |g| |h| )
//! ```
//!
//! with inner products of the means, without their noise ([`inner`]). Of single estimates the cosine is
//! near 0 whatever the gradients are, as most of each is noise, and near 1 if both have the same noise:
//! neither tells anything.

use crate::{Estimate, inner, repeats::chosen};

/// The cosine of the means of two gradients, `[n_repeats x n_parameters]` each, within -1 to 1; none if
/// one of them can't be told from 0.
#[must_use]
pub fn cosine(g: &[Vec<f64>], h: &[Vec<f64>]) -> Option<Estimate> {
    Estimate::jackknife(g.len(), |which| {
        let (g, h) = (chosen(g, which), chosen(h, which));
        let squares = [inner(&g, &g), inner(&h, &h)];
        let cosine = inner(&g, &h) / (squares[0].sqrt() * squares[1].sqrt());
        squares.iter().all(|it| *it > 0.0).then(|| cosine.clamp(-1.0, 1.0))
    })
}
