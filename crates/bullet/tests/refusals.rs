//! What Bullet couldn't use is refused with the call, the argument, what it should be and what it
//! was, and the world is then as before.
//!
//! "As before" is proved by the snapshot's bytes, and by a twin that never heard the question:
//! both go on with the same bits.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

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

#[test]
fn a_new_world_refuses_bad_settings() {
    let refuses = |settings: WorldSettings, message: String| {
        assert_eq!(World::new(&settings).unwrap_err().to_string(), message);
    };
    let good = WorldSettings::default;
    for (value, text) in NUMBER {
        for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let mut settings = good();
            settings.gravity[i] = *value;
            refuses(settings, format!("World::new: gravity.{axis} must be {IN_RANGE}, got {text}"));
        }
    }
    for iterations in [0, 1_000_001, u32::MAX] {
        refuses(
            WorldSettings { iterations, ..good() },
            format!("World::new: iterations must be between 1 and 1000000, got {iterations}"),
        );
    }
    type Set = fn(&mut WorldSettings) -> &mut f64;
    let table: [(&str, &str, Bad, Set); 5] = [
        ("time_step", "between 1e-6 and 1 s", POSITIVE, |s| &mut s.time_step),
        ("joint_erp", FROM_0_TO_1, SHARE, |s| &mut s.joint_erp),
        ("contact_erp", FROM_0_TO_1, SHARE, |s| &mut s.contact_erp),
        ("cfm", AT_LEAST_0, NON_NEGATIVE, |s| &mut s.cfm),
        ("split_impulse_threshold", IN_RANGE, NUMBER, |s| &mut s.split_impulse_threshold),
    ];
    for (argument, expected, bad, field) in table {
        for (value, text) in bad {
            let mut settings = good();
            *field(&mut settings) = *value;
            let message = format!("World::new: {argument} must be {expected}, got {text}");
            refuses(settings, message);
        }
    }
}

#[test]
fn primitive_shapes_refuse_bad_sizes() {
    let mut scene = Scene::new();
    let along = Lengthwise::Y;
    scene.refuses_vector("add_shape: box.half_extents", A_SIZE, POSITIVE, |world, half_extents| {
        world.add_shape(&Shape::Box { half_extents })
    });
    scene.refuses_vector("add_shape: ellipsoid.radii", A_SIZE, POSITIVE, |world, radii| {
        world.add_shape(&Shape::Ellipsoid { radii })
    });
    type Make = fn(f64) -> Shape;
    let table: [(&str, Make); 5] = [
        ("sphere.radius", |radius| Shape::Sphere { radius }),
        ("capsule.radius", |radius| Shape::Capsule { radius, length: 1.0, along: Lengthwise::X }),
        ("capsule.length", |length| Shape::Capsule { radius: 1.0, length, along: Lengthwise::Z }),
        ("cylinder.radius", |radius| Shape::Cylinder { radius, length: 1.0, along: Lengthwise::X }),
        ("cylinder.length", |length| Shape::Cylinder { radius: 1.0, length, along: Lengthwise::Z }),
    ];
    for (argument, make) in table {
        let argument = format!("add_shape: {argument}");
        scene.refuses_each(&argument, A_SIZE, POSITIVE, |world, x| world.add_shape(&make(x)));
    }
    let both = Shape::Cylinder { radius: 0.0, length: 0.0, along };
    scene.refuses(
        |world| world.add_shape(&both),
        "add_shape: cylinder.radius must be between 1e-6 and 1e6 m, got 0",
    );
    scene.refuses_vector("add_shape: plane.normal", IN_RANGE, NUMBER, |world, normal| {
        world.add_shape(&Shape::Plane { normal: Unit::new_unchecked(normal), offset: 0.0 })
    });
    for (x, square) in [(0.0, "0"), (2.0, "4")] {
        let normal = Unit::new_unchecked(Vector3::new(x, 0.0, 0.0));
        scene.refuses(
            |world| world.add_shape(&Shape::Plane { normal, offset: 0.0 }),
            &format!(
                "add_shape: plane.normal must be a unit vector, got one of squared length {square}"
            ),
        );
    }
    scene.refuses_each("add_shape: plane.offset", A_PLACE, NUMBER, |world, offset| {
        world.add_shape(&Shape::Plane { normal: Vector3::z_axis(), offset })
    });
    scene.goes_on();
}

