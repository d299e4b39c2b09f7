//! What a model file says, key by key; `docs/formats.md` explains the keys.
//!
//! Each value is within its bounds here; whether names fit together is checked by
//! [`crate::Morphology`]. Bodies and joints have files of their own.

mod body;
mod joint;

use config::{Placed, Section, above, flag, list, name, one_of, placed, text, vector, within};
use nalgebra::{Isometry3, Point3, Translation3, Vector3};

pub(crate) use body::{BodyFile, ColliderFile, ShapeFile};
pub(crate) use joint::{AxisFile, JointFile};

use crate::{
    ServoKind,
    hull::MOST_POINTS,
    rotation::{Turn, from_euler_deg},
};

/// Lengths that a robot may have, in m. Bullet's own bounds are wider.
const LONGEST_M: f64 = 1e3;
const SHORTEST_M: f64 = 1e-4;
/// Bodies, joints and groups, more than any robot has. A world holds 4096 bodies.
const MOST_PARTS: usize = 1000;
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
    pub(crate) no_collision: Vec<Placed<[Placed<String>; 2]>>,
    pub(crate) meshes: Vec<MeshFile>,
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
    pub(crate) kind: ServoKind,
    /// Whether it's for axes that things slide along.
    pub(crate) is_linear: bool,
    /// In rad/s, or in m/s.
    pub(crate) speed_limit: f64,
    /// In N m, or in N.
    pub(crate) force_limit: f64,
}

/// The corners of a mesh file that needn't be there.
pub(crate) struct MeshFile {
    pub(crate) file: Placed<String>,
    pub(crate) points: Vec<Point3<f64>>,
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
        let no_collision = model.or("no_collision", list(placed(vector(part()))), Vec::new());
        if has_too_many(model) {
            model.accept_all();
            return None;
        }
        let servos = model.named_tables("servo", |key, servo| ServoFile::read(&key.name, servo));
        let meshes = model.tables("mesh", MeshFile::read);
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
            no_collision,
            meshes,
            servos,
            bodies,
            joints,
            groups,
        })
    }
}

/// Whether there are more parts of a kind than anybody needs, which is a mistake then.
fn has_too_many(model: &mut Section<'_>) -> bool {
    for list in ["servo", "mesh", "body", "joint", "group"] {
        let count = model.count(list);
        if count > MOST_PARTS {
            model.refuse(list, &format!("at most {MOST_PARTS} tables"), count);
            return true;
        }
    }
    false
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
        const KINDS: &[(&str, ServoKind)] = &[
            ("position", ServoKind::Position),
            ("speed", ServoKind::Speed),
            ("torque", ServoKind::Torque),
        ];
        servo.call(format!("servo '{name}'"));
        let kind = servo.given_or("kind", one_of(KINDS), ServoKind::Position);
        let limit = || above(0.0).up_to(LARGEST);
        let is_linear = servo.has("speed_limit_m_s") || servo.has("force_limit_n");
        let (speed_limit, force_limit) = if is_linear {
            (servo.required("speed_limit_m_s", limit()), servo.required("force_limit_n", limit()))
        } else {
            let speed_limit = servo.required("speed_limit_rad_s", limit());
            (speed_limit, servo.required("torque_limit_nm", limit()))
        };
        Some(Self {
            name: name.into(),
            kind: kind?,
            is_linear,
            speed_limit: speed_limit?,
            force_limit: force_limit?,
        })
    }
}

impl MeshFile {
    fn read(mesh: &mut Section<'_>) -> Option<Self> {
        let file = mesh.required("file", placed(text()));
        let points = mesh.required("points", list(vector(within(-LARGEST, LARGEST))))?;
        if !(4..=MOST_POINTS).contains(&points.len()) {
            mesh.refuse("points", &format!("4 to {MOST_POINTS} points"), points.len());
            return None;
        }
        let points: Vec<_> = points.into_iter().map(Point3::from).collect();
        Some(Self { file: file?, points })
    }
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
