//! Curves as they are drawn: means over windows, which smooth and thin in one, and what quarters of
//! the instances do.

use super::statistics::{mean, quantile, sorted};

/// Means over windows of w updates, one after another. A last part that is shorter is left out,
/// but if it's all there is.
pub(super) fn window_means(values: &[f64], w: usize) -> Vec<[f64; 2]> {
    sliding_means(values, w, w)
}

/// Means over windows of w updates, `step` updates from one to the next, each with the number of
/// the update in its middle.
pub(super) fn sliding_means(values: &[f64], w: usize, step: usize) -> Vec<[f64; 2]> {
    let w = w.clamp(1, values.len().max(1));
    let middle = |begin: usize| begin as f64 + (w as f64 + 1.0) / 2.0;
    let windows = values.windows(w).enumerate().step_by(step.max(1));
    windows.map(|(begin, window)| [middle(begin), mean(window)]).collect()
}

/// The window with which the longest curve has at most so many points, at least 1 update.
pub(super) fn window_for(longest: usize, most_points: usize) -> usize {
    longest.div_ceil(most_points).max(1)
}

/// What the instances of a setting do at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spread {
    /// The update in the window's middle.
    pub(super) update: f64,
    pub(super) mean: f64,
    /// First quartile, median, third quartile.
    pub(super) quartiles: [f64; 3],
}

/// The spread of some columns over windows of w updates: at each, of those that have come so far.
pub(super) fn spreads<'a>(columns: impl Iterator<Item = &'a [f64]>, w: usize) -> Vec<Spread> {
    let curves: Vec<_> = columns.map(|column| window_means(column, w)).collect();
    let longest = curves.iter().map(Vec::len).max().unwrap_or(0);
    (0..longest)
        .filter_map(|i| {
            let points: Vec<_> = curves.iter().filter_map(|curve| curve.get(i)).collect();
            let values: Vec<_> = points.iter().map(|point| point[1]).collect();
            let ordered = sorted(&values);
            Some(Spread {
                // One that is shorter than a window has its middle elsewhere.
                update: points.iter().map(|point| point[0]).fold(0.0, f64::max),
                mean: mean(&values),
                quartiles: [0.25, 0.5, 0.75].map(|p| quantile(&ordered, p)),
            })
            .filter(|_| !points.is_empty())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_averaged_and_a_rest_is_left_out() {
        let values = [1.0, 3.0, 5.0, 7.0, 100.0];
        assert_eq!(window_means(&values, 2), [[1.5, 2.0], [3.5, 6.0]]);
        assert_eq!(window_means(&values, 1)[4], [5.0, 100.0]);
        assert_eq!(sliding_means(&values[..4], 3, 1), [[2.0, 3.0], [3.0, 5.0]]);
        // Shorter than a window: all of it.
        assert_eq!(window_means(&values[..2], 3), [[1.5, 2.0]]);
        assert_eq!(window_means(&[], 3), [[0.0; 2]; 0]);
        assert_eq!(
            [window_for(40, 100), window_for(30_000, 150), window_for(301, 150)],
            [1, 200, 3]
        );
    }

    #[test]
    fn spreads_are_of_those_that_have_come_so_far() {
        let columns = [[1.0, 10.0], [2.0, 20.0], [4.0, 40.0], [7.0, 0.0]];
        let columns = columns.iter().enumerate().map(|(i, it)| &it[..if i == 3 { 1 } else { 2 }]);
        let found = spreads(columns, 1);
        // As in statistics.rs: 1 2 4 7 have quartiles 1.75, 3 and 4.75.
        let first = Spread { update: 1.0, mean: 3.5, quartiles: [1.75, 3.0, 4.75] };
        let second = Spread { update: 2.0, mean: 70.0 / 3.0, quartiles: [15.0, 20.0, 30.0] };
        assert_eq!(found, [first, second]);
    }
}
