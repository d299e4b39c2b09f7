//! What a model file says, key by key; `docs/formats.md` explains the keys.
//!
//! Each value is within its bounds here; whether names fit together is checked by
//! [`crate::Morphology`].

use config::{
    Place, Placed, Section, above, flag, list, name, one_of, placed, text, vector, within,
};
use nalgebra::{Isometry3, Translation3, Vector3};

use crate::{
    morphology::{JointKind, Spring, Stop},
    rotation::{Turn, from_euler_deg},
    shape::{Rod, Shape},
};

/// Lengths that a robot may have, in m. Bullet's own bounds are wider.
const LONGEST_M: f64 = 1e3;
const SHORTEST_M: f64 = 1e-4;
/// Bodies, joints and groups, more than any robot has. A world holds 4096 bodies.
const MOST_PARTS: usize = 1000;
const HEAVIEST_KG: f64 = 1e6;
const LIGHTEST_KG: f64 = 1e-6;
/// Of torques in N m, speeds in rad/s and whatever else has no natural bound: far beyond any robot,
/// and far from where single precision ends.
const LARGEST: f64 = 1e9;

pub(crate) struct ModelFile {
    pub(crate) name: String,
    pub(crate) description: String,
    pub(crate) self_collision: bool,
    pub(crate) locomotion_scale: f64,
    pub(crate) touch_distance_m: f64,
    pub(crate) start: Isometry3<f64>,
    pub(crate) heading: HeadingFile,
    pub(crate) mirror: Option<MirrorFile>,
    pub(crate) sensors: Option<Vec<Placed<String>>>,
    pub(crate) actuators: Option<Vec<Placed<String>>>,
    pub(crate) feet: Vec<Placed<String>>,
    pub(crate) touch: Vec<Placed<String>>,
    pub(crate) penalised: Vec<Placed<String>>,
    pub(crate) servos: Vec<ServoFile>,
    pub(crate) bodies: Vec<BodyFile>,
    pub(crate) joints: Vec<JointFile>,
    pub(crate) groups: Vec<GroupFile>,
}

pub(crate) struct HeadingFile {
    pub(crate) body: Placed<String>,
    /// Of length 1.
    pub(crate) axis: Placed<Vector3<f64>>,
}

pub(crate) struct MirrorFile {
    pub(crate) from: String,
    pub(crate) to: String,
    /// The coordinate that changes its sign.
    pub(crate) across: Turn,
}

pub(crate) struct ServoFile {
    pub(crate) name: String,
    pub(crate) speed_limit_rad_s: f64,
    pub(crate) torque_limit_nm: f64,
}

#[derive(Clone)]
pub(crate) struct BodyFile {
    pub(crate) name: Placed<String>,
    pub(crate) mass_kg: f64,
    pub(crate) friction: f64,
    pub(crate) colour: [u8; 3],
    /// As drawn.
    pub(crate) pose: Isometry3<f64>,
    pub(crate) shape: Shape,
}

pub(crate) struct JointFile {
    pub(crate) name: Placed<String>,
    pub(crate) kind: JointKind,
    pub(crate) parent: Placed<String>,
    pub(crate) child: Placed<String>,
    /// In the parent's frame.
    pub(crate) frame: Isometry3<f64>,
    pub(crate) axes: Vec<AxisFile>,
    pub(crate) stop: Stop,
}

pub(crate) struct AxisFile {
    /// Of its range.
    pub(crate) place: Place,
    pub(crate) name: String,
    pub(crate) about: Turn,
    pub(crate) lower_rad: f64,
    pub(crate) upper_rad: f64,
    pub(crate) stop_margin_rad: f64,
    pub(crate) reversed: bool,
    pub(crate) servo: Option<Placed<String>>,
    pub(crate) spring: Option<Spring>,
}

pub(crate) struct GroupFile {
    pub(crate) name: Placed<String>,
    pub(crate) joints: Vec<Placed<String>>,
    pub(crate) contacts: Vec<Placed<String>>,
}

/// What a part is called, here or where it's referred to.
fn part() -> impl config::Rule<Out = Placed<String>> {
    placed(name())
}

fn parts() -> impl config::Rule<Out = Vec<Placed<String>>> {
    list(part())
}

/// Of groups, joints or axes; the latter have a slash.
fn axes() -> impl config::Rule<Out = Vec<Placed<String>>> {
    list(placed(text()))
}

fn length_m() -> impl config::Rule<Out = f64> {
    within(SHORTEST_M, LONGEST_M)
}

fn point_m() -> impl config::Rule<Out = [f64; 3]> {
    vector(within(-LONGEST_M, LONGEST_M))
}

fn angles_deg() -> impl config::Rule<Out = [f64; 3]> {
    vector(within(-360.0, 360.0))
}

