//! Joints between two bodies, all in one convention.
//!
//! A joint has a frame fixed in the parent and one fixed in the child. Its position is the child's
//! frame seen from the parent's: three coordinates (m), three angles (rad). Angles are
//! right-handed rotations of the child: in a joint with three of them the child's frame is the
//! parent's turned about z, then about the new y, then about the newest x. A motor with a positive
//! target velocity makes its position grow. Forces are in N and torques in N m. All this holds
//! whatever the conventions of Bullet's classes; `cpp/joints.cc` has them side by side.
//!
//! To joint a body to the world, joint it to a static body. (Bullet's single-body joints share one
//! body between all worlds of a program.)

use nalgebra::Isometry3;

use crate::{BodyId, JointId, JointState, body::to_pose, bridge::ffi};

/// A joint to be added with [`World::add_joint`](crate::World::add_joint).
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// The joint's kind, with its axes: what it lets move, and how far.
    pub kind: JointKind,
    /// The body in whose frame positions are told.
    pub parent: BodyId,
    /// The body that moves against the parent.
    pub child: BodyId,
    /// The joint's frame as seen from the parent's centre of mass.
    pub frame_in_parent: Isometry3<f64>,
    /// The joint's frame as seen from the child's centre of mass.
    pub frame_in_child: Isometry3<f64>,
    /// Whether the two bodies collide with each other.
    pub collide_connected: bool,
}

impl Joint {
    /// A joint whose two frames coincide, given in world coordinates, while the bodies are at
    /// `parent_pose` and `child_pose`: the joint's zero. The bodies don't collide with each other.
    ///
    /// ```
    /// use bullet::{AxisSettings, Body, Joint, JointKind, Shape, World, WorldSettings};
    /// use nalgebra::Isometry3;
    /// let mut world = World::new(&WorldSettings::default())?;
    /// let ball = world.add_shape(&Shape::Sphere { radius: 0.1 })?;
    /// let (above, below) =
    ///     (Isometry3::translation(0.0, 0.0, 2.0), Isometry3::translation(0.0, 0.0, 1.0));
    /// let pivot = world.add_body(&Body::fixed(ball, above))?;
    /// let bob = world.add_body(&Body::dynamic(ball, 1.0, below))?;
    /// let hinge = JointKind::Hinge(AxisSettings::free());
    /// world.add_joint(&Joint::at(&above, hinge, (pivot, &above), (bob, &below)))?;
    /// # Ok::<(), bullet::Error>(())
    /// ```
    pub fn at(
        frame: &Isometry3<f64>,
        kind: JointKind,
        (parent, parent_pose): (BodyId, &Isometry3<f64>),
        (child, child_pose): (BodyId, &Isometry3<f64>),
    ) -> Self {
        Self {
            kind,
            parent,
            child,
            frame_in_parent: parent_pose.inv_mul(frame),
            frame_in_child: child_pose.inv_mul(frame),
            collide_connected: false,
        }
    }

    pub(crate) fn to_spec(&self) -> ffi::JointSpec {
        let mut axes = [AxisSettings::locked().to_spec(); 6];
        let mut set = |axis: Axis, settings: &AxisSettings| {
            axes[axis.index()] = settings.to_spec();
        };
        let kind = match &self.kind {
            JointKind::Fixed => ffi::JointKind::Fixed,
            JointKind::PointToPoint => ffi::JointKind::PointToPoint,
            JointKind::Hinge(angular) => {
                set(Axis::AngularZ, angular);
                ffi::JointKind::Hinge
            }
            JointKind::Slider { linear, angular, held } => {
                set(Axis::LinearX, linear);
                set(Axis::AngularX, angular);
                set(Axis::LinearY, &AxisSettings { stop: *held, ..AxisSettings::locked() });
                ffi::JointKind::Slider
            }
            JointKind::SixDofSpring(settings) => {
                for (axis, settings) in Axis::ALL.into_iter().zip(settings.iter()) {
                    set(axis, settings);
                }
                ffi::JointKind::SixDofSpring
            }
        };
        ffi::JointSpec {
            kind,
            parent: self.parent,
            child: self.child,
            frame_in_parent: to_pose(&self.frame_in_parent),
            frame_in_child: to_pose(&self.frame_in_child),
            collide_connected: self.collide_connected,
            axes,
        }
    }
}

