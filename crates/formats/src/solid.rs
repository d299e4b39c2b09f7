//! Solids: how much they hold, how mass is spread in them, and how far down they reach.
//!
//! Moments of a solid of mass m that is filled evenly, as in any handbook of mechanics:
//!
//! ```text
//! box, half extents a b c    m (b² + c²)/3, ...
//! ellipsoid, radii a b c     m (b² + c²)/5, ...
//! cylinder, length l         across: m (l²/12 + r²/4);  along: m r²/2
//! capsule                    its cylinder's, and its two half balls': of both together, mass n,
//!                            across: n (2/5 r² + l²/4 + 3/8 l r);  along: 2/5 n r²
//! ```

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Point3, Quaternion, UnitQuaternion, Vector3};

use crate::{
    mesh::Mesh,
    robot::{Inertial, Shape, Solid},
};

impl Solid {
    /// In m^3; a mesh needs its surface.
    pub(crate) fn volume_m3(&self) -> Option<f64> {
        let ball = |radii: f64| 4.0 / 3.0 * PI * radii;
        match *self {
            Self::Box(half) => Some(8.0 * half.x * half.y * half.z),
            Self::Ball(r) => Some(ball(r * r * r)),
            Self::Ellipsoid(r) => Some(ball(r.x * r.y * r.z)),
            Self::Cylinder(r, half) => Some(2.0 * PI * r * r * half),
            Self::Capsule(r, half) => Some(2.0 * PI * r * r * half + ball(r * r * r)),
            Self::Mesh { .. } => None,
        }
    }

    /// Moments about its own axes and centre, in kg m^2; none of a mesh.
    fn moments_kg_m2(&self, mass_kg: f64) -> Vector3<f64> {
        let squares = |half: &Vector3<f64>| {
            let s = half.component_mul(half);
            Vector3::new(s.y + s.z, s.x + s.z, s.x + s.y)
        };
        match *self {
            Self::Box(half) => squares(&half) * (mass_kg / 3.0),
            Self::Ball(r) => Vector3::repeat(0.4 * mass_kg * r * r),
            Self::Ellipsoid(radii) => squares(&radii) * (mass_kg / 5.0),
            Self::Cylinder(r, half) => cylinder(mass_kg, r, 2.0 * half),
            Self::Capsule(r, half) => {
                let l = 2.0 * half;
                let (cylinder_volume, balls_volume) = (PI * r * r * l, 4.0 / 3.0 * PI * r * r * r);
                let n = mass_kg * balls_volume / (cylinder_volume + balls_volume);
                let along = 0.4 * n * r * r;
                let across = along + n * (l * l / 4.0 + 3.0 / 8.0 * l * r);
                cylinder(mass_kg - n, r, l) + Vector3::new(across, across, along)
            }
            Self::Mesh { .. } => Vector3::zeros(),
        }
    }

    /// How far it reaches from the origin of its frame in a direction there, in m.
    pub(crate) fn reach_m(&self, direction: &Vector3<f64>, mesh: Option<&Mesh>) -> f64 {
        let across = libm::sqrt(direction.x * direction.x + direction.y * direction.y);
        match self {
            Self::Box(half) => half.dot(&direction.abs()),
            Self::Ball(r) => *r,
            Self::Ellipsoid(radii) => radii.component_mul(direction).norm(),
            Self::Cylinder(r, half) => r * across + half * direction.z.abs(),
            Self::Capsule(r, half) => r + half * direction.z.abs(),
            Self::Mesh { scale, .. } => mesh.map_or(0.0, |mesh| {
                let reach = |p: &Point3<f64>| p.coords.component_mul(scale).dot(direction);
                mesh.corners.iter().map(reach).fold(f64::NEG_INFINITY, f64::max)
            }),
        }
    }

    /// Whether it has a size below 0.
    pub(crate) fn is_negative(&self) -> bool {
        match self {
            Self::Box(v) | Self::Ellipsoid(v) => v.iter().any(|half| *half < 0.0),
            Self::Ball(r) => *r < 0.0,
            Self::Cylinder(r, half) | Self::Capsule(r, half) => *r < 0.0 || *half < 0.0,
            Self::Mesh { .. } => false,
        }
    }

