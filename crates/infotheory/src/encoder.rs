//! Joint states of several variables as one number, injectively.
//!
//! [`MixedRadix`] computes the number of a state: with symbols s_1 .. s_m and radices k_1 .. k_m,
//!
//! ```text
//! code = ((s_1 k_2 + s_2) k_3 + s_3) k_4 + ...,   0 <= s_i < k_i
//! ```
//!
//! which is a bijection onto 0 .. k_1 k_2 ... k_m - 1. Each symbol is weighted by the radices
//! *behind* it. To weigh by another radix, one symbol's own say, looks right as long as all are
//! equal, and merges states where they aren't. The product must fit 64 bits, or there is no encoder.
//!
//! [`Dictionary`] numbers the states that occur, in the order in which they do. It has no bound
//! but memory, so it also takes joint states far beyond 64 bits.

use crate::{
    error::{Error, check_length, refused},
    keys::Keys,
};

/// Numbers all joint states of variables with given radices, at most 2^64 states.
///
/// ```
/// let encoder = infotheory::MixedRadix::new(&[2, 3, 5])?;
/// assert_eq!(encoder.encode(&[1, 2, 3])?, (1 * 3 + 2) * 5 + 3);
/// # Ok::<(), infotheory::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MixedRadix {
    radices: Vec<u64>,
    n_states: u128,
}

impl MixedRadix {
    /// An encoder for variables with `radices` states each, at least 1. Without variables there's
    /// one state, number 0.
    pub fn new(radices: &[u64]) -> Result<Self, Error> {
        let mut n_states = 1_u128;
        for (i, &radix) in radices.iter().enumerate() {
            if radix == 0 {
                return Err(refused("MixedRadix::new", format!("radix {i}"), "at least 1", radix));
            }
            // No overflow: at most 2^64 times less than 2^64.
            n_states *= u128::from(radix);
            if n_states > 1 << 64 {
                return Err(Error::TooManyStates { call: "MixedRadix::new", n_radices: i + 1 });
            }
        }
        Ok(Self { radices: radices.to_vec(), n_states })
    }

    /// The variables' numbers of states.
    #[must_use]
    pub fn radices(&self) -> &[u64] {
        &self.radices
    }

    /// Number of joint states, 1 to 2^64.
    #[must_use]
    pub fn n_states(&self) -> u128 {
        self.n_states
    }

    /// The number of a joint state.
    pub fn encode(&self, symbols: &[u64]) -> Result<u64, Error> {
        check_length("MixedRadix::encode", "symbols", self.radices.len(), symbols.len())?;
        let misfit = |i: usize| symbols[i] >= self.radices[i];
        if let Some(i) = (0..symbols.len()).find(|&i| misfit(i)) {
            let expected = format!("below {}", self.radices[i]);
            return Err(refused("MixedRadix::encode", format!("symbol {i}"), expected, symbols[i]));
        }
        Ok(self.code_of(symbols.iter().copied()))
    }

    /// The joint state of a number.
    pub fn decode(&self, code: u64, symbols: &mut [u64]) -> Result<(), Error> {
        check_length("MixedRadix::decode", "symbols", self.radices.len(), symbols.len())?;
        if u128::from(code) >= self.n_states {
            let expected = format!("below {}", self.n_states);
            return Err(refused("MixedRadix::decode", "code", expected, code));
        }
        let mut rest = code;
        for (symbol, &radix) in symbols.iter_mut().zip(&self.radices).rev() {
            *symbol = rest % radix;
            rest /= radix;
        }
        Ok(())
    }

    /// The code of symbols that are known to be in range. It's below `n_states`, so nothing wraps.
    pub(crate) fn code_of(&self, symbols: impl Iterator<Item = u64>) -> u64 {
        symbols.zip(&self.radices).fold(0, |code, (symbol, &radix)| code * radix + symbol)
    }
}

/// Numbers joint states of any size as they appear: the first is 0, the next new one 1.
///
/// ```
/// let mut dictionary = infotheory::Dictionary::new(2);
/// assert_eq!(dictionary.encode(&[u64::MAX, u64::MAX])?, 0);
/// assert_eq!(dictionary.encode(&[u64::MAX, 7])?, 1);
/// assert_eq!(dictionary.encode(&[u64::MAX, u64::MAX])?, 0);
/// # Ok::<(), infotheory::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Dictionary {
    states: Keys,
}

impl Dictionary {
    /// For states of `n_symbols` symbols. Without symbols there's one state.
    #[must_use]
    pub fn new(n_symbols: usize) -> Self {
        Self { states: Keys::new(n_symbols) }
    }

    /// Number of different states seen.
    #[must_use]
    pub fn len(&self) -> usize {
        self.states.len()
    }

    /// Whether no state was seen yet.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number of a state, a new one if it's new. There's room for 2^32 - 1.
    pub fn encode(&mut self, symbols: &[u64]) -> Result<u64, Error> {
        const CALL: &str = "Dictionary::encode";
        check_length(CALL, "symbols", self.states.width(), symbols.len())?;
        if let Some(code) = self.states.find(symbols) {
            return Ok(u64::from(code));
        }
        if self.len() == Keys::MAX_KEYS {
            return Err(refused(CALL, "symbols", "a state seen before: it's full", "a new one"));
        }
        Ok(u64::from(self.states.insert(symbols)))
    }