#[test]
fn hulls_refuse_too_few_too_many_flat_and_bad_points() {
    let mut scene = Scene::new();
    let hull = |points: Vec<Point3<f64>>| Shape::Hull { points, margin: 0.01 };
    let corners = [Point3::origin(), Vector3::x().into(), Vector3::y().into(), Vector3::z().into()];
    for count in [0, 3, 1025, 1_000_000] {
        scene.refuses(
            |world| world.add_shape(&hull(vec![Point3::origin(); count])),
            &format!("add_shape: hull.points must be 4 to 1024 points, got {count}"),
        );
    }
    let in_a_plane = (0..5).map(|i| Point3::new(i as f64, (i * i) as f64, 1.0)).collect();
    let in_a_line = (0..5).map(|i| Point3::new(i as f64, 2.0 * i as f64, 1.0)).collect();
    for flat in [in_a_plane, in_a_line, vec![Point3::new(1.0, 2.0, 3.0); 5]] {
        scene.refuses(
            |world| world.add_shape(&hull(flat)),
            "add_shape: hull.points must be points that span a volume, got 5 points in a plane",
        );
    }
    scene.refuses_vector("add_shape: hull.points[2]", A_PLACE, NUMBER, |world, point| {
        let mut points = corners.to_vec();
        points[2] = point.into();
        world.add_shape(&hull(points))
    });
    scene.refuses_each(
        "add_shape: hull.margin",
        "between 0 and 1e6 m",
        NON_NEGATIVE,
        |world, x| world.add_shape(&Shape::Hull { points: corners.to_vec(), margin: x }),
    );
    scene.goes_on();
}

#[test]
fn compounds_refuse_no_children_too_many_and_children_that_are_not_convex() {
    let mut scene = Scene::new();
    let (ball, plane) = (scene.ball, scene.plane);
    let at = Isometry3::identity();
    for count in [0, 257] {
        scene.refuses(
            |world| world.add_shape(&Shape::Compound { children: vec![(ball, at); count] }),
            &format!("add_shape: compound.children must be 1 to 256 shapes, got {count}"),
        );
    }
    scene.refuses(
        |world| world.add_shape(&Shape::Compound { children: vec![(ball, at), (plane, at)] }),
        "add_shape: compound.children[1] must be a box, sphere, capsule, cylinder, ellipsoid or hull, \
         got STATICPLANE (shape 0)",
    );
    let unknown = ShapeId { slot: 7 };
    scene.refuses(
        |world| world.add_shape(&Shape::Compound { children: vec![(unknown, at)] }),
        "add_shape: compound.children[0] 7 doesn't exist: only 2 were ever added",
    );
    scene.refuses_pose("add_shape: compound.children[0].pose", |world, pose| {
        world.add_shape(&Shape::Compound { children: vec![(ball, pose)] })
    });
    scene.goes_on();
}

#[test]
fn meshes_refuse_bad_counts_indices_corners_and_triangles_without_an_area() {
    let mut scene = Scene::new();
    let corners = vec![Point3::origin(), Vector3::x().into(), Vector3::y().into()];
    let mesh = |triangles: Vec<[u32; 3]>| Shape::Mesh { vertices: corners.clone(), triangles };
    let too_many = 1 << 21;
    for count in [0, too_many] {
        scene.refuses(
            |world| world.add_shape(&mesh(vec![[0, 1, 2]; count])),
            &format!("add_shape: mesh.triangles must be 1 to 2097151 triangles, got {count}"),
        );
    }
    for count in [0, 2] {
        let vertices = vec![Point3::origin(); count];
        scene.refuses(
            |world| world.add_shape(&Shape::Mesh { vertices, triangles: vec![[0, 1, 2]] }),
            &format!("add_shape: mesh.vertices must be 3 to 6291453 points, got {count}"),
        );
    }
    for index in [3, u32::MAX] {
        scene.refuses(
            |world| world.add_shape(&mesh(vec![[0, 1, 2], [0, 1, index]])),
            &format!("add_shape: mesh.triangles[1] must be indices below 3, got {index}"),
        );
    }
    scene.refuses(
        |world| world.add_shape(&mesh(vec![[0, 1, 2], [2, 1, 2]])),
        "add_shape: mesh.triangles[1] must be a triangle with an area, got three corners in a line",
    );
    scene.refuses_vector("add_shape: mesh.vertices[1]", A_PLACE, NUMBER, |world, vertex| {
        let mut vertices = corners.clone();
        vertices[1] = vertex.into();
        world.add_shape(&Shape::Mesh { vertices, triangles: vec![[0, 1, 2]] })
    });
    scene.goes_on();
}

