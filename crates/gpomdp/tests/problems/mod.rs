//! Problems small enough to be solved exactly, and what the tests and examples need to learn them.
//!
//! Exponentials come from `libm` and draws from a named generator, so that a seed means the same
//! numbers on every machine.
// Every user takes a part; states and parameters are known by their index.
#![allow(dead_code, unreachable_pub, missing_docs, clippy::needless_range_loop)]

pub mod bandit;
pub mod bias;
pub mod chain;

use gpomdp::{
    AdamSettings, Error, Estimator, MomentumSettings, Optimiser, OptimiserSettings, RpropSettings,
};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};

/// Uniform draws.
pub struct Draws(ChaCha8Rng);

impl Draws {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// An index, with these probabilities.
    pub fn index(&mut self, probabilities: &[f64]) -> usize {
        let mut rest = self.uniform();
        for (index, probability) in probabilities.iter().enumerate() {
            rest -= probability;
            if rest < 0.0 {
                return index;
            }
        }
        probabilities.len() - 1 // a rounding beyond 1
    }
}

/// A world with a policy to be learned, whose every policy's worth is known.
pub trait Problem {
    fn n_parameters(&self) -> usize;

    /// One action and its consequence: writes the score, returns the reward.
    fn step(&mut self, theta: &[f64], draws: &mut Draws, score: &mut [f64]) -> f64;

    /// The exact average reward of a policy.
    fn average_reward(&self, theta: &[f64]) -> f64;

    /// The largest average reward that any policy can have.
    fn optimum(&self) -> f64;
}

/// Estimator and optimiser, and the number of steps between updates.
pub struct Learner {
    pub estimator: Estimator,
    pub optimiser: Box<dyn Optimiser>,
    pub steps: u32,
}

impl Learner {
    /// One loop of steps with the same parameters, then an update from their estimate.
    pub fn learn(
        &mut self,
        problem: &mut impl Problem,
        theta: &mut [f64],
        draws: &mut Draws,
    ) -> Result<(), Error> {
        let mut score = vec![0.0; theta.len()];
        self.estimator.restart();
        for _ in 0..self.steps {
            let reward = problem.step(theta, draws, &mut score);
            self.estimator.accumulate(&score, reward)?;
        }
        self.optimiser.update(theta, self.estimator.gradient())
    }
}

/// The list with the settings that suit these problems; those that aren't named are the defaults.
pub fn suited_optimisers() -> Vec<OptimiserSettings> {
    let suited = |settings| match settings {
        OptimiserSettings::Momentum(settings) => {
            OptimiserSettings::Momentum(MomentumSettings { rate: 30.0, ..settings })
        }
        OptimiserSettings::Adam(settings) => {
            OptimiserSettings::Adam(AdamSettings { rate: 0.1, ..settings })
        }
        // Noise turns signs around, so that step sizes shrink for no reason: not below 0.05.
        OptimiserSettings::Rprop(settings) => {
            OptimiserSettings::Rprop(RpropSettings { smallest: 0.05, ..settings })
        }
    };
    OptimiserSettings::all().into_iter().map(suited).collect()
}

/// Mean of the runs' values and its standard error, elementwise.
pub fn mean_and_standard_error<const N: usize>(runs: &[[f64; N]]) -> ([f64; N], [f64; N]) {
    let n = runs.len() as f64;
    let (mut mean, mut error) = ([0.0; N], [0.0; N]);
    for i in 0..N {
        mean[i] = runs.iter().map(|run| run[i]).sum::<f64>() / n;
        let squares = runs.iter().map(|run| (run[i] - mean[i]) * (run[i] - mean[i]));
        error[i] = (squares.sum::<f64>() / (n - 1.0) / n).sqrt();
    }
    (mean, error)
}
