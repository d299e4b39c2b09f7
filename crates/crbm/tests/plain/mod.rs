//! The same policy as a textbook writes it: one chain after the other, one unit after the other, a
//! dot product and an exponential for each, all in `f64`. It shares nothing with the crate but the
//! order of the parameters, of a full layout. The tests' second opinion, and the bench's "plain
//! scalar loop".

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

pub struct Plain {
    pub n_inputs: usize,
    pub n_hidden: usize,
    pub n_outputs: usize,
    pub gibbs_updates: usize,
    pub samples: usize,
    /// V, c, W, b.
    pub parameters: Vec<f64>,
    pub rng: Pcg64Mcg,
}

impl Plain {
    pub fn new(sizes: [usize; 3], parameters: Vec<f64>, seed: u64) -> Self {
        let [n_inputs, n_hidden, n_outputs] = sizes;
        let rng = Pcg64Mcg::seed_from_u64(seed);
        let (gibbs_updates, samples) = (10, 60);
        Self { n_inputs, n_hidden, n_outputs, gibbs_updates, samples, parameters, rng }
    }

    /// The action, and its score into `score`.
    pub fn act_and_score(&mut self, x: &[f64], y: &mut [f64], score: &mut [f64]) {
        let given_input = self.given_input(x);
        let mut h = vec![0.0; self.n_hidden];
        self.sample(&given_input, &mut h, y);
        score.fill(0.0);
        self.expect_hidden(&given_input, y, &mut h);
        self.add_to_score(x, &h, y, 1.0, score);
        let mut sampled_y = vec![0.0; self.n_outputs];
        for _ in 0..self.samples {
            self.sample(&given_input, &mut h, &mut sampled_y);
            self.expect_hidden(&given_input, &sampled_y, &mut h);
            self.add_to_score(x, &h, &sampled_y, -1.0 / self.samples as f64, score);
        }
    }

    /// c + V x.
    pub fn given_input(&self, x: &[f64]) -> Vec<f64> {
        let (v, rest) = self.parameters.split_at(self.n_hidden * self.n_inputs);
        (0..self.n_hidden)
            .map(|j| {
                let row = &v[j * self.n_inputs..][..self.n_inputs];
                rest[j] + row.iter().zip(x).map(|(v, x)| v * x).sum::<f64>()
            })
            .collect()
    }

    /// One chain from a random start; the bits are 0.0 and 1.0.
    pub fn sample(&mut self, given_input: &[f64], h: &mut [f64], y: &mut [f64]) {
        for y in y.iter_mut() {
            *y = if self.rng.next_u64() >> 63 == 1 { 1.0 } else { 0.0 };
        }
        for _ in 0..self.gibbs_updates {
            self.expect_hidden(given_input, y, h);
            self.draw(h);
            let (w, b) = self.w_and_b();
            for i in 0..self.n_outputs {
                let mut activation = b[i];
                for j in 0..self.n_hidden {
                    activation += w[j * self.n_outputs + i] * h[j];
                }
                y[i] = sigmoid(activation);
            }
            self.draw(y);
        }
    }

    fn expect_hidden(&self, given_input: &[f64], y: &[f64], h: &mut [f64]) {
        let (w, _) = self.w_and_b();
        for j in 0..self.n_hidden {
            let mut activation = given_input[j];
            for i in 0..self.n_outputs {
                activation += w[j * self.n_outputs + i] * y[i];
            }
            h[j] = sigmoid(activation);
        }
    }

    fn w_and_b(&self) -> (&[f64], &[f64]) {
        let start = self.n_hidden * (self.n_inputs + 1);
        self.parameters[start..].split_at(self.n_hidden * self.n_outputs)
    }

    /// Each probability becomes a bit.
    fn draw(&mut self, probabilities: &mut [f64]) {
        for p in probabilities {
            let uniform = (self.rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
            *p = if uniform < *p { 1.0 } else { 0.0 };
        }
    }

    fn add_to_score(&self, x: &[f64], h: &[f64], y: &[f64], factor: f64, score: &mut [f64]) {
        let (v, rest) = score.split_at_mut(self.n_hidden * self.n_inputs);
        let (c, rest) = rest.split_at_mut(self.n_hidden);
        let (w, b) = rest.split_at_mut(self.n_hidden * self.n_outputs);
        for j in 0..self.n_hidden {
            let h = factor * h[j];
            for (v, x) in v[j * self.n_inputs..].iter_mut().zip(x) {
                *v += h * x;
            }
            c[j] += h;
            for (w, y) in w[j * self.n_outputs..].iter_mut().zip(y) {
                *w += h * y;
            }
        }
        for (b, y) in b.iter_mut().zip(y) {
            *b += factor * y;
        }
    }
}

fn sigmoid(a: f64) -> f64 {
    1.0 / (1.0 + (-a).exp())
}
