//! How often each of some keys is there.

use crate::keys::Keys;

/// Keys, and how often each is there.
#[derive(Clone, Debug)]
pub(super) struct Counted {
    pub(super) keys: Keys,
    /// [capacity]: 0 where the slot is free.
    pub(super) counts: Vec<u32>,
}

impl Counted {
    pub(super) fn new(width: usize, capacity: usize) -> Self {
        Self { keys: Keys::with_capacity(width, capacity), counts: vec![0; capacity] }
    }

    /// What [`Counted::new`] allocates.
    pub(super) fn bytes(width: usize, capacity: usize) -> usize {
        Keys::bytes(width, capacity).saturating_add(capacity.saturating_mul(4))
    }

    /// The key's slot, and whether it's a new one.
    pub(super) fn add(&mut self, key: &[u64]) -> (u32, bool) {
        let known = self.keys.find(key);
        let slot = known.unwrap_or_else(|| self.keys.insert(key));
        self.counts[slot as usize] += 1;
        (slot, known.is_none())
    }

    /// Takes one away, and says whether it was the last.
    pub(super) fn remove(&mut self, slot: u32) -> bool {
        self.counts[slot as usize] -= 1;
        let last = self.counts[slot as usize] == 0;
        if last {
            self.keys.remove(slot);
        }
        last
    }

    pub(super) fn clear(&mut self) {
        self.keys.clear();
        self.counts.fill(0);
    }
}
