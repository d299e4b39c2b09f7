//! The machine as a stochastic policy: x in; y, and the score of y, out.

use crate::{
    ChainRng, Error, Instructions, Layout,
    entropy::Entropy,
    error::{check_length, check_room},
    gibbs::{Bits, Conditionals, Sample, TOGETHER},
    score::{Expect, Statistics},
    simd::{Detected, LANES},
    tables::{Columns, Tables, incoming, negative_bits},
};

/// How p(y|x) is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// G: full Gibbs updates from a random start. With 0, y is uniform.
    pub gibbs_updates: usize,
    /// S: samples, besides the action, for the score's second term; at least 1.
    pub samples: usize,
}

impl Default for Sampling {
    /// The paper's: 10 updates, 60 samples.
    fn default() -> Self {
        Self { gibbs_updates: 10, samples: 60 }
    }
}

/// The most samples for a score.
const MAX_SAMPLES: usize = 1 << 20;

/// A conditional restricted Boltzmann machine that acts.
///
/// Holds the parameters in the forms that sampling reads, and all the room that a call needs: no
/// call but [`new`](Self::new) allocates. A policy's results depend on parameters, inputs and random
/// numbers only, never on earlier calls or on the processor.
#[derive(Clone, Debug)]
pub struct Policy {
    layout: Layout,
    sampling: Sampling,
    detected: Detected,
    input_weights: Columns,
    output_weights: Columns,
    /// c, `[n_hidden]`.
    hidden_biases: Vec<f64>,
    /// b, `[n_outputs]`.
    output_biases: Vec<f64>,
    /// c + V x of the last input, `[n_hidden]`.
    given_input: Vec<f64>,
    conditionals: Conditionals,
    hidden: Bits,
    outputs: Bits,
    statistics: Statistics,
}

impl Policy {
    /// With the parameters in the layout's order.
    ///
    /// # Errors
    /// As [`set_parameters`](Self::set_parameters), if the number of samples is 0 or beyond
    /// 1,048,576, and if there's no memory for it.
    pub fn new(layout: Layout, sampling: Sampling, parameters: &[f64]) -> Result<Self, Error> {
        if !(1..=MAX_SAMPLES).contains(&sampling.samples) {
            let expected = format!("in 1..={MAX_SAMPLES}");
            return Err(Error::argument("Policy::new", "samples", expected, sampling.samples));
        }
        check_room("Policy::new", bytes(&layout, sampling))?;
        let [of_hidden, of_outputs] = incoming(layout.output_mask());
        let (m, n) = (layout.n_hidden(), layout.n_outputs());
        let conditionals = Conditionals {
            hidden: Tables::new(&of_hidden),
            hidden_biases: vec![0.0; m],
            outputs: Tables::new(&of_outputs),
            output_biases: vec![0.0; n],
        };
        let mut policy = Self {
            input_weights: Columns::new(layout.input_mask()),
            output_weights: Columns::new(layout.output_mask()),
            hidden_biases: vec![0.0; m],
            output_biases: vec![0.0; n],
            given_input: vec![0.0; m],
            conditionals,
            hidden: Bits::new(m, TOGETHER),
            outputs: Bits::new(n, lane_groups(sampling)),
            statistics: Statistics::new(&layout),
            detected: Detected::best(),
            layout,
            sampling,
        };
        policy.set_parameters(parameters)?;
        Ok(policy)
    }

    /// Which parameter is where.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// How p(y|x) is sampled.
    pub fn sampling(&self) -> Sampling {
        self.sampling
    }

    /// 1 + S: the action's chain and the samples'.
    pub fn n_chains(&self) -> usize {
        1 + self.sampling.samples
    }

    /// The start of a named stream with a generator for each chain.
    pub fn rng(&self, seed: u64, stream: &str) -> ChainRng {
        ChainRng::new(seed, stream, self.n_chains())
    }

    /// What the policy runs on: the widest that the processor has, unless told otherwise.
    pub fn instructions(&self) -> Instructions {
        self.detected.instructions()
    }

