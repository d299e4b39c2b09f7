//! The score, the gradient of log p(y|x), from the chains' outputs.
//!
//! ```text
//! d/dW_ji = E[h_j|x,y] y_i - mean over samples y' of E[h_j|x,y'] y'_i
//! ```
//! and likewise for V (x_k in place of y_i and y'_i), c (1) and b (y_i and y'_i alone): the paper's
//! gradient, with the sampled h replaced by its expectation given the sample's y, which has the
//! same mean and less variance (Rao-Blackwell). Here a lane is a hidden unit, in `f64`.

use std::f64::consts::{LN_2, LOG2_E};

use crate::{
    Layout,
    gibbs::Bits,
    simd::{Kernel, Lanes},
    tables::{Columns, GROUP},
};

/// What the score is made of, and the room to compute it.
#[derive(Clone, Debug)]
pub(crate) struct Statistics {
    /// E[h|x,y] of the action, `[n_hidden]`.
    pub(crate) action: Vec<f64>,
    /// Sum of E[h|x,y'] over the samples, `[n_hidden]`.
    hidden: Vec<f64>,
    /// Sum of y', `[n_outputs]`.
    outputs: Vec<f64>,
    /// Sum of y'_i E[h|x,y'], `[n_outputs x n_hidden]`.
    products: Vec<f64>,
    /// E[h|x,y'] of one sample, `[n_hidden]`.
    sample: Vec<f64>,
    /// The outputs that are on in a chain, and room for one more write.
    pub(crate) on: Vec<usize>,
}

impl Statistics {
    pub(crate) fn new(layout: &Layout) -> Self {
        let (m, n) = (layout.n_hidden(), layout.n_outputs());
        Self {
            action: vec![0.0; m],
            hidden: vec![0.0; m],
            outputs: vec![0.0; n],
            products: vec![0.0; n * m],
            sample: vec![0.0; m],
            on: vec![0; n.div_ceil(GROUP) * GROUP + 1],
        }
    }

    /// What [`Statistics::new`] allocates.
    pub(crate) fn bytes(layout: &Layout) -> usize {
        let (m, n) = (layout.n_hidden(), layout.n_outputs());
        size_of::<f64>() * (n * m + 3 * m + 2 * n + GROUP)
    }

    /// The score at the action `y`, in the layout's order, from `n_samples` samples.
    pub(crate) fn write(
        &self,
        layout: &Layout,
        (x, y): (&[bool], &[bool]),
        n_samples: usize,
        score: &mut [f64],
    ) {
        let each = 1.0 / n_samples as f64;
        let if_on = |on: bool, value: f64| if on { value } else { 0.0 };
        let (v, rest) = score.split_at_mut(layout.input_weights().len());
        let (c, rest) = rest.split_at_mut(layout.n_hidden());
        let (w, b) = rest.split_at_mut(layout.output_weights().len());

        let hidden = self.action.iter().zip(&self.hidden);
        for (c, (action, sum)) in c.iter_mut().zip(hidden) {
            *c = action - sum * each;
        }
        for (b, (y, sum)) in b.iter_mut().zip(y.iter().zip(&self.outputs)) {
            *b = f64::from(u8::from(*y)) - sum * each;
        }
        let (m, inputs, outputs) = (layout.n_hidden(), layout.input_mask(), layout.output_mask());
        for (j, &c) in c.iter().enumerate() {
            for (v, &k) in v[inputs.row_positions(j)].iter_mut().zip(inputs.row(j)) {
                *v = if_on(x[k as usize], c);
            }
            for (w, &i) in w[outputs.row_positions(j)].iter_mut().zip(outputs.row(j)) {
                let i = i as usize;
                *w = if_on(y[i], self.action[j]) - self.products[i * m + j] * each;
            }
        }
    }
}

/// Fills [`Statistics`]: chain 0 is left out, the next `n_samples` are the samples.
pub(crate) struct Expect<'a> {
    pub(crate) output_weights: &'a Columns,
    /// c + V x, `[n_hidden]`.
    pub(crate) biases: &'a [f64],
    /// y, `[n_outputs]`.
    pub(crate) action: &'a [bool],
    pub(crate) outputs: &'a Bits,
    pub(crate) n_samples: usize,
    pub(crate) to: &'a mut Statistics,
}

