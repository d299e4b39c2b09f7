//! How a body's mass resists turning: principal moments and the axes that they are about.
//!
//! Moments that are given are about the axes of the body's frame. Those of shapes are the sum of each
//! shape's own, filled evenly with its share of the mass by volume, and of its distance d from the
//! centre of them all (Steiner):
//!
//! ```text
//! I = sum of R I_i R^T + m_i (d·d - d d^T)
//! ```
//!
//! The body's centre of mass is its frame's origin, wherever the shapes are: their inertia is about
//! their own common centre.

use nalgebra::{Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};

use crate::{Body, Collider};

/// The inertia of a body about its centre of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// From the body's frame to that of the principal axes.
    pub axes: UnitQuaternion<f64>,
    /// About these axes, in kg m².
    pub moments_kg_m2: Vector3<f64>,
}

impl Body {
    /// What is given, or what the shapes make.
    #[must_use]
    pub fn inertia(&self) -> Inertia {
        if let Some(moments_kg_m2) = self.inertia_kg_m2 {
            return Inertia { axes: UnitQuaternion::identity(), moments_kg_m2 };
        }
        if let [collider] = &self.colliders[..]
            && let Some(moments_kg_m2) = collider.shape.principal_moments(self.mass_kg)
        {
            return Inertia { axes: collider.principal_axes(), moments_kg_m2 };
        }
        principal(tensor(&self.colliders, self.mass_kg))
    }
}

/// Of shapes about their common centre, along the body's axes.
fn tensor(colliders: &[Collider], mass_kg: f64) -> Matrix3<f64> {
    let volume: f64 = colliders.iter().map(|it| it.shape.volume_m3()).sum();
    let mass = |it: &Collider| mass_kg * it.shape.volume_m3() / volume;
    let moment: Vector3<f64> = colliders.iter().map(|it| it.centre_m().coords * mass(it)).sum();
    let centre = Point3::from(moment / mass_kg);
    let one = |it: &Collider| {
        let axes = it.pose.rotation.to_rotation_matrix().into_inner();
        let away = it.centre_m() - centre;
        let steiner = Matrix3::from_diagonal_element(away.norm_squared()) - away * away.transpose();
        axes * it.shape.inertia_kg_m2(mass(it)) * axes.transpose() + steiner * mass(it)
    };
    colliders.iter().map(one).sum()
}

/// Jacobi's rotations: each makes one of the three products zero; a few rounds make all of them as
/// small as rounding is. Takes roots alone, so its bits don't depend on the machine.
fn principal(mut tensor: Matrix3<f64>) -> Inertia {
    const ROUNDS: usize = 12;
    let mut axes = Matrix3::identity();
    for (p, q) in [(0, 1), (0, 2), (1, 2)].into_iter().cycle().take(3 * ROUNDS) {
        let product = tensor[(p, q)];
        if product.abs() <= f64::EPSILON * 0.25 * tensor.diagonal().min() {
            continue;
        }
        let half = 0.5 * (tensor[(q, q)] - tensor[(p, p)]) / product;
        let tangent = half.signum() / (half.abs() + (half * half + 1.0).sqrt());
        let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
        let mut turn = Matrix3::identity();
        (turn[(p, p)], turn[(q, q)]) = (cosine, cosine);
        (turn[(p, q)], turn[(q, p)]) = (tangent * cosine, -tangent * cosine);
        tensor = turn.transpose() * tensor * turn;
        axes *= turn;
    }
    let rotation = Rotation3::from_matrix_unchecked(axes);
    // Of something long and thin the least one is lost in rounding, and may be below 0.
    let least = tensor.diagonal().max() * 1e-9;
    Inertia {
        axes: UnitQuaternion::from_rotation_matrix(&rotation),
        moments_kg_m2: tensor.diagonal().map(|moment| moment.max(least)),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Translation3};

    use super::*;
    use crate::{Shape, rotation::from_euler_deg};

    fn body(colliders: Vec<Collider>) -> Body {
        Body {
            name: "b".into(),
            mass_kg: 6.0,
            friction: 1.0,
            colour: [0; 3],
            pose: Isometry3::identity(),
            colliders,
            inertia_kg_m2: None,
        }
    }

    fn boxed(half: [f64; 3], at: [f64; 3], turn: [f64; 3]) -> Collider {
        Collider {
            shape: Shape::Box { half_extents_m: half.into() },
            pose: Isometry3::from_parts(Translation3::from(at), from_euler_deg(turn)),
        }
    }

    /// As the tensor along the body's axes, which doesn't depend on the choice of axes.
    fn whole(inertia: &Inertia) -> Matrix3<f64> {
        let axes = inertia.axes.to_rotation_matrix().into_inner();
        axes * Matrix3::from_diagonal(&inertia.moments_kg_m2) * axes.transpose()
    }

    /// A box cut into three, wherever and however it lies.
    #[test]
    fn parts_together_are_the_whole() {
        for turn in [[0.0; 3], [20.0, -50.0, 110.0], [0.0, 90.0, 45.0]] {
            let place =
                Isometry3::from_parts(Translation3::new(0.3, 0.0, -2.0), from_euler_deg(turn));
            let part = |half: [f64; 3], at: [f64; 3]| {
                let part = boxed(half, at, [0.0; 3]);
                Collider { pose: place * part.pose, ..part }
            };
            let one = body(vec![part([0.3, 0.2, 0.1], [0.0; 3])]).inertia();
            let cut = vec![
                part([0.1, 0.2, 0.1], [-0.2, 0.0, 0.0]),
                part([0.2, 0.05, 0.1], [0.1, -0.15, 0.0]),
                part([0.2, 0.15, 0.1], [0.1, 0.05, 0.0]),
            ];
            let several = body(cut).inertia();
            assert!((whole(&one) - whole(&several)).norm() < 1e-14, "{one:?} {several:?}");
            let volume = one.moments_kg_m2.sum() - several.moments_kg_m2.sum();
            assert!(volume.abs() < 1e-14);
        }
    }

    /// Of a symmetric matrix these are its eigenvectors, whatever the size of its entries.
    #[test]
    fn axes_are_principal() {
        for scale in [1e-12, 1.0, 1e9] {
            let turn = from_euler_deg([33.0, 12.0, -70.0]).to_rotation_matrix().into_inner();
            for moments in [[1.0, 2.0, 2.5], [1.0, 1.0, 2.0], [3.0, 3.0, 3.0], [1e-6, 1.0, 1.0]] {
                let tensor =
                    turn * Matrix3::from_diagonal(&moments.into()) * turn.transpose() * scale;
                let found = principal(tensor);
                assert!((whole(&found) - tensor).norm() < 1e-14 * scale, "{moments:?}: {found:?}");
                let mut sorted = found.moments_kg_m2 / scale;
                sorted.as_mut_slice().sort_by(f64::total_cmp);
                assert!((sorted - Vector3::from(moments)).norm() < 1e-14, "{moments:?}: {found:?}");
            }
        }
    }

    #[test]
    fn what_is_given_counts() {
        let given = Vector3::new(1.0, 2.0, 2.5);
        let shapes = vec![boxed([0.3, 0.2, 0.1], [1.0, 0.0, 0.0], [0.0, 40.0, 0.0])];
        let body = Body { inertia_kg_m2: Some(given), ..body(shapes) };
        let expected = Inertia { axes: UnitQuaternion::identity(), moments_kg_m2: given };
        assert_eq!(body.inertia(), expected);
        assert_eq!(Body { colliders: Vec::new(), ..body }.inertia(), expected);
    }
}
