//! Rigid bodies.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};

use crate::{
    bridge::ffi,
    constants,
    ffi::{BodyId, BodyState, ShapeId},
};

/// A body to be added with [`World::add_body`](crate::World::add_body).
///
/// ```
/// use bullet::{Body, Shape, World, WorldSettings};
/// use nalgebra::Isometry3;
/// let mut world = World::new(&WorldSettings::default())?;
/// let ball = world.add_shape(&Shape::Sphere { radius: 0.1 })?;
/// let body = world.add_body(&Body {
///     friction: 1.0,
///     ..Body::dynamic(ball, 2.0, Isometry3::translation(0.0, 0.0, 1.0))
/// })?;
/// # Ok::<(), bullet::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The shape that it collides as.
    pub shape: ShapeId,
    /// Whether it stands still, is moved, or moves by forces.
    pub motion: Motion,
    /// The pose of its centre of mass, in world coordinates.
    pub pose: Isometry3<f64>,
    /// The mass in kg, between 1e-12 and 1e12; of dynamic bodies only.
    pub mass: f64,
    /// Principal moments about the axes of its own frame, in kg m²; None: what Bullet makes of the
    /// shape, filled evenly: exact for boxes, balls and cylinders, rough for others (see
    /// [`Shape`](crate::Shape)).
    pub inertia: Option<Vector3<f64>>,
    /// Coulomb's coefficient; a contact has the product of its two bodies' coefficients, and at most
    /// 10.
    pub friction: f64,
    /// Torque against rolling, as a lever arm in m; a contact has the sum of each body's arm times
    /// the other's `friction`.
    pub rolling_friction: f64,
    /// Torque against spinning on the contact normal, as a lever arm in m; combined like
    /// `rolling_friction`, and only where that isn't 0.
    pub spinning_friction: f64,
    /// Share of the approaching speed that is left after a collision, 0 to 1; a contact has the
    /// product of its two bodies'. Below 0.2 m/s Bullet takes 0. It is exact for bodies that touch
    /// as the step begins: those near it (see [`Contact`](crate::Contact)) are slowed first, those that
    /// overlap are pushed apart as well, by `contact_erp`.
    pub restitution: f64,
    /// Share of the linear velocity lost within 1 s, 0 to 1.
    pub linear_damping: f64,
    /// Share of the angular velocity lost within 1 s, 0 to 1.
    pub angular_damping: f64,
    /// Which bodies it can touch.
    pub filter: CollisionFilter,
}

impl Body {
    /// A body moved by forces, with Bullet's defaults: friction 0.5, all else 0.
    pub fn dynamic(shape: ShapeId, mass: f64, pose: Isometry3<f64>) -> Self {
        let filter = CollisionFilter::moving();
        Self::with(shape, Motion::Dynamic, mass, pose, filter)
    }

    /// A body that never moves, with Bullet's defaults: friction 0.5, all else 0.
    pub fn fixed(shape: ShapeId, pose: Isometry3<f64>) -> Self {
        let filter = CollisionFilter::still();
        Self::with(shape, Motion::Static, 0.0, pose, filter)
    }

    /// A body moved by the caller, with Bullet's defaults: friction 0.5, all else 0.
    pub fn kinematic(shape: ShapeId, pose: Isometry3<f64>) -> Self {
        let filter = CollisionFilter::still();
        Self::with(shape, Motion::Kinematic, 0.0, pose, filter)
    }

    fn with(
        shape: ShapeId,
        motion: Motion,
        mass: f64,
        pose: Isometry3<f64>,
        filter: CollisionFilter,
    ) -> Self {
        Self {
            shape,
            motion,
            pose,
            mass,
            inertia: None,
            friction: 0.5,
            rolling_friction: 0.0,
            spinning_friction: 0.0,
            restitution: 0.0,
            linear_damping: 0.0,
            angular_damping: 0.0,
            filter,
        }
    }

