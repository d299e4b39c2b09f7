//! Worlds stepped in lanes have the bits of worlds stepped alone, whatever is in them; and what
//! lanes don't cover is left to Bullet's own loop. (Robots are in `crates/svenja/tests/lockstep.rs`.)
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod common;

use std::f64::consts::PI;

use bullet::{
    Axis, AxisSettings, Body, BodyId, CollisionFilter, Error, Instructions, Joint, JointId,
    JointKind, Lengthwise, Lockstep, LockstepCounts, Motor, MotorCommand, Push, Shape, SolverMode,
    Spring, Stop, World, WorldSettings,
};
use common::{Playground, Readings};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use proptest::{collection::vec, option, prelude::*, sample::select};

fn available() -> impl Iterator<Item = Instructions> {
    Instructions::ALL.into_iter().filter(|it| it.are_available())
}

/// Steps all worlds together; panics if one of them refuses.
fn step(lockstep: &mut Lockstep, worlds: &mut [World]) {
    let mut together: Vec<&mut World> = worlds.iter_mut().collect();
    let mut results = Vec::new();
    lockstep.step(&mut together, &mut results).unwrap();
    results.into_iter().for_each(Result::unwrap);
}

fn snapshot(world: &mut World) -> Vec<u8> {
    let mut bytes = Vec::new();
    world.snapshot(&mut bytes).unwrap();
    bytes
}

/// `make(i)` builds the `i`th world, `act(i, step, world)` is done before each of its steps.
fn compare(
    what: &str,
    (worlds, steps): (usize, usize),
    make: impl Fn(usize) -> World,
    act: impl Fn(usize, usize, &mut World),
) -> LockstepCounts {
    // Worlds that measure their motors have Bullet's rows; the others' are made in lanes.
    compare_measured(true, what, (worlds, steps.min(30)), &make, &act);
    compare_measured(false, what, (worlds, steps), &make, &act)
}

fn compare_measured(
    measured: bool,
    what: &str,
    (worlds, steps): (usize, usize),
    make: &impl Fn(usize) -> World,
    act: &impl Fn(usize, usize, &mut World),
) -> LockstepCounts {
    let make = |i| {
        let mut world = make(i);
        world.measure_motors(measured);
        world
    };
    let mut counts = LockstepCounts::default();
    for instructions in available() {
        let mut alone: Vec<World> = (0..worlds).map(&make).collect();
        let mut together: Vec<World> = (0..worlds).map(&make).collect();
        let mut lockstep = Lockstep::with(instructions).unwrap();
        for n in 0..steps {
            for i in 0..worlds {
                act(i, n, &mut alone[i]);
                alone[i].step().unwrap();
                act(i, n, &mut together[i]);
            }
            step(&mut lockstep, &mut together);
            for i in 0..worlds {
                assert!(
                    Readings::of(&alone[i]).bits() == Readings::of(&together[i]).bits(),
                    "{what}, {instructions:?}: other bits in world {i} after step {n}"
                );
                // What can't be read, but matters to what follows.
                if (n + i) % 10 == 9 || n + 1 == steps {
                    assert!(
                        snapshot(&mut alone[i]) == snapshot(&mut together[i]),
                        "{what}, {instructions:?}: another snapshot of world {i} after step {n}"
                    );
                }
            }
        }
        counts = lockstep.counts();
    }
    counts
}

/// All joints and shapes; moving bodies touch each other, and some roll with friction.
#[test]
fn everything_at_once() {
    for mode in [
        SolverMode::default(),
        SolverMode::default() - SolverMode::WARM_STARTING,
        SolverMode::default() | SolverMode::TWO_FRICTION_DIRECTIONS,
        SolverMode::default() | SolverMode::INTERLEAVED_FRICTION,
        SolverMode::default()
            | SolverMode::TWO_FRICTION_DIRECTIONS
            | SolverMode::INTERLEAVED_FRICTION
            | SolverMode::CACHED_FRICTION_DIRECTIONS,
        SolverMode::default() | SolverMode::RANDOM_ORDER,
    ] {
        let settings = WorldSettings { iterations: 10, solver_mode: mode, ..Default::default() };
        let mut alone = Playground::new(&settings);
        let mut together = Playground::new(&settings);
        let mut lockstep = Lockstep::new().unwrap();
        for n in 0..250 {
            alone.step();
            together.prepare();
            let mut results = Vec::new();
            lockstep.step(&mut [&mut together.world], &mut results).unwrap();
            results.remove(0).unwrap();
            let (a, b) = (Readings::of(&alone.world).bits(), Readings::of(&together.world).bits());
            assert!(a == b, "{mode:?}: other bits after step {n}");
        }
        let counts = lockstep.counts();
        assert!(counts.swept + counts.unsupported == 250, "{counts:?}");
    }
}