impl Kernel for Expect<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Statistics { action, hidden, outputs, products, sample, on } = self.to;
        for sum in [&mut *hidden, &mut *outputs, &mut *products] {
            sum.fill(0.0);
        }
        expect_action(self.output_weights, self.biases, self.action, (on, action));

        let m = hidden.len();
        for chain in 1..=self.n_samples {
            let n_on = list_on(self.outputs.of_chain(chain), GROUP, on);
            let on = &on[..n_on];
            expect(self.output_weights, self.biases, on, sample);
            add(hidden, sample);
            for &i in on {
                outputs[i] += 1.0;
                let range = self.output_weights.range(i);
                add(&mut products[i * m..][range.clone()], &sample[range]);
            }
        }
    }
}

/// The units that are on; returns how many. A bit decides nothing but how far the list grows: the
/// bits are random, and a branch on each would be mispredicted half of the time.
#[inline(always)]
fn list_on(words: impl Iterator<Item = u32>, bits_in_each: usize, on: &mut [usize]) -> usize {
    let mut n_on = 0;
    for (i, word) in words.enumerate() {
        for bit in 0..bits_in_each {
            on[n_on] = i * bits_in_each + bit;
            n_on += (word >> bit & 1) as usize;
        }
    }
    n_on
}

/// E[h|x,y] of an action, given c + V x; with room for which of its outputs are on.
#[inline(always)]
pub(crate) fn expect_action(
    output_weights: &Columns,
    biases: &[f64],
    action: &[bool],
    (on, to): (&mut [usize], &mut [f64]),
) {
    let n_on = list_on(action.iter().map(|on| u32::from(*on)), 1, on);
    expect(output_weights, biases, &on[..n_on], to);
}

/// E[h|x,y], given c + V x and the outputs that are on.
#[inline(always)]
fn expect(output_weights: &Columns, biases: &[f64], on: &[usize], to: &mut [f64]) {
    to.copy_from_slice(biases);
    for &i in on {
        output_weights.add_to(i, to);
    }
    for activation in to {
        *activation = sigmoid(*activation);
    }
}

#[inline(always)]
fn add(to: &mut [f64], summands: &[f64]) {
    for (sum, summand) in to.iter_mut().zip(summands) {
        *sum += summand;
    }
}

/// `1 / (1 + exp(-a))` by additions, multiplications and a division, so that compilers can put
/// several into a register; relative error below 1e-15 + 3e-16 |a|, for a in -690..=690, and the
/// value at the nearer end beyond.
///
/// As the sampler's power of two, to the precision of `f64`: the polynomial interpolates 2^f at 12
/// Chebyshev points in -1/2..=1/2, relative error 4.3e-18 before rounding.
#[inline(always)]
fn sigmoid(a: f64) -> f64 {
    // 1.5 * 2^52.
    const SHIFT: f64 = 6_755_399_441_055_744.0;
    let t = -LOG2_E * a;
    let t = if t < 1000.0 { t } else { 1000.0 };
    let t = if t > -1000.0 { t } else { -1000.0 };
    let shifted = t + SHIFT;
    let rest = t - (shifted - SHIFT);
    let mut power = POWER[0];
    for coefficient in &POWER[1..] {
        power = power * rest + coefficient;
    }
    let odds = f64::from_bits(power.to_bits().wrapping_add(shifted.to_bits() << 52));
    1.0 / (1.0 + odds)
}

/// Of 2^f on -1/2..=1/2, highest power first.
const POWER: [f64; 12] = [
    4.455_817_908_336_064_6e-10,
    7.074_194_297_288_521e-9,
    1.017_805_708_773_394_1e-7,
    1.321_543_253_591_237_6e-6,
    1.525_273_384_155_677_3e-5,
    1.540_353_046_372_435_4e-4,
    1.333_355_814_640_647e-3,
    9.618_129_107_587_257e-3,
    5.550_410_866_482_162_7e-2,
    2.402_265_069_591_016e-1,
    LN_2,
    1.0,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sigmoid_is_as_accurate_as_it_says() {
        for i in -69_000..=69_000 {
            let a = f64::from(i) / 100.0;
            let exact = 1.0 / (1.0 + libm::exp(-a));
            let error = (sigmoid(a) - exact).abs() / exact;
            assert!(error < 1e-15 + 3e-16 * a.abs(), "{a}: {error:e}");
        }
    }

    #[test]
    fn sigmoid_has_ends() {
        for a in [1e3, 1e9, 1e18] {
            assert_eq!(sigmoid(a), 1.0);
            assert!((0.0..1e-300).contains(&sigmoid(-a)), "{a}");
        }
    }
}