#[test]
fn bodies_refuse_bad_numbers_and_shapes_that_cannot_move() {
    let mut scene = Scene::new();
    let good = scene.body();
    type Set = fn(&mut Body) -> &mut f64;
    let table: [(&str, &str, Bad, Set); 7] = [
        ("mass", "between 1e-12 and 1e12 kg", POSITIVE, |body| &mut body.mass),
        ("friction", AT_LEAST_0, NON_NEGATIVE, |body| &mut body.friction),
        ("rolling_friction", AT_LEAST_0, NON_NEGATIVE, |body| &mut body.rolling_friction),
        ("spinning_friction", AT_LEAST_0, NON_NEGATIVE, |body| &mut body.spinning_friction),
        ("restitution", FROM_0_TO_1, SHARE, |body| &mut body.restitution),
        ("linear_damping", FROM_0_TO_1, SHARE, |body| &mut body.linear_damping),
        ("angular_damping", FROM_0_TO_1, SHARE, |body| &mut body.angular_damping),
    ];
    for (argument, expected, bad, field) in table {
        scene.refuses_each(&format!("add_body: {argument}"), expected, bad, |world, value| {
            let mut body = good.clone();
            *field(&mut body) = value;
            world.add_body(&body)
        });
    }
    let with_inertia = |inertia| Body { inertia: Some(inertia), ..good.clone() };
    scene.refuses_vector("add_body: inertia", IN_RANGE, NUMBER, |world, inertia| {
        world.add_body(&with_inertia(inertia))
    });
    const NO_INVERSE: Bad = &[(0.0, "0"), (-1.0, "-1")];
    let expected = "above 0, with a finite inverse";
    scene.refuses_vector("add_body: inertia", expected, NO_INVERSE, |world, inertia| {
        world.add_body(&with_inertia(inertia))
    });
    scene.refuses_pose("add_body: pose", |world, pose| {
        world.add_body(&Body { pose, ..good.clone() })
    });
    let (plane, unknown) = (scene.plane, ShapeId { slot: 9 });
    scene.refuses(
        |world| world.add_body(&Body::dynamic(plane, 1.0, Isometry3::identity())),
        "add_body: shape must be a solid one for a dynamic body, got STATICPLANE",
    );
    scene.refuses(
        |world| world.add_body(&Body { shape: unknown, ..good.clone() }),
        "add_body: shape 9 doesn't exist: only 2 were ever added",
    );
    scene.goes_on();
}

/// Beyond some size Bullet lets a body's bounding box stay where it was, or puts the body to sleep
/// for good.
#[test]
fn bodies_that_move_refuse_a_shape_that_bullet_would_give_up_on() {
    let mut scene = Scene::new();
    // Its bounding box measures 6e5 m * sqrt(3).
    let huge = scene.world.add_shape(&Shape::Sphere { radius: 3e5 }).unwrap();
    let at = Isometry3::identity();
    for body in [Body::dynamic(huge, 1.0, at), Body::kinematic(huge, at)] {
        let before = scene.snapshot();
        let message = scene.world.add_body(&body).unwrap_err().to_string();
        let says = "add_body: shape must be at most 4e5 m from corner to corner for a body that \
                    moves, got one of 1039230.";
        assert!(message.starts_with(says), "{message}");
        assert!(scene.snapshot() == before, "the world has changed");
    }
    scene.world.add_body(&Body::fixed(huge, at)).unwrap();
}

#[test]
fn a_world_refuses_a_body_too_many() {
    let mut scene = Scene::new();
    let body = Body::fixed(scene.ball, Isometry3::identity());
    for _ in 3..4096 {
        scene.world.add_body(&body).unwrap();
    }
    scene.refuses(
        |world| world.add_body(&body),
        "add_body: body must be one of at most 4096 in a world, got one more",
    );
    scene.world.remove_body(BodyId { slot: 4000 }).unwrap();
    scene.world.add_body(&body).unwrap();
}

#[test]
fn joints_refuse_bad_ends_and_frames() {
    let mut scene = Scene::new();
    let (ground, bob, paddle) = (scene.ground, scene.bob, scene.paddle);
    let good = scene.joint(JointKind::Fixed);
    scene.refuses(
        |world| world.add_joint(&Joint { parent: bob, ..good.clone() }),
        "add_joint: child must be another body than the parent, got body 1",
    );
    scene.refuses(
        |world| world.add_joint(&Joint { parent: ground, child: paddle, ..good.clone() }),
        "add_joint: child must be dynamic, unless its parent is, got two bodies that nothing moves",
    );
    let unknown = BodyId { slot: 9 };
    scene.refuses(
        |world| world.add_joint(&Joint { parent: unknown, ..good.clone() }),
        "add_joint: parent 9 doesn't exist: only 3 were ever added",
    );
    scene.refuses(
        |world| world.add_joint(&Joint { child: unknown, ..good.clone() }),
        "add_joint: child 9 doesn't exist: only 3 were ever added",
    );
    scene.refuses_pose("add_joint: frame_in_parent", |world, frame_in_parent| {
        world.add_joint(&Joint { frame_in_parent, ..good.clone() })
    });
    scene.refuses_pose("add_joint: frame_in_child", |world, frame_in_child| {
        world.add_joint(&Joint { frame_in_child, ..good.clone() })
    });
    scene.goes_on();
}

