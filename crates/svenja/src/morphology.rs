//! A robot's body plan: what a model file describes, checked, and never changed afterwards.

use std::path::Path;

use config::{Document, Problem, Problems};
use nalgebra::{Isometry3, Unit, Vector3};

use crate::{Shape, Turn, check::check, file::ModelFile};

/// A tree of rigid bodies, what moves and what senses them. It's right as far as a file can be: all
/// names belong to something, all numbers are within their bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Morphology {
    pub(crate) name: String,
    pub(crate) description: String,
    pub(crate) bodies: Vec<Body>,
    pub(crate) joints: Vec<Joint>,
    pub(crate) groups: Vec<Group>,
    pub(crate) sensors: Vec<AxisId>,
    pub(crate) actuators: Vec<AxisId>,
    pub(crate) contacts: Vec<usize>,
    pub(crate) n_feet: usize,
    pub(crate) penalised: Vec<usize>,
    pub(crate) heading: Heading,
    pub(crate) start: Isometry3<f64>,
    pub(crate) self_collision: bool,
    pub(crate) locomotion_scale: f64,
    pub(crate) touch_distance_m: f64,
    pub(crate) warnings: Vec<Problem>,
}

/// A rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Unique among the bodies.
    pub name: String,
    /// The mass in kg.
    pub mass_kg: f64,
    /// Coulomb's coefficient; a contact has the product of its two bodies'.
    pub friction: f64,
    /// Red, green and blue, for display.
    pub colour: [u8; 3],
    /// The pose of its centre of mass, as the model is drawn: all angles 0, before [`Morphology::start`].
    pub pose: Isometry3<f64>,
    /// In the body's frame.
    pub shape: Shape,
}

/// A joint between two bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Unique among the joints.
    pub name: String,
    /// The joint's kind: what it lets move.
    pub kind: JointKind,
    /// Index of a body.
    pub parent: usize,
    /// Index of a body.
    pub child: usize,
    /// Where it is and how its axes lie, as the model is drawn.
    pub frame: Isometry3<f64>,
    /// The axes that move; all others are locked.
    pub axes: Vec<JointAxis>,
    /// What happens at the ends of the axes' ranges, and to what the joint locks.
    pub stop: Stop,
}

/// The kinds of joints, by what they let move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// The bodies don't move against each other.
    Fixed,
    /// One rotation: Bullet's hinge.
    Hinge,
    /// One rotation: Bullet's slider with its translation locked, which is how the simulator of the
    /// original experiments made its hinges.
    SliderHinge,
    /// One to three rotations: Bullet's 6-dof spring joint. They are taken about z, then about the
    /// new y, then about the newest x.
    Spherical,
}

impl JointKind {
    /// Its name in model files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Hinge => "hinge",
            Self::SliderHinge => "slider-hinge",
            Self::Spherical => "spherical",
        }
    }

    /// How far from 0 an axis and its stops may be, in degrees. Of the three angles of Bullet's 6-dof
    /// joint, which it has whichever of them turn, the middle one's other half would be the same
    /// turns again.
    #[must_use]
    pub fn farthest_deg(self, about: Turn) -> f64 {
        if self == Self::Spherical && about == Turn::Y { 90.0 } else { 180.0 }
    }
}

/// A rotation of a joint: right-handed, 0 as the model is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct JointAxis {
    /// Unique within the joint.
    pub name: String,
    /// An axis of the joint's frame.
    pub about: Turn,
    /// Lower end of the range that commands and readings cover, in rad.
    pub lower_rad: f64,
    /// Its upper end, in rad.
    pub upper_rad: f64,
    /// How far beyond either end the joint's stops are, in rad.
    pub stop_margin_rad: f64,
    /// Whether +1 stands for the lower end, and -1 for the upper.
    pub reversed: bool,
    /// The servo that drives it, if it has one.
    pub servo: Option<Servo>,
    /// The damped spring that pulls it back, if it has one.
    pub spring: Option<Spring>,
}

impl JointAxis {
    /// Where the joint stops, in rad: the lower and the upper end.
    #[must_use]
    pub fn stops_rad(&self) -> [f64; 2] {
        [self.lower_rad - self.stop_margin_rad, self.upper_rad + self.stop_margin_rad]
    }

    /// Where -1..1 lies in the range, in rad.
    #[must_use]
    pub fn angle_of(&self, value: f64) -> f64 {
        let value = if self.reversed { -value } else { value };
        self.lower_rad + 0.5 * (value + 1.0) * (self.upper_rad - self.lower_rad)
    }

    /// Where an angle in rad lies on the scale from -1 to 1, and beyond.
    #[must_use]
    pub fn value_of(&self, angle_rad: f64) -> f64 {
        let part = (angle_rad - self.lower_rad) / (self.upper_rad - self.lower_rad);
        let value = 2.0 * part - 1.0;
        if self.reversed { -value } else { value }
    }
}

/// What drives an axis towards its target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo {
    /// How fast it turns at most, in rad/s.
    pub speed_limit_rad_s: f64,
    /// How hard it turns at most, in N m.
    pub torque_limit_nm: f64,
}

/// A damped spring: torque = -stiffness (angle - equilibrium) - damping rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// The stiffness in N m/rad.
    pub stiffness_nm_rad: f64,
    /// The damping in N m s/rad.
    pub damping_nms_rad: f64,
    /// The position at which the spring is at rest, in rad.
    pub equilibrium_rad: f64,
}

