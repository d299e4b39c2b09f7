//! What links weigh: moments that no body can have are replaced, and frames that nothing weighs are
//! taken into the links that they're fixed to.

use nalgebra::{Isometry3, Matrix3, Point3};

use crate::{
    compound,
    names::quoted,
    robot::{Inertial, Joint, Robot, Shape},
    stand,
    xml::Log,
};

/// The least that a body may weigh, in kg: as in a model file.
const LIGHTEST_KG: f64 = 1e-6;
const HEAVIEST_KG: f64 = 1e6;
const LEAST_KG_M2: f64 = 1e-15;
const MOST_KG_M2: f64 = 1e15;
const FARTHEST_M: f64 = 1e3;

/// Of what mass is made up for, in kg/m^3: water's.
const DENSITY: f64 = 1000.0;

/// Of a link that weighs nothing, moves and has others hanging on it, of the robot's mass.
const SHARE: f64 = 0.01;

/// Gives every link with a mass moments that a body can have.
pub(crate) fn mend_moments(robot: &mut Robot, log: &Log) {
    for link in &mut robot.links {
        let Some(inertial) = &mut link.inertial else { continue };
        if inertial.mass_kg > HEAVIEST_KG {
            let message = format!(
                "the mass of '{}' must be at most {HEAVIEST_KG:e} kg, got {}",
                link.name, inertial.mass_kg
            );
            log.problem(config::Problem { place: link.place.clone(), message });
        }
        if inertial.mass_kg < LIGHTEST_KG {
            log.chose("a mass below 1e-6 kg: counts as none", &quoted(&link.name));
            link.inertial = None;
            continue;
        }
        let tensor = &inertial.tensor_kg_m2;
        let moments = inertial.principal().0;
        if moments.min() >= LEAST_KG_M2 && tensor.iter().all(|it| it.is_finite()) {
            if 2.0 * moments.max() > moments.sum() * (1.0 + 1e-6) {
                log.chose(
                    "moments of inertia that no body has, one above the others' sum: kept",
                    &quoted(&link.name),
                );
            }
            continue;
        }
        let (filled, how) = filled(inertial.mass_kg, &link.shapes, &link.seen);
        inertial.tensor_kg_m2 = filled;
        log.chose(&format!("moments of inertia that aren't above 0: {how}"), &quoted(&link.name));
    }
}

/// A tensor about the centre of mass for a link that has a mass.
fn filled(mass_kg: f64, shapes: &[Shape], seen: &[Shape]) -> (Matrix3<f64>, &'static str) {
    for shapes in [shapes, seen] {
        let solids = shapes.iter().filter_map(|it| Some((it, it.solid.volume_m3()?)));
        let parts: Vec<_> = solids.map(|(shape, volume)| shape.filled(volume)).collect();
        if let Some(sum) = Inertial::sum(&parts) {
            return (sum.tensor_kg_m2 * (mass_kg / sum.mass_kg), "its shapes', filled evenly");
        }
    }
    let radius = libm::cbrt(mass_kg / DENSITY * 3.0 / (4.0 * std::f64::consts::PI));
    (Matrix3::identity() * (0.4 * mass_kg * radius * radius), "a ball's, of water")
}

/// Complains about what is beyond the bounds of a model file.
pub(crate) fn check_bounds(robot: &Robot, log: &Log) {
    let refuse = |place: &config::Place, message: String| {
        log.problem(config::Problem { place: place.clone(), message });
    };
    let frames: Vec<_> = robot.links.iter().map(principal_frame).collect();
    for (link, frame) in robot.links.iter().zip(&frames) {
        let Some((frame, moments)) = frame else { continue };
        let far = frame.translation.vector.amax();
        if far > FARTHEST_M {
            refuse(
                &link.place,
                format!("'{}' must be within {FARTHEST_M} m, got {far} m", link.name),
            );
        }
        if moments.max() > MOST_KG_M2 {
            let most = moments.max();
            refuse(
                &link.place,
                format!(
                    "moments of inertia of '{}' must be at most {MOST_KG_M2:e} kg m², got {most:e}",
                    link.name
                ),
            );
        }
    }
    for joint in &robot.joints {
        let parent =
            joint.parent.and_then(|it| frames[it]).map_or_else(Isometry3::identity, |it| it.0);
        let far = |axis: &crate::robot::Axis| (parent.inverse() * axis.anchor_m).coords.amax();
        if joint.axes.iter().any(|axis| far(axis) > FARTHEST_M) {
            let message =
                format!("joint '{}' must be within {FARTHEST_M} m of its parent", joint.name);
            refuse(&joint.place, message);
        }
    }
}

