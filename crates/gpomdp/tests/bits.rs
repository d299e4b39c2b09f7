//! The bits are those of the formulas, one operation after the other.
//!
//! Here every single operation goes through `black_box`, so that no compiler can fuse, reorder or
//! vectorise: that's IEEE 754 arithmetic as written. The crate's loops, compiled as they may be,
//! must have the same bits; that makes them the same on every machine and at every optimisation
//! level (run this with `--release` too). Lengths leave odd ends after full vectors.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;

use gpomdp::{
    AdamSettings, Estimator, EstimatorSettings, MomentumSettings, OptimiserSettings, RpropSettings,
};

const LENGTHS: [usize; 4] = [1, 7, 16, 103];
const STEPS: u32 = 300;

fn add(a: f64, b: f64) -> f64 {
    black_box(black_box(a) + black_box(b))
}
fn sub(a: f64, b: f64) -> f64 {
    black_box(black_box(a) - black_box(b))
}
fn mul(a: f64, b: f64) -> f64 {
    black_box(black_box(a) * black_box(b))
}
fn div(a: f64, b: f64) -> f64 {
    black_box(black_box(a) / black_box(b))
}

/// Numbers with full mantissas, of many magnitudes and both signs.
fn numbers(n: usize, step: u32) -> Vec<f64> {
    let number = |i: usize| {
        let hash = (u64::from(step) << 32 | i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let fraction = (hash >> 11) as f64 / (1_u64 << 53) as f64;
        (fraction - 0.5) * [1e-3, 1.0, 1e3][i % 3]
    };
    (0..n).map(number).collect()
}

fn assert_same(ours: &[f64], plain: &[f64], what: &str) {
    for (i, (ours, plain)) in ours.iter().zip(plain).enumerate() {
        assert!(ours.to_bits() == plain.to_bits(), "{what}, element {i}: {ours:?}, {plain:?}");
    }
}

#[test]
fn the_estimator_does_one_operation_after_the_other() {
    let (beta, f) = (0.75, 0.998);
    let settings = EstimatorSettings { discount: beta, baseline_factor: Some(f) };
    for n in LENGTHS {
        let mut estimator = Estimator::new(n, &settings).unwrap();
        let (mut z, mut delta) = (vec![0.0; n], vec![0.0; n]);
        let (mut weight, mut b) = (0.0, 0.0);
        for k in 1..=STEPS {
            let (score, reward) = (numbers(n, k), numbers(3, k)[1]);
            estimator.accumulate(&score, reward).unwrap();
            let r = if k == 1 { 0.0 } else { sub(reward, b) };
            weight = add(mul(f, weight), 1.0);
            b = add(b, div(sub(reward, b), weight));
            let share = div(1.0, f64::from(k));
            for i in 0..n {
                z[i] = add(mul(beta, z[i]), score[i]);
                delta[i] = add(delta[i], mul(sub(mul(r, z[i]), delta[i]), share));
            }
            assert_same(estimator.trace(), &z, &format!("z of {n}, step {k}"));
            assert_same(estimator.gradient(), &delta, &format!("Delta of {n}, step {k}"));
        }
    }
}

/// Runs an optimiser beside `plain`, which gets the step's number from 1, i, theta_i and g_i, and
/// returns the next theta_i.
fn compare(settings: &OptimiserSettings, mut plain: impl FnMut(u32, usize, f64, f64) -> f64) {
    for n in LENGTHS {
        let mut optimiser = settings.build(n).unwrap();
        let mut theta = numbers(n, 0);
        let mut expected = theta.clone();
        for step in 1..=STEPS {
            let gradient = numbers(n, step);
            optimiser.update(&mut theta, &gradient).unwrap();
            for i in 0..n {
                expected[i] = plain(step, i, expected[i], gradient[i]);
            }
            assert_same(&theta, &expected, &format!("{} of {n}, step {step}", settings.name()));
        }
    }
}

#[test]
fn momentum_does_one_operation_after_the_other() {
    let settings = MomentumSettings { rate: 0.3, decay: 0.01, momentum: 0.7 };
    let mut dtheta = vec![0.0; 103];
    compare(&OptimiserSettings::Momentum(settings), |step, i, theta, g| {
        let last = if step == 1 { 0.0 } else { dtheta[i] };
        dtheta[i] = add(mul(0.3, sub(g, mul(0.01, theta))), mul(0.7, last));
        add(theta, dtheta[i])
    });
}

#[test]
fn adam_does_one_operation_after_the_other() {
    let settings =
        AdamSettings { rate: 0.01, mean_factor: 0.9, square_factor: 0.999, epsilon: 1e-8 };
    let (mut m, mut v) = (vec![0.0; 103], vec![0.0; 103]);
    let mut powers = (1.0, 1.0);
    compare(&OptimiserSettings::Adam(settings), |step, i, theta, g| {
        if step == 1 {
            (m[i], v[i]) = (0.0, 0.0);
        }
        if i == 0 {
            let last = if step == 1 { (1.0, 1.0) } else { powers };
            powers = (mul(last.0, 0.9), mul(last.1, 0.999));
        }
        m[i] = add(mul(0.9, m[i]), mul(sub(1.0, 0.9), g));
        v[i] = add(mul(0.999, v[i]), mul(sub(1.0, 0.999), mul(g, g)));
        let (mhat, vhat) = (div(m[i], sub(1.0, powers.0)), div(v[i], sub(1.0, powers.1)));
        add(theta, div(mul(0.01, mhat), add(black_box(vhat.sqrt()), 1e-8)))
    });
}

#[test]
fn rprop_does_one_operation_after_the_other() {
    let settings = RpropSettings { grow: 1.3, shrink: 0.6, ..Default::default() };
    let (mut size, mut last) = (vec![0.0; 103], vec![0.0; 103]);
    compare(&OptimiserSettings::Rprop(settings), |step, i, theta, g| {
        if step == 1 {
            (size[i], last[i]) = (0.1, 0.0);
        }
        let product = mul(g, last[i]);
        last[i] = g;
        if product > 0.0 {
            size[i] = mul(1.3, size[i]).min(50.0);
        } else if product < 0.0 {
            size[i] = mul(0.6, size[i]).max(1e-6);
            last[i] = 0.0;
            return theta;
        }
        if g > 0.0 { add(theta, size[i]) } else { sub(theta, size[i]) }
    });
}
