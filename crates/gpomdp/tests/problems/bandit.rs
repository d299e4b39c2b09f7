//! Three arms that pay 1 with different probabilities, and a softmax policy with a parameter each:
//! p(a) = exp(theta_a) / sum_b exp(theta_b), d log p(a) / d theta_b = [a = b] - p(b).

use super::{Draws, Problem};

pub const PAYS: [f64; 3] = [0.2, 0.5, 0.8];

pub struct Bandit;

fn probabilities(theta: &[f64]) -> [f64; 3] {
    let largest = theta.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b));
    let weights = [0, 1, 2].map(|arm| libm::exp(theta[arm] - largest));
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}

impl Problem for Bandit {
    fn n_parameters(&self) -> usize {
        3
    }

    fn step(&mut self, theta: &[f64], draws: &mut Draws, score: &mut [f64]) -> f64 {
        let p = probabilities(theta);
        let arm = draws.index(&p);
        for (b, score) in score.iter_mut().enumerate() {
            *score = f64::from(u8::from(arm == b)) - p[b];
        }
        f64::from(u8::from(draws.uniform() < PAYS[arm]))
    }

    fn average_reward(&self, theta: &[f64]) -> f64 {
        probabilities(theta).iter().zip(PAYS).map(|(p, pay)| p * pay).sum()
    }

    fn optimum(&self) -> f64 {
        PAYS[2]
    }
}
