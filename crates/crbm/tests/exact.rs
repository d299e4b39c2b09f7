//! Enumeration against the definition, and the score against finite differences.
#![allow(clippy::unwrap_used, missing_docs)]

use crbm::{Exact, Layout, Mask};

fn bits(number: usize, length: usize) -> Vec<bool> {
    (0..length).map(|i| number >> i & 1 == 1).collect()
}

/// h'Vx + h'Wy + c'h + b'y, from the definition.
fn exponent(layout: &Layout, parameters: &[f64], [x, h, y]: [&[bool]; 3]) -> f64 {
    let mut sum = 0.0;
    for j in (0..h.len()).filter(|&j| h[j]) {
        sum += parameters[layout.hidden_biases()][j];
        let v = (0..x.len()).filter(|&k| x[k]).filter_map(|k| layout.input_weight(j, k));
        let w = (0..y.len()).filter(|&i| y[i]).filter_map(|i| layout.output_weight(j, i));
        sum += v.chain(w).map(|place| parameters[place]).sum::<f64>();
    }
    sum + (0..y.len()).filter(|&i| y[i]).map(|i| parameters[layout.output_biases()][i]).sum::<f64>()
}

fn machines() -> Vec<(Layout, Vec<f64>)> {
    let masked = Layout::new(
        Mask::from_fn(6, 4, |j, k| (j + k) % 3 != 0).unwrap(),
        Mask::blocks(2, &[0, 1, 2, 0, 1]).unwrap(),
    );
    let layouts = [Layout::full(4, 6, 5), Layout::full(0, 3, 2), Layout::full(2, 0, 3), masked];
    let random = |(seed, layout): (usize, Result<Layout, _>)| {
        let layout = layout.unwrap();
        let parameters = layout.random_parameters(1.0, seed as u64, "exact").unwrap();
        (layout, parameters)
    };
    layouts.into_iter().enumerate().map(random).collect()
}

/// Sums of at most 2^11 terms of either sign: some 1e-14.
#[test]
fn probabilities_are_the_definitions() {
    for (layout, parameters) in machines() {
        let exact = Exact::new(&layout, &parameters).unwrap();
        let (m, n) = (layout.n_hidden(), layout.n_outputs());
        for number in 0..1 << layout.n_inputs() {
            let x = bits(number, layout.n_inputs());
            let weight = |y: usize| {
                let h = (0..1 << m).map(|h| bits(h, m));
                h.map(|h| exponent(&layout, &parameters, [&x, &h, &bits(y, n)]).exp()).sum::<f64>()
            };
            let weights: Vec<f64> = (0..1 << n).map(weight).collect();
            let z: f64 = weights.iter().sum();
            assert!((exact.log_partition(&x).unwrap() - z.ln()).abs() < 1e-13);
            let logs = exact.log_probabilities(&x).unwrap();
            for (y, (log, weight)) in logs.iter().zip(&weights).enumerate() {
                assert!((log - (weight / z).ln()).abs() < 1e-13, "p({y}|{number})");
            }
            let pairs = [(x.clone(), bits(0, n)), (x, bits(1, n))];
            let likelihood = exact.log_likelihood(&pairs).unwrap();
            assert!((likelihood - (logs[0] + logs[1]) / 2.0).abs() < 1e-13);
        }
    }
}

/// Central differences over a step e err by e^2 times a third derivative, some 1e-8 of 1, and by
/// rounding, 1e-15 / e; extrapolated from two steps (Richardson) the first becomes e^4.
#[test]
fn the_score_is_the_gradient_of_the_log_probability() {
    for (layout, parameters) in machines() {
        let x = bits(0b0110, layout.n_inputs());
        let y = bits(0b10101, layout.n_outputs());
        let score = Exact::new(&layout, &parameters).unwrap().score(&x, &y).unwrap();
        let log_p = |parameters: &[f64]| {
            let exact = Exact::new(&layout, parameters).unwrap();
            exact.log_likelihood(&[(x.clone(), y.clone())]).unwrap()
        };
        for place in 0..parameters.len() {
            let difference = |step: f64| {
                let at = |step: f64| {
                    let mut moved = parameters.clone();
                    moved[place] += step;
                    log_p(&moved)
                };
                (at(step) - at(-step)) / (2.0 * step)
            };
            let slope = (4.0 * difference(1e-3) - difference(2e-3)) / 3.0;
            let error = (score[place] - slope).abs() / slope.abs().max(1e-3);
            assert!(error < 1e-6, "parameter {place}: {} and {slope}", score[place]);
        }
    }
}

