//! From a file to a morphology: mirror images are made, names looked up, mesh files read.

mod bodies;
mod tree;

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use config::{MOST_PROBLEMS, Place, Placed, Problem, Problems, shown, suggestion};
use nalgebra::{Isometry3, Unit};

use crate::{
    file::{
        AxisFile, BodyFile, GroupFile, HeadingFile, JointFile, MirrorFile, ModelFile, ServoFile,
    },
    joint::{Joint, JointAxis, Servo},
    morphology::{AxisId, Body, Group, Heading, Morphology},
    parts::Parts,
    rotation::{Mirror, Turn},
    warn::warnings,
};

/// What joints call the world by, that have it for their parent.
const WORLD: &str = "world";

/// Of the heading's axis; the figure is ours.
const STEEPEST_DEG: f64 = 80.0;

/// # Errors
/// All that is wrong. Parts come first: what refers to them is only looked up if they are right.
///
/// Mesh files are looked for in `folder`.
pub(crate) fn check(file: &ModelFile, folder: &Path) -> Result<Morphology, Problems> {
    let mut checker =
        Checker { mirror: file.mirror.as_ref(), meshes: Vec::new(), problems: Vec::new() };
    let bodies = checker.bodies(file, folder);
    let body_names = names("a body", &bodies, |body| &body.name);
    let joints = checker.joints(&file.joints, &bodies, &body_names, &file.servos);
    let joint_names = names("a joint", &joints, |joint| &joint.name);
    if checker.problems.is_empty() {
        checker.tree(&joints, &bodies);
    }

    let feet = checker.indices("feet", &file.feet, &body_names);
    let n_feet = feet.len();
    let touch = checker.indices("touch", &file.touch, &body_names);
    let contacts = [feet, touch].concat();
    checker.one_sensor_each(&file.feet, &file.touch);
    let penalised = checker.indices("penalised", &file.penalised, &body_names);
    let no_collision = checker.pairs("no_collision", &file.no_collision, &body_names);
    let heading = checker.heading(file, &bodies, &body_names);

    let groups = checker.groups(&file.groups, &joint_names, &body_names);
    checker.group_contacts(&groups, &contacts, &body_names);
    let parts = Parts::new(&joints, &groups);
    let (sensors, actuators) = checker.sensors_and_actuators(file, &parts);

    if !checker.problems.is_empty() {
        return Err(Problems::new(checker.problems));
    }
    Ok(Morphology {
        name: file.name.clone(),
        description: file.description.clone(),
        sensors,
        actuators,
        contacts,
        n_feet,
        penalised,
        no_collision,
        heading: Heading {
            body: heading.unwrap_or_default(),
            axis: Unit::new_unchecked(file.heading.axis.value),
        },
        start: file.start,
        self_collision: file.self_collision,
        locomotion_scale: file.locomotion_scale,
        touch_distance_m: file.touch_distance_m,
        warnings: warnings(file),
        meshes: checker.meshes.into_iter().filter_map(|mesh| mesh.from_file).collect(),
        groups: without_files(groups),
        joints: without_files(joints),
        bodies: without_files(bodies),
    })
}

/// Parts, or their mirror images, each with what the file says about it.
pub(crate) type Made<'a, F, P> = [(&'a F, P)];
type Bodies<'a> = Made<'a, BodyFile, Body>;
pub(crate) type Joints<'a> = Made<'a, JointFile, Joint>;
pub(crate) type Groups<'a> = Made<'a, GroupFile, Group>;

fn without_files<F, P>(made: Vec<(&F, P)>) -> Vec<P> {
    made.into_iter().map(|(_, part)| part).collect()
}

/// Where the names of a kind of parts are found.
struct Names<'a> {
    /// With an article.
    kind: &'static str,
    list: Vec<&'a str>,
    indices: BTreeMap<&'a str, usize>,
}

fn names<'a, F, P>(
    kind: &'static str,
    parts: &'a Made<'_, F, P>,
    name: impl Fn(&P) -> &String,
) -> Names<'a> {
    let list: Vec<_> = parts.iter().map(|(_, part)| name(part).as_str()).collect();
    let indices = list.iter().enumerate().map(|(i, name)| (*name, i)).collect();
    Names { kind, list, indices }
}

struct Checker<'a> {
    mirror: Option<&'a MirrorFile>,
    /// Those met so far.
    meshes: Vec<bodies::Met>,
    problems: Vec<Problem>,
}

