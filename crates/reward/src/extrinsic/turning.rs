//! Turning: how far the heading turned to the left, in rad for each control step.

use config::{Rule, Section, within};
use serde::Serialize;

use super::{Build, Extrinsic};
use crate::{Error, RobotLayout, Transition};

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

impl Build for TurningSettings {
    fn build(&self, _: &RobotLayout, _: u64) -> Result<Box<dyn Extrinsic>, Error> {
        Ok(Box::new(Turning))
    }

    fn factor(&self, _: &RobotLayout) -> f64 {
        self.scale
    }

    fn symbol(&self) -> &'static str {
        "turning"
    }

    fn unit(&self) -> &'static str {
        "rad"
    }
}

#[derive(Debug)]
struct Turning;

impl Extrinsic for Turning {
    fn value(&mut self, transition: &Transition<'_>) -> f64 {
        transition.heading_change_rad()
    }
}
