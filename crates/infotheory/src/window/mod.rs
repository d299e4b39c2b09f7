//! The information between successive readings in a sliding window: the intrinsic reward of
//! G. Montúfar, K. Ghazi-Zahedi and N. Ay, *Information theoretically aided reinforcement learning
//! for embodied agents* (2016).
//!
//! At time t the window holds the last N <= T' pairs (s, s') of a variable's states. With n(s, s')
//! their counts, n(s) and n(s') those of their first and second members, and s the first member of
//! the newest pair,
//!
//! ```text
//! r_t = sum_{s'} p(s'|s) ln( p(s'|s) / p(s') ),   p(s'|s) = n(s, s') / n(s),   p(s') = n(s') / N
//! ```
//!
//! over the successors s' of s that occur. (The paper doesn't say by which marginal p(s'|s) is
//! normalised; by that of the first members it sums to 1.) That's what s tells about its successor,
//! the *specific surprise* of M. DeWeese and M. Meister, *How to measure the information gained from
//! one symbol* (1999). It isn't negative, and its mean over the pairs in the window is their mutual
//! information, which is at most ln min(K, T') for K states. A single r_t can be as large as
//! ln N.
//!
//! Miller and Madow's correction of that mutual information is shared out among the pairs. With K_s
//! successors of s and K' second members that occur,
//!
//! ```text
//! r_t + (K' - 1) / 2N - (K_s - 1) / 2n(s)
//! ```
//!
//! whose mean over the pairs is the corrected mutual information, since sum_s K_s is the number of
//! different pairs. It's right for that mean; for a single value it is only as far as s and s' are
//! independent. Single values can be negative.
//!
//! Counts and logarithms are integers, so values are those of a recount from scratch, bit for bit,
//! however long the window has been sliding.

mod counted;
mod counts;
mod dense;
mod readings;
mod sparse;
mod transfer;
mod values;
mod variable;

use crate::{
    error::{Error, check_length, check_room, refused},
    information::{Estimator, Information},
    logs,
};
pub use transfer::TransferWindow;

use readings::Readings;
use variable::{States, Variable};

/// What a [`Window`] holds, fixed for its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WindowSettings {
    /// T', the number of pairs that the window holds when it's full, 1 to 2^20. With 1, every value
    /// is 0.
    pub pairs: usize,
    /// Readings from the first member's newest reading to the second member, 1 to 2^20. For several
    /// lags, make a window for each.
    pub lag: usize,
    /// Readings that make up the first member, a joint state, 1 to 64.
    pub past: usize,
}

/// 100 pairs of consecutive readings.
impl Default for WindowSettings {
    fn default() -> Self {
        Self { pairs: 100, lag: 1, past: 1 }
    }
}

impl WindowSettings {
    fn check(&self) -> Result<(), Error> {
        for (name, value, most) in
            [("pairs", self.pairs, 1 << 20), ("lag", self.lag, 1 << 20), ("past", self.past, 64)]
        {
            if !(1..=most).contains(&value) {
                return Err(refused("Window::new", name, format!("1 to {most}"), value));
            }
        }
        Ok(())
    }

    /// Readings that a pair spans.
    fn pair_span(&self) -> usize {
        self.lag + self.past
    }

    /// Readings that a full window spans.
    fn span(&self) -> usize {
        self.pairs + self.pair_span() - 1
    }
}

/// Groups for [`Window::new`]: each of `n_sensors` sensors by itself.
#[must_use]
pub fn each_sensor(n_sensors: usize) -> Vec<Vec<usize>> {
    (0..n_sensors).map(|sensor| vec![sensor]).collect()
}

/// Groups for [`Window::new`]: all of `n_sensors` sensors as one joint state.
#[must_use]
pub fn all_sensors(n_sensors: usize) -> Vec<Vec<usize>> {
    vec![(0..n_sensors).collect()]
}

