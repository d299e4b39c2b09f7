//! A robot as all formats have it, in the field's words: links, joints between them, motors.
//!
//! Everything is drawn in one space, with all joints at the file's zero. SI units and radians. An
//! axis has its direction and a point on it in that space, and a positive motion of it turns or
//! shifts the joint's child, right-handed, with all that hangs on it.

use std::path::PathBuf;

use config::Place;
use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, UnitQuaternion, Vector3};

/// A robot, as its file describes it.
#[derive(Clone, Debug)]
pub struct Robot {
    /// For people.
    pub name: String,
    /// The rigid parts. One that nothing weighs is a frame for others.
    pub links: Vec<Link>,
    /// A tree: every link but one, the root, is the child of exactly one of them; or all are, if the
    /// root is fixed or jointed to the world.
    pub joints: Vec<Joint>,
    /// Whether parts that no joint connects collide; `None` where the format doesn't say.
    pub self_collision: Option<bool>,
    /// Links that don't collide with each other.
    pub no_collision: Vec<[usize; 2]>,
    /// Links with a contact sensor.
    pub touch: Vec<usize>,
    /// Joint and place among its axes, in the order of the file's motors, if it has one of its own.
    pub actuators: Vec<[usize; 2]>,
    /// Forward, in the drawing.
    pub forward: Vector3<f64>,
    /// The height of the file's own ground, in m, if it has one.
    pub ground_m: Option<f64>,
}

/// A rigid part.
#[derive(Clone, Debug)]
pub struct Link {
    /// Unique among links once a robot has been checked.
    pub name: String,
    /// Where it's described.
    pub place: Place,
    /// Its frame.
    pub pose: Isometry3<f64>,
    /// What it weighs, if the file says so or its shapes do.
    pub inertial: Option<Inertial>,
    /// What collides.
    pub shapes: Vec<Shape>,
    /// What is only seen.
    pub seen: Vec<Shape>,
    /// Red, green, blue.
    pub colour: Option<[u8; 3]>,
    /// Coulomb's coefficient.
    pub friction: Option<f64>,
}

impl Link {
    /// A frame that nothing weighs.
    pub(crate) fn new(name: &str, place: Place, pose: Isometry3<f64>) -> Self {
        Self {
            name: name.into(),
            place,
            pose,
            inertial: None,
            shapes: Vec::new(),
            seen: Vec::new(),
            colour: None,
            friction: None,
        }
    }
}

/// Mass and how it's spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// The mass in kg.
    pub mass_kg: f64,
    /// In the link's frame, in m.
    pub centre_m: Point3<f64>,
    /// About the centre of mass, along the link's axes, in kg m^2.
    pub tensor_kg_m2: Matrix3<f64>,
}

/// A solid.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Where it's described.
    pub place: Place,
    /// In the link's frame.
    pub pose: Isometry3<f64>,
    /// What it is there.
    pub solid: Solid,
}

/// A solid around the origin of its frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Solid {
    /// Half its size along x, y and z, in m.
    Box(Vector3<f64>),
    /// Its radius, in m.
    Ball(f64),
    /// Along z: radius, and half the length, in m.
    Cylinder(f64, f64),
    /// Along z: radius, and half the length without the half balls, in m.
    Capsule(f64, f64),
    /// Half its size along x, y and z, in m.
    Ellipsoid(Vector3<f64>),
    /// A mesh from a file.
    Mesh {
        /// As the robot's file names it.
        uri: String,
        /// Where it was found.
        file: Option<PathBuf>,
        /// Factors along x, y and z.
        scale: Vector3<f64>,
    },
}

/// What holds a child to a parent.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Unique among joints once a robot has been checked.
    pub name: String,
    /// Where it's described.
    pub place: Place,
    /// A link; `None` is the world.
    pub parent: Option<usize>,
    /// A link.
    pub child: usize,
    /// What moves, nearest to the parent first: each is carried along by those before it. Without
    /// any the joint is fixed, or floats.
    pub axes: Vec<Axis>,
    /// Whether it holds nothing.
    pub floats: bool,
}

