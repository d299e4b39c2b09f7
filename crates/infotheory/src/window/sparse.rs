//! Counts of the states and pairs that occur, in hash tables.
//!
//! Each first member heads a doubly linked list of its pairs, so that the successors of one state
//! are found without looking at any others.

use super::{WindowSettings, counted::Counted};

/// Counts of the pairs of a variable with any number of states.
#[derive(Clone, Debug)]
pub(super) struct Sparse {
    firsts: Counted,
    seconds: Counted,
    /// Keys are the slots of the first and the second member, one in each half.
    pairs: Counted,
    /// [T']: the first pair in the list of each first member.
    heads: Vec<u32>,
    /// [T']: the neighbours of each pair in its list.
    after: Vec<u32>,
    before: Vec<u32>,
    /// Slot of the newest pair's first member.
    newest: u32,
}

/// No pair.
const NONE: u32 = u32::MAX;

impl Sparse {
    /// For states of `n_words` words.
    pub(super) fn new(settings: &WindowSettings, n_words: usize) -> Self {
        let capacity = settings.pairs;
        Self {
            firsts: Counted::new(settings.past * n_words, capacity),
            seconds: Counted::new(n_words, capacity),
            pairs: Counted::new(1, capacity),
            heads: vec![NONE; capacity],
            after: vec![NONE; capacity],
            before: vec![NONE; capacity],
            newest: 0,
        }
    }

    /// What [`Sparse::new`] allocates.
    pub(super) fn bytes(settings: &WindowSettings, n_words: usize) -> usize {
        let capacity = settings.pairs;
        let lists = capacity.saturating_mul(3 * 4);
        [settings.past.saturating_mul(n_words), n_words, 1]
            .iter()
            .map(|&width| Counted::bytes(width, capacity))
            .fold(lists, usize::saturating_add)
    }

    pub(super) fn add(&mut self, first: &[u64], second: &[u64]) {
        let (first, is_new) = self.firsts.add(first);
        if is_new {
            self.heads[first as usize] = NONE;
        }
        let (second, _) = self.seconds.add(second);
        let (pair, is_new) = self.pairs.add(&[pair_key(first, second)]);
        if is_new {
            self.link(first, pair);
        }
        self.newest = first;
    }

    /// Does nothing if the pair isn't there.
    pub(super) fn remove(&mut self, first: &[u64], second: &[u64]) {
        let (Some(first), Some(second)) =
            (self.firsts.keys.find(first), self.seconds.keys.find(second))
        else {
            return;
        };
        let Some(pair) = self.pairs.keys.find(&[pair_key(first, second)]) else {
            return;
        };
        if self.pairs.remove(pair) {
            self.unlink(first, pair);
        }
        self.firsts.remove(first);
        self.seconds.remove(second);
    }

    pub(super) fn clear(&mut self) {
        self.firsts.clear();
        self.seconds.clear();
        self.pairs.clear();
    }

    pub(super) fn newest_first(&self) -> u32 {
        self.firsts.counts[self.newest as usize]
    }

    pub(super) fn for_each_successor(&self, mut visit: impl FnMut(u32, u32)) {
        let mut pair = self.heads[self.newest as usize];
        while pair != NONE {
            let second = self.pairs.keys.key(pair)[0] as u32;
            visit(self.pairs.counts[pair as usize], self.seconds.counts[second as usize]);
            pair = self.after[pair as usize];
        }
    }

    pub(super) fn n_seconds(&self) -> usize {
        self.seconds.keys.len()
    }

    pub(super) fn all(&self) -> [&[u32]; 3] {
        [&self.firsts.counts, &self.seconds.counts, &self.pairs.counts]
    }

    fn link(&mut self, first: u32, pair: u32) {
        let head = self.heads[first as usize];
        self.after[pair as usize] = head;
        self.before[pair as usize] = NONE;
        if head != NONE {
            self.before[head as usize] = pair;
        }
        self.heads[first as usize] = pair;
    }

    fn unlink(&mut self, first: u32, pair: u32) {
        let (before, after) = (self.before[pair as usize], self.after[pair as usize]);
        if after != NONE {
            self.before[after as usize] = before;
        }
        if before != NONE {
            self.after[before as usize] = after;
        } else {
            self.heads[first as usize] = after;
        }
    }
}

fn pair_key(first: u32, second: u32) -> u64 {
    u64::from(first) << 32 | u64::from(second)
}
