//! The window's formulas, from counts.
//!
//! ```text
//! r       = [ sum_{s'} n(s,s') (ln n(s,s') - ln n(s')) + n(s) (ln N - ln n(s)) ] / n(s)
//! I(S;S') = [ sum_{s,s'} n(s,s') ln n(s,s') - sum_s n(s) ln n(s) - sum_{s'} n(s') ln n(s')
//!             + N ln N ] / N
//! ```
//!
//! Logs are integers, so both brackets are exact in whatever order they're summed.

use super::counts::Counts;
use crate::{information::Estimator, logs};

/// r_t in nats. `ln`: \[> n_pairs\], ln n in units of 2^-53.
pub(super) fn specific_surprise(
    counts: &Counts,
    n_pairs: usize,
    ln: &[i64],
    estimator: Estimator,
) -> f64 {
    if n_pairs == 0 {
        return 0.0;
    }
    let n_first = counts.newest_first();
    let (mut sum, mut n_successors) = (0_i128, 0_u32);
    counts.for_each_successor(|pair, second| {
        sum += i128::from(pair) * i128::from(ln[pair as usize] - ln[second as usize]);
        n_successors += 1;
    });
    sum += i128::from(n_first) * i128::from(ln[n_pairs] - ln[n_first as usize]);
    let plug_in = logs::nats(sum, u64::from(n_first)).max(0.0);
    match estimator {
        Estimator::PlugIn => plug_in,
        Estimator::MillerMadow => {
            let seconds = (counts.n_seconds() as f64 - 1.0) / (2.0 * n_pairs as f64);
            let successors = (f64::from(n_successors) - 1.0) / (2.0 * f64::from(n_first));
            plug_in + seconds - successors
        }
    }
}

/// I(S; S') in nats. `ln`: as above.
pub(super) fn mutual_information(
    counts: &Counts,
    n_pairs: usize,
    ln: &[i64],
    estimator: Estimator,
) -> f64 {
    if n_pairs == 0 {
        return 0.0;
    }
    let n_ln_n = |n: usize| n as i128 * i128::from(ln[n]);
    let sum_over = |counts: &[u32]| counts.iter().map(|&n| n_ln_n(n as usize)).sum::<i128>();
    let [firsts, seconds, pairs] = counts.all();
    let sum = sum_over(pairs) - sum_over(firsts) - sum_over(seconds) + n_ln_n(n_pairs);
    let plug_in = logs::nats(sum, n_pairs as u64).max(0.0);
    match estimator {
        Estimator::PlugIn => plug_in,
        Estimator::MillerMadow => {
            let [firsts, seconds, pairs] =
                [firsts, seconds, pairs].map(|c| c.iter().filter(|&&n| n > 0).count() as f64);
            plug_in + (firsts + seconds - pairs - 1.0) / (2.0 * n_pairs as f64)
        }
    }
}