    pub(crate) fn to_spec(&self) -> ffi::BodySpec {
        ffi::BodySpec {
            shape: self.shape,
            motion: match self.motion {
                Motion::Static => ffi::Motion::Static,
                Motion::Dynamic => ffi::Motion::Dynamic,
                Motion::Kinematic => ffi::Motion::Kinematic,
            },
            pose: to_pose(&self.pose),
            mass: self.mass,
            has_inertia: self.inertia.is_some(),
            inertia: self.inertia.unwrap_or_default().into(),
            friction: self.friction,
            rolling_friction: self.rolling_friction,
            spinning_friction: self.spinning_friction,
            restitution: self.restitution,
            linear_damping: self.linear_damping,
            angular_damping: self.angular_damping,
            group: self.filter.group,
            mask: self.filter.mask,
        }
    }
}

/// How a body moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Motion {
    /// Never; it has no mass.
    Static,
    /// It moves by forces, contacts and joints.
    Dynamic,
    /// As the caller says ([`World::set_pose`](crate::World::set_pose)); it pushes dynamic bodies and
    /// isn't pushed back.
    Kinematic,
}

/// A force, torque or impulse for [`World::push`](crate::World::push).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Push {
    /// Force in N, acts during the next step.
    Force,
    /// Torque in N m, acts during the next step.
    Torque,
    /// Impulse in N s, changes the velocities at once.
    Impulse,
    /// Angular impulse in N m s, changes the angular velocity at once.
    AngularImpulse,
}

impl Push {
    pub(crate) fn to_bridge(self) -> ffi::Push {
        match self {
            Self::Force => ffi::Push::Force,
            Self::Torque => ffi::Push::Torque,
            Self::Impulse => ffi::Push::Impulse,
            Self::AngularImpulse => ffi::Push::AngularImpulse,
        }
    }
}

/// Two bodies can touch if each one's `mask` has a bit of the other's `group`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CollisionFilter {
    /// Bits of what the body is.
    pub group: i32,
    /// Bits of what it touches.
    pub mask: i32,
}

impl CollisionFilter {
    /// Bullet's default for dynamic bodies: touches all.
    pub const fn moving() -> Self {
        Self { group: constants::DefaultFilter, mask: constants::AllFilter }
    }

    /// Bullet's default for static and kinematic bodies: touches all but its own kind.
    pub const fn still() -> Self {
        Self {
            group: constants::StaticFilter,
            mask: constants::AllFilter ^ constants::StaticFilter,
        }
    }
}

impl BodyId {
    /// The body's place in the buffer of [`World::read_bodies`](crate::World::read_bodies).
    pub const fn index(self) -> usize {
        self.slot as usize
    }
}

impl BodyState {
    /// Centre of mass and orientation. The quaternion is computed from the matrix that Bullet
    /// keeps, so it's rounded; `position` and `rotation` hold the exact bits.
    pub fn pose(&self) -> Isometry3<f64> {
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&self.rotation));
        let quaternion = UnitQuaternion::from_rotation_matrix(&rotation);
        Isometry3::from_parts(Point3::from(self.position).into(), quaternion)
    }

    /// A direction of the body's frame in world coordinates.
    pub fn direction(&self, in_body: &Vector3<f64>) -> Vector3<f64> {
        Matrix3::from_row_slice(&self.rotation) * in_body
    }

    /// The velocity at a point of the body given in world coordinates, in m/s.
    pub fn velocity_at(&self, point: &Point3<f64>) -> Vector3<f64> {
        let arm = point - Point3::from(self.position);
        Vector3::from(self.linear_velocity) + Vector3::from(self.angular_velocity).cross(&arm)
    }
}

pub(crate) fn to_pose(pose: &Isometry3<f64>) -> ffi::Pose {
    let q = pose.rotation.coords;
    ffi::Pose { position: pose.translation.vector.into(), rotation: [q.x, q.y, q.z, q.w] }
}