/// Takes out joints that hold nothing: what hangs on the world by one is free. A link that weighs
/// nothing is the world, if something floats above it.
pub(crate) fn let_float(robot: &mut Robot, log: &Log) {
    while let Some(index) = robot.joints.iter().position(|joint| joint.floats) {
        let joint = &robot.joints[index];
        let Some(parent) = joint.parent else {
            remove_joint(robot, index);
            continue;
        };
        let is_root = robot.joint_above(parent).is_none();
        let alone = robot.joints.iter().filter(|it| it.parent == Some(parent)).count() == 1;
        if is_root && alone && robot.links[parent].inertial.is_none() {
            remove_joint(robot, index);
            remove(robot, parent);
            continue;
        }
        let message = format!(
            "joint '{}' must not float: only what hangs on a root that weighs nothing can",
            joint.name
        );
        log.problem(config::Problem { place: joint.place.clone(), message });
        return;
    }
}

/// Leaves no link without a mass: frames are taken into what they're fixed to, joints on both sides of
/// one become one joint, ends are left out, and what remains is given a mass.
pub(crate) fn take_in_frames(robot: &mut Robot, log: &Log) {
    let mut frames = 0;
    while let Some(link) = robot.links.iter().rposition(|link| link.inertial.is_none()) {
        match take_in(robot, link, log) {
            Taken::Frame => frames += 1,
            Taken::Joined | Taken::Weighed => {}
            Taken::Away => return,
        }
    }
    if frames > 0 {
        log.chose("frames that nothing weighs: part of what they're fixed to", &frames.to_string());
    }
}

enum Taken {
    /// Into what it was fixed to.
    Frame,
    /// Two joints became one.
    Joined,
    /// It has a mass now.
    Weighed,
    /// Nothing can be done.
    Away,
}

fn take_in(robot: &mut Robot, link: usize, log: &Log) -> Taken {
    if robot.links.len() == 1 {
        return weighed(robot, link, log);
    }
    let above = robot.joint_above(link);
    let below: Vec<usize> =
        (0..robot.joints.len()).filter(|joint| robot.joints[*joint].parent == Some(link)).collect();
    if let Some(above) = above.filter(|it| is_fixed(&robot.joints[*it])) {
        return take_into(robot, link, robot.joints[above].parent, &below, log);
    }
    if let Some(child) = heaviest_fixed(robot, &below) {
        let (name, place) = (robot.links[child].name.clone(), robot.links[child].place.clone());
        merge(robot, child, link);
        let link = if child < link { link - 1 } else { link };
        robot.links[link].name = name;
        robot.links[link].place = place;
        return Taken::Frame;
    }
    let is_bare = robot.links[link].shapes.is_empty() && robot.links[link].seen.is_empty();
    match (above, below.as_slice()) {
        (None, below) => {
            let what = "a root that nothing weighs: the world's, so that the base is fixed";
            log.chose(what, &quoted(&robot.links[link].name));
            if let ([only], true) = (below, is_bare) {
                robot.joints[*only].parent = None;
                remove(robot, link);
                return Taken::Joined;
            }
            stand::fix(robot, link);
            weighed(robot, link, log)
        }
        (Some(above), []) if is_bare => {
            let place = robot.joints[above].place.clone();
            log.left_out("an end that nothing weighs, with its joint", place);
            remove(robot, link);
            Taken::Joined
        }
        (Some(above), [only]) if is_bare && joined(robot, above, *only) => Taken::Joined,
        _ => weighed(robot, link, log),
    }
}

fn is_fixed(joint: &Joint) -> bool {
    joint.axes.is_empty() && !joint.floats
}

/// A link that is fixed to another, or to the world.
fn take_into(
    robot: &mut Robot,
    link: usize,
    parent: Option<usize>,
    below: &[usize],
    log: &Log,
) -> Taken {
    match (parent, below) {
        (Some(parent), _) => merge(robot, link, parent),
        // The world's frame: what hangs on it hangs on the world.
        (None, [only]) if robot.links[link].shapes.is_empty() => {
            robot.joints[*only].parent = None;
            remove(robot, link);
        }
        (None, _) => return weighed(robot, link, log),
    }
    Taken::Frame
}

/// The heaviest of the links that hang on one by joints that are fixed, if any weighs something.
fn heaviest_fixed(robot: &Robot, below: &[usize]) -> Option<usize> {
    let fixed = below.iter().map(|joint| &robot.joints[*joint]).filter(|joint| is_fixed(joint));
    let mass = |link: usize| robot.links[link].inertial.map(|it| it.mass_kg);
    let weighing = fixed.filter_map(|joint| Some((mass(joint.child)?, joint.child)));
    weighing.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, child)| child)
}

