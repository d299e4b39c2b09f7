//! The estimator against the exact gradients of the three-state chain.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod problems;

use gpomdp::{Estimator, EstimatorSettings};
use problems::{
    Draws, Problem, bias,
    chain::{self, Chain, Exact, N_PARAMETERS, Theta},
    mean_and_standard_error,
};

const THETAS: [Theta; 5] = [
    [1.0, 1.0, -1.0, -1.0],
    [0.0, 0.0, 0.0, 0.0],
    [2.0, -3.0, -1.0, 1.0],
    [-3.0, 4.0, 0.0, -2.0],
    [9.0, -9.0, 0.0, 0.0],
];
const DISCOUNTS: [f64; 4] = [0.0, 0.4, 0.8, 0.95];

fn estimator(discount: f64, baseline_factor: Option<f64>) -> Estimator {
    Estimator::new(N_PARAMETERS, &EstimatorSettings { discount, baseline_factor }).unwrap()
}

/// The published numbers have 9 and 6 decimals.
#[test]
fn the_exact_values_are_the_published_ones() {
    let exact = Exact::at(&[1.0, 1.0, -1.0, -1.0]);
    assert!((exact.average_reward() - 0.294197473).abs() < 1e-9);
    let published = [-0.0327258543, -0.0352484694, 0.0327258543, 0.0352484694];
    for (ours, published) in exact.gradient().iter().zip(published) {
        assert!((ours - published).abs() < 1e-9, "{ours}, {published}");
    }
    let table = [
        (0.0, [-0.030203, -0.032532]),
        (0.4, [-0.031164, -0.033567]),
        (0.8, [-0.032188, -0.034669]),
        (0.95, [-0.032590, -0.035102]),
        (0.99, [-0.032699, -0.035219]),
    ];
    for (discount, published) in table {
        let ours = exact.discounted_gradient(discount);
        for (ours, published) in ours.iter().zip(published) {
            assert!((ours - published).abs() < 6e-7, "{discount}: {ours}, {published}");
        }
    }
}

/// Central differences with step h err by h^2 eta'''/6 and by 1e-16/h: 1e-10 is above both.
#[test]
fn the_exact_gradient_is_the_derivative_of_the_average_reward() {
    let h = 1e-5;
    for theta in THETAS {
        let gradient = Exact::at(&theta).gradient();
        for i in 0..N_PARAMETERS {
            let eta = |h: f64| {
                let mut moved = theta;
                moved[i] += h;
                Exact::at(&moved).average_reward()
            };
            let difference = (eta(h) - eta(-h)) / (2.0 * h);
            assert!((gradient[i] - difference).abs() < 1e-10, "{theta:?}, {i}");
        }
    }
}

/// The expectation over all trajectories of a short loop, each run through the estimator and
/// weighted with its probability: no statistics, an identity.
#[test]
fn the_expected_estimate_of_a_loop_is_the_exact_one() {
    for theta in THETAS {
        let exact = Exact::at(&theta);
        for discount in [0.0, 0.4, 0.95, 1.0] {
            for steps in [1, 2, 5] {
                let mut expected = [0.0; N_PARAMETERS + 1];
                for (state, &probability) in exact.stationary.iter().enumerate() {
                    let begin = (probability, state, estimator(discount, None));
                    add_all_trajectories(&theta, steps, begin, &mut expected);
                }
                let [reward, gradient @ ..] = expected;
                // Sums of thousands of numbers whose absolute values add up to about 1.
                assert!((reward - exact.average_reward()).abs() < 1e-13);
                for (ours, exact) in gradient.iter().zip(exact.looped_gradient(discount, steps)) {
                    assert!(
                        (ours - exact).abs() < 1e-13,
                        "{theta:?}, beta {discount}, T = {steps}: {ours}, {exact}"
                    );
                }
            }
        }
    }
}

/// Adds R and Delta of all trajectories that go on from here, each times its probability.
fn add_all_trajectories(
    theta: &Theta,
    steps: u32,
    (probability, state, estimator): (f64, usize, Estimator),
    sums: &mut [f64; N_PARAMETERS + 1],
) {
    if steps == 0 {
        sums[0] += probability * estimator.average_reward();
        for (sum, delta) in sums[1..].iter_mut().zip(estimator.gradient()) {
            *sum += probability * delta;
        }
        return;
    }
    for (branch, action, next) in Chain::branches(theta, state) {
        let mut estimator = estimator.clone();
        let score = chain::score(theta, state, action);
        estimator.accumulate(&score, Chain::reward_in(next)).unwrap();
        add_all_trajectories(theta, steps - 1, (probability * branch, next, estimator), sums);
    }
}

