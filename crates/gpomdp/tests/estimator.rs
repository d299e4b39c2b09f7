//! The estimator's bookkeeping: what it refuses, what a restart keeps, how states come back.
#![allow(clippy::unwrap_used, missing_docs)]

use gpomdp::{Error, Estimator, EstimatorSettings, LIMIT};
use proptest::{collection::vec, prelude::*, sample::select};

const N: usize = 3;
const BAD: [f64; 6] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.001e100, -1.001e100, f64::MAX];

type Step = ([f64; N], f64);

fn settings() -> impl Strategy<Value = EstimatorSettings> {
    let factor = select(vec![None, Some(0.0), Some(0.5), Some(0.998), Some(1.0)]);
    (0.0..=1.0, factor)
        .prop_map(|(discount, baseline_factor)| EstimatorSettings { discount, baseline_factor })
}

fn steps(n: usize) -> impl Strategy<Value = Vec<Step>> {
    vec((prop::array::uniform3(-2.0..2.0), -1.0..1.0), 0..n)
}

fn run(estimator: &mut Estimator, steps: &[Step]) {
    for (score, reward) in steps {
        estimator.accumulate(score, *reward).unwrap();
    }
}

fn bits(state: &[f64]) -> Vec<u64> {
    state.iter().map(|x| x.to_bits()).collect()
}

proptest! {
    /// Traces and sums from their definitions: sums over all pairs of a score and a later reward.
    #[test]
    fn the_estimate_is_the_mean_of_rewards_times_discounted_scores(
        discount in 0.0..=1.0,
        steps in steps(30),
    ) {
        let settings = EstimatorSettings { discount, baseline_factor: None };
        let mut estimator = Estimator::new(N, &settings).unwrap();
        run(&mut estimator, &steps);
        let count = steps.len().max(1) as f64;
        for i in 0..N {
            let mut sum = 0.0;
            for (later, (_, reward)) in steps.iter().enumerate() {
                for (earlier, (score, _)) in steps[..=later].iter().enumerate() {
                    sum += reward * discount.powi((later - earlier) as i32) * score[i];
                }
            }
            // 900 terms below 2, each with some roundings of epsilon/2, averaged over the steps.
            let tolerance = 900.0 * 2.0 * 4.0 * f64::EPSILON;
            prop_assert!((estimator.gradient()[i] - sum / count).abs() < tolerance);
        }
        let rewards: f64 = steps.iter().map(|step| step.1).sum();
        prop_assert_eq!(estimator.average_reward(), rewards / count);
        prop_assert_eq!(estimator.steps(), steps.len() as u64);
    }

    #[test]
    fn a_refused_step_leaves_everything_as_it_was(
        settings in settings(),
        steps in steps(5),
        bad in select(&BAD[..]),
        place in 0..=N,
    ) {
        let mut estimator = Estimator::new(N, &settings).unwrap();
        run(&mut estimator, &steps);
        let before = estimator.clone();
        let (mut score, mut reward) = ([0.5; N], 0.5);
        let refused = if place < N { &mut score[place] } else { &mut reward };
        *refused = bad;
        let error = estimator.accumulate(&score, reward).unwrap_err();
        let named = match error {
            Error::Element { what: "score", index, value, .. } => (index, value.to_bits()),
            Error::Number { what: "reward", value, .. } => (N, value.to_bits()),
            other => return Err(TestCaseError::fail(other.to_string())),
        };
        prop_assert_eq!(named, (place, bad.to_bits()));
        prop_assert_eq!(&estimator, &before);
        for score in [&[0.5; N - 1][..], &[0.5; N + 1], &[]] {
            let error = estimator.accumulate(score, 0.5).unwrap_err();
            let named =
                matches!(error, Error::Length { expected: N, got, .. } if got == score.len());
            prop_assert!(named, "{}", error);
        }
        prop_assert_eq!(&estimator, &before);
    }

    #[test]
    fn a_restored_estimator_continues_with_the_same_bits(
        settings in settings(),
        loops in vec(steps(8), 1..4),
        rest in steps(8),
    ) {
        let mut estimator = Estimator::new(N, &settings).unwrap();
        for steps in &loops {
            estimator.restart();
            run(&mut estimator, steps);
        }
        let mut restored = Estimator::new(N, &settings).unwrap();
        restored.accumulate(&[1.0; N], 1.0).unwrap(); // to be overwritten
        restored.restore(&estimator.state()).unwrap();
        prop_assert_eq!(&restored, &estimator);
        run(&mut estimator, &rest);
        run(&mut restored, &rest);
        prop_assert_eq!(bits(&restored.state()), bits(&estimator.state()));
    }

    #[test]
    fn a_restart_keeps_nothing_but_the_baseline(
        discount in 0.0..=1.0,
        first in steps(8),
        second in steps(8),
    ) {
        let mut plain =
            Estimator::new(N, &EstimatorSettings { discount, baseline_factor: None }).unwrap();
        let fresh = plain.clone();
        run(&mut plain, &first);
        plain.restart();
        prop_assert_eq!(&plain, &fresh);

        // The baseline is that of the two runs in one.
        let settings = EstimatorSettings { discount, baseline_factor: Some(0.9) };
        let mut restarted = Estimator::new(N, &settings).unwrap();
        let mut in_one = restarted.clone();
        run(&mut restarted, &first);
        restarted.restart();
        prop_assert_eq!(restarted.gradient(), &[0.0; N]);
        prop_assert_eq!(restarted.average_reward(), 0.0);
        run(&mut restarted, &second);
        run(&mut in_one, &[first, second].concat());
        prop_assert_eq!(restarted.baseline(), in_one.baseline());
    }

    /// R is of the raw rewards; the gradient is that of the rewards less the average of those
    /// before them.
    #[test]
    fn a_baseline_is_subtracted_in_the_gradient_only(
        discount in 0.0..=1.0,
        factor in select(vec![0.0, 0.5, 0.998, 1.0]),
        steps in steps(30),
    ) {
        let mut with = Estimator::new(
            N, &EstimatorSettings { discount, baseline_factor: Some(factor) }).unwrap();
        let mut without =
            Estimator::new(N, &EstimatorSettings { discount, baseline_factor: None }).unwrap();
        let mut rewards = 0.0;
        for (score, reward) in &steps {
            let centred = with.baseline().map_or(0.0, |b| reward - b);
            rewards += reward;
            with.accumulate(score, *reward).unwrap();
            without.accumulate(score, centred).unwrap();
        }
        prop_assert_eq!(with.gradient(), without.gradient());
        prop_assert_eq!(with.trace(), without.trace());
        prop_assert_eq!(with.average_reward(), rewards / steps.len().max(1) as f64);
    }
}