/// The kinds of joints, by what they let move.
#[derive(Clone, Debug, PartialEq)]
pub enum JointKind {
    /// The bodies don't move against each other (`btFixedConstraint`).
    Fixed,
    /// All rotations (`btPoint2PointConstraint`).
    PointToPoint,
    /// Rotation about the frame's z axis (`btHingeConstraint`). No spring.
    Hinge(AxisSettings),
    /// Translation along the frame's x axis and rotation about it (`btSliderConstraint`): a
    /// slider with the rotation locked, a hinge with the translation locked. No springs.
    ///
    /// Bullet's slider takes the wrong end for the one that its rotation's motor approaches. A
    /// motor that turns away from a stop starts slowly within one step's travel of it; one that
    /// pushes against a stop gets beyond it, by one step's travel over the stop's erp. Its stops
    /// along x can't bounce: Bullet tests the wrong sign. And what is locked is let go in a step
    /// that begins without any error at all; a range without a length elsewhere than at 0 makes
    /// that rare.
    Slider {
        /// Along x.
        linear: AxisSettings,
        /// About x.
        angular: AxisSettings,
        /// How the other four axes are held. By itself with the world's settings.
        held: Stop,
    },
    /// Each axis by itself, in the order of [`Axis`] (`btGeneric6DofSpring2Constraint`). The
    /// rotation about y must stay within a quarter turn.
    SixDofSpring(Box<[AxisSettings; 6]>),
}

/// How one axis of a joint may move, and what moves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisSettings {
    /// The positions that the axis may take.
    pub range: Range,
    /// What happens at the ends of the range.
    pub stop: Stop,
    /// Drives the axis at a velocity; None: no motor, and none can be switched on later.
    pub motor: Option<Motor>,
    /// Pulls the axis towards a position; only on a 6-dof spring joint.
    pub spring: Option<Spring>,
}

impl AxisSettings {
    /// An axis that stays at 0.
    pub const fn locked() -> Self {
        Self { range: Range::Locked, stop: Stop::BULLET, motor: None, spring: None }
    }

    /// An axis without limits.
    pub const fn free() -> Self {
        Self { range: Range::Free, ..Self::locked() }
    }

    /// Stays between two positions, in m or rad.
    pub const fn limited(lower: f64, upper: f64) -> Self {
        Self { range: Range::Limited { lower, upper }, ..Self::locked() }
    }

    fn to_spec(self) -> ffi::AxisSpec {
        let (lower, upper) = match self.range {
            Range::Locked | Range::Free => (0.0, 0.0),
            Range::Limited { lower, upper } => (lower, upper),
        };
        let maybe = |value: Option<f64>| {
            value.map_or_else(Default::default, |value| ffi::Maybe { given: true, value })
        };
        let motor = self.motor.unwrap_or(Motor { target_velocity: 0.0, max_force: 0.0 });
        let spring =
            self.spring.unwrap_or(Spring { stiffness: 0.0, damping: 0.0, equilibrium: 0.0 });
        ffi::AxisSpec {
            free: self.range == Range::Free,
            lower,
            upper,
            stop_erp: maybe(self.stop.erp),
            stop_cfm: maybe(self.stop.cfm),
            stop_bounce: maybe(self.stop.bounce),
            has_motor: self.motor.is_some(),
            motor_velocity: motor.target_velocity,
            motor_force: motor.max_force,
            has_spring: self.spring.is_some(),
            spring_stiffness: spring.stiffness,
            spring_damping: spring.damping,
            spring_equilibrium: spring.equilibrium,
        }
    }
}

/// The positions that an axis may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// The axis stays at 0.
    Locked,
    /// The axis has no limits.
    Free,
    /// From `lower` to `upper`, in m or rad; angles within half a turn of 0.
    Limited {
        /// Lower end.
        lower: f64,
        /// Upper end, not below the lower.
        upper: f64,
    },
}

