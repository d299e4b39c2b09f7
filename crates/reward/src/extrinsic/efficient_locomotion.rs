//! Efficient locomotion: metres along the heading, less a price for each joule that the servos spend.
//!
//! ```text
//! r_t = (x_t - x_{t-1})' d_t - price * sum_a max(0, w_{a,t})
//! ```
//!
//! with the displacement of [`locomotion`](super::LocomotionSettings) and w the mechanical work of
//! servo a in the control step. A servo that brakes in the sum over the step gives nothing back. In m
//! for each control step.

use config::{Rule, Section, at_least};
use serde::Serialize;

use super::{Build, Extrinsic, model_scale};
use crate::{Error, RobotLayout, Transition};

/// Settings of efficient locomotion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EfficientLocomotionSettings {
    /// What a metre in a control step counts; by default what the model says, `"model"`. Negative: the
    /// other way round, with work as a gain.
    #[serde(serialize_with = "model_scale::write")]
    pub scale: Option<f64>,
    /// What a joule costs, in m; 2e-5, which is a few mm for what Svenja spends in a control step.
    pub price_m_per_j: f64,
}

impl Default for EfficientLocomotionSettings {
    fn default() -> Self {
        Self { scale: None, price_m_per_j: 2e-5 }
    }
}

impl EfficientLocomotionSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let price = at_least(0.0).up_to(1e50).about(
            "what a joule costs, in m: of each servo's mechanical work in the control step, its torque \
             times how far its axis turns; one that brakes in the sum gives nothing back. Svenja spends \
             some 100 J in a control step of random actions",
        );
        Some(Self {
            scale: model_scale::read(section),
            price_m_per_j: section.or("price_m_per_j", price, Self::default().price_m_per_j),
        })
    }
}

impl Build for EfficientLocomotionSettings {
    fn build(&self, _: &RobotLayout, _: u64) -> Result<Box<dyn Extrinsic>, Error> {
        Ok(Box::new(EfficientLocomotion { price_m_per_j: self.price_m_per_j }))
    }

    fn factor(&self, layout: &RobotLayout) -> f64 {
        model_scale::factor(self.scale, layout)
    }

    fn symbol(&self) -> &'static str {
        "R_Eff"
    }

    fn unit(&self) -> &'static str {
        "m"
    }

    fn needs_work(&self) -> bool {
        true
    }
}

#[derive(Debug)]
struct EfficientLocomotion {
    price_m_per_j: f64,
}

impl Extrinsic for EfficientLocomotion {
    fn value(&mut self, transition: &Transition<'_>) -> f64 {
        let spent_j: f64 = transition.work_j.iter().map(|work| work.max(0.0)).sum();
        transition.advance_m() - self.price_m_per_j * spent_j
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::RobotState;

    #[test]
    fn joules_cost_metres_and_braking_gives_none_back() {
        let settings = EfficientLocomotionSettings { price_m_per_j: 0.125, ..Default::default() };
        let mut task = settings.build(&RobotLayout::default(), 1).unwrap();
        let before = RobotState::default();
        let mut after = RobotState::default();
        after.centre_of_gravity_m.x = 2.0;
        let work_j = [3.0, -5.0, 1.0];
        let step = Transition { work_j: &work_j, ..Transition::between(&before, &after) };
        assert_eq!(task.value(&step), 2.0 - 0.125 * 4.0);
    }
}
