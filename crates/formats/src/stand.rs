//! How a robot stands: on which feet, how high, fixed or free.

use crate::{
    files::Files,
    robot::{Joint, Robot},
    shapes::lowest_m,
    weight::remove_joint,
    xml::Log,
};

/// Words in the names of feet.
const FEET: [&str; 4] = ["foot", "feet", "sole", "tarsus"];

/// Of the robot's height: what is lower can be a foot.
const NEAR_THE_GROUND: f64 = 0.15;

/// Whether a robot is held by the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// It can fall.
    Free,
    /// Its root is fixed.
    Fixed,
}

/// Fixes or frees the base, where that is asked for.
pub(crate) fn set_base(robot: &mut Robot, base: Option<Base>, log: &Log) {
    let held = robot.joints.iter().position(|joint| joint.parent.is_none());
    match (base, held) {
        (Some(Base::Free), Some(joint)) => {
            log.chose("the base", "free, as asked for");
            remove_joint(robot, joint);
        }
        (Some(Base::Fixed), held) => {
            log.chose("the base", "fixed, as asked for");
            let root = held.map_or_else(|| root(robot), |joint| robot.joints[joint].child);
            if let Some(joint) = held {
                remove_joint(robot, joint);
            }
            fix(robot, root);
        }
        (_, Some(joint)) => {
            let kind = if robot.joints[joint].axes.is_empty() { "fixed to" } else { "jointed to" };
            robot_is(log, kind);
        }
        (_, None) => {}
    }
}

/// Holds a root to the world.
pub(crate) fn fix(robot: &mut Robot, root: usize) {
    let (name, place) = ("base".into(), robot.links[root].place.clone());
    let joint = Joint { name, place, parent: None, child: root, axes: Vec::new(), floats: false };
    robot.joints.insert(0, joint);
    robot.actuators.iter_mut().for_each(|[joint, _]| *joint += 1);
}

fn robot_is(log: &Log, kind: &str) {
    log.chose("the base", &format!("{kind} the world, as in the file (--base changes that)"));
}

/// The link that all others hang on.
pub(crate) fn root(robot: &Robot) -> usize {
    let is_root = |link: &usize| {
        robot.joint_above(*link).is_none_or(|joint| robot.joints[joint].parent.is_none())
    };
    (0..robot.links.len()).find(is_root).unwrap_or_default()
}

/// The height of its lowest and its highest link, in m.
fn span_m(robot: &Robot, files: &Files) -> Option<(f64, f64)> {
    let lowest: Vec<f64> =
        (0..robot.links.len()).filter_map(|it| lowest_m(robot, it, files)).collect();
    let least = lowest.iter().copied().min_by(f64::total_cmp)?;
    let heights = robot.links.iter().map(|link| link.pose.translation.vector.z);
    Some((least, heights.chain(lowest).fold(f64::NEG_INFINITY, f64::max)))
}

/// Lifts a robot onto the ground, or lowers it: by how much, in m. One that the world holds is only
/// lifted out of it, or onto what the file has for ground.
pub(crate) fn lift_m(robot: &Robot, files: &Files, log: &Log) -> f64 {
    let Some((lowest, _)) = span_m(robot, files) else { return 0.0 };
    let is_held = robot.joints.iter().any(|joint| joint.parent.is_none());
    let ground = robot.ground_m.unwrap_or(0.0);
    let lift = if is_held && lowest >= ground { -ground } else { -lowest };
    if lift.abs() < 1e-9 {
        return 0.0;
    }
    let why = if is_held && lowest >= ground {
        "the file's ground is the ground"
    } else {
        "the lowest point is on the ground"
    };
    log.chose("the height at the start", &format!("raised by {lift:.4} m: {why}"));
    lift
}

/// The links with contact sensors that are feet.
///
/// # Errors
/// A name that is no link's.
pub(crate) fn feet(
    robot: &Robot,
    asked: Option<&[String]>,
    files: &Files,
    log: &Log,
) -> Result<Vec<usize>, String> {
    if let Some(names) = asked {
        let find = |name: &String| {
            robot.links.iter().position(|link| link.name == *name).ok_or_else(|| {
                let known = robot.links.iter().map(|link| link.name.as_str());
                let likely = config::suggestion(name, known);
                format!("--feet must be names of bodies, got \"{}\"{likely}", config::shown(name))
            })
        };
        let mut feet: Vec<usize> = names.iter().map(find).collect::<Result<_, _>>()?;
        let mut seen = std::collections::BTreeSet::new();
        feet.retain(|foot| seen.insert(*foot));
        return Ok(feet);
    }
    let solid: Vec<usize> =
        (0..robot.links.len()).filter(|it| !robot.links[*it].shapes.is_empty()).collect();
    let named = |link: &&usize| {
        let name = robot.links[**link].name.to_lowercase();
        FEET.iter().any(|word| name.contains(word))
    };
    let mut feet: Vec<usize> = solid.iter().filter(named).copied().collect();
    let mut how = "by their names";
    let is_free = robot.joints.iter().all(|joint| joint.parent.is_some());
    if feet.is_empty() && is_free {
        feet = lowest_of_limbs(robot, files);
        how = "the lowest bodies of limbs, near the ground";
    }
    let names: Vec<_> = feet.iter().map(|foot| format!("'{}'", robot.links[*foot].name)).collect();
    if feet.is_empty() {
        log.chose("feet", "none");
    } else {
        log.chose("feet", &format!("{}: {how} (--feet changes that)", names.join(", ")));
    }
    Ok(feet)
}

/// Of each limb, which begins behind the last link that several hang on, the body that reaches lowest,
/// if that is near the ground.
fn lowest_of_limbs(robot: &Robot, files: &Files) -> Vec<usize> {
    let Some((lowest, highest)) = span_m(robot, files) else { return Vec::new() };
    let near = lowest + NEAR_THE_GROUND * (highest - lowest);
    let moves = |joint: &&Joint| !joint.axes.is_empty() && joint.parent.is_some();
    let children =
        |link: usize| robot.joints.iter().filter(moves).filter(move |it| it.parent == Some(link));
    let mut feet = Vec::new();
    let ends: Vec<usize> = robot.joints.iter().filter(moves).map(|joint| joint.child).collect();
    for end in ends {
        let below = robot.below(end);
        // The last joint of a limb: nothing that moves hangs on it or on what is fixed to it.
        if (0..robot.links.len()).any(|link| below[link] && children(link).next().is_some()) {
            continue;
        }
        let candidates = (0..robot.links.len()).filter(|link| below[*link]);
        let reaching = candidates.filter_map(|link| Some((lowest_m(robot, link, files)?, link)));
        let least = reaching.min_by(|a, b| a.0.total_cmp(&b.0));
        feet.extend(least.filter(|(height, _)| *height <= near).map(|(_, link)| link));
    }
    feet.sort_unstable();
    feet.dedup();
    feet
}
