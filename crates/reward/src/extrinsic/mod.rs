//! Extrinsic rewards: the task.

mod locomotion;
mod turning;

pub use locomotion::LocomotionSettings;
pub use turning::TurningSettings;

use super::{Step, kinds::kinds};

/// A task.
pub trait Extrinsic {
    /// What a control step achieved, in the task's own unit.
    fn raw(&self, step: &Step<'_>) -> f64;

    /// What `raw` is multiplied by, for a maximum of about 0.1. `locomotion_scale` is the model's
    /// own factor for metres of locomotion.
    fn factor(&self, locomotion_scale: f64) -> f64;

    /// What `raw` is called on axes and in tables.
    fn symbol(&self) -> &'static str;

    /// Of `raw`.
    fn unit(&self) -> &'static str;
}

kinds! {
    /// The task, with its settings: the list of all there are.
    ExtrinsicSettings, dyn Extrinsic, "reward.extrinsic" ("the task"):
    /// Locomotion: displacement of the centre of gravity in the XY plane times the XY part of the heading
    /// axis after the step, in m for each control step. That part isn't normalised: where the body
    /// pitches by an angle a, the same way counts cos a.
    "locomotion" => Locomotion(LocomotionSettings),
    /// Turning: change of the heading to the left, in rad for each control step.
    "turning" => Turning(TurningSettings),
}
