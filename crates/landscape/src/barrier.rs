//! How deep the valley between two points is, below the straight line between their heights:
//!
//! ```text
//! barrier = max_t ( (1 - t) f(0) + t f(1) - f(t) )
//! ```
//!
//! as in J. Frankle et al., *Linear mode connectivity and the lottery ticket hypothesis*, ICML 2020, where
//! lower is better; here higher is. A maximum over noisy values is too high, so each repeat is asked for
//! its depth where all others have theirs (cross-validation; H. van Hasselt, *Double Q-learning*, NeurIPS
//! 2010): the mean of these is never too high in the mean, and at most a little too low. It's the value,
//! and its t-interval has the lower end; the upper end is that of the depths at the one point where all
//! together are deepest, which are at most too high.

use crate::{
    Estimate, Repeats,
    repeats::{chosen, mean},
};

/// The barrier along a line from its first point to its last, in units of the values; near 0 or negative
/// if there's none.
#[must_use]
pub fn barrier(repeats: &Repeats) -> Estimate {
    let depths: Vec<_> = repeats.values().iter().map(|repeat| depths(repeat)).collect();
    let all: Vec<usize> = (0..repeats.n()).collect();
    let deepest = |which: &[usize]| {
        let mean = mean(&chosen(&depths, which));
        (0..mean.len()).max_by(|&a, &b| mean[a].total_cmp(&mean[b])).unwrap_or(0)
    };
    let where_others_are = |&r: &usize| {
        let others: Vec<_> = all.iter().copied().filter(|other| *other != r).collect();
        depths[r][deepest(&others)]
    };
    let fair = Estimate::mean(&all.iter().map(where_others_are).collect::<Vec<_>>());
    let point = deepest(&all);
    let high = Estimate::mean(&depths.iter().map(|depths| depths[point]).collect::<Vec<_>>()).high;
    Estimate { high: fair.value.max(high), ..fair }
}

/// Of each point, `[n_points]`.
fn depths(heights: &[f64]) -> Vec<f64> {
    let last = heights.len() - 1;
    let (first, end) = (heights[0], heights[last]);
    let depth = |(i, height): (usize, &f64)| {
        let t = i as f64 / last as f64;
        (1.0 - t) * first + t * end - height
    };
    heights.iter().enumerate().map(depth).collect()
}
