//! The running average of the rewards, to be subtracted from them.
//!
//! With a factor f, the rewards r_1, r_2, ... have the average
//!
//! ```text
//!     b_k = (r_k + f r_(k-1) + f^2 r_(k-2) + ...) / (1 + f + f^2 + ...)        (k terms each)
//! ```
//!
//! which is their plain mean at first and an exponential average later. It's kept as the weight
//! w = 1 + f + f^2 + ... and the average: w <- f w + 1, b <- b + (r - b)/w.

use crate::{Error, check};

/// A running average with an exponential memory.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RunningAverage {
    factor: f64,
    weight: f64,
    average: f64,
}

impl RunningAverage {
    /// The length of [`RunningAverage::save`].
    pub(crate) const STATE_LEN: usize = 2;

    pub(crate) fn new(factor: f64) -> Result<Self, Error> {
        let right = (0.0..=1.0).contains(&factor);
        check::number(right, "Estimator::new", "baseline_factor", "within 0 to 1", factor)?;
        Ok(Self { factor, weight: 0.0, average: 0.0 })
    }

    /// The average so far, if there is any reward.
    pub(crate) fn get(&self) -> Option<f64> {
        (self.weight > 0.0).then_some(self.average)
    }

    pub(crate) fn add(&mut self, reward: f64) {
        self.weight = self.factor * self.weight + 1.0;
        self.average += (reward - self.average) / self.weight;
    }

    pub(crate) fn save(&self, state: &mut Vec<f64>) {
        state.extend([self.weight, self.average]);
    }

    /// The same average with the numbers of [`RunningAverage::save`].
    pub(crate) fn restored(&self, place: &'static str, state: [f64; 2]) -> Result<Self, Error> {
        let [weight, average] = state;
        let right = weight == 0.0 || (1.0..=check::LARGEST_COUNT).contains(&weight);
        check::number(right, place, "the baseline's weight", "0, or within 1 to 2^53", weight)?;
        let right = average.abs() <= 2.0 * check::LIMIT; // a rounding more than a reward
        check::number(right, place, "the baseline", "within -2e100 to 2e100", average)?;
        Ok(Self { factor: self.factor, weight, average })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn it_is_the_weighted_mean_of_all_rewards() {
        for factor in [0.0, 0.5, 0.998, 1.0] {
            let mut average = RunningAverage::new(factor).unwrap();
            assert_eq!(average.get(), None);
            let (mut sum, mut weights) = (0.0, 0.0);
            for k in 0..200 {
                let reward = f64::from(k * 7919 % 31) - 11.0;
                average.add(reward);
                sum = factor * sum + reward;
                weights = factor * weights + 1.0;
                // 200 roundings of numbers up to 20.
                let difference = average.get().unwrap() - sum / weights;
                assert!(difference.abs() < 200.0 * 20.0 * f64::EPSILON, "{factor}, {k}");
            }
        }
    }

    #[test]
    fn a_constant_reward_is_its_own_average() {
        let mut average = RunningAverage::new(0.998).unwrap();
        for _ in 0..1000 {
            average.add(0.1);
            assert_eq!(average.get(), Some(0.1));
        }
    }
}