#[test]
fn the_largest_numbers_do_not_overflow() {
    for baseline_factor in [None, Some(0.5), Some(1.0)] {
        let settings = EstimatorSettings { discount: 1.0, baseline_factor };
        let mut estimator = Estimator::new(2, &settings).unwrap();
        for step in 0..1000 {
            let reward = if step % 3 == 0 { -LIMIT } else { LIMIT };
            estimator.accumulate(&[LIMIT, -LIMIT], reward).unwrap();
        }
        assert_eq!(estimator.trace()[0], -estimator.trace()[1]);
        // A thousand scores, but for the roundings of their sum.
        assert!((estimator.trace()[0] / (1000.0 * LIMIT) - 1.0).abs() < 1e-12);
        let state = estimator.state();
        assert!(state.iter().all(|x| x.is_finite()), "{state:?}");
        estimator.restore(&state).unwrap();
    }
}

#[test]
fn settings_out_of_range_are_refused() {
    for bad in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
        let settings = EstimatorSettings { discount: bad, baseline_factor: None };
        let error = Estimator::new(N, &settings).unwrap_err().to_string();
        assert_eq!(error, format!("Estimator::new: discount must be within 0 to 1, got {bad:?}"));
        let settings = EstimatorSettings { baseline_factor: Some(bad), ..Default::default() };
        let error = Estimator::new(N, &settings).unwrap_err().to_string();
        let expected = format!("baseline_factor must be within 0 to 1, got {bad:?}");
        assert_eq!(error, format!("Estimator::new: {expected}"));
    }
    let error = Estimator::new(usize::MAX, &EstimatorSettings::default()).unwrap_err();
    assert!(matches!(error, Error::Memory { n_parameters: usize::MAX, .. }), "{error}");
}

#[test]
fn senseless_states_are_refused_and_change_nothing() {
    let settings = EstimatorSettings { discount: 0.5, baseline_factor: Some(0.5) };
    let mut estimator = Estimator::new(N, &settings).unwrap();
    estimator.accumulate(&[1.0, 2.0, 3.0], 4.0).unwrap();
    let before = estimator.clone();
    let good = estimator.state();
    // Steps, sum of rewards, trace, gradient, weight and average of the baseline.
    assert_eq!(good, [1.0, 4.0, 1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0, 4.0]);
    let wrong =
        [(0, 0.5), (0, -1.0), (0, 1e16), (1, 1e117), (2, 1e117), (5, 1e218), (8, 0.5), (9, 3e100)];
    let nan = (0..good.len()).map(|index| (index, f64::NAN));
    for (index, value) in wrong.into_iter().chain(nan) {
        let mut state = good.clone();
        state[index] = value;
        assert!(estimator.restore(&state).is_err(), "{index}: {value}");
        assert_eq!(estimator, before);
    }
    for length in (0..good.len()).chain([good.len() + 1]) {
        let error = estimator.restore(&vec![1.0; length]).unwrap_err();
        assert!(matches!(error, Error::Length { got, .. } if got == length), "{error}");
        assert_eq!(estimator, before);
    }
}

#[test]
fn without_parameters_rewards_are_still_averaged() {
    let mut estimator = Estimator::new(0, &EstimatorSettings::default()).unwrap();
    estimator.accumulate(&[], 1.0).unwrap();
    estimator.accumulate(&[], 2.0).unwrap();
    assert_eq!((estimator.average_reward(), estimator.gradient()), (1.5, &[][..]));
    estimator.restore(&estimator.clone().state()).unwrap();
}

#[test]
fn a_step_and_a_restart_allocate_nothing() {
    let settings = EstimatorSettings { discount: 0.75, baseline_factor: Some(0.998) };
    let mut estimator = Estimator::new(100, &settings).unwrap();
    let score = [0.5; 100];
    let counted = allocation_counter::measure(|| {
        for _ in 0..10 {
            estimator.accumulate(&score, 1.0).unwrap();
        }
        estimator.restart();
    });
    assert_eq!(counted.count_total, 0, "{counted:?}");
}

#[test]
fn settings_come_from_a_file_with_defaults_and_without_typing_errors() {
    let read = |text: &str| toml::from_str::<EstimatorSettings>(text);
    assert_eq!(read("").unwrap(), EstimatorSettings::default());
    let expected = EstimatorSettings { discount: 0.5, baseline_factor: Some(0.998) };
    assert_eq!(read("discount = 0.5\nbaseline_factor = 0.998").unwrap(), expected);
    assert!(read("discout = 0.5").unwrap_err().to_string().contains("discout"));
    assert_eq!(read(&toml::to_string(&expected).unwrap()).unwrap(), expected);
}
