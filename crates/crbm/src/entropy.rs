//! How uncertain an action is: the entropy of its bits.
//!
//! ```text
//! h_j = p(h_j = 1 | x, y)        p_i = sigmoid(b_i + sum_j h_j W_ji)
//! H   = 1/n sum_i -p_i log p_i - (1 - p_i) log (1 - p_i)
//! ```
//!
//! p(y_i = 1 | x) is a sum over all hidden states, which isn't known. This is the last step of the chain
//! that drew y, from the hidden units' means given y in place of their sample: no random number is
//! drawn for it. It's exact where no hidden unit matters, 0 of a policy that always does the same, log 2 of
//! one that does anything; in between it's the entropy of a bit for whoever knows the hidden units, and
//! so rather too low.

use crate::{
    score::expect_action,
    simd::{Kernel, Lanes},
    tables::Columns,
};

/// Works out H.
pub(crate) struct Entropy<'a> {
    pub(crate) output_weights: &'a Columns,
    /// c + V x, `[n_hidden]`.
    pub(crate) hidden_biases: &'a [f64],
    /// b, `[n_outputs]`.
    pub(crate) output_biases: &'a [f64],
    /// y, `[n_outputs]`.
    pub(crate) action: &'a [bool],
    /// Room for E[h|x,y], `[n_hidden]`, and for which outputs are on.
    pub(crate) hidden: &'a mut [f64],
    pub(crate) on: &'a mut [usize],
    pub(crate) to: &'a mut f64,
}

impl Kernel for Entropy<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        expect_action(self.output_weights, self.hidden_biases, self.action, (self.on, self.hidden));
        let biases = self.output_biases.iter().enumerate();
        let entropy = |(i, bias): (usize, &f64)| {
            of_a_bit(bias + self.output_weights.weighted(i, self.hidden))
        };
        *self.to = biases.map(entropy).sum::<f64>() / self.output_biases.len() as f64;
    }
}

/// In nats, of a bit that is on with probability sigmoid(a): log(1 + e) + |a| e / (1 + e), e = exp(-|a|).
fn of_a_bit(a: f64) -> f64 {
    let size = a.abs();
    let e = libm::exp(-size);
    // Beyond it e is 0, and so is the product, however large a is.
    if e == 0.0 { 0.0 } else { libm::log1p(e) + size * e / (1.0 + e) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bit_has_its_entropy() {
        assert_eq!(of_a_bit(0.0), std::f64::consts::LN_2);
        for a in [-30.0, -2.0, 0.5, 1.0, 7.0] {
            let p = 1.0 / (1.0 + libm::exp(-a));
            let q = 1.0 / (1.0 + libm::exp(a));
            let expected = -p * libm::log(p) - q * libm::log(q);
            assert!((of_a_bit(a) - expected).abs() < 1e-14, "{a}");
        }
        for a in [1e3, -1e3, 1e300, f64::INFINITY] {
            assert_eq!(of_a_bit(a), 0.0, "{a}");
        }
    }
}
