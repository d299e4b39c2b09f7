//! Worlds stepped in lanes have the bits of worlds stepped alone, whatever is in them; and what
//! lanes don't cover is left to Bullet's own loop. (Robots are in `crates/svenja/tests/lockstep.rs`.)
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod cohorts;
#[path = "../common/mod.rs"]
mod common;
mod refused;
mod scenes;

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
    for worlds in [1, 6] {
        let counts = compare("rest", (worlds, 400), make, |_, _, _| ());
        assert!(counts.swept > 300 * worlds as u64, "{counts:?}");
    }
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
    for worlds in [1, 4] {
        let counts = compare("tiny", (worlds, 5), make, |_, _, _| ());
        assert!(counts.maybe_converged > 0, "{counts:?}");
    }
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
            let filter = CollisionFilter { group: 64, mask: !64 };
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
