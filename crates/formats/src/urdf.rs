//! URDF: links and joints by name, each joint with its frame in its parent's.
//!
//! <https://docs.ros.org/en/rolling/p/urdfdom/> and the ROS wiki's `urdf/XML`.

use std::collections::BTreeMap;

use config::shown;
use nalgebra::{Isometry3, Matrix3, Unit, Vector3};

use crate::{
    robot::{
        Axis, Inertial, Joint, Link, Motion, Motor, MotorKind, Robot, Shape, Solid, across, ball,
        roll_pitch_yaw,
    },
    tree,
    xml::{Element, Log},
};

/// Names of links to their indices.
type Names<'a> = BTreeMap<&'a str, usize>;

pub(crate) fn read(root: &Element, log: &Log) -> Option<Robot> {
    let mut robot = Robot::new(root.get("name").unwrap_or_default());
    let colours = colours(root, log);
    let mut names = Names::new();
    for element in root.children("link") {
        let Some(name) = element.required("name", log) else { continue };
        if names.insert(name, robot.links.len()).is_some() {
            log.problem(element.problem(format!("there is another link '{}'", shown(name))));
        }
        robot.links.push(link(element, name, &colours, log));
    }
    if root.child("link").is_none() {
        log.problem(root.problem("a robot must have a <link>, got none"));
    }
    let mut frames = Vec::new();
    for element in root.children("joint") {
        if let Some((joint, frame)) = joint(element, &names, log) {
            robot.joints.push(joint);
            frames.push(frame);
        }
    }
    for element in &root.children {
        match element.name.as_str() {
            "link" | "joint" | "material" => {}
            "gazebo" => gazebo(element, &names, &mut robot, log),
            name => log.left_out(name, element.place()),
        }
    }
    log.result().ok()?;
    draw(&mut robot, &frames, log)?;
    Some(robot)
}

/// Puts all links where they are with all joints at 0, and the joints' axes with them.
fn draw(robot: &mut Robot, frames: &[Isometry3<f64>], log: &Log) -> Option<()> {
    let order = tree::order(robot, log)?;
    robot.joints = order.iter().map(|&joint| robot.joints[joint].clone()).collect();
    for (joint, &written) in robot.joints.iter_mut().zip(&order) {
        let parent = joint.parent.map_or_else(Isometry3::identity, |it| robot.links[it].pose);
        let frame = parent * frames[written];
        robot.links[joint.child].pose = frame;
        joint.axes.iter_mut().for_each(|axis| axis.carried(&frame));
    }
    Some(())
}

fn link(element: &Element, name: &str, colours: &BTreeMap<&str, [u8; 3]>, log: &Log) -> Link {
    let mut link = Link::new(name, element.place(), Isometry3::identity());
    for child in &element.children {
        match child.name.as_str() {
            "inertial" => link.inertial = inertial(child, log),
            "collision" => link.shapes.extend(shape(child, log)),
            "visual" => {
                link.seen.extend(shape(child, log));
                if let Some(material) = child.child("material") {
                    let named = material.get("name").and_then(|name| colours.get(name).copied());
                    link.colour = link.colour.or(material_colour(material, log)).or(named);
                }
            }
            "contact" => {
                for property in &child.children {
                    match property.name.as_str() {
                        "lateral_friction" => link.friction = property.number("value", log),
                        name => log.left_out(&format!("link/contact/{name}"), property.place()),
                    }
                }
            }
            name => log.left_out(&format!("link/{name}"), child.place()),
        }
    }
    link
}

/// `xyz` and `rpy` of an element's `origin`.
fn origin(element: &Element, log: &Log) -> Isometry3<f64> {
    let Some(origin) = element.child("origin") else { return Isometry3::identity() };
    let position = origin.vector("xyz", log).unwrap_or_default();
    let rotation = roll_pitch_yaw(origin.numbers("rpy", log).unwrap_or_default());
    Isometry3::from_parts(position.into(), rotation)
}