type WithAxis = Box<dyn Fn(AxisSettings) -> JointKind>;

/// Every axis that a caller can set, by the name that messages give it.
fn open_axes() -> Vec<(&'static str, WithAxis)> {
    let locked = AxisSettings::locked();
    let mut axes: Vec<(_, WithAxis)> = vec![
        ("angular z", Box::new(JointKind::Hinge)),
        (
            "linear x",
            Box::new(move |linear| JointKind::Slider {
                linear,
                angular: locked,
                held: Stop::BULLET,
            }),
        ),
        (
            "angular x",
            Box::new(move |angular| JointKind::Slider {
                linear: locked,
                angular,
                held: Stop::BULLET,
            }),
        ),
    ];
    let names = ["linear x", "linear y", "linear z", "angular x", "angular y", "angular z"];
    for (i, name) in names.into_iter().enumerate() {
        let kind = move |settings| {
            let mut all = Box::new([locked; 6]);
            all[i] = settings;
            JointKind::SixDofSpring(all)
        };
        axes.push((name, Box::new(kind)));
    }
    axes
}

#[test]
fn every_axis_of_a_joint_refuses_bad_limits_stops_motors_and_springs() {
    let mut scene = Scene::new();
    let good = scene.joint(JointKind::Fixed);
    for (axis, kind) in open_axes() {
        let add = |world: &mut World, settings| {
            world.add_joint(&Joint { kind: kind(settings), ..good.clone() })
        };
        let farthest = match axis {
            "angular y" => "within a quarter turn",
            _ if axis.starts_with("angular") => "within half a turn",
            _ => "within 1e6 m",
        };
        let free = AxisSettings::free;
        let stop = Stop::BULLET;
        type Set = fn(AxisSettings, f64) -> AxisSettings;
        let mut table: Vec<(&str, &str, Bad, Set)> = vec![
            ("lower limit", farthest, NUMBER, |_, x| AxisSettings::limited(x, 0.0)),
            ("upper limit", farthest, NUMBER, |_, x| AxisSettings::limited(0.0, x)),
            ("stop erp", FROM_0_TO_1, SHARE, |s, x| AxisSettings {
                stop: Stop { erp: Some(x), ..s.stop },
                ..s
            }),
            ("stop cfm", "between 0 and 1e+18", NON_NEGATIVE, |s, x| AxisSettings {
                stop: Stop { cfm: Some(x), ..s.stop },
                ..s
            }),
            ("stop bounce", FROM_0_TO_1, SHARE, |s, x| AxisSettings {
                stop: Stop { bounce: Some(x), ..s.stop },
                ..s
            }),
            ("motor target velocity", IN_RANGE, NUMBER, |s, x| AxisSettings {
                motor: Some(Motor { target_velocity: x, ..MOTOR }),
                ..s
            }),
            ("motor max force", AT_LEAST_0, NON_NEGATIVE, |s, x| AxisSettings {
                motor: Some(Motor { max_force: x, ..MOTOR }),
                ..s
            }),
        ];
        let springs = matches!(kind(free()), JointKind::SixDofSpring(_));
        if springs {
            const SPRING: Spring = Spring { stiffness: 1.0, damping: 0.1, equilibrium: 0.0 };
            table.extend([
                (
                    "spring stiffness",
                    AT_LEAST_0,
                    NON_NEGATIVE,
                    (|s, x| AxisSettings { spring: Some(Spring { stiffness: x, ..SPRING }), ..s })
                        as Set,
                ),
                ("spring damping", AT_LEAST_0, NON_NEGATIVE, |s, x| AxisSettings {
                    spring: Some(Spring { damping: x, ..SPRING }),
                    ..s
                }),
                ("spring equilibrium", farthest, NUMBER, |s, x| AxisSettings {
                    spring: Some(Spring { equilibrium: x, ..SPRING }),
                    ..s
                }),
            ]);
        } else {
            let spring = Some(Spring { stiffness: 1.0, damping: 0.0, equilibrium: 0.0 });
            scene.refuses(
                |world| add(world, AxisSettings { spring, ..free() }),
                &format!(
                    "add_joint: {axis} spring must be absent: only a 6-dof spring joint has \
                     springs, got one"
                ),
            );
        }
        if axis == "linear x" && !springs {
            let stop = Stop { bounce: Some(0.5), ..Stop::BULLET };
            scene.refuses(
                |world| add(world, AxisSettings { stop, ..free() }),
                "add_joint: linear x stop bounce must be 0: Bullet's slider tests the wrong sign, \
                 and never bounces, got 0.5",
            );
        }
        for (argument, expected, bad, set) in table {
            let argument = format!("add_joint: {axis} {argument}");
            scene.refuses_each(&argument, expected, bad, |world, value| {
                add(world, set(AxisSettings { stop, ..free() }, value))
            });
        }
        let range = Range::Limited { lower: 0.5, upper: -0.5 };
        scene.refuses(
            |world| add(world, AxisSettings { range, ..free() }),
            &format!("add_joint: {axis} lower limit must be at most the upper one, -0.5, got 0.5"),
        );
        if let Some(past) = match farthest {
            "within a quarter turn" => Some(1.6),
            "within half a turn" => Some(3.2),
            _ => None,
        } {
            scene.refuses(
                |world| add(world, AxisSettings::limited(0.0, past)),
                &format!("add_joint: {axis} upper limit must be {farthest}, got {past}"),
            );
        }
    }
    scene.goes_on();
}

