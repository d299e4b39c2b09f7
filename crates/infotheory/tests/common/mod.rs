//! What the tests share: random symbols with a fixed seed, and recounts by the definitions.
#![allow(clippy::unwrap_used, dead_code, missing_docs, unreachable_pub)]

use std::collections::BTreeMap;

use infotheory::{Estimator, Window, all_sensors, each_sensor};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};

pub const BOTH: [Estimator; 2] = [Estimator::PlugIn, Estimator::MillerMadow];

/// Random symbols, the same at every run.
pub struct Random(ChaCha8Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Below `bound`; the bias of the remainder is bound / 2^64.
    pub fn below(&mut self, bound: u64) -> u64 {
        self.0.next_u64() % bound
    }

    pub fn symbols(&mut self, bound: u64, n: usize) -> Vec<u64> {
        (0..n).map(|_| self.below(bound)).collect()
    }

    /// True with a probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        ((self.0.next_u64() >> 11) as f64) < probability * 9_007_199_254_740_992.0
    }
}

/// A window's values from nothing but its pairs: (first, second), oldest first.
pub struct Recount<S> {
    pairs: Vec<(S, S)>,
    joint: BTreeMap<(S, S), u64>,
    firsts: BTreeMap<S, u64>,
    seconds: BTreeMap<S, u64>,
}

/// Sums of `libm` logs as multiples of 2^-53, which they are; see `src/logs.rs`.
fn ln(n: u64) -> i128 {
    (libm::log(n as f64) * 2.0_f64.powi(53)) as i128
}

fn nats(sum: i128, n: u64) -> f64 {
    (sum as f64 * 2.0_f64.powi(-53) / n as f64).max(0.0)
}

impl<S: Clone + Ord> Recount<S> {
    pub fn new(pairs: &[(S, S)]) -> Self {
        let (mut joint, mut firsts, mut seconds) =
            (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        for (first, second) in pairs {
            *joint.entry((first.clone(), second.clone())).or_insert(0) += 1;
            *firsts.entry(first.clone()).or_insert(0) += 1;
            *seconds.entry(second.clone()).or_insert(0) += 1;
        }
        Self { pairs: pairs.to_vec(), joint, firsts, seconds }
    }

    fn n(&self) -> u64 {
        self.pairs.len() as u64
    }

    /// n(s, s') and n(s') of the successors of s, n(s).
    fn row(&self, s: &S) -> (Vec<(u64, u64)>, u64) {
        let row = self
            .joint
            .iter()
            .filter(|((first, _), _)| first == s)
            .map(|((_, second), &n)| (n, self.seconds[second]))
            .collect();
        (row, self.firsts[s])
    }

    /// r of one first member, to be equal bit for bit.
    pub fn surprise_of(&self, s: &S) -> f64 {
        let (row, n_s) = self.row(s);
        let sum: i128 = row.iter().map(|&(n, second)| i128::from(n) * (ln(n) - ln(second))).sum();
        nats(sum + i128::from(n_s) * (ln(self.n()) - ln(n_s)), n_s)
    }

    /// r of the newest pair, bit for bit.
    pub fn surprise(&self) -> f64 {
        self.pairs.last().map_or(0.0, |(s, _)| self.surprise_of(s))
    }

    /// The same, term by term as in the paper, and corrected.
    pub fn surprise_by_definition(&self) -> (f64, f64) {
        self.pairs.last().map_or((0.0, 0.0), |(s, _)| self.surprise_by_definition_of(s))
    }

    pub fn surprise_by_definition_of(&self, s: &S) -> (f64, f64) {
        let (row, n_s) = self.row(s);
        let plug_in: f64 = row
            .iter()
            .map(|&(n, second)| {
                let (p_given_s, p) = (n as f64 / n_s as f64, second as f64 / self.n() as f64);
                p_given_s * (p_given_s / p).ln()
            })
            .sum();
        let corrected = plug_in + (self.seconds.len() as f64 - 1.0) / (2.0 * self.n() as f64)
            - (row.len() as f64 - 1.0) / (2.0 * n_s as f64);
        (plug_in, corrected)
    }
}

/// The window's pairs of one variable after some readings: `states` are its states so far.
pub fn pairs_of<S: Clone>(
    states: &[S],
    settings: &infotheory::WindowSettings,
) -> Vec<(Vec<S>, Vec<S>)> {
    let span = settings.lag + settings.past - 1;
    let n_pairs = states.len().saturating_sub(span).min(settings.pairs);
    (states.len() - n_pairs..states.len())
        .map(|t| {
            let end = t + 1 - settings.lag;
            (states[end - settings.past..end].to_vec(), vec![states[t].clone()])
        })
        .collect()
}

/// All values of a window, as bits.
pub fn values(window: &Window) -> Vec<u64> {
    let mut values = Vec::new();
    for estimator in BOTH {
        for i in 0..window.n_variables() {
            values.push(window.specific_surprise(i, estimator).unwrap().nats());
            values.push(window.mutual_information(i, estimator).unwrap().nats());
        }
        values.push(window.mean_specific_surprise(estimator).nats());
        values.push(window.mean_mutual_information(estimator).nats());
        values.push(window.share_of_maximum(estimator));
    }
    values.into_iter().map(f64::to_bits).collect()
}

/// Five sensors: a coin that remembers, a die, one of 40 states, one of 64 bits, one that is stuck.
pub const RADICES: [u64; 5] = [2, 6, 40, u64::MAX, 1];

/// By itself, in joint states that fit tables (2 x 6 states), hash tables (12 x 40) and more than
/// one word (64 bits and more).
pub fn groups() -> Vec<Vec<usize>> {
    let mut groups = each_sensor(5);
    groups.extend([vec![0, 1], vec![2, 1, 0], vec![3, 2, 0]]);
    groups.extend(all_sensors(5));
    groups
}

/// Readings of these sensors, each depending on the one before.
pub struct World {
    random: Random,
    state: [u64; 5],
}

impl World {
    pub fn new(seed: u64) -> Self {
        Self { random: Random::new(seed), state: [0; 5] }
    }

    pub fn reading(&mut self) -> [u64; 5] {
        let [coin, die, many, wide, stuck] = self.state;
        let random = &mut self.random;
        let steps = random.below(3);
        self.state = [
            if random.chance(0.2) { 1 - coin } else { coin },
            if random.chance(0.5) { random.below(6) } else { (die + 1) % 6 },
            (many + steps) % 40,
            if random.chance(0.7) { wide } else { u64::MAX - 1 - random.below(5) },
            stuck,
        ];
        self.state
    }
}
