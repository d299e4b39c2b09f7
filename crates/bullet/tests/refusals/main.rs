//! What Bullet couldn't use is refused with the call, the argument, what it should be and what it
//! was, and the world is then as before.
//!
//! "As before" is proved by the snapshot's bytes, and by a twin that never heard the question:
//! both go on with the same bits.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod making;
mod using;

use bullet::{
    Axis, AxisSettings, Body, BodyId, Error, Joint, JointId, JointKind, Lengthwise, Motor,
    MotorCommand, Push, Range, Shape, ShapeId, Spring, Stop, World, WorldSettings,
};
use nalgebra::{Isometry3, Point3, Quaternion, Unit, UnitQuaternion, Vector3};

// Values that a check refuses, and how a message shows them.
type Bad = &'static [(f64, &'static str)];
const NUMBER: Bad =
    &[(f64::NAN, "nan"), (f64::INFINITY, "inf"), (f64::NEG_INFINITY, "-inf"), (1e300, "1e+300")];
const NON_NEGATIVE: Bad =
    &[(f64::NAN, "nan"), (f64::INFINITY, "inf"), (1e300, "1e+300"), (-1.0, "-1")];
/// Of a size, a mass or a time step: 1e-300 is zero in single precision.
const POSITIVE: Bad = &[
    (f64::NAN, "nan"),
    (f64::INFINITY, "inf"),
    (1e300, "1e+300"),
    (1e-300, "1e-300"),
    (0.0, "0"),
    (-1.0, "-1"),
];
const SHARE: Bad = &[(f64::NAN, "nan"), (f64::INFINITY, "inf"), (-0.5, "-0.5"), (1.5, "1.5")];

// What messages say it must be.
const IN_RANGE: &str = "finite and at most 1e18 in size";
const AT_LEAST_0: &str = "finite, at least 0 and at most 1e18";
const A_PLACE: &str = "finite and within 1e6 m of the origin";
const A_SIZE: &str = "between 1e-6 and 1e6 m";
const FROM_0_TO_1: &str = "between 0 and 1";

/// A world with one body of each motion and a driven hinge.
struct Scene {
    world: World,
    plane: ShapeId,
    ball: ShapeId,
    ground: BodyId,
    bob: BodyId,
    paddle: BodyId,
    hinge: JointId,
}

impl Scene {
    fn new() -> Self {
        Self::with(&WorldSettings::default())
    }

    fn with(settings: &WorldSettings) -> Self {
        let mut world = World::new(settings).unwrap();
        let plane = world.add_shape(&Shape::ground()).unwrap();
        let ball = world.add_shape(&Shape::Sphere { radius: 0.1 }).unwrap();
        let ground = world.add_body(&Body::fixed(plane, Isometry3::identity())).unwrap();
        let at = Isometry3::translation(0.0, 0.0, 0.1);
        let bob = world.add_body(&Body::dynamic(ball, 1.0, at)).unwrap();
        let beside = Isometry3::translation(1.0, 0.0, 0.1);
        let paddle = world.add_body(&Body::kinematic(ball, beside)).unwrap();
        let driven = AxisSettings { motor: Some(MOTOR), ..AxisSettings::free() };
        let ends = ((ground, &Isometry3::identity()), (bob, &at));
        let hinge = Joint::at(&at, JointKind::Hinge(driven), ends.0, ends.1);
        let hinge = world.add_joint(&hinge).unwrap();
        Self { world, plane, ball, ground, bob, paddle, hinge }
    }

    fn body(&self) -> Body {
        Body::dynamic(self.ball, 1.0, Isometry3::identity())
    }

    fn joint(&self, kind: JointKind) -> Joint {
        Joint {
            kind,
            parent: self.ground,
            child: self.bob,
            frame_in_parent: Isometry3::identity(),
            frame_in_child: Isometry3::identity(),
            collide_connected: false,
        }
    }

    fn snapshot(&mut self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.world.snapshot(&mut bytes).unwrap();
        bytes
    }

    fn refuses<T: std::fmt::Debug>(
        &mut self,
        call: impl FnOnce(&mut World) -> Result<T, Error>,
        message: &str,
    ) {
        let before = self.snapshot();
        let error = call(&mut self.world).expect_err(message);
        assert_eq!(error.to_string(), message);
        assert!(self.snapshot() == before, "the world has changed: {message}");
    }

    /// The same for each bad value of one argument.
    fn refuses_each<T: std::fmt::Debug>(
        &mut self,
        argument: &str,
        expected: &str,
        bad: Bad,
        call: impl Fn(&mut World, f64) -> Result<T, Error>,
    ) {
        for &(value, text) in bad {
            let message = format!("{argument} must be {expected}, got {text}");
            self.refuses(|world| call(world, value), &message);
        }
    }

    /// Each component of a vector.
    fn refuses_vector<T: std::fmt::Debug>(
        &mut self,
        argument: &str,
        expected: &str,
        bad: Bad,
        call: impl Fn(&mut World, Vector3<f64>) -> Result<T, Error>,
    ) {
        for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let argument = format!("{argument}.{axis}");
            self.refuses_each(&argument, expected, bad, |world, value| {
                let mut vector = Vector3::repeat(0.5);
                vector[i] = value;
                call(world, vector)
            });
        }
    }

    /// Position and rotation of a pose.
    fn refuses_pose<T: std::fmt::Debug>(
        &mut self,
        argument: &str,
        call: impl Fn(&mut World, Isometry3<f64>) -> Result<T, Error>,
    ) {
        self.refuses_vector(&format!("{argument}.position"), A_PLACE, NUMBER, |world, position| {
            call(world, Isometry3::from_parts(position.into(), UnitQuaternion::identity()))
        });
        for (w, square) in [(0.0, "0"), (2.0, "4"), (f64::NAN, "nan"), (f64::INFINITY, "inf")] {
            let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, 0.0, 0.0, 0.0));
            let pose = Isometry3::from_parts(Vector3::zeros().into(), rotation);
            let message = format!(
                "{argument}.rotation must be a unit quaternion, got one of squared length {square}"
            );
            self.refuses(|world| call(world, pose), &message);
        }
    }

    /// Goes on as if nothing had been asked.
    fn goes_on(mut self) {
        let mut twin = Self::new();
        for _ in 0..10 {
            self.world.step().unwrap();
            twin.world.step().unwrap();
        }
        assert!(self.snapshot() == twin.snapshot(), "a refusal has left something behind");
    }
}

const MOTOR: Motor = Motor { target_velocity: 1.0, max_force: 1.0 };