/// What happens at the ends of a range, or to what is held. None: what Bullet's class does by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Share of the overshoot that a step takes back, 0 to 1. By itself: the world's `joint_erp`,
    /// and 0.3 times that for a hinge. A 6-dof joint with a range stops ahead of its ends: it lets
    /// a step take no more than this share of the way that is left.
    pub erp: Option<f64>,
    /// Softness; 0 is rigid. By itself: the world's `cfm`.
    pub cfm: Option<f64>,
    /// Share of the speed that comes back, 0 to 1. By itself: 0, and for a hinge 0.3. It's never less than what erp makes: a step takes the overshoot back by a
    /// velocity, which stays. A 6-dof joint surely bounces only with an erp of 1; else it is
    /// slowed first.
    pub bounce: Option<f64>,
}

impl Stop {
    /// All left to Bullet.
    pub const BULLET: Self = Self { erp: None, cfm: None, bounce: None };
}

/// Drives an axis at a velocity, with what force it takes up to a limit. What force that was, and what
/// work it did, [`World::read_motors_of`](crate::World::read_motors_of) tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// The velocity that the motor drives at, in m/s or rad/s.
    pub target_velocity: f64,
    /// The largest force in N or torque in N m, at least 0; with 0 the axis runs free.
    pub max_force: f64,
}

/// A damped spring: force = -stiffness (position - equilibrium) - damping velocity.
///
/// Bullet integrates it explicitly and, where that would be unstable, limits stiffness and
/// damping to what the time step allows. It also lets the spring bring the axis no further than to
/// the velocity that the spring alone would give it: where gravity or a motor pulls the same way,
/// the two don't add up, and the stronger one counts. Against a load an undamped spring is exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// The stiffness in N/m or N m/rad, at least 0.
    pub stiffness: f64,
    /// The damping in N s/m or N m s/rad, at least 0.
    pub damping: f64,
    /// The position at which the spring is at rest, in m or rad.
    pub equilibrium: f64,
}

/// New target of a motor, for [`World::set_motors`](crate::World::set_motors).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorCommand {
    /// The joint that the axis belongs to.
    pub joint: JointId,
    /// Which of its axes; it must have been built with a motor.
    pub axis: Axis,
    /// The velocity in m/s or rad/s, positive where the axis' position grows.
    pub target_velocity: f64,
    /// The most it may use, in N or N m, at least 0; with 0 the axis runs free.
    pub max_force: f64,
}

impl MotorCommand {
    pub(crate) fn to_bridge(self) -> ffi::MotorCommand {
        let Self { joint, axis, target_velocity, max_force } = self;
        ffi::MotorCommand { joint, axis: axis as u8, target_velocity, max_force }
    }
}

/// One degree of freedom of a joint: along or about an axis of its frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Axis {
    /// Translation along x.
    LinearX,
    /// Translation along y.
    LinearY,
    /// Translation along z.
    LinearZ,
    /// Rotation about x.
    AngularX,
    /// Rotation about y.
    AngularY,
    /// Rotation about z.
    AngularZ,
}

impl Axis {
    /// All six, in the order of [`JointState::position`].
    pub const ALL: [Self; 6] = [
        Self::LinearX,
        Self::LinearY,
        Self::LinearZ,
        Self::AngularX,
        Self::AngularY,
        Self::AngularZ,
    ];

    /// The axis' place in [`JointState::position`] and [`JointState::velocity`].
    pub const fn index(self) -> usize {
        self as usize
    }
}

impl JointId {
    /// The joint's place in the buffer of [`World::read_joints`](crate::World::read_joints).
    pub const fn index(self) -> usize {
        self.slot as usize
    }
}

impl JointState {
    /// Position of one axis, in m or rad.
    pub fn position_of(&self, axis: Axis) -> f64 {
        self.position[axis.index()]
    }

    /// Velocity of one axis, in m/s or rad/s.
    pub fn velocity_of(&self, axis: Axis) -> f64 {
        self.velocity[axis.index()]
    }
}
