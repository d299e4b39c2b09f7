//! A robot as the text of a model file, for a person to read on.

use std::{fmt::Write, path::PathBuf};

use nalgebra::{Isometry3, Quaternion, Unit, UnitQuaternion, Vector3};

use crate::{
    compound::{self, Fit},
    files::Files,
    motors::{Servo, Servos},
    robot::{Axis, Joint, Link, Motion, MotorKind, Robot, Shape, Solid, to_roll_pitch_yaw},
    weight::principal_frame,
};

/// A mesh to copy beside the model file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshCopy {
    /// Where it is.
    pub from: PathBuf,
    /// Where the model file says that it is: relative to that file, with slashes.
    pub to: String,
}

/// What is beside the robot in a model file.
pub(crate) struct Setting<'a> {
    pub(crate) lift_m: f64,
    pub(crate) root: usize,
    pub(crate) feet: &'a [usize],
    pub(crate) servos: &'a Servos,
    /// Where meshes are copied to, relative to the model file, if they are.
    pub(crate) mesh_folder: Option<&'a str>,
    pub(crate) files: &'a Files,
}

/// The text without its heading, and the meshes that it names.
pub(crate) fn model(robot: &Robot, setting: &Setting<'_>) -> (String, Vec<MeshCopy>) {
    let mut writer = Writer { text: String::new(), meshes: Vec::new(), setting, robot };
    writer.whole();
    setting.servos.list.iter().for_each(|servo| writer.servo(servo));
    let frames: Vec<Isometry3<f64>> = robot
        .links
        .iter()
        .map(|link| principal_frame(link).map_or(link.pose, |(frame, _)| frame))
        .collect();
    for (link, frame) in robot.links.iter().zip(&frames) {
        writer.body(link, frame);
    }
    for (i, joint) in robot.joints.iter().enumerate() {
        writer.joint(i, joint, &frames);
    }
    if setting.mesh_folder.is_some() {
        return (writer.text, writer.meshes);
    }
    for mesh in std::mem::take(&mut writer.meshes) {
        writer.corners(&mesh);
    }
    (writer.text, Vec::new())
}

struct Writer<'a> {
    text: String,
    meshes: Vec<MeshCopy>,
    setting: &'a Setting<'a>,
    robot: &'a Robot,
}

/// Ten digits: less than anybody can measure, more than files have.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.9e}").parse().unwrap_or(value);
    // Not -0.0.
    format!("{:?}", rounded + 0.0)
}

/// Of lengths in m and angles in degrees: what is left of 0 after some roundings is 0.
fn near(value: f64) -> f64 {
    if value.abs() < 1e-11 { 0.0 } else { value }
}

fn list(values: impl IntoIterator<Item = f64>) -> String {
    let values: Vec<_> = values.into_iter().map(|it| number(near(it))).collect();
    format!("[{}]", values.join(", "))
}

fn vector(vector: &Vector3<f64>) -> String {
    list(vector.iter().copied())
}

