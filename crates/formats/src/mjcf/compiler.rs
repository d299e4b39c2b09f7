//! `<compiler>`: how numbers are meant, and poses read by it.

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Unit, UnitQuaternion, Vector3};

use crate::{
    robot::turned,
    xml::{Element, Log},
};

/// What numbers mean.
#[derive(Debug)]
pub(super) struct Compiler {
    /// Of a unit of angle, in rad.
    pub(super) angle_rad: f64,
    /// Whether poses are those in the world, as before MuJoCo 2.3.4.
    pub(super) is_global: bool,
    pub(super) eulerseq: [char; 3],
    pub(super) autolimits: bool,
    pub(super) inertia_from_geom: InertiaFromGeom,
    pub(super) mesh_folder: String,
    pub(super) total_mass_kg: Option<f64>,
    pub(super) least_mass_kg: f64,
    pub(super) least_inertia_kg_m2: f64,
    pub(super) balance_inertia: bool,
    /// Groups of geoms that weigh something.
    pub(super) groups: [f64; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum InertiaFromGeom {
    Never,
    IfNotGiven,
    Always,
}

impl Compiler {
    pub(super) fn read(root: &Element, log: &Log) -> Self {
        let mut compiler = Self {
            angle_rad: 1_f64.to_radians(),
            is_global: false,
            eulerseq: ['x', 'y', 'z'],
            autolimits: true,
            inertia_from_geom: InertiaFromGeom::IfNotGiven,
            mesh_folder: String::new(),
            total_mass_kg: None,
            least_mass_kg: 0.0,
            least_inertia_kg_m2: 0.0,
            balance_inertia: false,
            groups: [0.0, 5.0],
        };
        for element in root.children("compiler") {
            compiler.take(element, log);
        }
        compiler
    }

    fn take(&mut self, element: &Element, log: &Log) {
        if let Some(angle) = element.word("angle", &["degree", "radian"], log) {
            self.angle_rad = if angle == "degree" { 1_f64.to_radians() } else { 1.0 };
        }
        if let Some(word) = element.word("coordinate", &["local", "global"], log) {
            self.is_global = word == "global";
        }
        if let Some(sequence) = element.get("eulerseq") {
            let letters: Vec<char> = sequence.chars().collect();
            match <[char; 3]>::try_from(letters) {
                Ok(letters) if letters.iter().all(|it| "xyzXYZ".contains(*it)) => {
                    self.eulerseq = letters;
                }
                _ => log.problem(config::Problem {
                    place: element.place_of("eulerseq"),
                    message: format!(
                        "eulerseq of <compiler> must be three of x, y, z, X, Y, Z, got \"{}\"",
                        config::shown(sequence)
                    ),
                }),
            }
        }
        let flag = |name| element.word(name, &["true", "false"], log).map(|word| word == "true");
        self.autolimits = flag("autolimits").unwrap_or(self.autolimits);
        self.balance_inertia = flag("balanceinertia").unwrap_or(self.balance_inertia);
        if let Some(word) = element.word("inertiafromgeom", &["true", "false", "auto"], log) {
            self.inertia_from_geom = match word {
                "true" => InertiaFromGeom::Always,
                "false" => InertiaFromGeom::Never,
                _ => InertiaFromGeom::IfNotGiven,
            };
        }
        for name in ["assetdir", "meshdir"] {
            if let Some(folder) = element.get(name) {
                self.mesh_folder = folder.into();
            }
        }
        let number = |name: &str| element.number(name, log);
        self.total_mass_kg =
            number("settotalmass").filter(|mass| *mass > 0.0).or(self.total_mass_kg);
        self.least_mass_kg = number("boundmass").unwrap_or(self.least_mass_kg);
        self.least_inertia_kg_m2 = number("boundinertia").unwrap_or(self.least_inertia_kg_m2);
        self.groups = element.numbers("inertiagrouprange", log).unwrap_or(self.groups);
    }

    /// `pos`, and the orientation in one of its spellings.
    pub(super) fn pose(&self, element: &Element, log: &Log) -> Isometry3<f64> {
        let position = element.vector("pos", log).unwrap_or_default();
        Isometry3::from_parts(position.into(), self.orientation(element, log))
    }

    pub(super) fn orientation(&self, element: &Element, log: &Log) -> UnitQuaternion<f64> {
        let direction = |name: &str, [x, y, z]: [f64; 3]| {
            let found = Unit::try_new(Vector3::new(x, y, z), 1e-9);
            if found.is_none() {
                let message = format!("{name} of <{}> must be a direction, got 0", element.name);
                log.problem(config::Problem { place: element.place_of(name), message });
            }
            found
        };
        let found = if let Some([w, x, y, z]) = element.numbers("quat", log) {
            let found = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9);
            if found.is_none() {
                let message = format!("quat of <{}> must be a rotation, got 0", element.name);
                log.problem(config::Problem { place: element.place_of("quat"), message });
            }
            found
        } else if let Some([x, y, z, angle]) = element.numbers("axisangle", log) {
            direction("axisangle", [x, y, z]).map(|axis| turned(&axis, angle * self.angle_rad))
        } else if let Some(angles) = element.numbers("euler", log) {
            Some(self.euler(angles))
        } else if let Some([a, b, c, d, e, f]) = element.numbers("xyaxes", log) {
            direction("xyaxes", [a, b, c]).and_then(|x| {
                let y = Vector3::new(d, e, f);
                let y = direction("xyaxes", (y - x.into_inner() * x.dot(&y)).into())?;
                let axes = [x.into_inner(), y.into_inner(), x.cross(&y)];
                let matrix = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&axes));
                Some(UnitQuaternion::from_rotation_matrix(&matrix))
            })
        } else if let Some(axis) = element.numbers("zaxis", log) {
            direction("zaxis", axis).map(|axis| from_z(&axis))
        } else {
            None
        };
        found.unwrap_or_default()
    }

    /// Small letters turn about the axes as turned so far, capitals about the fixed ones.
    fn euler(&self, angles: [f64; 3]) -> UnitQuaternion<f64> {
        let mut rotation = UnitQuaternion::identity();
        for (letter, angle) in self.eulerseq.iter().zip(angles) {
            let axis = match letter.to_ascii_lowercase() {
                'x' => Vector3::x_axis(),
                'y' => Vector3::y_axis(),
                _ => Vector3::z_axis(),
            };
            let turn = turned(&axis, angle * self.angle_rad);
            rotation = if letter.is_ascii_lowercase() { rotation * turn } else { turn * rotation };
        }
        rotation
    }
}

/// The least turn that takes z to a direction.
pub(super) fn from_z(axis: &Unit<Vector3<f64>>) -> UnitQuaternion<f64> {
    let turn = Vector3::z().cross(axis);
    let quaternion = Quaternion::from_parts(1.0 + axis.z, turn);
    // Straight down: half a turn about x.
    UnitQuaternion::try_new(quaternion, 1e-9)
        .unwrap_or_else(|| UnitQuaternion::new_unchecked(Quaternion::new(0.0, 1.0, 0.0, 0.0)))
}