#[test]
fn moving_and_pushing_refuse_bad_vectors_and_bodies_that_nothing_pushes() {
    let mut scene = Scene::new();
    let (ground, bob, paddle) = (scene.ground, scene.bob, scene.paddle);
    let some = Vector3::repeat(0.5);
    scene.refuses_pose("set_pose: pose", |world, pose| world.set_pose(bob, &pose));
    scene.refuses(
        |world| world.set_pose(ground, &Isometry3::identity()),
        "set_pose: id must be a dynamic or kinematic body, got body 0, which is static",
    );
    scene.refuses_vector("set_velocity: linear", IN_RANGE, NUMBER, |world, linear| {
        world.set_velocity(bob, &linear, &some)
    });
    scene.refuses_vector("set_velocity: angular", IN_RANGE, NUMBER, |world, angular| {
        world.set_velocity(bob, &some, &angular)
    });
    for still in [ground, paddle] {
        let got = format!(
            "id must be a dynamic body, got body {}, which is static or kinematic",
            still.slot
        );
        scene.refuses(
            |world| world.set_velocity(still, &some, &some),
            &format!("set_velocity: {got}"),
        );
        scene.refuses(|world| world.push(still, Push::Force, &some, None), &format!("push: {got}"));
    }
    for kind in [Push::Force, Push::Torque, Push::Impulse, Push::AngularImpulse] {
        scene.refuses_vector("push: vector", IN_RANGE, NUMBER, |world, vector| {
            world.push(bob, kind, &vector, None)
        });
    }
    for kind in [Push::Force, Push::Impulse] {
        scene.refuses_vector("push: point", A_PLACE, NUMBER, |world, point| {
            world.push(bob, kind, &some, Some(&point.into()))
        });
    }
    for kind in [Push::Torque, Push::AngularImpulse] {
        scene.refuses(
            |world| world.push(bob, kind, &some, Some(&Point3::origin())),
            "push: point must be absent for a torque or an angular impulse, got one",
        );
    }
    scene.refuses(
        |world| world.set_velocity(bob, &Vector3::new(0.0, 1e8, 0.0), &some),
        "set_velocity: linear must be at most 5e5 m in a step, got (0, 1e+08, 0) m/s",
    );
    scene.goes_on();
}

/// Each vector is fine by itself. A ball of 1 kg with a radius of 0.1 m has 0.004 kg m².
#[test]
fn pushes_refuse_what_a_light_body_or_a_long_arm_would_make_infinite() {
    let mut scene = Scene::new();
    let bob = scene.bob;
    let (huge, far) = (Vector3::new(0.0, 1e18, 0.0), Point3::new(1e6, 0.0, 0.0));
    let velocities = "the body below 5e5 m in a step and 1e18 rad/s";
    let loads = "the body's total force and torque within 1e18";
    for (kind, point, kept) in [
        (Push::Impulse, Some(&far), velocities),
        (Push::AngularImpulse, None, velocities),
        (Push::Force, Some(&far), loads),
    ] {
        scene.refuses(
            |world| world.push(bob, kind, &huge, point),
            &format!("push: vector must be small enough to keep {kept}, got (0, 1e+18, 0)"),
        );
    }
    scene.goes_on();
}