/// The sum over y of p(y|x) times the score is zero: the gradient of a sum that is always 1.
#[test]
fn scores_cancel_on_average() {
    for (layout, parameters) in machines() {
        let exact = Exact::new(&layout, &parameters).unwrap();
        let x = bits(0b1011, layout.n_inputs());
        let mut mean = vec![0.0; layout.n_parameters()];
        for (y, log) in exact.log_probabilities(&x).unwrap().into_iter().enumerate() {
            let score = exact.score(&x, &exact.output(y)).unwrap();
            mean.iter_mut().zip(score).for_each(|(mean, score)| *mean += log.exp() * score);
        }
        assert!(mean.iter().all(|mean| mean.abs() < 1e-14), "{mean:?}");
    }
}

/// sum over (y,h) of p(y,h|x) K(y,h -> y',h') = p(y',h'|x), where one full update K draws h' given
/// y, then y' given h'. All 2^7 by 2^7 of them.
#[test]
fn a_gibbs_update_leaves_the_joint_distribution_as_it_is() {
    let layout = Layout::full(2, 4, 3).unwrap();
    let parameters = layout.random_parameters(1.5, 3, "invariance").unwrap();
    let exact = Exact::new(&layout, &parameters).unwrap();
    let (x, m, n) = ([true, false], 4, 3);
    let z = exact.log_partition(&x).unwrap();
    let joint = |h: usize, y: usize| {
        (exponent(&layout, &parameters, [&x, &bits(h, m), &bits(y, n)]) - z).exp()
    };
    let product = |probabilities: Vec<f64>, bits: Vec<bool>| {
        let factors = probabilities.into_iter().zip(bits);
        factors.map(|(p, on)| if on { p } else { 1.0 - p }).product::<f64>()
    };
    for (new_h, new_y) in (0..1 << m).flat_map(|h| (0..1 << n).map(move |y| (h, y))) {
        let y_given_h =
            product(exact.output_probabilities(&bits(new_h, m)).unwrap(), bits(new_y, n));
        let mut after = 0.0;
        for (h, y) in (0..1 << m).flat_map(|h| (0..1 << n).map(move |y| (h, y))) {
            let given_y = exact.hidden_probabilities(&x, &bits(y, n)).unwrap();
            after += joint(h, y) * product(given_y, bits(new_h, m)) * y_given_h;
        }
        let before = joint(new_h, new_y);
        assert!((after - before).abs() < 1e-14, "({new_h}, {new_y}): {before} became {after}");
    }
}

#[test]
fn outputs_have_numbers() {
    let layout = Layout::full(0, 1, 3).unwrap();
    let exact = Exact::new(&layout, &[0.0; 7]).unwrap();
    assert_eq!(exact.output(6), [false, true, true]);
    assert!((0..8).all(|number| exact.number(&exact.output(number)) == Ok(number)));
}

#[test]
fn large_weights_neither_overflow_nor_give_nan() {
    for size in [60.0, 1e4, 1e9] {
        let layout = Layout::full(3, 5, 4).unwrap();
        let signs = layout.random_parameters(1.0, 4, "large").unwrap();
        let parameters: Vec<f64> = signs.iter().map(|sign| sign.signum() * size).collect();
        let exact = Exact::new(&layout, &parameters).unwrap();
        let x = [true, true, false];
        let logs = exact.log_probabilities(&x).unwrap();
        let sum: f64 = logs.iter().map(|log| log.exp()).sum();
        // log Z is at most 49 weights, and rounded relative to its size.
        let rounding = 49.0 * size * f64::EPSILON;
        assert!((sum - 1.0).abs() < rounding, "{size}: {sum}");
        let score = exact.score(&x, &exact.output(5)).unwrap();
        assert!(score.iter().all(|score| score.abs() <= 1.0 + rounding), "{size}: {score:?}");
    }
}

#[test]
fn bad_arguments_are_refused() {
    let large = Layout::full(1, 1, 21).unwrap();
    let message = Exact::new(&large, &vec![0.0; large.n_parameters()]).unwrap_err().to_string();
    assert_eq!(message, "Exact::new: n_outputs must be at most 20, got 21");
    let layout = Layout::full(1, 1, 2).unwrap();
    assert!(Exact::new(&layout, &[0.0; 5]).is_err());
    let exact = Exact::new(&layout, &[0.0; 6]).unwrap();
    assert!(exact.log_partition(&[]).is_err());
    assert!(exact.log_probabilities(&[true; 2]).is_err());
    assert!(exact.log_likelihood(&[]).is_err());
    assert!(exact.score(&[true], &[true]).is_err());
    assert!(exact.hidden_probabilities(&[true], &[true]).is_err());
    assert!(exact.output_probabilities(&[true; 2]).is_err());
}
