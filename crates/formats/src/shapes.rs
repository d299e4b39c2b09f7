//! Shapes that a model can have: meshes are found, what is only seen stands in where nothing collides,
//! and a box with a link's inertia where there is nothing else.

use nalgebra::{Isometry3, Vector3};

use crate::{
    files::Files,
    names::quoted,
    robot::{Robot, Shape, Solid},
    weight::principal_frame,
    xml::Log,
};

/// Sizes that a model file takes, in m.
const SHORTEST_M: f64 = 1e-4;
const LONGEST_M: f64 = 1e3;

/// Half the least size of a box that stands in for a mesh, in m.
const THINNEST_M: f64 = 5e-3;

/// Of a model file.
const MOST_FRICTION: f64 = 10.0;

/// Shapes of a body, at most.
const MOST_SHAPES: usize = 256;

/// Finds all meshes, and leaves out those that can't be used, with the reason. What is only seen is
/// looked at where a link has nothing that collides.
pub(crate) fn find_meshes(robot: &mut Robot, files: &Files, log: &Log) {
    for link in &mut robot.links {
        let had_shapes = !link.shapes.is_empty();
        link.shapes.retain_mut(|shape| found(shape, files, log));
        let seen = std::mem::take(&mut link.seen);
        if link.shapes.is_empty() && !had_shapes && !seen.is_empty() {
            let mut seen = seen;
            seen.retain_mut(|shape| found(shape, files, log));
            if !seen.is_empty() {
                log.chose(
                    "a link with nothing that collides: what is seen of it does",
                    &quoted(&link.name),
                );
            }
            link.shapes = seen;
        } else {
            seen.iter().for_each(|shape| log.set_aside("visual", shape.place.clone()));
        }
    }
}

/// Complains about sizes below 0, and leaves out shapes that have none.
pub(crate) fn check(robot: &mut Robot, log: &Log) {
    for link in &mut robot.links {
        for shapes in [&mut link.shapes, &mut link.seen] {
            shapes.retain(|shape| {
                let is_solid = shape.solid.is_solid();
                if shape.solid.is_negative() {
                    let message = "the sizes of a shape must be above 0".into();
                    log.problem(config::Problem { place: shape.place.clone(), message });
                } else if !is_solid {
                    log.left_out("a shape without a size", shape.place.clone());
                }
                is_solid
            });
        }
    }
}

/// Keeps friction within what a model file takes.
pub(crate) fn bound_friction(robot: &mut Robot, log: &Log) {
    for friction in robot.links.iter_mut().filter_map(|link| link.friction.as_mut()) {
        if !(0.0..=MOST_FRICTION).contains(friction) {
            log.chose("friction that no model has", &format!("{friction} is 0 to {MOST_FRICTION}"));
            *friction = friction.clamp(0.0, MOST_FRICTION);
        }
    }
}

fn found(shape: &mut Shape, files: &Files, log: &Log) -> bool {
    let Solid::Mesh { uri, file, scale } = &mut shape.solid else { return true };
    let found = files.mesh(uri).and_then(|(path, mesh)| {
        let corners = mesh.corners.iter().map(|it| it.coords.component_mul(scale).norm());
        let reach = corners.fold(0.0, f64::max);
        let fits = (SHORTEST_M..=LONGEST_M).contains(&reach);
        fits.then_some(path).ok_or_else(|| format!("reaches {reach} m: no size of a shape"))
    });
    match found {
        Ok(path) => {
            *file = Some(path);
            true
        }
        Err(why) => {
            log.left_out_since(&format!("mesh {}", config::shown(uri)), shape.place.clone(), &why);
            false
        }
    }
}

/// Leaves no shape outside the sizes of a model file, and gives links that had only meshes which
/// can't be used the box that their inertia is that of.
pub(crate) fn stand_in(robot: &mut Robot, had_mesh: &[bool], log: &Log) {
    let reaches: Vec<f64> = (0..robot.links.len()).map(|link| reach_m(robot, link)).collect();
    for (i, link) in robot.links.iter_mut().enumerate() {
        for shape in &mut link.shapes {
            bound(shape, log);
        }
        if link.shapes.len() > MOST_SHAPES {
            let more = link.shapes.split_off(MOST_SHAPES);
            more.iter().for_each(|it| {
                log.left_out("a shape beyond the 256th of a link", it.place.clone())
            });
        }
        if !link.shapes.is_empty() || !had_mesh[i] {
            continue;
        }
        let (Some(inertial), Some((frame, moments))) = (link.inertial, principal_frame(link))
        else {
            continue;
        };
        let half = moments.map(|moment| {
            let square = 1.5 * (moments.sum() - 2.0 * moment) / inertial.mass_kg;
            libm::sqrt(square.max(0.0)).clamp(THINNEST_M, reaches[i])
        });
        link.shapes.push(Shape {
            place: link.place.clone(),
            pose: link.pose.inverse() * frame,
            solid: Solid::Box(half),
        });
        log.chose(
            "the shape of a link whose mesh can't be used: a box with its inertia",
            &quoted(&link.name),
        );
    }
}

/// How far a link reaches at most: to the farthest of its joints, in m. Inertia is often made up.
fn reach_m(robot: &Robot, link: usize) -> f64 {
    let Some((frame, _)) = principal_frame(&robot.links[link]) else { return LONGEST_M };
    let own = robot.joints.iter().filter(|joint| joint.child == link || joint.parent == Some(link));
    let away = own.map(|joint| {
        let anchor = joint.axes.first().map_or_else(
            || robot.links[joint.child].pose.translation.vector,
            |axis| axis.anchor_m.coords,
        );
        (anchor - frame.translation.vector).norm()
    });
    let farthest = away.fold(0.0, f64::max);
    if farthest > THINNEST_M { farthest } else { 20.0 * THINNEST_M }
}

fn bound(shape: &mut Shape, log: &Log) {
    let clamp = |length: &mut f64, least: f64| {
        if !(least..=LONGEST_M).contains(&*length) {
            log.chose(
                "a size that no shape has",
                &format!("{length} m is {least} to {LONGEST_M} m"),
            );
            *length = length.clamp(least, LONGEST_M);
        }
    };
    match &mut shape.solid {
        Solid::Box(v) | Solid::Ellipsoid(v) => v.iter_mut().for_each(|it| clamp(it, SHORTEST_M)),
        Solid::Ball(r) => clamp(r, SHORTEST_M),
        Solid::Cylinder(r, half) => {
            clamp(r, SHORTEST_M);
            clamp(half, SHORTEST_M);
        }
        Solid::Capsule(r, half) => {
            clamp(r, SHORTEST_M);
            if *half < SHORTEST_M {
                shape.solid = Solid::Ball(*r);
            }
        }
        Solid::Mesh { .. } => {}
    }
}

/// The lowest point of a link, in m; `None` of one without shapes.
pub(crate) fn lowest_m(robot: &Robot, link: usize, files: &Files) -> Option<f64> {
    let link = &robot.links[link];
    let lowest = link.shapes.iter().map(|shape| {
        let pose: Isometry3<f64> = link.pose * shape.pose;
        let down = pose.rotation.inverse() * -Vector3::z();
        let mesh = match &shape.solid {
            Solid::Mesh { uri, .. } => files.mesh(uri).ok().map(|(_, mesh)| mesh),
            _ => None,
        };
        pose.translation.vector.z - shape.solid.reach_m(&down, mesh.as_deref())
    });
    lowest.min_by(f64::total_cmp)
}
