//! How often each first member, second member and pair occurs in a window: in tables if there are
//! few states, in hash tables if there are many.

use super::{WindowSettings, dense::Dense, sparse::Sparse};

/// Counts of a variable's pairs.
#[derive(Clone, Debug)]
pub(super) enum Counts {
    Dense(Dense),
    Sparse(Box<Sparse>),
}

/// The most pairs of states that are counted in a table. A table's row is summed from end to end,
/// empty places too, so a state has at most 32 successors: about as long as a hash table takes.
const MOST_DENSE_PAIRS: u64 = 1024;

impl Counts {
    /// For a variable of `n_states` states in `n_words` words.
    pub(super) fn new(settings: &WindowSettings, n_states: u64, n_words: usize) -> Self {
        if is_dense(settings, n_states, n_words) {
            Self::Dense(Dense::new(n_states as usize, settings.past))
        } else {
            Self::Sparse(Box::new(Sparse::new(settings, n_words)))
        }
    }

    /// What [`Counts::new`] allocates.
    pub(super) fn bytes(settings: &WindowSettings, n_states: u64, n_words: usize) -> usize {
        if is_dense(settings, n_states, n_words) {
            // First members, second members and pairs: no more each than there are pairs.
            3 * 4 * MOST_DENSE_PAIRS as usize
        } else {
            size_of::<Sparse>().saturating_add(Sparse::bytes(settings, n_words))
        }
    }

    /// Adds a pair and makes it the newest.
    pub(super) fn add(&mut self, first: &[u64], second: &[u64]) {
        match self {
            Self::Dense(counts) => counts.add(first, second[0]),
            Self::Sparse(counts) => counts.add(first, second),
        }
    }

    /// Removes a pair that is there.
    pub(super) fn remove(&mut self, first: &[u64], second: &[u64]) {
        match self {
            Self::Dense(counts) => counts.remove(first, second[0]),
            Self::Sparse(counts) => counts.remove(first, second),
        }
    }

    pub(super) fn clear(&mut self) {
        match self {
            Self::Dense(counts) => counts.clear(),
            Self::Sparse(counts) => counts.clear(),
        }
    }

    /// n(s) of the newest pair's first member.
    pub(super) fn newest_first(&self) -> u32 {
        match self {
            Self::Dense(counts) => counts.newest_first(),
            Self::Sparse(counts) => counts.newest_first(),
        }
    }

    /// Passes n(s, s') and n(s') of each successor s' of the newest pair's first member s, in any
    /// order.
    pub(super) fn for_each_successor(&self, visit: impl FnMut(u32, u32)) {
        match self {
            Self::Dense(counts) => counts.for_each_successor(visit),
            Self::Sparse(counts) => counts.for_each_successor(visit),
        }
    }

    /// K', the number of different second members.
    pub(super) fn n_seconds(&self) -> usize {
        match self {
            Self::Dense(counts) => counts.n_seconds(),
            Self::Sparse(counts) => counts.n_seconds(),
        }
    }

    /// The counts of first members, of second members, and of pairs. Zeros mean nothing.
    pub(super) fn all(&self) -> [&[u32]; 3] {
        match self {
            Self::Dense(counts) => counts.all(),
            Self::Sparse(counts) => counts.all(),
        }
    }
}

fn is_dense(settings: &WindowSettings, n_states: u64, n_words: usize) -> bool {
    let pairs = (0..=settings.past).fold(1_u64, |pairs, _| pairs.saturating_mul(n_states));
    pairs <= MOST_DENSE_PAIRS && n_words == 1
}