/// What happens at the stops of a joint. To Bullet's sliders and 6-dof joints what is locked is a
/// range without a length, so it's held in the same way; hinges and fixed joints hold it as the
/// world's own settings say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Share of the overshoot that a physics step takes back.
    pub erp: f64,
    /// Softness; 0 is rigid.
    pub cfm: f64,
    /// Share of the speed that comes back.
    pub bounce: f64,
}

/// Hard and without a bounce.
impl Default for Stop {
    fn default() -> Self {
        Self { erp: 1.0, cfm: 0.0, bounce: 0.0 }
    }
}

/// Joints and contacts that belong together: a leg.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Unique among groups and joints.
    pub name: String,
    /// Indices of joints.
    pub joints: Vec<usize>,
    /// Indices of bodies with a contact sensor.
    pub contacts: Vec<usize>,
}

/// One axis of one joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisId {
    /// Index of the joint.
    pub joint: usize,
    /// Index among the joint's axes.
    pub axis: usize,
}

/// The body and the direction in it that say where forward is.
#[derive(Clone, Debug, PartialEq)]
pub struct Heading {
    /// Index of a body.
    pub body: usize,
    /// In the body's frame.
    pub axis: Unit<Vector3<f64>>,
}

impl Morphology {
    /// Reads a model file.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place.
    pub fn open(path: &Path) -> Result<Self, Problems> {
        Self::read(&Document::open(path)?)
    }

    /// Reads a model from a text; problems name it `source`.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place.
    pub fn parse(source: &str, text: &str) -> Result<Self, Problems> {
        Self::read(&Document::parse(source, text)?)
    }

    /// Reads a model from a document, in which keys may have been changed since it was a file.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place.
    pub fn read(document: &Document) -> Result<Self, Problems> {
        check(&document.read(ModelFile::read)?)
    }

    /// The robot's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What the file says about it; may be empty.
    #[must_use]
    pub fn description(&self) -> &str {
        &self.description
    }

    /// What the file may say, and had better not: each with its place.
    #[must_use]
    pub fn warnings(&self) -> &[Problem] {
        &self.warnings
    }

    /// All bodies, in the order of the file.
    #[must_use]
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// All joints. Together with the bodies they form one tree.
    #[must_use]
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Joints and contacts that belong together.
    #[must_use]
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// Axes whose positions are sensed, in the order of the readings.
    #[must_use]
    pub fn sensors(&self) -> &[AxisId] {
        &self.sensors
    }

    /// Axes that are driven, in the order of the targets. Each has a servo.
    #[must_use]
    pub fn actuators(&self) -> &[AxisId] {
        &self.actuators
    }

    /// Bodies with a contact sensor, in the order of the readings, in which they follow the
    /// positions: the feet, then others.
    #[must_use]
    pub fn contacts(&self) -> &[usize] {
        &self.contacts
    }

    /// The feet: the first of [`Morphology::contacts`].
    #[must_use]
    pub fn feet(&self) -> &[usize] {
        &self.contacts[..self.n_feet]
    }

    /// Bodies that had better not touch anything.
    #[must_use]
    pub fn penalised(&self) -> &[usize] {
        &self.penalised
    }

    /// The body and the direction in it that say where forward is.
    #[must_use]
    pub fn heading(&self) -> &Heading {
        &self.heading
    }

    /// Moves the robot from where it's drawn to where it starts.
    #[must_use]
    pub fn start(&self) -> &Isometry3<f64> {
        &self.start
    }

    /// Whether its parts collide with each other, those that a joint connects excepted.
    #[must_use]
    pub fn self_collision(&self) -> bool {
        self.self_collision
    }

    /// What a metre of locomotion in a control step counts, so that the robot's fast gaits make
    /// about 0.1.
    #[must_use]
    pub fn locomotion_scale(&self) -> f64 {
        self.locomotion_scale
    }

    /// A body touches what is nearer than this, in m.
    #[must_use]
    pub fn touch_distance_m(&self) -> f64 {
        self.touch_distance_m
    }

    /// Readings: positions and contacts.
    #[must_use]
    pub fn n_readings(&self) -> usize {
        self.sensors.len() + self.contacts.len()
    }

    /// The mass of all bodies together, in kg.
    #[must_use]
    pub fn total_mass_kg(&self) -> f64 {
        self.bodies.iter().map(|body| body.mass_kg).sum()
    }

    /// The degrees of freedom of the joints and of the robot in space.
    #[must_use]
    pub fn degrees_of_freedom(&self) -> usize {
        6 + self.joints.iter().map(|joint| joint.axes.len()).sum::<usize>()
    }

    /// The axis that an id names.
    #[must_use]
    pub fn axis(&self, id: AxisId) -> &JointAxis {
        &self.joints[id.joint].axes[id.axis]
    }

    /// `hip/lift`, or the joint's name alone where it has one axis.
    #[must_use]
    pub fn axis_name(&self, id: AxisId) -> String {
        let joint = &self.joints[id.joint];
        match joint.axes.len() {
            1 => joint.name.clone(),
            _ => format!("{}/{}", joint.name, joint.axes[id.axis].name),
        }
    }
}
