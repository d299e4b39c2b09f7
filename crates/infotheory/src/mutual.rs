//! Information that variables share.
//!
//! ```text
//! mutual information       I(X; Y)   = H(X) + H(Y) - H(X, Y)
//! conditional              I(X; Y|Z) = H(X, Z) + H(Y, Z) - H(X, Y, Z) - H(Z)
//! multi-information        sum_i H(X_i) - H(X_1, ..., X_m)
//! ```
//!
//! T. Cover and J. Thomas, *Elements of Information Theory*, sections 2.3 to 2.5; multi-information
//! (total correlation) after S. Watanabe, *Information theoretical analysis of multivariate
//! correlation* (1960). The Miller-Madow corrections in nats, K counting the states that occur:
//!
//! ```text
//! I(X; Y)            (K_x + K_y - K_xy - 1) / 2n
//! I(X; Y|Z)          (K_xz + K_yz - K_xyz - K_z) / 2n
//! multi-information  (sum_i K_i - K_all - (m - 1)) / 2n
//! ```

use crate::{
    column::Column,
    entropy::{joined, ranked},
    error::{Error, check_length},
    information::{Estimator, Information, signed_entropies},
};

/// Information that X and Y have on each other, I(X; Y) = H(X) + H(Y) - H(X, Y). The slices are
/// equally long, 1 to 2^32 - 1.
///
/// Correction: (K_x + K_y - K_xy - 1) / 2n, for the states and pairs of states that occur.
pub fn mutual_information<X: Copy + Ord, Y: Copy + Ord>(
    x: &[X],
    y: &[Y],
    estimator: Estimator,
) -> Result<Information, Error> {
    const CALL: &str = "mutual_information";
    check_length(CALL, "y", x.len(), y.len())?;
    let (x, y) = (Column::new(CALL, "x", x)?, Column::new(CALL, "y", y)?);
    Ok(signed_entropies(x.n_rows(), &[(1, &x), (1, &y), (-1, &x.join(&y))], estimator))
}

/// Information that X and Y have on each other when Z is known, I(X; Y|Z). The slices are equally
/// long, 1 to 2^32 - 1. Several conditions are one of tuples, or of codes from
/// [`MixedRadix`](crate::MixedRadix).
///
/// It's H(X, Z) + H(Y, Z) - H(X, Y, Z) - H(Z); the correction (K_xz + K_yz - K_xyz - K_z) / 2n.
pub fn conditional_mutual_information<X: Copy + Ord, Y: Copy + Ord, Z: Copy + Ord>(
    x: &[X],
    y: &[Y],
    z: &[Z],
    estimator: Estimator,
) -> Result<Information, Error> {
    let triple = Triple::new("conditional_mutual_information", x, y, z)?;
    Ok(triple.information(estimator))
}

/// Information in m >= 1 variables beyond what they hold one by one; for two variables their
/// mutual information. It's sum_i H(X_i) - H(X_1, ..., X_m); the correction
/// (sum_i K_i - K_all - (m - 1)) / 2n.
///
/// `columns`: \[m\] slices of equal length
pub fn multi_information<T: Copy + Ord>(
    columns: &[&[T]],
    estimator: Estimator,
) -> Result<Information, Error> {
    let columns = ranked("multi_information", columns)?;
    let joint = joined(&columns);
    let mut terms: Vec<(i32, &Column)> = columns.iter().map(|column| (1, column)).collect();
    terms.push((-1, &joint));
    Ok(signed_entropies(joint.n_rows(), &terms, estimator))
}

/// Three columns of equal length, in the roles that they have in I(X; Y|Z).
pub(crate) struct Triple {
    pub(crate) x: Column,
    pub(crate) y: Column,
    pub(crate) z: Column,
}

impl Triple {
    pub(crate) fn new<X: Copy + Ord, Y: Copy + Ord, Z: Copy + Ord>(
        call: &'static str,
        x: &[X],
        y: &[Y],
        z: &[Z],
    ) -> Result<Self, Error> {
        check_length(call, "y", x.len(), y.len())?;
        check_length(call, "z", x.len(), z.len())?;
        Ok(Self {
            x: Column::new(call, "x", x)?,
            y: Column::new(call, "y", y)?,
            z: Column::new(call, "z", z)?,
        })
    }

    pub(crate) fn information(&self, estimator: Estimator) -> Information {
        let (xz, yz) = (self.x.join(&self.z), self.y.join(&self.z));
        let xyz = self.x.join(&yz);
        let terms = [(1, &xz), (1, &yz), (-1, &xyz), (-1, &self.z)];
        signed_entropies(self.x.n_rows(), &terms, estimator)
    }
}
