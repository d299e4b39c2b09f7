//! Parameters in the forms that the sampler and the score read, packed once per change.
//!
//! A unit's activation is a sum of weights over the units that are on. The sampler takes three
//! units at a time (a group): their bits make an index from 0 to 7 into the sums of all subsets of
//! their weights. That's a third of the additions, and no multiplication; the sums are rounded to
//! `f32` once. (The method of the Four Russians: Arlazarov, Dinic, Kronrod, Faradzev, 1970.)

use std::{f64::consts::LOG2_E, ops::Range};

use crate::{Mask, simd::Sums};

/// Units whose bits make one index.
pub(crate) const GROUP: usize = 3;

/// What the sampler adds up for each unit of one layer, given the bits of the other.
#[derive(Clone, Debug)]
pub(crate) struct Tables {
    /// `[n_units + 1]`: a unit's terms are at `starts[unit]..starts[unit + 1]`.
    starts: Vec<usize>,
    /// Of each term: which group of the other layer.
    groups: Vec<u32>,
    /// Of each term: its three weights' places, as far as they exist.
    places: Vec<[Option<usize>; GROUP]>,
    sums: Vec<Sums>,
}

impl Tables {
    /// `incoming[unit]`: the other layer's units that it sees, increasing, and the weights' places
    /// among the weights. Groups of which it sees nothing cost nothing.
    pub(crate) fn new(incoming: &[Vec<(usize, usize)>]) -> Self {
        let (mut starts, mut groups, mut places) = (vec![0], Vec::new(), Vec::new());
        for unit in incoming {
            let first = groups.len();
            for &(other, place) in unit {
                let group = (other / GROUP) as u32;
                if groups[first..].last() != Some(&group) {
                    groups.push(group);
                    places.push([None; GROUP]);
                }
                let last = places.len() - 1;
                places[last][other % GROUP] = Some(place);
            }
            starts.push(groups.len());
        }
        let sums = vec![Sums([0.0; 8]); groups.len()];
        Self { starts, groups, places, sums }
    }

    /// What is allocated to make the tables of both layers, [`incoming`] among it.
    pub(crate) fn bytes(mask: &Mask) -> usize {
        let mut groups_of_outputs = vec![usize::MAX; mask.n_columns()];
        let mut last = (0, usize::MAX);
        let mut n_terms = 0;
        for (hidden, output) in mask.pairs() {
            n_terms += usize::from(last != (hidden, output / GROUP));
            last = (hidden, output / GROUP);
            n_terms += usize::from(groups_of_outputs[output] != hidden / GROUP);
            groups_of_outputs[output] = hidden / GROUP;
        }
        let term = size_of::<u32>() + size_of::<[Option<usize>; GROUP]>() + size_of::<Sums>();
        let pair = size_of::<(usize, usize)>();
        // Lists that grow have up to twice the room that they need.
        2 * (n_terms * term + 2 * mask.n_pairs() * pair)
    }

    /// As [`negative_bits`] of the weights.
    pub(crate) fn pack(&mut self, weights: &[f64]) {
        for (sums, places) in self.sums.iter_mut().zip(&self.places) {
            let weight = places.map(|place| place.map_or(0.0, |place| weights[place]));
            sums.0 = std::array::from_fn(|subset| {
                let on = |bit: usize| if subset >> bit & 1 == 1 { weight[bit] } else { 0.0 };
                negative_bits(on(0) + on(1) + on(2))
            });
        }
    }

    /// The groups of a unit's terms, and their sums.
    #[inline(always)]
    pub(crate) fn terms(&self, unit: usize) -> (&[u32], &[Sums]) {
        let terms = self.starts[unit]..self.starts[unit + 1];
        (&self.groups[terms.clone()], &self.sums[terms])
    }
}

/// An activation in the unit in which the sampler adds: -log2 of the odds.
pub(crate) fn negative_bits(activation: f64) -> f32 {
    (-LOG2_E * activation) as f32
}

/// V or W by columns, dense, in `f64`: `[n_units x n_hidden]`.
#[derive(Clone, Debug)]
pub(crate) struct Columns {
    n_hidden: usize,
    /// `[n_units]`: the hidden units from the first to the last that see the input or output.
    ranges: Vec<Range<usize>>,
    /// Zero where nothing is connected.
    values: Vec<f64>,
}

