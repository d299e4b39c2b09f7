//! The axes of a robot in a world: read, sensed, driven.

use std::collections::BTreeSet;

use bullet::{Axis, JointId, JointState, MotorCommand, World};

use crate::{
    AxisId, Error, JointAxis, Morphology, Readings, Servo, ServoCommand, ServoKind,
    build::bullet_axis, robot::other_world, servo_command,
};

/// What a robot has to know of its axes, and buffers.
#[derive(Debug)]
pub(crate) struct Axes {
    /// The joints that somebody asks for, which alone are looked at: an angle takes an arc tangent.
    moving: Vec<JointId>,
    sensors: Vec<Axle>,
    /// `[n_actuators]`
    servos: Vec<Drive>,
    /// Axes that aren't among these, and that something resists.
    resisted: Vec<Drive>,
    /// The joint of each servo.
    driven: Vec<JointId>,
    /// Whether something slides or is resisted: else angles are enough.
    needs_states: bool,
    /// `[3 x n_moving]`, about x, y, z, in rad.
    angles: Vec<f64>,
    /// Of all of the world's joints, if they're needed.
    states: Vec<JointState>,
    commands: Vec<MotorCommand>,
}

/// One axis, and where it's found.
#[derive(Debug)]
struct Axle {
    joint: JointId,
    place: Axis,
    /// Its place among the angles of joints that move; None: it slides.
    angle: Option<usize>,
    axis: JointAxis,
}

/// An axis with what drives it, which may be nothing.
#[derive(Debug)]
struct Drive {
    axle: Axle,
    servo: Servo,
    /// A position in rad or m, or a share of the servo's limit.
    target: f64,
}

/// What drives an axis that has no servo.
const NO_SERVO: Servo = Servo { kind: ServoKind::Torque, speed_limit: 0.0, force_limit: 0.0 };

/// What a servo does that nobody commands: it holds, but for one of torque.
fn brake_of(axis: &JointAxis) -> Servo {
    match axis.servo {
        Some(servo) if servo.kind != ServoKind::Torque => Servo { kind: ServoKind::Speed, ..servo },
        _ => NO_SERVO,
    }
}

/// The axes that are sensed, driven or resisted.
fn used_axes(morphology: &Morphology) -> impl Iterator<Item = AxisId> + '_ {
    let resisted = |id: &AxisId| !morphology.axis(*id).resistance.is_none();
    let told = morphology.sensors().iter().chain(morphology.actuators()).copied();
    told.chain(morphology.axes().filter(resisted))
}

impl Axes {
    /// Of a robot whose joints have these ids.
    pub(crate) fn new(morphology: &Morphology, joints: &[JointId]) -> Self {
        let used: BTreeSet<usize> = used_axes(morphology).map(|id| id.joint).collect();
        let moving: Vec<_> = used.iter().map(|&joint| joints[joint]).collect();
        let axle = |id: AxisId| {
            let (joint, axis) = (joints[id.joint], morphology.axis(id).clone());
            let place = bullet_axis(morphology.joints()[id.joint].kind, axis.freedom);
            // The joints' ids grow.
            let among_moving = moving.partition_point(|other| *other < joint);
            let angle = place.index().checked_sub(Axis::AngularX.index());
            Axle { joint, place, angle: angle.map(|about| 3 * among_moving + about), axis }
        };
        let drive = |&id: &AxisId| {
            let axle = axle(id);
            let servo = axle.axis.servo.unwrap_or(NO_SERVO);
            let mut drive = Drive { axle, servo, target: 0.0 };
            drive.set(0.0);
            drive
        };
        let brake = |id: AxisId| {
            let axle = axle(id);
            Drive { servo: brake_of(&axle.axis), axle, target: 0.0 }
        };
        let servos: Vec<_> = morphology.actuators().iter().map(drive).collect();
        let others = morphology.axes().filter(|id| !morphology.actuators().contains(id));
        let resisted: Vec<_> = others.map(brake).filter(Drive::is_resisted).collect();
        let slides = morphology.axes().any(|id| morphology.axis(id).freedom.is_linear());
        Self {
            sensors: morphology.sensors().iter().map(|&id| axle(id)).collect(),
            driven: servos.iter().map(|servo| servo.axle.joint).collect(),
            needs_states: slides || servos.iter().chain(&resisted).any(Drive::is_resisted),
            moving,
            servos,
            resisted,
            angles: Vec::new(),
            states: Vec::new(),
            commands: Vec::new(),
        }
    }