/// The last pairs of readings, counted for several variables.
///
/// A variable is a group of sensors; its state is their joint state, of any number of bits. Few
/// states are counted in tables, many in hash tables, with the same results. A reading costs O(1)
/// for each variable, a value as much as there are successors of one state; neither allocates.
///
/// ```
/// use infotheory::{Estimator, Window, WindowSettings, each_sensor};
///
/// // Two sensors of 2 states: one alternates, one never moves.
/// let mut window = Window::new(WindowSettings::default(), &[2, 2], &each_sensor(2))?;
/// for t in 0..=100 {
///     window.push(&[t % 2, 0])?;
/// }
/// let surprise = |sensor| window.specific_surprise(sensor, Estimator::PlugIn);
/// assert!((surprise(0)?.bits() - 1.0).abs() < 1e-12);
/// assert_eq!(surprise(1)?.bits(), 0.0);
/// assert!((window.share_of_maximum(Estimator::PlugIn) - 0.5).abs() < 1e-12);
/// # Ok::<(), infotheory::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Window {
    settings: WindowSettings,
    /// [n_sensors]
    radices: Vec<u64>,
    variables: Vec<Variable>,
    readings: Readings,
    /// [T' + 1]: ln n in units of 2^-53.
    ln: Vec<i64>,
    /// [words of a reading]: the one that comes in.
    incoming: Vec<u64>,
    /// Of sensors and groups.
    hash: u64,
}

impl Window {
    /// An empty window on sensors with `radices` states each, for variables that are `groups` of
    /// sensors, given by their places in a reading. A sensor may be in several groups or in none.
    ///
    /// It takes about 8 (T' + lag) bytes a variable and, for those with many states,
    /// some 130 T' more; longer pasts and states beyond 64 bits add 8 T' for each 64 bits.
    ///
    /// # Errors
    /// [`Error::Argument`] for settings out of range, sensors that aren't there, and empty groups;
    /// [`Error::Memory`] if there's no room for it, with nothing allocated.
    pub fn new(
        settings: WindowSettings,
        radices: &[u64],
        groups: &[impl AsRef<[usize]>],
    ) -> Result<Self, Error> {
        settings.check()?;
        if let Some(sensor) = radices.iter().position(|&radix| radix == 0) {
            let argument = format!("the radix of sensor {sensor}");
            return Err(refused("Window::new", argument, "at least 1", 0));
        }
        if groups.is_empty() {
            return Err(refused("Window::new", "the number of groups", "at least 1", 0));
        }
        let states = groups.iter().enumerate();
        let states: Vec<States> = states
            .map(|(place, group)| States::new(radices, place, group.as_ref()))
            .collect::<Result<_, _>>()?;
        check_room("Window::new", bytes(&settings, &states))?;
        let n_words = states.iter().map(States::n_words).sum();
        let mut variables: Vec<Variable> = Vec::with_capacity(groups.len());
        for states in states {
            let first_word = variables.last().map_or(0, |variable| variable.words.end);
            variables.push(Variable::new(&settings, states, first_word));
        }
        Ok(Self {
            settings,
            radices: radices.to_vec(),
            variables,
            readings: Readings::new(n_words, settings.span()),
            ln: (0..=settings.pairs as u64).map(logs::ln_fixed).collect(),
            incoming: vec![0; n_words],
            hash: hash_of(radices, groups),
        })
    }

    /// What the window was made with.
    #[must_use]
    pub fn settings(&self) -> &WindowSettings {
        &self.settings
    }

    /// The number of variables.
    #[must_use]
    pub fn n_variables(&self) -> usize {
        self.variables.len()
    }

    /// Pairs in the window: none for the first lag + past - 1 readings, then one more with each,
    /// up to T'.
    #[must_use]
    pub fn n_pairs(&self) -> usize {
        (self.readings.len() + 1).saturating_sub(self.settings.pair_span())
    }

    /// Takes in the next reading: each sensor's symbol, below its radix.
    ///
    /// `reading`: \[n_sensors\]
    pub fn push(&mut self, reading: &[u64]) -> Result<(), Error> {
        check_reading("Window::push", reading, &self.radices)?;
        for variable in &self.variables {
            variable.encode(reading, &mut self.incoming[variable.words.clone()]);
        }
        self.slide();
        Ok(())
    }

    /// What the newest pair's first member s tells about its successor, for one variable:
    ///
    /// ```text
    /// r = sum_{s'} p(s'|s) ln( p(s'|s) / p(s') )
    /// ```
    ///
    /// with p(s'|s) = n(s, s') / n(s) and p(s') = n(s') / N counted over the N pairs in the window.
    /// [`Estimator::MillerMadow`] adds (K' - 1) / 2N - (K_s - 1) / 2n(s), where K' different second
    /// members occur and K_s successors of s. 0 as long as there are no pairs.
    ///
    /// After G. Montúfar, K. Ghazi-Zahedi and N. Ay, *Information theoretically aided reinforcement
    /// learning for embodied agents* (2016).
    pub fn specific_surprise(
        &self,
        variable: usize,
        estimator: Estimator,
    ) -> Result<Information, Error> {
        let variable = self.variable("Window::specific_surprise", variable)?;
        Ok(Information::from_nats(self.surprise_nats(variable, estimator)))
    }

