//! A bandit and the three-state chain, learned by every optimiser of the list.
//!
//! Learned means: the policy's exact average reward is at least 0.99 of the optimum, for each of
//! several seeds. Both problems are deterministic given the seed, so these tests pass always or
//! never.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod problems;

use gpomdp::{Estimator, EstimatorSettings};
use problems::{Draws, Learner, Problem, bandit::Bandit, chain::Chain, suited_optimisers};

const SEEDS: u64 = 8;

fn is_learned<P: Problem>(make: impl Fn() -> P, discount: f64, (updates, steps): (u32, u32)) {
    for settings in suited_optimisers() {
        for seed in 0..SEEDS {
            let mut problem = make();
            let n = problem.n_parameters();
            let mut theta = vec![0.0; n];
            let estimator = EstimatorSettings { discount, baseline_factor: Some(0.998) };
            let mut learner = Learner {
                estimator: Estimator::new(n, &estimator).unwrap(),
                optimiser: settings.build(n).unwrap(),
                steps,
            };
            let mut draws = Draws::new(seed);
            let before = problem.average_reward(&theta);
            assert!(before < 0.7 * problem.optimum(), "there is something to learn: {before}");
            for _ in 0..updates {
                learner.learn(&mut problem, &mut theta, &mut draws).unwrap();
            }
            let reached = problem.average_reward(&theta) / problem.optimum();
            assert!(reached >= 0.99, "{}, seed {seed}: {reached} of the optimum", settings.name());
        }
    }
}

#[test]
fn the_bandit_is_learned_by_every_optimiser() {
    is_learned(|| Bandit, 0.0, (400, 100));
}

#[test]
fn the_chain_is_learned_by_every_optimiser() {
    is_learned(|| Chain { state: 0 }, 0.75, (400, 100));
}