fn ball(world: &mut World, radius: f64, mass: f64, z: f64) -> BodyId {
    let shape = world.add_shape(&Shape::Sphere { radius }).unwrap();
    world.add_body(&Body::dynamic(shape, mass, Isometry3::translation(0.0, 0.0, z))).unwrap()
}

fn ground(world: &mut World) -> BodyId {
    let shape = world.add_shape(&Shape::ground()).unwrap();
    world.add_body(&Body { friction: 1.0, ..Body::fixed(shape, Isometry3::identity()) }).unwrap()
}

#[test]
fn free_fall_has_no_rows() {
    let make = |i| {
        let mut world = World::new(&WorldSettings::default()).unwrap();
        ball(&mut world, 0.1, 1.0, i as f64);
        world
    };
    let counts = compare("free fall", (5, 50), make, |_, _, _| ());
    // The solver has a body and no row; what there is to sweep is nothing.
    assert_eq!(counts.swept + counts.idle, 5 * 50, "{counts:?}");
}

#[test]
fn rest_ends_the_sweep_early() {
    let make = |i: usize| {
        let mut world = World::new(&WorldSettings::default()).unwrap();
        ground(&mut world);
        let shape =
            world.add_shape(&Shape::Box { half_extents: Vector3::new(0.1, 0.2, 0.1) }).unwrap();
        let z = 0.1 + 0.05 * i as f64;
        let pose = Isometry3::translation(0.0, 0.0, z);
        world.add_body(&Body { friction: 0.5, ..Body::dynamic(shape, 1.0, pose) }).unwrap();
        world
    };
    let counts = compare("rest", (6, 400), make, |_, _, _| ());
    assert!(counts.swept > 6 * 300, "{counts:?}");
}

/// Impulses that are far below what their squares can tell from zero: Bullet stops at once, though
/// they aren't zero.
#[test]
fn tiny_changes_are_left_to_bullet() {
    let make = |i: usize| {
        let mut world = World::new(&WorldSettings {
            gravity: Vector3::zeros(),
            iterations: 30,
            ..Default::default()
        })
        .unwrap();
        let a = ball(&mut world, 0.1, 1.0, 0.0);
        let b = ball(&mut world, 0.1, 1.0, 1.0);
        let pose = Isometry3::translation(0.0, 0.0, 0.5);
        let (at_a, at_b) = (Isometry3::identity(), Isometry3::translation(0.0, 0.0, 1.0));
        let joint = Joint::at(&pose, JointKind::PointToPoint, (a, &at_a), (b, &at_b));
        world.add_joint(&joint).unwrap();
        let tiny = if bullet::SCALAR_BYTES == 4 { 1e-30 } else { 1e-200 };
        let speed = Vector3::new(tiny * (1 + i) as f64, 0.0, tiny);
        world.set_velocity(b, &speed, &Vector3::zeros()).unwrap();
        world
    };
    let counts = compare("tiny", (4, 5), make, |_, _, _| ());
    assert!(counts.maybe_converged > 0, "{counts:?}");
}

/// More joints than Bullet solves in one go.
#[test]
fn many_robots_in_a_world() {
    let make = |i: usize| {
        let mut world =
            World::new(&WorldSettings { iterations: 20, ..Default::default() }).unwrap();
        ground(&mut world);
        let link = world
            .add_shape(&Shape::Capsule { radius: 0.05, length: 0.3, along: Lengthwise::Z })
            .unwrap();
        for chain in 0..10 {
            let at = |n: usize| Isometry3::translation(chain as f64, 0.0, 0.4 * n as f64 + 0.5);
            let add = |world: &mut World, n| world.add_body(&Body::dynamic(link, 1.0, at(n)));
            let mut last = add(&mut world, 0).unwrap();
            for n in 1..20 {
                let next = add(&mut world, n).unwrap();
                let frame = at(n) * Isometry3::translation(0.0, 0.0, -0.2);
                let ends = ((last, &at(n - 1)), (next, &at(n)));
                let hinge = JointKind::Hinge(AxisSettings::limited(-0.3, 0.3));
                world.add_joint(&Joint::at(&frame, hinge, ends.0, ends.1)).unwrap();
                last = next;
            }
            let aside = Vector3::new(0.1 * chain as f64, 0.2 * (1 + i) as f64, 0.0);
            world.set_velocity(last, &aside, &Vector3::zeros()).unwrap();
        }
        world
    };
    let counts = compare("chains", (3, 40), make, |_, _, _| ());
    assert!(counts.separate_groups > 0 && counts.swept > 0, "{counts:?}");
}

