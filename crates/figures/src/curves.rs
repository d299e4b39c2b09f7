//! Curves as they are drawn: means over windows, which smooth and thin in one, and the spread of a
//! setting's cells.
//!
//! Windows are of rows; a row is an update, or the mean of `every` updates that follow each other.

use runs::{COLUMNS, Row};

use super::{
    Setting,
    statistics::{mean, quantile, sorted},
};

/// Means over windows of w rows, one after another, each with the number of the update in its middle.
/// A last part that is shorter is left out, but if it's all there is.
pub(super) fn window_means(values: &[f64], w: usize, every: usize) -> Vec<[f64; 2]> {
    in_updates(sliding_means(values, w, w), every)
}

/// A column of one of a setting's cells over windows of about w updates: as many whole rows.
pub(super) fn smoothed(setting: &Setting, values: &[f64], w: usize) -> Vec<[f64; 2]> {
    window_means(values, setting.rows(w), setting.every)
}

/// Points at rows, at updates: counted from 1, the row r is the updates r every - every + 1 to r every.
fn in_updates(points: Vec<[f64; 2]>, every: usize) -> Vec<[f64; 2]> {
    let middle = |row: f64| (row - 0.5) * every as f64 + 0.5;
    points.into_iter().map(|[row, mean]| [middle(row), mean]).collect()
}

/// Means over windows of w rows, `step` rows from one to the next, each with the number of the row in
/// its middle.
pub(super) fn sliding_means(values: &[f64], w: usize, step: usize) -> Vec<[f64; 2]> {
    let w = w.clamp(1, values.len().max(1));
    let middle = |begin: usize| begin as f64 + (w as f64 + 1.0) / 2.0;
    let windows = values.windows(w).enumerate().step_by(step.max(1));
    windows.map(|(begin, window)| [middle(begin), mean(window)]).collect()
}

/// The window with which the longest curve has at most so many points, at least 1 row.
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

    /// The length of its windows, in rows.
    pub(super) fn window(&self) -> usize {
        self.window
    }

    /// Over windows of w rows, a power of two that isn't below its own.
    pub(super) fn over(&self, w: usize, every: usize) -> Vec<[f64; 2]> {
        window_means(&self.means, w / self.window, self.window * every)
    }

    /// What the column always is, if it never changes but for roundings.
    pub(super) fn constant(&self) -> Option<f64> {
        let first = *self.means.first()?;
        self.means.iter().all(|mean| (mean - first).abs() <= 1e-9 * first.abs()).then_some(first)
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

    /// The column of the task's own value.
    fn task(rows: &[Row]) -> Thinned {
        let place = COLUMNS.iter().position(|it| it.name == "task").unwrap();
        Thinned::of(rows).swap_remove(place)
    }

    #[test]
    fn windows_are_averaged_and_a_rest_is_left_out() {
        let values = [1.0, 3.0, 5.0, 7.0, 100.0];
        assert_eq!(window_means(&values, 2, 1), [[1.5, 2.0], [3.5, 6.0]]);
        assert_eq!(window_means(&values, 1, 1)[4], [5.0, 100.0]);
        assert_eq!(sliding_means(&values[..4], 3, 1), [[2.0, 3.0], [3.0, 5.0]]);
        // Shorter than a window: all of it.
        assert_eq!(window_means(&values[..2], 3, 1), [[1.5, 2.0]]);
        assert_eq!(window_means(&[], 3, 1), [[0.0; 2]; 0]);
        assert_eq!(
            [window_for(40, 100), window_for(30_000, 150), window_for(301, 150)],
            [1, 200, 3]
        );
    }

    /// Of rows that are means of 10 updates the first is that of 1 to 10, whose middle is 5.5.
    #[test]
    fn rows_are_drawn_where_their_updates_are() {
        let values: Vec<_> = (0..40).map(f64::from).collect();
        let rows: Vec<_> = values.chunks(10).map(mean).collect();
        assert_eq!(window_means(&rows, 1, 10)[0], [5.5, 4.5]);
        assert_eq!(window_means(&rows, 2, 10), window_means(&values, 20, 1));
        let row = |&task: &f64| Row { task, ..Row::default() };
        let thinned = task(&rows.iter().map(row).collect::<Vec<_>>());
        assert_eq!(thinned.over(2, 10), window_means(&values, 20, 1));
        assert_eq!(thinned.constant(), None);
        assert_eq!(Thinned { window: 1, means: vec![0.1, 0.1 + 1e-17] }.constant(), Some(0.1));
    }

    #[test]
    fn spreads_are_of_those_that_have_come_so_far() {
        let columns = [[1.0, 10.0], [2.0, 20.0], [4.0, 40.0], [7.0, 0.0]];
        let columns = columns.iter().enumerate().map(|(i, it)| &it[..if i == 3 { 1 } else { 2 }]);
        let curves: Vec<_> = columns.map(|column| window_means(column, 1, 1)).collect();
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
            task(&rows)
        };
        let values: Vec<_> = (0..3000).map(f64::from).collect();
        let long = thinned(&values);
        assert_eq!((long.window(), long.means.len()), (16, 187));
        for w in [16, 32, 128] {
            // The last window of 16 isn't whole, nor is one of more.
            assert_eq!(long.over(w, 1), window_means(&values, w, 1), "{w}");
        }
        let short = thinned(&[1.0, 2.0, 6.0]);
        assert_eq!(short.over(1, 1), [[1.0, 1.0], [2.0, 2.0], [3.0, 6.0]]);
        assert_eq!(short.over(16, 1), [[2.0, 3.0]]);
        assert_eq!(thinned(&[]).over(4, 1), [[0.0; 2]; 0]);
    }
}
