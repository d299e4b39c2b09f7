//! What a cell came to: its first, best and last window of what the run is judged by, whether it
//! made significant progress, whether it collapsed; and which cells of a setting are its best and
//! its median.
//!
//! The paper says that "more than half the instances did not make any significant progress" with
//! the task's reward alone, and that "sometimes the performance drops sharply", and defines neither.
//! Here, with the run's window of W updates, in whole rows, and windows counted back from a cell's end
//! (of several runs together each has its own window, and the largest gain is that of all):
//!
//! - The *gain* of a window is its mean minus that of the cell's first W updates; G is the
//!   largest gain of all windows of all cells of the run.
//! - A window shows *significant progress* if its gain is at least G/10, and larger than 0 by Welch's
//!   one-sided t-test at 5 %. The test compares means of up to ten batches of each window, since
//!   successive updates aren't independent. Without the first condition thousands of updates would
//!   make the smallest gain significant; without the second, noise would count where G is small.
//! - A cell made significant progress if its last window shows it.
//! - It *collapsed* if its best window shows it, and its last one has less than half of that gain.
//!
//! With fewer than 2 W updates, or W of one row, neither can be told.

use std::ops::Range;

use super::{
    CellResults, Results, Setting,
    statistics::{mean, welch_p},
};

/// Of the run's largest gain.
const SUBSTANTIAL: f64 = 0.1;
/// Of the t-test.
const LEVEL: f64 = 0.05;
/// Of a window, for the t-test.
const BATCHES: usize = 10;

/// The updates of an early and of a late window: a tenth of these, at least 1.
#[must_use]
pub fn tenth_of(updates: u64) -> u64 {
    (updates / 10).max(1)
}

/// What a cell came to, in the unit of the run's measure for each control step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// The mean of the first window.
    pub first: f64,
    /// The mean of the best window.
    pub best: f64,
    /// The mean of the last window.
    pub last: f64,
    /// Whether it made significant progress, if that can be told.
    pub progressed: Option<bool>,
    /// Whether it collapsed, if that can be told.
    pub collapsed: Option<bool>,
    /// Whether it has fewer updates than the run's longest cell.
    pub is_behind: bool,
}

/// The windows of a cell.
struct Windows {
    first: Range<usize>,
    best: Range<usize>,
    last: Range<usize>,
}

impl Outcome {
    /// Fills in the windows of some runs, each by its own longest cell, and the outcomes of all cells,
    /// by the largest gain of all runs.
    pub(super) fn evaluate(runs: &mut [Results]) {
        for run in &mut *runs {
            let tenth = tenth_of(run.longest() as u64) as usize;
            for setting in &mut run.settings {
                setting.window = setting.rows(tenth) * setting.every;
            }
        }
        let largest_gain = runs.iter().flat_map(|run| &run.settings).map(largest_gain);
        let largest_gain = largest_gain.fold(0.0, f64::max);
        for run in runs {
            let longest = run.longest();
            for setting in &mut run.settings {
                let window = setting.window_rows();
                for cell in &mut setting.cells {
                    cell.outcome = Self {
                        is_behind: cell.updates() < longest,
                        ..Self::of(&cell.performance, window, largest_gain)
                    };
                }
            }
        }
    }

    fn of(values: &[f64], window: usize, largest_gain: f64) -> Self {
        let windows = Windows::of(values, window);
        let [first, best, last] =
            [&windows.first, &windows.best, &windows.last].map(|it| mean(&values[it.clone()]));
        let progressed = |it: &Range<usize>| {
            let gain = mean(&values[it.clone()]) - first;
            let batches = [it, &windows.first].map(|it| batches(&values[it.clone()]));
            let p = welch_p(&batches[0], &batches[1])?;
            (values.len() >= 2 * window)
                .then_some(gain > 0.0 && gain >= SUBSTANTIAL * largest_gain && p < LEVEL)
        };
        let lost = last - first < (best - first) / 2.0;
        Self {
            first,
            best,
            last,
            progressed: progressed(&windows.last),
            collapsed: progressed(&windows.best).map(|it| it && lost),
            is_behind: false,
        }
    }
}

/// Of the windows of a setting's cells.
fn largest_gain(setting: &Setting) -> f64 {
    let gain = |cell: &CellResults| {
        let values = &cell.performance;
        let windows = Windows::of(values, setting.window_rows());
        mean(&values[windows.best]) - mean(&values[windows.first])
    };
    setting.cells.iter().map(gain).fold(0.0, f64::max)
}

impl Windows {
    fn of(values: &[f64], window: usize) -> Self {
        let n = values.len();
        let window = window.min(n);
        let back = (0..n / window).map(|i| n - (i + 1) * window..n - i * window);
        let higher = |a: &Range<usize>, b: &Range<usize>| {
            mean(&values[a.clone()]).total_cmp(&mean(&values[b.clone()]))
        };
        let last = n - window..n;
        Self { first: 0..window, best: back.max_by(higher).unwrap_or(last.clone()), last }
    }
}