    /// Looks at the joints of a world.
    pub(crate) fn update(&mut self, world: &World) -> Result<(), Error> {
        world.read_angles_of(&self.moving, &mut self.angles).map_err(other_world)?;
        if self.needs_states {
            world.read_joints(&mut self.states)?;
        }
        Ok(())
    }

    /// Puts all positions into `out`, in place of what it held.
    pub(crate) fn sense(&self, out: &mut Readings) {
        out.values.clear();
        out.clipped.clear();
        for sensor in &self.sensors {
            let value = sensor.axis.value_of(self.position(sensor));
            out.values.push(value.clamp(-1.0, 1.0));
            out.clipped.push(value.abs() > 1.0);
        }
    }

    /// Takes the servos' commands, `[n_actuators]`, each -1 to 1.
    pub(crate) fn actuate(&mut self, targets: &[f64]) {
        for (servo, &target) in self.servos.iter_mut().zip(targets) {
            servo.set(target);
        }
    }

    /// What motors are to do in the next step.
    pub(crate) fn commands(&mut self) -> &[MotorCommand] {
        let mut commands = std::mem::take(&mut self.commands);
        commands.clear();
        commands.extend(self.servos.iter().chain(&self.resisted).map(|drive| self.command(drive)));
        self.commands = commands;
        &self.commands
    }

    fn command(&self, drive: &Drive) -> MotorCommand {
        let Axle { joint, place: axis, .. } = drive.axle;
        let told = drive.told(self.position(&drive.axle), || self.velocity(&drive.axle));
        let ServoCommand { velocity: target_velocity, max_force } = told;
        MotorCommand { joint, axis, target_velocity, max_force }
    }

    /// `[n_actuators]`: the joint of each servo.
    pub(crate) fn driven(&self) -> &[JointId] {
        &self.driven
    }

    /// `[n_actuators]`: which axis of its joint each servo drives.
    pub(crate) fn places(&self) -> impl Iterator<Item = Axis> {
        self.servos.iter().map(|servo| servo.axle.place)
    }

    pub(crate) fn n_actuators(&self) -> usize {
        self.servos.len()
    }

    fn position(&self, axle: &Axle) -> f64 {
        match axle.angle {
            Some(angle) => self.angles[angle],
            None => self.states[axle.joint.index()].position_of(axle.place),
        }
    }

    fn velocity(&self, axle: &Axle) -> f64 {
        self.states[axle.joint.index()].velocity_of(axle.place)
    }
}

impl Drive {
    /// Takes a command, -1 to 1.
    fn set(&mut self, command: f64) {
        let axis = &self.axle.axis;
        self.target = match self.servo.kind {
            ServoKind::Position => axis.position_of(command),
            ServoKind::Speed | ServoKind::Torque if axis.reversed => -command,
            ServoKind::Speed | ServoKind::Torque => command,
        };
    }

    fn is_resisted(&self) -> bool {
        !self.axle.axis.resistance.is_none()
    }

    /// What its motor is told at a position, and at a velocity that it may not have to know.
    fn told(&self, position: f64, velocity: impl FnOnce() -> f64) -> ServoCommand {
        let axis = &self.axle.axis;
        let command = match self.servo.kind {
            ServoKind::Position => axis.way(position, self.target),
            ServoKind::Speed | ServoKind::Torque => self.target,
        };
        let told = servo_command(&self.servo, command, axis.freedom.is_linear());
        if self.is_resisted() { told.against(&axis.resistance, velocity()) } else { told }
    }
}
