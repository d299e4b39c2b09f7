//! GPOMDP in each world: the gradient is the mean of their estimates, summed in their order.
//!
//! Its standard error is that of a mean of W: the root of sum_w |g_w - g|^2 / (W (W - 1)).

use gpomdp::{Estimator, EstimatorSettings};

use super::Learner;

pub(super) struct Gpomdp {
    /// One a world.
    estimators: Vec<Estimator>,
    /// Of the last gradient; NaN of one world.
    error: f64,
}

impl Gpomdp {
    pub(super) fn new(
        settings: &EstimatorSettings,
        n_parameters: usize,
        worlds: usize,
    ) -> anyhow::Result<Self> {
        let estimator = Estimator::new(n_parameters, settings)?;
        Ok(Self { estimators: vec![estimator; worlds], error: f64::NAN })
    }
}

impl Learner for Gpomdp {
    fn needs_scores(&self) -> bool {
        true
    }

    fn candidate(&self, _: u64, _: usize, theta: &[f64], candidate: &mut [f64]) {
        candidate.copy_from_slice(theta);
    }

    fn observe(&mut self, world: usize, score: &[f64], reward: f64) -> anyhow::Result<()> {
        Ok(self.estimators[world].accumulate(score, reward)?)
    }

    fn steps(&self, world: usize) -> u64 {
        self.estimators[world].steps()
    }

    fn gradient(&mut self, _: u64, gradient: &mut [f64]) -> anyhow::Result<()> {
        let n = self.estimators.len() as f64;
        let mut squares = 0.0;
        gradient.fill(0.0);
        for estimator in &mut self.estimators {
            let one = estimator.gradient();
            for (sum, value) in gradient.iter_mut().zip(one) {
                *sum += value;
                squares += value * value;
            }
            estimator.restart();
        }
        gradient.iter_mut().for_each(|sum| *sum /= n);
        let square: f64 = gradient.iter().map(|value| value * value).sum();
        // 0 / 0 of one world; and roundings may take the difference below 0.
        self.error = ((squares / n - square).max(0.0) / (n - 1.0)).sqrt();
        Ok(())
    }

    fn gradient_error(&self) -> f64 {
        self.error
    }

    fn state(&self, world: usize) -> Vec<f64> {
        self.estimators[world].state()
    }

    fn restore(&mut self, world: usize, state: &[f64]) -> anyhow::Result<()> {
        Ok(self.estimators[world].restore(state)?)
    }
}