/// A joint without a row brings a kinematic body into the solver, which makes its zeros positive.
#[test]
fn joints_without_rows_count() {
    let settings = WorldSettings { gravity: Vector3::zeros(), ..Default::default() };
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let bases = [0.0, PI, -PI, PI / 2.0];
    for (axis, base) in axes.into_iter().flat_map(|axis| bases.map(|base| (axis, base))) {
        for rate in [-0.05, -0.02, 0.02, 0.05] {
            let turned = move |n: usize| {
                let base = UnitQuaternion::from_euler_angles(base, 0.0, 0.0);
                let turn = UnitQuaternion::from_scaled_axis(axis * (rate * n as f64));
                Isometry3::from_parts(Translation3::identity(), turn * base)
            };
            let make = |i: usize| {
                let mut world = World::new(&settings).unwrap();
                let shape = world.add_shape(&Shape::Sphere { radius: 0.1 }).unwrap();
                let table = world.add_body(&Body::kinematic(shape, turned(0))).unwrap();
                let body = ball(&mut world, 0.1, 1.0 + i as f64, 1.0);
                let above = Isometry3::translation(0.0, 0.0, 1.0);
                let kind = JointKind::SixDofSpring(Box::new([AxisSettings::free(); 6]));
                world
                    .add_joint(&Joint::at(&above, kind, (table, &turned(0)), (body, &above)))
                    .unwrap();
                world
            };
            compare("turntable", (2, 60), make, |_, n, world| {
                world.set_pose(BodyId { slot: 0 }, &turned(n + 1)).unwrap();
            });
        }
    }
}

#[test]
fn a_world_that_blows_up_disturbs_no_other() {
    let make = |i: usize| {
        let mut world = World::new(&WorldSettings::default()).unwrap();
        ground(&mut world);
        let a = ball(&mut world, 0.1, 1.0, 0.3 + 0.01 * i as f64);
        let b = ball(&mut world, 0.1, 1.0, 0.6);
        let pose = Isometry3::translation(0.0, 0.0, 0.45);
        let (at_a, at_b) =
            (Isometry3::translation(0.0, 0.0, 0.3), Isometry3::translation(0.0, 0.0, 0.6));
        world.add_joint(&Joint::at(&pose, JointKind::Fixed, (a, &at_a), (b, &at_b))).unwrap();
        world
    };
    let blow_up = |world: &mut World| {
        let torn = Vector3::new(1e17, 1e17, 0.0);
        for _ in 0..5 {
            let body = BodyId { slot: 1 };
            world.push(body, Push::Torque, &torn, None).unwrap();
        }
    };
    for instructions in available() {
        let mut alone: Vec<World> = (0..4).map(make).collect();
        let mut together: Vec<World> = (0..4).map(make).collect();
        let mut lockstep = Lockstep::with(instructions).unwrap();
        let mut results = Vec::new();
        let mut torn = None;
        for n in 0..100 {
            if n == 30 {
                blow_up(&mut alone[2]);
                blow_up(&mut together[2]);
            }
            let expected: Vec<_> = alone.iter_mut().map(World::step).collect();
            let mut group: Vec<&mut World> = together.iter_mut().collect();
            lockstep.step(&mut group, &mut results).unwrap();
            // NaN is spelled in words, so that errors can be compared.
            assert_eq!(format!("{results:?}"), format!("{expected:?}"), "step {n}");
            torn = torn.or_else(|| results[2].clone().err());
            for i in [0, 1, 3] {
                results[i].clone().unwrap();
                assert!(Readings::of(&alone[i]).bits() == Readings::of(&together[i]).bits());
            }
        }
        assert!(matches!(torn, Some(Error::BlewUp { .. })), "{torn:?}");
    }
}

