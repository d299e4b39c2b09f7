//! Locomotion: how far the centre of gravity went along the heading.
//!
//! ```text
//! r_Loc,t = (x_t - x_{t-1})' d_t
//! ```
//!
//! with x the centre of gravity in the XY plane and d the XY part of the robot's axial direction,
//! read after the step and not normalised again. In m for each control step.

use config::{Rule, Section, or_word, within};
use serde::{Serialize, Serializer};

use super::Extrinsic;
use crate::Step;

/// What stands for the model's own factor.
const OF_MODEL: &str = "model";

/// Settings of locomotion.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LocomotionSettings {
    /// What a metre in a control step counts; None: what the model says.
    #[serde(serialize_with = "write_scale")]
    pub scale: Option<f64>,
}

impl LocomotionSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let scale = or_word(within(-1e50, 1e50), OF_MODEL).about(
            "what a metre in a control step counts; `\"model\"`: what the model says; negative: \
             backwards",
        );
        Some(Self { scale: section.or("scale", scale, None) })
    }
}

fn write_scale<S: Serializer>(scale: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    match scale {
        Some(scale) => serializer.serialize_f64(*scale),
        None => serializer.serialize_str(OF_MODEL),
    }
}

impl Extrinsic for LocomotionSettings {
    fn raw(&self, step: &Step<'_>) -> f64 {
        step.advance_m
    }

    fn factor(&self, locomotion_scale: f64) -> f64 {
        self.scale.unwrap_or(locomotion_scale)
    }

    fn symbol(&self) -> &'static str {
        "R_Loc"
    }

    fn unit(&self) -> &'static str {
        "m"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_model_sets_the_scale_unless_the_file_does() {
        assert_eq!(LocomotionSettings::default().factor(2.5), 2.5);
        assert_eq!(LocomotionSettings { scale: Some(-3.0) }.factor(2.5), -3.0);
    }
}
