//! An amount of information, and how it's estimated from counts.
//!
//! The plug-in (maximum-likelihood) entropy of n samples with counts c_1 .. c_K of the K states
//! that occur is too low, by (K - 1) / 2n nats to first order; Miller and Madow add that back
//! (G. Miller, *Note on the bias of information estimates*, Information Theory in Psychology II-B,
//! 1955):
//!
//! ```text
//! plug-in       H = -sum_i (c_i / n) ln(c_i / n) = ln n - (1/n) sum_i c_i ln c_i
//! Miller-Madow  H + (K - 1) / 2n
//! ```
//!
//! Every measure of this crate is a sum of entropies with signs, so its correction is the sum of
//! theirs. K counts the states that occurred, so if most states never did, the correction is too
//! small.

use std::f64::consts::LN_2;

use crate::{column::Column, logs};

/// An amount of information: read it in [`nats`](Self::nats) or in [`bits`](Self::bits).
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Information {
    nats: f64,
}

impl Information {
    pub(crate) fn from_nats(nats: f64) -> Self {
        Self { nats }
    }

    /// In nats: logarithms to the base e.
    #[must_use]
    pub fn nats(self) -> f64 {
        self.nats
    }

    /// In bits: logarithms to the base 2.
    #[must_use]
    pub fn bits(self) -> f64 {
        self.nats / LN_2
    }
}

/// How an amount of information is estimated from counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Estimator {
    /// The observed frequencies in place of probabilities: -sum_i (c_i / n) ln(c_i / n) for an
    /// entropy. Never negative.
    PlugIn,
    /// Plug-in, less its bias of first order: each entropy gets (K - 1) / 2n nats more, if K states
    /// occur in n samples (G. Miller, *Note on the bias of information estimates*, 1955).
    /// Differences of entropies, like mutual information, can come out negative, by as much as the
    /// samples scatter.
    MillerMadow,
}

/// The sum of the columns' entropies, each with its sign. All columns have `n_samples` rows.
///
/// The logs are summed as integers, so the bits don't depend on the order or names of states.
pub(crate) fn signed_entropies(
    n_samples: usize,
    terms: &[(i32, &Column)],
    estimator: Estimator,
) -> Information {
    let n = n_samples as u64;
    let (mut sum, mut twice_n_bias) = (0, 0.0);
    for &(sign, column) in terms {
        sum += i128::from(sign) * (logs::n_ln_n(n) - column.sum_n_ln_n());
        twice_n_bias += f64::from(sign) * (column.n_states() as f64 - 1.0);
    }
    // Logs are rounded, so what is zero can come out as -1e-16.
    let plug_in = logs::nats(sum, n).max(0.0);
    Information::from_nats(match estimator {
        Estimator::PlugIn => plug_in,
        Estimator::MillerMadow => plug_in + twice_n_bias / (2.0 * n as f64),
    })
}