    /// The number of a state that was seen, or `None`.
    pub fn find(&self, symbols: &[u64]) -> Result<Option<u64>, Error> {
        check_length("Dictionary::find", "symbols", self.states.width(), symbols.len())?;
        Ok(self.states.find(symbols).map(u64::from))
    }

    /// The state of a number.
    pub fn decode(&self, code: u64) -> Result<&[u64], Error> {
        match u32::try_from(code) {
            Ok(slot) if code < self.len() as u64 => Ok(self.states.key(slot)),
            _ => {
                let expected = format!("below {}, the states seen", self.len());
                Err(refused("Dictionary::decode", "code", expected, code))
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_first_symbol_weighs_most() {
        let encoder = MixedRadix::new(&[2, 3, 5]).unwrap();
        assert_eq!(encoder.n_states(), 30);
        assert_eq!(encoder.encode(&[1, 2, 3]), Ok(28));
        let mut symbols = [9; 3];
        encoder.decode(28, &mut symbols).unwrap();
        assert_eq!(symbols, [1, 2, 3]);
    }

    #[test]
    fn sixty_four_bits_are_all_there() {
        let encoder = MixedRadix::new(&[2; 64]).unwrap();
        assert_eq!(encoder.n_states(), 1 << 64);
        assert_eq!(encoder.encode(&[1; 64]), Ok(u64::MAX));
        let mut symbols = [9; 64];
        encoder.decode(u64::MAX, &mut symbols).unwrap();
        assert_eq!(symbols, [1; 64]);
        assert_eq!(encoder.encode(&[0; 64]), Ok(0));
    }

    #[test]
    fn one_bit_more_is_an_error() {
        assert_eq!(
            MixedRadix::new(&[2; 65]).unwrap_err().to_string(),
            "MixedRadix::new: radices must multiply to at most 2^64, got more with the first 65"
        );
        let radices = [u64::MAX, u64::MAX, u64::MAX];
        let error = Error::TooManyStates { call: "MixedRadix::new", n_radices: 2 };
        assert_eq!(MixedRadix::new(&radices), Err(error));
    }

    #[test]
    fn no_variables_have_one_state() {
        let none = MixedRadix::new(&[]).unwrap();
        assert_eq!((none.n_states(), none.encode(&[])), (1, Ok(0)));
        let mut dictionary = Dictionary::new(0);
        assert_eq!((dictionary.encode(&[]), dictionary.encode(&[])), (Ok(0), Ok(0)));
        assert_eq!(dictionary.len(), 1);
    }

    #[test]
    fn misfits_are_refused_with_place_and_value() {
        let encoder = MixedRadix::new(&[2, 3]).unwrap();
        let dictionary = Dictionary::new(2);
        let message = |error: Error| error.to_string();
        for (found, expected) in [
            (
                MixedRadix::new(&[2, 0]).map(|_| ()),
                "MixedRadix::new: radix 1 must be at least 1, got 0",
            ),
            (
                encoder.encode(&[2, 0]).map(|_| ()),
                "MixedRadix::encode: symbol 0 must be below 2, got 2",
            ),
            (
                encoder.encode(&[0]).map(|_| ()),
                "MixedRadix::encode: the length of symbols must be 2, got 1",
            ),
            (encoder.decode(6, &mut [0; 2]), "MixedRadix::decode: code must be below 6, got 6"),
            (
                dictionary.clone().encode(&[0]).map(|_| ()),
                "Dictionary::encode: the length of symbols must be 2, got 1",
            ),
            (
                dictionary.decode(1 << 32).map(|_| ()),
                "Dictionary::decode: code must be below 0, the states seen, got 4294967296",
            ),
        ] {
            assert_eq!(found.map_err(message), Err(expected.to_owned()));
        }
    }

    proptest! {
        #[test]
        fn every_code_is_the_code_of_one_state(
            radices in prop::collection::vec(1_u64..7, 0..6),
        ) {
            let encoder = MixedRadix::new(&radices)?;
            let mut symbols = vec![0; radices.len()];
            for code in 0..encoder.n_states() as u64 {
                encoder.decode(code, &mut symbols)?;
                prop_assert_eq!(encoder.encode(&symbols)?, code);
            }
        }

        #[test]
        fn a_state_comes_back_from_its_code_whatever_the_radices(
            radices in prop::collection::vec(1_u64..=1 << 16, 0..4),
            numbers: [u64; 4],
        ) {
            let encoder = MixedRadix::new(&radices)?;
            let symbols: Vec<u64> = radices.iter().zip(numbers).map(|(k, n)| n % k).collect();
            let mut decoded = vec![9; radices.len()];
            encoder.decode(encoder.encode(&symbols)?, &mut decoded)?;
            prop_assert_eq!(symbols, decoded);
        }

        #[test]
        fn a_dictionary_numbers_states_as_they_appear(
            states in prop::collection::vec(prop::array::uniform3(0_u64..3), 0..60),
        ) {
            let mut dictionary = Dictionary::new(3);
            let mut seen: Vec<[u64; 3]> = Vec::new();
            for state in states {
                let known = seen.iter().position(|&other| other == state);
                prop_assert_eq!(dictionary.find(&state)?, known.map(|code| code as u64));
                if known.is_none() {
                    seen.push(state);
                }
                let code = known.unwrap_or(seen.len() - 1);
                prop_assert_eq!(dictionary.encode(&state)?, code as u64);
                prop_assert_eq!(dictionary.decode(code as u64)?, &state);
                prop_assert_eq!(dictionary.len(), seen.len());
            }
        }
    }
}
