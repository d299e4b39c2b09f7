//! A table that numbers keys of a fixed number of 64-bit words, and forgets them again.
//!
//! Numbers are slots: a new key gets the slot freed last, or the next one. Which slot a key has
//! depends on the calls before, and on nothing else; the hash only decides where to look.

use hashbrown::HashTable;

/// Keys of `width` words each, in numbered slots.
#[derive(Clone, Debug)]
pub(crate) struct Keys {
    width: usize,
    /// [n_slots x width], row-major: the key of each slot; stale where the slot is free.
    words: Vec<u64>,
    n_slots: usize,
    free: Vec<u32>,
    table: HashTable<u32>,
}

impl Keys {
    /// The most keys at a time.
    pub(crate) const MAX_KEYS: usize = u32::MAX as usize;

    pub(crate) fn new(width: usize) -> Self {
        Self { width, words: Vec::new(), n_slots: 0, free: Vec::new(), table: HashTable::new() }
    }

    /// A table that never allocates as long as it holds at most `capacity` keys. Twice the room:
    /// removed keys leave marks, and a table that is half empty clears them in place.
    pub(crate) fn with_capacity(width: usize, capacity: usize) -> Self {
        Self {
            width,
            words: Vec::with_capacity(width * capacity),
            n_slots: 0,
            free: Vec::with_capacity(capacity),
            table: HashTable::with_capacity(2 * capacity + 2),
        }
    }

    /// What [`Keys::with_capacity`] allocates.
    pub(crate) fn bytes(width: usize, capacity: usize) -> usize {
        // A power of two of buckets, of which 7/8 are used at most, each with a byte of its own.
        let buckets = (capacity.saturating_mul(2) + 2).saturating_mul(8) / 7;
        let table = buckets.checked_next_power_of_two().unwrap_or(usize::MAX);
        let slots = capacity.saturating_mul(width.saturating_mul(8).saturating_add(4));
        table.saturating_mul(5).saturating_add(slots)
    }

    pub(crate) fn width(&self) -> usize {
        self.width
    }

    pub(crate) fn len(&self) -> usize {
        self.table.len()
    }

    /// The key in a slot. The slot must be below the highest ever used.
    pub(crate) fn key(&self, slot: u32) -> &[u64] {
        key_at(&self.words, self.width, slot)
    }

    pub(crate) fn find(&self, key: &[u64]) -> Option<u32> {
        let (words, width) = (&self.words, self.width);
        self.table.find(hash(key), |&slot| key_at(words, width, slot) == key).copied()
    }

    /// Gives a slot to a key that isn't there. There must be room: see
    /// [`MAX_KEYS`](Self::MAX_KEYS).
    pub(crate) fn insert(&mut self, key: &[u64]) -> u32 {
        let slot = match self.free.pop() {
            Some(slot) => {
                let start = slot as usize * self.width;
                self.words[start..start + self.width].copy_from_slice(key);
                slot
            }
            None => {
                let slot = self.n_slots as u32;
                self.words.extend_from_slice(key);
                self.n_slots += 1;
                slot
            }
        };
        let (words, width) = (&self.words, self.width);
        self.table.insert_unique(hash(key), slot, |&slot| hash(key_at(words, width, slot)));
        slot
    }

    /// Frees a slot that is taken.
    pub(crate) fn remove(&mut self, slot: u32) {
        let hash = hash(self.key(slot));
        if let Ok(entry) = self.table.find_entry(hash, |&other| other == slot) {
            entry.remove();
            self.free.push(slot);
        }
    }

    pub(crate) fn clear(&mut self) {
        self.words.clear();
        self.n_slots = 0;
        self.free.clear();
        self.table.clear();
    }
}

fn key_at(words: &[u64], width: usize, slot: u32) -> &[u64] {
    let start = slot as usize * width;
    &words[start..start + width]
}

/// Multiplies by 2^64 over the golden ratio, which spreads neighbouring keys (D. Knuth, *The Art
/// of Computer Programming* 3, section 6.4), and folds the high half, where it mixes best, into
/// the low one.
fn hash(key: &[u64]) -> u64 {
    key.iter().fold(0, |hash: u64, &word| {
        let mixed = (hash.rotate_left(5) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ mixed >> 32
    })
}