/// Moves all that a link has into another, and its joints' ends; then it's gone, with the joint
/// between them.
fn merge(robot: &mut Robot, link: usize, into: usize) {
    let by = robot.links[into].pose.inverse() * robot.links[link].pose;
    let from = robot.links[link].clone();
    let moved = |shape: &Shape| Shape { pose: by * shape.pose, ..shape.clone() };
    let to = &mut robot.links[into];
    to.shapes.extend(from.shapes.iter().map(moved));
    to.seen.extend(from.seen.iter().map(moved));
    let parts: Vec<_> =
        [to.inertial, from.inertial.map(|it| it.seen_from(&by))].into_iter().flatten().collect();
    to.inertial = Inertial::sum(&parts);
    to.colour = to.colour.or(from.colour);
    to.friction = to.friction.or(from.friction);
    for joint in robot.joints.iter_mut().filter(|joint| joint.parent == Some(link)) {
        joint.parent = Some(into);
    }
    for touched in robot.touch.iter_mut().filter(|touched| **touched == link) {
        *touched = into;
    }
    for end in robot.no_collision.iter_mut().flatten().filter(|end| **end == link) {
        *end = into;
    }
    remove(robot, link);
}

/// Takes out a link and the joint that it's the child of; nothing hangs on it any more.
pub(crate) fn remove(robot: &mut Robot, link: usize) {
    if let Some(joint) = robot.joint_above(link) {
        remove_joint(robot, joint);
    }
    robot.links.remove(link);
    let shift = |index: &mut usize| *index -= usize::from(*index > link);
    for joint in &mut robot.joints {
        joint.parent.iter_mut().for_each(shift);
        shift(&mut joint.child);
    }
    robot.touch.retain(|touched| *touched != link);
    robot.touch.iter_mut().for_each(shift);
    robot.no_collision.retain(|[a, b]| *a != link && *b != link && a != b);
    robot.no_collision.iter_mut().flatten().for_each(shift);
}

pub(crate) fn remove_joint(robot: &mut Robot, joint: usize) {
    robot.joints.remove(joint);
    robot.actuators.retain(|[driven, _]| *driven != joint);
    robot.actuators.iter_mut().for_each(|[driven, _]| *driven -= usize::from(*driven > joint));
}

/// Makes one joint of two with a frame between them, if one can move as both do.
fn joined(robot: &mut Robot, above: usize, below: usize) -> bool {
    let (first, second) = (&robot.joints[above], &robot.joints[below]);
    if first.floats || second.floats {
        return false;
    }
    let named = |joint: &Joint| {
        joint
            .axes
            .iter()
            .cloned()
            .map(|mut axis| {
                if axis.name.is_empty() {
                    axis.name.clone_from(&joint.name);
                }
                axis
            })
            .collect::<Vec<_>>()
    };
    let axes = [named(first), named(second)].concat();
    if compound::fitting(&axes).len() < axes.len() {
        return false;
    }
    let (n, parent) = (first.axes.len(), first.parent);
    let frame = first.child;
    for driven in &mut robot.actuators {
        if driven[0] == below {
            driven[1] += n;
        } else if driven[0] == above {
            driven[0] = below;
        }
    }
    let joint = &mut robot.joints[below];
    (joint.parent, joint.axes) = (parent, axes);
    // Its own joint goes with it.
    remove(robot, frame);
    true
}

/// Gives a link a mass, which it had not.
fn weighed(robot: &mut Robot, link: usize, log: &Log) -> Taken {
    let total = robot.mass_kg();
    let link = &mut robot.links[link];
    let all = link.shapes.iter().chain(&link.seen);
    let solids = all.filter_map(|it| Some((it, it.solid.volume_m3()?)));
    let parts: Vec<_> = solids.map(|(shape, volume)| shape.filled(volume * DENSITY)).collect();
    let sum = Inertial::sum(&parts).filter(|it| (LIGHTEST_KG..HEAVIEST_KG).contains(&it.mass_kg));
    let how =
        if sum.is_some() { "its shapes', filled with water" } else { "a hundredth of the robot's" };
    let mass_kg = if total > 0.0 { total * SHARE } else { 1.0 }.max(LIGHTEST_KG);
    link.inertial = Some(sum.unwrap_or_else(|| Inertial {
        mass_kg,
        centre_m: Point3::origin(),
        tensor_kg_m2: filled(mass_kg, &[], &[]).0,
    }));
    log.chose(&format!("the mass of a link that has none: {how}"), &quoted(&link.name));
    if link.inertial.is_some() { Taken::Weighed } else { Taken::Away }
}

/// The frame of a link's centre of mass and principal axes, in the drawing, with its moments.
pub(crate) fn principal_frame(
    link: &crate::robot::Link,
) -> Option<(Isometry3<f64>, nalgebra::Vector3<f64>)> {
    let inertial = link.inertial?;
    let (moments, axes) = inertial.principal();
    let own = Isometry3::from_parts(inertial.centre_m.coords.into(), axes);
    Some((link.pose * own, moments))
}
