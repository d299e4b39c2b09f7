//! The sampler and the Monte-Carlo score against enumeration.
//!
//! Every test has a fixed seed. A test's false-alarm rate is the probability that another seed
//! would have failed it, had the code been right.
#![allow(clippy::unwrap_used, missing_docs)]

#[allow(dead_code, unreachable_pub, clippy::needless_range_loop)]
mod plain;

use crbm::{Exact, Layout, Mask, Policy, Sampling};
use plain::Plain;

/// Of y after a number of Gibbs updates from a uniform start, by enumeration: `[2^n_outputs]`.
fn distribution_after(exact: &Exact, layout: &Layout, x: &[bool], updates: usize) -> Vec<f64> {
    let (m, n) = (layout.n_hidden(), layout.n_outputs());
    let bits = |number: usize| (0..m).map(move |j| number >> j & 1 == 1);
    let product = |on: &[f64], bits: &[bool]| -> f64 {
        on.iter().zip(bits).map(|(p, on)| if *on { *p } else { 1.0 - p }).product()
    };
    let mut of_y = vec![1.0 / (1 << n) as f64; 1 << n];
    for _ in 0..updates {
        let mut after = vec![0.0; 1 << n];
        let hidden: Vec<Vec<f64>> =
            (0..1 << n).map(|y| exact.hidden_probabilities(x, &exact.output(y)).unwrap()).collect();
        for h in 0..1 << m {
            let h: Vec<bool> = bits(h).collect();
            let of_h: f64 = of_y.iter().zip(&hidden).map(|(p, on)| p * product(on, &h)).sum();
            let outputs = exact.output_probabilities(&h).unwrap();
            for (y, after) in after.iter_mut().enumerate() {
                *after += of_h * product(&outputs, &exact.output(y));
            }
        }
        of_y = after;
    }
    of_y
}

/// P(chi-square with `freedom` degrees >= `value`), by the recursion over two degrees.
fn chi_square_tail(value: f64, freedom: usize) -> f64 {
    let x = value / 2.0;
    let (mut a, mut tail) =
        if freedom.is_multiple_of(2) { (1.0, (-x).exp()) } else { (0.5, libm::erfc(x.sqrt())) };
    while a < freedom as f64 / 2.0 - 0.25 {
        tail += (a * x.ln() - x - libm::lgamma(a + 1.0)).exp();
        a += 1.0;
    }
    tail
}

/// Asserts that counts are of a distribution; false-alarm rate 1e-6.
fn assert_fits(counts: &[u64], probabilities: &[f64], what: &str) {
    let total: u64 = counts.iter().sum();
    let (mut sum, mut cells, mut rest) = (0.0, 0, (0.0, 0.0));
    let mut add = |count: f64, expected: f64| {
        sum += (count - expected).powi(2) / expected;
        cells += 1;
    };
    for (count, p) in counts.iter().zip(probabilities) {
        let (count, expected) = (*count as f64, p * total as f64);
        // The statistic's distribution is the limit's from some 10 expected on; rarer ones go
        // together.
        if expected < 10.0 {
            rest = (rest.0 + count, rest.1 + expected)
        } else {
            add(count, expected)
        }
    }
    if rest.1 > 0.0 {
        add(rest.0, rest.1.max(1.0));
    }
    let tail = chi_square_tail(sum, cells - 1);
    assert!(tail > 1e-6, "{what}: chi-square {sum:.1} of {cells} cells, tail {tail:e}");
}

/// As `Exact::number`.
fn number(y: &[bool]) -> usize {
    y.iter().enumerate().map(|(i, on)| usize::from(*on) << i).sum()
}

fn counts(policy: &mut Policy, x: &[bool], calls: usize) -> Vec<u64> {
    let n = policy.layout().n_outputs();
    let mut rng = policy.rng(1, "counts");
    let mut counts = vec![0; 1 << n];
    let mut samples = vec![false; n * policy.n_chains()];
    for _ in 0..calls {
        policy.sample(x, &mut rng, &mut samples).unwrap();
        samples.chunks(n).for_each(|y| counts[number(y)] += 1);
    }
    counts
}

#[test]
fn the_tail_of_chi_square_is_that_of_tables() {
    for (value, freedom, tail) in [(3.841, 1, 0.05), (18.307, 10, 0.05), (52.191, 31, 0.01)] {
        assert!((chi_square_tail(value, freedom) - tail).abs() < 1e-4, "{freedom}");
    }
}

#[test]
fn after_any_number_of_updates_samples_have_the_exact_distribution() {
    let masked = Layout::new(
        Mask::from_fn(7, 2, |j, k| (j + k) % 2 == 0).unwrap(),
        Mask::blocks(1, &[0, 1, 2, 3, 3, 4, 6]).unwrap(),
    );
    for layout in [Layout::full(2, 5, 4), Layout::full(2, 4, 5), Layout::full(2, 0, 3), masked] {
        let layout = layout.unwrap();
        let parameters = layout.random_parameters(1.5, 2, "sampling").unwrap();
        let exact = Exact::new(&layout, &parameters).unwrap();
        for updates in [0, 1, 2, 3, 10] {
            let sampling = Sampling { gibbs_updates: updates, samples: 99 };
            let mut policy = Policy::new(layout.clone(), sampling, &parameters).unwrap();
            for x in [[false, true], [true, true]] {
                let expected = distribution_after(&exact, &layout, &x, updates);
                let counts = counts(&mut policy, &x, 500);
                assert_fits(&counts, &expected, &format!("{updates} updates, x {x:?}"));
            }
        }
    }
}