const HALF_TURN_DEG: f64 = 180.0;

const TURNS: &[(&str, Turn)] = &[("x", Turn::X), ("y", Turn::Y), ("z", Turn::Z)];

impl ModelFile {
    pub(crate) fn read(model: &mut Section<'_>) -> Option<Self> {
        let name = model.required("name", text());
        let description = model.optional("description", text()).unwrap_or_default();
        let self_collision = model.or("self_collision", flag(), false);
        let locomotion_scale = model.or("locomotion_scale", above(0.0).up_to(LARGEST), 1.0);
        let touch_distance_m = model.or("touch_distance_m", within(0.0, LONGEST_M), 0.002);
        let start = model.table("start", pose).unwrap_or_default();
        let heading = model.required_table("heading", HeadingFile::read);
        let mirror = model.table("mirror", MirrorFile::read);
        let sensors = model.optional("sensors", axes());
        let actuators = model.optional("actuators", axes());
        let feet = model.or("feet", parts(), Vec::new());
        let touch = model.or("touch", parts(), Vec::new());
        let penalised = model.or("penalised", parts(), Vec::new());
        for list in ["servo", "body", "joint", "group"] {
            let count = model.count(list);
            if count > MOST_PARTS {
                model.refuse(list, &format!("at most {MOST_PARTS} tables"), count);
                model.accept_all();
                return None;
            }
        }
        let servos = model.named_tables("servo", |key, servo| ServoFile::read(&key.name, servo));
        let bodies = model.tables("body", BodyFile::read);
        if model.count("body") == 0 {
            model.complain(&model.place_of("body"), "a robot must have a [[body]], got none");
        }
        let joints = model.tables("joint", JointFile::read);
        let groups = model.tables("group", GroupFile::read);
        Some(Self {
            name: name?,
            description,
            self_collision,
            locomotion_scale,
            touch_distance_m,
            start,
            heading: heading?,
            mirror,
            sensors,
            actuators,
            feet,
            touch,
            penalised,
            servos,
            bodies,
            joints,
            groups,
        })
    }
}

/// `position_m` and `rotation_deg`, both zero by default.
#[allow(clippy::unnecessary_wraps)] // a reader
fn pose(section: &mut Section<'_>) -> Option<Isometry3<f64>> {
    let position = section.or("position_m", point_m(), [0.0; 3]);
    let rotation = section.or("rotation_deg", angles_deg(), [0.0; 3]);
    Some(Isometry3::from_parts(Translation3::from(position), from_euler_deg(rotation)))
}

impl HeadingFile {
    fn read(heading: &mut Section<'_>) -> Option<Self> {
        let body = heading.required("body", part());
        let axis = heading.or("axis", vector(within(-LONGEST_M, LONGEST_M)), [0.0, 1.0, 0.0]);
        let axis = Vector3::from(axis);
        let length = axis.norm();
        if length < SHORTEST_M {
            heading.refuse_value("axis", "a direction, as [0.0, 1.0, 0.0] is");
            return None;
        }
        let axis = Placed { value: axis / length, place: heading.place_of("axis") };
        Some(Self { body: body?, axis })
    }
}

impl MirrorFile {
    fn read(mirror: &mut Section<'_>) -> Option<Self> {
        let from = mirror.required("from", name());
        let to = mirror.required("to", name());
        let across = mirror.or("across", one_of(TURNS), Turn::X);
        let (from, to) = (from?, to?);
        if from.contains(&to) || to.contains(&from) {
            mirror.refuse_value(
                "to",
                &format!("a word that isn't in \"{from}\" and doesn't have it inside"),
            );
            return None;
        }
        Some(Self { from, to, across })
    }
}

impl ServoFile {
    fn read(name: &str, servo: &mut Section<'_>) -> Option<Self> {
        servo.call(format!("servo '{name}'"));
        let speed_limit_rad_s = servo.required("speed_limit_rad_s", above(0.0).up_to(LARGEST));
        let torque_limit_nm = servo.required("torque_limit_nm", above(0.0).up_to(LARGEST));
        Some(Self {
            name: name.into(),
            speed_limit_rad_s: speed_limit_rad_s?,
            torque_limit_nm: torque_limit_nm?,
        })
    }
}

impl BodyFile {
    fn read(body: &mut Section<'_>) -> Option<Self> {
        let name = body.required("name", part());
        if let Some(name) = &name {
            body.call(format!("body '{}'", name.value));
        }
        let mass_kg = body.required("mass_kg", within(LIGHTEST_KG, HEAVIEST_KG));
        let friction = body.or("friction", within(0.0, 10.0), 1.0);
        let colour = body.or("colour", Colour, [0x8c, 0x8c, 0x8c]);
        let pose = pose(body)?;
        let shape = body.required_table("shape", read_shape);
        Some(Self { name: name?, mass_kg: mass_kg?, friction, colour, pose, shape: shape? })
    }
}

