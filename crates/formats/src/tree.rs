//! A robot's joints as one tree.

use config::Problem;

use crate::{robot::Robot, weight::remove_joint, xml::Log};

/// Links and joints that a robot may have: as many as a model file takes.
pub(crate) const MOST_PARTS: usize = 1000;

/// Whether a robot has no more parts than it may, which is said.
pub(crate) fn is_small(robot: &Robot, log: &Log) -> bool {
    let (links, joints) = (&robot.links, &robot.joints);
    if links.len() <= MOST_PARTS && joints.len() <= MOST_PARTS {
        return true;
    }
    let place = links[0].place.clone();
    let message = format!("at most {MOST_PARTS} bodies and as many joints expected, got more");
    log.problem(Problem { place, message });
    false
}

/// Joints from the root outwards, each behind the one above it, in the order of the file otherwise.
/// `None`, with all that is wrong in the log, if they aren't one tree.
pub(crate) fn order(robot: &Robot, log: &Log) -> Option<Vec<usize>> {
    let links = &robot.links;
    if !is_small(robot, log) {
        return None;
    }
    let mut above: Vec<Option<usize>> = vec![None; links.len()];
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); links.len()];
    let mut is_tree = true;
    let mut refuse = |place: &config::Place, message: String| {
        log.problem(Problem { place: place.clone(), message });
        is_tree = false;
    };
    for (i, joint) in robot.joints.iter().enumerate() {
        if let Some(other) = above[joint.child].replace(i) {
            let (child, other) = (&links[joint.child].name, &robot.joints[other].name);
            let message =
                format!("joint '{}': '{child}' is the child of '{other}' too", joint.name);
            refuse(&joint.place, message);
        }
        if let Some(parent) = joint.parent {
            below[parent].push(i);
        }
    }
    let is_root = |link: &usize| above[*link].is_none_or(|it| robot.joints[it].parent.is_none());
    let roots: Vec<_> = (0..links.len()).filter(is_root).collect();
    for other in roots.iter().skip(1) {
        let message = format!(
            "'{}' must be the child of a joint, as all links but one ('{}') are",
            links[*other].name, links[roots[0]].name
        );
        refuse(&links[*other].place, message);
    }
    if roots.is_empty() {
        let message = "joints must not go round in a circle, but every link is a child";
        refuse(&robot.joints[0].place, message.into());
    }
    if !is_tree {
        return None;
    }
    let order = outwards(robot, above[roots[0]], &below, roots[0]);
    if let Some(lost) = (0..robot.joints.len()).find(|joint| !order.contains(joint)) {
        let joint = &robot.joints[lost];
        let message = format!("joint '{}' must not hang on its own child: a circle", joint.name);
        log.problem(Problem { place: joint.place.clone(), message });
        return None;
    }
    Some(order)
}

/// The joints that a root hangs on and that hang on it, each behind the one above it.
fn outwards(robot: &Robot, above: Option<usize>, below: &[Vec<usize>], root: usize) -> Vec<usize> {
    let mut order: Vec<usize> = above.into_iter().collect();
    let mut waiting: Vec<usize> = below[root].iter().rev().copied().collect();
    while let Some(joint) = waiting.pop() {
        order.push(joint);
        waiting.extend(below[robot.joints[joint].child].iter().rev());
    }
    order
}

/// Leaves out joints that close a loop, and all trees but the one with the most links, where a format
/// allows several.
pub(crate) fn keep_the_largest(robot: &mut Robot, log: &Log) {
    let mut above = vec![false; robot.links.len()];
    let mut joint = 0;
    while let Some(found) = robot.joints.get(joint) {
        if std::mem::replace(&mut above[found.child], true) {
            log.left_out("a joint that closes a loop", found.place.clone());
            remove_joint(robot, joint);
        } else {
            joint += 1;
        }
    }
    // The tree of each link, by the links that joints put together.
    let mut tree: Vec<usize> = (0..robot.links.len()).collect();
    let root = |tree: &[usize], mut link: usize| {
        while tree[link] != link {
            link = tree[link];
        }
        link
    };
    for joint in &robot.joints {
        if let Some(parent) = joint.parent {
            let (a, b) = (root(&tree, parent), root(&tree, joint.child));
            tree[b.max(a)] = b.min(a);
        }
    }
    let roots: Vec<usize> = (0..robot.links.len()).map(|link| root(&tree, link)).collect();
    let size = |root: usize| roots.iter().filter(|it| **it == root).count();
    let Some(most) = roots.iter().map(|root| size(*root)).max() else { return };
    let Some(kept) = roots.iter().copied().find(|root| size(*root) == most) else { return };
    for link in (0..robot.links.len()).rev().filter(|link| roots[*link] != kept) {
        log.left_out("a body that isn't part of the robot", robot.links[link].place.clone());
        crate::weight::remove(robot, link);
    }
}
