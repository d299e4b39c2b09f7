//! Extrinsic rewards: the task.

mod efficient_locomotion;
mod height;
mod locomotion;
mod model_scale;
mod reach;
mod turning;

pub use efficient_locomotion::EfficientLocomotionSettings;
pub use height::HeightSettings;
pub use locomotion::LocomotionSettings;
pub use reach::ReachSettings;
pub use turning::TurningSettings;

use std::fmt::Debug;

use super::{Error, RobotLayout, Transition, kinds::kinds};

/// Makes a task of its settings.
pub trait Build {
    /// For this robot. Whatever is drawn is drawn from a stream of the seed that has a name of its own.
    ///
    /// # Errors
    /// Settings that don't fit the robot.
    fn build(&self, layout: &RobotLayout, seed: u64) -> Result<Box<dyn Extrinsic>, Error>;

    /// What the task's value is multiplied by, for a maximum of about 0.1.
    fn factor(&self, layout: &RobotLayout) -> f64;

    /// What the task's value is called on axes and in tables.
    fn symbol(&self) -> &'static str;

    /// The unit of the task's value.
    fn unit(&self) -> &'static str;

    /// Whether it asks for [`Transition::work_j`], which takes time to measure.
    fn needs_work(&self) -> bool {
        false
    }
}

/// Sees control steps and tells what they are worth.
pub trait Extrinsic: Debug + Send {
    /// What a control step achieved, in the task's own unit.
    fn value(&mut self, transition: &Transition<'_>) -> f64;

    /// All that changes, for [`Extrinsic::restore`]: as many words at any time, and none for a task
    /// without a memory.
    fn save(&self) -> Vec<u64> {
        Vec::new()
    }

    /// Goes back to a state with the same settings and layout.
    ///
    /// # Errors
    /// A state of others. Nothing has changed then.
    fn restore(&mut self, state: &[u64]) -> Result<(), Error> {
        Error::expect_no_state(state)
    }
}

kinds! {
    /// The task, with its settings: the list of all there are.
    ExtrinsicSettings, dyn Build, "reward.extrinsic" ("the task"):
    /// Locomotion: displacement of the centre of gravity in the XY plane times the XY part of the heading
    /// axis after the step, in m for each control step. That part isn't normalised: where the body
    /// pitches by an angle a, the same way counts cos a.
    "locomotion" => Locomotion(LocomotionSettings),
    /// Turning: change of the heading to the left, in rad for each control step.
    "turning" => Turning(TurningSettings),
    /// Reaching: how much nearer the centre of gravity came to a point in the XY plane, which is drawn
    /// anew when it's reached, in m for each control step.
    "reach" => Reach(ReachSettings),
    /// Efficient locomotion: that of `locomotion`, less a price for the joules that the servos spend, in m
    /// for each control step.
    "efficient_locomotion" => EfficientLocomotion(EfficientLocomotionSettings),
    /// Height: of a body's centre of mass above the ground, z = 0, after the step, in m.
    "height" => Height(HeightSettings),
}
