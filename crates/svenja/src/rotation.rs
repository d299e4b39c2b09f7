//! Rotations as model files write them, and mirror images.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// An axis of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Turn {
    /// The x axis.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}

impl Turn {
    /// The axis's letter.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["x", "y", "z"][self.index()]
    }

    /// The axis's place in a vector: 0, 1 or 2.
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }

    /// The unit vector along the axis.
    #[must_use]
    pub fn unit(self) -> Vector3<f64> {
        Vector3::ith(self.index(), 1.0)
    }
}

/// Turned about x, then about the fixed y, then about the fixed z: R = Rz Ry Rx. With `libm`'s sine
/// and cosine, whose bits don't depend on the machine.
pub(crate) fn from_euler_deg([x, y, z]: [f64; 3]) -> UnitQuaternion<f64> {
    let about = |turn: Turn, degrees: f64| {
        let half = degrees.to_radians() / 2.0;
        let vector = turn.unit() * libm::sin(half);
        UnitQuaternion::new_unchecked(Quaternion::from_parts(libm::cos(half), vector))
    };
    about(Turn::Z, z) * about(Turn::Y, y) * about(Turn::X, x)
}

/// The plane through the origin across an axis, as a mirror. All of it is exact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mirror(pub(crate) Turn);

impl Mirror {
    pub(crate) fn point(self, point: &Point3<f64>) -> Point3<f64> {
        let mut image = *point;
        image[self.0.index()] *= -1.0;
        image
    }

    /// Of a thing whose shape is mirrored too: M R M, with M the reflection.
    pub(crate) fn pose(self, pose: &Isometry3<f64>) -> Isometry3<f64> {
        let q = pose.rotation.coords;
        let kept = self.0.index();
        let coords = [0, 1, 2].map(|i| if i == kept { q[i] } else { -q[i] });
        let rotation = Quaternion::new(q.w, coords[0], coords[1], coords[2]);
        self.moved(pose, UnitQuaternion::new_unchecked(rotation))
    }

    /// Of a joint's frame: a turn about an axis becomes one the other way about its mirror image,
    /// so the frame with the same angles has the axes -M R, which is right-handed.
    pub(crate) fn joint_frame(self, frame: &Isometry3<f64>) -> Isometry3<f64> {
        let half_turn = Quaternion::from_parts(0.0, self.0.unit());
        let rotation = half_turn * frame.rotation.quaternion();
        self.moved(frame, UnitQuaternion::new_unchecked(rotation))
    }

    fn moved(self, pose: &Isometry3<f64>, rotation: UnitQuaternion<f64>) -> Isometry3<f64> {
        let position = self.point(&pose.translation.vector.into());
        Isometry3::from_parts(Translation3::from(position), rotation)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;

    /// A few roundings of numbers about 1.
    const EPSILON: f64 = 1e-14;

    #[test]
    fn angles_turn_about_fixed_axes_in_turn() {
        let turned = from_euler_deg([90.0, 0.0, 90.0]) * Vector3::y();
        assert!((turned - Vector3::z()).norm() < EPSILON, "about x to z, which z leaves");
        let turned = from_euler_deg([0.0, 0.0, 30.0]) * Vector3::x();
        assert!((turned - Vector3::new(0.75_f64.sqrt(), 0.5, 0.0)).norm() < EPSILON);
        let turned = from_euler_deg([0.0, 90.0, 90.0]) * Vector3::x();
        assert!((turned + Vector3::z()).norm() < EPSILON, "about y to -z, which z leaves");
    }

    #[test]
    fn a_mirror_image_is_what_the_reflection_makes() {
        let pose = Isometry3::from_parts(
            Translation3::new(1.0, 2.0, 3.0),
            from_euler_deg([20.0, -50.0, 110.0]),
        );
        let turn = from_euler_deg([0.0, 0.0, 40.0]);
        for across in [Turn::X, Turn::Y, Turn::Z] {
            let mut m = Matrix3::identity();
            m[(across.index(), across.index())] = -1.0;
            let mirror = Mirror(across);
            let r = pose.rotation.to_rotation_matrix().into_inner();
            let image = mirror.pose(&pose);
            let matrix = image.rotation.to_rotation_matrix().into_inner();
            assert!((matrix - m * r * m).norm() < EPSILON);
            assert_eq!(image.translation.vector, m * pose.translation.vector);

            // The same angle in the mirrored frame makes the mirrored turn.
            let in_space = |frame: &UnitQuaternion<f64>| {
                (frame * turn * frame.inverse()).to_rotation_matrix().into_inner()
            };
            let frame = mirror.joint_frame(&pose).rotation;
            assert!((in_space(&frame) - m * in_space(&pose.rotation) * m).norm() < EPSILON);
        }
    }
}
