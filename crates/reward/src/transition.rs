//! What a reward is told of a control step: the robot before it, the robot after it, and what was done
//! in between.
//!
//! Lengths are in m, angles in rad, times in s; vectors are in the world's frame, whose z is up. The
//! ground is at z = 0.

use nalgebra::{Isometry3, Point3, Vector3};

/// A robot at the end of a control step.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotState {
    /// `[n_bodies]`, in the model's order.
    pub bodies: Vec<BodyState>,
    /// The centre of gravity of the whole robot, in m.
    pub centre_of_gravity_m: Point3<f64>,
    /// The heading axis, of length 1.
    pub heading: Vector3<f64>,
    /// `[n_sensors]`: positions within -1 to 1, then contacts, 0 or 1.
    pub readings: Vec<f64>,
    /// `[n_bodies]`: which of them touch something that isn't the robot.
    pub contacts: Vec<bool>,
    /// How many of the bodies that had better not touch anything do.
    pub penalised_contacts: usize,
}

/// A body of a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyState {
    /// Centre of mass, and the body's frame as in the model.
    pub pose: Isometry3<f64>,
    /// The velocity of the centre of mass, in m/s.
    pub linear_velocity_m_s: Vector3<f64>,
    /// The angular velocity about the axes of the world, in rad/s.
    pub angular_velocity_rad_s: Vector3<f64>,
}

impl Default for RobotState {
    /// No bodies and no sensors at the origin, heading along x.
    fn default() -> Self {
        Self {
            bodies: Vec::new(),
            centre_of_gravity_m: Point3::origin(),
            heading: Vector3::x(),
            readings: Vec::new(),
            contacts: Vec::new(),
            penalised_contacts: 0,
        }
    }
}

/// A control step.
#[derive(Clone, Copy, Debug)]
pub struct Transition<'a> {
    /// Where it began.
    pub before: &'a RobotState,
    /// Where it ended.
    pub after: &'a RobotState,
    /// Each sensor's bin after it, `[n_sensors]`.
    pub bins: &'a [u64],
    /// What the servos were told, `[n_actuators]`, within -1 to 1.
    pub targets: &'a [f64],
    /// The mechanical work of each servo, in J, `[n_actuators]`: the sum over the physics steps of its
    /// torque times how far its axis turned, negative where it brakes. Empty if the task has
    /// [no need of it](crate::extrinsic::Build::needs_work).
    pub work_j: &'a [f64],
}

impl<'a> Transition<'a> {
    /// The step of a robot that nobody told anything, and whose readings and work aren't looked at.
    #[must_use]
    pub fn between(before: &'a RobotState, after: &'a RobotState) -> Self {
        Self { before, after, bins: &[], targets: &[], work_j: &[] }
    }

    /// How far the centre of gravity went along the heading after the step, in the XY plane, in m. The
    /// heading's part in that plane isn't normalised again.
    #[must_use]
    pub fn advance_m(&self) -> f64 {
        let moved = self.after.centre_of_gravity_m - self.before.centre_of_gravity_m;
        moved.xy().dot(&self.after.heading.xy())
    }

    /// How far the heading turned to the left, seen from above, in rad.
    #[must_use]
    pub fn heading_change_rad(&self) -> f64 {
        let (from, to) = (&self.before.heading, &self.after.heading);
        libm::atan2(from.x * to.y - from.y * to.x, from.x * to.x + from.y * to.y)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use super::*;

    #[test]
    fn turning_left_is_positive() {
        let before = RobotState::default();
        let turned = |heading| {
            let after = RobotState { heading, ..RobotState::default() };
            let transition = Transition::between(&before, &after);
            transition.heading_change_rad()
        };
        // A rounding.
        assert!((turned(Vector3::new(1.0, 1.0, 5.0)) - FRAC_PI_4).abs() < 1e-15);
        assert!(turned(Vector3::new(1.0, -0.1, 0.0)) < 0.0);
        assert_eq!(turned(Vector3::x()), 0.0);
    }
}
