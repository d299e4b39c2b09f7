//! SDF, Gazebo's format: links, joints and frames of a model, each posed relative to another.
//!
//! <http://sdformat.org/spec>

use std::collections::BTreeMap;

use config::{Problem, shown};
use nalgebra::{Isometry3, Matrix3, Unit, Vector3};

use crate::{
    robot::{
        Axis, Inertial, Joint, Link, Motion, Motor, MotorKind, Robot, Shape, Solid, Spring, ball,
        roll_pitch_yaw,
    },
    tree::MOST_PARTS,
    urdf::colour,
    xml::{Element, LARGEST, Log},
};

/// Models in models, at most.
const DEEPEST: usize = 20;

pub(crate) fn read(root: &Element, log: &Log) -> Option<Robot> {
    let model = choose(root, log)?;
    let mut reader = Reader { frames: BTreeMap::new(), robot: Robot::new("robot"), log };
    reader.robot.name = model.get("name").unwrap_or("robot").into();
    let is_static =
        model.child("static").is_some_and(|it| ["true", "1"].contains(&it.text.as_str()));
    reader.model(model, "", &Isometry3::identity(), 0);
    let mut robot = reader.robot;
    if robot.links.is_empty() {
        if log.result().is_ok() {
            log.problem(model.problem("a model must have a <link>, got none"));
        }
        return None;
    }
    if is_static {
        let place = model.place();
        let name = "base".into();
        robot.joints.push(Joint {
            name,
            place,
            parent: None,
            child: 0,
            axes: vec![],
            floats: false,
        });
    }
    Some(robot)
}

/// The robot among the models of a world: the one that moves with the most links.
fn choose<'a>(root: &'a Element, log: &Log) -> Option<&'a Element> {
    let mut models: Vec<&Element> = root.children("model").collect();
    for world in root.children("world") {
        models.extend(world.children("model"));
        let others = world.children.iter().filter(|it| it.name != "model");
        for other in others {
            let element = format!("world/{}", other.name);
            match other.name.as_str() {
                "light" | "scene" | "gui" | "physics" | "plugin" => {
                    log.set_aside(&element, other.place())
                }
                _ => log.left_out(&element, other.place()),
            }
        }
    }
    let links = |model: &Element| model.children("link").count();
    let moves = |model: &Element| {
        !model.child("static").is_some_and(|it| it.text == "true" || it.text == "1")
    };
    let key = |model: &Element| (moves(model), links(model));
    let Some(best) = models.iter().map(|model| key(model)).max() else {
        log.problem(root.problem("a file must have a <model>, got none"));
        return None;
    };
    let chosen = models.iter().position(|model| key(model) == best)?;
    for (i, other) in models.iter().enumerate() {
        if i != chosen {
            let kind = if moves(other) { "another model" } else { "scenery" };
            log.left_out(&format!("world/model: {kind}"), other.place());
        }
    }
    Some(models[chosen])
}

/// What has a pose: a link, a joint, a frame or a model.
struct Frame<'a> {
    /// Its full name's frame that the pose is relative to, as written.
    element: &'a Element,
    relative_to: Option<String>,
    /// Where names are looked up: `outer::`.
    scope: String,
    /// The link that it's part of, as far as known.
    attached_to: Option<String>,
    pose: Isometry3<f64>,
}

struct Reader<'a> {
    /// By full name.
    frames: BTreeMap<String, Frame<'a>>,
    robot: Robot,
    log: &'a Log,
}

impl<'a> Reader<'a> {
    fn model(&mut self, model: &'a Element, scope: &str, pose: &Isometry3<f64>, depth: usize) {
        if depth > DEEPEST {
            let message = format!("at most {DEEPEST} models in each other expected, got more");
            self.log.problem(model.problem(message));
            return;
        }
        self.model_frames(model, scope, pose, depth);
        if depth > 0 {
            return;
        }
        // All frames are known: poses can be found.
        let links = self.sections(model, scope, "link");
        if links.len().max(self.frames.len() / 4) > MOST_PARTS {
            let message =
                format!("at most {MOST_PARTS} links and as many joints expected, got more");
            self.log.problem(model.problem(message));
            return;
        }
        for (scope, element) in &links {
            self.link(element, scope);
        }
        let names: BTreeMap<String, usize> =
            self.robot.links.iter().enumerate().map(|(i, link)| (link.name.clone(), i)).collect();
        for (scope, element) in self.sections(model, scope, "joint") {
            self.joint(element, &scope, &names);
        }
        self.leave_out(model);
    }

