//! Adam: steps scaled by running moments of the gradient.
//!
//! At step t, with gradient g, elementwise and uphill:
//!
//! ```text
//!     m <- beta1 m + (1 - beta1) g              mhat = m / (1 - beta1^t)
//!     v <- beta2 v + (1 - beta2) g^2            vhat = v / (1 - beta2^t)
//!     theta <- theta + rate mhat / (sqrt(vhat) + epsilon)
//! ```
//!
//! from m = v = 0. Source: D. P. Kingma and J. Ba, Adam: A Method for Stochastic Optimization,
//! ICLR 2015, algorithm 1. The powers beta^t are kept as running products, since what `powi` gives
//! isn't the same everywhere; the square root is exact by IEEE 754.

use super::{Optimiser, check_update, settings};
use crate::{
    Error,
    check::{self, LIMIT},
};

/// Powers in a state, before the moments.
const HEAD: usize = 2;

settings! {
    /// What [`Adam`] can be told. The defaults are the article's.
    AdamSettings {
        rate: "learning rate, about the largest step of a parameter", 0.001,
            "> 0 and at most 1e100", |it| it.rate > 0.0 && it.rate <= LIMIT;
        mean_factor: "factor per update of the gradient's running mean, beta1", 0.9,
            ">= 0 and < 1", |it| (0.0..1.0).contains(&it.mean_factor);
        square_factor: "factor per update of its square's running mean, beta2", 0.999,
            ">= 0 and < 1", |it| (0.0..1.0).contains(&it.square_factor);
        // Not smaller, so that no step can overflow.
        epsilon: "summand that keeps the divisor from 0; gradients much below it hardly move anything",
            1e-8, "within 1e-50 to 1e100", |it| (1e-50..=LIMIT).contains(&it.epsilon);
    }
}

/// Adam: each parameter's step is the running mean of its gradient over the root of the running
/// mean of its square.
#[derive(Clone, Debug, PartialEq)]
pub struct Adam {
    settings: AdamSettings,
    /// beta1^t, beta2^t
    powers: [f64; HEAD],
    /// m, [n_parameters]
    mean: Vec<f64>,
    /// v, [n_parameters]
    square: Vec<f64>,
}

impl Adam {
    /// The optimiser before its first step.
    ///
    /// # Errors
    /// A setting that is out of range; more parameters than there is memory for.
    pub fn new(n_parameters: usize, settings: &AdamSettings) -> Result<Self, Error> {
        let place = "Adam::new";
        settings.check(place)?;
        Ok(Self {
            settings: settings.clone(),
            powers: [1.0, 1.0],
            mean: check::filled(place, n_parameters, 0.0)?,
            square: check::filled(place, n_parameters, 0.0)?,
        })
    }
}

impl Optimiser for Adam {
    fn n_parameters(&self) -> usize {
        self.mean.len()
    }

    fn update(&mut self, parameters: &mut [f64], gradient: &[f64]) -> Result<(), Error> {
        check_update("Adam::update", self.mean.len(), parameters, gradient)?;
        let AdamSettings { rate, mean_factor: beta1, square_factor: beta2, epsilon } =
            self.settings;
        self.powers[0] *= beta1;
        self.powers[1] *= beta2;
        let (correct1, correct2) = (1.0 - self.powers[0], 1.0 - self.powers[1]);
        let moments = self.mean.iter_mut().zip(&mut self.square);
        for ((theta, &g), (m, v)) in parameters.iter_mut().zip(gradient).zip(moments) {
            *m = beta1 * *m + (1.0 - beta1) * g;
            *v = beta2 * *v + (1.0 - beta2) * (g * g);
            let (mhat, vhat) = (*m / correct1, *v / correct2);
            *theta += rate * mhat / (vhat.sqrt() + epsilon);
        }
        Ok(())
    }

    /// beta1^t, beta2^t, m, v: `[2 + 2 n_parameters]`.
    fn state(&self) -> Vec<f64> {
        [&self.powers[..], &self.mean, &self.square].concat()
    }

    fn restore(&mut self, state: &[f64]) -> Result<(), Error> {
        let place = "Adam::restore";
        let n = self.mean.len();
        // Means of squares are below the square of the limit, but for roundings.
        check::slice(place, "state", state, HEAD + 2 * n, 2.0 * LIMIT * LIMIT)?;
        let (powers, moments) = state.split_at(HEAD);
        let (mean, square) = moments.split_at(n);
        for (what, &power) in ["power of mean_factor", "power of square_factor"].iter().zip(powers)
        {
            check::number((0.0..=1.0).contains(&power), place, what, "within 0 to 1", power)?;
        }
        check::slice(place, "means", mean, n, 2.0 * LIMIT)?;
        if let Some(&negative) = square.iter().find(|square| **square < 0.0) {
            check::number(false, place, "a mean of squares", ">= 0", negative)?;
        }
        self.powers.copy_from_slice(powers);
        self.mean.copy_from_slice(mean);
        self.square.copy_from_slice(square);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Bias correction makes both moments of a constant gradient exact from the first step on, so
    /// every step is rate g / (|g| + epsilon).
    #[test]
    fn a_constant_gradient_makes_steps_of_the_rate() {
        let settings = AdamSettings { rate: 0.25, ..AdamSettings::default() };
        let mut adam = Adam::new(3, &settings).unwrap();
        let mut theta = [0.0; 3];
        let gradient = [1000.0, -1.0, 1e-8];
        for t in 1..=500 {
            adam.update(&mut theta, &gradient).unwrap();
            for (theta, g) in theta.iter().zip(gradient) {
                let expected = 0.25 * f64::from(t) * g / (g.abs() + 1e-8);
                // 1 - beta2 and 1 - beta2^t come with an error of epsilon/2 each, relative to
                // 0.001, which grows by the recursion's 500 roundings.
                assert!((theta / expected - 1.0).abs() < 1e-12, "step {t}: {theta}, {expected}");
            }
        }
    }

    /// m and v from their sums over all gradients so far, in place of the recursion.
    #[test]
    fn the_moments_are_weighted_means_of_all_gradients() {
        let settings =
            AdamSettings { rate: 0.1, mean_factor: 0.5, square_factor: 0.75, epsilon: 0.0625 };
        let mut adam = Adam::new(1, &settings).unwrap();
        let (mut theta, mut expected) = ([1.0], 1.0);
        let gradients: Vec<f64> = (0..20).map(|i| f64::from(i * i % 7) - 2.5).collect();
        for t in 1..=gradients.len() {
            adam.update(&mut theta, &gradients[t - 1..t]).unwrap();
            let mean = |factor: f64, power: i32| {
                let weights = (0..t).map(|i| factor.powi((t - 1 - i) as i32));
                let sum: f64 =
                    weights.clone().zip(&gradients).map(|(w, g)| w * g.powi(power)).sum();
                sum / weights.sum::<f64>()
            };
            expected += 0.1 * mean(0.5, 1) / (mean(0.75, 2).sqrt() + 0.0625);
            // Some 20 roundings of numbers around 1.
            assert!((theta[0] - expected).abs() < 1e-14, "step {t}: {theta:?}, {expected}");
        }
    }
}
