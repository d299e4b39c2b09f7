//! An evolution strategy: a population of candidates around one point, and the direction in which
//! the better ones lie.
//!
//! A generation of n candidates tries n/2 random directions, each both ways, and weighs them by their
//! ranks:
//!
//! ```text
//! eps_j ~ N(0, I),  j = 0 .. n/2 - 1
//! theta_2j = theta + sigma eps_j,  theta_2j+1 = theta - sigma eps_j
//! u_k = (rank of candidate k's fitness, 0 for the lowest) / (n - 1) - 1/2
//! g = 1/(n sigma) sum_j (u_2j - u_2j+1) eps_j
//! ```
//!
//! g estimates the gradient of the mean of u over N(theta, sigma^2 I), and any optimiser may follow
//! it. Candidates of the same fitness share the mean of their ranks, so where all are equal, g is 0.
//! Ranks make it blind to the scale of the fitness, and to single huge values.
//!
//! Source: T. Salimans, J. Ho, X. Chen, S. Sidor and I. Sutskever, *Evolution Strategies as a Scalable
//! Alternative to Reinforcement Learning*, arXiv:1703.03864 (2017), algorithm 1 and section 2.1
//! (antithetic directions, ranks); with ranks as the utilities of D. Wierstra et al., *Natural
//! Evolution Strategies*, Journal of Machine Learning Research 15 (2014), 949-980.
//!
//! ```
//! use evolution::Strategy;
//!
//! let strategy = Strategy::new(20, 0.1, 1)?;
//! let mut theta = [0.0, 0.0]; // the best is at (3, -1)
//! let (mut candidate, mut gradient) = ([0.0; 2], [0.0; 2]);
//! for generation in 0..200 {
//!     let fitness = (0..strategy.population()).map(|k| {
//!         strategy.candidate(generation, k, &theta, &mut candidate);
//!         -(candidate[0] - 3.0).powi(2) - (candidate[1] + 1.0).powi(2)
//!     });
//!     let fitness: Vec<f64> = fitness.collect();
//!     strategy.gradient(generation, &fitness, &mut gradient)?;
//!     theta.iter_mut().zip(gradient).for_each(|(theta, g)| *theta += 0.03 * g);
//! }
//! assert!((theta[0] - 3.0).abs() < 0.1 && (theta[1] + 1.0).abs() < 0.1, "{theta:?}");
//! # Ok::<(), evolution::Error>(())
//! ```
//!
//! What always holds: directions depend on the seed, the generation and the pair alone, so there is
//! nothing to save between generations, and a candidate can be made anew at any time; the same input
//! gives the same bits anywhere. Robots, policies and optimisers aren't known here.

#![forbid(unsafe_code)]

use streams::Normals;

/// Why there's no strategy, or no gradient.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Candidates come in pairs.
    #[error("a population must be an even number of at least 2, got {0}")]
    Population(usize),
    /// The spread of the population.
    #[error("sigma must be a number above 0, at most 1e8, got {0}")]
    Sigma(f64),
    /// Each candidate has one fitness.
    #[error("there must be {expected} numbers of fitness, one a candidate, got {found}")]
    Length {
        /// The population.
        expected: usize,
        /// What there is.
        found: usize,
    },
    /// Ranks need an order.
    #[error("the fitness of candidate {candidate} must be a number, got NaN")]
    NotANumber {
        /// Which one, from 0.
        candidate: usize,
    },
}

/// An evolution strategy's settings, with the seed of its directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Strategy {
    population: usize,
    sigma: f64,
    seed: u64,
}

impl Strategy {
    /// For populations of this size, whose parameters spread by the standard deviation `sigma`.
    ///
    /// # Errors
    /// A population that's odd or empty; a sigma that is none.
    pub fn new(population: usize, sigma: f64, seed: u64) -> Result<Self, Error> {
        if population < 2 || !population.is_multiple_of(2) {
            return Err(Error::Population(population));
        }
        if !(sigma > 0.0 && sigma <= 1e8) {
            return Err(Error::Sigma(sigma));
        }
        Ok(Self { population, sigma, seed })
    }

    /// n, the number of candidates.
    #[must_use]
    pub fn population(&self) -> usize {
        self.population
    }