#[test]
fn motors_refuse_a_list_of_commands_if_one_is_bad() {
    let mut scene = Scene::new();
    let good = MotorCommand {
        joint: scene.hinge,
        axis: Axis::AngularZ,
        target_velocity: 5.0,
        max_force: 5.0,
    };
    scene.refuses(
        |world| world.set_motors(&[good, MotorCommand { joint: JointId { slot: 9 }, ..good }]),
        "set_motors: commands[1].joint 9 doesn't exist: only 1 were ever added",
    );
    scene.refuses(
        |world| world.set_motors(&[good, MotorCommand { axis: Axis::LinearY, ..good }]),
        "set_motors: commands[1].axis must be one that was built with a motor, got linear y",
    );
    scene.refuses_each(
        "set_motors: commands[1].target_velocity",
        IN_RANGE,
        NUMBER,
        |world, target_velocity| {
            world.set_motors(&[good, MotorCommand { target_velocity, ..good }])
        },
    );
    scene.refuses_each(
        "set_motors: commands[1].max_force",
        AT_LEAST_0,
        NON_NEGATIVE,
        |world, max_force| world.set_motors(&[good, MotorCommand { max_force, ..good }]),
    );
    scene.goes_on();
}

#[test]
fn what_is_used_refuses_removal_and_what_was_removed_is_unknown() {
    let mut scene = Scene::new();
    let (ball, bob, hinge, paddle) = (scene.ball, scene.bob, scene.hinge, scene.paddle);
    let compound = Shape::Compound { children: vec![(ball, Isometry3::identity())] };
    let compound = scene.world.add_shape(&compound).unwrap();
    scene.refuses(
        |world| world.remove_body(bob),
        "remove_body: id must be a body without joints, got body 1, which has 1",
    );
    scene.refuses(
        |world| world.remove_shape(ball),
        "remove_shape: id must be a shape that nothing uses, got shape 1, used by 3 bodies or \
         compounds",
    );
    scene.world.remove_joint(hinge).unwrap();
    scene.world.remove_body(bob).unwrap();
    scene.world.remove_body(paddle).unwrap();
    scene.refuses(
        |world| world.remove_shape(ball),
        "remove_shape: id must be a shape that nothing uses, got shape 1, used by 1 bodies or \
         compounds",
    );
    scene.world.remove_shape(compound).unwrap();
    scene.world.remove_shape(ball).unwrap();

    let gone =
        |call: &str, argument: &str| format!("{call}: {argument} doesn't exist: it was removed");
    let some = Vector3::repeat(0.5);
    let command =
        MotorCommand { joint: hinge, axis: Axis::AngularZ, target_velocity: 0.0, max_force: 0.0 };
    let children = vec![(ball, Isometry3::identity())];
    let fixed = scene.joint(JointKind::Fixed);
    type Ask = Box<dyn FnOnce(&mut World) -> Result<(), Error>>;
    let table: [(&str, &str, Ask); 13] = [
        ("remove_shape", "id 1", Box::new(move |world| world.remove_shape(ball))),
        ("remove_body", "id 1", Box::new(move |world| world.remove_body(bob))),
        ("remove_joint", "id 0", Box::new(move |world| world.remove_joint(hinge))),
        ("set_pose", "id 1", Box::new(move |world| world.set_pose(bob, &Isometry3::identity()))),
        ("set_velocity", "id 1", Box::new(move |world| world.set_velocity(bob, &some, &some))),
        ("push", "id 1", Box::new(move |world| world.push(bob, Push::Force, &some, None))),
        ("mass_properties", "id 1", Box::new(move |world| world.mass_properties(bob).map(drop))),
        ("set_motors", "commands[0].joint 0", Box::new(move |world| world.set_motors(&[command]))),
        ("add_body", "shape 1", {
            Box::new(move |world| {
                world.add_body(&Body::dynamic(ball, 1.0, Isometry3::identity())).map(drop)
            })
        }),
        ("add_shape", "compound.children[0] 1", {
            Box::new(move |world| world.add_shape(&Shape::Compound { children }).map(drop))
        }),
        ("add_joint", "child 1", {
            let joint = fixed.clone();
            Box::new(move |world| world.add_joint(&joint).map(drop))
        }),
        ("add_joint", "parent 1", {
            let joint = Joint { parent: bob, child: fixed.parent, ..fixed };
            Box::new(move |world| world.add_joint(&joint).map(drop))
        }),
        ("add_joint", "child 2", {
            let joint = Joint { child: paddle, ..scene.joint(JointKind::PointToPoint) };
            Box::new(move |world| world.add_joint(&joint).map(drop))
        }),
    ];
    for (call, argument, ask) in table {
        scene.refuses(ask, &gone(call, argument));
    }
}