    /// The mean of [`specific_surprise`](Self::specific_surprise) over the variables.
    #[must_use]
    pub fn mean_specific_surprise(&self, estimator: Estimator) -> Information {
        Information::from_nats(self.mean(|variable| self.surprise_nats(variable, estimator)))
    }

    /// The mean over the variables of [`specific_surprise`](Self::specific_surprise) as a share of
    /// the greatest mutual information that the variable can have, ln min(K, T') for K states. Times
    /// the greatest reward wanted, that's the reward.
    ///
    /// The mean over the pairs is at most 1; single values exceed it and aren't clipped. A variable
    /// of one state, or a window of one pair, can't have any information: its share is 0.
    #[must_use]
    pub fn share_of_maximum(&self, estimator: Estimator) -> f64 {
        self.mean(|variable| {
            let most = self.most_nats(variable);
            if most > 0.0 { self.surprise_nats(variable, estimator) / most } else { 0.0 }
        })
    }

    /// Mutual information of the first and the second members of all pairs in the window, for one
    /// variable. It takes O(T') steps, or as many as there are pairs of states if they're few. 0 as
    /// long as there are no pairs.
    pub fn mutual_information(
        &self,
        variable: usize,
        estimator: Estimator,
    ) -> Result<Information, Error> {
        let variable = self.variable("Window::mutual_information", variable)?;
        Ok(Information::from_nats(self.mutual_nats(variable, estimator)))
    }

    /// The mean of [`mutual_information`](Self::mutual_information) over the variables.
    #[must_use]
    pub fn mean_mutual_information(&self, estimator: Estimator) -> Information {
        Information::from_nats(self.mean(|variable| self.mutual_nats(variable, estimator)))
    }

    /// Empties the window.
    pub fn clear(&mut self) {
        self.readings.clear();
        for variable in &mut self.variables {
            variable.counts.clear();
        }
    }

    /// Writes the window's state, for [`restore`](Self::restore): six words that say of what shape
    /// it is (T', lag, past, words of a reading, a hash of sensors and groups, number of readings) and
    /// the readings, oldest first.
    pub fn save(&self, words: &mut Vec<u64>) {
        words.clear();
        words.extend(self.shape());
        words.push(self.readings.len() as u64);
        for age in (0..self.readings.len()).rev() {
            words.extend_from_slice(self.readings.row(age));
        }
    }

    /// Takes up a saved state, in a window made with the same arguments. It continues with the same
    /// bits.
    pub fn restore(&mut self, words: &[u64]) -> Result<(), Error> {
        const CALL: &str = "Window::restore";
        let Some((header, rows)) = words.split_at_checked(6) else {
            return Err(refused(CALL, "the length of words", "at least 6", words.len()));
        };
        let shape = self.shape();
        for (place, &expected) in shape.iter().enumerate() {
            if header[place] != expected {
                let name = ["pairs", "lag", "past", "the words of a reading", "the sensors' hash"];
                let name = name[place];
                return Err(refused(CALL, name, expected.to_string(), header[place]));
            }
        }
        let n_readings = header[5];
        if n_readings > self.settings.span() as u64 {
            let expected = format!("at most {}", self.settings.span());
            return Err(refused(CALL, "the number of readings", expected, n_readings));
        }
        let n_words = self.incoming.len();
        check_length(CALL, "words", 6 + n_readings as usize * n_words, words.len())?;
        for row in rows.chunks_exact(n_words) {
            for variable in &self.variables {
                variable.check(CALL, &row[variable.words.clone()])?;
            }
        }
        self.clear();
        for row in rows.chunks_exact(n_words) {
            self.incoming.copy_from_slice(row);
            self.slide();
        }
        Ok(())
    }

    /// Drops the oldest pair of a full window, then adds the newest one.
    fn slide(&mut self) {
        let settings = &self.settings;
        if self.readings.len() == settings.span() {
            for variable in &mut self.variables {
                variable.remove_pair(&self.readings, settings, settings.pairs - 1);
            }
        }
        self.readings.push(&self.incoming);
        if self.readings.len() >= settings.pair_span() {
            for variable in &mut self.variables {
                variable.add_pair(&self.readings, settings, 0);
            }
        }
    }

    fn shape(&self) -> [u64; 5] {
        let WindowSettings { pairs, lag, past } = self.settings;
        [pairs as u64, lag as u64, past as u64, self.incoming.len() as u64, self.hash]
    }