/// Means of up to ten parts, as long as each other to one value.
fn batches(values: &[f64]) -> Vec<f64> {
    let (n, n_batches) = (values.len(), BATCHES.min(values.len()));
    let bound = |i: usize| i * n / n_batches;
    (0..n_batches).map(|i| mean(&values[bound(i)..bound(i + 1)])).collect()
}

/// Which cells of a setting are looked at closely. Indices of its cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The highest last-window mean.
    pub best: usize,
    /// The second highest; none with one cell.
    pub second: Option<usize>,
    /// The median one; of an even number the lower one of the two in the middle.
    pub median: usize,
}

/// Of some cells, at least one; equal ones in their order.
pub(super) fn choice(cells: &[CellResults]) -> Choice {
    let mut order: Vec<_> = (0..cells.len()).collect();
    order.sort_by(|&a, &b| cells[b].outcome.last.total_cmp(&cells[a].outcome.last));
    Choice { best: order[0], second: order.get(1).copied(), median: order[order.len() / 2] }
}

/// The best, the second best and the median cell of each setting, by the mean of the last window.
#[must_use]
pub fn best_and_median(run: &Results) -> Vec<Choice> {
    run.settings.iter().map(|setting| choice(&setting.cells)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::run_of;

    /// Ten windows of ten updates around these means.
    fn curve(means: [f64; 10]) -> Vec<f64> {
        let noise = |i: usize| if i.is_multiple_of(2) { 0.1 } else { -0.1 };
        means.iter().flat_map(|m| (0..10).map(move |i| m + noise(i))).collect()
    }

    fn outcomes(curves: Vec<Vec<f64>>) -> Vec<Outcome> {
        let run = run_of(&[("xi=1", curves)]);
        run.cells().map(|cell| cell.outcome).collect()
    }

    #[test]
    fn progress_is_a_tenth_of_the_largest_gain_and_not_noise() {
        let rising = curve([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 9.0, 10.0]);
        let slow = curve([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.9]);
        let enough = curve([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.1]);
        let sinking = curve([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -5.0]);
        let found = outcomes(vec![rising, slow, enough, sinking]);
        let progressed: Vec<_> = found.iter().map(|it| it.progressed.unwrap()).collect();
        assert_eq!(progressed, [true, false, true, false]);
        assert!(found.iter().all(|it| it.collapsed == Some(false)));
        assert!((found[0].last - 10.0).abs() < 1e-12 && found[0].first.abs() < 1e-12);

        // Alone, its gain is the largest; but it's less than the noise.
        let noisy = curve([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.02]);
        assert_eq!(outcomes(vec![noisy])[0].progressed, Some(false));
    }

    #[test]
    fn a_collapse_loses_half_of_what_was_gained() {
        let to = |end| curve([0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 10.0, 8.0, 6.0, end]);
        let found = outcomes(vec![to(4.9), to(5.1), to(0.0)]);
        let both: Vec<_> =
            found.iter().map(|it| (it.progressed.unwrap(), it.collapsed.unwrap())).collect();
        // The first still has made progress.
        assert_eq!(both, [(true, true), (true, false), (false, true)]);
        assert!((found[0].best - 10.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_too_short_to_tell_is_not_told() {
        let long = curve([0.0; 10]);
        let short = long[..15].to_vec();
        let found = outcomes(vec![long, short, vec![3.0]]);
        assert_eq!(found[0].progressed, Some(false));
        assert_eq!((found[1].progressed, found[1].collapsed), (None, None));
        assert_eq!((found[2].first, found[2].last, found[2].progressed), (3.0, 3.0, None));
        let behind: Vec<_> = found.iter().map(|it| it.is_behind).collect();
        assert_eq!(behind, [false, true, true]);
    }

    #[test]
    fn best_second_and_median_are_by_the_last_window() {
        let flat = |value: f64| vec![value; 20];
        let choice = |values: &[f64]| {
            let run = run_of(&[("base", values.iter().map(|&value| flat(value)).collect())]);
            best_and_median(&run)[0]
        };
        let of = |best, second, median| Choice { best, second, median };
        assert_eq!(choice(&[1.0, 5.0, 3.0, 4.0, 2.0]), of(1, Some(3), 2));
        // 4 3 | 2 1: the lower one.
        assert_eq!(choice(&[1.0, 2.0, 3.0, 4.0]), of(3, Some(2), 1));
        assert_eq!(choice(&[7.0]), of(0, None, 0));
        assert_eq!(choice(&[7.0, 7.0, 7.0]), of(0, Some(1), 1));
    }
}
