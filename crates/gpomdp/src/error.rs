//! What can go wrong, with the place, what was expected and what was found.

/// What this crate refuses. Whatever refused is as it was before the call.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A slice of the wrong length.
    #[error("{place}: {what} must have {expected} elements, got {got}")]
    Length {
        /// The function that refused.
        place: &'static str,
        /// Its argument.
        what: &'static str,
        /// The length that it should have.
        expected: usize,
        /// The length that it has.
        got: usize,
    },
    /// An element that is NaN, infinite or too large.
    #[error("{place}: {what}[{index}] must be within -{limit:e} to {limit:e}, got {value:?}")]
    Element {
        /// The function that refused.
        place: &'static str,
        /// Its argument.
        what: &'static str,
        /// The first element that is out of range.
        index: usize,
        /// The largest magnitude that it may have.
        limit: f64,
        /// What it is.
        value: f64,
    },
    /// A single number that is NaN, infinite or out of range.
    #[error("{place}: {what} must be {expected}, got {value:?}")]
    Number {
        /// The function that refused.
        place: &'static str,
        /// Its argument, the setting, or the part of a state.
        what: &'static str,
        /// What it should be.
        expected: &'static str,
        /// What it is.
        value: f64,
    },
    /// More parameters than there is memory for.
    #[error(
        "{place}: {n_parameters} parameters take {:.0} MB, and there is no memory for them",
        *n_parameters as f64 * size_of::<f64>() as f64 / 1e6
    )]
    Memory {
        /// The function that refused.
        place: &'static str,
        /// The number of parameters that was asked for.
        n_parameters: usize,
    },
}