#[derive(Clone, Copy, PartialEq)]
enum ShapeKind {
    Box,
    Sphere,
    Capsule,
    Cylinder,
}

fn read_shape(shape: &mut Section<'_>) -> Option<Shape> {
    const KINDS: &[(&str, ShapeKind)] = &[
        ("box", ShapeKind::Box),
        ("sphere", ShapeKind::Sphere),
        ("capsule", ShapeKind::Capsule),
        ("cylinder", ShapeKind::Cylinder),
    ];
    match shape.required("kind", one_of(KINDS)) {
        Some(ShapeKind::Box) => {
            let half_extents_m = shape.required("half_extents_m", vector(length_m()))?;
            Some(Shape::Box { half_extents_m: half_extents_m.into() })
        }
        Some(ShapeKind::Sphere) => {
            Some(Shape::Sphere { radius_m: shape.required("radius_m", length_m())? })
        }
        Some(ShapeKind::Capsule) => Some(Shape::Capsule(Rod::read(shape)?)),
        Some(ShapeKind::Cylinder) => Some(Shape::Cylinder(Rod::read(shape)?)),
        None => {
            // Without a kind no key is wrong or missing.
            shape.accept_all();
            None
        }
    }
}

impl Rod {
    fn read(shape: &mut Section<'_>) -> Option<Self> {
        let radius_m = shape.required("radius_m", length_m());
        let from_m = shape.required("from_m", point_m());
        let to_m = shape.required("to_m", point_m());
        let rod = Self { radius_m: radius_m?, from_m: from_m?.into(), to_m: to_m?.into() };
        if rod.length_m() < SHORTEST_M {
            shape.refuse_value("to_m", &format!("at least {SHORTEST_M} m away from from_m"));
            return None;
        }
        Some(rod)
    }
}

/// `"#8c8c8c"`
struct Colour;

impl config::Rule for Colour {
    type Out = [u8; 3];

    fn expected(&self) -> String {
        "a colour such as \"#8c8c8c\" (red, green, blue)".into()
    }

    fn take(&self, node: &config::Node) -> Result<[u8; 3], config::Mismatch> {
        let config::Value::Text(text) = &node.value else { return Err(self.refuse(node)) };
        let digits = text.strip_prefix('#').filter(|digits| {
            digits.len() == 6 && digits.bytes().all(|byte| byte.is_ascii_hexdigit())
        });
        match digits.map(|digits| u32::from_str_radix(digits, 16)) {
            Some(Ok(number)) => {
                let [_, red, green, blue] = number.to_be_bytes();
                Ok([red, green, blue])
            }
            _ => Err(self.refuse(node)),
        }
    }

    fn written(&self, [red, green, blue]: &[u8; 3]) -> String {
        format!("\"#{red:02x}{green:02x}{blue:02x}\"")
    }
}

const JOINT_KINDS: &[(&str, JointKind)] = &[
    ("fixed", JointKind::Fixed),
    ("hinge", JointKind::Hinge),
    ("slider-hinge", JointKind::SliderHinge),
    ("spherical", JointKind::Spherical),
];

impl JointFile {
    fn read(joint: &mut Section<'_>) -> Option<Self> {
        let name = joint.required("name", part());
        if let Some(name) = &name {
            joint.call(format!("joint '{}'", name.value));
        }
        let kind = joint.required("kind", one_of(JOINT_KINDS));
        let parent = joint.required("parent", part());
        let child = joint.required("child", part());
        let anchor = joint.required("anchor_m", point_m());
        let rotation = joint.or("frame_deg", angles_deg(), [0.0; 3]);
        let stop = joint.table("stop", read_stop).unwrap_or_default();
        let axes = read_axes(joint, kind);
        Some(Self {
            name: name?,
            kind: kind?,
            parent: parent?,
            child: child?,
            frame: Isometry3::from_parts(Translation3::from(anchor?), from_euler_deg(rotation)),
            axes: axes?,
            stop,
        })
    }
}

