//! Statistics of cells, as reinforcement learning reports them.
//!
//! | what | definition |
//! |---|---|
//! | quantile | linear between order statistics: h = (n - 1) p, x_(h) (Hyndman and Fan 1996, type 7; NumPy's) |
//! | interquartile mean (IQM) | mean without the floor(n/4) smallest and the floor(n/4) largest values |
//! | interval | percentile bootstrap, cells drawn with replacement within each stratum |
//! | performance profile | F(tau): the share of values above tau |
//! | probability of improvement | P(X > Y) + P(X = Y) / 2 over all pairs (Mann and Whitney 1947) |
//! | Pearson | r = sum (x - mx)(y - my) / sqrt(sum (x - mx)^2 sum (y - my)^2) |
//! | share | Wilson's score interval (JASA 22, 1927) |
//! | Welch | t = (ma - mb) / sqrt(va / na + vb / nb), degrees of freedom of Welch and Satterthwaite |
//! | paired | t = m / (s / sqrt(n)) of n differences, n - 1 degrees of freedom (Student, Biometrika 6, 1908) |
//!
//! IQM, the stratified bootstrap, profiles and the probability of improvement are those of R. Agarwal et al.,
//! *Deep Reinforcement Learning at the Edge of the Statistical Precipice*, NeurIPS 2021, and of its
//! library rliable: there a stratum is a task, here it's a setting.

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use runs::Moments;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Of all bootstraps: the same runs give the same intervals.
const SEED: u64 = 2021;

/// Between these quantiles of the replicates lies the interval: 95 %.
const LEVELS: [f64; 2] = [0.025, 0.975];

/// Cells from which a 95 % interval can be told. Replicates of a mean or an IQM never leave the
/// sample's range, and with a probability of 2^(1-n) all n values lie on one side of what they are
/// drawn around: 50 % of 2, 25 % of 3, still 6 % of 5.
pub const FEWEST_FOR_INTERVAL: usize = 6;

/// A 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The lower end of the interval.
    pub low: f64,
    /// The upper end of the interval.
    pub high: f64,
}

/// The mean; NaN of nothing.
#[must_use]
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The standard deviation of a sample; none of fewer than two values.
#[must_use]
pub fn deviation(values: &[f64]) -> Option<f64> {
    variance(values).map(f64::sqrt)
}

fn variance(values: &[f64]) -> Option<f64> {
    let (n, m) = (values.len() as f64, mean(values));
    let squares: f64 = values.iter().map(|value| (value - m) * (value - m)).sum();
    (values.len() > 1).then(|| squares / (n - 1.0))
}

