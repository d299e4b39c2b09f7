//! Entropies of discrete data.
//!
//! ```text
//! H(X)    = -sum_x p(x) ln p(x)
//! H(X, Y) = -sum_{x,y} p(x, y) ln p(x, y)
//! H(X|Y)  = H(X, Y) - H(Y)
//! ```
//!
//! C. Shannon, *A mathematical theory of communication* (1948); T. Cover and J. Thomas, *Elements
//! of Information Theory*, chapter 2. With n samples, of which K_x states of X occur and K_xy of
//! the pair, the Miller-Madow corrections in nats are
//!
//! ```text
//! H(X): (K_x - 1) / 2n     H(X, Y): (K_xy - 1) / 2n     H(X|Y): (K_xy - K_y) / 2n
//! ```

use crate::{
    column::Column,
    error::{Error, check_length, refused},
    information::{Estimator, Information, signed_entropies},
    logs,
};

/// Entropy of a variable, H(X) = -sum_x p(x) ln p(x), from a sample of 1 to 2^32 - 1 symbols.
///
/// Correction: (K_x - 1) / 2n.
pub fn entropy<T: Copy + Ord>(x: &[T], estimator: Estimator) -> Result<Information, Error> {
    let x = Column::new("entropy", "x", x)?;
    Ok(signed_entropies(x.n_rows(), &[(1, &x)], estimator))
}

/// Entropy of a variable whose states occurred so many times. Zeros are states that didn't.
pub fn entropy_of_counts(counts: &[u64], estimator: Estimator) -> Result<Information, Error> {
    const CALL: &str = "entropy_of_counts";
    let total = counts.iter().try_fold(0_u64, |sum, &count| sum.checked_add(count));
    let Some(n) = total.filter(|&n| n > 0) else {
        let value = if total.is_none() { "more" } else { "0" };
        return Err(refused(CALL, "the sum of counts", "1 to 2^64 - 1", value));
    };
    // Each term is below n ln n < 2^123 and so is their sum, by convexity.
    let sum: i128 = counts.iter().map(|&count| logs::n_ln_n(count)).sum();
    let n_states = counts.iter().filter(|&&count| count > 0).count();
    let plug_in = logs::nats(logs::n_ln_n(n) - sum, n).max(0.0);
    Ok(Information::from_nats(match estimator {
        Estimator::PlugIn => plug_in,
        Estimator::MillerMadow => plug_in + (n_states as f64 - 1.0) / (2.0 * n as f64),
    }))
}

/// Entropy of several variables together, H(X_1, ..., X_m), m >= 1.
///
/// Correction: (K - 1) / 2n, for the K joint states that occur.
///
/// `columns`: \[m\] slices of equal length
pub fn joint_entropy<T: Copy + Ord>(
    columns: &[&[T]],
    estimator: Estimator,
) -> Result<Information, Error> {
    let columns = ranked("joint_entropy", columns)?;
    let joint = joined(&columns);
    Ok(signed_entropies(joint.n_rows(), &[(1, &joint)], estimator))
}

/// Entropy that is left in X when Y is known, H(X|Y) = H(X, Y) - H(Y). The slices are equally long.
///
/// Correction: (K_xy - K_y) / 2n.
pub fn conditional_entropy<X: Copy + Ord, Y: Copy + Ord>(
    x: &[X],
    y: &[Y],
    estimator: Estimator,
) -> Result<Information, Error> {
    const CALL: &str = "conditional_entropy";
    check_length(CALL, "y", x.len(), y.len())?;
    let (x, y) = (Column::new(CALL, "x", x)?, Column::new(CALL, "y", y)?);
    Ok(signed_entropies(x.n_rows(), &[(1, &x.join(&y)), (-1, &y)], estimator))
}

/// Checks that there are columns, and that they're equally long.
pub(crate) fn ranked<T: Copy + Ord>(
    call: &'static str,
    columns: &[&[T]],
) -> Result<Vec<Column>, Error> {
    let Some(first) = columns.first() else {
        return Err(refused(call, "the number of columns", "at least 1", 0));
    };
    let rank = |(i, column): (usize, &&[T])| {
        let name = format!("column {i}");
        check_length(call, &name, first.len(), column.len())?;
        Column::new(call, &name, column)
    };
    columns.iter().enumerate().map(rank).collect()
}

/// All columns as one. There's at least one.
pub(crate) fn joined(columns: &[Column]) -> Column {
    let constant = Column::constant(columns[0].n_rows());
    columns.iter().fold(constant, |joint, column| joint.join(column))
}
