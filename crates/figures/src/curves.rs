//! Curves as they are drawn: means over windows, which smooth and thin in one, and the spread of a
//! setting's cells.

use runs::{COLUMNS, Row};

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

/// Windows that a [`Thinned`] column has at most.
const KEPT: usize = 256;

/// A column so thin that all of them can be kept of all cells: means over windows. Their length is
/// a power of two, so that columns of any length can be drawn over the same windows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Thinned {
    window: usize,
    means: Vec<f64>,
}

impl Thinned {
    /// All of [`COLUMNS`], in their order. Last rows that don't fill a window are left out.
    pub(super) fn of(rows: &[Row]) -> Vec<Self> {
        let window = rows.len().div_ceil(KEPT).next_power_of_two();
        let mut columns: Vec<_> =
            COLUMNS.iter().map(|_| Self { window, means: Vec::with_capacity(KEPT) }).collect();
        // Row by row, which is as they lie in memory.
        for rows in rows.chunks_exact(window) {
            for (thinned, column) in columns.iter_mut().zip(&COLUMNS) {
                let sum: f64 = rows.iter().map(column.value).sum();
                thinned.means.push(sum / window as f64);
            }
        }
        columns
    }

    /// The length of its windows.
    pub(super) fn window(&self) -> usize {
        self.window
    }

    /// Over windows of w updates, a power of two that isn't below its own.
    pub(super) fn over(&self, w: usize) -> Vec<[f64; 2]> {
        let window = self.window as f64;
        let points = window_means(&self.means, w / self.window);
        // The middle of a window is counted in windows here.
        points.into_iter().map(|[middle, mean]| [(middle - 0.5) * window + 0.5, mean]).collect()
    }

    #[cfg(test)]
    pub(super) fn fill(&mut self, value: f64) {
        self.means.fill(value);
    }
}

/// What the cells of a setting do at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spread {
    /// The update in the window's middle.
    pub(super) update: f64,
    pub(super) mean: f64,
    /// A lower one, the median and an upper one.
    pub(super) quantiles: [f64; 3],
}

/// First quartile, median, third quartile.
pub(super) const QUARTILES: [f64; 3] = [0.25, 0.5, 0.75];
/// Lowest, median, highest.
pub(super) const EXTREMES: [f64; 3] = [0.0, 0.5, 1.0];

/// The spread of some curves, with the quantiles of these probabilities: at each point of those
/// that have come so far and are finite there.
pub(super) fn spreads(curves: &[Vec<[f64; 2]>], quantiles: [f64; 3]) -> Vec<Spread> {
    let longest = curves.iter().map(Vec::len).max().unwrap_or(0);
    (0..longest)
        .filter_map(|i| {
            let points = curves.iter().filter_map(|curve| curve.get(i));
            let points: Vec<_> = points.filter(|point| point[1].is_finite()).collect();
            let values: Vec<_> = points.iter().map(|point| point[1]).collect();
            let ordered = sorted(&values);
            Some(Spread {
                // One that is shorter than a window has its middle elsewhere.
                update: points.iter().map(|point| point[0]).fold(0.0, f64::max),
                mean: mean(&values),
                quantiles: quantiles.map(|p| quantile(&ordered, p)),
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
        let curves: Vec<_> = columns.map(|column| window_means(column, 1)).collect();
        let found = spreads(&curves, QUARTILES);
        // As in statistics.rs: 1 2 4 7 have quartiles 1.75, 3 and 4.75.
        let first = Spread { update: 1.0, mean: 3.5, quantiles: [1.75, 3.0, 4.75] };
        let second = Spread { update: 2.0, mean: 70.0 / 3.0, quantiles: [15.0, 20.0, 30.0] };
        assert_eq!(found, [first, second]);
        assert_eq!(spreads(&curves, EXTREMES)[0].quantiles, [1.0, 3.0, 7.0]);
        let unknown = [vec![[1.0, f64::NAN], [2.0, 5.0]], vec![[1.0, f64::INFINITY]]];
        let found: Vec<_> =
            spreads(&unknown, EXTREMES).iter().map(|it| (it.update, it.mean)).collect();
        assert_eq!(found, [(2.0, 5.0)]);
    }

    #[test]
    fn thin_columns_are_the_means_of_thick_ones() {
        let thinned = |values: &[f64]| {
            let row = |&task: &f64| Row { task, ..Row::default() };
            let rows: Vec<_> = values.iter().map(row).collect();
            Thinned::of(&rows).pop().unwrap()
        };
        let values: Vec<_> = (0..3000).map(f64::from).collect();
        let long = thinned(&values);
        assert_eq!((long.window(), long.means.len()), (16, 187));
        for w in [16, 32, 128] {
            // The last window of 16 isn't whole, nor is one of more.
            assert_eq!(long.over(w), window_means(&values, w), "{w}");
        }
        let short = thinned(&[1.0, 2.0, 6.0]);
        assert_eq!(short.over(1), [[1.0, 1.0], [2.0, 2.0], [3.0, 6.0]]);
        assert_eq!(short.over(16), [[2.0, 3.0]]);
        assert_eq!(thinned(&[]).over(4), [[0.0; 2]; 0]);
    }
}
