//! Named streams of random numbers: a seed and a name give the same numbers on any machine, whatever
//! else is drawn beside them. So what is added to a program later changes nothing that was drawn
//! before.
//!
//! ```
//! use rand_chacha::rand_core::Rng;
//!
//! let draw = |seed, name| streams::named(seed, name).next_u64();
//! assert_eq!(draw(1, "policy"), draw(1, "policy"));
//! assert_ne!(draw(1, "policy"), draw(1, "start"));
//! assert_ne!(draw(1, "policy"), draw(2, "policy"));
//! ```
//!
//! [`named`] is a stream of words, [`Normals`] are draws from N(0,1).

#![forbid(unsafe_code)]

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use xxhash_rust::xxh3::xxh3_128;

/// A stream's start: ChaCha8 with the key seed, 128-bit hash of the stream's name, zeros.
#[must_use]
pub fn named(seed: u64, name: &str) -> ChaCha8Rng {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8..24].copy_from_slice(&xxh3_128(name.as_bytes()).to_le_bytes());
    ChaCha8Rng::from_seed(key)
}

/// Draws from N(0,1) by the transform of Box and Muller (1958), with `libm`'s functions.
#[derive(Clone, Debug)]
pub struct Normals {
    uniforms: ChaCha8Rng,
    /// Half of the last pair.
    spare: Option<f64>,
}

impl Normals {
    /// The start of a named stream.
    #[must_use]
    pub fn new(seed: u64, name: &str) -> Self {
        Self { uniforms: named(seed, name), spare: None }
    }

    /// The next one. None is farther out than 8.6.
    pub fn draw(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        // In (0, 1], whose logarithm is finite.
        let mut uniform = || ((self.uniforms.next_u64() >> 11) + 1) as f64 / (1u64 << 53) as f64;
        let radius = libm::sqrt(-2.0 * libm::log(uniform()));
        let angle = std::f64::consts::TAU * uniform();
        self.spare = Some(radius * libm::sin(angle));
        radius * libm::cos(angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 100,000 draws: mean within 5 standard errors (false alarms: 6e-7), and variance, whose
    /// standard error is sqrt(2/n), too.
    #[test]
    fn normals_have_mean_0_and_variance_1() {
        let mut normals = Normals::new(1, "test");
        let n = 100_000;
        let draws: Vec<f64> = (0..n).map(|_| normals.draw()).collect();
        let mean = draws.iter().sum::<f64>() / n as f64;
        let variance = draws.iter().map(|draw| draw * draw).sum::<f64>() / n as f64;
        assert!(mean.abs() < 5.0 / (n as f64).sqrt(), "{mean}");
        assert!((variance - 1.0).abs() < 5.0 * (2.0 / n as f64).sqrt(), "{variance}");
    }
}
