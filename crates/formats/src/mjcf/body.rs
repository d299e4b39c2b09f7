//! Bodies in bodies, with their joints, geoms and sites.

use std::collections::BTreeMap;

use config::Problem;
use nalgebra::{Isometry3, Matrix3, Unit, Vector3};

use super::{
    World,
    compiler::Compiler,
    defaults::Defaults,
    geom::{Geom, Masks, friction, leave_out_unknown},
};
use crate::{
    files::Files,
    robot::{Axis, Inertial, Joint, Link, Motion, Robot, Spring, ball},
    tree::MOST_PARTS,
    urdf::colour,
    xml::{Element, Log},
};

/// Elements in bodies, copies of replicas each counted.
const MOST_ELEMENTS: usize = 20_000;

/// Attributes of a joint that are carried over, or have no effect.
const JOINT: [&str; 16] = [
    "name",
    "class",
    "type",
    "pos",
    "axis",
    "range",
    "limited",
    "ref",
    "stiffness",
    "springref",
    "damping",
    "frictionloss",
    "armature",
    "group",
    "user",
    "actuatorfrcrange",
];

/// And of a body.
const BODY: [&str; 9] =
    ["name", "childclass", "pos", "quat", "axisangle", "xyaxes", "zaxis", "euler", "user"];

/// Reads bodies one by one into a robot.
pub(super) struct Reader<'a> {
    compiler: &'a Compiler,
    defaults: &'a Defaults,
    meshes: &'a [Element],
    files: &'a Files,
    log: &'a Log,
    pub(super) robot: Robot,
    /// Each with its link.
    pub(super) geoms: Vec<(usize, Geom)>,
    pub(super) world: World,
    /// What each link's `<inertial>` says.
    pub(super) given: Vec<Option<Inertial>>,
    pub(super) joints: BTreeMap<String, [usize; 2]>,
    pub(super) sites: BTreeMap<String, usize>,
    /// Elements so far, replicas among them, and whether that was too many.
    read: usize,
    is_full: bool,
    /// Most that motors of an axis do together: joint, axis, N m or N.
    pub(super) most: Vec<([usize; 2], f64)>,
}

/// Where an element stands.
#[derive(Clone)]
struct Around {
    /// The body; `None` is the world.
    link: Option<usize>,
    /// The frame that it's written in, in the body's.
    frame: Isometry3<f64>,
    class: String,
    /// What replicas have behind their names.
    suffix: String,
}

impl<'a> Reader<'a> {
    pub(super) fn new(
        compiler: &'a Compiler,
        defaults: &'a Defaults,
        meshes: &'a [Element],
        files: &'a Files,
        log: &'a Log,
    ) -> Self {
        Self {
            compiler,
            defaults,
            meshes,
            files,
            log,
            robot: Robot::new(""),
            geoms: Vec::new(),
            world: World::default(),
            given: Vec::new(),
            joints: BTreeMap::new(),
            sites: BTreeMap::new(),
            read: 0,
            is_full: false,
            most: Vec::new(),
        }
    }

    pub(super) fn world(&mut self, world: &Element) {
        let class = world.get("childclass").unwrap_or("main").into();
        let frame = Isometry3::identity();
        let around = Around { link: None, frame, class, suffix: String::new() };
        for child in &world.children {
            self.child(child, &around);
        }
    }

    fn child(&mut self, element: &Element, around: &Around) {
        self.read += 1;
        if self.robot.links.len() > MOST_PARTS || self.read > MOST_ELEMENTS {
            if !self.is_full {
                self.is_full = true;
                let message = format!(
                    "at most {MOST_PARTS} bodies and {MOST_ELEMENTS} elements in them expected, got more"
                );
                self.log.problem(element.problem(message));
            }
            return;
        }
        match (element.name.as_str(), around.link) {
            ("body", _) => self.body(element, around),
            ("frame", _) => self.frame(element, around),
            ("replicate", _) => self.replicate(element, around),
            ("geom", Some(link)) => self.geom(element, link, around),
            ("geom", None) => self.ground(element, around),
            ("site", Some(link)) => {
                let name = element.get("name").unwrap_or_default();
                self.sites.insert(format!("{name}{}", around.suffix), link);
            }
            // Both are read with their body.
            ("joint" | "freejoint", Some(_)) => {}
            ("inertial", Some(link)) => {
                let frame = around.frame;
                self.given[link] = inertial(element, &frame, self.compiler, self.log);
            }
            ("camera" | "light" | "site", _) => {
                self.log.set_aside(&element.name, element.place());
            }
            (name, _) => self.log.left_out(name, element.place()),
        }
    }

    /// Poses and a class for all that is in it.
    fn frame(&mut self, element: &Element, around: &Around) {
        self.defaults.check(element, "childclass", self.log);
        let around = Around {
            frame: around.frame * self.compiler.pose(element, self.log),
            class: element.get("childclass").unwrap_or(&around.class).into(),
            ..around.clone()
        };
        for child in &element.children {
            self.child(child, &around);
        }
    }

