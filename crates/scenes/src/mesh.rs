//! Shapes as triangles, for formats that know no others.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use svenja::{Collider, Rod, Shape};

/// Corners around what is round, and from an equator to a pole.
const AROUND: u16 = 32;
const TO_POLE: u16 = 8;

/// Triangles, anticlockwise from outside.
#[derive(Default)]
pub(crate) struct Mesh {
    pub(crate) corners: Vec<Corner>,
    /// Three corners each.
    pub(crate) triangles: Vec<u16>,
}

pub(crate) struct Corner {
    /// In m.
    pub(crate) position: [f32; 3],
    /// Of length 1.
    pub(crate) normal: [f32; 3],
}

impl Corner {
    fn change(&mut self, position: Vector3<f64>, normal: Vector3<f64>) {
        let single = |it: Vector3<f64>| [it.x as f32, it.y as f32, it.z as f32];
        (self.position, self.normal) = (single(position), single(normal.normalize()));
    }

    fn move_by(&mut self, pose: &Isometry3<f64>) {
        let [position, normal] = [self.position, self.normal].map(|it| Vector3::from(it).cast());
        self.change(pose.translation.vector + pose.rotation * position, pose.rotation * normal);
    }

    /// Of a ball.
    fn stretch(&mut self, by: &Vector3<f64>) {
        let [position, normal] = [self.position, self.normal].map(|it| Vector3::from(it).cast());
        self.change(position.component_mul(by), normal.component_div(by));
    }
}

impl Mesh {
    /// In the body's frame.
    pub(crate) fn of(collider: &Collider) -> Self {
        let mut mesh = Self::of_shape(&collider.shape);
        if collider.pose != Isometry3::identity() {
            for corner in &mut mesh.corners {
                corner.move_by(&collider.pose);
            }
        }
        mesh
    }

    fn of_shape(shape: &Shape) -> Self {
        match shape {
            Shape::Box { half_extents_m } => Self::boxed(half_extents_m),
            Shape::Sphere { radius_m } => Self::turned(
                &half_circle(*radius_m, 0.0),
                Point3::origin(),
                UnitQuaternion::identity(),
            ),
            Shape::Capsule(rod) => Self::rod(rod, &half_circle(rod.radius_m, 0.5 * rod.length_m())),
            Shape::Cylinder(rod) => {
                let (r, z) = (rod.radius_m, 0.5 * rod.length_m());
                // Each edge twice: it's sharp.
                let (up, out, down) = ([0.0, 1.0], [1.0, 0.0], [0.0, -1.0]);
                let outline = [
                    ([0.0, -z], down),
                    ([r, -z], down),
                    ([r, -z], out),
                    ([r, z], out),
                    ([r, z], up),
                    ([0.0, z], up),
                ];
                Self::rod(rod, &outline)
            }
            Shape::Ellipsoid { radii_m } => {
                let ball = half_circle(1.0, 0.0);
                let mut mesh = Self::turned(&ball, Point3::origin(), UnitQuaternion::identity());
                mesh.corners.iter_mut().for_each(|corner| corner.stretch(radii_m));
                mesh
            }
            Shape::Hull(hull) => {
                let mut mesh = Self::default();
                for [a, b, c] in hull.facets_m() {
                    let begin = mesh.corners.len() as u16;
                    let normal = (b - a).cross(&(c - a));
                    [a, b, c].iter().for_each(|corner| mesh.corner(corner.coords, normal));
                    mesh.triangles.extend([begin, begin + 1, begin + 2]);
                }
                mesh
            }
        }
    }

    fn rod(rod: &Rod, outline: &[([f64; 2], [f64; 2])]) -> Self {
        Self::turned(outline, rod.centre_m(), rod.from_z())
    }

    fn corner(&mut self, position: Vector3<f64>, normal: Vector3<f64>) {
        let single = |it: Vector3<f64>| [it.x as f32, it.y as f32, it.z as f32];
        self.corners
            .push(Corner { position: single(position), normal: single(normal.normalize()) });
    }