#[test]
fn after_many_updates_samples_have_the_distribution_of_the_machine() {
    let layout = Layout::full(3, 6, 5).unwrap();
    let parameters = layout.random_parameters(0.7, 5, "sampling").unwrap();
    let sampling = Sampling { gibbs_updates: 50, samples: 99 };
    let mut policy = Policy::new(layout.clone(), sampling, &parameters).unwrap();
    let x = [true, false, true];
    let exact = Exact::new(&layout, &parameters).unwrap();
    let logs = exact.log_probabilities(&x).unwrap();
    let expected: Vec<f64> = logs.into_iter().map(f64::exp).collect();
    assert_fits(&counts(&mut policy, &x, 1000), &expected, "50 updates");
}

/// Two counts against each other, at sizes that can't be enumerated: how many outputs are on, over
/// many draws; chi-square of two samples, false-alarm rate 1e-6.
#[test]
fn the_plain_loop_draws_from_the_same_distribution() {
    let (sizes, calls) = ([30, 50, 24], 60);
    let layout = Layout::full(30, 50, 24).unwrap();
    let parameters = layout.random_parameters(0.3, 8, "sampling").unwrap();
    let mut policy = Policy::new(layout, Sampling::default(), &parameters).unwrap();
    let mut plain = Plain::new(sizes, parameters, 1);
    let x: Vec<bool> = (0..30).map(|k| k % 4 == 1).collect();
    let given = plain.given_input(&x.iter().map(|on| f64::from(u8::from(*on))).collect::<Vec<_>>());
    let mut rng = policy.rng(3, "policy");
    let mut counts = [[0u64; 25]; 2];
    let (mut samples, mut h, mut y) = (vec![false; 24 * 61], vec![0.0; 50], vec![0.0; 24]);
    for _ in 0..calls {
        policy.sample(&x, &mut rng, &mut samples).unwrap();
        for sample in samples.chunks(24) {
            counts[0][sample.iter().filter(|on| **on).count()] += 1;
            plain.sample(&given, &mut h, &mut y);
            counts[1][y.iter().sum::<f64>() as usize] += 1;
        }
    }
    let (mut sum, mut freedom) = (0.0, 0);
    for (ours, theirs) in counts[0].iter().zip(&counts[1]) {
        if ours + theirs >= 20 {
            sum += (*ours as f64 - *theirs as f64).powi(2) / (ours + theirs) as f64;
            freedom += 1;
        }
    }
    assert!(chi_square_tail(sum, freedom) > 1e-6, "{sum} with {freedom} degrees: {counts:?}");
}

/// The mean of the score less the exact score at the same action is the bias of the second term,
/// which enumeration knows. Each of 35 parameters within 5.5 standard errors: false alarms 2e-6.
#[test]
fn the_scores_only_bias_is_that_of_the_chains_start() {
    let layout = Layout::full(2, 5, 3).unwrap();
    let parameters = layout.random_parameters(2.0, 6, "sampling").unwrap();
    let exact = Exact::new(&layout, &parameters).unwrap();
    let x = [true, true];
    let scores: Vec<Vec<f64>> =
        (0..8).map(|y| exact.score(&x, &exact.output(y)).unwrap()).collect();
    for updates in [1, 4] {
        let of_y = distribution_after(&exact, &layout, &x, updates);
        let mut bias = vec![0.0; layout.n_parameters()];
        for (p, score) in of_y.iter().zip(&scores) {
            bias.iter_mut().zip(score).for_each(|(bias, score)| *bias -= p * score);
        }
        let sampling = Sampling { gibbs_updates: updates, samples: 20 };
        let mut policy = Policy::new(layout.clone(), sampling, &parameters).unwrap();
        let mut rng = policy.rng(1, "bias");
        let (calls, mut y, mut score) = (4000, [false; 3], vec![0.0; layout.n_parameters()]);
        let mut sums = vec![(0.0, 0.0); score.len()];
        for _ in 0..calls {
            policy.act_and_score(&x, &mut rng, &mut y, &mut score).unwrap();
            for ((sum, score), exact) in sums.iter_mut().zip(&score).zip(&scores[number(&y)]) {
                *sum = (sum.0 + (score - exact), sum.1 + (score - exact).powi(2));
            }
        }
        let n = f64::from(calls);
        for (place, ((sum, squares), bias)) in sums.into_iter().zip(bias).enumerate() {
            let mean = sum / n;
            let error = ((squares / n - mean * mean) / n).sqrt();
            // The sampler's own rounding is far below the second summand.
            let tolerance = 5.5 * error + 1e-6;
            assert!((mean - bias).abs() < tolerance, "{place}: {mean} +- {error}, exactly {bias}");
        }
    }
}