#[test]
fn bodies_are_kept_apart_once_and_from_others() {
    let mut scene = Scene::new();
    let (bob, paddle) = (scene.bob, scene.paddle);
    scene.refuses(
        |world| world.keep_apart(bob, bob),
        "keep_apart: b must be another body than a, got body 1",
    );
    scene.world.keep_apart(bob, paddle).unwrap();
    for (a, b) in [(bob, paddle), (paddle, bob)] {
        let expected = format!(
            "keep_apart: b must be a body that isn't kept apart from a already, got body {}",
            b.slot
        );
        scene.refuses(|world| world.keep_apart(a, b), &expected);
    }
    let never = BodyId { slot: 3 };
    scene.refuses(
        |world| world.keep_apart(bob, never),
        "keep_apart: b 3 doesn't exist: only 3 were ever added",
    );
}

#[test]
fn ids_that_never_were_are_refused_by_every_call_that_takes_one() {
    let mut scene = Scene::new();
    let (shape, body, joint) =
        (ShapeId { slot: 2 }, BodyId { slot: 3 }, JointId { slot: u32::MAX });
    let some = Vector3::repeat(0.5);
    let never = |call: &str, id: &str, count: u32| {
        format!("{call}: id {id} doesn't exist: only {count} were ever added")
    };
    scene.refuses(|world| world.remove_shape(shape), &never("remove_shape", "2", 2));
    scene.refuses(|world| world.remove_body(body), &never("remove_body", "3", 3));
    scene.refuses(|world| world.remove_joint(joint), &never("remove_joint", "4294967295", 1));
    scene.refuses(|world| world.mass_properties(body), &never("mass_properties", "3", 3));
    scene.refuses(|world| world.set_pose(body, &Isometry3::identity()), &never("set_pose", "3", 3));
    scene.refuses(|world| world.set_velocity(body, &some, &some), &never("set_velocity", "3", 3));
    scene.refuses(|world| world.push(body, Push::Torque, &some, None), &never("push", "3", 3));
    scene.goes_on();
}

#[test]
fn slots_are_not_used_again_and_buffers_mark_what_was_removed() {
    let mut scene = Scene::new();
    scene.world.remove_joint(scene.hinge).unwrap();
    scene.world.remove_body(scene.bob).unwrap();
    let again = scene.world.add_body(&scene.body()).unwrap();
    assert_eq!(again, BodyId { slot: 3 });
    let joint = Joint { child: again, ..scene.joint(JointKind::PointToPoint) };
    assert_eq!(scene.world.add_joint(&joint).unwrap(), JointId { slot: 1 });
    scene.world.step().unwrap();

    let (mut bodies, mut joints) = (Vec::new(), Vec::new());
    scene.world.read_bodies(&mut bodies).unwrap();
    scene.world.read_joints(&mut joints).unwrap();
    let exist: Vec<_> = bodies.iter().map(|body| body.exists).collect();
    assert_eq!(exist, [true, false, true, true]);
    assert_eq!(bodies[1], Default::default(), "all else is 0");
    let exist: Vec<_> = joints.iter().map(|joint| joint.exists).collect();
    assert_eq!(exist, [false, true]);
    assert_eq!(joints[0], Default::default(), "all else is 0");

    let mut angles = Vec::new();
    scene.world.read_angles_of(&[JointId { slot: 1 }; 2], &mut angles).unwrap();
    assert_eq!(angles, [&joints[1].position[3..]; 2].concat());
    for slot in [0, 2] {
        let ids = [JointId { slot: 1 }, JointId { slot }];
        let error = scene.world.read_angles_of(&ids, &mut angles).unwrap_err();
        assert!(error.to_string().starts_with(&format!("read_angles_of: ids[1] {slot} doesn't")));
    }

    let mut motors = Vec::new();
    let there = [JointId { slot: 1 }; 2];
    let error = scene.world.read_motors_of(&there, &mut motors).unwrap_err();
    let unmeasured = "read_motors_of: the world must be one that measures its motors, got one that \
                      doesn't";
    assert_eq!(error.to_string(), unmeasured);
    scene.world.measure_motors(true);
    scene.world.read_motors_of(&there, &mut motors).unwrap();
    assert_eq!(motors, [Default::default(); 2], "nothing was done yet");
    for slot in [0, 2] {
        let ids = [JointId { slot: 1 }, JointId { slot }];
        let error = scene.world.read_motors_of(&ids, &mut motors).unwrap_err();
        assert!(error.to_string().starts_with(&format!("read_motors_of: ids[1] {slot} doesn't")));
    }

    let shape = scene.world.add_shape(&Shape::Sphere { radius: 1.0 }).unwrap();
    scene.world.remove_shape(shape).unwrap();
    let next = scene.world.add_shape(&Shape::Sphere { radius: 1.0 }).unwrap();
    assert_eq!(next.slot, shape.slot + 1);
}

