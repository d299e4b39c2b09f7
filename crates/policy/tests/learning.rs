//! Every kind of the list, with its default settings, learns.
#![allow(clippy::unwrap_used, missing_docs)]

#[allow(unreachable_pub, dead_code)]
mod common;

use common::{build, small};
use policy::{KindSettings, Policy};

/// Each leg shall do with one target what it feels, and with the other the opposite.
fn reward(x: &[bool], y: &[bool]) -> f64 {
    let right =
        (0..3).map(|leg| f64::from(u8::from(y[leg] == x[leg]) + u8::from(y[leg + 3] != x[leg])));
    right.sum::<f64>() / 6.0
}

/// REINFORCE with the mean reward for a baseline (R. J. Williams, 1992): the mean reward of the last
/// tenth of the updates.
fn learn(policy: &mut dyn Policy, updates: usize) -> f64 {
    let (acts, rate) = (40, 6.0);
    let mut parameters = policy.parameters().to_vec();
    let (mut y, mut score) = ([false; 6], vec![0.0; parameters.len()]);
    let (mut baseline, mut last) = (0.5, 0.0);
    for update in 0..updates {
        let mut gradient = vec![0.0; parameters.len()];
        let mut mean = 0.0;
        for act in 0..acts {
            let x = [0, 1, 2, 3].map(|bit| (act + update * 7) >> bit & 1 == 1);
            policy.act_and_score(&x, &mut y, &mut score).unwrap();
            let reward = reward(&x, &y);
            mean += reward / acts as f64;
            for (sum, score) in gradient.iter_mut().zip(&score) {
                *sum += (reward - baseline) * score / acts as f64;
            }
        }
        baseline += 0.2 * (mean - baseline);
        for (parameter, slope) in parameters.iter_mut().zip(&gradient) {
            *parameter += rate * slope;
        }
        policy.set_parameters(&parameters).unwrap();
        if update >= updates - updates / 10 {
            last += mean / (updates / 10) as f64;
        }
    }
    last
}

/// By chance half is right, at best all.
#[test]
fn every_kind_learns() {
    for kind in KindSettings::all() {
        for seed in 1..=2 {
            let reward = learn(&mut *build(&kind, &small(), 0.3, seed), 200);
            assert!(reward > 0.9, "{kind:?}, seed {seed}: {reward}");
        }
    }
}
