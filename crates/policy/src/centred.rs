//! Parameters of centred units: what a policy learns by when each bit x, h, y counts from 1/2, so that
//! off is -1/2 and on is 1/2, in place of 0 and 1.
//!
//! ```text
//! w'(u - 1/2)(v - 1/2) + b'(u - 1/2) = w uv + b u + ...,   w = w',   b = b' - 1/2 sum_w w'
//! d log p / d w' = d log p / d w - 1/2 (d log p / d b_u + d log p / d b_v),   d log p / d b' = d log p / d b
//! ```
//!
//! with the sum over the weights of the unit that b belongs to. The policies are the same ones; but a
//! weight's gradient is there whether its input is on or off, and no longer goes along with that of
//! the bias, so steps of the same size lead elsewhere. Source: G. Montavon and K.-R. Müller, *Deep
//! Boltzmann Machines and the Centering Trick*, in Neural Networks: Tricks of the Trade (2012),
//! 621-637, with 1/2 for all offsets; the restricted kind in K. Cho, T. Raiko and A. Ilin, *Enhanced
//! Gradient for Training Restricted Boltzmann Machines*, Neural Computation 25 (2013), 805-831.

use crate::{Error, Policy};

/// A weight between two units, and the biases of those of them that have one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// Where the weight is among the parameters.
    pub weight: usize,
    /// Where the biases are; inputs have none.
    pub biases: [Option<usize>; 2],
}

/// A policy whose parameters are those of centred units. Its files have those of units 0 and 1.
#[derive(Debug)]
pub(crate) struct Centred {
    /// Acts, by the parameters of units 0 and 1.
    inner: Box<dyn Policy>,
    links: Vec<Link>,
    /// Those of centred units.
    parameters: Vec<f64>,
    /// On their way to `inner`.
    buffer: Vec<f64>,
}

impl Centred {
    pub(crate) fn new(inner: Box<dyn Policy>) -> Self {
        let links = inner.links();
        let mut parameters = inner.parameters().to_vec();
        add_to_biases(&links, 0.5, &mut parameters);
        Self { links, buffer: parameters.clone(), parameters, inner }
    }
}

/// To each bias `factor` times the sum of its unit's weights.
fn add_to_biases(links: &[Link], factor: f64, parameters: &mut [f64]) {
    for link in links {
        let change = factor * parameters[link.weight];
        link.biases.iter().flatten().for_each(|&bias| parameters[bias] += change);
    }
}

impl Policy for Centred {
    fn n_inputs(&self) -> usize {
        self.inner.n_inputs()
    }

    fn n_outputs(&self) -> usize {
        self.inner.n_outputs()
    }

    fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), Error> {
        if parameters.len() != self.parameters.len() {
            // Says what is wrong with it.
            return self.inner.set_parameters(parameters);
        }
        self.buffer.copy_from_slice(parameters);
        add_to_biases(&self.links, -0.5, &mut self.buffer);
        self.inner.set_parameters(&self.buffer)?;
        self.parameters.copy_from_slice(parameters);
        Ok(())
    }

    fn act_and_score(
        &mut self,
        inputs: &[bool],
        outputs: &mut [bool],
        score: &mut [f64],
    ) -> Result<(), Error> {
        self.inner.act_and_score(inputs, outputs, score)?;
        for link in &self.links {
            let of_biases: f64 = link.biases.iter().flatten().map(|&bias| score[bias]).sum();
            score[link.weight] -= 0.5 * of_biases;
        }
        Ok(())
    }

    fn act(&mut self, inputs: &[bool], outputs: &mut [bool]) -> Result<(), Error> {
        self.inner.act(inputs, outputs)
    }

    fn entropy_nats(&mut self, outputs: &[bool]) -> Result<f64, Error> {
        self.inner.entropy_nats(outputs)
    }

    fn links(&self) -> Vec<Link> {
        self.links.clone()
    }

    fn draw_from(&mut self, seed: u64, stream: &str) {
        self.inner.draw_from(seed, stream);
    }

    fn random_state(&self) -> Vec<u32> {
        self.inner.random_state()
    }

    fn set_random_state(&mut self, state: &[u32]) -> Result<(), Error> {
        self.inner.set_random_state(state)
    }

    fn to_safetensors(&self) -> Result<Vec<u8>, Error> {
        self.inner.to_safetensors()
    }

    fn read_safetensors(&self, bytes: &[u8]) -> Result<Vec<f64>, Error> {
        let mut parameters = self.inner.read_safetensors(bytes)?;
        add_to_biases(&self.links, 0.5, &mut parameters);
        Ok(parameters)
    }
}