impl Checker<'_> {
    /// One more problem than is shown tells that there are more.
    fn complain(&mut self, place: &Place, message: String) {
        if self.problems.len() <= MOST_PROBLEMS {
            self.problems.push(Problem { place: place.clone(), message });
        }
    }

    /// The name of a part's mirror image, if it has one.
    fn image_name(&self, name: &str) -> Option<String> {
        let mirror = self.mirror?;
        name.contains(&mirror.from).then(|| name.replace(&mirror.from, &mirror.to))
    }

    fn reflection(&self) -> Mirror {
        Mirror(self.mirror.map_or(Turn::X, |mirror| mirror.across))
    }

    /// The mirror image of a part, which is itself if it has none.
    fn image_of(&self, part: usize, names: &Names<'_>) -> usize {
        let image = self.image_name(names.list[part]);
        image.and_then(|image| names.indices.get(image.as_str()).copied()).unwrap_or(part)
    }

    /// Index of a name among those of a kind, or a complaint.
    fn find(&mut self, what: &str, name: &Placed<String>, names: &Names<'_>) -> Option<usize> {
        let found = names.indices.get(name.value.as_str()).copied();
        if found.is_none() {
            self.refuse_name(what, name, names.kind, names.indices.keys().copied());
        }
        found
    }

    fn refuse_name<'n>(
        &mut self,
        what: &str,
        name: &Placed<String>,
        kind: &str,
        known: impl Iterator<Item = &'n str>,
    ) {
        // Looking for a likely one takes time.
        if self.problems.len() <= MOST_PROBLEMS {
            let (found, likely) = (shown(&name.value), suggestion(&name.value, known));
            let message = format!("{what} must be the name of {kind}, got \"{found}\"{likely}");
            self.complain(&name.place, message);
        }
    }

    /// Indices of names, none of them twice.
    fn indices(&mut self, what: &str, list: &[Placed<String>], names: &Names<'_>) -> Vec<usize> {
        let mut seen = BTreeSet::new();
        let mut indices = Vec::new();
        for (i, name) in list.iter().enumerate() {
            let Some(index) = self.find(&format!("{what}[{i}]"), name, names) else { continue };
            if seen.insert(index) {
                indices.push(index);
            } else {
                let message =
                    format!("{what}[{i}] must not repeat {}, got \"{}\"", names.kind, name.value);
                self.complain(&name.place, message);
            }
        }
        indices
    }

    /// Pairs of different bodies, each with the lower index first, none of them twice.
    fn pairs(
        &mut self,
        what: &str,
        list: &[Placed<[Placed<String>; 2]>],
        bodies: &Names<'_>,
    ) -> Vec<[usize; 2]> {
        let mut pairs = Vec::new();
        for (i, Placed { value: [a, b], place }) in list.iter().enumerate() {
            let found = [(0, a), (1, b)]
                .map(|(end, name)| self.find(&format!("{what}[{i}][{end}]"), name, bodies));
            let [Some(a), Some(b)] = found else { continue };
            let pair = [a.min(b), a.max(b)];
            let names = pair.map(|body| bodies.list[body]);
            if a == b {
                self.complain(place, format!("{what}[{i}] must be two bodies, got {names:?}"));
            } else if pairs.contains(&pair) {
                self.complain(place, format!("{what}[{i}] must not repeat a pair, got {names:?}"));
            } else {
                pairs.push(pair);
            }
        }
        pairs
    }

    /// Complains about names that come again, whether written or of mirror images.
    fn unique<'n>(
        &mut self,
        kind: &str,
        names: impl Iterator<Item = (&'n Placed<String>, &'n str)>,
    ) {
        let mut seen: BTreeMap<&str, &Placed<String>> = BTreeMap::new();
        for (written, name) in names {
            let Some(first) = seen.insert(name, written) else { continue };
            let message = format!(
                "{} must have a name of its own, but {}the {kind} of line {} has it too",
                described(kind, name, &written.value),
                if first.value == name { "" } else { "the mirror image of " },
                first.place.line
            );
            self.complain(&written.place, message);
        }
    }

    fn joints<'f>(
        &mut self,
        files: &'f [JointFile],
        bodies: &Bodies<'_>,
        body_names: &Names<'_>,
        servos: &[ServoFile],
    ) -> Vec<(&'f JointFile, Joint)> {
        let mut joints = Vec::new();
        for file in files {
            let subject = format!("joint '{}': ", file.name.value);
            let is_held = file.parent.value == WORLD;
            let parent = if is_held {
                None
            } else {
                self.find(&format!("{subject}parent"), &file.parent, body_names)
            };
            let child = self.find(&format!("{subject}child"), &file.child, body_names);
            if parent.is_some() && parent == child {
                let message = format!(
                    "{subject}child must be another body than the parent, got \"{}\"",
                    file.child.value
                );
                self.complain(&file.child.place, message);
            }
            // A joint to nowhere is kept for its name, which others may refer to.
            let parent = (!is_held).then(|| parent.unwrap_or_default());
            let child = child.unwrap_or_default();
            let drawn = parent.map_or_else(Isometry3::identity, |parent| bodies[parent].1.pose);
            let axes = file.axes.iter().enumerate();
            let joint = Joint {
                name: file.name.value.clone(),
                kind: file.kind,
                parent,
                child,
                frame: drawn * file.frame,
                axes: axes
                    .map(|(i, axis)| self.axis(&format!("{subject}axes[{i}]: "), axis, servos))
                    .collect(),
                stop: file.stop,
            };
            let image = self.image_name(&joint.name).map(|name| Joint {
                name,
                parent: parent.map(|parent| self.image_of(parent, body_names)),
                child: self.image_of(child, body_names),
                frame: self.reflection().joint_frame(&joint.frame),
                ..joint.clone()
            });
            joints.push((file, joint));
            joints.extend(image.map(|image| (file, image)));
        }
        self.unique("joint", joints.iter().map(|(file, joint)| (&file.name, joint.name.as_str())));
        joints
    }

    fn axis(&mut self, subject: &str, axis: &AxisFile, servos: &[ServoFile]) -> JointAxis {
        let servo = axis.servo.as_ref().and_then(|name| {
            let found = servos.iter().find(|servo| servo.name == name.value);
            match found {
                None => {
                    let known = servos.iter().map(|servo| servo.name.as_str());
                    self.refuse_name(&format!("{subject}servo"), name, "a [servo.NAME]", known);
                }
                Some(servo) if servo.is_linear != axis.freedom.is_linear() => {
                    let (is, keys) = match axis.freedom.is_linear() {
                        true => ("slides", "speed_limit_m_s and force_limit_n"),
                        false => ("turns", "speed_limit_rad_s and torque_limit_nm"),
                    };
                    let message = format!(
                        "{subject}servo must have {keys}, since the axis {is}, but '{}' hasn't",
                        name.value
                    );
                    self.complain(&name.place, message);
                }
                Some(_) => {}
            }
            found
        });
        JointAxis {
            name: axis.name.clone(),
            freedom: axis.freedom,
            range: axis.range,
            stop_margin: axis.stop_margin,
            reversed: axis.reversed,
            servo: servo.map(|servo| Servo {
                kind: servo.kind,
                speed_limit: servo.speed_limit,
                force_limit: servo.force_limit,
            }),
            spring: axis.spring,
            resistance: axis.resistance,
        }
    }

    fn groups<'f>(
        &mut self,
        files: &'f [GroupFile],
        joints: &Names<'_>,
        bodies: &Names<'_>,
    ) -> Vec<(&'f GroupFile, Group)> {
        let mut groups = Vec::new();
        for file in files {
            let subject = format!("group '{}': ", file.name.value);
            let own_joints = self.indices(&format!("{subject}joints"), &file.joints, joints);
            let contacts = self.indices(&format!("{subject}contacts"), &file.contacts, bodies);
            let image = self.image_name(&file.name.value).map(|name| Group {
                name,
                joints: own_joints.iter().map(|&joint| self.image_of(joint, joints)).collect(),
                contacts: contacts.iter().map(|&body| self.image_of(body, bodies)).collect(),
            });
            let group = Group { name: file.name.value.clone(), joints: own_joints, contacts };
            groups.push((file, group));
            groups.extend(image.map(|image| (file, image)));
        }
        self.unique("group", groups.iter().map(|(file, group)| (&file.name, group.name.as_str())));
        for (file, group) in &groups {
            if joints.indices.contains_key(group.name.as_str()) {
                let group = described("group", &group.name, &file.name.value);
                let message = format!("{group} must have a name that no joint has");
                self.complain(&file.name.place, message);
            }
        }
        groups
    }

    /// Where an axis points along the ground: one that points up has no heading, or has one that turns
    /// around at the slightest tilt.
    fn heading(
        &mut self,
        file: &ModelFile,
        bodies: &Bodies<'_>,
        names: &Names<'_>,
    ) -> Option<usize> {
        let HeadingFile { body, axis } = &file.heading;
        let body = self.find("heading: body", body, names)?;
        let direction = file.start.rotation * bodies[body].1.pose.rotation * axis.value;
        let slope_deg = libm::atan2(direction.z, direction.xy().norm()).to_degrees();
        if slope_deg.abs() > STEEPEST_DEG {
            let message = format!(
                "heading: axis must be at most {STEEPEST_DEG} degrees above or below the ground where \
                 the robot starts, got one at {slope_deg:.0} degrees"
            );
            self.complain(&axis.place, message);
        }
        Some(body)
    }

    fn one_sensor_each(&mut self, feet: &[Placed<String>], touch: &[Placed<String>]) {
        let feet: BTreeSet<_> = feet.iter().map(|name| &name.value).collect();
        for (i, name) in touch.iter().enumerate().filter(|(_, name)| feet.contains(&name.value)) {
            let message = format!("touch[{i}] must not be one of feet, got \"{}\"", name.value);
            self.complain(&name.place, message);
        }
    }

    fn group_contacts(&mut self, groups: &Groups<'_>, sensed: &[usize], bodies: &Names<'_>) {
        for (file, group) in groups {
            let unsensed = group.contacts.iter().enumerate().filter(|(_, b)| !sensed.contains(b));
            for (i, &body) in unsensed {
                let message = format!(
                    "{}: contacts[{i}] must be among feet and touch, got \"{}\"",
                    described("group", &group.name, &file.name.value),
                    bodies.list[body]
                );
                let name = file.contacts.get(i).unwrap_or(&file.name);
                self.complain(&name.place, message);
            }
        }
    }

    /// What the file lists, or all axes, and all that have a servo.
    fn sensors_and_actuators(
        &mut self,
        file: &ModelFile,
        parts: &Parts<'_>,
    ) -> (Vec<AxisId>, Vec<AxisId>) {
        let sensors = match &file.sensors {
            Some(names) => self.axes("sensors", names, parts, false),
            None => parts.all_axes(),
        };
        let has_servo = |&id: &AxisId| parts.axis(id).servo.is_some();
        let actuators = match &file.actuators {
            Some(names) => self.axes("actuators", names, parts, true),
            None => parts.all_axes().into_iter().filter(has_servo).collect(),
        };
        (sensors, actuators)
    }

    /// The axes that names of groups, of joints and of axes stand for.
    fn axes(
        &mut self,
        what: &str,
        names: &[Placed<String>],
        parts: &Parts<'_>,
        driven: bool,
    ) -> Vec<AxisId> {
        let mut axes = Vec::new();
        let mut taken = BTreeSet::new();
        for (i, name) in names.iter().enumerate() {
            let what = format!("{what}[{i}]");
            let Some(found) = parts.axes.get(&name.value) else {
                let kind = "a group, of a joint or of a joint's axis (\"joint/axis\")";
                self.refuse_name(&what, name, kind, parts.axes.keys().map(String::as_str));
                continue;
            };
            if found.is_empty() {
                let message =
                    format!("{what} must have an axis that moves, but '{}' has none", name.value);
                self.complain(&name.place, message);
            }
            for &id in found {
                if driven && parts.axis(id).servo.is_none() {
                    let axis = parts.name(id);
                    let message = format!("{what} must have a servo, but axis '{axis}' has none");
                    self.complain(&name.place, message);
                }
                if taken.insert((id.joint, id.axis)) {
                    axes.push(id);
                } else {
                    let axis = parts.name(id);
                    let message =
                        format!("{what} must not repeat an axis, but '{axis}' came before");
                    self.complain(&name.place, message);
                }
            }
        }
        axes
    }
}

/// A part, and what it's the mirror image of, if it's one.
fn described(kind: &str, name: &str, written: &str) -> String {
    if name == written {
        format!("{kind} '{name}'")
    } else {
        format!("{kind} '{name}' (the mirror image of '{written}')")
    }
}
