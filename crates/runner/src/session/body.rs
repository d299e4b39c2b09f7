//! The robot in its world, as a cell has it: what is moved by targets and felt in readings.

use std::time::Instant;

use bullet::{SolverMode, World, WorldSettings};
use nalgebra::{Point3, Vector3};
use reward::Step;
use svenja::{Morphology, Readings, Robot, add_ground};

use super::Solver;
use crate::experiment::Experiment;

/// A robot on the ground of a world of its own.
#[derive(Debug)]
pub struct Body {
    world: World,
    robot: Robot,
    readings: Readings,
    /// Physics steps in a control step.
    n_physics_steps: u64,
    /// Physics steps from one recorded pose to the next.
    pose_every: u64,
    n_bodies: usize,
    /// `[frames_per_step x n_bodies x 7]`, of the last control step.
    poses: Vec<f32>,
}

impl Body {
    /// The robot where its model starts.
    ///
    /// # Errors
    /// What the world refuses.
    pub fn new(experiment: &Experiment, morphology: &Morphology) -> Result<Self, svenja::Error> {
        let physics = &experiment.physics;
        let warm = SolverMode::WARM_STARTING;
        let mode = SolverMode::default();
        let mut world = World::new(&WorldSettings {
            time_step: 1.0 / physics.frequency_hz,
            iterations: physics.iterations,
            solver_mode: if physics.warm_starting { mode | warm } else { mode - warm },
            ..WorldSettings::default()
        })?;
        add_ground(&mut world)?;
        let robot = Robot::spawn(morphology, &mut world)?;
        let mut body = Self {
            world,
            robot,
            readings: Readings::default(),
            n_physics_steps: experiment.physics_steps_per_control_step(),
            pose_every: experiment.record.pose_every,
            n_bodies: morphology.bodies().len(),
            poses: Vec::new(),
        };
        body.sense()?;
        Ok(body)
    }

    /// Sets targets, `[n_actuators]`, to be held until others are.
    ///
    /// # Errors
    /// Targets that aren't.
    pub fn actuate(&mut self, targets: &[f64]) -> Result<(), svenja::Error> {
        self.robot.actuate(targets)
    }

    /// The world after a physics step of a control step, counted from 1.
    fn look(&mut self, step: u64) -> Result<(), svenja::Error> {
        if step.is_multiple_of(self.pose_every) {
            self.robot.look(&self.world)?;
            self.record_poses();
        }
        Ok(())
    }

    fn sense(&mut self) -> Result<(), svenja::Error> {
        self.robot.sense(&self.world, &mut self.readings)
    }

    fn record_poses(&mut self) {
        for part in 0..self.n_bodies {
            let pose = self.robot.pose(part);
            let (t, q) = (pose.translation.vector, pose.rotation.coords);
            self.poses.extend([t.x, t.y, t.z, q.x, q.y, q.z, q.w].map(|value| value as f32));
        }
    }

    /// `[frames_per_step x n_bodies x 7]`, of the last control step: x y z in m, quaternion x y z w.
    #[must_use]
    pub fn poses(&self) -> &[f32] {
        &self.poses
    }

    /// The newest readings.
    #[must_use]
    pub fn readings(&self) -> &Readings {
        &self.readings
    }

    /// Where the robot is now.
    #[must_use]
    pub fn whereabouts(&self) -> Whereabouts {
        Whereabouts {
            centre_of_gravity_m: self.robot.centre_of_gravity_m(),
            heading: self.robot.heading(),
        }
    }

    /// What a control step did that began somewhere and ended here, with this reading's bins.
    #[must_use]
    pub fn step_since<'a>(&self, before: &Whereabouts, bins: &'a [u64]) -> Step<'a> {
        let now = self.whereabouts();
        let moved = now.centre_of_gravity_m - before.centre_of_gravity_m;
        Step {
            bins,
            advance_m: moved.xy().dot(&now.heading.xy()),
            heading_change_rad: turned(&before.heading, &now.heading),
            penalised_contacts: self.robot.n_penalised_contacts(),
        }
    }

    /// Which bodies touch something, 1 or 0 each, in the model's order.
    pub fn contacts(&self) -> impl Iterator<Item = u8> + '_ {
        (0..self.n_bodies).map(|part| u8::from(self.robot.touches(part)))
    }

    /// The world's state, for [`Body::restore`].
    ///
    /// # Errors
    /// A world that blew up.
    pub fn save(&mut self) -> Result<Vec<u8>, bullet::Error> {
        let mut bytes = Vec::new();
        self.world.snapshot(&mut bytes)?;
        Ok(bytes)
    }

    /// Goes on from a saved state, with the same bits.
    ///
    /// # Errors
    /// Bytes of another world.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), svenja::Error> {
        self.world.restore(bytes)?;
        self.sense()
    }
}

/// Lets bodies with the same physics hold their targets for a control step, all in step. What
/// becomes of one doesn't touch the others.
pub(super) fn hold(
    bodies: &mut [&mut Body],
    solver: &mut Solver,
) -> Vec<Result<(), svenja::Error>> {
    let n_physics_steps = bodies.first().map_or(0, |body| body.n_physics_steps);
    let mut results: Vec<_> = bodies.iter().map(|_| Ok(())).collect();
    bodies.iter_mut().for_each(|body| body.poses.clear());
    for step in 1..=n_physics_steps {
        let start = Instant::now();
        let mut well: Vec<_> =
            bodies.iter_mut().zip(&mut results).filter(|(_, result)| result.is_ok()).collect();
        for (body, result) in &mut well {
            **result = body.robot.drive(&mut body.world);
        }
        well.retain(|(_, result)| result.is_ok());
        let mut worlds: Vec<&mut World> =
            well.iter_mut().map(|(body, _)| &mut body.world).collect();
        let stepped = solver.step(&mut worlds);
        solver.spent_since(start);
        for ((body, result), stepped) in well.into_iter().zip(stepped) {
            *result =
                stepped.map_err(|error| body.robot.explain(error)).and_then(|()| body.look(step));
        }
    }
    for (body, result) in bodies.iter_mut().zip(&mut results) {
        if result.is_ok() {
            *result = body.sense();
        }
    }
    results
}

/// Where a robot is, and where it heads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whereabouts {
    /// The centre of gravity of the whole robot, in m.
    pub centre_of_gravity_m: Point3<f64>,
    /// The heading axis in space, of length 1.
    pub heading: Vector3<f64>,
}

/// How far a heading turned to the left, in rad, seen from above.
fn turned(from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    libm::atan2(from.x * to.y - from.y * to.x, from.x * to.x + from.y * to.y)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use super::*;

    #[test]
    fn turning_left_is_positive() {
        let x = Vector3::x();
        // A rounding.
        assert!((turned(&x, &Vector3::new(1.0, 1.0, 5.0)) - FRAC_PI_4).abs() < 1e-15);
        assert!(turned(&x, &Vector3::new(1.0, -0.1, 0.0)) < 0.0);
        assert_eq!(turned(&x, &x), 0.0);
    }
}