    /// All elements of a kind, of models within, too, each with its scope.
    fn sections(&self, model: &'a Element, scope: &str, kind: &str) -> Vec<(String, &'a Element)> {
        let mut found = Vec::new();
        for child in &model.children {
            if child.name == kind {
                found.push((scope.to_owned(), child));
            } else if child.name == "model" {
                let inner = format!("{scope}{}::", child.get("name").unwrap_or_default());
                found.extend(self.sections(child, &inner, kind));
            }
        }
        found
    }

    fn leave_out(&mut self, model: &Element) {
        for child in &model.children {
            match child.name.as_str() {
                "link" | "joint" | "frame" | "pose" | "static" => {}
                "model" => self.leave_out(child),
                "self_collide" => {
                    self.robot.self_collision = Some(["true", "1"].contains(&child.text.as_str()));
                }
                // What a program does with a model that nobody touches.
                "allow_auto_disable" | "enable_wind" => {}
                name => self.log.left_out(&format!("model/{name}"), child.place()),
            }
        }
    }

    fn model_frames(
        &mut self,
        model: &'a Element,
        scope: &str,
        outer: &Isometry3<f64>,
        depth: usize,
    ) {
        if depth > DEEPEST {
            return;
        }
        self.frames.insert(
            format!("{scope}__model__"),
            Frame {
                element: model,
                relative_to: None,
                scope: scope.into(),
                attached_to: model
                    .get("canonical_link")
                    .map(|link| format!("{scope}{link}"))
                    .or_else(|| {
                        model
                            .child("link")
                            .and_then(|link| link.get("name"))
                            .map(|it| format!("{scope}{it}"))
                    }),
                pose: *outer,
            },
        );
        for child in &model.children {
            let kind = child.name.as_str();
            if !["link", "joint", "frame", "model"].contains(&kind) {
                continue;
            }
            let Some(name) = child.required("name", self.log) else { continue };
            let full = format!("{scope}{name}");
            let (pose, relative_to) = self.pose(child);
            if kind == "model" {
                let pose = outer * pose;
                self.model_frames(child, &format!("{full}::"), &pose, depth + 1);
                continue;
            }
            let attached_to = match kind {
                "frame" => child.get("attached_to").map(str::to_owned),
                _ => child.child("child").map(|child| child.text.clone()),
            };
            // A joint is where its child is, a frame where what it's attached to is.
            let relative_to =
                relative_to.or_else(|| attached_to.clone().filter(|_| kind != "link"));
            let attached_to = if kind == "link" { None } else { attached_to };
            let frame =
                Frame { element: child, relative_to, scope: scope.into(), attached_to, pose };
            if self.frames.insert(full, frame).is_some() {
                let message = format!("there is another '{}' in its model", shown(name));
                self.log.problem(child.problem(message));
            }
        }
    }

    /// A pose, and what it's relative to where that is said.
    fn pose(&self, element: &Element) -> (Isometry3<f64>, Option<String>) {
        let Some(pose) = element.child("pose") else { return (Isometry3::identity(), None) };
        let relative_to = pose.get("relative_to").filter(|name| !name.is_empty());
        let relative_to = relative_to.map(str::to_owned);
        if pose.text.is_empty() {
            return (Isometry3::identity(), relative_to);
        }
        let degrees = pose.get("degrees").is_some_and(|it| ["true", "1"].contains(&it));
        let unit = if degrees { 1_f64.to_radians() } else { 1.0 };
        if pose.get("rotation_format") == Some("quat_xyzw") {
            let numbers = pose.own_numbers::<7>(self.log).unwrap_or([0.0; 7]);
            let [x, y, z, i, j, k, w] = numbers;
            let turn =
                nalgebra::UnitQuaternion::try_new(nalgebra::Quaternion::new(w, i, j, k), 1e-9);
            let position = Vector3::new(x, y, z).into();
            return (Isometry3::from_parts(position, turn.unwrap_or_default()), relative_to);
        }
        let [x, y, z, roll, pitch, yaw] = pose.own_numbers::<6>(self.log).unwrap_or([0.0; 6]);
        let turn = roll_pitch_yaw([roll, pitch, yaw].map(|angle| angle * unit));
        (Isometry3::from_parts(Vector3::new(x, y, z).into(), turn), relative_to)
    }