    /// Whether its sizes are ones.
    pub(crate) fn is_solid(&self) -> bool {
        let all = |v: &Vector3<f64>| v.iter().all(|half| *half > 0.0);
        match self {
            Self::Box(v) | Self::Ellipsoid(v) => all(v),
            Self::Ball(r) => *r > 0.0,
            Self::Cylinder(r, half) => *r > 0.0 && *half > 0.0,
            Self::Capsule(r, half) => *r > 0.0 && *half >= 0.0,
            Self::Mesh { scale, .. } => scale.iter().all(|factor| *factor != 0.0),
        }
    }
}

/// About x, y and its axis z.
fn cylinder(m: f64, r: f64, l: f64) -> Vector3<f64> {
    let across = m * (l * l / 12.0 + r * r / 4.0);
    Vector3::new(across, across, m * r * r / 2.0)
}

impl Shape {
    /// What it weighs with a mass, filled evenly.
    pub(crate) fn filled(&self, mass_kg: f64) -> Inertial {
        let moments = Matrix3::from_diagonal(&self.solid.moments_kg_m2(mass_kg));
        Inertial {
            mass_kg,
            centre_m: self.pose.translation.vector.into(),
            tensor_kg_m2: turned(&moments, &self.pose.rotation),
        }
    }
}

/// A tensor along the axes of a frame, along those that the frame is seen from.
pub(crate) fn turned(tensor: &Matrix3<f64>, frame: &UnitQuaternion<f64>) -> Matrix3<f64> {
    let r = frame.to_rotation_matrix().into_inner();
    r * tensor * r.transpose()
}

impl Inertial {
    /// The same, in the frame that its own one is seen from.
    pub(crate) fn seen_from(&self, frame: &Isometry3<f64>) -> Self {
        Self {
            mass_kg: self.mass_kg,
            centre_m: frame * self.centre_m,
            tensor_kg_m2: turned(&self.tensor_kg_m2, &frame.rotation),
        }
    }

    /// Several held together; `None` of none.
    pub(crate) fn sum(parts: &[Self]) -> Option<Self> {
        let mass_kg: f64 = parts.iter().map(|part| part.mass_kg).sum();
        if parts.is_empty() || mass_kg <= 0.0 {
            return None;
        }
        let centre: Vector3<f64> =
            parts.iter().map(|part| part.centre_m.coords * part.mass_kg).sum::<Vector3<f64>>()
                / mass_kg;
        // Steiner.
        let about_centre = |part: &Self| {
            let d = part.centre_m.coords - centre;
            let shifted = Matrix3::identity() * d.dot(&d) - d * d.transpose();
            part.tensor_kg_m2 + shifted * part.mass_kg
        };
        Some(Self {
            mass_kg,
            centre_m: centre.into(),
            tensor_kg_m2: parts.iter().map(about_centre).sum(),
        })
    }

    /// Principal moments, in kg m^2, and the frame of their axes. Moments are in the order, and axes
    /// point the ways, that turn the frame least from the link's; along the link's own axes the frame
    /// isn't turned at all.
    #[must_use]
    pub fn principal(&self) -> (Vector3<f64>, UnitQuaternion<f64>) {
        let tensor = &self.tensor_kg_m2;
        let largest = tensor.diagonal().amax();
        let off = [tensor[(0, 1)], tensor[(0, 2)], tensor[(1, 2)]];
        // Far beyond the digits that files have.
        if off.iter().all(|product| product.abs() <= 1e-12 * largest) {
            return (tensor.diagonal(), UnitQuaternion::identity());
        }
        let eigen = tensor.symmetric_eigen();
        if let Some(found) = symmetric(&eigen.eigenvalues, &eigen.eigenvectors) {
            return found;
        }
        let (mut best, mut trace) = (None, f64::NEG_INFINITY);
        for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let mut axes = Matrix3::from_columns(&order.map(|i| eigen.eigenvectors.column(i)));
            for i in 0..3 {
                if axes[(i, i)] < 0.0 {
                    axes.column_mut(i).neg_mut();
                }
            }
            if axes.determinant() < 0.0 {
                // The axis that this turns least.
                let i = axes.diagonal().imin();
                axes.column_mut(i).neg_mut();
            }
            // A rounding's difference doesn't change the order.
            if axes.trace() > trace + 1e-9 {
                trace = axes.trace();
                best = Some((order, axes));
            }
        }
        let Some((order, axes)) = best else {
            return (tensor.diagonal(), UnitQuaternion::identity());
        };
        let frame = nalgebra::Rotation3::from_matrix_unchecked(axes);
        let moments = Vector3::from(order.map(|i| eigen.eigenvalues[i]));
        (moments, UnitQuaternion::from_rotation_matrix(&frame))
    }
}

