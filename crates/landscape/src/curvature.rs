//! Second differences over a line, against how much it varies at all:
//!
//! ```text
//! curvature = sqrt( mean (f_{i-1} - 2 f_i + f_{i+1})^2 / mean (f_i - mean f)^2 )
//! ```
//!
//! both means without noise ([`inner`](crate::inner)). It has no unit, and depends on how far the points
//! lie apart: a wave of n points a period has 4 sin^2(pi / n), which is 4 for a zigzag of n = 2. Squared
//! second differences as a measure of roughness are those of the smoothing spline (C. Reinsch, *Smoothing
//! by spline functions*, Numerische Mathematik 10, 1967).

use crate::{Estimate, Repeats, inner, repeats::chosen};

/// The root mean square of a line's second differences over that of its deviations; none if it doesn't
/// vary beyond noise.
#[must_use]
pub fn curvature(repeats: &Repeats) -> Option<Estimate> {
    let second = |repeat: &Vec<f64>| -> Vec<f64> {
        repeat.windows(3).map(|it| it[0] - 2.0 * it[1] + it[2]).collect()
    };
    let seconds: Vec<_> = repeats.values().iter().map(second).collect();
    let centred = repeats.centred();
    let n = repeats.n_points() as f64;
    Estimate::jackknife(repeats.n(), |which| {
        let [bends, varies] = [&seconds, &centred].map(|rows| {
            let rows = chosen(rows, which);
            inner(&rows, &rows)
        });
        // Noise may leave less than nothing of what is small.
        (varies > 0.0).then(|| (bends.max(0.0) / (n - 2.0) / (varies / n)).sqrt())
    })
}