    /// Where something is in the drawing.
    fn placed(&self, full: &str) -> Option<Isometry3<f64>> {
        let mut pose = Isometry3::identity();
        let mut name = full.to_owned();
        // A chain longer than there are frames goes round.
        for _ in 0..=self.frames.len() {
            let frame = self.frames.get(&name)?;
            pose = frame.pose * pose;
            if name.ends_with("__model__") {
                return Some(pose);
            }
            name = match &frame.relative_to {
                Some(other) if other == "world" => return Some(pose),
                Some(other) => {
                    let other_full = format!("{}{other}", frame.scope);
                    let other_full = if self.frames.contains_key(&other_full) {
                        other_full
                    } else {
                        // A model within is found by its own frame.
                        format!("{other_full}::__model__")
                    };
                    if !self.frames.contains_key(&other_full) {
                        self.unknown(frame.element, other, &frame.scope);
                        return None;
                    }
                    other_full
                }
                None => format!("{}__model__", frame.scope),
            };
        }
        let element = self.frames.get(full)?.element;
        let message = "poses must not be relative to each other in a circle";
        self.log.problem(element.problem(message));
        None
    }

    fn unknown(&self, element: &Element, name: &str, scope: &str) {
        let known = self.frames.keys().filter_map(|known| known.strip_prefix(scope));
        let likely = self.log.likely(name, known);
        let message = format!(
            "<{}> must refer to a link, a joint or a frame of its model, got \"{}\"{likely}",
            element.name,
            shown(name)
        );
        self.log.problem(Problem { place: element.place(), message });
    }

    fn link(&mut self, element: &Element, scope: &str) {
        let log = self.log;
        let Some(name) = element.get("name") else { return };
        let full = format!("{scope}{name}");
        let Some(pose) = self.placed(&full) else { return };
        let mut link = Link::new(&full, element.place(), pose);
        for child in &element.children {
            match child.name.as_str() {
                "pose" | "inertial" | "gravity" | "kinematic" => {}
                "self_collide" if ["true", "1"].contains(&child.text.as_str()) => {
                    self.robot.self_collision = Some(true);
                }
                "self_collide" | "enable_wind" => {}
                "collision" => {
                    link.shapes.extend(self.shape(child));
                    link.friction = link.friction.or_else(|| friction(child, log));
                }
                "visual" => {
                    link.seen.extend(self.shape(child));
                    let diffuse = child.child("material").and_then(|it| it.child("diffuse"));
                    link.colour = link.colour.or(diffuse.and_then(|it| colour(&it.own_list(log)?)));
                }
                "sensor" if child.get("type") == Some("contact") => {
                    self.robot.touch.push(self.robot.links.len());
                }
                "light" | "projector" => {
                    log.set_aside(&format!("link/{}", child.name), child.place())
                }
                name => log.left_out(&format!("link/{name}"), child.place()),
            }
        }
        link.inertial = self.inertial(element);
        self.robot.links.push(link);
    }

    /// What is missing is 1 kg, or 1 kg m^2 about each axis, as SDF has it.
    fn inertial(&self, link: &Element) -> Option<Inertial> {
        let log = self.log;
        let inertial = link.child("inertial");
        let mass = inertial.and_then(|it| it.number_in("mass", log));
        let inertia = inertial.and_then(|it| it.child("inertia"));
        if mass.is_none() {
            log.chose("a link without <mass>", "1 kg, as SDF has it");
        }
        if inertia.is_none() {
            log.chose("a link without <inertia>", "1 kg m² about each axis, as SDF has it");
        }
        if let Some(found) = mass.filter(|mass| *mass < 0.0) {
            let place = inertial.and_then(|it| it.child("mass")).unwrap_or(link);
            log.problem(place.problem(format!("<mass> must be 0 or more, got {found}")));
        }
        if mass == Some(0.0) {
            return None;
        }
        let number =
            |name, default| inertia.and_then(|it| it.number_in(name, log)).unwrap_or(default);
        let (xy, xz, yz) = (number("ixy", 0.0), number("ixz", 0.0), number("iyz", 0.0));
        let tensor = Matrix3::new(
            number("ixx", 1.0),
            xy,
            xz, //
            xy,
            number("iyy", 1.0),
            yz, //
            xz,
            yz,
            number("izz", 1.0),
        );
        let own = Inertial {
            mass_kg: mass.unwrap_or(1.0),
            centre_m: Vector3::zeros().into(),
            tensor_kg_m2: tensor,
        };
        let pose = inertial.map_or_else(Isometry3::identity, |it| self.pose(it).0);
        Some(own.seen_from(&pose))
    }