/// Of what is round about an axis, whose other axes are any: the least turn to that axis.
fn symmetric(
    values: &Vector3<f64>,
    vectors: &Matrix3<f64>,
) -> Option<(Vector3<f64>, UnitQuaternion<f64>)> {
    let alike = |i: usize, j: usize| (values[i] - values[j]).abs() <= 1e-9 * values.amax();
    let lone = match (alike(0, 1), alike(1, 2), alike(0, 2)) {
        (false, false, false) => return None,
        (true, true, _) => return Some((*values, UnitQuaternion::identity())),
        (true, ..) => 2,
        (_, true, _) => 0,
        _ => 1,
    };
    let axis: Vector3<f64> = vectors.column(lone).into();
    let letter = axis.iamax();
    let axis = if axis[letter] < 0.0 { -axis } else { axis };
    let unit = Vector3::ith(letter, 1.0);
    let turn = Quaternion::from_parts(1.0 + axis.dot(&unit), unit.cross(&axis));
    let mut moments = Vector3::repeat(values[(lone + 1) % 3]);
    moments[letter] = values[lone];
    Some((moments, UnitQuaternion::from_quaternion(turn)))
}

#[cfg(test)]
mod tests {
    use config::Place;

    use super::*;
    use crate::robot::roll_pitch_yaw;

    fn at(x: f64, y: f64, z: f64) -> Isometry3<f64> {
        Isometry3::translation(x, y, z)
    }

    #[test]
    fn halves_of_a_box_make_the_box() {
        let solid = |y, half| Shape {
            place: Place::whole("test"),
            pose: at(0.0, y, 0.0),
            solid: Solid::Box(Vector3::new(1.0, half, 3.0)),
        };
        let half = |y| solid(y, 1.0);
        let sum = Inertial::sum(&[half(-1.0).filled(2.0), half(1.0).filled(2.0)]).unwrap();
        let whole = solid(0.0, 2.0).filled(4.0);
        assert_eq!(sum.mass_kg, 4.0);
        // A few roundings.
        assert!((sum.tensor_kg_m2 - whole.tensor_kg_m2).amax() < 1e-12);
    }

    #[test]
    fn principal_axes_give_the_tensor_back_and_stay_near_the_links() {
        let (tall, round) = (Vector3::new(1.0, 2.0, 2.5), Vector3::new(2.0, 1.0, 2.0));
        let turns = [[0.1, -0.2, 0.3], [0.0, 0.0, 1.0], [3.0, 1.0, 2.0]];
        for (moments, [roll, pitch, yaw]) in
            [tall, round].iter().flat_map(|it| turns.map(|turn| (it, turn)))
        {
            let frame = roll_pitch_yaw([roll, pitch, yaw]);
            let tensor_kg_m2 = turned(&Matrix3::from_diagonal(moments), &frame);
            let inertial = Inertial { mass_kg: 1.0, centre_m: Point3::origin(), tensor_kg_m2 };
            let (found, axes) = inertial.principal();
            let back = turned(&Matrix3::from_diagonal(&found), &axes);
            // The eigenvalues' own tolerance.
            assert!((back - tensor_kg_m2).amax() < 1e-12, "{back}");
            // No rotation of a cube is farther from all of them than that.
            assert!(axes.angle() < 1.1, "{}", axes.angle());
        }
        let plain = Inertial {
            mass_kg: 1.0,
            centre_m: Point3::origin(),
            tensor_kg_m2: Matrix3::from_diagonal(&Vector3::new(3.0, 1.0, 2.5)),
        };
        assert_eq!(plain.principal().1, UnitQuaternion::identity());
    }

    #[test]
    fn solids_reach_as_far_as_they_do() {
        let down = -Vector3::z();
        let slanting = Vector3::new(0.6, 0.0, -0.8);
        assert_eq!(Solid::Box(Vector3::new(1.0, 2.0, 3.0)).reach_m(&down, None), 3.0);
        assert_eq!(Solid::Capsule(0.5, 2.0).reach_m(&down, None), 2.5);
        assert_eq!(Solid::Cylinder(0.5, 2.0).reach_m(&slanting, None), 0.3 + 1.6);
        assert_eq!(Solid::Ellipsoid(Vector3::new(1.0, 1.0, 2.0)).reach_m(&down, None), 2.0);
    }
}