#[test]
fn restoring_refuses_bytes_that_are_not_this_worlds_snapshot() {
    let mut scene = Scene::new();
    let whole = scene.snapshot();
    let with = |at: usize| {
        let mut bytes = whole.clone();
        bytes[at] ^= 1;
        bytes
    };
    let state = whole.len() - 44;
    let mut elsewhere = Vec::new();
    World::new(&WorldSettings::default()).unwrap().snapshot(&mut elsewhere).unwrap();
    for (bytes, message) in [
        (vec![], "these bytes are not the snapshot of a world".into()),
        (vec![7; 100], "these bytes are not the snapshot of a world".into()),
        (with(0), "these bytes are not the snapshot of a world".into()),
        (whole[..12].to_vec(), "damaged: only 12 bytes".into()),
        (
            whole[..whole.len() - 1].to_vec(),
            format!("damaged: {} bytes of state where {state} were written", state - 1),
        ),
        (with(50), "damaged: its checksum is wrong".into()),
        (
            elsewhere,
            "of another world: its settings, shapes, bodies or joints were added differently"
                .into(),
        ),
    ] {
        scene.refuses(|world| world.restore(&bytes), &format!("snapshot: {message}"));
    }
    scene.goes_on();
}

/// Ways that every argument allows: a force and a torque on a body of 1e-12 kg, and a journey of
/// 4e5 m a step to beyond 1e9 m.
#[test]
fn a_world_that_blows_up_names_body_and_step_and_a_snapshot_heals_it() {
    type Blow = fn(&mut World, BodyId) -> Result<(), Error>;
    let default = WorldSettings::default;
    let table: [(WorldSettings, Blow, &str, u64); 3] = [
        (
            default(),
            |world, id| world.push(id, Push::Force, &Vector3::new(0.0, 1e18, 0.0), None),
            "linear velocity",
            1,
        ),
        (
            default(),
            |world, id| world.push(id, Push::Torque, &Vector3::new(0.0, 1e18, 0.0), None),
            "angular velocity",
            1,
        ),
        (
            WorldSettings { time_step: 1.0, gravity: Vector3::zeros(), ..default() },
            |world, id| world.set_velocity(id, &Vector3::new(0.0, 4e5, 0.0), &Vector3::zeros()),
            "position",
            2501,
        ),
    ];
    for (settings, blow, expected, steps) in table {
        let five_steps_in = || {
            let mut scene = Scene::with(&settings);
            let light = Body::dynamic(scene.ball, 1e-12, Isometry3::translation(5.0, 0.0, 5.0));
            let light = scene.world.add_body(&light).unwrap();
            (0..5).for_each(|_| scene.world.step().unwrap());
            (scene, light)
        };
        let (mut scene, light) = five_steps_in();
        let before = scene.snapshot();
        blow(&mut scene.world, light).unwrap();
        (1..steps).for_each(|_| scene.world.step().unwrap());
        let error = scene.world.step().expect_err(expected);
        let made = 5 + steps;
        match &error {
            Error::BlewUp { body, step, quantity, .. } => {
                assert_eq!((*body, *step, quantity.as_str()), (light, made, expected));
            }
            other => panic!("{other}"),
        }
        let says = format!("step {made}: the {expected} of body 3 blew up: (");
        assert!(error.to_string().starts_with(&says), "{error}");

        assert_eq!(scene.world.step().unwrap_err(), error, "later steps refuse likewise");
        assert_eq!(scene.world.steps(), made, "and aren't made");
        assert_eq!(scene.world.snapshot(&mut Vec::new()).unwrap_err(), error);
        let mut bodies = Vec::new();
        scene.world.read_bodies(&mut bodies).unwrap();
        assert!(bodies[light.index()].exists);
        scene.world.read_joints(&mut Vec::new()).unwrap();
        scene.world.read_contacts(&mut Vec::new()).unwrap();

        scene.world.restore(&before).unwrap();
        let (mut twin, _) = five_steps_in();
        for _ in 0..10 {
            scene.world.step().unwrap();
            twin.world.step().unwrap();
        }
        assert!(scene.snapshot() == twin.snapshot(), "it goes on as if it hadn't blown up");
    }
}
