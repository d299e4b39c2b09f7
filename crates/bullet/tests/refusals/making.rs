//! What worlds, shapes, bodies and joints are made of.

use super::*;

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
