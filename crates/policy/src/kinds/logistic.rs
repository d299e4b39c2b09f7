//! Each output bit a logistic function of the inputs, and the bits independent of each other: the
//! plain policy, with an exact score.
//!
//! ```text
//! p(y_i = 1 | x) = p_i = 1 / (1 + exp(-b_i - sum_k W_ik x_k))
//! d log p(y|x) / d b_i = y_i - p_i          d log p(y|x) / d W_ik = (y_i - p_i) x_k
//! ```
//!
//! In `f64`, with `libm`'s exponential, and sums in the order of the inputs: the same bits anywhere. A
//! bit is on if u < p_i, with u a multiple of 2^-53 in [0, 1). The parameters are W,
//! `[n_outputs x n_inputs]`, row-major, then b, `[n_outputs]`.

use config::Section;
use serde::Serialize;

use super::Build;
use crate::{
    Error, Link, Policy, Structure,
    error::{check_length, zeros},
    policy::check_act,
    tensors::{Tensors, expect_same_layout},
    uniform::Uniform,
};

/// It has no settings of its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LogisticSettings {}

impl LogisticSettings {
    pub(super) fn read(_: &mut Section<'_>) -> Option<Self> {
        Some(Self {})
    }
}

impl Build for LogisticSettings {
    fn build(&self, structure: &Structure) -> Result<Box<dyn Policy>, Error> {
        Ok(Box::new(Logistic::new(structure)?))
    }
}

/// Independent logistic outputs.
#[derive(Clone, Debug)]
pub struct Logistic {
    n_inputs: usize,
    n_outputs: usize,
    /// W, then b.
    parameters: Vec<f64>,
    tensors: Tensors,
    uniform: Uniform,
    /// y_i - p_i of the last act, `[n_outputs]`.
    surprise: Vec<f64>,
}

impl Logistic {
    /// With all parameters 0.
    ///
    /// # Errors
    /// A robot without sensors or actuators.
    pub fn new(structure: &Structure) -> Result<Self, Error> {
        structure.check()?;
        let (n_inputs, n_outputs) = (structure.n_inputs(), structure.n_outputs());
        let shapes = vec![("W".into(), vec![n_outputs, n_inputs]), ("b".into(), vec![n_outputs])];
        let tensors = Tensors::new("logistic", shapes);
        let (parameters, surprise) = (zeros(tensors.n_parameters())?, vec![0.0; n_outputs]);
        let uniform = Uniform::new(0, "policy");
        Ok(Self { n_inputs, n_outputs, parameters, tensors, uniform, surprise })
    }

    /// Draws y, and keeps y - p.
    fn draw(&mut self, inputs: &[bool], outputs: &mut [bool]) {
        let (weights, biases) = self.parameters.split_at(self.n_outputs * self.n_inputs);
        let rows = weights.chunks(self.n_inputs).zip(biases);
        for ((output, surprise), (row, bias)) in
            outputs.iter_mut().zip(&mut self.surprise).zip(rows)
        {
            let p = probability(*bias, row, inputs);
            *output = self.uniform.draw() < p;
            *surprise = f64::from(u8::from(*output)) - p;
        }
    }
}

/// p(y_i = 1 | x), given b_i and `W_i`, `[n_inputs]`.
fn probability(bias: f64, weights: &[f64], inputs: &[bool]) -> f64 {
    let seen = weights.iter().zip(inputs).map(|(weight, on)| if *on { *weight } else { 0.0 });
    1.0 / (1.0 + libm::exp(-seen.fold(bias, |sum, weight| sum + weight)))
}

/// Of a bit that is on with probability p.
fn bit_entropy_nats(p: f64) -> f64 {
    let part = |p: f64| if p > 0.0 { -p * libm::log(p) } else { 0.0 };
    part(p) + part(1.0 - p)
}

impl Policy for Logistic {
    fn n_inputs(&self) -> usize {
        self.n_inputs
    }

    fn n_outputs(&self) -> usize {
        self.n_outputs
    }

    fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), Error> {
        self.tensors.check("Policy::set_parameters", parameters)?;
        self.parameters.copy_from_slice(parameters);
        Ok(())
    }

    fn act_and_score(
        &mut self,
        inputs: &[bool],
        outputs: &mut [bool],
        score: &mut [f64],
    ) -> Result<(), Error> {
        check_act(self, inputs, outputs, Some(score))?;
        self.draw(inputs, outputs);
        let (of_weights, of_biases) = score.split_at_mut(self.n_outputs * self.n_inputs);
        for (row, surprise) in of_weights.chunks_mut(self.n_inputs).zip(&self.surprise) {
            for (score, on) in row.iter_mut().zip(inputs) {
                *score = if *on { *surprise } else { 0.0 };
            }
        }
        of_biases.copy_from_slice(&self.surprise);
        Ok(())
    }

    fn act(&mut self, inputs: &[bool], outputs: &mut [bool]) -> Result<(), Error> {
        check_act(self, inputs, outputs, None)?;
        self.draw(inputs, outputs);
        Ok(())
    }

    /// Exact.
    fn entropy_nats(&mut self, outputs: &[bool]) -> Result<f64, Error> {
        check_length("Policy::entropy_nats", "outputs", self.n_outputs, outputs.len())?;
        // 1 - p(y_i), of which a bit has the same entropy as of p(y_i).
        let of_bits = self.surprise.iter().map(|surprise| bit_entropy_nats(surprise.abs()));
        Ok(of_bits.sum::<f64>() / self.n_outputs as f64)
    }

    fn links(&self) -> Vec<Link> {
        let n_weights = self.n_outputs * self.n_inputs;
        let bias = |weight| Some(n_weights + weight / self.n_inputs);
        (0..n_weights).map(|weight| Link { weight, biases: [bias(weight), None] }).collect()
    }

    fn draw_from(&mut self, seed: u64, stream: &str) {
        self.uniform = Uniform::new(seed, stream);
    }

    fn random_state(&self) -> Vec<u32> {
        self.uniform.state()
    }

    fn set_random_state(&mut self, state: &[u32]) -> Result<(), Error> {
        self.uniform.set_state(state)
    }

    fn to_safetensors(&self) -> Result<Vec<u8>, Error> {
        let Self { n_inputs, n_outputs, .. } = self;
        self.tensors.write(&format!("n_inputs={n_inputs} n_outputs={n_outputs}"), &self.parameters)
    }

    fn read_safetensors(&self, bytes: &[u8]) -> Result<Vec<f64>, Error> {
        expect_same_layout(bytes, &self.to_safetensors()?)?;
        self.tensors.read(bytes)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_are_logistic_and_have_ends() {
        let p = probability(0.5, &[1.0, 7.0, -2.0], &[true, false, true]);
        assert!((p - 1.0 / (1.0 + f64::exp(0.5))).abs() < 1e-15);
        assert_eq!(probability(1e9, &[], &[]), 1.0);
        assert_eq!(probability(-1e9, &[], &[]), 0.0);
    }

    #[test]
    fn a_bit_has_its_entropy() {
        assert_eq!([0.0, 1.0].map(bit_entropy_nats), [0.0, 0.0]);
        assert!((bit_entropy_nats(0.5) - std::f64::consts::LN_2).abs() < 1e-15);
        // 1/4 log 4 + 3/4 log 4/3
        assert!((bit_entropy_nats(0.25) - 0.562_335_144_618_808_4).abs() < 1e-15);
        assert_eq!(bit_entropy_nats(0.25), bit_entropy_nats(0.75));
    }
}
