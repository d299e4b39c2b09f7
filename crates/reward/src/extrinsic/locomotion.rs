//! Locomotion: how far the centre of gravity went along the heading.
//!
//! ```text
//! r_Loc,t = (x_t - x_{t-1})' d_t
//! ```
//!
//! with x the centre of gravity in the XY plane and d the XY part of the robot's axial direction,
//! read after the step and not normalised again. In m for each control step.

use config::Section;
use serde::Serialize;

use super::{Build, Extrinsic, model_scale};
use crate::{Error, RobotLayout, Transition};

/// Settings of locomotion.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LocomotionSettings {
    /// What a metre in a control step counts; by default what the model says, `"model"`. Negative:
    /// walking backwards.
    #[serde(serialize_with = "model_scale::write")]
    pub scale: Option<f64>,
}

impl LocomotionSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        Some(Self { scale: model_scale::read(section) })
    }
}

impl Build for LocomotionSettings {
    fn build(&self, _: &RobotLayout, _: u64) -> Result<Box<dyn Extrinsic>, Error> {
        Ok(Box::new(Locomotion))
    }

    fn factor(&self, layout: &RobotLayout) -> f64 {
        model_scale::factor(self.scale, layout)
    }

    fn symbol(&self) -> &'static str {
        "R_Loc"
    }

    fn unit(&self) -> &'static str {
        "m"
    }
}

#[derive(Debug)]
struct Locomotion;

impl Extrinsic for Locomotion {
    fn value(&mut self, transition: &Transition<'_>) -> f64 {
        transition.advance_m()
    }
}
