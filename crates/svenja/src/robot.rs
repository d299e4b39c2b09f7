//! A robot in a world: a morphology built, sensed and actuated.
//!
//! Bullet wants a body's frame along its principal axes of inertia, and a joint's axis along one of
//! the frame's that depends on the class. Both are turned here and turned back, so that outside
//! all is in the frames of the model.

use bullet::{
    Axis, AxisSettings, BodyId, BodyState, CollisionFilter, Contact, JointId, JointState,
    Lengthwise, Motor, MotorCommand, Range, World,
};
use nalgebra::{Isometry3, Point3, Quaternion, UnitQuaternion, Vector3};

use crate::{
    AxisId, Body, Joint, JointAxis, JointKind, Morphology, Rod, Shape, Turn, servo_velocity,
};

/// The collision group of robots, none of Bullet's own.
const ROBOT: i32 = 64;

/// Where a slider's translation is locked, in m. Bullet leaves its row out in a step that begins
/// with the translation exactly where it's locked: a leg under load then slips by a centimetre. At 0
/// that happens now and then, since positions are rounded to some 1e-7 m; here it doesn't.
const OFF_ZERO_M: f64 = 1e-30;

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
    #[error("{source} (body '{body}'{})", joint.as_ref().map(|j| format!(" of joint '{j}'")).unwrap_or_default())]
    BlewUp {
        /// The body's name.
        body: String,
        /// The joint that has it as its child, if there is one.
        joint: Option<String>,
        /// What the world says.
        source: Box<bullet::Error>,
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
    sensors: Vec<Sensor>,
    servos: Vec<ServoDrive>,
    contacts: Vec<usize>,
    penalised: Vec<usize>,
    heading: (usize, Vector3<f64>),
    touch_distance_m: f64,
    total_mass_kg: f64,
    /// Buffers.
    states: Vec<BodyState>,
    joint_states: Vec<JointState>,
    contact_points: Vec<Contact>,
    touching: Vec<bool>,
    commands: Vec<MotorCommand>,
}

#[derive(Debug)]
struct Part {
    name: String,
    id: BodyId,
    mass_kg: f64,
    /// The model's frame of the body, seen from Bullet's.
    model_frame: UnitQuaternion<f64>,
}

#[derive(Debug)]
struct Sensor {
    joint: usize,
    place: Axis,
    axis: JointAxis,
}

#[derive(Debug)]
struct ServoDrive {
    sensor: Sensor,
    speed_limit_rad_s: f64,
    torque_limit_nm: f64,
    /// In rad.
    target: f64,
}

