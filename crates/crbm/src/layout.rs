//! Where each parameter is in the one flat vector: V, then c, then W, then b.
//!
//! Masked pairs have no place at all, so that they stay zero whatever an optimiser does, and cost
//! nothing in a score, a trace or an update. A full machine's V and W are dense, row-major.

use std::ops::Range;

use crate::{Error, Mask, rng};

/// The most units of one kind: the pairs of two kinds still fit into memory.
pub const MAX_UNITS: usize = 16_384;

/// The largest magnitude of a parameter: beyond any use, and far from where sums in `f32` overflow.
pub const MAX_PARAMETER: f64 = 1e9;

/// Sizes and connections of a machine, and the order of its parameters in a flat vector.
///
/// ```
/// use crbm::{Layout, Mask};
///
/// let full = Layout::full(30, 50, 24)?;
/// assert_eq!(full.n_parameters(), 50 * 30 + 50 + 50 * 24 + 24);
/// assert_eq!(full.hidden_biases(), 1500..1550);
///
/// // Six legs with four outputs each, and eight hidden units a leg.
/// let leg_of_output: Vec<usize> = (0..24).map(|output| output / 4).collect();
/// let legs = Layout::new(Mask::full(48, 30)?, Mask::blocks(8, &leg_of_output)?)?;
/// assert_eq!(legs.output_weights().len(), 48 * 4);
/// assert_eq!(legs.output_weight(7, 4), None, "the first leg's units don't see the second's");
/// # Ok::<(), crbm::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    inputs: Mask,
    outputs: Mask,
}

impl Layout {
    /// All hidden units connected with all inputs and outputs.
    ///
    /// # Errors
    /// If there's no output, or more than [`MAX_UNITS`] of a kind; if there's no memory for the masks.
    pub fn full(n_inputs: usize, n_hidden: usize, n_outputs: usize) -> Result<Self, Error> {
        Self::new(Mask::full(n_hidden, n_inputs)?, Mask::full(n_hidden, n_outputs)?)
    }

    /// With the pairs of hidden unit and input, and of hidden unit and output, that are connected.
    ///
    /// # Errors
    /// If the masks differ in the number of hidden units, or there's no output.
    pub fn new(inputs: Mask, outputs: Mask) -> Result<Self, Error> {
        let place = "Layout::new";
        if inputs.n_rows() != outputs.n_rows() {
            let expected = format!("{}, as with the inputs", inputs.n_rows());
            return Err(Error::argument(
                place,
                "rows of the outputs' mask",
                expected,
                outputs.n_rows(),
            ));
        }
        if outputs.n_columns() == 0 {
            return Err(Error::argument(place, "number of outputs", "at least 1", 0));
        }
        Ok(Self { inputs, outputs })
    }

    /// The number k of inputs, the bits of x.
    pub fn n_inputs(&self) -> usize {
        self.inputs.n_columns()
    }

    /// The number m of hidden units, the bits of h.
    pub fn n_hidden(&self) -> usize {
        self.outputs.n_rows()
    }

    /// The number n of outputs, the bits of y.
    pub fn n_outputs(&self) -> usize {
        self.outputs.n_columns()
    }

    /// Length of the flat vector.
    pub fn n_parameters(&self) -> usize {
        self.output_biases().end
    }

    /// Where the weights V are: the allowed pairs of `[n_hidden x n_inputs]`, row-major.
    pub fn input_weights(&self) -> Range<usize> {
        0..self.inputs.n_pairs()
    }

    /// Where the hidden units' biases c are, `[n_hidden]`.
    pub fn hidden_biases(&self) -> Range<usize> {
        let start = self.input_weights().end;
        start..start + self.n_hidden()
    }

    /// Where the weights W are: the allowed pairs of `[n_hidden x n_outputs]`, row-major.
    pub fn output_weights(&self) -> Range<usize> {
        let start = self.hidden_biases().end;
        start..start + self.outputs.n_pairs()
    }

    /// Where the outputs' biases b are, `[n_outputs]`.
    pub fn output_biases(&self) -> Range<usize> {
        let start = self.output_weights().end;
        start..start + self.n_outputs()
    }

    /// Which hidden units see which inputs: `[n_hidden x n_inputs]`.
    pub fn input_mask(&self) -> &Mask {
        &self.inputs
    }

    /// Which hidden units are connected with which outputs: `[n_hidden x n_outputs]`.
    pub fn output_mask(&self) -> &Mask {
        &self.outputs
    }

    /// Index of the weight V between a hidden unit and an input, `None` if they aren't connected.
    pub fn input_weight(&self, hidden: usize, input: usize) -> Option<usize> {
        self.inputs.position(hidden, input)
    }

