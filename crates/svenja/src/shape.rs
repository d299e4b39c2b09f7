//! Shapes of bodies, and how mass is spread in them.
//!
//! Volumes, and principal moments of solids of mass m, filled evenly (any handbook of mechanics):
//!
//! ```text
//! box, half extents a b c    8 a b c        m (b² + c²)/3, m (a² + c²)/3, m (a² + b²)/3
//! ellipsoid, radii a b c     4/3 π a b c    m (b² + c²)/5, m (a² + c²)/5, m (a² + b²)/5
//! ball, radius r             4/3 π r³       2/5 m r²
//! cylinder, length l         π r² l         across: m (l²/12 + r²/4);  along: m r²/2
//! capsule                    its cylinder's, and its two half balls': of both together, mass n,
//!                            across: n (2/5 r² + l²/4 + 3/8 l r);  along: 2/5 n r²
//! ```
//!
//! A hull has its own page.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Point3, Quaternion, UnitQuaternion, Vector3};

use crate::{Hull, rotation::Mirror};

/// A shape where it lies in a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Collider {
    /// What it is.
    pub shape: Shape,
    /// The shape's frame, seen from the body's.
    pub pose: Isometry3<f64>,
}

impl Collider {
    /// As a mirror shows it, in the mirrored frame.
    pub(crate) fn image(&self, mirror: Mirror) -> Self {
        Self { shape: self.shape.image(mirror), pose: mirror.pose(&self.pose) }
    }

    /// Its centre of mass in the body's frame, in m.
    #[must_use]
    pub fn centre_m(&self) -> Point3<f64> {
        let centre = self.shape.centre_m();
        if self.is_as_the_body() { centre } else { self.pose * centre }
    }

    /// From the body's frame to that of the shape's own axes.
    #[must_use]
    pub fn principal_axes(&self) -> UnitQuaternion<f64> {
        let axes = self.shape.principal_axes();
        if self.is_as_the_body() { axes } else { self.pose.rotation * axes }
    }

    /// A product with 1 may lose a zero's sign, and so change later bits.
    fn is_as_the_body(&self) -> bool {
        self.pose == Isometry3::identity()
    }
}

/// What a body looks like and collides as, and gets its inertia from if none is given.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A box around the origin.
    Box {
        /// Half its size along x, y and z, in m.
        half_extents_m: Vector3<f64>,
    },
    /// A ball around the origin.
    Sphere {
        /// In m.
        radius_m: f64,
    },
    /// A cylinder with half balls at its ends.
    Capsule(Rod),
    /// A cylinder.
    Cylinder(Rod),
    /// A ball around the origin, stretched.
    Ellipsoid {
        /// Half its size along x, y and z, in m.
        radii_m: Vector3<f64>,
    },
    /// The convex hull of some points.
    Hull(Hull),
}

/// A round thing from one point to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Rod {
    /// The radius in m.
    pub radius_m: f64,
    /// One end of the axis, in m; a capsule's half ball lies beyond.
    pub from_m: Point3<f64>,
    /// The other end, in m.
    pub to_m: Point3<f64>,
}

impl Rod {
    /// From end to end, in m, without a capsule's half balls.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        (self.to_m - self.from_m).norm()
    }

    /// Its centre, in m.
    #[must_use]
    pub fn centre_m(&self) -> Point3<f64> {
        nalgebra::center(&self.from_m, &self.to_m)
    }

    /// The least turn that takes z to the rod's axis, either way along it.
    #[must_use]
    pub fn from_z(&self) -> UnitQuaternion<f64> {
        let axis = (self.to_m - self.from_m).normalize();
        let axis = if axis.z < 0.0 { -axis } else { axis };
        let turn = Vector3::z().cross(&axis);
        UnitQuaternion::from_quaternion(Quaternion::from_parts(1.0 + axis.z, turn))
    }
}