    /// The same several times, each moved once more than the one before.
    fn replicate(&mut self, element: &Element, around: &Around) {
        let count = element.number("count", self.log).unwrap_or_default();
        if !(1.0..=MOST_PARTS as f64).contains(&count) {
            let message = format!("count of <replicate> must be 1 to {MOST_PARTS}, got {count}");
            self.log.problem(Problem { place: element.place_of("count"), message });
            return;
        }
        let offset = element.vector("offset", self.log).unwrap_or_default();
        let turn = self.compiler.orientation(element, self.log);
        let step = Isometry3::from_parts(offset.into(), turn);
        let (digits, separator) = (format!("{}", count - 1.0).len(), element.get("sep"));
        let mut around = around.clone();
        let outer = around.suffix.clone();
        for i in 0..count as usize {
            if self.is_full {
                return;
            }
            self.read += 1;
            around.suffix = format!("{}{i:0digits$}{outer}", separator.unwrap_or_default());
            for child in &element.children {
                self.child(child, &around);
            }
            around.frame *= step;
        }
    }

    fn body(&mut self, element: &Element, around: &Around) {
        self.defaults.check(element, "childclass", self.log);
        leave_out_unknown(element, &BODY, self.log);
        let outer = around.link.map_or_else(Isometry3::identity, |it| self.robot.links[it].pose);
        let own = self.compiler.pose(element, self.log);
        let pose = if self.compiler.is_global { own } else { outer * around.frame * own };
        let link = self.robot.links.len();
        let name = element.get("name").map(|name| format!("{name}{}", around.suffix));
        if let Some(name) = &name
            && self.robot.links.iter().any(|link| link.name == *name)
        {
            let message = format!("there is another body '{}'", config::shown(name));
            self.log.problem(Problem { place: element.place_of("name"), message });
        }
        let name = name.unwrap_or_else(|| own_name(element));
        self.robot.links.push(Link::new(&name, element.place(), pose));
        self.given.push(None);
        let inner = Around {
            link: Some(link),
            frame: if self.compiler.is_global { pose.inverse() } else { Isometry3::identity() },
            class: element.get("childclass").unwrap_or(&around.class).into(),
            suffix: around.suffix.clone(),
        };
        self.joint(element, &inner, around.link);
        for child in &element.children {
            self.child(child, &inner);
        }
    }

    /// All joints of a body, which are one of several axes here; without any it's fixed.
    fn joint(&mut self, body: &Element, around: &Around, parent: Option<usize>) {
        let Some(child) = around.link else { return };
        let index = self.robot.joints.len();
        let mut joint = Joint {
            name: self.robot.links[child].name.clone(),
            place: body.place(),
            parent,
            child,
            axes: Vec::new(),
            floats: false,
        };
        for element in
            body.children.iter().filter(|it| ["joint", "freejoint"].contains(&it.name.as_str()))
        {
            let whole = self.defaults.apply(element, &around.class, self.log);
            let Some(kind) = self.kind(&whole) else { continue };
            let name = whole.get("name").map(|name| format!("{name}{}", around.suffix));
            if let Some(name) = &name {
                self.joints.insert(name.clone(), [index, joint.axes.len()]);
                if joint.axes.is_empty() {
                    joint.name.clone_from(name);
                }
            }
            if kind == "free" {
                joint.floats = true;
                if parent.is_some() {
                    let message = "a free joint must be of a body in the world itself";
                    self.log.problem(element.problem(message));
                }
                continue;
            }
            if kind == "fixed" {
                continue;
            }
            let pose = match self.compiler.is_global {
                true => Isometry3::identity(),
                false => self.robot.links[child].pose,
            };
            let before = joint.axes.len();
            if let Some([lower, upper]) = whole.numbers("actuatorfrcrange", self.log) {
                self.most.push(([index, before], f64::max(-lower, upper)));
            }
            joint.axes.extend(self.axes(&whole, kind, &pose));
            for axis in &mut joint.axes[before..] {
                let own = name.clone().unwrap_or_default();
                axis.name = if kind == "ball" { format!("{own} {}", axis.name) } else { own };
            }
        }
        self.robot.joints.push(joint);
    }

