//! The geometric mix:
//!
//! ```text
//! r = sign(e) ( |e|^xi i^(1-xi) )^power,   0^0 = 1, sign(0) = 0
//! ```
//!
//! of the paper's main text (power 2) and of its experiments with information by legs (power 1).
//! Either part at 0 makes r 0, but for xi = 1 and xi = 0, where the other one has no say. At xi = 0
//! the formula still has the sign of e, and so has r unless `sign_at_zero_xi` is false.

use config::{Rule, Section, flag, within};
use serde::Serialize;

use super::{Mix, Xi};

/// Settings of the geometric mix.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GeometricSettings {
    /// Share of the extrinsic part.
    #[serde(flatten)]
    pub xi: Xi,
    /// The power of the whole.
    pub power: f64,
    /// Whether r keeps the sign of the extrinsic part at xi = 0.
    pub sign_at_zero_xi: bool,
}

impl Default for GeometricSettings {
    fn default() -> Self {
        Self { xi: Xi::default(), power: 2.0, sign_at_zero_xi: true }
    }
}

impl GeometricSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let default = Self::default();
        let xi = Xi::read(section);
        let power = within(0.01, 100.0).about("the power of the whole");
        let sign_at_zero_xi = flag().about("whether the sign of e stays at xi = 0");
        Some(Self {
            power: section.or("power", power, default.power),
            sign_at_zero_xi: section.or(
                "sign_at_zero_xi",
                sign_at_zero_xi,
                default.sign_at_zero_xi,
            ),
            xi: xi?,
        })
    }
}

impl Mix for GeometricSettings {
    fn xi(&self) -> &Xi {
        &self.xi
    }

    fn mix(&self, xi: f64, extrinsic: f64, intrinsic: f64) -> f64 {
        let mean = libm::pow(extrinsic.abs(), xi) * libm::pow(intrinsic, 1.0 - xi);
        let magnitude = libm::pow(mean, self.power);
        if xi == 0.0 && !self.sign_at_zero_xi { magnitude } else { sign(extrinsic) * magnitude }
    }

    fn degree(&self) -> f64 {
        self.power
    }
}

/// -1, 0 or 1; NaN of NaN. (`f64::signum` has no 0.)
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mix(power: f64, xi: f64, extrinsic: f64, intrinsic: f64) -> f64 {
        GeometricSettings { power, ..Default::default() }.mix(xi, extrinsic, intrinsic)
    }

    /// By hand: sqrt(0.04 * 0.09) = 0.06; 16^(3/4) = 8; 81^(1/4) = 3.
    #[test]
    fn values_worked_by_hand() {
        for (power, xi, extrinsic, intrinsic, expected) in [
            (1.0, 0.5, 0.04, 0.09, 0.06),
            (1.0, 0.5, -0.04, 0.09, -0.06),
            (2.0, 0.5, 0.04, 0.09, 0.0036),
            (2.0, 0.5, -0.04, 0.09, -0.0036),
            (1.0, 0.75, 16.0, 81.0, 24.0),
            (2.0, 0.75, -16.0, 81.0, -576.0),
        ] {
            let found = mix(power, xi, extrinsic, intrinsic);
            // Powers of libm are right to an ulp or so; four of them here.
            assert!((found - expected).abs() <= 4.0 * f64::EPSILON * expected.abs(), "{found}");
        }
    }

    #[test]
    fn at_the_ends_the_other_part_has_no_say() {
        assert_eq!(mix(1.0, 1.0, 0.04, 0.0), 0.04);
        assert_eq!(mix(1.0, 1.0, -0.04, 7.0), -0.04);
        assert_eq!(mix(1.0, 0.0, 1e-300, 0.04), 0.04);
        assert_eq!(mix(1.0, 0.0, -1e-300, 0.04), -0.04);
    }

    #[test]
    fn zero_to_the_zero_is_one_and_the_sign_of_zero_is_zero() {
        assert_eq!(mix(2.0, 1.0, 0.5, 0.0), 0.25);
        assert_eq!(mix(2.0, 0.0, 0.0, 0.5), 0.0);
        assert_eq!(mix(2.0, 1.0, 0.0, 0.0), 0.0);
        assert_eq!(mix(2.0, 0.5, 0.5, 0.0), 0.0);
    }

    #[test]
    fn the_sign_can_be_dropped_at_zero_xi_and_only_there() {
        let unsigned = GeometricSettings { sign_at_zero_xi: false, ..Default::default() };
        assert_eq!(unsigned.mix(0.0, -0.1, 0.5), 0.25);
        assert_eq!(unsigned.mix(0.0, 0.0, 0.5), 0.25);
        assert!(unsigned.mix(0.25, -0.1, 0.5) < 0.0);
    }

    #[test]
    fn one_percent_is_a_round_number() {
        let of = |power| GeometricSettings { power, ..Default::default() }.one_percent();
        assert_eq!((of(2.0), of(1.0)), (0.0001, 0.001));
    }
}
