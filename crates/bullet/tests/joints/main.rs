//! The one convention of all joints (`src/joint.rs`), against geometry: signs, frames, limits,
//! motors, springs, stops and reactions of each kind.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod drives;
mod stops;

use bullet::{
    Axis, AxisSettings, Body, BodyId, BodyState, Joint, JointId, JointKind, JointState, Motor,
    MotorCommand, Push, SCALAR_BYTES, Shape, Spring, Stop, World, WorldSettings,
};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

/// Distance of 1 from the next number, in Bullet's precision.
const EPS: f64 = if SCALAR_BYTES == 8 { f64::EPSILON } else { f32::EPSILON as f64 };
const DT: f64 = 0.01;
/// What btHingeConstraint multiplies its stop's erp and bounce by, a float in both precisions.
const HINGE_BIAS: f64 = 0.3_f32 as f64;

/// The classes of joints that have ranges, motors and stops.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Class {
    Hinge,
    Slider,
    SixDof,
}

/// Each of their axes.
const DRIVEN: [(Class, Axis); 9] = [
    (Class::Hinge, Axis::AngularZ),
    (Class::Slider, Axis::LinearX),
    (Class::Slider, Axis::AngularX),
    (Class::SixDof, Axis::LinearX),
    (Class::SixDof, Axis::LinearY),
    (Class::SixDof, Axis::LinearZ),
    (Class::SixDof, Axis::AngularX),
    (Class::SixDof, Axis::AngularY),
    (Class::SixDof, Axis::AngularZ),
];

/// A joint that lets one axis move, the others locked.
fn kind((class, axis): (Class, Axis), settings: AxisSettings) -> JointKind {
    let locked = AxisSettings::locked();
    match (class, axis) {
        (Class::Hinge, _) => JointKind::Hinge(settings),
        (Class::Slider, Axis::LinearX) => {
            JointKind::Slider { linear: settings, angular: locked, held: Stop::BULLET }
        }
        (Class::Slider, _) => {
            JointKind::Slider { linear: locked, angular: settings, held: Stop::BULLET }
        }
        (Class::SixDof, _) => {
            let mut axes = [locked; 6];
            axes[axis.index()] = settings;
            JointKind::SixDofSpring(Box::new(axes))
        }
    }
}

fn is_angular(axis: Axis) -> bool {
    axis.index() >= 3
}

/// The child's frame seen from the parent's, at these six positions: R = Rz Ry Rx.
fn placed(position: [f64; 6]) -> Isometry3<f64> {
    let [x, y, z, roll, pitch, yaw] = position;
    let turn = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
    Isometry3::from_parts(
        Translation3::new(x, y, z),
        turn(Vector3::z_axis(), yaw)
            * turn(Vector3::y_axis(), pitch)
            * turn(Vector3::x_axis(), roll),
    )
}

fn along(axis: Axis, value: f64) -> [f64; 6] {
    let mut position = [0.0; 6];
    position[axis.index()] = value;
    position
}

/// Poses with nothing special about them: of the parent, and of the joint's frame in each body.
fn askew() -> [Isometry3<f64>; 3] {
    let pose = |x, y, z, a, b, c| {
        Isometry3::from_parts(
            Translation3::new(x, y, z),
            UnitQuaternion::from_euler_angles(a, b, c),
        )
    };
    [
        pose(0.4, -0.3, 0.8, 0.7, -0.4, 2.5),
        pose(0.2, 0.1, -0.3, -1.9, 0.6, 0.3),
        pose(-0.1, 0.25, 0.15, 0.5, 1.2, -0.8),
    ]
}

/// Two bodies and a joint between them in a world without gravity.
struct Pair {
    world: World,
    parent: BodyId,
    child: BodyId,
    joint: JointId,
    frames: [Isometry3<f64>; 2],
}

const MASS: f64 = 2.0;
const MOMENT: f64 = 0.5;

impl Pair {
    /// The joint begins with its axes at `start`. With a `parent_mass` the parent moves; its
    /// moment is a quarter of it.
    fn new(
        settings: &WorldSettings,
        kind: JointKind,
        [parent_pose, in_parent, in_child]: [Isometry3<f64>; 3],
        parent_mass: Option<f64>,
        start: [f64; 6],
    ) -> Self {
        let mut world = World::new(settings).unwrap();
        let shape = world.add_shape(&Shape::Sphere { radius: 0.1 }).unwrap();
        let body = |mass: f64, pose| Body {
            inertia: Some(Vector3::repeat(mass / MASS * MOMENT)),
            ..Body::dynamic(shape, mass, pose)
        };
        let parent = match parent_mass {
            Some(mass) => body(mass, parent_pose),
            None => Body::fixed(shape, parent_pose),
        };
        let child = body(MASS, parent_pose * in_parent * placed(start) * in_child.inverse());
        let parent = world.add_body(&parent).unwrap();
        let child = world.add_body(&child).unwrap();
        let joint = Joint {
            kind,
            parent,
            child,
            frame_in_parent: in_parent,
            frame_in_child: in_child,
            collide_connected: false,
        };
        let joint = world.add_joint(&joint).unwrap();
        Self { world, parent, child, joint, frames: [in_parent, in_child] }
    }

    /// Frames at the bodies' centres, the parent fixed.
    fn centred(kind: JointKind, start: [f64; 6]) -> Self {
        Self::new(&weightless(), kind, [Isometry3::identity(); 3], None, start)
    }

    fn state(&self) -> JointState {
        let mut joints = Vec::new();
        self.world.read_joints(&mut joints).unwrap();
        joints[self.joint.index()]
    }

    fn body(&self, id: BodyId) -> BodyState {
        let mut bodies = Vec::new();
        self.world.read_bodies(&mut bodies).unwrap();
        bodies[id.index()]
    }

    /// Gives the child the velocity that moves one axis; the frames must be at the centres and
    /// the parent at rest at the origin.
    fn set_speed(&mut self, axis: Axis, speed: f64) {
        let mut vectors = [Vector3::zeros(); 2];
        vectors[axis.index() / 3][axis.index() % 3] = speed;
        self.world.set_velocity(self.child, &vectors[0], &vectors[1]).unwrap();
    }

    fn steps(&mut self, count: u32) {
        for _ in 0..count {
            self.world.step().unwrap();
        }
    }
}

fn weightless() -> WorldSettings {
    WorldSettings { gravity: Vector3::zeros(), time_step: DT, ..WorldSettings::default() }
}

#[track_caller]
fn assert_near(what: &str, got: f64, expected: f64, tolerance: f64) {
    assert!(
        (got - expected).abs() <= tolerance,
        "{what}: {got} is {:e} from {expected}, more than {tolerance:e}",
        got - expected
    );
}