#[test]
fn worlds_leave_and_join() {
    let make = |i: usize| {
        let mut world = World::new(&WorldSettings::default()).unwrap();
        ground(&mut world);
        ball(&mut world, 0.1, 1.0, 0.2 + 0.1 * i as f64);
        world
    };
    let mut alone: Vec<World> = (0..7).map(make).collect();
    let mut together: Vec<World> = (0..7).map(make).collect();
    let mut lockstep = Lockstep::new().unwrap();
    for n in 0..140_usize {
        let here = |i: usize| !(n / 10 + i).is_multiple_of(3);
        let mut group: Vec<&mut World> =
            together.iter_mut().enumerate().filter(|(i, _)| here(*i)).map(|(_, w)| w).collect();
        lockstep.step(&mut group, &mut Vec::new()).unwrap();
        for (i, world) in alone.iter_mut().enumerate() {
            if here(i) {
                world.step().unwrap();
            }
            assert!(Readings::of(world).bits() == Readings::of(&together[i]).bits(), "{i}, {n}");
        }
        if n == 77 {
            // A restored world goes on like any other.
            let mut bytes = Vec::new();
            together[3].snapshot(&mut bytes).unwrap();
            let mut fresh = make(3);
            fresh.restore(&bytes).unwrap();
            together[3] = fresh;
        }
    }
    assert!(lockstep.step(&mut [], &mut Vec::new()).is_ok());
}

/// What may only meet planes needs no box; a body that it may meet can come at any time, and go.
#[test]
fn bodies_come_and_go() {
    let make = |i: usize| {
        let mut world = World::new(&WorldSettings::default()).unwrap();
        ground(&mut world);
        let slope = world.add_shape(&Shape::ground()).unwrap();
        let tilt = UnitQuaternion::from_euler_angles(0.0, -0.4, 0.0);
        let pose = Isometry3::from_parts(Translation3::new(3.0, 0.0, 0.0), tilt);
        world.add_body(&Body::fixed(slope, pose)).unwrap();
        let shapes = [
            Shape::Capsule { radius: 0.1, length: 0.6, along: Lengthwise::X },
            Shape::Box { half_extents: Vector3::new(0.1, 0.2, 0.3) },
        ];
        for (k, shape) in shapes.iter().enumerate() {
            let shape = world.add_shape(shape).unwrap();
            let turn = UnitQuaternion::from_euler_angles(0.3 * i as f64, 0.4, 1.0);
            let at = Translation3::new(2.0 * k as f64, 0.0, 1.5 + 0.1 * i as f64);
            let filter = CollisionFilter { group: 2, mask: !2 };
            let body = Body::dynamic(shape, 1.0, Isometry3::from_parts(at, turn));
            let id = world.add_body(&Body { filter, ..body }).unwrap();
            world.set_velocity(id, &Vector3::x(), &Vector3::new(1.0, 2.0, 3.0)).unwrap();
        }
        world
    };
    compare("come and go", (3, 240), make, |_, n, world| match n {
        40 => {
            ball(world, 0.3, 2.0, 0.4);
        }
        90 => {
            let mut contacts = Vec::new();
            world.read_contacts(&mut contacts).unwrap();
            let lies = contacts.iter().any(|it| it.a.slot.max(it.b.slot) == 4);
            assert!(lies, "the ball is on the ground: {contacts:?}");
            world.remove_body(BodyId { slot: 4 }).unwrap();
        }
        _ => (),
    });
}

/// Shapes of our own, and bodies that are kept apart from some that they meet.
#[test]
fn ellipsoids_and_what_is_kept_apart() {
    let make = |i: usize| {
        let mut world = World::new(&WorldSettings::default()).unwrap();
        ground(&mut world);
        let radii = Vector3::new(0.3, 0.1, 0.2);
        let shape = world.add_shape(&Shape::Ellipsoid { radii }).unwrap();
        let bodies = [0.4, 0.7, 1.0].map(|z| {
            let turn = UnitQuaternion::from_euler_angles(0.3 * i as f64, 0.4, z);
            let pose = Isometry3::from_parts(Translation3::new(0.02 * z, 0.0, z), turn);
            world.add_body(&Body::dynamic(shape, 1.0, pose)).unwrap()
        });
        world.keep_apart(bodies[0], bodies[2]).unwrap();
        world
    };
    let counts = compare("ellipsoids", (3, 150), make, |_, n, world| {
        if n == 60 {
            world.keep_apart(BodyId { slot: 1 }, BodyId { slot: 2 }).unwrap();
        }
    });
    assert!(counts.swept > 0, "{counts:?}");
}

