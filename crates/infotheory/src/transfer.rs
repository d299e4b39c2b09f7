//! Transfer entropy: what the source's past tells about the target's next symbol, beyond what the
//! target's own past tells.
//!
//! ```text
//! T = I(x_t ; y_{t-1} .. y_{t-l} | x_{t-1} .. x_{t-k}),   x the target, y the source
//! ```
//!
//! T. Schreiber, *Measuring information transfer*, Physical Review Letters 85 (2000). It's a
//! conditional mutual information, with that one's estimators and corrections.

use crate::{
    column::Column,
    error::{Error, check_length, refused},
    information::{Estimator, Information},
    mutual::Triple,
};

/// The numbers of past symbols that count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct History {
    /// k: symbols of the target's own past. With 0 it's ignored, and transfer entropy is the
    /// mutual information of the target's symbol with the source's past.
    pub target: usize,
    /// l: symbols of the source's past, at least 1.
    pub source: usize,
}

/// One symbol of each.
impl Default for History {
    fn default() -> Self {
        Self { target: 1, source: 1 }
    }
}

/// Transfer entropy from `source` to `target`, series of equal length N:
/// I(x_t ; y_{t-1} .. y_{t-l} | x_{t-1} .. x_{t-k}) for the target x and the source y, with the
/// correction of [`conditional_mutual_information`](crate::conditional_mutual_information). The
/// sample is the N - max(k, l) symbols of the target that have a full past; there must be one.
///
/// After T. Schreiber, *Measuring information transfer*, Physical Review Letters 85 (2000).
pub fn transfer_entropy<S: Copy + Ord, T: Copy + Ord>(
    source: &[S],
    target: &[T],
    history: History,
    estimator: Estimator,
) -> Result<Information, Error> {
    Ok(embed("transfer_entropy", source, target, history)?.information(estimator))
}

/// The source's past, the target's symbol and the target's past, as x, y and z of I(X; Y|Z).
pub(crate) fn embed<S: Copy + Ord, T: Copy + Ord>(
    call: &'static str,
    source: &[S],
    target: &[T],
    history: History,
) -> Result<Triple, Error> {
    check_length(call, "target", source.len(), target.len())?;
    if history.source == 0 {
        return Err(refused(call, "history.source", "at least 1", 0));
    }
    let skipped = history.source.max(history.target);
    if skipped >= target.len() {
        let expected = format!("more than {skipped}, the longer history");
        return Err(refused(call, "the length of target", expected, target.len()));
    }
    Ok(Triple {
        x: past(call, source, skipped, history.source)?,
        y: Column::new(call, "target", &target[skipped..])?,
        z: past(call, target, skipped, history.target)?,
    })
}

/// The `length` symbols before each one from the `skipped`th on, as one column.
fn past<T: Copy + Ord>(
    call: &'static str,
    series: &[T],
    skipped: usize,
    length: usize,
) -> Result<Column, Error> {
    let mut joint = Column::constant(series.len() - skipped);
    for lag in 1..=length {
        let lagged = &series[skipped - lag..series.len() - lag];
        joint = joint.join(&Column::new(call, "series", lagged)?);
    }
    Ok(joint)
}