impl Robot {
    /// Builds a robot in its start pose. Its servos hold the middle of their ranges, the neutral
    /// command, until [`Robot::actuate`].
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
        let mut joints = Vec::new();
        for joint in morphology.joints() {
            joints.push(world.add_joint(&bullet_joint(joint, morphology, &parts))?);
        }
        let drive = |&id: &AxisId| {
            let sensor = sensor(morphology, id);
            let servo = sensor.axis.servo?;
            Some(ServoDrive {
                speed_limit_rad_s: servo.speed_limit_rad_s,
                torque_limit_nm: servo.torque_limit_nm,
                target: sensor.axis.angle_of(0.0),
                sensor,
            })
        };
        let heading = morphology.heading();
        let mut robot = Self {
            touching: vec![false; parts.len()],
            parts,
            part_of_slot,
            joints,
            joint_names: morphology.joints().iter().map(|j| (j.name.clone(), j.child)).collect(),
            sensors: morphology.sensors().iter().map(|&id| sensor(morphology, id)).collect(),
            servos: morphology.actuators().iter().filter_map(drive).collect(),
            contacts: morphology.contacts().to_vec(),
            penalised: morphology.penalised().to_vec(),
            heading: (heading.body, heading.axis.into_inner()),
            touch_distance_m: morphology.touch_distance_m(),
            total_mass_kg: morphology.total_mass_kg(),
            states: Vec::new(),
            joint_states: Vec::new(),
            contact_points: Vec::new(),
            commands: Vec::new(),
        };
        robot.look(world)?;
        Ok(robot)
    }

    /// Looks at the bodies alone: at their poses, the centre of gravity and the heading, not at
    /// joints and contacts.
    ///
    /// # Errors
    /// As [`Robot::sense`].
    pub fn look(&mut self, world: &World) -> Result<(), Error> {
        world.read_bodies(&mut self.states)?;
        let n_slots = self.part_of_slot.len();
        if self.states.len() < n_slots {
            self.states.resize(n_slots, BodyState::default());
            return Err(Error::OtherWorld);
        }
        Ok(())
    }

    fn look_at_joints(&mut self, world: &World) -> Result<(), Error> {
        world.read_joints(&mut self.joint_states)?;
        let n_slots = self.joints.last().map_or(0, |joint| joint.index() + 1);
        if self.joint_states.len() < n_slots { Err(Error::OtherWorld) } else { Ok(()) }
    }

    /// Looks at the world as it is now; the readings are put into `out`, which keeps its room. What
    /// [`Robot::centre_of_gravity_m`] and the other methods after it tell is of this moment, too.
    ///
    /// # Errors
    /// A world without the robot; what the world says of its state.
    pub fn sense(&mut self, world: &World, out: &mut Readings) -> Result<(), Error> {
        self.look(world)?;
        self.look_at_joints(world)?;
        world.read_contacts(&mut self.contact_points)?;
        self.feel_contacts();

        out.values.clear();
        out.clipped.clear();
        for sensor in &self.sensors {
            let angle =
                self.joint_states[self.joints[sensor.joint].index()].position_of(sensor.place);
            let value = sensor.axis.value_of(angle);
            out.values.push(value.clamp(-1.0, 1.0));
            out.clipped.push(value.abs() > 1.0);
        }
        let touches = self.contacts.iter().map(|&part| f64::from(u8::from(self.touching[part])));
        out.values.extend(touches);
        Ok(())
    }

    /// A part touches if something that isn't the robot is near enough.
    fn feel_contacts(&mut self) {
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

    /// Sets the targets of all servos, `[n_actuators]`, each within -1 to 1 over its range.
    /// [`Robot::drive`] then holds them.
    ///
    /// # Errors
    /// Another number of targets, or one that's NaN or beyond; the targets are then as before.
    pub fn actuate(&mut self, targets: &[f64]) -> Result<(), Error> {
        let refused = |argument: &str, expected: String, value: String| {
            Err(Error::Target { argument: argument.into(), expected, value })
        };
        if targets.len() != self.servos.len() {
            let expected = format!("{} targets", self.servos.len());
            return refused("targets", expected, targets.len().to_string());
        }
        if let Some(i) = targets.iter().position(|target| !(-1.0..=1.0).contains(target)) {
            let value = targets[i].to_string();
            return refused(&format!("targets[{i}]"), "from -1 to 1".into(), value);
        }
        for (servo, &target) in self.servos.iter_mut().zip(targets) {
            servo.target = servo.sensor.axis.angle_of(target);
        }
        Ok(())
    }

    /// Applies the [servo law](servo_velocity) to all servos: once before each physics step.
    ///
    /// # Errors
    /// What the world refuses.
    pub fn drive(&mut self, world: &mut World) -> Result<(), Error> {
        self.look_at_joints(world)?;
        self.commands.clear();
        for servo in &self.servos {
            let joint = self.joints[servo.sensor.joint];
            let angle = self.joint_states[joint.index()].position_of(servo.sensor.place);
            self.commands.push(MotorCommand {
                joint,
                axis: servo.sensor.place,
                target_velocity: servo_velocity(servo.target, angle, servo.speed_limit_rad_s),
                max_force: servo.torque_limit_nm,
            });
        }
        Ok(world.set_motors(&self.commands)?)
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
            source: Box::new(error),
        }
    }

    /// Mass-weighted mean of all parts' positions, in m.
    #[must_use]
    pub fn centre_of_gravity_m(&self) -> Point3<f64> {
        let mut sum = Vector3::zeros();
        for part in &self.parts {
            sum += Vector3::from(self.states[part.id.index()].position) * part.mass_kg;
        }
        (sum / self.total_mass_kg).into()
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

    /// Length of the targets.
    #[must_use]
    pub fn n_actuators(&self) -> usize {
        self.servos.len()
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

fn sensor(morphology: &Morphology, id: AxisId) -> Sensor {
    let axis = morphology.axis(id).clone();
    let place = bullet_axis(morphology.joints()[id.joint].kind, axis.about);
    Sensor { joint: id.joint, place, axis }
}

fn add_body(body: &Body, morphology: &Morphology, world: &mut World) -> Result<Part, Error> {
    let principal = body.shape.principal_axes();
    let pose = morphology.start() * body.pose * principal;
    let shape = add_shape(&body.shape, world)?;
    let mask = if morphology.self_collision() { -1 } else { !ROBOT };
    let id = world.add_body(&bullet::Body {
        inertia: Some(body.shape.inertia_kg_m2(body.mass_kg)),
        friction: body.friction,
        filter: CollisionFilter { group: ROBOT, mask },
        ..bullet::Body::dynamic(shape, body.mass_kg, pose)
    })?;
    let model_frame = principal.inverse();
    Ok(Part { name: body.name.clone(), id, mass_kg: body.mass_kg, model_frame })
}

/// In the frame of its own axes, with the body's centre of mass as origin.
fn add_shape(shape: &Shape, world: &mut World) -> Result<bullet::ShapeId, Error> {
    let along = Lengthwise::Z;
    let (primitive, rod) = match shape {
        Shape::Box { half_extents_m } => {
            (bullet::Shape::Box { half_extents: *half_extents_m }, None)
        }
        Shape::Sphere { radius_m } => (bullet::Shape::Sphere { radius: *radius_m }, None),
        Shape::Capsule(rod) => {
            let (radius, length) = (rod.radius_m, rod.length_m());
            (bullet::Shape::Capsule { radius, length, along }, Some(rod))
        }
        Shape::Cylinder(rod) => {
            let (radius, length) = (rod.radius_m, rod.length_m());
            (bullet::Shape::Cylinder { radius, length, along }, Some(rod))
        }
    };
    let primitive = world.add_shape(&primitive)?;
    match rod.map(Rod::centre_m) {
        Some(centre) if centre != Point3::origin() => {
            let centre = shape.principal_axes().inverse_transform_point(&centre);
            let children = vec![(primitive, Isometry3::translation(centre.x, centre.y, centre.z))];
            Ok(world.add_shape(&bullet::Shape::Compound { children })?)
        }
        _ => Ok(primitive),
    }
}

fn bullet_joint(joint: &Joint, morphology: &Morphology, parts: &[Part]) -> bullet::Joint {
    let pose = |body: usize| {
        let drawn = morphology.bodies()[body].pose;
        drawn * parts[body].model_frame.inverse()
    };
    let turn = joint
        .axes
        .first()
        .map_or_else(UnitQuaternion::identity, |axis| frame_turn(joint.kind, axis.about));
    // Relative poses: where the robot starts doesn't matter.
    let frame = Isometry3::from_parts(joint.frame.translation, joint.frame.rotation * turn);
    let stop = bullet::Stop {
        erp: Some(joint.stop.erp),
        cfm: Some(joint.stop.cfm),
        bounce: Some(joint.stop.bounce),
    };
    let locked =
        AxisSettings { stop: bullet::Stop { bounce: None, ..stop }, ..AxisSettings::locked() };
    let only_axis = || joint.axes.first().map_or(locked, |axis| axis_settings(axis, stop));
    let kind = match joint.kind {
        JointKind::Fixed => bullet::JointKind::Fixed,
        JointKind::Hinge => bullet::JointKind::Hinge(only_axis()),
        JointKind::SliderHinge => bullet::JointKind::Slider {
            linear: AxisSettings {
                range: Range::Limited { lower: OFF_ZERO_M, upper: OFF_ZERO_M },
                ..locked
            },
            angular: only_axis(),
            held: locked.stop,
        },
        JointKind::Spherical => {
            let mut axes = [locked; 6];
            for axis in &joint.axes {
                axes[bullet_axis(joint.kind, axis.about).index()] = axis_settings(axis, stop);
            }
            bullet::JointKind::SixDofSpring(Box::new(axes))
        }
    };
    bullet::Joint::at(
        &frame,
        kind,
        (parts[joint.parent].id, &pose(joint.parent)),
        (parts[joint.child].id, &pose(joint.child)),
    )
}

fn axis_settings(axis: &JointAxis, stop: bullet::Stop) -> AxisSettings {
    AxisSettings {
        range: Range::Limited {
            lower: axis.lower_rad - axis.stop_margin_rad,
            upper: axis.upper_rad + axis.stop_margin_rad,
        },
        stop,
        motor: axis
            .servo
            .map(|servo| Motor { target_velocity: 0.0, max_force: servo.torque_limit_nm }),
        spring: axis.spring.map(|spring| bullet::Spring {
            stiffness: spring.stiffness_nm_rad,
            damping: spring.damping_nms_rad,
            equilibrium: spring.equilibrium_rad,
        }),
    }
}

/// Which of Bullet's axes a joint turns about.
fn bullet_axis(kind: JointKind, about: Turn) -> Axis {
    match (kind, about) {
        (JointKind::Hinge, _) => Axis::AngularZ,
        (JointKind::SliderHinge, _) => Axis::AngularX,
        (_, Turn::X) => Axis::AngularX,
        (_, Turn::Y) => Axis::AngularY,
        (_, Turn::Z) => Axis::AngularZ,
    }
}

/// Turns the joint's frame so that the axis `about` lies where Bullet's class wants it: z for a
/// hinge, x for a slider.
fn frame_turn(kind: JointKind, about: Turn) -> UnitQuaternion<f64> {
    // x to y, y to z, z to x: exact.
    let on = UnitQuaternion::new_unchecked(Quaternion::new(0.5, 0.5, 0.5, 0.5));
    let wanted = match kind {
        JointKind::Hinge => Turn::Z,
        JointKind::SliderHinge => Turn::X,
        JointKind::Fixed | JointKind::Spherical => about,
    };
    match (3 + about.index() - wanted.index()) % 3 {
        0 => UnitQuaternion::identity(),
        1 => on,
        _ => on.inverse(),
    }
}