    /// An outline (radius and z, and the normal there) turned about z, from below.
    fn turned(
        outline: &[([f64; 2], [f64; 2])],
        centre: Point3<f64>,
        turn: UnitQuaternion<f64>,
    ) -> Self {
        let mut mesh = Self::default();
        for ([r, z], [normal_r, normal_z]) in outline {
            for i in 0..=AROUND {
                let angle = TAU * f64::from(i) / f64::from(AROUND);
                let (sin, cos) = (libm::sin(angle), libm::cos(angle));
                let position = Vector3::new(r * cos, r * sin, *z);
                let normal = Vector3::new(normal_r * cos, normal_r * sin, *normal_z);
                mesh.corner(centre.coords + turn * position, turn * normal);
            }
        }
        let ring = AROUND + 1;
        for (level, pair) in outline.windows(2).enumerate() {
            // A sharp edge is there twice, with nothing between.
            if pair[0].0 == pair[1].0 {
                continue;
            }
            let begin = level as u16 * ring;
            for i in begin..begin + AROUND {
                // At a pole one of the two triangles has no area.
                if pair[0].0[0] > 0.0 {
                    mesh.triangles.extend([i, i + 1, i + ring + 1]);
                }
                if pair[1].0[0] > 0.0 {
                    mesh.triangles.extend([i, i + ring + 1, i + ring]);
                }
            }
        }
        mesh
    }

    fn boxed(half: &Vector3<f64>) -> Self {
        let mut mesh = Self::default();
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut normal = Vector3::zeros();
                normal[axis] = sign;
                let mut along = Vector3::zeros();
                along[(axis + 1) % 3] = 1.0;
                let across = normal.cross(&along);
                let begin = mesh.corners.len() as u16;
                for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                    let direction: Vector3<f64> = normal + a * along + b * across;
                    mesh.corner(direction.component_mul(half), normal);
                }
                mesh.triangles.extend([0, 1, 2, 0, 2, 3].map(|corner| begin + corner));
            }
        }
        mesh
    }
}

/// Two quarter circles from pole to pole, their centres at -half and +half.
fn half_circle(radius: f64, half: f64) -> Vec<([f64; 2], [f64; 2])> {
    let quarter = |upper: bool| {
        (0..=TO_POLE).map(move |i| {
            let up = f64::from(i) / f64::from(TO_POLE);
            let angle = TAU / 4.0 * if upper { up } else { up - 1.0 };
            // A pole is on the axis, not beside it by a rounding.
            let on_axis = angle.abs() == TAU / 4.0;
            let (sin, cos) = (libm::sin(angle), if on_axis { 0.0 } else { libm::cos(angle) });
            let middle = if upper { half } else { -half };
            ([radius * cos, middle + radius * sin], [cos, sin])
        })
    };
    let skipped = usize::from(half == 0.0); // A ball has one equator.
    quarter(false).chain(quarter(true).skip(skipped)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;

    /// By Gauss, the volume is a third of the sum of p·n over the surface; facets lose a few percent
    /// of what is round.
    #[test]
    fn meshes_are_closed_and_turned_outwards() {
        let rod = Rod {
            radius_m: 0.1,
            from_m: Point3::new(0.1, 0.0, 0.2),
            to_m: Point3::new(0.1, 0.4, 0.5),
        };
        let ball = 4.0 / 3.0 * TAU / 2.0 * 0.1_f64.powi(3);
        let cylinder = TAU / 2.0 * 0.01 * 0.5;
        let cases = [
            (Shape::Box { half_extents_m: Vector3::new(0.1, 0.2, 0.3) }, 0.048),
            (Shape::Sphere { radius_m: 0.1 }, ball),
            (Shape::Capsule(rod.clone()), ball + cylinder),
            (Shape::Cylinder(rod), cylinder),
            (Shape::Ellipsoid { radii_m: Vector3::new(0.1, 0.05, 0.3) }, 1.5 * ball),
            (Shape::Hull(example::pyramid()), 0.008),
        ];
        for (shape, expected) in cases {
            let pose = Isometry3::new(Vector3::new(0.3, 0.0, -0.2), Vector3::new(0.4, 1.0, -2.0));
            let mesh = Mesh::of(&Collider { shape: shape.clone(), pose });
            let point = |i: u16| Vector3::from(mesh.corners[usize::from(i)].position).cast::<f64>();
            let volume: f64 = mesh
                .triangles
                .chunks(3)
                .map(|t| point(t[0]).dot(&point(t[1]).cross(&point(t[2]))) / 6.0)
                .sum();
            assert!((0.96..1.0001).contains(&(volume / expected)), "{shape:?}: {volume}");
            for triangle in mesh.triangles.chunks(3) {
                let [a, b, c] = [point(triangle[0]), point(triangle[1]), point(triangle[2])];
                let area = (b - a).cross(&(c - a));
                assert!(area.norm() > 1e-9, "{shape:?}: a triangle without an area");
                let normal =
                    Vector3::from(mesh.corners[usize::from(triangle[0])].normal).cast::<f64>();
                assert!(area.normalize().dot(&normal) > 0.8, "{shape:?}");
            }
        }
    }
}
