//! The linear mix: r = xi e + (1 - xi) i.

use config::Section;
use serde::Serialize;

use super::{Mix, Xi};

/// Settings of the linear mix.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LinearSettings {
    /// Share of the extrinsic part.
    #[serde(flatten)]
    pub xi: Xi,
}

impl LinearSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        Some(Self { xi: Xi::read(section)? })
    }
}

impl Mix for LinearSettings {
    fn xi(&self) -> &Xi {
        &self.xi
    }

    fn mix(&self, xi: f64, extrinsic: f64, intrinsic: f64) -> f64 {
        xi * extrinsic + (1.0 - xi) * intrinsic
    }

    fn degree(&self) -> f64 {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_worked_by_hand() {
        let mix =
            |xi, extrinsic, intrinsic| LinearSettings::default().mix(xi, extrinsic, intrinsic);
        assert_eq!(mix(0.75, -0.5, 0.25), -0.3125);
        assert_eq!(mix(1.0, -0.5, 0.25), -0.5);
        assert_eq!(mix(0.0, -0.5, 0.25), 0.25);
    }

    #[test]
    fn one_percent_is_a_round_number() {
        assert_eq!(LinearSettings::default().one_percent(), 0.001);
    }
}