fn inertial(element: &Element, log: &Log) -> Option<Inertial> {
    let mass = element.child("mass")?;
    let mass_kg = mass.number("value", log)?;
    if mass_kg < 0.0 {
        let place = mass.place_of("value");
        let message = format!("value of <mass> must be 0 or more, got {mass_kg}");
        log.problem(config::Problem { place, message });
    }
    if mass_kg <= 0.0 {
        return None;
    }
    let inertia = element.child("inertia");
    let number = |name| inertia.and_then(|it| it.number(name, log)).unwrap_or_default();
    let (xy, xz, yz) = (number("ixy"), number("ixz"), number("iyz"));
    let tensor = Matrix3::new(
        number("ixx"),
        xy,
        xz, //
        xy,
        number("iyy"),
        yz, //
        xz,
        yz,
        number("izz"),
    );
    let own = Inertial { mass_kg, centre_m: Vector3::zeros().into(), tensor_kg_m2: tensor };
    Some(own.seen_from(&origin(element, log)))
}

fn shape(element: &Element, log: &Log) -> Option<Shape> {
    let Some(geometry) = element.child("geometry") else {
        log.problem(
            element.problem(format!("<{}> must have a <geometry>, got none", element.name)),
        );
        return None;
    };
    let solid = geometry.children.first()?;
    let number = |name: &str| {
        solid.required(name, log)?;
        solid.number(name, log)
    };
    let found = match solid.name.as_str() {
        "box" => {
            solid.required("size", log)?;
            Solid::Box(solid.vector("size", log)? / 2.0)
        }
        "sphere" => Solid::Ball(number("radius")?),
        "cylinder" => Solid::Cylinder(number("radius")?, number("length")? / 2.0),
        "capsule" => Solid::Capsule(number("radius")?, number("length")? / 2.0),
        "mesh" => Solid::Mesh {
            uri: solid.required("filename", log)?.into(),
            file: None,
            scale: match solid.get("scale") {
                Some(_) => solid.vector("scale", log)?,
                None => Vector3::repeat(1.0),
            },
        },
        name => {
            log.left_out(&format!("{}/geometry/{name}", element.name), solid.place());
            return None;
        }
    };
    Some(Shape { place: solid.place(), pose: origin(element, log), solid: found })
}

/// A joint, and its frame in its parent's. Its axis is along the axes of that frame so far.
fn joint(element: &Element, names: &Names<'_>, log: &Log) -> Option<(Joint, Isometry3<f64>)> {
    let name = element.required("name", log);
    let ends = ["parent", "child"].map(|end| {
        let Some(end) = element.child(end) else {
            log.problem(element.problem(format!("<joint> must have a <{end}>, got none")));
            return None;
        };
        let link = end.required("link", log)?;
        let found = names.get(link).copied();
        if found.is_none() {
            let likely = log.likely(link, names.keys().copied());
            let message = format!(
                "link of <{}> must be a link's name, got \"{}\"{likely}",
                end.name,
                shown(link)
            );
            log.problem(config::Problem { place: end.place_of("link"), message });
        }
        found
    });
    element.required("type", log)?;
    // "spherical" is PyBullet's.
    let types = ["revolute", "continuous", "prismatic", "fixed", "floating", "planar", "spherical"];
    let kind = element.word("type", &types, log)?;
    let axes = axes(element, kind, log);
    for child in &element.children {
        match child.name.as_str() {
            "parent" | "child" | "origin" | "axis" | "limit" | "dynamics" => {}
            name => log.left_out(&format!("joint/{name}"), child.place()),
        }
    }
    let [Some(parent), Some(child)] = ends else { return None };
    let joint = Joint {
        name: name?.into(),
        place: element.place(),
        parent: Some(parent),
        child,
        axes,
        floats: kind == "floating",
    };
    Some((joint, origin(element, log)))
}