#[test]
fn the_first_term_is_exact() {
    // Without weights to the outputs, h doesn't depend on y, so both terms of V and c cancel; b's
    // first term is y itself.
    let layout = Layout::full(2, 3, 2).unwrap();
    let mut parameters = layout.random_parameters(1.0, 7, "sampling").unwrap();
    parameters[layout.output_weights()].fill(0.0);
    let mut policy = Policy::new(layout.clone(), Sampling::default(), &parameters).unwrap();
    let mut rng = policy.rng(1, "policy");
    let mut score = vec![0.0; layout.n_parameters()];
    policy.score(&[true, false], &[true, false], &mut rng, &mut score).unwrap();
    // A mean of 60 equal numbers, rounded at each addition.
    assert!(score[..layout.hidden_biases().end].iter().all(|score| score.abs() < 60.0 * 2e-16));
    let b = &score[layout.output_biases()];
    assert!((0.0..1.0).contains(&b[0]) && (-1.0..0.0).contains(&b[1]), "{b:?}");
    // Both from the same samples: W's terms are c's probability times b's.
    let on = Exact::new(&layout, &parameters).unwrap();
    let on = on.hidden_probabilities(&[true, false], &[true, false]).unwrap();
    for (j, on) in on.iter().enumerate() {
        for (i, b) in b.iter().enumerate() {
            let w = score[layout.output_weight(j, i).unwrap()];
            assert!((w - on * b).abs() < 1e-14, "W[{j},{i}]");
        }
    }
}

/// Each bit, and each two neighbours' agreement, in half of the draws, within 5.5 standard errors:
/// false-alarm rate 5e-6. More outputs than a random word has bits.
#[test]
fn chains_start_uniform() {
    let layout = Layout::full(0, 1, 65).unwrap();
    let parameters = vec![0.0; layout.n_parameters()];
    let sampling = Sampling { gibbs_updates: 0, samples: 99 };
    let mut policy = Policy::new(layout, sampling, &parameters).unwrap();
    let mut rng = policy.rng(1, "policy");
    let (mut on, mut agree, draws) = ([0.0; 65], [0.0; 64], 10_000.0);
    let mut samples = vec![false; 65 * 100];
    for _ in 0..100 {
        policy.sample(&[], &mut rng, &mut samples).unwrap();
        for y in samples.chunks(65) {
            (0..65).for_each(|i| on[i] += f64::from(u8::from(y[i])));
            (0..64).for_each(|i| agree[i] += f64::from(u8::from(y[i] == y[i + 1])));
        }
    }
    for count in on.iter().chain(&agree) {
        assert!((count - draws / 2.0f64).abs() < 5.5 * draws.sqrt() / 2.0, "{on:?} {agree:?}");
    }
}

/// With one sample and no weights, b's score is y - y', which is 0 in half of the calls; within 5.5
/// standard errors, false-alarm rate 4e-8.
#[test]
fn the_action_is_none_of_the_samples() {
    let layout = Layout::full(0, 1, 1).unwrap();
    let sampling = Sampling { gibbs_updates: 1, samples: 1 };
    let mut policy = Policy::new(layout, sampling, &[0.0; 3]).unwrap();
    let mut rng = policy.rng(1, "policy");
    let (mut equal, calls) = (0.0, 10_000.0f64);
    let mut score = [0.0; 3];
    for _ in 0..calls as usize {
        policy.act_and_score(&[], &mut rng, &mut [false], &mut score).unwrap();
        equal += if score[2] == 0.0 { 1.0 } else { 0.0 };
    }
    assert!((equal - calls / 2.0).abs() < 5.5 * calls.sqrt() / 2.0, "{equal}");
}

#[test]
fn large_weights_neither_overflow_nor_give_nan() {
    let layout = Layout::full(30, 50, 24).unwrap();
    let signs = layout.random_parameters(1.0, 9, "sampling").unwrap();
    for size in [60.0, 1e4, 1e9] {
        let parameters: Vec<f64> = signs.iter().map(|sign| sign.signum() * size).collect();
        let mut policy = Policy::new(layout.clone(), Sampling::default(), &parameters).unwrap();
        let mut rng = policy.rng(1, "policy");
        let (mut y, mut score) = (vec![false; 24], vec![0.0; layout.n_parameters()]);
        for x in [[false; 30], [true; 30]] {
            policy.act_and_score(&x, &mut rng, &mut y, &mut score).unwrap();
            assert!(score.iter().all(|score| score.abs() <= 1.0), "{size}");
        }
    }
}

#[test]
fn strong_biases_decide() {
    let layout = Layout::full(1, 2, 4).unwrap();
    let mut parameters = vec![0.0; layout.n_parameters()];
    parameters[layout.output_biases()].copy_from_slice(&[60.0, -60.0, 60.0, -60.0]);
    let mut policy = Policy::new(layout, Sampling::default(), &parameters).unwrap();
    let mut rng = policy.rng(1, "policy");
    let mut y = vec![false; 4 * 61];
    policy.sample(&[true], &mut rng, &mut y).unwrap();
    assert!(y.chunks(4).all(|y| y == [true, false, true, false]));
}
