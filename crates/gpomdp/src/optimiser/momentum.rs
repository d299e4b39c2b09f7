//! Gradient ascent with momentum and weight decay.
//!
//! ```text
//!     dtheta <- rate (Delta - decay theta) + momentum dtheta
//!     theta  <- theta + dtheta
//! ```
//!
//! from dtheta = 0. The momentum is B. T. Polyak's heavy ball (Some methods of speeding up the
//! convergence of iteration methods, USSR Computational Mathematics and Mathematical Physics 4
//! (1964), 1-17); in this form, with the decay of the weights inside the step, it's what G. Hinton
//! recommends for restricted Boltzmann machines (A Practical Guide to Training Restricted
//! Boltzmann Machines, 2010, sections 9 and 10).

use super::{Optimiser, check_update, settings};
use crate::{
    Error,
    check::{self, LIMIT},
};

/// A momentum below 1 keeps the step below this for all accepted gradients and rates:
/// 2^53 times 1e100 times 2e100.
const STEP_LIMIT: f64 = 1e217;

settings! {
    /// The settings of [`Momentum`].
    MomentumSettings {
        rate: "learning rate", 1.0,
            "> 0 and at most 1e100", |it| it.rate > 0.0 && it.rate <= LIMIT;
        decay: "part of the parameters that is taken off the gradient", 1e-5,
            "within 0 to 1", |it| (0.0..=1.0).contains(&it.decay);
        momentum: "part of the last step that goes into this one", 0.5,
            ">= 0 and < 1", |it| (0.0..1.0).contains(&it.momentum);
    }
}

/// Gradient ascent with momentum and weight decay:
/// step <- rate (gradient - decay parameters) + momentum step, parameters <- parameters + step.
#[derive(Clone, Debug, PartialEq)]
pub struct Momentum {
    settings: MomentumSettings,
    /// dtheta, [n_parameters]
    step: Vec<f64>,
}

impl Momentum {
    /// The optimiser before its first step.
    ///
    /// # Errors
    /// A setting that is out of range; more parameters than there is memory for.
    pub fn new(n_parameters: usize, settings: &MomentumSettings) -> Result<Self, Error> {
        let place = "Momentum::new";
        settings.check(place)?;
        Ok(Self { settings: settings.clone(), step: check::filled(place, n_parameters, 0.0)? })
    }
}

impl Optimiser for Momentum {
    fn n_parameters(&self) -> usize {
        self.step.len()
    }

    fn update(&mut self, parameters: &mut [f64], gradient: &[f64]) -> Result<(), Error> {
        check_update("Momentum::update", self.step.len(), parameters, gradient)?;
        let MomentumSettings { rate, decay, momentum } = self.settings;
        for ((theta, dtheta), &delta) in parameters.iter_mut().zip(&mut self.step).zip(gradient) {
            *dtheta = rate * (delta - decay * *theta) + momentum * *dtheta;
            *theta += *dtheta;
        }
        Ok(())
    }

    /// dtheta, `[n_parameters]`.
    fn state(&self) -> Vec<f64> {
        self.step.clone()
    }

    fn restore(&mut self, state: &[f64]) -> Result<(), Error> {
        check::slice("Momentum::restore", "state", state, self.step.len(), STEP_LIMIT)?;
        self.step.copy_from_slice(state);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// By hand, in binary fractions: 0.5 (2 - 0.25 * 4) = 0.5; 0.5 (1 - 0.25 * 4.5) + 0.5 * 0.5
    /// = 0.1875; 0.5 (0 - 0.25 * 4.6875) + 0.5 * 0.1875 = -0.4921875.
    #[test]
    fn three_steps_worked_by_hand() {
        let settings = MomentumSettings { rate: 0.5, decay: 0.25, momentum: 0.5 };
        let mut momentum = Momentum::new(1, &settings).unwrap();
        let mut theta = [4.0];
        for (gradient, step) in [(2.0, 0.5), (1.0, 0.1875), (0.0, -0.4921875)] {
            let before = theta[0];
            momentum.update(&mut theta, &[gradient]).unwrap();
            assert_eq!(momentum.state(), [step]);
            assert_eq!(theta[0], before + step);
        }
    }

    /// With a constant gradient g and no decay, step n is g (1 - momentum^n)/(1 - momentum).
    #[test]
    fn a_constant_gradient_ends_in_a_constant_speed() {
        let settings = MomentumSettings { rate: 1.0, decay: 0.0, momentum: 0.5 };
        let mut momentum = Momentum::new(1, &settings).unwrap();
        let mut theta = [0.0];
        for n in 1..=40 {
            momentum.update(&mut theta, &[3.0]).unwrap();
            assert_eq!(momentum.state(), [3.0 * (1.0 - 0.5_f64.powi(n)) / 0.5], "step {n}");
        }
    }

    /// Where rate and gradient balance, theta = gradient / decay.
    #[test]
    fn decay_holds_parameters_at_gradient_over_decay() {
        let settings = MomentumSettings { rate: 1.0, decay: 0.01, momentum: 0.5 };
        let mut momentum = Momentum::new(2, &settings).unwrap();
        let mut theta = [0.0, 100.0];
        for _ in 0..3000 {
            momentum.update(&mut theta, &[0.5, -0.25]).unwrap();
        }
        // What is left of the way shrinks by about 0.98 a step: to e^-60, below the roundings.
        assert!((theta[0] - 50.0).abs() < 1e-11, "{theta:?}");
        assert!((theta[1] + 25.0).abs() < 1e-11, "{theta:?}");
    }
}
