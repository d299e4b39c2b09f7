//! An evolution strategy: each world has a candidate, whose fitness is its mean reward over an
//! episode, but for the first steps, which the settled robot takes to get going.

use ::evolution::Strategy;
use anyhow::ensure;

use super::Learner;
use crate::experiment::EvolutionSettings;

pub(super) struct Evolution {
    strategy: Strategy,
    /// Control steps at the start of an episode that don't count.
    skip: u64,
    /// Of each world in this episode: control steps, and the sum of the rewards that count.
    sums: Vec<(u64, f64)>,
}

impl Evolution {
    pub(super) fn new(
        settings: &EvolutionSettings,
        worlds: usize,
        seed: u64,
    ) -> anyhow::Result<Self> {
        let strategy = Strategy::new(worlds, settings.sigma, seed)?;
        Ok(Self { strategy, skip: settings.skip, sums: vec![(0, 0.0); worlds] })
    }
}

impl Learner for Evolution {
    fn begins_anew(&self) -> bool {
        true
    }

    fn candidate(&self, update: u64, world: usize, theta: &[f64], candidate: &mut [f64]) {
        self.strategy.candidate(update, world, theta, candidate);
    }

    fn observe(&mut self, world: usize, _: &[f64], reward: f64) -> anyhow::Result<()> {
        let (steps, sum) = &mut self.sums[world];
        *steps += 1;
        if *steps > self.skip {
            *sum += reward;
        }
        Ok(())
    }

    fn steps(&self, world: usize) -> u64 {
        self.sums[world].0
    }

    fn gradient(&mut self, update: u64, gradient: &mut [f64]) -> anyhow::Result<()> {
        // All have as many steps, so sums are in the order of means.
        let fitness: Vec<f64> = self.sums.iter().map(|&(_, sum)| sum).collect();
        self.strategy.gradient(update, &fitness, gradient)?;
        self.sums.fill((0, 0.0));
        Ok(())
    }

    fn state(&self, world: usize) -> Vec<f64> {
        let (steps, sum) = self.sums[world];
        vec![steps as f64, sum]
    }

    fn restore(&mut self, world: usize, state: &[f64]) -> anyhow::Result<()> {
        let is_count = |steps: f64| (0.0..9e15).contains(&steps) && steps.trunc() == steps;
        let &[steps, sum] = state else {
            anyhow::bail!("expected steps and a sum of rewards, got {} numbers", state.len());
        };
        ensure!(is_count(steps), "steps must be a whole number, got {steps}");
        ensure!(sum.is_finite(), "the sum of rewards must be a finite number, got {sum}");
        self.sums[world] = (steps as u64, sum);
        Ok(())
    }
}
