//! Everything exactly, by adding up all outputs: for small machines, and as the oracle of the rest.
//!
//! The hidden units can be summed out one by one:
//! ```text
//! sum_h exp(h'V x + h'W y + c'h + b'y) = exp(b'y) prod_j (1 + exp(a_j)),  a = c + V x + W y
//! ```
//! so that p(y|x) takes a sum over 2^n outputs, whatever m is. In `f64`, with log-sum-exp; textbook
//! loops, which share nothing with the sampler but the layout.

use crate::{Error, Layout, error::check_length};

/// The most outputs that are enumerated.
pub const MAX_ENUMERATED: usize = 20;

/// A machine with few outputs, for exact answers.
///
/// Output vectors are numbered in the order of their bits: y_i is bit i of the number.
#[derive(Clone, Debug)]
pub struct Exact<'a> {
    layout: &'a Layout,
    parameters: &'a [f64],
}

impl<'a> Exact<'a> {
    /// # Errors
    /// If there are more than [`MAX_ENUMERATED`] outputs, or the parameters aren't right for the
    /// layout, as in [`Policy::set_parameters`](crate::Policy::set_parameters).
    pub fn new(layout: &'a Layout, parameters: &'a [f64]) -> Result<Self, Error> {
        let place = "Exact::new";
        if layout.n_outputs() > MAX_ENUMERATED {
            let expected = format!("at most {MAX_ENUMERATED}");
            return Err(Error::argument(place, "n_outputs", expected, layout.n_outputs()));
        }
        layout.check(place, parameters)?;
        Ok(Self { layout, parameters })
    }

    /// log Z(x).
    ///
    /// # Errors
    /// If the length of `x` is wrong.
    pub fn log_partition(&self, x: &[bool]) -> Result<f64, Error> {
        check_length("Exact::log_partition", "x", self.layout.n_inputs(), x.len())?;
        Ok(log_sum_exp(&self.log_weights(x)))
    }

    /// log p(y|x) for all y: `[2^n_outputs]`.
    ///
    /// # Errors
    /// If the length of `x` is wrong.
    pub fn log_probabilities(&self, x: &[bool]) -> Result<Vec<f64>, Error> {
        check_length("Exact::log_probabilities", "x", self.layout.n_inputs(), x.len())?;
        let mut logs = self.log_weights(x);
        let log_partition = log_sum_exp(&logs);
        for log in &mut logs {
            *log -= log_partition;
        }
        Ok(logs)
    }

    /// Mean of log p(y|x) over pairs (x, y), in nats.
    ///
    /// # Errors
    /// If there's no pair, or a length is wrong.
    pub fn log_likelihood(&self, pairs: &[(Vec<bool>, Vec<bool>)]) -> Result<f64, Error> {
        let place = "Exact::log_likelihood";
        if pairs.is_empty() {
            return Err(Error::argument(place, "number of pairs", "at least 1", 0));
        }
        let mut sum = 0.0;
        for (x, y) in pairs {
            self.check_pair(place, x, y)?;
            sum += self.log_weight(x, y) - log_sum_exp(&self.log_weights(x));
        }
        Ok(sum / pairs.len() as f64)
    }

    /// The gradient of log p(y|x) by the parameters, in the layout's order.
    ///
    /// # Errors
    /// If a length is wrong.
    pub fn score(&self, x: &[bool], y: &[bool]) -> Result<Vec<f64>, Error> {
        self.check_pair("Exact::score", x, y)?;
        let mut score = vec![0.0; self.layout.n_parameters()];
        self.add_expectations(x, y, 1.0, &mut score);
        for (number, log) in self.log_probabilities(x)?.into_iter().enumerate() {
            self.add_expectations(x, &self.output(number), -libm::exp(log), &mut score);
        }
        Ok(score)
    }

    /// P(h_j = 1 | x, y), `[n_hidden]`.
    ///
    /// # Errors
    /// If a length is wrong.
    pub fn hidden_probabilities(&self, x: &[bool], y: &[bool]) -> Result<Vec<f64>, Error> {
        self.check_pair("Exact::hidden_probabilities", x, y)?;
        Ok(self.activations(x, y).into_iter().map(sigmoid).collect())
    }

