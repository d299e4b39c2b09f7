//! Counts in tables with a place for every state.

/// Counts of the pairs of a variable with K states.
#[derive(Clone, Debug)]
pub(super) struct Dense {
    /// K
    n_states: usize,
    /// [K^past]: n(s)
    firsts: Vec<u32>,
    /// [K]: n(s')
    seconds: Vec<u32>,
    /// [K^past x K], row-major: n(s, s')
    pairs: Vec<u32>,
    n_seconds: usize,
    /// s of the newest pair.
    newest: usize,
}

impl Dense {
    pub(super) fn new(n_states: usize, past: usize) -> Self {
        let n_firsts = (0..past).fold(1, |product, _| product * n_states);
        Self {
            n_states,
            firsts: vec![0; n_firsts],
            seconds: vec![0; n_states],
            pairs: vec![0; n_firsts * n_states],
            n_seconds: 0,
            newest: 0,
        }
    }

    pub(super) fn add(&mut self, first: &[u64], second: u64) {
        let (first, second) = (self.index(first), second as usize);
        self.n_seconds += usize::from(self.seconds[second] == 0);
        self.firsts[first] += 1;
        self.seconds[second] += 1;
        self.pairs[first * self.n_states + second] += 1;
        self.newest = first;
    }

    pub(super) fn remove(&mut self, first: &[u64], second: u64) {
        let (first, second) = (self.index(first), second as usize);
        self.firsts[first] -= 1;
        self.seconds[second] -= 1;
        self.pairs[first * self.n_states + second] -= 1;
        self.n_seconds -= usize::from(self.seconds[second] == 0);
    }

    pub(super) fn clear(&mut self) {
        self.firsts.fill(0);
        self.seconds.fill(0);
        self.pairs.fill(0);
        self.n_seconds = 0;
    }

    pub(super) fn newest_first(&self) -> u32 {
        self.firsts[self.newest]
    }

    pub(super) fn for_each_successor(&self, mut visit: impl FnMut(u32, u32)) {
        let row = &self.pairs[self.newest * self.n_states..][..self.n_states];
        for (&pair, &second) in row.iter().zip(&self.seconds) {
            if pair > 0 {
                visit(pair, second);
            }
        }
    }

    pub(super) fn n_seconds(&self) -> usize {
        self.n_seconds
    }

    pub(super) fn all(&self) -> [&[u32]; 3] {
        [&self.firsts, &self.seconds, &self.pairs]
    }

    /// The row of a first member: its readings as digits to the base K.
    fn index(&self, first: &[u64]) -> usize {
        first.iter().fold(0, |index, &state| index * self.n_states + state as usize)
    }
}
