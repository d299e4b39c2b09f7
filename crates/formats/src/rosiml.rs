//! RoSiML, the format of YARS: bodies where they are, and actuators between them.
//!
//! As YARS reads it: a joint's pose is relative to the position of its source body, along the axes of
//! the world. A hinge turns about the x axis of that pose. A `generic` one counts its angles
//! left-handed, and turns about z first, then y, then x, of its source. Angles are in degrees; a pose
//! is turned by alpha, beta and gamma about the fixed x, y and z.

use std::collections::BTreeMap;

use config::{Problem, shown};
use nalgebra::{Isometry3, Point3, Unit, Vector3};

use crate::{
    robot::{
        Axis, Inertial, Joint, Link, Motion, Motor, MotorKind, Robot, Shape, Solid, Spring,
        roll_pitch_yaw,
    },
    stand, tree,
    xml::{Element, Log},
};

/// Kinds of bodies.
const BODIES: [&str; 6] = ["box", "sphere", "capsule", "cylinder", "ply", "composite"];

pub(crate) fn read(root: &Element, log: &Log) -> Option<Robot> {
    let mut robots = root.children("robots").flat_map(|robots| robots.children("robot"));
    let Some(element) = robots.next() else {
        log.problem(root.problem("a file must have <robots> with a <robot>, got none"));
        return None;
    };
    robots.for_each(|other| log.left_out("robots/robot: another one", other.place()));
    leave_out(root, log);
    let mut robot = Robot::new(element.get("name").unwrap_or("robot"));
    robot.forward = Vector3::y();
    let names = bodies(element, &mut robot, log);
    if robot.links.is_empty() {
        if log.result().is_ok() {
            log.problem(element.problem("a robot must have a <body> with parts in it, got none"));
        }
        return None;
    }
    if !tree::is_small(&robot, log) {
        return None;
    }
    for actuator in element.children("actuators").flat_map(|it| &it.children) {
        robot.joints.extend(joint(actuator, &names, &robot.links, log));
    }
    sensors(element, &names, &mut robot, log);
    for child in &element.children {
        match child.name.as_str() {
            "body" | "actuators" | "sensors" => {}
            "controller" => log.set_aside("robot/controller", child.place()),
            name => log.left_out(&format!("robot/{name}"), child.place()),
        }
    }
    root_at_the_middle(&mut robot);
    Some(robot)
}

/// Reads all bodies; returns their links by their names.
fn bodies(element: &Element, robot: &mut Robot, log: &Log) -> BTreeMap<String, usize> {
    let mut names = BTreeMap::new();
    for bodies in element.children("body") {
        if let Some(word) = bodies.word("selfCollide", &["true", "false"], log) {
            robot.self_collision = Some(word == "true");
        }
        for body in &bodies.children {
            if !BODIES.contains(&body.name.as_str()) {
                log.left_out(&format!("body/{}", body.name), body.place());
                continue;
            }
            let Some(name) = body.required("name", log) else { continue };
            let index = robot.links.len();
            if names.insert(name.to_owned(), index).is_some() {
                log.problem(body.problem(format!("there is another body '{}'", shown(name))));
            }
            robot.links.push(link(body, name, log));
            // Parts of a composite are known by their names, too.
            let parts = body.child("geometry").into_iter().flat_map(|it| &it.children);
            for part in parts.filter_map(|part| part.get("name")) {
                names.entry(part.to_owned()).or_insert(index);
            }
        }
    }
    names
}

fn sensors(element: &Element, names: &BTreeMap<String, usize>, robot: &mut Robot, log: &Log) {
    for sensor in element.children("sensors").flat_map(|it| &it.children) {
        let object = sensor.child("object").and_then(|it| it.get("name"));
        let link = object.and_then(|name| names.get(name));
        match (sensor.name.as_str(), link) {
            // All axes are sensed anyway.
            ("deflection", _) => {}
            ("contact" | "binary" | "binaryContact", Some(&link)) => robot.touch.push(link),
            (name, _) => log.left_out(&format!("sensors/{name}"), sensor.place()),
        }
    }
}

/// What belongs to the simulator and its screen.
fn leave_out(root: &Element, log: &Log) {
    for child in &root.children {
        match child.name.as_str() {
            "robots" => {}
            "screens" | "traces" => log.set_aside(&child.name, child.place()),
            "environment" => {
                for part in child.children.iter().filter(|it| it.name != "ground") {
                    log.left_out(&format!("environment/{}", part.name), part.place());
                }
            }
            name => log.set_aside(name, child.place()),
        }
    }
}