/// One way in which a joint moves.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Unique among those of the joint once a robot has been checked.
    pub name: String,
    /// Turns about it or slides along it.
    pub motion: Motion,
    /// In the drawing.
    pub direction: Unit<Vector3<f64>>,
    /// A point on it, in the drawing, in m.
    pub anchor_m: Point3<f64>,
    /// Lower and upper end, in rad or m; `None` moves without end.
    pub range: Option<[f64; 2]>,
    /// Whether a command of +1 stands for the lower end.
    pub reversed: bool,
    /// What moves it.
    pub motor: Option<Motor>,
    /// The damping in N m s/rad or N s/m.
    pub damping: f64,
    /// The friction in N m or N.
    pub friction: f64,
    /// What pulls it back.
    pub spring: Option<Spring>,
}

/// How an axis moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// About its direction, right-handed; rad, N m.
    Turns,
    /// Along its direction; m, N.
    Slides,
}

/// What moves an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// What a command is.
    pub kind: MotorKind,
    /// The speed limit in rad/s or m/s, if the file has one.
    pub speed: Option<f64>,
    /// The limit of its torque or force in N m or N, if the file has one.
    pub effort: Option<f64>,
}

/// What a motor's command is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MotorKind {
    /// A position in the range.
    Position,
    /// A share of the speed limit.
    Speed,
    /// A share of the torque or force limit.
    Torque,
}

/// A damped spring is this and the axis' damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// The stiffness in N m/rad or N/m.
    pub stiffness: f64,
    /// Where it's at rest, in rad or m.
    pub rest: f64,
}

impl Axis {
    /// An axis without limits and motor.
    pub(crate) fn new(
        motion: Motion,
        direction: Unit<Vector3<f64>>,
        anchor_m: Point3<f64>,
    ) -> Self {
        Self {
            name: String::new(),
            motion,
            direction,
            anchor_m,
            range: None,
            reversed: false,
            motor: None,
            damping: 0.0,
            friction: 0.0,
            spring: None,
        }
    }

    /// How space moves if the axis does by so much.
    #[must_use]
    pub fn moved(&self, position: f64) -> Isometry3<f64> {
        match self.motion {
            Motion::Slides => Translation3::from(self.direction.into_inner() * position).into(),
            Motion::Turns => {
                let turn = turned(&self.direction, position);
                let anchor = self.anchor_m.coords;
                Isometry3::from_parts((anchor - turn * anchor).into(), turn)
            }
        }
    }

    /// The same motion, counted the other way.
    pub(crate) fn flipped(&self) -> Self {
        Self {
            direction: -self.direction,
            range: self.range.map(|[lower, upper]| [-upper, -lower]),
            reversed: !self.reversed,
            spring: self.spring.map(|spring| Spring { rest: -spring.rest, ..spring }),
            ..self.clone()
        }
    }

    /// The same, seen from a space that has moved.
    pub(crate) fn carried(&mut self, by: &Isometry3<f64>) {
        self.direction = Unit::new_unchecked(by.rotation * self.direction.into_inner());
        self.anchor_m = by * self.anchor_m;
    }
}

/// Right-handed about a direction, with `libm`, whose bits don't depend on the machine.
pub(crate) fn turned(about: &Unit<Vector3<f64>>, angle_rad: f64) -> UnitQuaternion<f64> {
    let half = angle_rad / 2.0;
    let vector = about.into_inner() * libm::sin(half);
    UnitQuaternion::from_quaternion(nalgebra::Quaternion::from_parts(libm::cos(half), vector))
}

/// Turned about x, then about the fixed y, then about the fixed z, as roll, pitch and yaw are.
pub(crate) fn roll_pitch_yaw([roll, pitch, yaw]: [f64; 3]) -> UnitQuaternion<f64> {
    turned(&Vector3::z_axis(), yaw)
        * turned(&Vector3::y_axis(), pitch)
        * turned(&Vector3::x_axis(), roll)
}