impl Shape {
    /// Its name in model files.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Box { .. } => "box",
            Self::Sphere { .. } => "sphere",
            Self::Capsule(_) => "capsule",
            Self::Cylinder(_) => "cylinder",
            Self::Ellipsoid { .. } => "ellipsoid",
            Self::Hull(_) => "hull",
        }
    }

    /// From the shape's frame to that of its own axes, along z for what is round. A hull has none, and
    /// lies as it does.
    #[must_use]
    pub fn principal_axes(&self) -> UnitQuaternion<f64> {
        match self {
            Self::Capsule(rod) | Self::Cylinder(rod) => rod.from_z(),
            _ => UnitQuaternion::identity(),
        }
    }

    /// Its centre of mass in its own frame, in m.
    #[must_use]
    pub fn centre_m(&self) -> Point3<f64> {
        match self {
            Self::Capsule(rod) | Self::Cylinder(rod) => rod.centre_m(),
            Self::Hull(hull) => hull.centre_m(),
            _ => Point3::origin(),
        }
    }

    /// Points of its frame around which it lies within a radius, both in m: enough to know how far it
    /// reaches in any direction.
    #[must_use]
    pub fn outline_m(&self) -> (Vec<Point3<f64>>, f64) {
        let corners = |half: &Vector3<f64>| {
            let sign =
                |i: usize, bit: usize| if i >> bit & 1 == 0 { -half[bit] } else { half[bit] };
            (0..8).map(|i| Point3::new(sign(i, 0), sign(i, 1), sign(i, 2))).collect()
        };
        match self {
            Self::Box { half_extents_m: half } | Self::Ellipsoid { radii_m: half } => {
                (corners(half), 0.0)
            }
            Self::Sphere { radius_m } => (vec![Point3::origin()], *radius_m),
            Self::Capsule(rod) | Self::Cylinder(rod) => (vec![rod.from_m, rod.to_m], rod.radius_m),
            Self::Hull(hull) => (hull.points_m().to_vec(), 0.0),
        }
    }

    /// As a mirror shows it, in the mirrored frame.
    pub(crate) fn image(&self, mirror: Mirror) -> Self {
        let rod = |rod: &Rod| Rod {
            radius_m: rod.radius_m,
            from_m: mirror.point(&rod.from_m),
            to_m: mirror.point(&rod.to_m),
        };
        match self {
            Self::Box { .. } | Self::Sphere { .. } | Self::Ellipsoid { .. } => self.clone(),
            Self::Hull(hull) => Self::Hull(hull.image(mirror)),
            Self::Capsule(capsule) => Self::Capsule(rod(capsule)),
            Self::Cylinder(cylinder) => Self::Cylinder(rod(cylinder)),
        }
    }

    /// In m³.
    #[must_use]
    pub fn volume_m3(&self) -> f64 {
        let ball = 4.0 / 3.0 * PI;
        match self {
            Self::Box { half_extents_m } => 8.0 * half_extents_m.product(),
            Self::Sphere { radius_m: r } => ball * r * r * r,
            Self::Ellipsoid { radii_m } => ball * radii_m.product(),
            Self::Cylinder(rod) => PI * rod.radius_m * rod.radius_m * rod.length_m(),
            Self::Capsule(rod) => {
                let r = rod.radius_m;
                PI * r * r * rod.length_m() + ball * r * r * r
            }
            Self::Hull(hull) => hull.volume_m3(),
        }
    }

    /// Moments about its own axes through its centre, in kg m², of a mass in kg; none for a hull, whose
    /// own axes aren't known.
    pub(crate) fn principal_moments(&self, mass_kg: f64) -> Option<Vector3<f64>> {
        Some(match self {
            Self::Box { half_extents_m } => across(half_extents_m) * (mass_kg / 3.0),
            Self::Ellipsoid { radii_m } => across(radii_m) * (mass_kg / 5.0),
            Self::Sphere { radius_m } => Vector3::repeat(0.4 * mass_kg * radius_m * radius_m),
            Self::Cylinder(rod) => cylinder(mass_kg, rod.radius_m, rod.length_m()),
            Self::Capsule(rod) => {
                let (r, l) = (rod.radius_m, rod.length_m());
                let (cylinder_volume, ball_volume) = (PI * r * r * l, 4.0 / 3.0 * PI * r * r * r);
                let n = mass_kg * ball_volume / (cylinder_volume + ball_volume);
                let along = 0.4 * n * r * r;
                let across = along + n * (l * l / 4.0 + 3.0 / 8.0 * l * r);
                cylinder(mass_kg - n, r, l) + Vector3::new(across, across, along)
            }
            Self::Hull(_) => return None,
        })
    }

    /// The inertia about its centre, along its frame's axes, in kg m², of a mass in kg.
    pub(crate) fn inertia_kg_m2(&self, mass_kg: f64) -> Matrix3<f64> {
        match (self, self.principal_moments(mass_kg)) {
            (Self::Hull(hull), _) => hull.inertia_kg_m2(mass_kg),
            (_, moments) => {
                let axes = self.principal_axes().to_rotation_matrix().into_inner();
                axes * Matrix3::from_diagonal(&moments.unwrap_or_default()) * axes.transpose()
            }
        }
    }
}

