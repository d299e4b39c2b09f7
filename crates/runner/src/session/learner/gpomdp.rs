//! GPOMDP in each world: the gradient is the mean of their estimates, summed in their order.

use gpomdp::{Estimator, EstimatorSettings};

use super::Learner;

pub(super) struct Gpomdp {
    /// One a world.
    estimators: Vec<Estimator>,
}

impl Gpomdp {
    pub(super) fn new(
        settings: &EstimatorSettings,
        n_parameters: usize,
        worlds: usize,
    ) -> anyhow::Result<Self> {
        let estimator = Estimator::new(n_parameters, settings)?;
        Ok(Self { estimators: vec![estimator; worlds] })
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
        gradient.fill(0.0);
        for estimator in &mut self.estimators {
            let one = estimator.gradient();
            gradient.iter_mut().zip(one).for_each(|(sum, value)| *sum += value);
            estimator.restart();
        }
        gradient.iter_mut().for_each(|sum| *sum /= n);
        Ok(())
    }

    fn state(&self, world: usize) -> Vec<f64> {
        self.estimators[world].state()
    }

    fn restore(&mut self, world: usize, state: &[f64]) -> anyhow::Result<()> {
        Ok(self.estimators[world].restore(state)?)
    }
}