    /// Index of the weight W between a hidden unit and an output, `None` if they aren't connected.
    pub fn output_weight(&self, hidden: usize, output: usize) -> Option<usize> {
        Some(self.output_weights().start + self.outputs.position(hidden, output)?)
    }

    /// The start of learning: `scale` times a draw from N(0,1) for each parameter, in their order.
    /// The draws depend on `seed` and `stream` only.
    ///
    /// # Errors
    /// If `scale` isn't finite, or so large that a parameter could pass [`MAX_PARAMETER`]; if there's
    /// no memory for the parameters.
    pub fn random_parameters(
        &self,
        scale: f64,
        seed: u64,
        stream: &str,
    ) -> Result<Vec<f64>, Error> {
        rng::random_parameters(self.n_parameters(), scale, seed, stream)
    }

    /// That parameters have the right number and are finite and in range.
    pub(crate) fn check(&self, place: &'static str, parameters: &[f64]) -> Result<(), Error> {
        crate::error::check_length(place, "parameters", self.n_parameters(), parameters.len())?;
        let bad = |value: &f64| value.is_nan() || value.abs() > MAX_PARAMETER;
        match parameters.iter().position(bad) {
            None => Ok(()),
            Some(index) => {
                let expected = format!("in -{MAX_PARAMETER:e}..={MAX_PARAMETER:e}");
                let argument = format!("parameter {index}, {}", self.name(index));
                Err(Error::argument(place, argument, expected, parameters[index]))
            }
        }
    }

    /// `W[3,1]`, for messages.
    fn name(&self, index: usize) -> String {
        let pair = |mask: &Mask, position| {
            (0..self.n_hidden())
                .find(|&row| mask.row_positions(row).contains(&position))
                .map(|row| (row, mask.row(row)[position - mask.row_positions(row).start]))
        };
        let named = |letter: char, found: Option<(usize, u32)>| match found {
            Some((row, column)) => format!("{letter}[{row},{column}]"),
            None => letter.to_string(),
        };
        if index < self.hidden_biases().start {
            named('V', pair(&self.inputs, index))
        } else if index < self.output_weights().start {
            format!("c[{}]", index - self.hidden_biases().start)
        } else if index < self.output_biases().start {
            named('W', pair(&self.outputs, index - self.output_weights().start))
        } else {
            format!("b[{}]", index - self.output_biases().start)
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_full_layout_is_dense_and_row_major() {
        let layout = Layout::full(3, 4, 2).unwrap();
        assert_eq!(layout.input_weights(), 0..12);
        assert_eq!(layout.hidden_biases(), 12..16);
        assert_eq!(layout.output_weights(), 16..24);
        assert_eq!(layout.output_biases(), 24..26);
        assert_eq!(layout.n_parameters(), 26);
        assert_eq!(layout.input_weight(2, 1), Some(7));
        assert_eq!(layout.output_weight(3, 1), Some(23));
    }

    #[test]
    fn a_masked_pair_has_no_parameter() {
        let mask = Mask::blocks(2, &[0, 0, 1]).unwrap();
        let layout = Layout::new(Mask::full(4, 1).unwrap(), mask).unwrap();
        assert_eq!(layout.output_weights(), 8..14);
        let row = |hidden| [0, 1, 2].map(|output| layout.output_weight(hidden, output));
        assert_eq!(row(1), [Some(10), Some(11), None]);
        assert_eq!(row(2), [None, None, Some(12)]);
    }

    #[test]
    fn messages_name_the_parameter() {
        let layout = Layout::full(3, 4, 2).unwrap();
        let mut parameters = vec![0.0; 26];
        for (index, name) in [(7, "V[2,1]"), (12, "c[0]"), (23, "W[3,1]"), (25, "b[1]")] {
            parameters[index] = f64::NAN;
            let message = layout.check("here", &parameters).unwrap_err().to_string();
            let expected =
                format!("here: parameter {index}, {name} must be in -1e9..=1e9, got NaN");
            assert_eq!(message, expected);
            parameters[index] = 0.0;
        }
    }

    #[test]
    fn random_parameters_depend_on_seed_and_stream() {
        let layout = Layout::full(3, 4, 2).unwrap();
        let draw = |seed, stream| layout.random_parameters(1.0, seed, stream).unwrap();
        assert_eq!(draw(1, "start"), draw(1, "start"));
        assert_ne!(draw(1, "start"), draw(2, "start"));
        assert_ne!(draw(1, "start"), draw(1, "other"));
        assert!(layout.random_parameters(f64::NAN, 1, "start").is_err());
        assert!(layout.random_parameters(-1.0, 1, "start").is_err());
    }
}
