//! A column of data as ranks: each symbol is replaced by its place among the symbols that occur.
//!
//! Ranks are below the number of rows, so two of them always fit one 64-bit word, side by side:
//! columns are joined without any radix, and without overflow, however many there are.

use crate::{
    error::{Error, refused},
    logs,
};

/// Ranks of the symbols in a column, and how often each occurs.
#[derive(Clone, Debug)]
pub(crate) struct Column {
    /// [n_rows], each below the number of states.
    ranks: Vec<u32>,
    /// [n_states], none of them 0.
    counts: Vec<u32>,
}

impl Column {
    /// The column named `name` in messages. It must have 1 to 2^32 - 1 rows.
    pub(crate) fn new<T: Copy + Ord>(
        call: &'static str,
        name: &str,
        symbols: &[T],
    ) -> Result<Self, Error> {
        let n = symbols.len();
        if n == 0 || u32::try_from(n).is_err() {
            return Err(refused(call, format!("the length of {name}"), "1 to 2^32 - 1", n));
        }
        Ok(Self::ranked(symbols))
    }

    /// A column of equal symbols.
    pub(crate) fn constant(n_rows: usize) -> Self {
        Self { ranks: vec![0; n_rows], counts: vec![n_rows as u32] }
    }

    /// Pairs of this column's and the other's symbols, row by row; as many rows as the shorter.
    pub(crate) fn join(&self, other: &Self) -> Self {
        Self::of_pairs(&self.ranks, &other.ranks)
    }

    /// As [`join`](Self::join), of bare ranks.
    pub(crate) fn of_pairs(a: &[u32], b: &[u32]) -> Self {
        let pairs: Vec<u64> =
            a.iter().zip(b).map(|(&a, &b)| u64::from(a) << 32 | u64::from(b)).collect();
        Self::ranked(&pairs)
    }

    pub(crate) fn ranks(&self) -> &[u32] {
        &self.ranks
    }

    pub(crate) fn n_rows(&self) -> usize {
        self.ranks.len()
    }

    pub(crate) fn n_states(&self) -> usize {
        self.counts.len()
    }

    /// sum_i c_i ln c_i over the counts, in units of 2^-53.
    pub(crate) fn sum_n_ln_n(&self) -> i128 {
        self.counts.iter().map(|&count| logs::n_ln_n(u64::from(count))).sum()
    }

    fn ranked<T: Copy + Ord>(symbols: &[T]) -> Self {
        let mut states = symbols.to_vec();
        states.sort_unstable();
        states.dedup();
        let mut counts = vec![0; states.len()];
        let ranks = symbols
            .iter()
            .map(|symbol| {
                // Every symbol is among the states; the place is the same in either case.
                let (Ok(rank) | Err(rank)) = states.binary_search(symbol);
                counts[rank] += 1;
                rank as u32
            })
            .collect();
        Self { ranks, counts }
    }
}