/// y² + z², x² + z², x² + y²
fn across(size: &Vector3<f64>) -> Vector3<f64> {
    let s = size.component_mul(size);
    Vector3::new(s.y + s.z, s.x + s.z, s.x + s.y)
}

/// About x, y and its axis z.
fn cylinder(m: f64, r: f64, l: f64) -> Vector3<f64> {
    let across = m * (l * l / 12.0 + r * r / 4.0);
    Vector3::new(across, across, m * r * r / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rod(radius_m: f64, to: [f64; 3]) -> Rod {
        Rod { radius_m, from_m: Point3::origin(), to_m: Point3::from(to) }
    }

    /// Sums over small cubes: an inertia that no formula went into. With cubes of h, a surface is
    /// off by up to h/2: a part of h/r of what matters, 2 % here.
    #[test]
    fn inertia_is_that_of_the_solid() {
        let (r, l, h) = (1.0, 3.0, 0.02);
        let inside_cylinder = |p: &Vector3<f64>| p.z.abs() <= l / 2.0 && p.xy().norm() <= r;
        let inside_capsule = |p: &Vector3<f64>| {
            let end = Vector3::new(0.0, 0.0, p.z.clamp(-l / 2.0, l / 2.0));
            (p - end).norm() <= r
        };
        let half = Vector3::new(0.5, 1.0, 1.5);
        let inside_box = |p: &Vector3<f64>| (0..3).all(|i| p[i].abs() <= half[i]);
        let inside_ball = |p: &Vector3<f64>| p.norm() <= r;
        type Inside<'a> = &'a dyn Fn(&Vector3<f64>) -> bool;
        let inside_ellipsoid = |p: &Vector3<f64>| p.component_div(&half).norm() <= 1.0;
        let cases: [(Shape, Inside<'_>); 5] = [
            (Shape::Ellipsoid { radii_m: half }, &inside_ellipsoid),
            (Shape::Cylinder(rod(r, [0.0, 0.0, l])), &inside_cylinder),
            (Shape::Capsule(rod(r, [0.0, 0.0, l])), &inside_capsule),
            (Shape::Box { half_extents_m: half }, &inside_box),
            (Shape::Sphere { radius_m: r }, &inside_ball),
        ];
        for (shape, inside) in cases {
            let (mut sum, mut count) = (Vector3::zeros(), 0.0);
            let n = (2.6 / h) as i32;
            for i in -n..n {
                for j in -n / 2..n / 2 {
                    for k in -n..n {
                        let p = Vector3::new(f64::from(j), f64::from(i), f64::from(k));
                        let p = (p + Vector3::repeat(0.5)) * h;
                        if inside(&p) {
                            let s = p.component_mul(&p);
                            sum += Vector3::new(s.y + s.z, s.x + s.z, s.x + s.y);
                            count += 1.0;
                        }
                    }
                }
            }
            let counted = sum * (5.0 / count);
            let formula = shape.principal_moments(5.0).unwrap();
            let volume = shape.volume_m3() / (count * h.powi(3));
            assert!((volume - 1.0).abs() < 0.02, "{}: {volume}", shape.name());
            for i in 0..3 {
                let ratio = formula[i] / counted[i];
                assert!((ratio - 1.0).abs() < 0.02, "{}: {formula} {counted}", shape.name());
            }
        }
    }

    #[test]
    fn a_rod_lies_along_its_own_z_axis() {
        for to in [[0.0, 0.0, 2.0], [0.0, 0.0, -2.0], [2.0, 0.0, 0.0], [0.6, -1.0, -0.3]] {
            let rod = rod(0.1, to);
            let axis = rod.from_z() * Vector3::z();
            let along = (rod.to_m - rod.from_m).normalize();
            // A few roundings.
            assert!((axis.dot(&along).abs() - 1.0).abs() < 1e-14, "{to:?}");
        }
    }
}
