//! The last readings, in a ring: the newest has age 0.

/// A ring of readings of some words each.
#[derive(Clone, Debug)]
pub(super) struct Readings {
    /// [capacity x n_words], row-major
    words: Vec<u64>,
    n_words: usize,
    capacity: usize,
    len: usize,
    /// Row of the reading that comes next.
    next: usize,
}

impl Readings {
    pub(super) fn new(n_words: usize, capacity: usize) -> Self {
        Self { words: vec![0; n_words * capacity], n_words, capacity, len: 0, next: 0 }
    }

    /// What [`Readings::new`] allocates.
    pub(super) fn bytes(n_words: usize, capacity: usize) -> usize {
        n_words.saturating_mul(capacity).saturating_mul(8)
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn clear(&mut self) {
        (self.len, self.next) = (0, 0);
    }

    /// The reading of an age below `len`.
    pub(super) fn row(&self, age: usize) -> &[u64] {
        let back = age + 1;
        let row =
            if back <= self.next { self.next - back } else { self.next + self.capacity - back };
        &self.words[row * self.n_words..(row + 1) * self.n_words]
    }

    /// Puts a reading in the place of the oldest.
    pub(super) fn push(&mut self, reading: &[u64]) {
        self.words[self.next * self.n_words..][..self.n_words].copy_from_slice(reading);
        self.next = if self.next + 1 == self.capacity { 0 } else { self.next + 1 };
        self.len = (self.len + 1).min(self.capacity);
    }
}