    fn kind(&self, joint: &Element) -> Option<&'static str> {
        // "fixed" is PyBullet's.
        let types = ["free", "ball", "slide", "hinge", "fixed"];
        match (joint.name.as_str(), joint.has("type")) {
            ("freejoint", _) => Some("free"),
            (_, true) => joint.word("type", &types, self.log),
            _ => Some("hinge"),
        }
    }

    fn axes(&self, joint: &Element, kind: &str, pose: &Isometry3<f64>) -> Vec<Axis> {
        let log = self.log;
        let anchor = pose * nalgebra::Point3::from(joint.vector("pos", log).unwrap_or_default());
        let unit = if kind == "slide" { 1.0 } else { self.compiler.angle_rad };
        let range = joint.numbers::<2>("range", log).map(|range| range.map(|end| end * unit));
        let limited = match joint.get("limited").unwrap_or("auto") {
            "auto" => self.compiler.autolimits && range.is_some(),
            word => word == "true",
        };
        let range = range.filter(|_| limited);
        leave_out_unknown(joint, &JOINT, log);
        if joint.number("armature", log).is_some_and(|armature| armature != 0.0) {
            log.left_out("joint/armature", joint.place_of("armature"));
        }
        let number = |name: &str| joint.number(name, log).unwrap_or_default();
        let (reference, stiffness) = (number("ref") * unit, number("stiffness"));
        let rest = number("springref") * unit - reference;
        let dress = |mut axis: Axis| {
            axis.range = range.map(|range| range.map(|end| end - reference));
            axis.damping = number("damping").max(0.0);
            axis.friction = number("frictionloss").max(0.0);
            axis.spring = (stiffness > 0.0).then_some(Spring { stiffness, rest });
            axis
        };
        if kind == "ball" {
            let frame = Isometry3::from_parts(anchor.coords.into(), pose.rotation);
            // The range of a ball is that of its whole angle.
            let range = range.map(|[_, most]| [-most, most]);
            return ball(&frame)
                .map(|axis| {
                    let name = axis.name.clone();
                    Axis { name, range, ..dress(axis) }
                })
                .into();
        }
        let direction = joint.vector("axis", log).unwrap_or(Vector3::z());
        let Some(direction) = Unit::try_new(direction, 1e-9) else {
            let message = "axis of <joint> must be a direction, got 0 0 0".into();
            log.problem(Problem { place: joint.place_of("axis"), message });
            return Vec::new();
        };
        let motion = if kind == "slide" { Motion::Slides } else { Motion::Turns };
        let direction = Unit::new_normalize(pose.rotation * direction.into_inner());
        vec![dress(Axis::new(motion, direction, anchor))]
    }

    fn geom(&mut self, element: &Element, link: usize, around: &Around) {
        let whole = self.defaults.apply(element, &around.class, self.log);
        let Self { meshes, compiler, files, log, .. } = *self;
        let Some(geom) = Geom::read(&whole, &around.frame, meshes, compiler, files, log) else {
            return;
        };
        let ground = self.world.friction.unwrap_or_default();
        let geom = Geom { friction: geom.friction.max(ground), ..geom };
        let colour = whole.list("rgba", log).and_then(|rgba| colour(&rgba));
        let own = &mut self.robot.links[link].colour;
        *own = own.or(colour);
        self.geoms.push((link, geom));
    }

    /// A geom of the world: the ground is a plane at 0 here.
    fn ground(&mut self, element: &Element, around: &Around) {
        let whole = self.defaults.apply(element, &around.class, self.log);
        let masks = Masks::read(&whole, self.log);
        let collides = masks.types != 0 || masks.affinity != 0;
        if whole.get("type") != Some("plane") {
            if collides {
                self.log.left_out("worldbody/geom", element.place());
            } else {
                self.log.set_aside("worldbody/geom", element.place());
            }
            return;
        }
        let pose = around.frame * self.compiler.pose(&whole, self.log);
        if !collides {
            return;
        }
        self.world.masks.push(masks);
        let friction = friction(&whole, self.log);
        self.world.friction = Some(self.world.friction.map_or(friction, |it| it.max(friction)));
        if (pose.rotation * Vector3::z()).z > 0.999 {
            let height = pose.translation.vector.z;
            self.world.ground_m = Some(self.world.ground_m.map_or(height, |it| it.min(height)));
        } else {
            self.log.left_out("worldbody/geom plane that isn't level", element.place());
        }
    }
}

/// What a body without a name is called by: its joint, or its geom.
fn own_name(body: &Element) -> String {
    let named = |kind| body.children(kind).find_map(|it| it.get("name"));
    named("joint").or_else(|| named("geom")).unwrap_or("body").into()
}

fn inertial(
    element: &Element,
    frame: &Isometry3<f64>,
    compiler: &Compiler,
    log: &Log,
) -> Option<Inertial> {
    element.required("mass", log)?;
    let mass_kg = element.number("mass", log)?;
    if mass_kg < 0.0 {
        let message = format!("mass of <inertial> must be 0 or more, got {mass_kg}");
        log.problem(Problem { place: element.place_of("mass"), message });
        return None;
    }
    if mass_kg == 0.0 {
        return None;
    }
    let tensor = if let Some([xx, yy, zz, xy, xz, yz]) = element.numbers("fullinertia", log) {
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    } else {
        Matrix3::from_diagonal(&element.vector("diaginertia", log).unwrap_or_default())
    };
    let own = Inertial { mass_kg, centre_m: Vector3::zeros().into(), tensor_kg_m2: tensor };
    Some(own.seen_from(&(frame * compiler.pose(element, log))))
}
