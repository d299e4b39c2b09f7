//! `[[body]]`: a rigid body, its shapes and its inertia.

use config::{Mismatch, Node, Placed, Rule, Section, Value, one_of, placed, text, vector, within};
use nalgebra::{Isometry3, Vector3};

use super::{SHORTEST_M, length_m, part, point_m, pose};
use crate::shape::{Rod, Shape};

const HEAVIEST_KG: f64 = 1e6;
const LIGHTEST_KG: f64 = 1e-6;
/// Of moments of inertia in kg m²: their inverses are numbers in single precision.
const LEAST_KG_M2: f64 = 1e-15;
const MOST_KG_M2: f64 = 1e15;
/// Bullet's compounds have at most so many.
const MOST_SHAPES: usize = 256;
/// Bounds of a factor of lengths.
const SMALLEST_SCALE: f64 = 1e-9;
const LARGEST_SCALE: f64 = 1e9;

pub(crate) struct BodyFile {
    pub(crate) name: Placed<String>,
    pub(crate) mass_kg: f64,
    pub(crate) friction: f64,
    pub(crate) colour: [u8; 3],
    /// As drawn.
    pub(crate) pose: Isometry3<f64>,
    pub(crate) colliders: Vec<ColliderFile>,
    pub(crate) inertia_kg_m2: Option<Placed<Vector3<f64>>>,
}

pub(crate) struct ColliderFile {
    pub(crate) shape: ShapeFile,
    pub(crate) pose: Isometry3<f64>,
}

pub(crate) enum ShapeFile {
    Whole(Shape),
    /// To be read.
    Hull {
        file: Placed<String>,
        scale: Vector3<f64>,
    },
}

impl BodyFile {
    pub(super) fn read(body: &mut Section<'_>) -> Option<Self> {
        let name = body.required("name", part());
        if let Some(name) = &name {
            body.call(format!("body '{}'", name.value));
        }
        let mass_kg = body.required("mass_kg", within(LIGHTEST_KG, HEAVIEST_KG));
        let friction = body.or("friction", within(0.0, 10.0), 1.0);
        let colour = body.or("colour", Colour, [0x8c, 0x8c, 0x8c]);
        let pose = pose(body)?;
        let moments = placed(vector::<_, 3>(within(LEAST_KG_M2, MOST_KG_M2)));
        let inertia = body.optional("inertia_kg_m2", moments);
        let colliders = read_colliders(body);
        Some(Self {
            name: name?,
            mass_kg: mass_kg?,
            friction,
            colour,
            pose,
            colliders: colliders?,
            inertia_kg_m2: inertia
                .map(|Placed { value, place }| Placed { value: value.into(), place }),
        })
    }
}

/// A `shape`, or a list of `shapes`; or none, where the inertia is given.
fn read_colliders(body: &mut Section<'_>) -> Option<Vec<ColliderFile>> {
    let needs_one = !body.has("inertia_kg_m2");
    let count = body.count("shapes");
    if !body.has("shapes") {
        if needs_one {
            return Some(vec![body.required_table("shape", ColliderFile::read)?]);
        }
        let shape = body.table("shape", ColliderFile::read);
        let is_wrong = shape.is_none() && body.has("shape");
        return (!is_wrong).then(|| shape.into_iter().collect());
    }
    if body.has("shape") {
        body.table("shape", ColliderFile::read);
        body.refuse("shapes", "absent beside a shape", "both");
    }
    if count > MOST_SHAPES {
        body.refuse("shapes", &format!("at most {MOST_SHAPES} shapes"), count);
        return None;
    }
    if needs_one && count == 0 {
        let expected = "a list of tables, at least one where inertia_kg_m2 isn't given";
        body.refuse_value("shapes", expected);
    }
    Some(body.tables("shapes", ColliderFile::read))
}

impl ColliderFile {
    fn read(collider: &mut Section<'_>) -> Option<Self> {
        let pose = pose(collider)?;
        Some(Self { shape: ShapeFile::read(collider)?, pose })
    }
}

#[derive(Clone, Copy, PartialEq)]
enum ShapeKind {
    Box,
    Sphere,
    Capsule,
    Cylinder,
    Ellipsoid,
    Hull,
}

impl ShapeFile {
    fn read(shape: &mut Section<'_>) -> Option<Self> {
        const KINDS: &[(&str, ShapeKind)] = &[
            ("box", ShapeKind::Box),
            ("sphere", ShapeKind::Sphere),
            ("capsule", ShapeKind::Capsule),
            ("cylinder", ShapeKind::Cylinder),
            ("ellipsoid", ShapeKind::Ellipsoid),
            ("hull", ShapeKind::Hull),
        ];
        let whole = match shape.required("kind", one_of(KINDS)) {
            Some(ShapeKind::Box) => {
                let half_extents_m = shape.required("half_extents_m", vector(length_m()))?;
                Shape::Box { half_extents_m: half_extents_m.into() }
            }
            Some(ShapeKind::Sphere) => {
                Shape::Sphere { radius_m: shape.required("radius_m", length_m())? }
            }
            Some(ShapeKind::Capsule) => Shape::Capsule(Rod::read(shape)?),
            Some(ShapeKind::Cylinder) => Shape::Cylinder(Rod::read(shape)?),
            Some(ShapeKind::Ellipsoid) => {
                let radii_m = shape.required("radii_m", vector(length_m()))?;
                Shape::Ellipsoid { radii_m: radii_m.into() }
            }
            Some(ShapeKind::Hull) => {
                let file = shape.required("file", placed(text()));
                let scale = shape.given_or("scale", Scale, [1.0; 3]);
                return Some(Self::Hull { file: file?, scale: scale?.into() });
            }
            None => {
                // Without a kind no key is wrong or missing.
                shape.accept_all();
                return None;
            }
        };
        Some(Self::Whole(whole))
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

impl Rule for Colour {
    type Out = [u8; 3];

    fn expected(&self) -> String {
        "a colour such as \"#8c8c8c\" (red, green, blue)".into()
    }

    fn take(&self, node: &Node) -> Result<[u8; 3], Mismatch> {
        let Value::Text(text) = &node.value else { return Err(self.refuse(node)) };
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

/// A factor for all three directions, or one for each.
struct Scale;

impl Rule for Scale {
    type Out = [f64; 3];

    fn expected(&self) -> String {
        "a number or a list of 3, each 1e-9 to 1e9 or its negative".into()
    }

    fn take(&self, node: &Node) -> Result<[f64; 3], Mismatch> {
        let factor = |node: &Node| {
            let factor = match node.value {
                Value::Number(number) => number,
                Value::Integer(number) => number as f64,
                _ => return Err(self.refuse(node)),
            };
            let fits = (SMALLEST_SCALE..=LARGEST_SCALE).contains(&factor.abs());
            if fits { Ok(factor) } else { Err(self.refuse(node)) }
        };
        match &node.value {
            Value::List(items) => match &items[..] {
                [x, y, z] => Ok([factor(x)?, factor(y)?, factor(z)?]),
                _ => Err(self.refuse(node)),
            },
            _ => factor(node).map(|factor| [factor; 3]),
        }
    }

    fn written(&self, factors: &[f64; 3]) -> String {
        format!("{factors:?}")
    }
}
