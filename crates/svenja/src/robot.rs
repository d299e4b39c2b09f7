//! A robot in a world: a morphology built, sensed and actuated.

use bullet::{BodyId, BodyState, Contact, JointId, MotorState, World};
use nalgebra::{Isometry3, Point3, Vector3};

use crate::{
    Morphology,
    axes::Axes,
    build::{Part, add_body, add_joint},
    centre_of_gravity_m,
};

/// What a robot refused, or what its world did.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Targets that aren't.
    #[error("actuate: {argument} must be {expected}, got {value}")]
    Target {
        /// The argument, or the part of it.
        argument: String,
        /// What it should be.
        expected: String,
        /// What it was.
        value: String,
    },
    /// A part of the robot blew up.
    #[error("{cause} (body '{body}'{})", joint.as_ref().map(|j| format!(" of joint '{j}'")).unwrap_or_default())]
    BlewUp {
        /// The body's name.
        body: String,
        /// The joint that has it as its child, if there is one.
        joint: Option<String>,
        /// What the world says.
        cause: Box<bullet::Error>,
    },
    /// A world that the robot isn't in.
    #[error("this world doesn't have the robot's bodies and joints")]
    OtherWorld,
    /// Something else about the world.
    #[error(transparent)]
    World(#[from] bullet::Error),
}

/// What a robot senses, in the order of the morphology.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Readings {
    /// `[n_sensors + n_contacts]`: positions, each within -1 to 1 over its range, then contacts, 0
    /// or 1.
    pub values: Vec<f64>,
    /// `[n_sensors]`: whether the position was beyond its range, and is clipped.
    pub clipped: Vec<bool>,
}

impl Readings {
    /// How many positions were beyond their range.
    #[must_use]
    pub fn n_clipped(&self) -> usize {
        self.clipped.iter().filter(|&&clipped| clipped).count()
    }
}

/// Adds ground at z = 0 with friction 1, so that a contact has the friction of the robot's part.
///
/// # Errors
/// What the world refuses.
pub fn add_ground(world: &mut World) -> Result<BodyId, bullet::Error> {
    let shape = world.add_shape(&bullet::Shape::ground())?;
    world.add_body(&bullet::Body {
        friction: 1.0,
        ..bullet::Body::fixed(shape, Isometry3::identity())
    })
}

/// A robot in a world.
#[derive(Debug)]
pub struct Robot {
    parts: Vec<Part>,
    /// The index of each of the world's bodies among the parts.
    part_of_slot: Vec<Option<usize>>,
    joints: Vec<JointId>,
    joint_names: Vec<(String, usize)>,
    axes: Axes,
    contacts: Vec<usize>,
    penalised: Vec<usize>,
    heading: (usize, Vector3<f64>),
    touch_distance_m: f64,
    /// Buffers.
    states: Vec<BodyState>,
    contact_points: Vec<Contact>,
    touching: Vec<bool>,
    motors: Vec<MotorState>,
}

impl Robot {
    /// Builds a robot in its start pose. Its servos hold the neutral command, which for those of position
    /// is the middle of their ranges, until [`Robot::actuate`].
    ///
    /// # Errors
    /// What the world refuses. It then has some parts of the robot.
    pub fn spawn(morphology: &Morphology, world: &mut World) -> Result<Self, Error> {
        let mut parts = Vec::new();
        let mut part_of_slot = Vec::new();
        for (index, body) in morphology.bodies().iter().enumerate() {
            let part = add_body(body, morphology, world)?;
            part_of_slot.resize(part.id.index() + 1, None);
            part_of_slot[part.id.index()] = Some(index);
            parts.push(part);
        }
        for &[a, b] in morphology.no_collision() {
            world.keep_apart(parts[a].id, parts[b].id)?;
        }
        let mut joints = Vec::new();
        for joint in morphology.joints() {
            joints.push(add_joint(joint, morphology, &parts, world)?);
        }
        let heading = morphology.heading();
        let mut robot = Self {
            touching: vec![false; parts.len()],
            parts,
            part_of_slot,
            axes: Axes::new(morphology, &joints),
            joints,
            joint_names: morphology.joints().iter().map(|j| (j.name.clone(), j.child)).collect(),
            contacts: morphology.contacts().to_vec(),
            penalised: morphology.penalised().to_vec(),
            heading: (heading.body, heading.axis.into_inner()),
            touch_distance_m: morphology.touch_distance_m(),
            states: Vec::new(),
            contact_points: Vec::new(),
            motors: Vec::new(),
        };
        robot.update_poses(world)?;
        Ok(robot)
    }