    fn shape(&self, element: &Element) -> Option<Shape> {
        let log = self.log;
        let geometry = element.child("geometry")?;
        let solid = geometry.children.first()?;
        let missing = |what: &str| {
            if solid.child(what).is_none() {
                log.problem(
                    solid.problem(format!("<{}> must have a <{what}>, got none", solid.name)),
                );
            }
        };
        let number = |what: &str| {
            missing(what);
            solid.number_in(what, log)
        };
        let vector = |what: &str| {
            missing(what);
            solid.numbers_in::<3>(what, log).map(Vector3::from)
        };
        let found = match solid.name.as_str() {
            "box" => Solid::Box(vector("size")? / 2.0),
            "sphere" => Solid::Ball(number("radius")?),
            "cylinder" => Solid::Cylinder(number("radius")?, number("length")? / 2.0),
            "capsule" => Solid::Capsule(number("radius")?, number("length")? / 2.0),
            "ellipsoid" => Solid::Ellipsoid(vector("radii")?),
            "mesh" => {
                missing("uri");
                let scale = solid.numbers_in("scale", log).unwrap_or([1.0; 3]);
                let uri = solid.child("uri")?.text.clone();
                Solid::Mesh { uri, file: None, scale: scale.into() }
            }
            name => {
                log.left_out(&format!("{}/geometry/{name}", element.name), solid.place());
                return None;
            }
        };
        Some(Shape { place: solid.place(), pose: self.pose(element).0, solid: found })
    }

    fn joint(&mut self, element: &'a Element, scope: &str, names: &BTreeMap<String, usize>) {
        let log = self.log;
        let Some(name) = element.get("name") else { return };
        let full = format!("{scope}{name}");
        let types = [
            "revolute",
            "continuous",
            "prismatic",
            "fixed",
            "ball",
            "universal",
            "revolute2",
            "screw",
            "gearbox",
        ];
        element.required("type", log);
        let Some(kind) = element.word("type", &types, log) else { return };
        if kind == "gearbox" {
            log.left_out("joint of type gearbox", element.place());
            return;
        }
        let end = |end: &str| {
            let Some(found) = element.child(end) else {
                log.problem(element.problem(format!("<joint> must have a <{end}>, got none")));
                return None;
            };
            if found.text == "world" {
                return Some(None);
            }
            let link = self.link_of(&format!("{scope}{}", found.text), names);
            if link.is_none() {
                self.unknown(found, &found.text, scope);
            }
            link.map(Some)
        };
        let (Some(parent), Some(child)) = (end("parent"), end("child")) else { return };
        let Some(child) = child else {
            log.left_out("joint whose child is the world", element.place());
            return;
        };
        let Some(frame) = self.placed(&full) else { return };
        let axes = self.axes(element, kind, &frame, parent, scope);
        for child in &element.children {
            match child.name.as_str() {
                "parent" | "child" | "pose" | "axis" | "axis2" => {}
                name => log.left_out(&format!("joint/{name}"), child.place()),
            }
        }
        let place = element.place();
        let joint = Joint { name: full, place, parent, child, axes, floats: false };
        self.robot.joints.push(joint);
    }

    /// The link that a name stands for, or that a frame of that name is attached to.
    fn link_of(&self, full: &str, names: &BTreeMap<String, usize>) -> Option<usize> {
        let mut name = full.to_owned();
        for _ in 0..=self.frames.len() {
            if let Some(link) = names.get(&name) {
                return Some(*link);
            }
            let (scope, attached) = match self.frames.get(&name) {
                Some(frame) => (frame.scope.clone(), frame.attached_to.clone()),
                None => (String::new(), Some(format!("{name}::__model__"))),
            };
            let attached = attached?;
            // Those of models have their scope in them.
            name = if self.frames.contains_key(&attached) {
                attached
            } else {
                format!("{scope}{attached}")
            };
        }
        None
    }

