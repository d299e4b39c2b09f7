//! The robot in its world, as a cell has it: what is moved by targets and felt in readings.

use std::time::Instant;

use bullet::{SolverMode, World, WorldSettings};
use reward::{BodyState, RobotState};
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
    /// `[n_actuators]`, of the last control step; empty if nobody asks for it.
    work_j: Vec<f64>,
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
        let needs_work = experiment.reward.extrinsic.get().needs_work();
        world.measure_motors(needs_work);
        let mut body = Self {
            world,
            readings: Readings::default(),
            n_physics_steps: experiment.physics_steps_per_control_step(),
            pose_every: experiment.record.pose_every,
            n_bodies: morphology.bodies().len(),
            poses: Vec::new(),
            work_j: vec![0.0; if needs_work { robot.n_actuators() } else { 0 }],
            robot,
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
    fn after_physics_step(&mut self, step: u64) -> Result<(), svenja::Error> {
        if !self.work_j.is_empty() {
            self.robot.add_work(&self.world, &mut self.work_j)?;
        }
        if step.is_multiple_of(self.pose_every) {
            self.robot.update_poses(&self.world)?;
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

    /// Looks at the robot as it is now; `out` keeps its room.
    pub fn read_state(&self, out: &mut RobotState) {
        let parts = 0..self.n_bodies;
        out.bodies.clear();
        out.bodies.extend(parts.clone().map(|part| {
            let (linear_velocity_m_s, angular_velocity_rad_s) = self.robot.velocities(part);
            BodyState { pose: self.robot.pose(part), linear_velocity_m_s, angular_velocity_rad_s }
        }));
        out.centre_of_gravity_m = self.robot.centre_of_gravity_m();
        out.heading = self.robot.heading();
        out.readings.clone_from(&self.readings.values);
        out.contacts.clear();
        out.contacts.extend(parts.map(|part| self.robot.touches(part)));
        out.penalised_contacts = self.robot.n_penalised_contacts();
    }

    /// The mechanical work of each servo in the last control step, in J: `[n_actuators]`, or none if the
    /// task has no need of it.
    #[must_use]
    pub fn work_j(&self) -> &[f64] {
        &self.work_j
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
pub(super) fn simulate(
    bodies: &mut [&mut Body],
    solver: &mut Solver,
) -> Vec<Result<(), svenja::Error>> {
    let n_physics_steps = bodies.first().map_or(0, |body| body.n_physics_steps);
    let mut results: Vec<_> = bodies.iter().map(|_| Ok(())).collect();
    for body in bodies.iter_mut() {
        body.poses.clear();
        body.work_j.fill(0.0);
    }
    for step in 1..=n_physics_steps {
        let start = Instant::now();
        let mut healthy: Vec<_> =
            bodies.iter_mut().zip(&mut results).filter(|(_, result)| result.is_ok()).collect();
        for (body, result) in &mut healthy {
            **result = body.robot.drive(&mut body.world);
        }
        healthy.retain(|(_, result)| result.is_ok());
        let mut worlds: Vec<&mut World> =
            healthy.iter_mut().map(|(body, _)| &mut body.world).collect();
        let stepped = solver.step(&mut worlds);
        solver.spent_since(start);
        for ((body, result), stepped) in healthy.into_iter().zip(stepped) {
            *result = stepped
                .map_err(|error| body.robot.explain(error))
                .and_then(|()| body.after_physics_step(step));
        }
    }
    for (body, result) in bodies.iter_mut().zip(&mut results) {
        if result.is_ok() {
            *result = body.sense();
        }
    }
    results
}
