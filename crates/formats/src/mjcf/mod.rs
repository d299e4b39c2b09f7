//! MJCF, MuJoCo's format: bodies in bodies, each with the joints to the one around it.
//!
//! <https://mujoco.readthedocs.io/en/stable/XMLreference.html>

mod actuator;
mod body;
mod compiler;
mod defaults;
mod geom;
mod include;

use std::collections::BTreeMap;

use config::Problem;

use self::{
    body::Reader,
    compiler::Compiler,
    defaults::Defaults,
    geom::{Geom, Masks},
    include::Includer,
};
use crate::{
    files::Files,
    robot::{Inertial, Link, Robot},
    xml::{Element, Log},
};

pub(crate) fn read(root: Element, files: &Files, log: &Log) -> Option<Robot> {
    let mut includer = Includer::new(&root, files, log);
    let root = includer.expand(root);
    log.result().ok()?;
    let compiler = Compiler::read(&root, log);
    let defaults = Defaults::read(&root, log);
    let assets = root.children("asset").flat_map(|assets| assets.children("mesh"));
    let meshes: Vec<_> = assets.map(|mesh| defaults.apply(mesh, "main", log)).collect();
    let mut reader = Reader::new(&compiler, &defaults, &meshes, files, log);
    root.children("worldbody").for_each(|world| reader.world(world));
    let Reader { mut robot, geoms, world, given, joints, sites, most, .. } = reader;
    robot.name = root.get("model").unwrap_or("MuJoCo Model").into();
    if robot.links.is_empty() && log.result().is_ok() {
        log.problem(root.problem("a model must have a <body> in its <worldbody>, got none"));
    }
    log.result().ok()?;
    weigh(&mut robot, &geoms, &given, &compiler, log);
    collide(&mut robot, geoms, &world.masks, log);
    robot.ground_m = world.ground_m;
    let names = Names { joints, sites };
    for section in &root.children {
        names.section(section, &defaults, &mut robot, log);
    }
    for ([joint, axis], most) in most {
        if let Some(motor) = robot.joints[joint].axes.get_mut(axis).and_then(|it| it.motor.as_mut())
        {
            motor.effort = Some(motor.effort.map_or(most, |effort| effort.min(most)));
        }
    }
    Some(robot)
}

/// What the world has that matters to a robot.
#[derive(Debug, Default)]
struct World {
    /// Of its geoms.
    masks: Vec<Masks>,
    /// Of its lowest level plane.
    ground_m: Option<f64>,
    /// Of its planes.
    friction: Option<f64>,
}

/// Gives links their mass, as the compiler's settings say.
fn weigh(
    robot: &mut Robot,
    geoms: &[(usize, Geom)],
    given: &[Option<Inertial>],
    compiler: &Compiler,
    log: &Log,
) {
    for (i, link) in robot.links.iter_mut().enumerate() {
        let own = geoms.iter().filter(|(link, _)| *link == i);
        let parts: Vec<_> = own.filter_map(|(_, geom)| geom.inertial).collect();
        let from_geoms = Inertial::sum(&parts);
        link.inertial = match compiler.inertia_from_geom {
            compiler::InertiaFromGeom::Always => from_geoms,
            compiler::InertiaFromGeom::Never => given[i],
            compiler::InertiaFromGeom::IfNotGiven => given[i].or(from_geoms),
        };
        if let Some(inertial) = &mut link.inertial {
            bound(inertial, compiler, log);
        }
    }
    if let Some(total) = compiler.total_mass_kg {
        let factor = total / robot.mass_kg();
        for inertial in robot.links.iter_mut().filter_map(|link| link.inertial.as_mut()) {
            inertial.mass_kg *= factor;
            inertial.tensor_kg_m2 *= factor;
        }
    }
}

fn bound(inertial: &mut Inertial, compiler: &Compiler, log: &Log) {
    inertial.mass_kg = inertial.mass_kg.max(compiler.least_mass_kg);
    let (moments, axes) = inertial.principal();
    let mut bounded = moments.map(|moment| moment.max(compiler.least_inertia_kg_m2));
    let largest = bounded.max();
    if compiler.balance_inertia && 2.0 * largest > bounded.sum() {
        bounded = nalgebra::Vector3::repeat(bounded.mean());
        log.chose("moments that no body can have", "their mean, as balanceinertia says");
    }
    if bounded != moments {
        let tensor = nalgebra::Matrix3::from_diagonal(&bounded);
        inertial.tensor_kg_m2 = crate::solid::turned(&tensor, &axes);
    }
}

