//! Uniform random numbers of a policy in `f64`, from a named stream, with a state that can be saved.

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};

use crate::{Error, error::check_length};

/// A named stream.
#[derive(Clone, Debug)]
pub(crate) struct Uniform(ChaCha8Rng);

impl Uniform {
    /// From the start of a stream.
    pub(crate) fn new(seed: u64, stream: &str) -> Self {
        Self(streams::named(seed, stream))
    }

    /// The next one: a multiple of 2^-53 in [0, 1).
    pub(crate) fn draw(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The generator's key, eight words, and how many of its words are drawn, in three.
    pub(crate) fn state(&self) -> Vec<u32> {
        let (key, position) = (self.0.get_seed(), self.0.get_word_pos());
        let words = key.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes));
        words.chain([0, 32, 64].map(|shift| (position >> shift) as u32)).collect()
    }

    /// What [`Policy::set_random_state`](crate::Policy::set_random_state) does.
    pub(crate) fn set_state(&mut self, state: &[u32]) -> Result<(), Error> {
        let place = "Policy::set_random_state";
        check_length(place, "state", 11, state.len())?;
        // 2^64 blocks of 16 words.
        if state[10] >= 16 {
            return Err(Error::argument(place, "state[10]", "below 16", state[10]));
        }
        let mut key = [0; 32];
        for (bytes, word) in key.chunks_mut(4).zip(state) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        let position = state[8..].iter().rev().fold(0, |sum, &word| sum << 32 | u128::from(word));
        self.0 = ChaCha8Rng::from_seed(key);
        self.0.set_word_pos(position);
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_state_may_be_however_far_in_the_stream() {
        let mut uniform = Uniform::new(1, "policy");
        let mut state = uniform.state();
        state[8..].copy_from_slice(&[5, 7, 15]);
        uniform.set_state(&state).unwrap();
        assert_eq!(uniform.state(), state);
        state[10] = 16;
        let message = uniform.set_state(&state).unwrap_err().to_string();
        assert_eq!(message, "Policy::set_random_state: state[10] must be below 16, got 16");
    }
}