/// In TOML's spelling.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => {
                // Writing to a text never fails.
                let _ = write!(quoted, "\\u{:04x}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

/// Roll, pitch and yaw in degrees, without what is left of 0.
fn angles_deg(rotation: &UnitQuaternion<f64>) -> Option<[f64; 3]> {
    let angles = to_roll_pitch_yaw(rotation).map(f64::to_degrees);
    angles.iter().any(|angle| angle.abs() > 1e-9).then_some(angles.map(|it| {
        // A file's degrees are whole more often than not.
        let whole = it.round();
        if (it - whole).abs() < 1e-9 { whole } else { it }
    }))
}

/// `key = value` in an inline table.
fn inline(entries: &[String]) -> String {
    format!("{{ {} }}", entries.join(", "))
}

impl Writer<'_> {
    fn line(&mut self, line: impl AsRef<str>) {
        self.text += line.as_ref();
        self.text.push('\n');
    }

    fn names(&self, links: &[usize]) -> String {
        let names: Vec<_> = links.iter().map(|it| quoted(&self.robot.links[*it].name)).collect();
        format!("[{}]", names.join(", "))
    }

    fn whole(&mut self) {
        let (robot, setting) = (self.robot, self.setting);
        self.line(format!("name = {}", quoted(&robot.name)));
        if let Some(self_collision) = robot.self_collision {
            self.line(format!("self_collision = {self_collision}"));
        }
        if setting.lift_m != 0.0 {
            let position = list([0.0, 0.0, setting.lift_m]);
            self.line(format!("start = {{ position_m = {position} }}"));
        }
        let root = &robot.links[setting.root];
        let frame = principal_frame(root).map_or(root.pose, |(frame, _)| frame);
        let forward = frame.rotation.inverse() * robot.forward;
        let (body, axis) = (quoted(&root.name), vector(&forward));
        self.line(format!("heading = {{ body = {body}, axis = {axis} }}"));
        if !setting.feet.is_empty() {
            self.line(format!("feet = {}", self.names(setting.feet)));
        }
        let mut touch: Vec<usize> =
            robot.touch.iter().copied().filter(|it| !setting.feet.contains(it)).collect();
        touch.sort_unstable();
        touch.dedup();
        if !touch.is_empty() {
            self.line(format!("touch = {}", self.names(&touch)));
        }
        self.actuators();
        if !robot.no_collision.is_empty() {
            let pairs: Vec<_> = robot.no_collision.iter().map(|pair| self.names(pair)).collect();
            self.line(format!("no_collision = [{}]", pairs.join(", ")));
        }
    }

    /// The order of the file's motors, where it isn't that of the joints.
    fn actuators(&mut self) {
        let driven = |joint: usize| {
            let axes = self.robot.joints[joint].axes.iter().enumerate();
            axes.filter(|(_, axis)| axis.motor.is_some()).map(move |(axis, _)| [joint, axis])
        };
        let natural: Vec<[usize; 2]> = (0..self.robot.joints.len()).flat_map(driven).collect();
        let mut order = self.robot.actuators.clone();
        if order.is_empty() || order == natural {
            return;
        }
        order.extend(natural.into_iter().filter(|it| !self.robot.actuators.contains(it)));
        let name = |[joint, axis]: &[usize; 2]| {
            let joint = &self.robot.joints[*joint];
            if joint.axes.len() == 1 {
                quoted(&joint.name)
            } else {
                quoted(&format!("{}/{}", joint.name, joint.axes[*axis].name))
            }
        };
        let names: Vec<_> = order.iter().map(name).collect();
        self.line(format!("actuators = [{}]", names.join(", ")));
    }

    fn servo(&mut self, servo: &Servo) {
        self.line(format!("\n[servo.{}]", quoted(&servo.name)));
        match servo.kind {
            MotorKind::Position => {}
            MotorKind::Speed => self.line("kind = \"speed\""),
            MotorKind::Torque => self.line("kind = \"torque\""),
        }
        let (speed, effort) = match servo.motion {
            Motion::Turns => ("speed_limit_rad_s", "torque_limit_nm"),
            Motion::Slides => ("speed_limit_m_s", "force_limit_n"),
        };
        self.line(format!("{speed} = {}", number(servo.speed)));
        self.line(format!("{effort} = {}", number(servo.effort)));
    }

    fn body(&mut self, link: &Link, frame: &Isometry3<f64>) {
        let Some(inertial) = link.inertial else { return };
        let moments = inertial.principal().0;
        self.line("\n[[body]]");
        self.line(format!("name = {}", quoted(&link.name)));
        self.line(format!("mass_kg = {}", number(inertial.mass_kg)));
        let moments: Vec<_> = moments.iter().map(|it| number(*it)).collect();
        self.line(format!("inertia_kg_m2 = [{}]", moments.join(", ")));
        if let Some(friction) = link.friction {
            self.line(format!("friction = {}", number(friction)));
        }
        self.line(format!("position_m = {}", vector(&frame.translation.vector)));
        if let Some(angles) = angles_deg(&frame.rotation) {
            self.line(format!("rotation_deg = {}", list(angles)));
        }
        let inverse = frame.inverse() * link.pose;
        let shapes: Vec<_> = link.shapes.iter().map(|it| self.shape(it, &inverse)).collect();
        match shapes.as_slice() {
            [] => {}
            [shape] => self.line(format!("shape = {shape}")),
            shapes => self.line(format!("shapes = [\n    {},\n]", shapes.join(",\n    "))),
        }
        if let Some([red, green, blue]) = link.colour {
            self.line(format!("colour = \"#{red:02x}{green:02x}{blue:02x}\""));
        }
    }

    fn shape(&mut self, shape: &Shape, link: &Isometry3<f64>) -> String {
        let pose = link * shape.pose;
        let position = pose.translation.vector;
        let mut entries = match &shape.solid {
            Solid::Box(half) => {
                vec!["kind = \"box\"".into(), format!("half_extents_m = {}", vector(half))]
            }
            Solid::Ball(radius) => {
                vec!["kind = \"sphere\"".into(), format!("radius_m = {}", number(*radius))]
            }
            Solid::Ellipsoid(radii) => {
                vec!["kind = \"ellipsoid\"".into(), format!("radii_m = {}", vector(radii))]
            }
            Solid::Cylinder(radius, half) | Solid::Capsule(radius, half) => {
                let kind = match shape.solid {
                    Solid::Cylinder(..) => "cylinder",
                    _ => "capsule",
                };
                let along = pose.rotation * Vector3::new(0.0, 0.0, *half);
                let (from, to) = (vector(&(position - along)), vector(&(position + along)));
                return inline(&[
                    format!("kind = \"{kind}\""),
                    format!("radius_m = {}", number(*radius)),
                    format!("from_m = {from}"),
                    format!("to_m = {to}"),
                ]);
            }
            Solid::Mesh { file, scale, .. } => {
                let to = self.mesh(file.clone().unwrap_or_default());
                let mut entries = vec!["kind = \"hull\"".into(), format!("file = {}", quoted(&to))];
                if *scale != Vector3::repeat(1.0) {
                    entries.push(format!("scale = {}", vector(scale)));
                }
                entries
            }
        };
        if position.amax() > 1e-11 {
            entries.push(format!("position_m = {}", vector(&position)));
        }
        if let Some(angles) = angles_deg(&pose.rotation)
            && !matches!(shape.solid, Solid::Ball(_))
        {
            entries.push(format!("rotation_deg = {}", list(angles)));
        }
        inline(&entries)
    }

    /// What a mesh is called beside the model file.
    fn mesh(&mut self, from: PathBuf) -> String {
        if let Some(known) = self.meshes.iter().find(|known| known.from == from) {
            return known.to.clone();
        }
        let plain = |part: Option<&std::ffi::OsStr>| {
            let text = part.unwrap_or_default().to_string_lossy().into_owned();
            text.replace(|c: char| c.is_control() || c == '/', "-")
        };
        let (stem, ending) = (plain(from.file_stem()), plain(from.extension()));
        let folder = self.setting.mesh_folder.unwrap_or("meshes");
        let mut to = format!("{folder}/{stem}.{ending}");
        let mut number = 1;
        while self.meshes.iter().any(|known| known.to == to) {
            number += 1;
            to = format!("{folder}/{stem}-{number}.{ending}");
        }
        self.meshes.push(MeshCopy { from, to: to.clone() });
        to
    }

    /// A mesh in the model file itself.
    fn corners(&mut self, mesh: &MeshCopy) {
        let Some(found) = self.setting.files.known(&mesh.from) else { return };
        self.line("\n[[mesh]]");
        self.line(format!("file = {}", quoted(&mesh.to)));
        let points: Vec<_> = found.corners.iter().map(|it| vector(&it.coords)).collect();
        self.line(format!("points = [\n    {},\n]", points.join(",\n    ")));
    }

    fn joint(&mut self, index: usize, joint: &Joint, frames: &[Isometry3<f64>]) {
        let parent = joint.parent.map_or_else(Isometry3::identity, |parent| frames[parent]);
        let (kind, fit, axes) = placed(joint, &parent, &frames[joint.child]);
        self.line("\n[[joint]]");
        self.line(format!("name = {}", quoted(&joint.name)));
        self.line(format!("kind = \"{kind}\""));
        let parent_name = joint.parent.map_or("world", |parent| &self.robot.links[parent].name);
        self.line(format!("parent = {}", quoted(parent_name)));
        self.line(format!("child = {}", quoted(&self.robot.links[joint.child].name)));
        let anchor = parent.inverse() * fit.anchor_m;
        self.line(format!("anchor_m = {}", vector(&anchor.coords)));
        if let Some(angles) = angles_deg(&(parent.rotation.inverse() * fit.rotation)) {
            self.line(format!("frame_deg = {}", list(angles)));
        }
        let axes: Vec<_> = (0..axes.len())
            .map(|i| {
                let servo = self.setting.servos.name_of(index, i);
                axis(&axes[i], fit.letters[i], axes.len() > 1, servo)
            })
            .collect();
        match axes.as_slice() {
            [] => {}
            [axis] => self.line(format!("axes = [{axis}]")),
            axes => self.line(format!("axes = [\n    {},\n]", axes.join(",\n    "))),
        }
    }
}