    /// Runs on these instructions from now on. The results are the same.
    ///
    /// # Errors
    /// If the processor doesn't have them.
    pub fn set_instructions(&mut self, instructions: Instructions) -> Result<(), Error> {
        let expected = "what the processor has";
        self.detected = instructions.detect().ok_or_else(|| {
            let value = format!("{instructions:?}");
            Error::argument("Policy::set_instructions", "instructions", expected, value)
        })?;
        Ok(())
    }

    /// Changes all parameters, given in the layout's order, `[n_parameters]`.
    ///
    /// # Errors
    /// If their number is wrong, or one is NaN or beyond [`MAX_PARAMETER`](crate::MAX_PARAMETER) in
    /// magnitude; the policy is as before.
    pub fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), Error> {
        let layout = &self.layout;
        layout.check("Policy::set_parameters", parameters)?;
        self.input_weights.pack(layout.input_mask(), &parameters[layout.input_weights()]);
        self.hidden_biases.copy_from_slice(&parameters[layout.hidden_biases()]);
        let output_weights = &parameters[layout.output_weights()];
        self.output_weights.pack(layout.output_mask(), output_weights);
        self.conditionals.hidden.pack(output_weights);
        self.conditionals.outputs.pack(output_weights);
        let biases = &parameters[layout.output_biases()];
        self.output_biases.copy_from_slice(biases);
        for (to, bias) in self.conditionals.output_biases.iter_mut().zip(biases) {
            *to = negative_bits(*bias);
        }
        Ok(())
    }

    /// Draws an action y, `[n_outputs]`, and the score at (x, y), `[n_parameters]`, in one pass of
    /// 1 + S chains. The action is chain 0's.
    ///
    /// # Errors
    /// If a slice's length is wrong, or `rng` has fewer than 1 + S chains; nothing is drawn then.
    pub fn act_and_score(
        &mut self,
        x: &[bool],
        rng: &mut ChainRng,
        y: &mut [bool],
        score: &mut [f64],
    ) -> Result<(), Error> {
        let place = "Policy::act_and_score";
        check_length(place, "y", self.layout.n_outputs(), y.len())?;
        check_length(place, "score", self.layout.n_parameters(), score.len())?;
        self.run_chains(place, x, rng, self.n_chains())?;
        self.outputs.unpack(0, y);
        self.write_score(x, y, score);
        Ok(())
    }

    /// The score at any (x, y), `[n_parameters]`, with S samples: what
    /// [`act_and_score`](Self::act_and_score) would give for that action, and with as many random
    /// numbers.
    ///
    /// # Errors
    /// As [`act_and_score`](Self::act_and_score).
    pub fn score(
        &mut self,
        x: &[bool],
        y: &[bool],
        rng: &mut ChainRng,
        score: &mut [f64],
    ) -> Result<(), Error> {
        let place = "Policy::score";
        check_length(place, "y", self.layout.n_outputs(), y.len())?;
        check_length(place, "score", self.layout.n_parameters(), score.len())?;
        self.run_chains(place, x, rng, self.n_chains())?;
        self.write_score(x, y, score);
        Ok(())
    }

    /// Draws an action y, `[n_outputs]`, alone: the same as
    /// [`act_and_score`](Self::act_and_score) would, and for a fraction of its time.
    ///
    /// # Errors
    /// If a slice's length is wrong, or `rng` has no chain.
    pub fn act(&mut self, x: &[bool], rng: &mut ChainRng, y: &mut [bool]) -> Result<(), Error> {
        check_length("Policy::act", "y", self.layout.n_outputs(), y.len())?;
        self.run_chains("Policy::act", x, rng, 1)?;
        self.outputs.unpack(0, y);
        Ok(())
    }

    /// Draws independent samples of y, `[any number up to 1 + S x n_outputs]`, row-major, one from
    /// each of the first chains.
    ///
    /// # Errors
    /// If a slice's length is wrong, or `rng` has too few chains.
    pub fn sample(&mut self, x: &[bool], rng: &mut ChainRng, y: &mut [bool]) -> Result<(), Error> {
        let (place, n) = ("Policy::sample", self.layout.n_outputs());
        let n_samples = y.len() / n;
        if !y.len().is_multiple_of(n) || n_samples > self.n_chains() {
            let expected = format!("a multiple of {n} up to {}", n * self.n_chains());
            return Err(Error::argument(place, "length of y", expected, y.len()));
        }
        self.run_chains(place, x, rng, n_samples)?;
        for (chain, y) in y.chunks_mut(n).enumerate() {
            self.outputs.unpack(chain, y);
        }
        Ok(())
    }

    /// About how uncertain the bits of an action were, given the last input x: the mean of their entropies,
    /// 0 to log 2 nats, by p(y_i | x, h) with the hidden units at their means given this y. Nothing is drawn.
    ///
    /// # Errors
    /// If the length of `y` is wrong.
    pub fn entropy_nats(&mut self, y: &[bool]) -> Result<f64, Error> {
        check_length("Policy::entropy_nats", "y", self.layout.n_outputs(), y.len())?;
        if self.sampling.gibbs_updates == 0 {
            return Ok(std::f64::consts::LN_2);
        }
        let mut entropy = 0.0;
        self.detected.run(Entropy {
            output_weights: &self.output_weights,
            hidden_biases: &self.given_input,
            output_biases: &self.output_biases,
            action: y,
            hidden: &mut self.statistics.action,
            on: &mut self.statistics.on,
            to: &mut entropy,
        });
        Ok(entropy)
    }

    /// From the samples of the last [`run_chains`](Self::run_chains), for the same x.
    fn write_score(&mut self, x: &[bool], y: &[bool], score: &mut [f64]) {
        self.detected.run(Expect {
            output_weights: &self.output_weights,
            biases: &self.given_input,
            action: y,
            outputs: &self.outputs,
            n_samples: self.sampling.samples,
            to: &mut self.statistics,
        });
        self.statistics.write(&self.layout, (x, y), self.sampling.samples, score);
    }

    /// The first `n_chains` chains, and those that share a lane group with one of them.
    fn run_chains(
        &mut self,
        place: &'static str,
        x: &[bool],
        rng: &mut ChainRng,
        n_chains: usize,
    ) -> Result<(), Error> {
        check_length(place, "x", self.layout.n_inputs(), x.len())?;
        if rng.n_chains() < n_chains {
            let expected = format!("at least {n_chains}");
            return Err(Error::argument(place, "chains of rng", expected, rng.n_chains()));
        }
        self.given_input.copy_from_slice(&self.hidden_biases);
        for (k, _) in x.iter().enumerate().filter(|(_, on)| **on) {
            self.input_weights.add_to(k, &mut self.given_input);
        }
        for (to, sum) in self.conditionals.hidden_biases.iter_mut().zip(&self.given_input) {
            *to = negative_bits(*sum);
        }
        self.detected.run(Sample {
            given: &self.conditionals,
            updates: self.sampling.gibbs_updates,
            rng: &mut rng.groups()[..n_chains.div_ceil(LANES)],
            hidden: &mut self.hidden,
            outputs: &mut self.outputs,
        });
        Ok(())
    }
}