fn axes(element: &Element, kind: &str, log: &Log) -> Vec<Axis> {
    let direction = match element.child("axis").filter(|axis| axis.has("xyz")) {
        Some(axis) => {
            let Some(xyz) = axis.vector("xyz", log) else { return Vec::new() };
            let direction = Unit::try_new(xyz, 1e-9);
            if direction.is_none() && !["fixed", "floating", "spherical"].contains(&kind) {
                let place = axis.place_of("xyz");
                let message = "xyz of <axis> must be a direction, got 0 0 0".into();
                log.problem(config::Problem { place, message });
            }
            direction.unwrap_or(Vector3::x_axis())
        }
        None => Vector3::x_axis(),
    };
    let axis = |motion, direction| Axis::new(motion, direction, Vector3::zeros().into());
    match kind {
        "revolute" | "continuous" => {
            let mut axis = axis(Motion::Turns, direction);
            limits(&mut axis, element, kind, log);
            vec![axis]
        }
        "prismatic" => {
            let mut axis = axis(Motion::Slides, direction);
            limits(&mut axis, element, kind, log);
            vec![axis]
        }
        // In the plane across the axis, and about it.
        "planar" => {
            let [first, second] = across(&direction);
            [(Motion::Slides, first), (Motion::Slides, second), (Motion::Turns, direction)]
                .map(|(motion, direction)| axis(motion, direction))
                .into()
        }
        "spherical" => ball(&Isometry3::identity()).into(),
        _ => Vec::new(),
    }
}

fn limits(axis: &mut Axis, element: &Element, kind: &str, log: &Log) {
    let limit = element.child("limit");
    let number = |name| limit.and_then(|limit| limit.number(name, log));
    let has_range = limit.is_some_and(|limit| limit.has("lower") || limit.has("upper"));
    if kind != "continuous" && has_range {
        let [lower, upper] = ["lower", "upper"].map(|end| number(end).unwrap_or_default());
        axis.range = Some([lower, upper]);
    } else if kind != "continuous" {
        log.chose("a joint without <limit lower upper>", "moves without end");
    }
    if let Some(dynamics) = element.child("dynamics") {
        axis.damping = dynamics.number("damping", log).unwrap_or_default();
        axis.friction = dynamics.number("friction", log).unwrap_or_default();
    }
    let is_wheel = axis.range.is_none() && axis.motion == Motion::Turns;
    axis.motor = Some(Motor {
        kind: if is_wheel { MotorKind::Speed } else { MotorKind::Position },
        speed: number("velocity"),
        effort: number("effort"),
    });
}

/// Colours of the robot's own materials.
fn colours<'a>(root: &'a Element, log: &Log) -> BTreeMap<&'a str, [u8; 3]> {
    let visuals = root.children("link").flat_map(|link| link.children("visual"));
    let inner = visuals.flat_map(|visual| visual.children("material"));
    let materials = root.children("material").chain(inner);
    materials.filter_map(|it| Some((it.get("name")?, material_colour(it, log)?))).collect()
}

fn material_colour(material: &Element, log: &Log) -> Option<[u8; 3]> {
    colour(&material.child("color")?.list("rgba", log)?)
}

/// Of shares of full light: red, green, blue, and whatever follows.
pub(crate) fn colour(shares: &[f64]) -> Option<[u8; 3]> {
    let byte = |share: f64| (share.clamp(0.0, 1.0) * 255.0).round() as u8;
    shares.first_chunk::<3>().map(|shares| shares.map(byte))
}

/// What Gazebo reads beside the robot: friction and contact sensors of links are carried over.
fn gazebo(element: &Element, names: &Names<'_>, robot: &mut Robot, log: &Log) {
    let link = element.get("reference").and_then(|name| names.get(name).copied());
    for child in &element.children {
        let contact = child.name == "sensor" && child.get("type") == Some("contact");
        match (child.name.as_str(), link) {
            ("mu1", Some(link)) => {
                let friction = match child.text.as_str() {
                    "" => child.number("value", log),
                    _ => child.own_numbers(log).map(|[mu]| mu),
                };
                robot.links[link].friction = robot.links[link].friction.or(friction);
            }
            ("sensor", Some(link)) if contact => robot.touch.push(link),
            ("material" | "visual", _) => log.set_aside("gazebo/material", child.place()),
            (name, _) => log.left_out(&format!("gazebo/{name}"), child.place()),
        }
    }
}