    fn variable(&self, call: &'static str, variable: usize) -> Result<&Variable, Error> {
        self.variables.get(variable).ok_or_else(|| {
            refused(call, "variable", format!("below {}", self.variables.len()), variable)
        })
    }

    fn surprise_nats(&self, variable: &Variable, estimator: Estimator) -> f64 {
        values::specific_surprise(&variable.counts, self.n_pairs(), &self.ln, estimator)
    }

    fn mutual_nats(&self, variable: &Variable, estimator: Estimator) -> f64 {
        values::mutual_information(&variable.counts, self.n_pairs(), &self.ln, estimator)
    }

    /// ln min(K, T')
    fn most_nats(&self, variable: &Variable) -> f64 {
        let states = variable.n_states.min(self.settings.pairs as u64);
        logs::nats(i128::from(self.ln[states as usize]), 1)
    }

    /// Over the variables, in their order. There's at least one.
    fn mean(&self, nats: impl Fn(&Variable) -> f64) -> f64 {
        let sum = self.variables.iter().fold(0.0, |sum, variable| sum + nats(variable));
        sum / self.variables.len() as f64
    }
}

/// What a window of these variables allocates, but for some hundred bytes a variable.
fn bytes(settings: &WindowSettings, states: &[States]) -> usize {
    let n_words = states.iter().map(States::n_words).sum();
    let counts = states.iter().map(|states| states.bytes(settings));
    let logarithms = size_of::<i64>() * (settings.pairs + 1);
    let readings = Readings::bytes(n_words, settings.span());
    counts.fold(readings.saturating_add(logarithms), usize::saturating_add)
}

/// A reading has a symbol of each sensor, below its radix.
fn check_reading(call: &'static str, reading: &[u64], radices: &[u64]) -> Result<(), Error> {
    check_length(call, "reading", radices.len(), reading.len())?;
    let mut symbols = reading.iter().zip(radices);
    match symbols.position(|(symbol, radix)| symbol >= radix) {
        None => Ok(()),
        Some(sensor) => {
            let argument = format!("the symbol of sensor {sensor}");
            let expected = format!("below {}", radices[sensor]);
            Err(refused(call, argument, expected, reading[sensor]))
        }
    }
}

/// FNV-1a over the states of the sensors and the sensors of the groups: a saved window of others
/// isn't this one.
fn hash_of(radices: &[u64], groups: &[impl AsRef<[usize]>]) -> u64 {
    let sensors = groups.iter().flat_map(|group| {
        let group = group.as_ref();
        std::iter::once(group.len()).chain(group.iter().copied())
    });
    let numbers = radices.iter().copied().chain(sensors.map(|number| number as u64));
    numbers.flat_map(u64::to_le_bytes).fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// What is said to be needed is what is taken, within the sizes that hash tables come in.
    #[test]
    fn its_bytes_are_those_that_it_allocates() {
        for (pairs, lag, past) in [(1, 1, 1), (100, 1, 1), (5000, 3, 1), (3000, 1, 16)] {
            let settings = WindowSettings { pairs, lag, past };
            for radix in [2, 1 << 20, u64::MAX] {
                let radices = vec![radix; 12];
                let groups = [all_sensors(12), each_sensor(12)].concat();
                let group = |(i, group): (usize, &Vec<usize>)| States::new(&radices, i, group);
                let states: Vec<_> =
                    groups.iter().enumerate().map(group).collect::<Result<_, _>>().unwrap();
                let said = bytes(&settings, &states);
                // The probe for room is as large as what was said: only what stays is counted.
                let counted = allocation_counter::measure(|| {
                    std::mem::forget(Window::new(settings, &radices, &groups).unwrap());
                });
                let stays = counted.bytes_current as usize;
                let small = 1_000 * groups.len();
                assert!(stays <= said + small, "{stays} stay, {said} said");
                assert!(said <= stays + stays / 10 + 300_000, "{stays} stay, {said} said");
            }
        }
    }

    #[test]
    fn more_than_there_is_memory_for_is_refused_with_the_amount() {
        let settings = WindowSettings { pairs: 1 << 20, lag: 1, past: 64 };
        // Beyond the address space; a system that promises more than it has would take less.
        let groups = vec![(0..500).collect::<Vec<_>>(); 4096];
        let error = Window::new(settings, &[u64::MAX; 500], &groups).unwrap_err();
        assert!(matches!(error, Error::Memory { bytes, .. } if bytes > 1 << 49), "{error}");
        let message = error.to_string();
        assert!(message.starts_with("Window::new: it takes ") && message.contains(" MB, and"));
    }
}