/// Estimates of independent runs, each one loop: `[runs][estimators]`, all fed by the same steps.
fn independent_runs(
    theta: &Theta,
    (runs, steps): (u64, u32),
    offset: f64,
    estimators: &[Estimator],
) -> Vec<Vec<Theta>> {
    let mut estimates = vec![Vec::new(); estimators.len()];
    for run in 0..runs {
        let mut draws = Draws::new(run);
        let mut chain = Chain::stationary(theta, &mut draws);
        let mut score = [0.0; N_PARAMETERS];
        let mut estimators = estimators.to_vec();
        for _ in 0..steps {
            let reward = chain.step(theta, &mut draws, &mut score) + offset;
            for estimator in &mut estimators {
                estimator.accumulate(&score, reward).unwrap();
            }
        }
        for (estimates, estimator) in estimates.iter_mut().zip(&estimators) {
            estimates.push(estimator.gradient().try_into().unwrap());
        }
    }
    estimates
}

/// Within 3 standard errors of the exact discounted gradient.
///
/// With right code, one comparison of 255 degrees of freedom fails with probability 0.0030. There
/// are 40 that aren't each other's mirror image, so new seeds would raise a false alarm with
/// probability below 0.12; the seeds are fixed. A loop's start, where the trace is still short,
/// shortens the expected estimate by at most 1/(1 - 0.95)/T of it, a hundredth of what the test
/// can see; what it can see, a standard error, is asserted too.
#[test]
fn long_runs_estimate_the_discounted_gradient() {
    for theta in THETAS {
        let exact = Exact::at(&theta);
        let estimators = DISCOUNTS.map(|discount| estimator(discount, None));
        let estimates = independent_runs(&theta, (256, 10_000), 0.0, &estimators);
        for (discount, estimates) in DISCOUNTS.into_iter().zip(estimates) {
            let (mean, standard_error) = mean_and_standard_error(&estimates);
            for (i, exact) in exact.discounted_gradient(discount).into_iter().enumerate() {
                let (mean, error) = (mean[i], standard_error[i]);
                let place = format!("{theta:?}, beta {discount}, {i}");
                assert!((mean - exact).abs() < 3.0 * error, "{place}: {mean} +- {error}, {exact}");
                assert!(error < 0.05 * exact.abs(), "{place}: {error} tells little of {exact}");
            }
        }
    }
}

/// A running average of past rewards leaves the direction and has the factor
/// (1 - beta)/(1 - f beta); and it takes out the noise that a constant part of the reward makes.
///
/// 4 comparisons with 63 degrees of freedom at 3 standard errors: false alarm below 0.016.
#[test]
fn the_baseline_shrinks_the_estimate_as_stated_and_takes_out_the_noise() {
    let theta = THETAS[0];
    let (offset, discount) = (5.0, 0.8);
    let factors = [0.9, 0.998];
    let estimators =
        [None, Some(factors[0]), Some(factors[1])].map(|factor| estimator(discount, factor));
    let [plain, with_baselines @ ..] =
        &independent_runs(&theta, (64, 10_000), offset, &estimators)[..]
    else {
        panic!("three estimators")
    };
    let (_, plain_error) = mean_and_standard_error(plain);
    for (factor, estimates) in factors.into_iter().zip(with_baselines) {
        let shrink = (1.0 - discount) / (1.0 - factor * discount);
        let (mean, error) = mean_and_standard_error(estimates);
        for (i, exact) in Exact::at(&theta).discounted_gradient(discount).into_iter().enumerate() {
            let expected = shrink * exact;
            assert!((mean[i] - expected).abs() < 3.0 * error[i], "{factor}: {mean:?}, {expected}");
            // So that the factor, 0.71 or 0.99, isn't hidden by the noise.
            assert!(error[i] < 0.05 * exact.abs());
            assert!(error[i] < 0.2 * plain_error[i], "{error:?}, {plain_error:?}");
        }
    }
}

#[test]
fn the_table_of_the_page_is_what_the_example_prints() {
    let page = include_str!("../src/lib.rs");
    for line in bias::table().unwrap() {
        assert!(page.contains(&format!("//! {line}\n")), "not in src/lib.rs: {line}");
    }
}