fn pose(element: &Element, log: &Log) -> Isometry3<f64> {
    let Some(pose) = element.child("pose") else { return Isometry3::identity() };
    let number = |name| pose.number(name, log).unwrap_or_default();
    let position = Vector3::new(number("x"), number("y"), number("z"));
    let unit = if pose.get("type") == Some("rad") { 1.0 } else { 1_f64.to_radians() };
    let angles = [number("alpha"), number("beta"), number("gamma")].map(|angle| angle * unit);
    Isometry3::from_parts(position.into(), roll_pitch_yaw(angles))
}

fn link(body: &Element, name: &str, log: &Log) -> Link {
    let mut link = Link::new(name, body.place(), pose(body, log));
    let parts: Vec<&Element> = match body.child("geometry") {
        Some(parts) if body.name == "composite" => parts.children.iter().collect(),
        _ => vec![body],
    };
    let mut weights = Vec::new();
    for part in parts {
        let pose = if body.name == "composite" { pose(part, log) } else { Isometry3::identity() };
        let mass = part.child("physics").and_then(|it| it.child("mass"));
        let mass_kg = mass.and_then(|mass| mass.number("kg", log)).unwrap_or_default();
        if let Some(mass) = mass.filter(|_| mass_kg < 0.0) {
            let message = format!("kg of <mass> must be 0 or more, got {mass_kg}");
            log.problem(Problem { place: mass.place_of("kg"), message });
        }
        let Some(solid) = solid(part, log) else { continue };
        let shape = Shape { place: part.place(), pose, solid };
        if mass_kg > 0.0 {
            weights.push(match shape.solid {
                // What a ply holds is only known to Bullet's hull: it's given its stand-in's moments.
                Solid::Mesh { .. } => Inertial {
                    mass_kg,
                    centre_m: pose.translation.vector.into(),
                    tensor_kg_m2: nalgebra::Matrix3::zeros(),
                },
                _ => shape.filled(mass_kg),
            });
        }
        link.shapes.push(shape);
    }
    link.inertial = Inertial::sum(&weights);
    if let Some(inertial) = &mut link.inertial
        && body.name == "composite"
    {
        // A compound's centre of mass is its origin in Bullet.
        inertial.centre_m = Point3::origin();
    }
    let physics = body.child("physics");
    link.friction =
        physics.and_then(|it| it.child("friction")).and_then(|it| it.number("value", log));
    for part in physics.into_iter().flat_map(|it| &it.children) {
        if !["mass", "friction"].contains(&part.name.as_str()) {
            log.left_out(&format!("physics/{}", part.name), part.place());
        }
    }
    link
}

fn solid(part: &Element, log: &Log) -> Option<Solid> {
    let size = |name: &str| {
        let Some(dimension) = part.child("dimension") else {
            log.problem(part.problem(format!("<{}> must have a <dimension>, got none", part.name)));
            return None;
        };
        dimension.required(name, log)?;
        dimension.number(name, log)
    };
    match part.name.as_str() {
        "box" => {
            Some(Solid::Box(Vector3::new(size("width")?, size("depth")?, size("height")?) / 2.0))
        }
        "sphere" => Some(Solid::Ball(size("radius")?)),
        "capsule" => Some(Solid::Capsule(size("radius")?, size("height")? / 2.0)),
        "cylinder" => Some(Solid::Cylinder(size("radius")?, size("height")? / 2.0)),
        "ply" => Some(Solid::Mesh {
            uri: part.required("filename", log)?.into(),
            file: None,
            scale: Vector3::repeat(1.0),
        }),
        name => {
            log.left_out(&format!("geometry/{name}"), part.place());
            None
        }
    }
}

fn joint(
    element: &Element,
    names: &BTreeMap<String, usize>,
    links: &[Link],
    log: &Log,
) -> Option<Joint> {
    let kind = element.name.as_str();
    if !["hinge", "slider", "fixed", "generic"].contains(&kind) {
        log.left_out(&format!("actuators/{kind}"), element.place());
        return None;
    }
    let name = element.required("name", log)?;
    let body = |end: &str| {
        let found = element.child(end)?;
        let name = found.required("name", log)?;
        let link = names.get(name).copied();
        if link.is_none() {
            let likely = log.likely(name, names.keys().map(String::as_str));
            let message =
                format!("name of <{end}> must be a body's, got \"{}\"{likely}", shown(name));
            log.problem(Problem { place: found.place_of("name"), message });
        }
        link
    };
    if element.child("source").is_none() {
        log.problem(element.problem(format!("<{kind}> must have a <source>, got none")));
    }
    let source = body("source")?;
    let destination = match element.child("destination") {
        Some(_) => Some(body("destination")?),
        None => None,
    };
    let frame = pose(element, log);
    let position = &frame.translation.vector;
    let global = element.child("pose").and_then(|it| it.get("global")) == Some("true");
    let origin = if global { Vector3::zeros() } else { links[source].pose.translation.vector };
    let anchor = Point3::from(origin + position);
    let frame = Isometry3::from_parts(anchor.coords.into(), frame.rotation);
    let axes = match kind {
        "hinge" => vec![axis(element, &frame, Motion::Turns, Vector3::x(), log)],
        "slider" => vec![axis(element, &frame, Motion::Slides, Vector3::x(), log)],
        "generic" => generic(element, &frame, log),
        _ => Vec::new(),
    };
    let place = element.place();
    let (parent, child) = match destination {
        Some(destination) => (Some(source), destination),
        None => (None, source),
    };
    Some(Joint { name: name.into(), place, parent, child, axes, floats: false })
}

