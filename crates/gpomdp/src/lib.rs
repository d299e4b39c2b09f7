//! Policy gradients from one long run: the GPOMDP estimator, and optimisers that follow it.
//!
//! Some agent acts by chance, with probabilities p(action|sensors) that depend on parameters. It
//! is never reset, and sees only a part of its world's state. An [`Estimator`] hears of every step
//! two things, the *score* grad log p(action|sensors) and the reward that followed, and estimates
//! from them the gradient of the average reward. An [`Optimiser`] then moves the parameters. Both
//! work on slices of `f64` and know nothing of the policy or the world.
//!
//! ```
//! use gpomdp::{Estimator, EstimatorSettings, MomentumSettings, OptimiserSettings};
//! use rand_chacha::{ChaCha8Rng, rand_core::{Rng, SeedableRng}};
//!
//! let mut rng = ChaCha8Rng::seed_from_u64(1);
//! let mut theta = [0.0]; // p(switch on) = 1 / (1 + exp(-theta)), and light is rewarded
//! let mut estimator = Estimator::new(1, &EstimatorSettings::default())?;
//! let mut optimiser = OptimiserSettings::Momentum(MomentumSettings::default()).build(1)?;
//! for _update in 0..200 {
//!     for _step in 0..100 {
//!         let p = 1.0 / (1.0 + f64::exp(-theta[0]));
//!         let on = f64::from(rng.next_u32()) < p * f64::from(u32::MAX);
//!         let (score, reward) = if on { (1.0 - p, 1.0) } else { (-p, 0.0) };
//!         estimator.accumulate(&[score], reward)?;
//!     }
//!     optimiser.update(&mut theta, estimator.gradient())?;
//!     estimator.restart();
//! }
//! assert!(theta[0] > 3.0, "on, with a probability above 0.95");
//! # Ok::<(), gpomdp::Error>(())
//! ```
//!
//! # The estimate
//! In each step the trace z <- beta z + score remembers the actions that the reward r may be due
//! to, and the estimate is the mean of r z (J. Baxter and P. L. Bartlett, Infinite-Horizon
//! Policy-Gradient Estimation, Journal of Artificial Intelligence Research 15 (2001), 319-350).
//! In the long run it converges to
//!
//! ```text
//!     pi' grad(P) (r + beta P r + beta^2 P^2 r + ...)
//! ```
//!
//! for a world with the transition matrix P, its stationary distribution pi and rewards r, all
//! under the policy. The gradient of the average reward is the limit for beta -> 1. A small beta
//! doesn't see what an action leads to later: bias. A large one gives each reward to many actions
//! that have nothing to do with it: noise. In percent of the length of the exact gradient, for the
//! three-state chain that the method was published with (`tests/problems/chain.rs`) and T steps
//! for an estimate, `cargo run -p gpomdp --release --example discount_bias` prints:
//!
//! | beta | bias | noise, T = 100 | noise, T = 10,000 |
//! |---|---|---|---|
//! | 0 | 7.7 % | 38 % | 4 % |
//! | 0.4 | 4.8 % | 48 % | 5 % |
//! | 0.75 | 2.0 % | 81 % | 8 % |
//! | 0.9 | 0.8 % | 156 % | 16 % |
//! | 0.95 | 0.4 % | 262 % | 30 % |
//! | 0.99 | 0.1 % | 602 % | 137 % |
//!
//! The chain forgets its past within some steps, so its bias is small. What a beta does in another
//! world depends on 1/(1 - beta), the steps that the trace remembers, against the steps that an
//! action's consequences need. Much of the noise comes from the constant part of the reward, which
//! a [baseline](EstimatorSettings::baseline_factor) takes out.
//!
//! # The optimisers
//! | [`OptimiserSettings`] | what | made for |
//! |---|---|---|
//! | [`Momentum`] | gradient ascent with momentum and weight decay | noisy estimates |
//! | [`Adam`] | steps scaled by running moments | noisy estimates, parameters of unlike scales |
//! | [`Rprop`] | step sizes from signs (iRprop-) | long estimates with little noise |
//!
//! `cargo run -p gpomdp --release --example chain` shows all of them on the three-state chain.
//!
//! # Promises
//! - From a stationary start and without a baseline, the expected estimate of a loop of T steps is,
//!   to rounding, the formula above with the term of beta^s less by the factor 1 - s/T, since the
//!   trace begins anew; long runs converge to the formula (`tests/oracles.rs`).
//! - The same input gives the same bits, on any CPU with IEEE 754 arithmetic and at any
//!   optimisation level: nothing but sums, products, quotients and square roots, element by
//!   element, in the order in which the formulas are written (`tests/bits.rs`).
//! - NaN, infinity, numbers beyond [`LIMIT`] and slices of a wrong length are errors, and leave
//!   everything as it was. Nothing overflows after that (`tests/estimator.rs`,
//!   `tests/optimisers.rs`).
//! - What has run on from a restored state has the same bits as what was never interrupted.
//! - A step allocates nothing, and costs one pass over the slices beyond the checks.

#![forbid(unsafe_code)]

mod baseline;
mod check;
mod error;
mod estimator;
mod optimiser;

pub use check::LIMIT;
pub use error::Error;
pub use estimator::{Estimator, EstimatorSettings};
pub use optimiser::{
    Adam, AdamSettings, Momentum, MomentumSettings, Optimiser, OptimiserSettings, Rprop,
    RpropSettings, Setting,
};