    /// Looks at the bodies alone: at their poses, the centre of gravity and the heading, not at
    /// joints and contacts.
    ///
    /// # Errors
    /// As [`Robot::sense`].
    pub fn update_poses(&mut self, world: &World) -> Result<(), Error> {
        world.read_bodies(&mut self.states)?;
        let n_slots = self.part_of_slot.len();
        if self.states.len() < n_slots {
            self.states.resize(n_slots, BodyState::default());
            return Err(Error::OtherWorld);
        }
        Ok(())
    }

    /// Looks at the world as it is now; the readings are put into `out`, which keeps its room. What
    /// [`Robot::centre_of_gravity_m`] and the other methods after it tell is of this moment, too.
    ///
    /// # Errors
    /// A world without the robot; what the world says of its state.
    pub fn sense(&mut self, world: &World, out: &mut Readings) -> Result<(), Error> {
        self.update_poses(world)?;
        self.axes.update(world)?;
        world.read_contacts(&mut self.contact_points)?;
        self.update_contacts();

        self.axes.sense(out);
        let touches = self.contacts.iter().map(|&part| f64::from(u8::from(self.touching[part])));
        out.values.extend(touches);
        Ok(())
    }

    /// A part touches if something that isn't the robot is near enough.
    fn update_contacts(&mut self) {
        self.touching.fill(false);
        let part = |id: BodyId| self.part_of_slot.get(id.index()).copied().flatten();
        for contact in &self.contact_points {
            if contact.distance < self.touch_distance_m {
                match (part(contact.a), part(contact.b)) {
                    (Some(touching), None) | (None, Some(touching)) => {
                        self.touching[touching] = true;
                    }
                    _ => {}
                }
            }
        }
    }

    /// Sets the commands of all servos, `[n_actuators]`, each within -1 to 1: over an axis' range for one
    /// of position, else the share of its limit. [`Robot::drive`] then holds them.
    ///
    /// # Errors
    /// Another number of targets, or one that's NaN or beyond; the targets are then as before.
    pub fn actuate(&mut self, targets: &[f64]) -> Result<(), Error> {
        let refused = |argument: &str, expected: String, value: String| {
            Err(Error::Target { argument: argument.into(), expected, value })
        };
        if targets.len() != self.n_actuators() {
            let expected = format!("{} targets", self.n_actuators());
            return refused("targets", expected, targets.len().to_string());
        }
        if let Some(i) = targets.iter().position(|target| !(-1.0..=1.0).contains(target)) {
            let value = targets[i].to_string();
            return refused(&format!("targets[{i}]"), "from -1 to 1".into(), value);
        }
        self.axes.actuate(targets);
        Ok(())
    }

    /// Applies the [servos' law](crate::servo_command) to all servos, and what resists to all axes: once
    /// before each physics step.
    ///
    /// # Errors
    /// What the world refuses.
    pub fn drive(&mut self, world: &mut World) -> Result<(), Error> {
        self.axes.update(world)?;
        Ok(world.set_motors(self.axes.commands())?)
    }

    /// Drives and steps `n` times: a control step of `n` physics steps.
    ///
    /// # Errors
    /// [`Error::BlewUp`] with the part's name, if the simulation does.
    pub fn step(&mut self, world: &mut World, n: usize) -> Result<(), Error> {
        for _ in 0..n {
            self.drive(world)?;
            world.step().map_err(|error| self.explain(error))?;
        }
        Ok(())
    }