/// Two balls that something joins.
fn pair(kind: JointKind) -> World {
    let mut world = World::new(&WorldSettings::default()).unwrap();
    ground(&mut world);
    let (a, b) = (ball(&mut world, 0.1, 1.0, 0.5), ball(&mut world, 0.1, 2.0, 1.0));
    join(&mut world, kind, (a, b), 0.2);
    world.set_velocity(a, &Vector3::x(), &Vector3::new(1.0, 2.0, 3.0)).unwrap();
    world
}

fn join(world: &mut World, kind: JointKind, (a, b): (BodyId, BodyId), tilt: f64) {
    let at = |z| Isometry3::translation(0.0, 0.0, z);
    let frame = at(0.75) * UnitQuaternion::from_euler_angles(tilt, 0.3, 0.1);
    world.add_joint(&Joint::at(&frame, kind, (a, &at(0.5)), (b, &at(1.0)))).unwrap();
}

fn slider(stop: Stop) -> JointKind {
    let linear = AxisSettings { stop, ..AxisSettings::limited(-0.1, 0.1) };
    JointKind::Slider { linear, angular: AxisSettings::limited(-0.3, 0.3), held: stop }
}

/// What lanes keep of joints is made anew with another joint in the place of one.
#[test]
fn joints_are_replaced() {
    let make = |_| pair(slider(Stop::BULLET));
    compare("replaced", (3, 120), make, |i, n, world| {
        if n == 60 {
            world.remove_joint(JointId { slot: 0 }).unwrap();
            let ends = (BodyId { slot: 1 }, BodyId { slot: 2 });
            join(world, slider(Stop { erp: Some(0.5), ..Stop::BULLET }), ends, 1.0 + i as f64);
        }
    });
}

/// Groups of worlds that are built alike, but not of the same numbers, with one `Lockstep`.
#[test]
fn groups_take_turns() {
    let soft = Stop { cfm: Some(1e-3), ..Stop::BULLET };
    let make = |i: usize| pair(slider(if i < 2 { Stop::BULLET } else { soft }));
    for instructions in available() {
        let mut alone: Vec<World> = (0..4).map(make).collect();
        let mut together: Vec<World> = (0..4).map(make).collect();
        let mut lockstep = Lockstep::with(instructions).unwrap();
        for n in 0..60 {
            let (first, second) = together.split_at_mut(2);
            step(&mut lockstep, first);
            step(&mut lockstep, second);
            for (i, world) in alone.iter_mut().enumerate() {
                world.step().unwrap();
                assert!(
                    Readings::of(world).bits() == Readings::of(&together[i]).bits(),
                    "{i}, {n}"
                );
            }
        }
    }
}

/// Bodies so heavy to turn that Bullet gives up their rows: what it makes of its residual then is its
/// own.
#[test]
fn rows_that_do_nothing_are_left_to_bullet() {
    let make = |i: usize| {
        let mut world = World::new(&WorldSettings::default()).unwrap();
        let (a, b) = (ball(&mut world, 10.0, 5e6, 0.0), ball(&mut world, 10.0, 5e6, 30.0));
        let at = |z| Isometry3::translation(0.0, 0.0, z);
        let ends = ((a, &at(0.0)), (b, &at(30.0)));
        world.add_joint(&Joint::at(&at(15.0), JointKind::Fixed, ends.0, ends.1)).unwrap();
        world.set_velocity(a, &Vector3::x(), &Vector3::new(0.1, i as f64, 0.0)).unwrap();
        world
    };
    let counts = compare("heavy", (3, 20), make, |_, _, _| ());
    assert!(counts.unsupported > 0 || bullet::SCALAR_BYTES == 8, "{counts:?}");
}

/// Angles for which three rotations are told in more than one way.
#[test]
fn joints_are_turned_all_the_way() {
    let settings = WorldSettings { gravity: Vector3::zeros(), ..Default::default() };
    let spring = Some(Spring { stiffness: 5.0, damping: 0.1, equilibrium: 0.0 });
    let held = AxisSettings { spring, ..AxisSettings::limited(-0.5, 0.5) };
    for axes in [[AxisSettings::free(); 6], [held; 6], [AxisSettings::locked(); 6]] {
        for about in [Vector3::x(), Vector3::y(), Vector3::z()] {
            let make = |i: usize| {
                let mut world = World::new(&settings).unwrap();
                let (a, b) = (ball(&mut world, 0.1, 1.0, 0.5), ball(&mut world, 0.1, 2.0, 1.0));
                join(&mut world, JointKind::SixDofSpring(Box::new(axes)), (a, b), i as f64);
                world
            };
            compare("turned", (2, 33), make, |_, n, world| {
                let turn = UnitQuaternion::from_scaled_axis(about * (PI / 16.0 * n as f64));
                let pose = Isometry3::from_parts(Translation3::new(0.0, 0.0, 1.0), turn);
                world.set_pose(BodyId { slot: 1 }, &pose).unwrap();
                world.set_velocity(BodyId { slot: 1 }, &Vector3::zeros(), &about).unwrap();
            });
        }
    }
}

