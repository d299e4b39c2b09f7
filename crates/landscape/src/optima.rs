//! Local optima and total variation, beyond noise.
//!
//! What noise alone makes is found by noise alone: in 95 % of slices that are flat but for noise like
//! this one's, no optimum stands out as far as the *threshold*. An optimum counts if its prominence
//! (`prominence.rs`) is more than that, and a rise or fall counts in the variation if it's more:
//!
//! ```text
//! variation = sum of the rises and falls of more than the threshold / (highest - lowest)
//! ```
//!
//! which is 1 for a slope, 2 for a hill whose feet are equally low, 2 k for k such hills. Without noise
//! it's the total variation over the range. That falls of less than a threshold are left out is the
//! simplification of a function by persistence (source in `prominence.rs`).

use streams::Normals;

use crate::{Grid, Peak, Repeats};

/// Replicates of noise, and the share of them without an optimum.
const REPLICATES: usize = 400;
const SHARE: f64 = 0.95;

/// The local optima of a slice beyond noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Optima {
    /// How many there are.
    pub n: usize,
    /// They themselves, the most prominent first.
    pub peaks: Vec<Peak>,
    /// How far an optimum has to stand out: in units of the values.
    pub threshold: f64,
}

impl Optima {
    /// The optima of a slice whose points lie like that.
    #[must_use]
    pub fn of(repeats: &Repeats, grid: &Grid) -> Self {
        let mut normals = Normals::new(1, "landscape noise");
        let highest = |_| {
            let peaks = grid.prominences(&repeats.noise(&mut normals));
            peaks.first().map_or(0.0, |peak| peak.prominence)
        };
        let mut replicates: Vec<f64> = (0..REPLICATES).map(highest).collect();
        replicates.sort_by(f64::total_cmp);
        let threshold = replicates[(SHARE * REPLICATES as f64) as usize];
        let peaks: Vec<_> = grid
            .prominences(&repeats.mean())
            .into_iter()
            .filter(|peak| peak.prominence > threshold)
            .collect();
        Self { n: peaks.len(), peaks, threshold }
    }
}

/// The total variation of a line's heights by rises and falls of more than a threshold, over their range;
/// none if nothing rises or falls that far.
#[must_use]
pub fn variation(heights: &[f64], threshold: f64) -> Option<f64> {
    let turns = turns(heights, threshold);
    let (low, high) = range(&turns);
    let sum: f64 = turns.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
    (high > low).then(|| sum / (high - low))
}

/// The heights at which a line turns, if what is up to a threshold doesn't count; first and last among
/// them.
pub(crate) fn turns(heights: &[f64], threshold: f64) -> Vec<f64> {
    let mut turns = Vec::new();
    // Since the last turn; before the first one both ends may be it.
    let (mut low, mut high) = range(&heights[..heights.len().min(1)]);
    let mut rises: Option<bool> = None;
    for &height in heights {
        low = low.min(height);
        high = high.max(height);
        let (turned, turn) = match rises {
            Some(true) | None if high - height > threshold => (Some(false), high),
            Some(false) | None if height - low > threshold => (Some(true), low),
            _ => continue,
        };
        turns.push(turn);
        rises = turned;
        (low, high) = (height, height);
    }
    match rises {
        Some(true) => turns.push(high),
        Some(false) => turns.push(low),
        None => {}
    }
    turns
}

fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
        (low.min(value), high.max(value))
    })
}
