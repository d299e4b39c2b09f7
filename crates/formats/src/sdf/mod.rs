//! SDF, Gazebo's format: links, joints and frames of a model, each posed relative to another.
//!
//! <http://sdformat.org/spec>

mod frames;
mod joint;

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Vector3};

use self::frames::Frame;
use crate::{
    robot::{Inertial, Link, Robot, Shape, Solid},
    stand,
    tree::MOST_PARTS,
    urdf::colour,
    xml::{Element, Log},
};

pub(crate) fn read(root: &Element, log: &Log) -> Option<Robot> {
    let model = choose(root, log)?;
    let mut reader = Reader { frames: BTreeMap::new(), robot: Robot::new("robot"), log };
    reader.robot.name = model.get("name").unwrap_or("robot").into();
    let is_static =
        model.child("static").is_some_and(|it| ["true", "1"].contains(&it.text.as_str()));
    reader.model(model);
    let mut robot = reader.robot;
    if robot.links.is_empty() {
        if log.result().is_ok() {
            log.problem(model.problem("a model must have a <link>, got none"));
        }
        return None;
    }
    if is_static {
        stand::fix(&mut robot, 0);
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

struct Reader<'a> {
    /// By full name.
    frames: BTreeMap<String, Frame<'a>>,
    robot: Robot,
    log: &'a Log,
}

impl<'a> Reader<'a> {
    fn model(&mut self, model: &'a Element) {
        let scope = "";
        self.model_frames(model, scope, &Isometry3::identity());
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
}

fn friction(collision: &Element, log: &Log) -> Option<f64> {
    let friction = collision.child("surface")?.child("friction")?;
    let bullet = friction.child("bullet").and_then(|it| it.number_in("friction", log));
    bullet.or_else(|| friction.child("ode")?.number_in("mu", log))
}