    /// Candidate `k` of a generation around theta, `[n_parameters]`, both counted from 0. `candidate`
    /// is as long as theta.
    pub fn candidate(&self, generation: u64, k: usize, theta: &[f64], candidate: &mut [f64]) {
        let step = if k.is_multiple_of(2) { self.sigma } else { -self.sigma };
        let mut direction = self.direction(generation, k / 2);
        for (candidate, theta) in candidate.iter_mut().zip(theta) {
            *candidate = theta + step * direction.draw();
        }
    }

    /// g, `[n_parameters]`, from the fitness of each candidate of a generation, `[population]`. An
    /// infinite fitness is a rank like any other.
    ///
    /// # Errors
    /// Another number of them; a fitness that is NaN. The gradient is then as before.
    pub fn gradient(
        &self,
        generation: u64,
        fitness: &[f64],
        gradient: &mut [f64],
    ) -> Result<(), Error> {
        let utilities = self.utilities(fitness)?;
        gradient.fill(0.0);
        let factor = 1.0 / (self.population as f64 * self.sigma);
        for (j, pair) in utilities.as_chunks::<2>().0.iter().enumerate() {
            let weight = factor * (pair[0] - pair[1]);
            let mut direction = self.direction(generation, j);
            gradient.iter_mut().for_each(|sum| *sum += weight * direction.draw());
        }
        Ok(())
    }

    /// u, the centred rank of each: -1/2 for the lowest fitness to 1/2 for the highest.
    fn utilities(&self, fitness: &[f64]) -> Result<Vec<f64>, Error> {
        let n = self.population;
        if fitness.len() != n {
            return Err(Error::Length { expected: n, found: fitness.len() });
        }
        if let Some(candidate) = fitness.iter().position(|value| value.is_nan()) {
            return Err(Error::NotANumber { candidate });
        }
        // Twice the mean rank of those with the same fitness: as many as are below, and to the last
        // of the equals.
        let count = |is: &dyn Fn(&&f64) -> bool| fitness.iter().filter(is).count();
        let twice_rank = |f: &f64| count(&|g| *g < f) + count(&|g| *g <= f) - 1;
        let most = (n - 1) as f64;
        Ok(fitness.iter().map(|f| (twice_rank(f) as f64 - most) / (2.0 * most)).collect())
    }

