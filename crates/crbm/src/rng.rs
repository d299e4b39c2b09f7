//! Named streams of random numbers: one xoshiro128++ a chain, seeded by ChaCha.
//!
//! xoshiro128++ (Blackman and Vigna, Scrambled Linear Pseudorandom Number Generators, 2021) has
//! period 2^128 - 1 and passes BigCrush; it takes additions, shifts and exclusive ors of 32-bit
//! words, so that 16 of them run in one AVX-512 register. The states of a stream's generators are
//! the words of the named stream in turn: that two of 64 generators meet within 2^45 draws each has a probability below 2^-70.

use rand_chacha::rand_core::Rng;
use streams::Normals;

use crate::{Error, error::check_room, layout::MAX_PARAMETER, simd::LANES};

/// Chains of one lane group, a word of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(align(64))]
pub(crate) struct Words(pub(crate) [u32; LANES]);

/// The generators of 16 chains: word 0 of all, word 1 of all, and so on.
pub(crate) type States = [Words; 4];

/// A stream of random numbers for a number of chains, each with a generator of its own.
///
/// Chain `i`'s numbers depend on the seed, the stream's name and `i`, and on nothing else.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChainRng {
    groups: Vec<States>,
}

impl ChainRng {
    /// A stream's start, with generators for at least `n_chains` chains: the next multiple of 16.
    pub fn new(seed: u64, stream: &str, n_chains: usize) -> Self {
        let mut words = streams::named(seed, stream);
        let groups = (0..n_chains.div_ceil(LANES)).map(|_| {
            let mut group = [Words([0; LANES]); 4];
            for lane in 0..LANES {
                for word in &mut group {
                    word.0[lane] = words.next_u32();
                }
                // The one state that would stay as it is; it comes once in 2^128.
                if group.iter().all(|word| word.0[lane] == 0) {
                    group[0].0[lane] = 1;
                }
            }
            group
        });
        Self { groups: groups.collect() }
    }

    /// The chains that it has generators for, a multiple of 16.
    pub fn n_chains(&self) -> usize {
        self.groups.len() * LANES
    }

    /// All of the state: four words a chain, `[n_chains x 4]`, row-major.
    pub fn words(&self) -> Vec<u32> {
        let lane = |group: &States, lane: usize| group.map(|word| word.0[lane]);
        self.groups.iter().flat_map(|group| (0..LANES).flat_map(move |i| lane(group, i))).collect()
    }

    /// Continues where [`words`](Self::words) were taken.
    ///
    /// # Errors
    /// If the number of words isn't a multiple of 64, or a chain's four are all zero, which
    /// xoshiro can't leave.
    pub fn from_words(words: &[u32]) -> Result<Self, Error> {
        let place = "ChainRng::from_words";
        let (groups, rest) = words.as_chunks::<{ 4 * LANES }>();
        if !rest.is_empty() {
            let expected = "a multiple of 64";
            return Err(Error::argument(place, "number of words", expected, words.len()));
        }
        if let Some(chain) = words.as_chunks::<4>().0.iter().position(|state| *state == [0; 4]) {
            let argument = format!("the state of chain {chain}");
            return Err(Error::argument(place, argument, "not all zero", "0, 0, 0, 0"));
        }
        let group = |words: &[u32; 4 * LANES]| {
            [0, 1, 2, 3].map(|word| Words(std::array::from_fn(|lane| words[4 * lane + word])))
        };
        Ok(Self { groups: groups.iter().map(group).collect() })
    }

    pub(crate) fn groups(&mut self) -> &mut [States] {
        &mut self.groups
    }
}

/// The start of learning: `scale` times a draw from N(0,1) for each of `n` parameters, in their
/// order. The draws depend on `seed` and `stream` only.
///
/// # Errors
/// If `scale` isn't finite, or so large that a parameter could pass [`MAX_PARAMETER`]; if there's no
/// memory for the parameters.
pub fn random_parameters(n: usize, scale: f64, seed: u64, stream: &str) -> Result<Vec<f64>, Error> {
    // No draw of 53 bits is farther out than 8.6.
    let largest = MAX_PARAMETER / 10.0;
    if !(0.0..=largest).contains(&scale) {
        let expected = format!("in 0..={largest}");
        return Err(Error::argument("random_parameters", "scale", expected, scale));
    }
    check_room("random_parameters", n.saturating_mul(size_of::<f64>()))?;
    let mut normals = Normals::new(seed, stream);
    Ok((0..n).map(|_| scale * normals.draw()).collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_restored_stream_is_the_same() {
        let rng = ChainRng::new(7, "policy", 61);
        assert_eq!(rng.n_chains(), 64);
        assert_eq!(ChainRng::from_words(&rng.words()).unwrap(), rng);
    }

    #[test]
    fn a_chains_state_does_not_depend_on_the_number_of_chains() {
        let few = ChainRng::new(7, "policy", 16).words();
        assert_eq!(ChainRng::new(7, "policy", 64).words()[..few.len()], few);
    }

    #[test]
    fn streams_differ_in_seed_and_name() {
        let words = |seed, name| ChainRng::new(seed, name, 16).words();
        assert_ne!(words(7, "policy"), words(8, "policy"));
        assert_ne!(words(7, "policy"), words(7, "perturbation"));
    }

    #[test]
    fn states_that_cannot_be_are_refused() {
        let message = |words: &[u32]| ChainRng::from_words(words).unwrap_err().to_string();
        assert_eq!(
            message(&[1; 63]),
            "ChainRng::from_words: number of words must be a multiple of 64, got 63"
        );
        let mut words = [1; 64];
        words[8..12].fill(0);
        assert_eq!(
            message(&words),
            "ChainRng::from_words: the state of chain 2 must be not all zero, got 0, 0, 0, 0"
        );
    }
}