/// Roll, pitch and yaw of a rotation: the inverse of [`roll_pitch_yaw`], exact where pitch is a right
/// angle, too.
pub(crate) fn to_roll_pitch_yaw(rotation: &UnitQuaternion<f64>) -> [f64; 3] {
    let r = rotation.to_rotation_matrix().into_inner();
    let across = libm::sqrt(r[(2, 1)] * r[(2, 1)] + r[(2, 2)] * r[(2, 2)]);
    // Where roll and yaw turn about the same axis, yaw does it all.
    let roll = if across < 1e-9 { 0.0 } else { libm::atan2(r[(2, 1)], r[(2, 2)]) };
    let (s, c) = (libm::sin(roll), libm::cos(roll));
    let pitch = libm::atan2(-r[(2, 0)], across);
    let yaw = libm::atan2(s * r[(0, 2)] - c * r[(0, 1)], c * r[(1, 1)] - s * r[(1, 2)]);
    [roll, pitch, yaw]
}

/// Two directions that make a right-handed frame with a third.
pub(crate) fn across(third: &Unit<Vector3<f64>>) -> [Unit<Vector3<f64>>; 2] {
    let least = Vector3::ith(third.iamin(), 1.0);
    let first = Unit::new_normalize(least - third.into_inner() * third.dot(&least));
    [first, Unit::new_normalize(third.cross(&first))]
}

/// The axes of a ball joint: about z, y and x of its frame, in which they are carried along.
pub(crate) fn ball(frame: &Isometry3<f64>) -> [Axis; 3] {
    [("z", Vector3::z()), ("y", Vector3::y()), ("x", Vector3::x())].map(|(name, direction)| {
        let direction = Unit::new_normalize(frame.rotation * direction);
        let anchor_m = frame.translation.vector.into();
        Axis { name: name.into(), ..Axis::new(Motion::Turns, direction, anchor_m) }
    })
}

impl Robot {
    /// An empty one.
    pub(crate) fn new(name: &str) -> Self {
        Self {
            name: name.into(),
            links: Vec::new(),
            joints: Vec::new(),
            self_collision: None,
            no_collision: Vec::new(),
            touch: Vec::new(),
            actuators: Vec::new(),
            forward: Vector3::x(),
            ground_m: None,
        }
    }

    /// The mass of all links that weigh something, in kg.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        self.links.iter().filter_map(|link| link.inertial).map(|it| it.mass_kg).sum()
    }

    /// The joint that a link is the child of.
    pub(crate) fn joint_above(&self, link: usize) -> Option<usize> {
        self.joints.iter().position(|joint| joint.child == link)
    }

    /// Whether each link is a link or hangs on it. Joints have to be in the order of the tree.
    pub(crate) fn below(&self, root: usize) -> Vec<bool> {
        let mut below = vec![false; self.links.len()];
        below[root] = true;
        for joint in &self.joints {
            below[joint.child] |= joint.parent.is_some_and(|parent| below[parent]);
        }
        below
    }

    /// Moves a link with all that hangs on it: their frames, and the axes between them.
    pub(crate) fn carry(&mut self, link: usize, by: &Isometry3<f64>) {
        let below = self.below(link);
        for (link, moves) in self.links.iter_mut().zip(&below) {
            if *moves {
                link.pose = by * link.pose;
            }
        }
        let inner = self.joints.iter_mut();
        for joint in inner.filter(|joint| joint.parent.is_some_and(|parent| below[parent])) {
            joint.axes.iter_mut().for_each(|axis| axis.carried(by));
        }
    }

    /// Redraws the robot with an axis at another position, which is its zero from then on.
    pub(crate) fn redraw(&mut self, joint: usize, axis: usize, position: f64) {
        let by = self.joints[joint].axes[axis].moved(position);
        for later in &mut self.joints[joint].axes[axis + 1..] {
            later.carried(&by);
        }
        let moved = &mut self.joints[joint].axes[axis];
        if let Some(range) = &mut moved.range {
            *range = range.map(|end| end - position);
        }
        if let Some(spring) = &mut moved.spring {
            spring.rest -= position;
        }
        if moved.motion == Motion::Slides {
            moved.anchor_m = by * moved.anchor_m;
        }
        self.carry(self.joints[joint].child, &by);
    }
}