    fn direction(&self, generation: u64, pair: usize) -> Normals {
        Normals::new(self.seed, &format!("evolution, generation {generation}, pair {pair}"))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use proptest::{prop_assert_eq, prop_assume, proptest};

    use super::*;

    #[test]
    fn ranks_are_centred_and_equals_share_theirs() {
        let strategy = Strategy::new(4, 1.0, 1).unwrap();
        let of = |fitness: [f64; 4]| strategy.utilities(&fitness).unwrap();
        assert_eq!(of([7.0, -1.0, 1e300, 0.0]), [1.0 / 6.0, -0.5, 0.5, -1.0 / 6.0]);
        assert_eq!(of([2.0, 2.0, 2.0, 2.0]), [0.0; 4]);
        assert_eq!(of([2.0, f64::INFINITY, 2.0, 1.0]), [0.0, 0.5, 0.0, -0.5]);
    }

    /// The formula of the front page with one pair: g = (u_0 - u_1) eps / (2 sigma), u = +-1/2.
    #[test]
    fn one_pair_points_to_its_better_half() {
        let strategy = Strategy::new(2, 0.5, 9).unwrap();
        let (mut plus, mut minus, mut gradient) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        strategy.candidate(4, 0, &[1.0, 2.0, 3.0], &mut plus);
        strategy.candidate(4, 1, &[1.0, 2.0, 3.0], &mut minus);
        strategy.gradient(4, &[-1.0, 5.0], &mut gradient).unwrap();
        for i in 0..3 {
            let theta = [1.0, 2.0, 3.0][i];
            let eps = (plus[i] - theta) / 0.5;
            // Roundings of numbers below 10.
            assert!((minus[i] - (theta - 0.5 * eps)).abs() < 1e-14);
            assert!((gradient[i] + eps).abs() < 1e-14, "{gradient:?}");
        }
        strategy.gradient(5, &[-1.0, 5.0], &mut minus).unwrap();
        assert_ne!(gradient, minus, "another generation goes another way");
    }

    /// For a fitness a.theta with |a| = 1, u is a monotone function of a.eps, and the mean of
    /// g.a is the mean of u(x) x for x ~ N(0,1) over sigma: with u the distribution function less
    /// 1/2, 1/(2 sqrt(pi)). n is large, so the standard error is below 1/sqrt(n) = 0.016; 5 of them.
    #[test]
    fn the_gradient_of_a_slope_is_as_long_as_theory_says() {
        let (n, sigma) = (4000, 2.0);
        let strategy = Strategy::new(n, sigma, 3).unwrap();
        let a = [0.6, -0.8];
        let (mut candidate, mut gradient) = ([0.0; 2], [0.0; 2]);
        let fitness = (0..n).map(|k| {
            strategy.candidate(0, k, &[5.0, 5.0], &mut candidate);
            a[0] * candidate[0] + a[1] * candidate[1]
        });
        let fitness: Vec<f64> = fitness.collect();
        strategy.gradient(0, &fitness, &mut gradient).unwrap();
        let along: f64 = sigma * (gradient[0] * a[0] + gradient[1] * a[1]);
        let across: f64 = sigma * (gradient[0] * a[1] - gradient[1] * a[0]);
        assert!((along - 0.5 / std::f64::consts::PI.sqrt()).abs() < 0.08, "{along}");
        assert!(across.abs() < 0.08, "{across}");
    }

    /// In 20 dimensions, with steps of a constant rate: from distance 4.5 to below 0.5.
    #[test]
    fn it_finds_the_top_of_a_hill() {
        let strategy = Strategy::new(32, 0.1, 2).unwrap();
        let (mut theta, mut candidate, mut gradient) = ([1.0; 20], [0.0; 20], [0.0; 20]);
        for generation in 0..300 {
            let fitness = (0..32).map(|k| {
                strategy.candidate(generation, k, &theta, &mut candidate);
                -candidate.iter().map(|x| x * x).sum::<f64>()
            });
            let fitness: Vec<f64> = fitness.collect();
            strategy.gradient(generation, &fitness, &mut gradient).unwrap();
            theta.iter_mut().zip(gradient).for_each(|(theta, g)| *theta += 0.01 * g);
        }
        let distance = theta.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!(distance < 0.5, "{distance}");
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for population in [0, 1, 3] {
            assert_eq!(Strategy::new(population, 1.0, 1), Err(Error::Population(population)));
        }
        for sigma in [0.0, -1.0, f64::INFINITY] {
            assert_eq!(Strategy::new(2, sigma, 1), Err(Error::Sigma(sigma)));
        }
        assert!(Strategy::new(2, f64::NAN, 1).is_err());
        let strategy = Strategy::new(2, 1.0, 1).unwrap();
        let refused = |fitness: &[f64]| {
            let mut gradient = [7.0];
            let error = strategy.gradient(0, fitness, &mut gradient).unwrap_err();
            assert_eq!(gradient, [7.0]);
            error.to_string()
        };
        assert_eq!(refused(&[1.0]), "there must be 2 numbers of fitness, one a candidate, got 1");
        assert_eq!(
            refused(&[1.0, f64::NAN]),
            "the fitness of candidate 1 must be a number, got NaN"
        );
    }

    proptest! {
        /// Whatever grows with the fitness has the same ranks.
        #[test]
        fn the_scale_of_the_fitness_does_not_matter(
            fitness in proptest::collection::vec(-10.0..10.0_f64, 6),
        ) {
            let strategy = Strategy::new(6, 0.1, 1).unwrap();
            let scaled: Vec<_> = fitness.iter().map(|f| 1e6 * f * f * f - 3.0).collect();
            let all_differ = {
                let bits: std::collections::BTreeSet<_> = scaled.iter().map(|f| f.to_bits()).collect();
                bits.len() == 6
            };
            prop_assume!(all_differ);
            let (mut one, mut other) = ([0.0; 4], [0.0; 4]);
            strategy.gradient(7, &fitness, &mut one).unwrap();
            strategy.gradient(7, &scaled, &mut other).unwrap();
            prop_assert_eq!(one, other);
        }
    }
}