#[test]
fn worlds_that_do_not_match_are_refused() {
    let with = |settings: &WorldSettings, change: &dyn Fn(&mut World, BodyId, BodyId)| {
        let mut world = World::new(settings).unwrap();
        ground(&mut world);
        let (a, b) = (ball(&mut world, 0.1, 1.0, 1.0), ball(&mut world, 0.1, 1.0, 2.0));
        change(&mut world, a, b);
        world
    };
    let settings = WorldSettings::default();
    let join = |kind: JointKind| {
        move |world: &mut World, a: BodyId, b: BodyId| {
            let pose = Isometry3::identity();
            let joint = Joint::at(&pose, kind.clone(), (a, &pose), (b, &pose));
            world.add_joint(&joint).unwrap();
        }
    };
    let motor = Some(Motor { target_velocity: 1.0, max_force: 1.0 });
    let hinge = join(JointKind::Hinge(AxisSettings::limited(-1.0, 1.0)));
    let driven = join(JointKind::Hinge(AxisSettings { motor, ..AxisSettings::limited(-1.0, 1.0) }));
    let fixed = join(JointKind::Fixed);
    let another = |world: &mut World, _, _| {
        ball(world, 0.1, 1.0, 3.0);
    };
    let static_one = |world: &mut World, a, _| {
        world.remove_body(a).unwrap();
    };
    let fewer = WorldSettings { iterations: 50, ..Default::default() };
    let cold = WorldSettings {
        solver_mode: SolverMode::default() - SolverMode::WARM_STARTING,
        ..Default::default()
    };
    let plain = |_: &mut World, _, _| ();
    let cases: [(World, World, &str, &str); 6] = [
        (with(&settings, &plain), with(&fewer, &plain), "200 iterations", "50 iterations"),
        (with(&settings, &plain), with(&cold, &plain), "260 as solver mode", "256 as solver mode"),
        (with(&settings, &plain), with(&settings, &another), "3 bodies", "4 bodies"),
        (with(&settings, &plain), with(&settings, &static_one), "body 1 dynamic", "body 1 removed"),
        (with(&settings, &hinge), with(&settings, &fixed), "joint 0 hinge", "joint 0 fixed"),
        (
            with(&settings, &hinge),
            with(&settings, &driven),
            "joint 0 with axes r",
            "joint 0 with axes R",
        ),
    ];
    let mut lockstep = Lockstep::new().unwrap();
    for (mut one, mut other, first, second) in cases {
        let error = lockstep.step(&mut [&mut one, &mut other], &mut Vec::new()).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!(
                "Lockstep::step: worlds[1] must be built like worlds[0], {first}, got {second}"
            )
        );
        assert_eq!((one.steps(), other.steps()), (0, 0), "none is stepped");
    }
}

#[test]
fn unknown_instructions_are_refused() {
    let error = "mmx".parse::<Instructions>().unwrap_err();
    assert_eq!(
        error.to_string(),
        "Lockstep::new: ITARL_INSTRUCTIONS must be plain, avx2 or avx512, got \"mmx\""
    );
    for instructions in Instructions::ALL {
        assert_eq!(instructions.name().parse::<Instructions>().unwrap(), instructions);
        assert_eq!(Lockstep::with(instructions).is_ok(), instructions.are_available());
    }
}

/// A small robot: a tree of bodies, each joined to one before it.
#[derive(Clone, Debug)]
struct Scene {
    parts: Vec<Part>,
    settings: WorldSettings,
    self_collision: bool,
    restitution: f64,
    paddle: bool,
    anchored: bool,
    seed: u64,
}

#[derive(Clone, Debug)]
struct Part {
    shape: Shape,
    mass: f64,
    parent: usize,
    kind: JointKind,
    turn: [f64; 3],
    friction: f64,
}

