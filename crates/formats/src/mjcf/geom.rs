//! Geoms: shapes, which also weigh something.

use nalgebra::{Isometry3, Unit, Vector3};

use super::compiler::{Compiler, from_z};
use crate::{
    files::Files,
    robot::{Inertial, Shape, Solid},
    xml::{Element, Log},
};

/// Attributes that are carried over, have no effect, or are said elsewhere.
const KNOWN: [&str; 22] = [
    "name",
    "class",
    "type",
    "pos",
    "quat",
    "axisangle",
    "xyaxes",
    "zaxis",
    "euler",
    "contype",
    "conaffinity",
    "friction",
    "size",
    "fromto",
    "mass",
    "density",
    "rgba",
    "material",
    "group",
    "mesh",
    "user",
    "shellinertia",
];

/// Says which attributes of an element aren't carried over.
pub(super) fn leave_out_unknown(element: &Element, known: &[&str], log: &Log) {
    for attribute in &element.attributes {
        let name = attribute.name.as_str();
        if !known.contains(&name) {
            log.left_out(&format!("{}/{name}", element.name), element.place_of(name));
        }
    }
}

/// Of what MuJoCo takes for water.
const DENSITY: f64 = 1000.0;

/// A geom of a link.
#[derive(Debug)]
pub(super) struct Geom {
    pub(super) shape: Shape,
    pub(super) inertial: Option<Inertial>,
    pub(super) masks: Masks,
    pub(super) friction: f64,
}

/// Which collide with which: the type of one has a bit in common with the affinity of the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Masks {
    pub(super) types: u32,
    pub(super) affinity: u32,
}

impl Masks {
    pub(super) fn read(geom: &Element, log: &Log) -> Self {
        let bits = |name| geom.number(name, log).map_or(1, |bits| bits as i64 as u32);
        Self { types: bits("contype"), affinity: bits("conaffinity") }
    }

    pub(super) fn collide(self, other: Self) -> bool {
        self.types & other.affinity != 0 || other.types & self.affinity != 0
    }
}

/// Sliding friction, the first of up to three numbers.
pub(super) fn friction(geom: &Element, log: &Log) -> f64 {
    geom.list("friction", log).and_then(|list| list.first().copied()).unwrap_or(1.0)
}

impl Geom {
    /// A geom with its defaults, in the frame of its link.
    pub(super) fn read(
        geom: &Element,
        frame: &Isometry3<f64>,
        meshes: &[Element],
        compiler: &Compiler,
        files: &Files,
        log: &Log,
    ) -> Option<Self> {
        leave_out_unknown(geom, &KNOWN, log);
        let (solid, pose) = solid(geom, meshes, compiler, log)?;
        if solid.is_negative() {
            let message = format!("size of <geom> must be above 0, got {}", size_text(geom));
            log.problem(config::Problem { place: geom.place_of("size"), message });
            return None;
        }
        if !solid.is_solid() {
            log.left_out("a geom without a size", geom.place());
            return None;
        }
        let shape = Shape { place: geom.place(), pose: frame * pose, solid };
        if geom.get("shellinertia") == Some("true") {
            log.left_out("geom/shellinertia", geom.place_of("shellinertia"));
        }
        Some(Self {
            inertial: inertial(geom, &shape, compiler, files, log),
            masks: Masks::read(geom, log),
            friction: friction(geom, log),
            shape,
        })
    }
}

fn size_text(geom: &Element) -> String {
    geom.get("size").map_or("none".into(), config::shown)
}

/// What it weighs; `None` if that's nothing.
fn inertial(
    geom: &Element,
    shape: &Shape,
    compiler: &Compiler,
    files: &Files,
    log: &Log,
) -> Option<Inertial> {
    let group = geom.number("group", log).unwrap_or_default();
    if !(compiler.groups[0]..=compiler.groups[1]).contains(&group) {
        return None;
    }
    let own_mass = geom.number("mass", log);
    let density = geom.number("density", log).unwrap_or(DENSITY);
    for (name, value) in [("mass", own_mass.unwrap_or_default()), ("density", density)] {
        if value < 0.0 {
            let message = format!("{name} of <geom> must be 0 or more, got {value}");
            log.problem(config::Problem { place: geom.place_of(name), message });
        }
    }
    let inertial = match &shape.solid {
        Solid::Mesh { uri, scale, .. } => {
            let (_, mesh) = files.mesh(uri).ok()?;
            let filled = mesh.filled(scale, density)?;
            let factor = own_mass.map_or(1.0, |mass| mass / filled.mass_kg);
            let own = Inertial {
                mass_kg: filled.mass_kg * factor,
                tensor_kg_m2: filled.tensor_kg_m2 * factor,
                ..filled
            };
            own.seen_from(&shape.pose)
        }
        solid => shape.filled(own_mass.unwrap_or(density * solid.volume_m3()?)),
    };
    (inertial.mass_kg > 0.0).then_some(inertial)
}

