//! Which hidden units are connected with which inputs or outputs: a set of pairs, kept by rows
//! (compressed sparse rows).

use std::ops::Range;

use crate::{Error, layout::MAX_UNITS};

/// The connected pairs of `[n_hidden x n_units]`, where the units are inputs or outputs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    n_columns: usize,
    /// `[n_rows + 1]`: a row's pairs are at `starts[row]..starts[row + 1]`.
    starts: Vec<usize>,
    /// Of each pair, increasing within a row.
    columns: Vec<u32>,
}

impl Mask {
    /// All pairs.
    ///
    /// # Errors
    /// As [`from_fn`](Self::from_fn).
    pub fn full(n_hidden: usize, n_units: usize) -> Result<Self, Error> {
        Self::from_fn(n_hidden, n_units, |_, _| true)
    }

    /// The pairs of hidden unit and input or output for which `connected` says so.
    ///
    /// # Errors
    /// Beyond [`MAX_UNITS`] rows or columns; if there's no memory for the pairs.
    pub fn from_fn(
        n_hidden: usize,
        n_units: usize,
        mut connected: impl FnMut(usize, usize) -> bool,
    ) -> Result<Self, Error> {
        for (argument, count) in [("n_hidden", n_hidden), ("n_units", n_units)] {
            if count > MAX_UNITS {
                let expected = format!("at most {MAX_UNITS}");
                return Err(Error::argument("Mask::from_fn", argument, expected, count));
            }
        }
        let mut mask = Self { n_columns: n_units, starts: vec![0], columns: Vec::new() };
        for row in 0..n_hidden {
            if mask.columns.try_reserve(n_units).is_err() {
                let bytes = size_of::<u32>() * n_hidden * n_units;
                return Err(Error::Memory { place: "Mask::from_fn", bytes });
            }
            let allowed = (0..n_units).filter(|&column| connected(row, column));
            mask.columns.extend(allowed.map(|column| column as u32));
            mask.starts.push(mask.columns.len());
        }
        Ok(mask)
    }

    /// One block of hidden units for each group of inputs or outputs, an actuator's bits or a leg's
    /// actuators: the first `hidden_per_block` hidden units see the units of group 0, the next
    /// those of group 1, and so on. `group_of_unit` tells each unit's group.
    ///
    /// # Errors
    /// As [`from_fn`](Self::from_fn).
    pub fn blocks(hidden_per_block: usize, group_of_unit: &[usize]) -> Result<Self, Error> {
        let n_groups = group_of_unit.iter().max().map_or(0, |last| last.saturating_add(1));
        let n_hidden = n_groups.saturating_mul(hidden_per_block);
        Self::from_fn(n_hidden, group_of_unit.len(), |hidden, unit| {
            hidden / hidden_per_block == group_of_unit[unit]
        })
    }

    /// The number of hidden units.
    pub fn n_rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// The number of inputs or outputs.
    pub fn n_columns(&self) -> usize {
        self.n_columns
    }

    /// The number of connected pairs.
    pub fn n_pairs(&self) -> usize {
        self.columns.len()
    }

    /// Whether all pairs are connected.
    pub fn is_full(&self) -> bool {
        self.n_pairs() == self.n_rows() * self.n_columns
    }

    /// What a hidden unit is connected with, increasing; nothing if there's no such unit.
    pub fn row(&self, hidden: usize) -> &[u32] {
        &self.columns[self.row_positions(hidden)]
    }

    /// Where a row's pairs are among all pairs.
    pub(crate) fn row_positions(&self, hidden: usize) -> Range<usize> {
        match (self.starts.get(hidden), self.starts.get(hidden + 1)) {
            (Some(&start), Some(&end)) => start..end,
            _ => 0..0,
        }
    }

    /// Where a pair is among all pairs.
    pub(crate) fn position(&self, hidden: usize, unit: usize) -> Option<usize> {
        let row = self.row(hidden);
        let place = row.binary_search_by(|&column| (column as usize).cmp(&unit)).ok()?;
        Some(self.row_positions(hidden).start + place)
    }

    /// All pairs (hidden unit, input or output), by rows.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.n_rows())
            .flat_map(|row| self.row(row).iter().map(move |&column| (row, column as usize)))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn blocks_may_be_of_scattered_units() {
        let mask = Mask::blocks(2, &[1, 0, 1]).unwrap();
        let rows: Vec<&[u32]> = (0..mask.n_rows()).map(|row| mask.row(row)).collect();
        assert_eq!(rows, [&[1][..], &[1], &[0, 2], &[0, 2]]);
        assert!(!mask.is_full());
        assert_eq!(mask.pairs().last(), Some((3, 2)));
    }

    #[test]
    fn masks_may_be_empty() {
        let mask = Mask::blocks(3, &[]).unwrap();
        assert_eq!((mask.n_rows(), mask.n_columns(), mask.n_pairs()), (0, 0, 0));
        assert!(Mask::full(0, 5).unwrap().is_full());
        assert_eq!(Mask::blocks(0, &[0, 1]).unwrap().n_rows(), 0);
    }

    #[test]
    fn too_many_units_are_refused() {
        let message = Mask::full(70_000, 1).unwrap_err().to_string();
        assert_eq!(message, "Mask::from_fn: n_hidden must be at most 16384, got 70000");
        assert!(Mask::blocks(usize::MAX, &[usize::MAX]).is_err());
    }
}
