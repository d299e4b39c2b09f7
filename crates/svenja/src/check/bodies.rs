//! Bodies, their mirror images, and the meshes that their hulls are of.

use std::path::{Component, Path};

use config::{Placed, shown};
use nalgebra::{Point3, Vector3};

use super::{Checker, WORLD};
use crate::{
    Collider, Hull, Mesh, Shape,
    file::{BodyFile, ColliderFile, MeshFile, ModelFile, ShapeFile},
    mesh,
    morphology::Body,
};

/// The farthest that a hull may reach, in m, and the least of its lengths.
const FARTHEST_M: f64 = 1e3;
const SHORTEST_M: f64 = 1e-4;

/// A mesh that hulls are made of.
pub(super) struct Met {
    file: String,
    /// None if it can't be read, which has been said.
    points: Option<Vec<Point3<f64>>>,
    /// If it isn't in the model's own text.
    pub(super) from_file: Option<Mesh>,
}

impl Checker<'_> {
    pub(super) fn bodies<'f>(
        &mut self,
        model: &'f ModelFile,
        folder: &Path,
    ) -> Vec<(&'f BodyFile, Body)> {
        self.own_meshes(&model.meshes);
        let mut bodies = Vec::new();
        for file in &model.bodies {
            if file.name.value == WORLD {
                let message = format!(
                    "body '{WORLD}' must have another name: \"{WORLD}\" is what joints call the \
                     world by, as their parent"
                );
                self.complain(&file.name.place, message);
            }
            let body = Body {
                name: file.name.value.clone(),
                mass_kg: file.mass_kg,
                friction: file.friction,
                colour: file.colour,
                pose: file.pose,
                colliders: self.colliders(file, folder),
                inertia_kg_m2: file.inertia_kg_m2.as_ref().map(|moments| moments.value),
            };
            let image = self.image_name(&body.name).map(|name| Body {
                name,
                pose: self.reflection().pose(&body.pose),
                colliders: body.colliders.iter().map(|it| it.image(self.reflection())).collect(),
                ..body.clone()
            });
            bodies.push((file, body));
            bodies.extend(image.map(|image| (file, image)));
        }
        self.unique("body", bodies.iter().map(|(file, body)| (&file.name, body.name.as_str())));
        bodies
    }

    fn colliders(&mut self, body: &BodyFile, folder: &Path) -> Vec<Collider> {
        let subject = format!("body '{}': shape: ", body.name.value);
        let mut colliders = Vec::new();
        for ColliderFile { shape, pose } in &body.colliders {
            let shape = match shape {
                ShapeFile::Whole(shape) => Some(shape.clone()),
                ShapeFile::Hull { file, scale } => {
                    self.hull(&subject, file, scale, folder).map(Shape::Hull)
                }
            };
            colliders.extend(shape.map(|shape| Collider { shape, pose: *pose }));
        }
        colliders
    }

    fn hull(
        &mut self,
        subject: &str,
        file: &Placed<String>,
        scale: &Vector3<f64>,
        folder: &Path,
    ) -> Option<Hull> {
        let points = self.mesh(subject, file, folder)?;
        let scaled: Vec<_> =
            points.iter().map(|it| Point3::from(it.coords.component_mul(scale))).collect();
        let far = scaled.iter().map(|it| it.coords.norm()).fold(0.0, f64::max);
        let hull = Hull::around(&scaled).filter(|_| (SHORTEST_M..=FARTHEST_M).contains(&far));
        if hull.is_none() {
            let message = format!(
                "{subject}file must be a mesh that, with its scale, spans a volume and reaches \
                 {SHORTEST_M} to {FARTHEST_M} m from its origin, got {}, which reaches {far} m",
                shown(&file.value)
            );
            self.complain(&file.place, message);
        }
        hull
    }

    /// The corners of a mesh: of the model's own, or of a file, which is read once.
    fn mesh(
        &mut self,
        subject: &str,
        file: &Placed<String>,
        folder: &Path,
    ) -> Option<Vec<Point3<f64>>> {
        if let Some(met) = self.meshes.iter().find(|met| met.file == file.value) {
            return met.points.clone();
        }
        let name = shown(&file.value);
        let read = if is_below(&file.value) {
            mesh::corners(&folder.join(&file.value))
                .map_err(|what| format!("{subject}file must be a mesh: {name}{what}"))
        } else {
            let expected = "a path to a file beside the model or in a folder below it";
            Err(format!("{subject}file must be {expected}, got \"{name}\""))
        };
        let points = read.map_err(|message| self.complain(&file.place, message)).ok();
        let from_file = points.clone().map(|points| Mesh { file: file.value.clone(), points });
        self.meshes.push(Met { file: file.value.clone(), points: points.clone(), from_file });
        points
    }

    fn own_meshes(&mut self, meshes: &[MeshFile]) {
        for MeshFile { file, points } in meshes {
            if self.meshes.iter().any(|met| met.file == file.value) {
                let name = shown(&file.value);
                self.complain(
                    &file.place,
                    format!("mesh: file must not come twice, got \"{name}\""),
                );
                continue;
            }
            let points = Hull::around(points).map(|_| points.clone());
            if points.is_none() {
                let message = format!("mesh '{}': points must span a volume", shown(&file.value));
                self.complain(&file.place, message);
            }
            let file = file.value.clone();
            self.meshes.push(Met { file, points, from_file: None });
        }
    }
}

/// Whether a path stays in its folder, so that a robot and its files can be put elsewhere together.
fn is_below(path: &str) -> bool {
    let mut parts = Path::new(path).components();
    !path.contains(char::is_control)
        && parts.clone().next().is_some()
        && parts.all(|part| matches!(part, Component::Normal(_)))
}
