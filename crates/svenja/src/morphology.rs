//! A robot's body plan: what a model file describes, checked, and never changed afterwards.

use std::path::Path;

use config::{Document, Problem, Problems};
use nalgebra::{Isometry3, Point3, Unit, Vector3};

use crate::{Collider, Joint, JointAxis, check::check, file::ModelFile};

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
    pub(crate) no_collision: Vec<[usize; 2]>,
    pub(crate) heading: Heading,
    pub(crate) start: Isometry3<f64>,
    pub(crate) self_collision: bool,
    pub(crate) locomotion_scale: f64,
    pub(crate) touch_distance_m: f64,
    pub(crate) warnings: Vec<Problem>,
    pub(crate) meshes: Vec<Mesh>,
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
    /// The pose of its centre of mass, as the model is drawn: all positions 0, before
    /// [`Morphology::start`].
    pub pose: Isometry3<f64>,
    /// What it looks like and collides as; with none it's not seen and touches nothing.
    pub colliders: Vec<Collider>,
    /// Principal moments about the axes of its frame, if they're given; [`Body::inertia`] has those of
    /// every body.
    pub inertia_kg_m2: Option<Vector3<f64>>,
}

impl Body {
    /// How far from its centre of mass its shapes reach at most, in m.
    #[must_use]
    pub fn reach_m(&self) -> f64 {
        let reach = |collider: &Collider| {
            let (points, radius) = collider.shape.outline_m();
            let far = points.iter().map(|point| (collider.pose * point).coords.norm());
            radius + far.fold(0.0, f64::max)
        };
        self.colliders.iter().map(reach).fold(0.0, f64::max)
    }
}

/// The hull of a mesh file that a model names.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// As the model names it.
    pub file: String,
    /// The hull's corners, in the file's unit.
    pub points: Vec<Point3<f64>>,
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
        Self::read(&Document::open(path)?, path)
    }

    /// Reads a model from a text; problems name it `source`, and files that it names are looked for
    /// where that path says it is.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place.
    pub fn parse(source: &str, text: &str) -> Result<Self, Problems> {
        Self::read(&Document::parse(source, text)?, source.as_ref())
    }

    /// Reads a model from a document, in which keys may have been changed since it was a file; files
    /// that it names are looked for beside `path`.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place.
    pub fn read(document: &Document, path: &Path) -> Result<Self, Problems> {
        check(&document.read(ModelFile::read)?, path.parent().unwrap_or(path))
    }

    /// What makes a model's text whole, put behind it: what it takes from mesh files, as `[[mesh]]`.
    /// With this it's the same robot wherever it lies; empty if it needs no file.
    #[must_use]
    pub fn meshes_as_text(&self) -> String {
        let mut text = String::new();
        for Mesh { file, points } in &self.meshes {
            let points: Vec<_> =
                points.iter().map(|it| format!("[{:?}, {:?}, {:?}]", it.x, it.y, it.z)).collect();
            let file = file.replace('\\', "\\\\").replace('"', "\\\"");
            text += &format!("\n[[mesh]]\nfile = \"{file}\"\npoints = [{}]\n", points.join(", "));
        }
        text
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

    /// Pairs of bodies that never collide, whether or not others do.
    #[must_use]
    pub fn no_collision(&self) -> &[[usize; 2]] {
        &self.no_collision
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

    /// The degrees of freedom of the joints and, if no joint holds it to the world, of the robot in
    /// space.
    #[must_use]
    pub fn degrees_of_freedom(&self) -> usize {
        let is_held = self.joints.iter().any(|joint| joint.parent.is_none());
        let in_space = if is_held { 0 } else { 6 };
        in_space + self.joints.iter().map(|joint| joint.axes.len()).sum::<usize>()
    }

    /// The ids of all axes, joint by joint.
    pub fn axes(&self) -> impl Iterator<Item = AxisId> {
        let of = |(joint, it): (usize, &Joint)| {
            (0..it.axes.len()).map(move |axis| AxisId { joint, axis })
        };
        self.joints.iter().enumerate().flat_map(of)
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