fn generic(element: &Element, frame: &Isometry3<f64>, log: &Log) -> Vec<Axis> {
    let mut axes = Vec::new();
    let directions = [("z", Vector3::z()), ("y", Vector3::y()), ("x", Vector3::x())];
    for (section, motion) in [("translational", Motion::Slides), ("rotational", Motion::Turns)] {
        let Some(section) = element.child(section) else { continue };
        for (name, direction) in directions {
            let Some(own) = section.child(name) else { continue };
            let direction = if motion == Motion::Turns { -direction } else { direction };
            let mut axis = axis(own, frame, motion, direction, log);
            axis.name = if motion == Motion::Turns { name.into() } else { format!("along {name}") };
            axes.push(axis);
        }
    }
    axes
}

/// An axis of a joint's frame, with what its element says.
fn axis(
    element: &Element,
    frame: &Isometry3<f64>,
    motion: Motion,
    direction: Vector3<f64>,
    log: &Log,
) -> Axis {
    let direction = Unit::new_normalize(frame.rotation * direction);
    let mut axis = Axis::new(motion, direction, frame.translation.vector.into());
    let ends = |name: &str| {
        let element = element.child(name)?;
        Some([element.number("min", log)?, element.number("max", log)?])
    };
    let unit = if motion == Motion::Turns { 1_f64.to_radians() } else { 1.0 };
    axis.range = ends("deflection").map(|range| range.map(|end| end * unit));
    axis.reversed = ends("mapping").is_some_and(|[from, to]| from > to);
    axis.friction = element.number("friction", log).unwrap_or_default();
    let most = |name: &str| element.child(name).and_then(|it| it.number("max", log));
    if element.get("mode") != Some("passive") {
        let kind = match element.get("type").unwrap_or_default() {
            "velocity" => MotorKind::Speed,
            "force" => MotorKind::Torque,
            _ => MotorKind::Position,
        };
        axis.motor = Some(Motor { kind, speed: most("velocity"), effort: most("force") });
    }
    if let Some(spring) = element.child("spring") {
        let number = |name| spring.number(name, log).unwrap_or_default();
        axis.damping = number("damping");
        axis.spring = Some(Spring { stiffness: number("stiffness"), rest: 0.0 });
    }
    for child in &element.children {
        let known = [
            "source",
            "destination",
            "pose",
            "force",
            "velocity",
            "deflection",
            "mapping",
            "spring",
        ];
        if !known.contains(&child.name.as_str()) {
            log.left_out(&format!("{}/{}", element.name, child.name), child.place());
        }
    }
    axis
}

/// Source and destination are no parent and child: the tree's root is the body that most joints are
/// at, or one that can't move, and joints that point towards it are turned round.
fn root_at_the_middle(robot: &mut Robot) {
    let joints_at = |link: usize| {
        robot
            .joints
            .iter()
            .filter(|joint| joint.parent == Some(link) || joint.child == link)
            .count()
    };
    let key = |link: &usize| (robot.links[*link].inertial.is_none(), joints_at(*link));
    let Some(best) = (0..robot.links.len()).map(|link| key(&link)).max() else { return };
    let Some(root) = (0..robot.links.len()).find(|link| key(link) == best) else { return };
    if robot.links[root].inertial.is_none() {
        // What weighs nothing doesn't move in Bullet.
        stand::fix(robot, root);
    }
    let mut reached = vec![false; robot.links.len()];
    let mut waiting = vec![root];
    reached[root] = true;
    while let Some(link) = waiting.pop() {
        for joint in &mut robot.joints {
            let Some(parent) = joint.parent else { continue };
            let other = if parent == link { joint.child } else { parent };
            if (parent != link && joint.child != link) || reached[other] {
                continue;
            }
            if joint.child == link {
                turn_round(joint, link, other);
            }
            reached[other] = true;
            waiting.push(other);
        }
    }
}

/// What moves the child by an angle in front of the parent moves the parent by its opposite in front
/// of the child, the last turn first.
fn turn_round(joint: &mut Joint, parent: usize, child: usize) {
    joint.parent = Some(parent);
    joint.child = child;
    joint.axes.reverse();
    for axis in &mut joint.axes {
        axis.direction = -axis.direction;
    }
}