/// The kind of a joint, where its axes are, and these as they are in its frame.
fn placed(
    joint: &Joint,
    parent: &Isometry3<f64>,
    child: &Isometry3<f64>,
) -> (&'static str, Fit, Vec<Axis>) {
    let fixed = Fit {
        rotation: parent.rotation,
        anchor_m: child.translation.vector.into(),
        letters: Vec::new(),
        against: Vec::new(),
    };
    if let [axis] = joint.axes.as_slice() {
        let direction = parent.rotation.inverse() * axis.direction;
        // Springs are those of a joint that has bounds about y.
        let is_sprung = axis.spring.is_some() && axis.motion == Motion::Turns;
        let mut size = direction.abs();
        if is_sprung {
            size.y = 0.0;
        }
        let letter = size.imax();
        let kind = match axis.motion {
            Motion::Slides => "slider",
            Motion::Turns if is_sprung => "spherical",
            Motion::Turns => "hinge",
        };
        let rotation = parent.rotation * from_letter(letter, &direction);
        let fit =
            Fit { rotation, anchor_m: axis.anchor_m, letters: vec![letter], against: vec![false] };
        return (kind, fit, vec![axis.clone()]);
    }
    let Some(fit) = compound::fit(&joint.axes) else { return ("fixed", fixed, Vec::new()) };
    let slides = joint.axes.iter().any(|axis| axis.motion == Motion::Slides);
    let axes = joint.axes.iter().zip(&fit.against);
    let axes = axes.map(|(axis, against)| if *against { axis.flipped() } else { axis.clone() });
    let axes = axes.collect();
    (if slides { "general" } else { "spherical" }, fit, axes)
}