/// Lane groups for the action's chain and the samples'.
fn lane_groups(sampling: Sampling) -> usize {
    (1 + sampling.samples).div_ceil(LANES)
}

/// What a policy allocates.
fn bytes(layout: &Layout, sampling: Sampling) -> usize {
    let (m, n) = (layout.n_hidden(), layout.n_outputs());
    let biases = size_of::<f64>() * (2 * m + 2 * n) + size_of::<f32>() * (m + n);
    let bits = Bits::bytes(m, TOGETHER) + Bits::bytes(n, lane_groups(sampling));
    let columns = Columns::bytes(layout.input_mask()) + Columns::bytes(layout.output_mask());
    Tables::bytes(layout.output_mask()) + columns + biases + bits + Statistics::bytes(layout)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::Mask;

    /// The definition, with plain loops, of machines with and without a mask.
    #[test]
    fn entropy_is_of_the_bits_given_the_hidden_units_means() {
        let blocks = Mask::blocks(3, &[0, 0, 1, 1, 1]).unwrap();
        let masked = Layout::new(Mask::full(6, 4).unwrap(), blocks).unwrap();
        for layout in [Layout::full(4, 7, 5).unwrap(), masked] {
            let n = layout.n_parameters();
            let parameters: Vec<f64> =
                (0..n).map(|i| ((i * 37 % 23) as f64 - 11.0) * 0.2).collect();
            let mut policy = Policy::new(layout.clone(), Sampling::default(), &parameters).unwrap();
            let (x, mut y) = ([true, false, true, true], [false; 5]);
            let mut rng = policy.rng(1, "entropy");
            for _ in 0..20 {
                policy.act(&x, &mut rng, &mut y).unwrap();
                let at =
                    |place: Option<usize>, on: f64| place.map_or(0.0, |it| parameters[it] * on);
                let sigmoid = |a: f64| 1.0 / (1.0 + libm::exp(-a));
                let bit = |on: bool| f64::from(u8::from(on));
                let hidden = |j: usize| {
                    let v = (0..4).map(|k| at(layout.input_weight(j, k), bit(x[k])));
                    let w = (0..5).map(|i| at(layout.output_weight(j, i), bit(y[i])));
                    sigmoid(parameters[layout.hidden_biases().start + j] + v.chain(w).sum::<f64>())
                };
                let entropy = |i: usize| {
                    let w =
                        (0..layout.n_hidden()).map(|j| at(layout.output_weight(j, i), hidden(j)));
                    let p = sigmoid(parameters[layout.output_biases().start + i] + w.sum::<f64>());
                    -p * libm::log(p) - (1.0 - p) * libm::log(1.0 - p)
                };
                let expected = (0..5).map(entropy).sum::<f64>() / 5.0;
                let found = policy.entropy_nats(&y).unwrap();
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
                for instructions in Instructions::available() {
                    policy.set_instructions(instructions).unwrap();
                    assert_eq!(policy.entropy_nats(&y).unwrap(), found, "{instructions:?}");
                }
            }
        }
    }

    /// No less than it takes, so that what was let in isn't refused later by the system, and not so
    /// much more that what fits is refused.
    #[test]
    fn its_bytes_are_about_those_that_it_allocates() {
        let blocks = Mask::blocks(40, &(0..24).collect::<Vec<_>>()).unwrap();
        for (layout, samples) in [
            (Layout::full(30, 50, 24).unwrap(), 60),
            (Layout::full(3000, 700, 24).unwrap(), 60),
            (Layout::full(2, 1, 300).unwrap(), 1),
            (Layout::full(30, 50, 24).unwrap(), 20_000),
            (Layout::new(Mask::full(960, 30).unwrap(), blocks).unwrap(), 60),
        ] {
            let sampling = Sampling { gibbs_updates: 10, samples };
            let said = bytes(&layout, sampling) as i64;
            let parameters = vec![0.0; layout.n_parameters()];
            // The probe for room is as large as what was said: only what stays is counted.
            let counted = allocation_counter::measure(|| {
                std::mem::forget(Policy::new(layout, sampling, &parameters).unwrap());
            });
            let stays = counted.bytes_current;
            assert!(stays <= said && said <= 3 * stays + 100_000, "{stays} stay, {said} said");
        }
    }

    #[test]
    fn more_than_there_is_memory_for_is_refused_with_the_amount() {
        let layout = Layout::full(1, 1, 1).unwrap();
        // Beyond the address space; a system that promises more than it has would take less.
        let error = check_room("Policy::new", 1 << 60).unwrap_err();
        let message = "Policy::new: it takes 1152921504607 MB, and there is no memory for them";
        assert_eq!(error.to_string(), message);
        assert!(Policy::new(layout, Sampling::default(), &[0.0; 4]).is_ok());
    }
}