    fn axes(
        &self,
        element: &Element,
        kind: &str,
        frame: &Isometry3<f64>,
        parent: Option<usize>,
        scope: &str,
    ) -> Vec<Axis> {
        let log = self.log;
        let anchor = frame * nalgebra::Point3::origin();
        let named = |mut axis: Axis, name: &str| {
            axis.name = name.into();
            axis
        };
        match kind {
            "fixed" => Vec::new(),
            "ball" => ball(frame).into(),
            _ => {
                if kind == "screw" {
                    log.left_out("joint/thread_pitch: a screw's shift", element.place());
                }
                let wanted: &[&str] = if kind == "universal" || kind == "revolute2" {
                    &["axis", "axis2"]
                } else {
                    &["axis"]
                };
                let mut axes = Vec::new();
                for name in wanted {
                    let axis = element.child(name);
                    if axis.is_none() {
                        log.problem(
                            element.problem(format!("<joint> must have an <{name}>, got none")),
                        );
                    }
                    let Some(axis) = axis else { continue };
                    let motion = if kind == "prismatic" { Motion::Slides } else { Motion::Turns };
                    let Some(direction) = self.direction(axis, frame, parent, scope) else {
                        continue;
                    };
                    let mut read = Axis::new(motion, direction, anchor);
                    limits(&mut read, axis, kind == "continuous", log);
                    axes.push(if wanted.len() > 1 { named(read, name) } else { read });
                }
                axes
            }
        }
    }

    /// In the drawing.
    fn direction(
        &self,
        axis: &Element,
        frame: &Isometry3<f64>,
        parent: Option<usize>,
        scope: &str,
    ) -> Option<Unit<Vector3<f64>>> {
        let log = self.log;
        let xyz = axis.child("xyz");
        let written = xyz.map_or(Some([0.0, 0.0, 1.0]), |xyz| xyz.own_numbers(log))?;
        let Some(direction) = Unit::try_new(Vector3::from(written), 1e-9) else {
            log.problem(axis.problem("<xyz> must be a direction, got 0 0 0"));
            return None;
        };
        let old = axis.child("use_parent_model_frame");
        let expressed_in = xyz.and_then(|xyz| xyz.get("expressed_in")).filter(|it| !it.is_empty());
        let rotation = match expressed_in {
            Some(name) => {
                let full = format!("{scope}{name}");
                if name == "__model__" {
                    self.frames.get(&full)?.pose.rotation
                } else if self.frames.contains_key(&full) {
                    self.placed(&full)?.rotation
                } else {
                    self.unknown(axis, name, scope);
                    return None;
                }
            }
            None if old.is_some_and(|it| ["true", "1"].contains(&it.text.as_str())) => {
                let _ = parent;
                self.frames.get(&format!("{scope}__model__"))?.pose.rotation
            }
            None => frame.rotation,
        };
        Some(Unit::new_normalize(rotation * direction.into_inner()))
    }
}

fn limits(axis: &mut Axis, element: &Element, continuous: bool, log: &Log) {
    let limit = element.child("limit");
    let number = |name| limit.and_then(|limit| limit.number_in(name, log));
    let lower = number("lower").unwrap_or(-LARGEST);
    let upper = number("upper").unwrap_or(LARGEST);
    if !continuous && (lower > -LARGEST || upper < LARGEST) {
        axis.range = Some([lower, upper]);
    }
    if let Some(dynamics) = element.child("dynamics") {
        let number = |name| dynamics.number_in(name, log).unwrap_or_default();
        axis.damping = number("damping");
        axis.friction = number("friction");
        let (stiffness, rest) = (number("spring_stiffness"), number("spring_reference"));
        axis.spring = (stiffness > 0.0).then_some(Spring { stiffness, rest });
    }
    let is_wheel = axis.range.is_none() && axis.motion == Motion::Turns;
    axis.motor = Some(Motor {
        kind: if is_wheel { MotorKind::Speed } else { MotorKind::Position },
        speed: number("velocity"),
        effort: number("effort"),
    });
}

fn friction(collision: &Element, log: &Log) -> Option<f64> {
    let friction = collision.child("surface")?.child("friction")?;
    let bullet = friction.child("bullet").and_then(|it| it.number_in("friction", log));
    bullet.or_else(|| friction.child("ode")?.number_in("mu", log))
}