/// The values in increasing order.
#[must_use]
pub fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// A quantile, `p` within 0 to 1, of values in increasing order; NaN of nothing.
#[must_use]
pub fn quantile(sorted: &[f64], p: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = last as f64 * p;
    let below = (place as usize).min(last);
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

/// The interquartile mean; NaN of nothing.
#[must_use]
pub fn interquartile_mean(values: &[f64]) -> f64 {
    let sorted = sorted(values);
    let cut = sorted.len() / 4;
    mean(&sorted[cut..sorted.len() - cut])
}

/// The share of values above a score; NaN of nothing.
#[must_use]
pub fn share_above(values: &[f64], score: f64) -> f64 {
    values.iter().filter(|&&value| value > score).count() as f64 / values.len() as f64
}

/// The probability that a value of `x` is larger than one of `y`; NaN if there's none of either.
#[must_use]
pub fn probability_of_improvement(x: &[f64], y: &[f64]) -> f64 {
    let y = sorted(y);
    let wins = x.iter().map(|x| {
        let below = y.partition_point(|y| y < x);
        let not_above = y.partition_point(|y| y <= x);
        (below + not_above) as f64 / 2.0
    });
    wins.sum::<f64>() / (x.len() * y.len()) as f64
}

/// The percentile bootstrap's 95 % interval of a statistic of some strata.
#[must_use]
pub fn bootstrap(
    strata: &[&[f64]],
    n_replicates: usize,
    statistic: impl Fn(&[Vec<f64>]) -> f64,
) -> Interval {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let mut drawn: Vec<Vec<f64>> = strata.iter().map(|stratum| stratum.to_vec()).collect();
    let replicates = (0..n_replicates).map(|_| {
        for (drawn, stratum) in drawn.iter_mut().zip(strata) {
            let n = stratum.len() as u64;
            // Uniform to one part in 2^32 / n.
            let mut index = || ((u64::from(random.next_u32()) * n) >> 32) as usize;
            drawn.iter_mut().for_each(|value| *value = stratum[index()]);
        }
        statistic(&drawn)
    });
    let replicates = sorted(&replicates.collect::<Vec<_>>());
    let [low, high] = LEVELS.map(|p| quantile(&replicates, p));
    Interval { low, high }
}

/// The moments of pairs (x, y), gone through twice.
#[must_use]
pub fn moments(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> Moments {
    let mut of = Moments::default();
    for (x, y) in pairs.clone() {
        of.n += 1;
        let n = of.n as f64;
        of.means = [of.means[0] + (x - of.means[0]) / n, of.means[1] + (y - of.means[1]) / n];
    }
    for (x, y) in pairs {
        let (x, y) = (x - of.means[0], y - of.means[1]);
        of.sums = [of.sums[0] + x * x, of.sums[1] + x * y, of.sums[2] + y * y];
    }
    of
}

/// The moments of two samples together (Chan, Golub and LeVeque 1979).
#[must_use]
pub fn together(a: Moments, b: Moments) -> Moments {
    let n = a.n + b.n;
    if a.n == 0 || b.n == 0 {
        return if a.n == 0 { b } else { a };
    }
    let share = b.n as f64 / n as f64;
    let [x, y] = [0, 1].map(|i| b.means[i] - a.means[i]);
    let weight = a.n as f64 * share;
    let between = [x * x * weight, x * y * weight, y * y * weight];
    Moments {
        n,
        means: [a.means[0] + x * share, a.means[1] + y * share],
        sums: std::array::from_fn(|i| a.sums[i] + b.sums[i] + between[i]),
    }
}

/// The sample correlation; none of fewer than two pairs, or if one side is constant.
#[must_use]
pub fn pearson(moments: Moments) -> Option<f64> {
    let [xx, xy, yy] = moments.sums;
    let r = xy / (xx.sqrt() * yy.sqrt());
    r.is_finite().then(|| r.clamp(-1.0, 1.0))
}

/// The 95 % interval of a share of which `n_true` of `n` were found: Wilson's score interval, which
/// has a width also where all or none were.
#[must_use]
pub fn wilson(n_true: usize, n: usize) -> Interval {
    const Z: f64 = 1.959_963_984_540_054;
    let (share, n) = (n_true as f64 / n as f64, n as f64);
    let middle = share + Z * Z / (2.0 * n);
    let half = Z * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
    let [low, high] = [middle - half, middle + half].map(|end| end / (1.0 + Z * Z / n));
    // By the formula it's 0 if none is and 1 if all are, which rounding doesn't always meet.
    let low = if n_true == 0 { 0.0 } else { low.max(0.0) };
    let high = if share == 1.0 { 1.0 } else { high.min(1.0) };
    Interval { low, high }
}

/// The probability, if both have the same mean, that `a` exceeds `b` as far or further by chance:
/// Welch's t-test, one-sided. None with fewer than two values on a side.
#[must_use]
pub fn welch_p(a: &[f64], b: &[f64]) -> Option<f64> {
    // Of the means, and the degrees of freedom of that.
    let squared_error = |values: &[f64]| {
        let n = values.len() as f64;
        variance(values).map(|variance| (variance / n, n - 1.0))
    };
    let [error_a, error_b] = [squared_error(a)?, squared_error(b)?];
    let variance = error_a.0 + error_b.0;
    let difference = mean(a) - mean(b);
    if variance == 0.0 {
        return Some(if difference > 0.0 { 0.0 } else { 1.0 });
    }
    let each = error_a.0 * error_a.0 / error_a.1 + error_b.0 * error_b.0 / error_b.1;
    upper_tail(difference / variance.sqrt(), variance * variance / each)
}

/// t, and the probability of one at least as high by chance if differences have a mean of 0: the
/// paired t-test, one-sided. None for fewer than two differences, or for equal ones.
#[must_use]
pub fn paired_t(differences: &[f64]) -> Option<(f64, f64)> {
    let n = differences.len() as f64;
    let t = mean(differences) / (deviation(differences)? / n.sqrt());
    if t.is_finite() { Some((t, upper_tail(t, n - 1.0)?)) } else { None }
}

/// The probability that Student's t with these degrees of freedom is `t` or more.
fn upper_tail(t: f64, freedom: f64) -> Option<f64> {
    StudentsT::new(0.0, 1.0, freedom).ok().map(|distribution| distribution.sf(t))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of a few numbers of about 1: a few roundings.
    #[track_caller]
    fn is_near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
    }

    #[test]
    fn quantiles_lie_between_order_statistics() {
        let values = sorted(&[7.0, 1.0, 2.0, 4.0]);
        // (n - 1) p is 0.75, 1.5 and 2.25.
        is_near(quantile(&values, 0.25), 1.75);
        is_near(quantile(&values, 0.5), 3.0);
        is_near(quantile(&values, 0.75), 4.75);
        is_near(quantile(&values, 0.0), 1.0);
        is_near(quantile(&values, 1.0), 7.0);
        is_near(quantile(&[3.0], 0.25), 3.0);
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn the_interquartile_mean_leaves_a_quarter_out_at_each_end() {
        is_near(interquartile_mean(&[100.0, 3.0, 1.0, -50.0]), 2.0);
        // floor(7 / 4) = 1 at each end: (2 + 3 + 4 + 5 + 6) / 5.
        is_near(interquartile_mean(&[7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0]), 4.0);
        // Three are too few to leave any out.
        is_near(interquartile_mean(&[1.0, 2.0, 6.0]), 3.0);
    }

    #[test]
    fn improvement_counts_pairs_and_half_of_the_ties() {
        // 3 > 1, 3 > 2, 3 = 3; 2 > 1, 2 = 2, 2 < 3: (2.5 + 1.5) / 6.
        is_near(probability_of_improvement(&[3.0, 2.0], &[1.0, 2.0, 3.0]), 4.0 / 6.0);
        is_near(probability_of_improvement(&[1.0, 2.0, 3.0], &[3.0, 2.0]), 2.0 / 6.0);
        is_near(probability_of_improvement(&[5.0], &[5.0]), 0.5);
        assert!(probability_of_improvement(&[], &[1.0]).is_nan());
    }

    /// Two values, 0 and 1, have means 0, 1/2 and 1 with probabilities 1/4, 1/2 and 1/4, so the
    /// quantiles at 2.5 % and 97.5 % are 0 and 1. Five values of 0 to 1 by quarters: P(mean = 0) is
    /// 5^-5 and the interval's ends are near the normal's, 0.5 -+ 1.96 sqrt(0.125 / 5).
    #[test]
    fn the_bootstrap_draws_with_replacement() {
        let mean_of = |drawn: &[Vec<f64>]| mean(&drawn[0]);
        assert_eq!(bootstrap(&[&[0.0, 1.0]], 1000, mean_of), Interval { low: 0.0, high: 1.0 });
        assert_eq!(bootstrap(&[&[0.3]], 10, mean_of), Interval { low: 0.3, high: 0.3 });
        let five = bootstrap(&[&[0.0, 0.25, 0.5, 0.75, 1.0]], 20_000, mean_of);
        let half = 1.96 * (0.125_f64 / 5.0).sqrt();
        // Means are multiples of 0.05.
        assert!((five.low - (0.5 - half)).abs() <= 0.05, "{five:?}");
        assert!((five.high - (0.5 + half)).abs() <= 0.05, "{five:?}");
    }

    /// Were values drawn from the other stratum, some difference would not be 10.
    #[test]
    fn strata_do_not_mix_and_the_seed_is_fixed() {
        let difference = |drawn: &[Vec<f64>]| mean(&drawn[1]) - mean(&drawn[0]);
        let apart = bootstrap(&[&[1.0, 1.0], &[11.0, 11.0, 11.0]], 100, difference);
        assert_eq!(apart, Interval { low: 10.0, high: 10.0 });
        let again = || bootstrap(&[&[1.0, 2.0, 5.0, 9.0]], 100, |drawn| mean(&drawn[0]));
        assert_eq!(again(), again());
    }

    /// Deviations -2 -1 0 1 2 and -1 -2 1 0 2: sums of squares 10 and 10, of products 8.
    #[test]
    fn pearson_is_the_normalised_covariance() {
        let y = [3.0, 2.0, 5.0, 4.0, 6.0];
        let pairs = (1..=5).map(f64::from).zip(y);
        let of = |pairs: &[(f64, f64)]| pearson(moments(pairs.iter().copied()));
        is_near(pearson(moments(pairs.clone())).unwrap(), 0.8);
        is_near(pearson(moments(pairs.map(|(x, y)| (x, -y)))).unwrap(), -0.8);
        assert_eq!(of(&[(1.0, 2.0)]), None);
        assert_eq!(of(&[(1.0, 2.0), (2.0, 2.0)]), None);
        assert_eq!(of(&[]), None);
    }

    #[test]
    fn moments_of_parts_are_those_of_the_whole() {
        let pairs: Vec<_> = (0..20).map(|i| (f64::from(i * i % 7), f64::from(i % 5))).collect();
        let of = |pairs: &[(f64, f64)]| moments(pairs.iter().copied());
        let whole = of(&pairs);
        let parts = [0..3, 3..3, 3..12, 12..20].map(|part| of(&pairs[part]));
        let found = parts.into_iter().fold(Moments::default(), together);
        assert_eq!(found.n, 20);
        for i in 0..2 {
            is_near(found.means[i], whole.means[i]);
        }
        for i in 0..3 {
            is_near(found.sums[i], whole.sums[i]);
        }
    }

    /// As R has it: prop.test(x, n, correct = FALSE).
    #[test]
    fn a_share_has_wilsons_interval() {
        let near = |found: Interval, low: f64, high: f64| {
            assert!(
                (found.low - low).abs() < 5e-5 && (found.high - high).abs() < 5e-5,
                "{found:?}"
            );
        };
        near(wilson(6, 8), 0.4093, 0.9285);
        near(wilson(8, 8), 0.6756, 1.0);
        near(wilson(0, 30), 0.0, 0.1135);
    }

    /// Means 4 and 2, variances 4 and 1, n = 3: t = 2 / sqrt(5/3) = 1.549, and the degrees of freedom
    /// are (5/3)^2 / (16/18 + 1/18) = 2.941. A table of t with 3 has .1 at 1.638 and .15 at 1.250.
    #[test]
    fn welchs_test_is_one_sided() {
        let (a, b) = ([2.0, 4.0, 6.0], [1.0, 2.0, 3.0]);
        let p = welch_p(&a, &b).unwrap();
        assert!((0.10..0.13).contains(&p), "{p}");
        is_near(welch_p(&b, &a).unwrap(), 1.0 - p);
        assert_eq!(welch_p(&[1.0, 1.0], &[0.0, 0.0]), Some(0.0));
        assert_eq!(welch_p(&[0.0, 0.0], &[0.0, 0.0]), Some(1.0));
        assert_eq!(welch_p(&[0.0], &[0.0, 1.0]), None);
    }

    /// Student's own example: extra hours of sleep by one drug over another, ten patients; t is
    /// 4.06, and a table gives .0014 for it.
    #[test]
    fn the_paired_test_is_students() {
        let gains = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4];
        let (t, p) = paired_t(&gains).unwrap();
        // To the places that are published.
        assert!((t - 4.062).abs() < 5e-4, "{t}");
        assert!((p - 0.001_42).abs() < 5e-6, "{p}");
        assert_eq!(paired_t(&[1.0]), None);
        assert_eq!(paired_t(&[1.0, 1.0]), None);
        assert_eq!(deviation(&[1.0, 3.0]), Some(2.0_f64.sqrt()));
        assert_eq!(deviation(&[1.0]), None);
    }

    /// Without a formula for it: of many samples of n values around 0, how many have an interval with
    /// 0 in it? With fewer than [`FEWEST_FOR_INTERVAL`] 95 % can't be had, whatever is drawn.
    #[test]
    fn a_sample_of_few_misses_the_middle_too_often() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut value = || f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5;
        for n in 2..=8 {
            let samples = 4000;
            let inside = (0..samples).filter(|_| {
                let sample: Vec<_> = (0..n).map(|_| value()).collect();
                sample.iter().any(|it| *it < 0.0) && sample.iter().any(|it| *it > 0.0)
            });
            let share = inside.count() as f64 / f64::from(samples);
            // Three standard errors of a share of 4000.
            let error = 3.0 * (0.25_f64 / f64::from(samples)).sqrt();
            assert!((share - (1.0 - 0.5_f64.powi(n - 1))).abs() < error, "{n}: {share}");
            assert_eq!(1.0 - 0.5_f64.powi(n - 1) >= 0.95, n as usize >= FEWEST_FOR_INTERVAL);
        }
    }
}
