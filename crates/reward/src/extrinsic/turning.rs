//! Turning: how far the heading turned to the left, in rad for each control step.

use config::{Rule, Section, within};
use serde::Serialize;

use super::Extrinsic;
use crate::Step;

/// Settings of turning.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TurningSettings {
    /// What a radian in a control step counts.
    pub scale: f64,
}

impl Default for TurningSettings {
    fn default() -> Self {
        Self { scale: 1.0 }
    }
}

impl TurningSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let scale = within(-1e50, 1e50)
            .about("what a radian in a control step counts; negative: to the right");
        Some(Self { scale: section.or("scale", scale, Self::default().scale) })
    }
}

impl Extrinsic for TurningSettings {
    fn raw(&self, step: &Step<'_>) -> f64 {
        step.heading_change_rad
    }

    fn factor(&self, _: f64) -> f64 {
        self.scale
    }

    fn symbol(&self) -> &'static str {
        "turning"
    }

    fn unit(&self) -> &'static str {
        "rad"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locomotion_counts_nothing() {
        let step =
            Step { bins: &[], advance_m: 5.0, heading_change_rad: 0.25, penalised_contacts: 0 };
        assert_eq!(TurningSettings::default().raw(&step), 0.25);
        assert_eq!(TurningSettings { scale: -2.0 }.factor(9.0), -2.0);
    }
}
