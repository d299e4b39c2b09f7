//! The perturbation: now and then some of the policy's output bits are flipped before they are
//! executed, which the paper likens to a strong wind.
//!
//! Whether a bit is flipped in a control step depends on the seed, the step and the bit alone, so
//! there is nothing to save.

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use xxhash_rust::xxh3::xxh3_128;

/// The perturbation: it flips bits of the action now and then.
#[derive(Clone, Debug)]
pub struct Perturbation {
    every: u64,
    length: u64,
    /// Of 2^32.
    threshold: u64,
    start: ChaCha8Rng,
}

impl Perturbation {
    /// Active for `length` control steps, from every `every`-th on but not from step 0, and flips a
    /// bit with a probability, by a named stream of the seed's random numbers. With `every` 0 it
    /// never is.
    #[must_use]
    pub fn new(every: u64, length: u64, flip_probability: f64, seed: u64, stream: &str) -> Self {
        // Not quite the key of `streams::named`, which is younger: runs keep their bits.
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[16..].copy_from_slice(&xxh3_128(stream.as_bytes()).to_le_bytes());
        let threshold = (flip_probability * 4_294_967_296.0) as u64;
        Self { every, length, threshold, start: ChaCha8Rng::from_seed(key) }
    }

    /// Whether it is active in a control step.
    #[must_use]
    pub fn is_active(&self, step: u64) -> bool {
        self.every > 0 && step >= self.every && step % self.every < self.length
    }

    /// Flips some of an action's bits, if it is active in this control step.
    pub fn perturb(&self, step: u64, action: &mut [bool]) {
        if !self.is_active(step) {
            return;
        }
        let mut rng = self.start.clone();
        rng.set_stream(step);
        for bit in action {
            *bit ^= u64::from(rng.next_u32()) < self.threshold;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blows_when_it_should() {
        let perturbation = Perturbation::new(1000, 10, 0.1, 1, "perturbation");
        let active: Vec<_> = (0..3000).filter(|&step| perturbation.is_active(step)).collect();
        let expected: Vec<_> = (1000..1010).chain(2000..2010).collect();
        assert_eq!(active, expected);
        assert!(
            (0..3000).all(|step| !Perturbation::new(0, 10, 0.1, 1, "perturbation").is_active(step))
        );
    }

    /// 24,000 bits: the share of flips is within 5 standard errors, 0.01, of the probability.
    #[test]
    fn flips_as_many_as_it_should_and_the_same_again() {
        let perturbation = Perturbation::new(1, 1, 0.1, 7, "perturbation");
        let count = |perturbation: &Perturbation| -> Vec<usize> {
            let flips = |step| {
                let mut action = [false; 24];
                perturbation.perturb(step, &mut action);
                action.iter().filter(|&&bit| bit).count()
            };
            (1..=1000).map(flips).collect()
        };
        let flips = count(&perturbation);
        let share = flips.iter().sum::<usize>() as f64 / 24_000.0;
        assert!((share - 0.1).abs() < 0.01, "{share}");
        assert_eq!(flips, count(&Perturbation::new(1, 1, 0.1, 7, "perturbation")));
        assert_ne!(flips, count(&Perturbation::new(1, 1, 0.1, 8, "perturbation")));
        assert_eq!(count(&Perturbation::new(1, 1, 1.0, 7, "perturbation")), vec![24; 1000]);
        assert_eq!(count(&Perturbation::new(1, 1, 0.0, 7, "perturbation")), vec![0; 1000]);
    }
}