/// Shapes that collide with the ground or with others, and those that are only seen.
fn collide(robot: &mut Robot, geoms: Vec<(usize, Geom)>, world: &[Masks], log: &Log) {
    let parent: BTreeMap<usize, Option<usize>> =
        robot.joints.iter().map(|joint| (joint.child, joint.parent)).collect();
    let above = |link: usize| parent.get(&link).copied().flatten();
    let kinds: Vec<(usize, Masks)> = geoms.iter().map(|(link, geom)| (*link, geom.masks)).collect();
    let touches = |link: usize, masks: Masks| {
        kinds.iter().any(|&(other, theirs)| {
            let apart = other != link && above(other) != Some(link) && above(link) != Some(other);
            apart && masks.collide(theirs)
        })
    };
    let default = [Masks { types: 1, affinity: 1 }];
    let world = if world.is_empty() { &default } else { world };
    let mut kept: Vec<(Masks, config::Place)> = Vec::new();
    let mut self_collision = false;
    for (link, geom) in geoms {
        let grounded = world.iter().any(|masks| geom.masks.collide(*masks));
        let touching = touches(link, geom.masks);
        let link = &mut robot.links[link];
        if grounded || touching {
            self_collision |= touching;
            kept.push((geom.masks, geom.shape.place.clone()));
            link.friction = link.friction.or(Some(geom.friction));
            link.shapes.push(geom.shape);
        } else {
            link.seen.push(geom.shape);
        }
    }
    robot.self_collision = Some(self_collision);
    let differ = kept.iter().any(|(masks, _)| *masks != kept[0].0);
    for (_, place) in kept.into_iter().filter(|_| differ) {
        log.left_out("geom/contype and conaffinity that differ", place);
    }
}

/// What other sections refer to.
struct Names {
    /// Joints by name, each a joint and an axis of it.
    joints: BTreeMap<String, [usize; 2]>,
    /// Links of sites.
    sites: BTreeMap<String, usize>,
}

impl Names {
    fn section(&self, section: &Element, defaults: &Defaults, robot: &mut Robot, log: &Log) {
        match section.name.as_str() {
            "compiler" | "default" | "worldbody" | "size" => {}
            "asset" | "visual" | "statistic" => {
                let looks = section.children.iter().filter(|it| it.name != "mesh");
                looks.for_each(|it| {
                    log.set_aside(&format!("{}/{}", section.name, it.name), it.place())
                });
            }
            "option" => option(section, log),
            "actuator" => {
                let find = |name: &str| self.joints.get(name).copied();
                for element in &section.children {
                    actuator::read(element, defaults, find, robot, log);
                }
            }
            "sensor" => section.children.iter().for_each(|it| self.sensor(it, robot, log)),
            "contact" => {
                for element in &section.children {
                    match element.name.as_str() {
                        "exclude" => exclude(element, robot, log),
                        name => log.left_out(&format!("contact/{name}"), element.place()),
                    }
                }
            }
            "custom" | "keyframe" => {
                for element in &section.children {
                    log.set_aside(&format!("{}/{}", section.name, element.name), element.place());
                }
            }
            name => {
                for element in &section.children {
                    log.left_out(&format!("{name}/{}", element.name), element.place());
                }
            }
        }
    }

    fn sensor(&self, sensor: &Element, robot: &mut Robot, log: &Log) {
        let site = sensor.get("site").and_then(|site| self.sites.get(site));
        match (sensor.name.as_str(), site) {
            // All axes are sensed anyway.
            ("jointpos" | "actuatorpos", _) => {}
            ("touch", Some(&link)) => robot.touch.push(link),
            (name, _) => log.left_out(&format!("sensor/{name}"), sensor.place()),
        }
    }
}

/// Settings of a simulation belong to an experiment; gravity does, too, but changes what a robot is.
fn option(option: &Element, log: &Log) {
    for attribute in &option.attributes {
        let name = attribute.name.as_str();
        if name == "gravity" {
            let gravity = option.vector(name, log);
            let usual =
                |it: nalgebra::Vector3<f64>| it.xy().norm() < 1e-9 && (it.z + 9.81).abs() < 0.02;
            if gravity.is_none_or(usual) {
                continue;
            }
        }
        let element = format!("option/{name}");
        if ["gravity", "density", "viscosity", "wind", "magnetic"].contains(&name) {
            log.left_out(&element, option.place_of(name));
        } else {
            log.set_aside(&element, option.place_of(name));
        }
    }
    for child in &option.children {
        log.set_aside(&format!("option/{}", child.name), child.place());
    }
}

fn exclude(exclude: &Element, robot: &mut Robot, log: &Log) {
    let bodies = ["body1", "body2"].map(|name| {
        let body = exclude.required(name, log)?;
        let found = robot.links.iter().position(|link: &Link| link.name == body);
        if found.is_none() && body != "world" {
            let message = format!(
                "{name} of <exclude> must be the name of a <body>, got \"{}\"",
                config::shown(body)
            );
            log.problem(Problem { place: exclude.place_of(name), message });
        }
        found
    });
    match bodies {
        [Some(a), Some(b)] => robot.no_collision.push([a, b]),
        _ => log.left_out("contact/exclude with the world", exclude.place()),
    }
}