fn axis() -> impl Strategy<Value = AxisSettings> {
    let range = prop_oneof![
        Just(AxisSettings::free()),
        Just(AxisSettings::locked()),
        (0.0..0.6, 0.0..0.6).prop_map(|(a, b): (f64, f64)| AxisSettings::limited(-a, b)),
    ];
    let motor = (-4.0..4.0, 0.0..30.0)
        .prop_map(|(target_velocity, max_force)| Motor { target_velocity, max_force });
    let stop = |bounce: fn(f64) -> f64| {
        let setting = || option::of(prop_oneof![Just(0.0), Just(1.0), 0.0..1.0]);
        (setting(), option::of(select(vec![0.0, 0.0, 1e-4])), setting())
            .prop_map(move |(erp, cfm, back)| Stop { erp, cfm, bounce: back.map(bounce) })
    };
    (range, option::of(motor), stop(std::convert::identity))
        .prop_map(|(range, motor, stop)| AxisSettings { motor, stop, ..range })
}

/// Bullet's slider throws nothing back along its axis.
fn along() -> impl Strategy<Value = AxisSettings> {
    axis().prop_map(|axis| AxisSettings { stop: Stop { bounce: None, ..axis.stop }, ..axis })
}

fn sprung() -> impl Strategy<Value = AxisSettings> {
    let spring = (0.0..50.0, 0.0..1.0, -0.3..0.3)
        .prop_map(|(stiffness, damping, equilibrium)| Spring { stiffness, damping, equilibrium });
    (axis(), option::of(spring)).prop_map(|(axis, spring)| AxisSettings { spring, ..axis })
}

fn kind() -> impl Strategy<Value = JointKind> {
    prop_oneof![
        Just(JointKind::Fixed),
        Just(JointKind::PointToPoint),
        axis().prop_map(JointKind::Hinge),
        (along(), axis(), along()).prop_map(|(linear, angular, held)| JointKind::Slider {
            linear,
            angular,
            held: held.stop
        }),
        [sprung(), sprung(), sprung(), sprung(), sprung(), sprung()]
            .prop_map(|axes| JointKind::SixDofSpring(Box::new(axes))),
    ]
}

fn part() -> impl Strategy<Value = Part> {
    let shape = prop_oneof![
        (0.05..0.2).prop_map(|radius| Shape::Sphere { radius }),
        (0.05..0.15, 0.1..0.4).prop_map(|(radius, length)| Shape::Capsule {
            radius,
            length,
            along: Lengthwise::Z
        }),
        (0.05..0.2, 0.05..0.2, 0.05..0.2)
            .prop_map(|(x, y, z)| Shape::Box { half_extents: Vector3::new(x, y, z) }),
    ];
    let turn = [-1.0..1.0, -1.0..1.0, -1.0..1.0];
    (shape, 0.1..5.0, any::<prop::sample::Index>(), kind(), turn, select(vec![0.0, 0.5, 1.0]))
        .prop_map(|(shape, mass, parent, kind, turn, friction)| Part {
            shape,
            mass,
            parent: parent.index(1000),
            kind,
            turn,
            friction,
        })
}

fn scene() -> impl Strategy<Value = Scene> {
    let mode = vec(any::<bool>(), 4).prop_map(|on| {
        let switches = [
            SolverMode::TWO_FRICTION_DIRECTIONS,
            SolverMode::INTERLEAVED_FRICTION,
            SolverMode::FIXED_FRICTION_DIRECTIONS,
        ];
        let cold = SolverMode::default() - SolverMode::WARM_STARTING;
        let start = if on[3] { cold } else { SolverMode::default() };
        switches.into_iter().zip(on).fold(start, |mode, (it, on)| if on { mode | it } else { mode })
    });
    let settings = (mode, 1_u32..60, select(vec![0.0, 0.0, 1e-4]), any::<bool>(), any::<bool>())
        .prop_map(|(solver_mode, iterations, cfm, split_impulse, sleeping)| WorldSettings {
            solver_mode,
            iterations,
            cfm,
            split_impulse,
            sleeping,
            ..WorldSettings::default()
        });
    let yes_or_no = any::<[bool; 3]>();
    (vec(part(), 2..8), settings, yes_or_no, select(vec![0.0, 0.5]), any::<u64>()).prop_map(
        |(parts, settings, [self_collision, paddle, anchored], restitution, seed)| Scene {
            parts,
            settings,
            self_collision,
            restitution,
            paddle,
            anchored,
            seed,
        },
    )
}

