//! A variable: a group of sensors, the words that hold its joint state, and the counts of its pairs.
//!
//! Sensors are packed into words in their order, as many to a word as 64 bits can number
//! ([`MixedRadix`]), so a joint state of any size is one key, and equal keys are equal states.

use std::ops::Range;

use super::{WindowSettings, counts::Counts, readings::Readings};
use crate::{
    encoder::MixedRadix,
    error::{Error, refused},
};

#[derive(Clone, Debug)]
pub(super) struct Variable {
    /// One for each word of the state.
    packs: Vec<Pack>,
    /// Its part of a reading in the ring.
    pub(super) words: Range<usize>,
    /// Number of joint states; `u64::MAX` stands for all beyond.
    pub(super) n_states: u64,
    pub(super) counts: Counts,
    /// [past x words of the state]: the first member of a pair, newest reading first.
    first: Vec<u64>,
}

/// The joint states of a group of sensors.
pub(super) struct States {
    packs: Vec<Pack>,
    n_states: u64,
}

impl States {
    /// Of the group with a place in the list.
    pub(super) fn new(radices: &[u64], place: usize, group: &[usize]) -> Result<Self, Error> {
        check_group(radices, place, group)?;
        let packs = pack(radices, group)?;
        let n_states = packs
            .iter()
            .map(|pack| u64::try_from(pack.encoder.n_states()).unwrap_or(u64::MAX))
            .fold(1, u64::saturating_mul);
        Ok(Self { packs, n_states })
    }

    /// Words of a state.
    pub(super) fn n_words(&self) -> usize {
        self.packs.len()
    }

    /// What their [`Variable`] allocates for its counts.
    pub(super) fn bytes(&self, settings: &WindowSettings) -> usize {
        Counts::bytes(settings, self.n_states, self.packs.len())
    }
}

/// Sensors that share a word.
#[derive(Clone, Debug)]
struct Pack {
    sensors: Vec<usize>,
    encoder: MixedRadix,
}

impl Variable {
    /// The variable of a group's states, which are in a reading's words from `first_word` on.
    pub(super) fn new(settings: &WindowSettings, states: States, first_word: usize) -> Self {
        let States { packs, n_states } = states;
        Self {
            words: first_word..first_word + packs.len(),
            n_states,
            counts: Counts::new(settings, n_states, packs.len()),
            first: vec![0; settings.past * packs.len()],
            packs,
        }
    }

    /// Writes the variable's state in a checked reading.
    pub(super) fn encode(&self, reading: &[u64], words: &mut [u64]) {
        for (pack, word) in self.packs.iter().zip(words) {
            *word = pack.encoder.code_of(pack.sensors.iter().map(|&sensor| reading[sensor]));
        }
    }

    /// Whether these words are a state.
    pub(super) fn check(&self, call: &'static str, words: &[u64]) -> Result<(), Error> {
        for (pack, &word) in self.packs.iter().zip(words) {
            let n_states = pack.encoder.n_states();
            if u128::from(word) >= n_states {
                return Err(refused(call, "a state", format!("below {n_states}"), word));
            }
        }
        Ok(())
    }

    /// Counts the pair whose second member has an age.
    pub(super) fn add_pair(&mut self, readings: &Readings, settings: &WindowSettings, age: usize) {
        self.gather_first(readings, age + settings.lag);
        self.counts.add(&self.first, &readings.row(age)[self.words.clone()]);
    }

    /// Takes it back.
    pub(super) fn remove_pair(
        &mut self,
        readings: &Readings,
        settings: &WindowSettings,
        age: usize,
    ) {
        self.gather_first(readings, age + settings.lag);
        self.counts.remove(&self.first, &readings.row(age)[self.words.clone()]);
    }

    fn gather_first(&mut self, readings: &Readings, age: usize) {
        for (older, words) in self.first.chunks_exact_mut(self.packs.len()).enumerate() {
            words.copy_from_slice(&readings.row(age + older)[self.words.clone()]);
        }
    }
}

fn check_group(radices: &[u64], place: usize, group: &[usize]) -> Result<(), Error> {
    const CALL: &str = "Window::new";
    if group.is_empty() {
        return Err(refused(CALL, format!("group {place}"), "of at least 1 sensor", "none"));
    }
    for (i, &sensor) in group.iter().enumerate() {
        if sensor >= radices.len() {
            let expected = format!("of sensors below {}", radices.len());
            return Err(refused(CALL, format!("group {place}"), expected, sensor));
        }
        if group[..i].contains(&sensor) {
            let value = format!("{sensor} twice");
            return Err(refused(CALL, format!("group {place}"), "of different sensors", value));
        }
    }
    Ok(())
}

/// Fills word after word, each to at most 2^64 states. Radices are at least 1.
fn pack(radices: &[u64], group: &[usize]) -> Result<Vec<Pack>, Error> {
    let mut packs = Vec::new();
    let mut rest = group;
    while !rest.is_empty() {
        let mut n_states = 1_u128;
        let fits = |&&sensor: &&usize| {
            // At most 2^64 times less than 2^64; and once it doesn't fit, nothing more is asked.
            n_states *= u128::from(radices[sensor]);
            n_states <= 1 << 64
        };
        let n_sensors = rest.iter().take_while(fits).count();
        let (sensors, others) = rest.split_at(n_sensors);
        let radices: Vec<u64> = sensors.iter().map(|&sensor| radices[sensor]).collect();
        packs.push(Pack { sensors: sensors.to_vec(), encoder: MixedRadix::new(&radices)? });
        rest = others;
    }
    Ok(packs)
}