/// The least turn that takes x, y or z to a direction.
fn from_letter(letter: usize, direction: &Unit<Vector3<f64>>) -> UnitQuaternion<f64> {
    let unit = Vector3::ith(letter, 1.0);
    let quaternion = Quaternion::from_parts(1.0 + unit.dot(direction), unit.cross(direction));
    UnitQuaternion::try_new(quaternion, 1e-9).unwrap_or_else(|| {
        // Half a turn about another axis.
        let other = Vector3::ith((letter + 1) % 3, 1.0);
        UnitQuaternion::new_unchecked(Quaternion::from_parts(0.0, other))
    })
}

/// A whole inline table. A joint's only axis needs no name.
fn axis(axis: &Axis, letter: usize, is_named: bool, servo: Option<&str>) -> String {
    let letter = ["x", "y", "z"][letter];
    let turns = axis.motion == Motion::Turns;
    let unit = if turns { 1_f64.to_degrees() } else { 1.0 };
    let mut entries = Vec::new();
    if is_named {
        entries.push(format!("name = {}", quoted(&axis.name)));
    }
    entries.push(format!("{} = \"{letter}\"", if turns { "about" } else { "along" }));
    if let Some(range) = axis.range {
        let bound = if turns { 180.0 } else { f64::INFINITY };
        let ends = range.map(|end| (end * unit).clamp(-bound, bound));
        entries.push(format!("{} = {}", if turns { "range_deg" } else { "range_m" }, list(ends)));
    }
    if axis.reversed {
        entries.push("reversed = true".into());
    }
    if let Some(servo) = servo {
        entries.push(format!("servo = {}", quoted(servo)));
    }
    let (damping, friction) =
        if turns { ("damping_nms_rad", "friction_nm") } else { ("damping_ns_m", "friction_n") };
    if let Some(spring) = axis.spring {
        let (stiffness, rest) = if turns {
            ("stiffness_nm_rad", "equilibrium_deg")
        } else {
            ("stiffness_n_m", "equilibrium_m")
        };
        let mut parts = vec![
            format!("{stiffness} = {}", number(spring.stiffness)),
            format!("{damping} = {}", number(axis.damping)),
        ];
        let ends = axis.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        if spring.rest.abs() > 1e-11 {
            let rest_value = spring.rest.clamp(ends[0], ends[1]) * unit;
            parts.push(format!("{rest} = {}", number(rest_value)));
        }
        entries.push(format!("spring = {}", inline(&parts)));
    } else if axis.damping > 0.0 {
        entries.push(format!("{damping} = {}", number(axis.damping)));
    }
    if axis.friction > 0.0 {
        entries.push(format!("{friction} = {}", number(axis.friction)));
    }
    inline(&entries)
}