impl Scene {
    fn build(&self, number: usize) -> World {
        let mut world = World::new(&self.settings).unwrap();
        let floor = ground(&mut world);
        if self.paddle {
            let shape =
                world.add_shape(&Shape::Box { half_extents: Vector3::new(0.1, 1.0, 0.2) }).unwrap();
            world.add_body(&Body::kinematic(shape, paddle(0))).unwrap();
        }
        let mut placed: Vec<(BodyId, Isometry3<f64>)> = Vec::new();
        for (i, part) in self.parts.iter().enumerate() {
            let pose = Isometry3::from_parts(
                Translation3::new(0.3 * i as f64, 0.1 * (i % 3) as f64, 0.6 + 0.1 * i as f64),
                UnitQuaternion::from_euler_angles(part.turn[0], part.turn[1], part.turn[2]),
            );
            let shape = world.add_shape(&part.shape).unwrap();
            let filter = if self.self_collision {
                CollisionFilter::moving()
            } else {
                CollisionFilter { group: 2, mask: !2 }
            };
            let body = Body {
                friction: part.friction,
                restitution: self.restitution,
                filter,
                ..Body::dynamic(shape, part.mass, pose)
            };
            let id = world.add_body(&body).unwrap();
            let (parent, parent_pose) = match placed.len() {
                0 if self.anchored => (floor, Isometry3::identity()),
                0 => {
                    placed.push((id, pose));
                    continue;
                }
                n => placed[part.parent % n],
            };
            let frame = pose * Isometry3::translation(-0.15, 0.0, 0.0);
            let ends = ((parent, &parent_pose), (id, &pose));
            world.add_joint(&Joint::at(&frame, part.kind.clone(), ends.0, ends.1)).unwrap();
            placed.push((id, pose));
        }
        let spin = Vector3::new(number as f64, (self.seed % 7) as f64, -1.0);
        world.set_velocity(placed[0].0, &(0.3 * spin), &spin).unwrap();
        world
    }

    /// In the order of the joints.
    fn motors(&self) -> Vec<(JointId, Axis)> {
        let joined = self.parts.iter().skip(usize::from(!self.anchored));
        let driven = |(slot, part): (u32, &Part)| {
            let axes = match &part.kind {
                JointKind::Hinge(axis) => vec![(Axis::AngularZ, axis.motor)],
                JointKind::Slider { linear, angular, .. } => {
                    vec![(Axis::LinearX, linear.motor), (Axis::AngularX, angular.motor)]
                }
                JointKind::SixDofSpring(axes) => {
                    Axis::ALL.into_iter().zip(axes.iter().map(|axis| axis.motor)).collect()
                }
                _ => Vec::new(),
            };
            axes.into_iter()
                .filter(|(_, motor)| motor.is_some())
                .map(move |(axis, _)| (JointId { slot }, axis))
        };
        (0..).zip(joined).flat_map(driven).collect()
    }

    fn act(&self, number: usize, n: usize, world: &mut World) {
        if n % 7 == 3 {
            let phase = (n + 3 * number) as f64;
            let commands: Vec<MotorCommand> = self
                .motors()
                .into_iter()
                .map(|(joint, axis)| MotorCommand {
                    joint,
                    axis,
                    target_velocity: 3.0 * phase.sin(),
                    max_force: 10.0 * phase.cos().abs(),
                })
                .collect();
            world.set_motors(&commands).unwrap();
        }
        if self.paddle {
            world.set_pose(BodyId { slot: 1 }, &paddle(n + number)).unwrap();
        }
        if (n + number) % 17 == 5 {
            let last = BodyId { slot: 1 + u32::from(self.paddle) };
            let up = Vector3::new(1.0, number as f64 - 1.0, 6.0);
            world.push(last, Push::Impulse, &up, None).unwrap();
        }
    }
}

fn paddle(step: usize) -> Isometry3<f64> {
    let phase = (step % 100) as f64 / 50.0;
    let x = if phase < 1.0 { 2.0 * phase } else { 4.0 - 2.0 * phase };
    Isometry3::translation(x - 0.6, 0.0, 0.2)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    #[test]
    fn random_robots_and_scenes(scene in scene()) {
        // Wild robots may tear themselves apart, which another test is about.
        let survives = |i| {
            let mut world = scene.build(i);
            (0..60).all(|n| {
                scene.act(i, n, &mut world);
                world.step().is_ok()
            })
        };
        prop_assume!((0..3).all(survives));
        compare("random", (3, 60), |i| scene.build(i), |i, n, world| scene.act(i, n, world));
    }
}