impl Columns {
    pub(crate) fn new(mask: &Mask) -> Self {
        let n_hidden = mask.n_rows();
        let mut ranges = vec![0..0; mask.n_columns()];
        for (hidden, unit) in mask.pairs() {
            let range = &mut ranges[unit];
            let start = if range.end == 0 { hidden } else { range.start };
            *range = start..hidden + 1;
        }
        Self { n_hidden, ranges, values: vec![0.0; n_hidden * mask.n_columns()] }
    }

    /// What [`Columns::new`] allocates.
    pub(crate) fn bytes(mask: &Mask) -> usize {
        let column = size_of::<Range<usize>>() + size_of::<f64>() * mask.n_rows();
        column * mask.n_columns()
    }

    pub(crate) fn pack(&mut self, mask: &Mask, weights: &[f64]) {
        for ((hidden, unit), weight) in mask.pairs().zip(weights) {
            self.values[unit * self.n_hidden + hidden] = *weight;
        }
    }

    /// Which hidden units a column is about.
    #[inline(always)]
    pub(crate) fn range(&self, unit: usize) -> Range<usize> {
        self.ranges[unit].clone()
    }

    /// Adds a column to the hidden units' activations, `[n_hidden]`.
    #[inline(always)]
    pub(crate) fn add_to(&self, unit: usize, activations: &mut [f64]) {
        let range = self.range(unit);
        let column = &self.values[unit * self.n_hidden..][range.clone()];
        for (activation, weight) in activations[range].iter_mut().zip(column) {
            *activation += weight;
        }
    }
}

impl Columns {
    /// A column's sum with hidden units in place of their activations, `[n_hidden]`: in four parts, which
    /// fill a register, whatever the processor.
    #[inline(always)]
    pub(crate) fn weighted(&self, unit: usize, hidden: &[f64]) -> f64 {
        let range = self.range(unit);
        let column = &self.values[unit * self.n_hidden..][range.clone()];
        let (weights, last_weights) = column.as_chunks::<4>();
        let (units, last_units) = hidden[range].as_chunks::<4>();
        let mut sums = [0.0; 4];
        for (weights, units) in weights.iter().zip(units) {
            for (sum, (weight, unit)) in sums.iter_mut().zip(weights.iter().zip(units)) {
                *sum += weight * unit;
            }
        }
        let last = last_weights.iter().zip(last_units).map(|(weight, unit)| weight * unit);
        sums.iter().sum::<f64>() + last.sum::<f64>()
    }
}

/// For [`Tables::new`]: what each hidden unit sees of the outputs, and each output of the hidden
/// units, with the weights' places.
pub(crate) fn incoming(mask: &Mask) -> [Vec<Vec<(usize, usize)>>; 2] {
    let mut of_hidden = vec![Vec::new(); mask.n_rows()];
    let mut of_outputs = vec![Vec::new(); mask.n_columns()];
    for (place, (hidden, output)) in mask.pairs().enumerate() {
        of_hidden[hidden].push((output, place));
        of_outputs[output].push((hidden, place));
    }
    [of_hidden, of_outputs]
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_term_has_the_sums_of_all_subsets() {
        let mask = Mask::from_fn(1, 7, |_, output| output != 4).unwrap();
        let [of_hidden, _] = incoming(&mask);
        let mut tables = Tables::new(&of_hidden);
        tables.pack(&[1.0, 2.0, 4.0, 8.0, 16.0, 32.0]);
        let (groups, sums) = tables.terms(0);
        assert_eq!(groups, [0, 1, 2]);
        let weights = |term: usize| sums[term].0.map(|sum| (-sum as f64 / LOG2_E).round());
        assert_eq!(weights(0), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        assert_eq!(weights(1), [0.0, 8.0, 0.0, 8.0, 16.0, 24.0, 16.0, 24.0]);
        assert_eq!(weights(2), [0.0, 32.0, 0.0, 32.0, 0.0, 32.0, 0.0, 32.0]);
    }

    #[test]
    fn masked_groups_have_no_term() {
        let [of_hidden, of_outputs] = incoming(&Mask::blocks(3, &[0, 0, 0, 1, 1, 1]).unwrap());
        assert_eq!(Tables::new(&of_hidden).sums.len(), 6);
        assert_eq!(Tables::new(&of_outputs).sums.len(), 6);
    }
}