    /// P(y_i = 1 | h), `[n_outputs]`; x has no part in it.
    ///
    /// # Errors
    /// If the length of `h` is wrong.
    pub fn output_probabilities(&self, h: &[bool]) -> Result<Vec<f64>, Error> {
        let layout = self.layout;
        check_length("Exact::output_probabilities", "h", layout.n_hidden(), h.len())?;
        let mut activations = self.parameters[layout.output_biases()].to_vec();
        let weights = &self.parameters[layout.output_weights()];
        for ((j, i), weight) in layout.output_mask().pairs().zip(weights) {
            if h[j] {
                activations[i] += weight;
            }
        }
        Ok(activations.into_iter().map(sigmoid).collect())
    }

    /// The output with a number: y_i is its bit i. Bits beyond the outputs don't count.
    pub fn output(&self, number: usize) -> Vec<bool> {
        (0..self.layout.n_outputs()).map(|i| number >> i & 1 == 1).collect()
    }

    /// An output's number, from its bits.
    ///
    /// # Errors
    /// If its length is wrong.
    pub fn number(&self, y: &[bool]) -> Result<usize, Error> {
        check_length("Exact::number", "y", self.layout.n_outputs(), y.len())?;
        Ok(y.iter().enumerate().map(|(i, on)| usize::from(*on) << i).sum())
    }

    fn check_pair(&self, place: &'static str, x: &[bool], y: &[bool]) -> Result<(), Error> {
        check_length(place, "x", self.layout.n_inputs(), x.len())?;
        check_length(place, "y", self.layout.n_outputs(), y.len())
    }

    /// c + V x + W y.
    fn activations(&self, x: &[bool], y: &[bool]) -> Vec<f64> {
        let layout = self.layout;
        let mut activations = self.parameters[layout.hidden_biases()].to_vec();
        let sides = [
            (layout.input_mask(), layout.input_weights(), x),
            (layout.output_mask(), layout.output_weights(), y),
        ];
        for (mask, places, bits) in sides {
            for ((j, unit), weight) in mask.pairs().zip(&self.parameters[places]) {
                if bits[unit] {
                    activations[j] += weight;
                }
            }
        }
        activations
    }

    /// log of exp(b'y) prod_j (1 + exp(a_j)).
    fn log_weight(&self, x: &[bool], y: &[bool]) -> f64 {
        let biases = &self.parameters[self.layout.output_biases()];
        let linear: f64 = y.iter().zip(biases).filter(|(on, _)| **on).map(|(_, bias)| bias).sum();
        linear + self.activations(x, y).into_iter().map(log_1_plus_exp).sum::<f64>()
    }

    fn log_weights(&self, x: &[bool]) -> Vec<f64> {
        let numbers = 0..1 << self.layout.n_outputs();
        numbers.map(|number| self.log_weight(x, &self.output(number))).collect()
    }

    /// Adds `factor` times E[the parameters' factors in the exponent | x, y].
    fn add_expectations(&self, x: &[bool], y: &[bool], factor: f64, to: &mut [f64]) {
        let layout = self.layout;
        let hidden: Vec<f64> =
            self.activations(x, y).into_iter().map(|a| factor * sigmoid(a)).collect();
        let add_pairs = |to: &mut [f64], mask: &crate::Mask, bits: &[bool]| {
            for (to, (j, unit)) in to.iter_mut().zip(mask.pairs()) {
                if bits[unit] {
                    *to += hidden[j];
                }
            }
        };
        add_pairs(&mut to[layout.input_weights()], layout.input_mask(), x);
        add_pairs(&mut to[layout.output_weights()], layout.output_mask(), y);
        for (to, hidden) in to[layout.hidden_biases()].iter_mut().zip(&hidden) {
            *to += hidden;
        }
        for (to, on) in to[layout.output_biases()].iter_mut().zip(y) {
            *to += if *on { factor } else { 0.0 };
        }
    }
}

fn sigmoid(a: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-a))
}

fn log_1_plus_exp(a: f64) -> f64 {
    a.max(0.0) + libm::log1p(libm::exp(-a.abs()))
}

fn log_sum_exp(logs: &[f64]) -> f64 {
    let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    largest + libm::log(logs.iter().map(|log| libm::exp(log - largest)).sum())
}