/// Without a kind, which is a problem already, it can't be said what is wrong with the axes.
fn read_axes(joint: &mut Section<'_>, kind: Option<JointKind>) -> Option<Vec<AxisFile>> {
    let count = joint.count("axes");
    let kind = kind?;
    let (counts, expected) = match kind {
        JointKind::Fixed => (0..=0, "absent for a fixed joint"),
        JointKind::Hinge | JointKind::SliderHinge => (1..=1, "a list of one axis"),
        JointKind::Spherical => (1..=3, "a list of one to three axes"),
    };
    if !counts.contains(&count) {
        joint.refuse("axes", expected, format!("{count} of them"));
        return None;
    }
    let mut earlier: Vec<(Turn, String)> = Vec::new();
    let axes = joint.tables("axes", |axis| {
        let read = AxisFile::read(axis, kind)?;
        if earlier.iter().any(|(about, _)| *about == read.about) {
            axis.refuse_value("about", "another direction than that of the joint's other axes");
        } else if earlier.iter().any(|(_, name)| *name == read.name) {
            axis.refuse_value("name", "another name than those of the joint's other axes");
        }
        earlier.push((read.about, read.name.clone()));
        Some(read)
    });
    Some(axes)
}

impl AxisFile {
    fn read(axis: &mut Section<'_>, kind: JointKind) -> Option<Self> {
        let about = axis.required("about", one_of(TURNS));
        let name = axis.optional("name", name());
        let range_deg =
            axis.required("range_deg", vector::<_, 2>(within(-HALF_TURN_DEG, HALF_TURN_DEG)));
        let margin_deg = axis.or("stop_margin_deg", within(0.0, HALF_TURN_DEG), 0.0);
        let reversed = axis.or("reversed", flag(), false);
        let servo = axis.optional("servo", part());
        let spring = axis.table("spring", |spring| read_spring(spring, range_deg));
        if kind != JointKind::Spherical && axis.has("spring") {
            axis.refuse("spring", "absent (only a spherical joint has springs)", "one");
        }
        let (about, range_deg) = (about?, range_deg?);
        check_range(axis, range_deg, margin_deg, kind.farthest_deg(about))?;
        Some(Self {
            place: axis.place_of("range_deg"),
            name: name.unwrap_or_else(|| about.name().into()),
            about,
            lower_rad: range_deg[0].to_radians(),
            upper_rad: range_deg[1].to_radians(),
            stop_margin_rad: margin_deg.to_radians(),
            reversed,
            servo,
            spring,
        })
    }
}

/// Whether a range is one, has 0 in it, and leaves its stops where the joint can tell angles apart.
fn check_range(
    axis: &mut Section<'_>,
    [lower, upper]: [f64; 2],
    margin: f64,
    farthest: f64,
) -> Option<()> {
    let reach = upper.max(-lower);
    if lower >= upper {
        axis.refuse_value("range_deg", "[lower, upper] with lower < upper");
    } else if lower > 0.0 || upper < 0.0 {
        axis.refuse_value("range_deg", "around 0, the angle in which the model is drawn");
    } else if reach > farthest {
        let expected = format!(
            "from {} to {farthest} (about y of a spherical joint; about x or z, and in a hinge, \
             there's no such bound)",
            -farthest
        );
        axis.refuse_value("range_deg", &expected);
    } else if reach + margin > farthest {
        let expected = format!("at most {farthest} less the {reach} of range_deg");
        axis.refuse_value("stop_margin_deg", &expected);
    } else {
        return Some(());
    }
    None
}

fn read_spring(spring: &mut Section<'_>, range_deg: Option<[f64; 2]>) -> Option<Spring> {
    let stiffness_nm_rad = spring.required("stiffness_nm_rad", within(0.0, LARGEST));
    let damping_nms_rad = spring.required("damping_nms_rad", within(0.0, LARGEST));
    let rule = within(-HALF_TURN_DEG, HALF_TURN_DEG);
    let equilibrium_deg = spring.or("equilibrium_deg", rule, 0.0);
    if let Some([lower, upper]) = range_deg
        && spring.has("equilibrium_deg")
        && lower < upper
        && !(lower..=upper).contains(&equilibrium_deg)
    {
        spring.refuse_value("equilibrium_deg", &format!("in range_deg, {lower} to {upper}"));
    }
    Some(Spring {
        stiffness_nm_rad: stiffness_nm_rad?,
        damping_nms_rad: damping_nms_rad?,
        equilibrium_rad: equilibrium_deg.to_radians(),
    })
}

#[allow(clippy::unnecessary_wraps)] // a reader
fn read_stop(stop: &mut Section<'_>) -> Option<Stop> {
    let default = Stop::default();
    Some(Stop {
        erp: stop.or("erp", within(0.0, 1.0), default.erp),
        cfm: stop.or("cfm", within(0.0, 1.0), default.cfm),
        bounce: stop.or("bounce", within(0.0, 1.0), default.bounce),
    })
}

impl GroupFile {
    fn read(group: &mut Section<'_>) -> Option<Self> {
        let name = group.required("name", part());
        if let Some(name) = &name {
            group.call(format!("group '{}'", name.value));
        }
        let joints = group.required("joints", parts());
        let contacts = group.or("contacts", parts(), Vec::new());
        Some(Self { name: name?, joints: joints?, contacts })
    }
}
