//! What is done with a world that stands: moving, pushing, driving, removing, restoring.

use super::*;

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