const TYPES: [&str; 9] =
    ["plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf"];

/// A solid, and its pose where the geom is written.
fn solid(
    geom: &Element,
    meshes: &[Element],
    compiler: &Compiler,
    log: &Log,
) -> Option<(Solid, Isometry3<f64>)> {
    let kind = match geom.get("type") {
        Some(_) => geom.word("type", &TYPES, log)?,
        None if geom.has("mesh") => "mesh",
        None => "sphere",
    };
    if ["plane", "hfield", "sdf"].contains(&kind) {
        log.left_out(&format!("geom of type {kind}"), geom.place());
        return None;
    }
    if kind == "mesh" {
        return mesh(geom, meshes, compiler, log);
    }
    if geom.has("mesh") {
        log.left_out(&format!("geom/mesh that a {kind} is fitted to"), geom.place_of("mesh"));
        return None;
    }
    let mut sizes = geom.list("size", log).unwrap_or_default();
    let mut pose = compiler.pose(geom, log);
    if let Some(points) = geom.numbers("fromto", log) {
        let (middle, half) = from_to(geom, points, log)?;
        pose = middle;
        let radius = sizes.first().copied().unwrap_or_default();
        sizes = match kind {
            "box" | "ellipsoid" => vec![radius, radius, half],
            _ => vec![radius, half],
        };
    }
    let wanted = match kind {
        "sphere" => 1,
        "capsule" | "cylinder" => 2,
        _ => 3,
    };
    if sizes.len() < wanted {
        let message =
            format!("size of a <geom> {kind} must have {wanted} numbers, got {}", sizes.len());
        log.problem(config::Problem { place: geom.place_of("size"), message });
        return None;
    }
    let solid = match kind {
        "sphere" => Solid::Ball(sizes[0]),
        "capsule" => Solid::Capsule(sizes[0], sizes[1]),
        "cylinder" => Solid::Cylinder(sizes[0], sizes[1]),
        "box" => Solid::Box(Vector3::new(sizes[0], sizes[1], sizes[2])),
        _ => Solid::Ellipsoid(Vector3::new(sizes[0], sizes[1], sizes[2])),
    };
    Some((solid, pose))
}

/// The pose of what reaches from one point to another along its z axis, and half its length.
fn from_to(
    geom: &Element,
    [a, b, c, d, e, f]: [f64; 6],
    log: &Log,
) -> Option<(Isometry3<f64>, f64)> {
    let (from, to) = (Vector3::new(a, b, c), Vector3::new(d, e, f));
    // MuJoCo's z axis points from the second point to the first.
    let Some(axis) = Unit::try_new(from - to, 1e-12) else {
        let message = "fromto of <geom> must have two points, got the same twice".into();
        log.problem(config::Problem { place: geom.place_of("fromto"), message });
        return None;
    };
    let pose = Isometry3::from_parts(((from + to) / 2.0).into(), from_z(&axis));
    Some((pose, (to - from).norm() / 2.0))
}

/// A mesh of `<asset>`, found by its name, which is its file's where it has none.
fn mesh(
    geom: &Element,
    meshes: &[Element],
    compiler: &Compiler,
    log: &Log,
) -> Option<(Solid, Isometry3<f64>)> {
    let name = geom.required("mesh", log)?;
    let named = |mesh: &&Element| {
        let file = mesh.get("file").unwrap_or_default();
        let stem = file.rsplit('/').next().and_then(|it| it.rsplit_once('.')).map(|(stem, _)| stem);
        mesh.get("name").or(stem) == Some(name)
    };
    let Some(asset) = meshes.iter().find(named) else {
        let message =
            format!("mesh of <geom> must be the name of a <mesh>, got \"{}\"", config::shown(name));
        log.problem(config::Problem { place: geom.place_of("mesh"), message });
        return None;
    };
    let Some(file) = asset.get("file") else {
        log.left_out("asset/mesh without a file", asset.place());
        return None;
    };
    let folder = compiler.mesh_folder.trim_end_matches('/');
    let uri = if folder.is_empty() { file.into() } else { format!("{folder}/{file}") };
    let scale = asset.vector("scale", log).unwrap_or(Vector3::repeat(1.0));
    let reference = Isometry3::from_parts(
        asset.vector("refpos", log).unwrap_or_default().into(),
        asset.numbers("refquat", log).map_or_else(Default::default, |[w, x, y, z]| {
            nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z))
        }),
    );
    let pose = compiler.pose(geom, log) * reference.inverse();
    Some((Solid::Mesh { uri, file: None, scale }, pose))
}
