//! How rough a noisy function of many parameters is: slices through it, and measures of them.
//!
//! A function that can only be estimated, as the reward of a policy by its parameters, is evaluated at
//! the points of a *slice*, a line or a plane through its parameters, and that several times with
//! random numbers of their own: [`Repeats`]. What differs between repeats is noise, and noise isn't
//! roughness: every measure takes it out, or says how far it reaches.
//!
//! | file | what |
//! |---|---|
//! | `slice.rs` | [`random_direction`], [`PrincipalPlane`]: where slices go through a space of parameters |
//! | `repeats.rs` | [`Repeats`]: the values of a slice, their mean, their noise; [`Estimate`] with its interval |
//! | `inner.rs` | [`inner`]: the inner product of two means without their noise, which most measures are made of |
//! | `prominence.rs` | [`Grid::prominences`]: how far each local optimum stands out |
//! | `optima.rs` | [`Optima`]: local optima and total variation beyond noise |
//! | `curvature.rs` | [`curvature`]: second differences |
//! | `barrier.rs` | [`barrier`]: how deep the valley between two points is |
//! | `correlation.rs` | [`distance_correlation`]: of value and distance |
//! | `slope.rs` | [`slope`]: in the middle of a line |
//! | `alignment.rs` | [`cosine`]: of two noisy gradients |
//!
//! ```
//! use landscape::{Grid, Optima, Repeats, curvature};
//!
//! // Two hills, five times with a little noise.
//! let height = |t: f64| (3.0 * t).cos().powi(2);
//! let mut noise = streams::Normals::new(1, "noise");
//! let repeat = |_| (0..41).map(|i| height(i as f64 / 20.0 - 1.0) + 0.02 * noise.draw()).collect();
//! let hills = Repeats::new((0..5).map(repeat).collect())?;
//! let optima = Optima::of(&hills, &Grid::line(41));
//! assert_eq!(optima.n, 1); // at 0; those at -1.05 and 1.05 lie outside
//! assert!(curvature(&hills).is_some());
//! # Ok::<(), landscape::Error>(())
//! ```
//!
//! What always holds: the same values give the same bits; a measure of what isn't there, as the
//! curvature of a slice that is flat but for noise, is `None` and never NaN.

#![forbid(unsafe_code)]

mod alignment;
mod barrier;
mod correlation;
mod curvature;
mod inner;
mod optima;
mod prominence;
mod repeats;
mod slice;
mod slope;

pub use alignment::cosine;
pub use barrier::barrier;
pub use correlation::distance_correlation;
pub use curvature::curvature;
pub use inner::inner;
pub use optima::{Optima, variation};
pub use prominence::{Grid, Peak};
pub use repeats::{Estimate, Repeats, require_finite};
pub use slice::{PrincipalPlane, blocks, random_direction};
pub use slope::slope;

/// Values that can't be measured.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}: expected {expected}, got {got}")]
pub struct Error {
    what: &'static str,
    expected: &'static str,
    got: String,
}

impl Error {
    fn new(what: &'static str, expected: &'static str, got: impl ToString) -> Self {
        Self { what, expected, got: got.to_string() }
    }
}

#[cfg(test)]
mod tests;