    /// Adds the mechanical work of each servo in the last physics step to `work_j`, `[n_actuators]`, in
    /// J: its torque times how far its axis turned, negative where it brakes. With it counts what
    /// [resists](crate::Resistance) that axis, which one motor does together with the servo.
    ///
    /// # Errors
    /// A world without the robot, or one that doesn't [measure](World::measure_motors).
    pub fn add_work(&mut self, world: &World, work_j: &mut [f64]) -> Result<(), Error> {
        world.read_motors_of(self.axes.driven(), &mut self.motors).map_err(other_world)?;
        for ((work_j, motor), place) in work_j.iter_mut().zip(&self.motors).zip(self.axes.places())
        {
            *work_j += motor.work[place.index()];
        }
        Ok(())
    }

    /// Names the part that an error of the world is about.
    #[must_use]
    pub fn explain(&self, error: bullet::Error) -> Error {
        let bullet::Error::BlewUp { body, .. } = &error else { return Error::World(error) };
        let Some(&Some(part)) = self.part_of_slot.get(body.index()) else {
            return Error::World(error);
        };
        let joint = self.joint_names.iter().find(|(_, child)| *child == part);
        Error::BlewUp {
            body: self.parts[part].name.clone(),
            joint: joint.map(|(name, _)| name.clone()),
            cause: Box::new(error),
        }
    }

    /// Mass-weighted mean of all parts' positions, in m.
    #[must_use]
    pub fn centre_of_gravity_m(&self) -> Point3<f64> {
        centre_of_gravity_m(
            self.parts
                .iter()
                .map(|part| (part.mass_kg, Vector3::from(self.states[part.id.index()].position))),
        )
    }

    /// The heading axis in the world, of length 1. Its x and y are the paper's d_t.
    #[must_use]
    pub fn heading(&self) -> Vector3<f64> {
        let (body, axis) = &self.heading;
        let part = &self.parts[*body];
        let axis = part.model_frame * axis;
        self.states[part.id.index()].direction(&axis)
    }

    /// How many of the penalised parts touch something.
    #[must_use]
    pub fn n_penalised_contacts(&self) -> usize {
        self.penalised.iter().filter(|&&part| self.touching[part]).count()
    }

    /// Whether a part, by its index in the morphology, touches something that isn't the robot.
    #[must_use]
    pub fn touches(&self, part: usize) -> bool {
        self.touching[part]
    }

    /// Pose of a part, by its index in the morphology: its centre of mass, and its frame as in the
    /// model.
    #[must_use]
    pub fn pose(&self, part: usize) -> Isometry3<f64> {
        let part = &self.parts[part];
        let pose = self.states[part.id.index()].pose();
        Isometry3::from_parts(pose.translation, pose.rotation * part.model_frame)
    }

    /// Velocities of a part, by its index in the morphology, along and about the axes of the world: that
    /// of its centre of mass in m/s, and the angular one in rad/s.
    #[must_use]
    pub fn velocities(&self, part: usize) -> (Vector3<f64>, Vector3<f64>) {
        let state = &self.states[self.parts[part].id.index()];
        (state.linear_velocity.into(), state.angular_velocity.into())
    }

    /// Length of the targets.
    #[must_use]
    pub fn n_actuators(&self) -> usize {
        self.axes.n_actuators()
    }

    /// The world's id of a part, by its index in the morphology.
    #[must_use]
    pub fn body_id(&self, part: usize) -> BodyId {
        self.parts[part].id
    }

    /// The world's id of a joint, by its index in the morphology.
    #[must_use]
    pub fn joint_id(&self, joint: usize) -> JointId {
        self.joints[joint]
    }
}

/// A joint that isn't there is one of another world's.
pub(crate) fn other_world(error: bullet::Error) -> Error {
    match error {
        bullet::Error::UnknownId { .. } => Error::OtherWorld,
        error => error.into(),
    }
}
