//! Worlds that live in lanes from step to step: nobody looks at them for a while, or somebody does, or
//! changes one; they part, and are dropped.

use super::*;
use bullet::JointState;

/// Joined bodies of each shape whose contacts lanes find, thrown onto a plane that's tilted.
fn thrown(i: usize) -> World {
    thrown_with(SolverMode::default(), i)
}

fn thrown_with(solver_mode: SolverMode, i: usize) -> World {
    let settings = WorldSettings { solver_mode, ..WorldSettings::default() };
    let mut world = World::new(&settings).unwrap();
    let slope = world.add_shape(&Shape::ground()).unwrap();
    let tilt = UnitQuaternion::from_euler_angles(0.05, -0.04, 0.3);
    let pose = Isometry3::from_parts(Translation3::new(0.0, 0.0, 0.1), tilt);
    world.add_body(&Body { friction: 0.8, restitution: 0.6, ..Body::fixed(slope, pose) }).unwrap();
    let size = 0.1 + 0.01 * i as f64;
    let capsule = |along| Shape::Capsule { radius: size, length: 0.4, along };
    let tilted = Isometry3::from_parts(
        Translation3::new(0.05, 0.0, -0.05),
        UnitQuaternion::from_euler_angles(0.4, 0.2, 0.1 * i as f64),
    );
    let inner = world.add_shape(&capsule(Lengthwise::Y)).unwrap();
    let inner_box =
        world.add_shape(&Shape::Box { half_extents: Vector3::new(0.2, size, 0.1) }).unwrap();
    let mut shapes: Vec<_> = [
        Shape::Box { half_extents: Vector3::new(0.2, size, 0.1) },
        Shape::Sphere { radius: size },
        capsule(Lengthwise::X),
        capsule(Lengthwise::Z),
    ]
    .iter()
    .map(|shape| world.add_shape(shape).unwrap())
    .collect();
    for child in [inner, inner_box] {
        let children = vec![(child, tilted)];
        shapes.push(world.add_shape(&Shape::Compound { children }).unwrap());
    }
    let mut last: Option<(BodyId, Isometry3<f64>)> = None;
    for (k, shape) in shapes.into_iter().enumerate() {
        let turn = UnitQuaternion::from_euler_angles(0.3 * k as f64, 0.4, 1.0 + i as f64);
        let at = Isometry3::from_parts(Translation3::new(0.7 * k as f64, 0.0, 0.8), turn);
        let body = Body {
            friction: 0.3 * k as f64,
            restitution: 0.5,
            filter: CollisionFilter { group: 64, mask: !64 },
            ..Body::dynamic(shape, 1.0 + k as f64, at)
        };
        let id = world.add_body(&body).unwrap();
        world.set_velocity(id, &Vector3::x(), &Vector3::new(1.0, 2.0, 3.0)).unwrap();
        // Each second body flies alone.
        if let (Some((before, from)), true) = (last, k % 2 == 1) {
            let frame = at * Isometry3::translation(-0.3, 0.0, 0.0);
            let joint = Joint::at(&frame, slider(Stop::BULLET), (before, &from), (id, &at));
            world.add_joint(&joint).unwrap();
        }
        last = Some((id, at));
    }
    world
}

#[test]
fn nobody_looks() {
    nobody_looks_with(SolverMode::default(), &[1, 3, 5, 16, 20]);
}

/// Rows of contacts lie elsewhere: each with its friction behind it.
#[test]
fn nobody_looks_at_interleaved_rows() {
    let mode = SolverMode::default() | SolverMode::INTERLEAVED_FRICTION;
    nobody_looks_with(mode, &[1, 5]);
}

fn nobody_looks_with(mode: SolverMode, counts: &[usize]) {
    for instructions in available() {
        for &count in counts {
            let make = |i| thrown_with(mode, i);
            let mut alone: Vec<World> = (0..count).map(make).collect();
            let mut together: Vec<World> = (0..count).map(make).collect();
            let mut lockstep = Lockstep::with(instructions).unwrap();
            for n in [1, 2, 3, 50, 400] {
                for _ in 0..n {
                    alone.iter_mut().for_each(|world| world.step().unwrap());
                    step(&mut lockstep, &mut together);
                }
                for (i, world) in alone.iter_mut().enumerate() {
                    assert!(
                        snapshot(world) == snapshot(&mut together[i]),
                        "{mode:?}, {instructions:?}, {count} worlds: another snapshot of world {i}, {n}"
                    );
                }
            }
            let counts = lockstep.counts();
            assert_eq!(counts.swept, 456 * count as u64, "{counts:?}");
            // The first step of each group of worlds; and that in which they sink in too deep.
            assert!(counts.bullet_contacts * 4 < counts.swept, "{counts:?}");
        }
    }
}

/// One is pushed, one steps alone, one is dropped, one is restored from another; then the lockstep is
/// dropped, and they go on in another one.
#[test]
fn they_part() {
    let mut alone: Vec<World> = (0..6).map(thrown).collect();
    let mut together: Vec<World> = (0..6).map(thrown).collect();
    let mut lockstep = Lockstep::new().unwrap();
    let mut bytes = Vec::new();
    for n in 0..140 {
        for worlds in [&mut alone, &mut together] {
            match n {
                20 => {
                    let up = Vector3::new(0.0, 1.0, 8.0);
                    worlds[1].push(BodyId { slot: 2 }, Push::Impulse, &up, None).unwrap();
                }
                40 => worlds[2].step().unwrap(),
                60 => drop(worlds.remove(4)),
                80 => {
                    worlds[0].snapshot(&mut bytes).unwrap();
                    worlds[0] = thrown(0);
                    worlds[0].restore(&bytes).unwrap();
                }
                120 => worlds.swap(0, 3),
                _ => (),
            }
        }
        if n == 100 {
            lockstep = Lockstep::new().unwrap();
        }
        alone.iter_mut().for_each(|world| world.step().unwrap());
        step(&mut lockstep, &mut together);
    }
    drop(lockstep);
    for (i, world) in alone.iter_mut().enumerate() {
        assert!(snapshot(world) == snapshot(&mut together[i]), "world {i}");
    }
}

/// Two balls that don't meet each other, joined by a slider.
fn slid(linear: AxisSettings, angular: AxisSettings) -> World {
    let mut world = World::new(&WorldSettings::default()).unwrap();
    ground(&mut world);
    let shape = world.add_shape(&Shape::Sphere { radius: 0.1 }).unwrap();
    let filter = CollisionFilter { group: 64, mask: !64 };
    let bodies = [0.5, 1.0].map(|z| {
        let body = Body::dynamic(shape, 1.0, Isometry3::translation(0.0, 0.0, z));
        world.add_body(&Body { filter, ..body }).unwrap()
    });
    let kind = JointKind::Slider { linear, angular, held: Stop::BULLET };
    join(&mut world, kind, (bodies[0], bodies[1]), 0.2);
    world
}

/// A motor tears one apart without leaving lanes: it's told so, as it is alone, and the others go on.
#[test]
fn one_blows_up() {
    let motor = Some(Motor { target_velocity: 0.0, max_force: 1.0 });
    let build = |_| slid(AxisSettings { motor, ..AxisSettings::free() }, AxisSettings::locked());
    let mut alone: Vec<World> = (0..4).map(build).collect();
    let mut together: Vec<World> = (0..4).map(build).collect();
    let mut lockstep = Lockstep::new().unwrap();
    let mut torn = None;
    for n in 0..60 {
        if n == 30 {
            let axis = Axis::LinearX;
            let joint = JointId { slot: 0 };
            let command = MotorCommand { joint, axis, target_velocity: 1e10, max_force: 1e17 };
            alone[2].set_motors(&[command]).unwrap();
            together[2].set_motors(&[command]).unwrap();
        }
        let expected: Vec<_> = alone.iter_mut().map(World::step).collect();
        let mut results = Vec::new();
        lockstep.step(&mut together.iter_mut().collect::<Vec<_>>(), &mut results).unwrap();
        assert_eq!(format!("{results:?}"), format!("{expected:?}"), "step {n}");
        torn = torn.or_else(|| results[2].clone().err());
    }
    assert!(matches!(torn, Some(Error::BlewUp { .. })), "{torn:?}");
    for (a, b) in alone.iter().zip(&together) {
        assert!(Readings::of(a).bits() == Readings::of(b).bits());
    }
}

/// What is read of a world in lanes is what it is; motors are told what to do there, too.
#[test]
fn they_are_read_and_driven() {
    let build = |i: usize| {
        let motor = Some(Motor { target_velocity: 0.0, max_force: 1.0 });
        let angular = AxisSettings { motor, ..AxisSettings::limited(-0.3, 0.3) };
        let linear = AxisSettings::locked();
        let mut world = slid(linear, angular);
        let spin = Vector3::new(0.0, i as f64, 1.0);
        world.set_velocity(BodyId { slot: 1 }, &Vector3::x(), &spin).unwrap();
        world
    };
    let mut alone: Vec<World> = (0..4).map(build).collect();
    let mut together: Vec<World> = (0..4).map(build).collect();
    let mut lockstep = Lockstep::new().unwrap();
    let joint = JointId { slot: 0 };
    let (mut expected, mut found) = (Vec::new(), Vec::new());
    let mut states: [Vec<JointState>; 2] = Default::default();
    for n in 0..200 {
        for i in 0..4 {
            let command = MotorCommand {
                joint,
                axis: Axis::AngularX,
                target_velocity: (0.1 * (n + i) as f64).sin(),
                max_force: 2.0,
            };
            alone[i].set_motors(&[command]).unwrap();
            together[i].set_motors(&[command]).unwrap();
        }
        alone.iter_mut().for_each(|world| world.step().unwrap());
        step(&mut lockstep, &mut together);
        for (a, b) in alone.iter().zip(&together) {
            a.read_angles_of(&[joint], &mut expected).unwrap();
            b.read_angles_of(&[joint], &mut found).unwrap();
            assert_eq!(expected, found, "step {n}");
        }
        if n % 60 == 59 {
            for (i, world) in alone.iter_mut().enumerate() {
                world.read_joints(&mut states[0]).unwrap();
                together[i].read_joints(&mut states[1]).unwrap();
                assert_eq!(states[0], states[1], "{i}, {n}");
                assert!(snapshot(world) == snapshot(&mut together[i]), "{i}, {n}");
            }
        }
    }
    let counts = lockstep.counts();
    assert!(counts.bullet_contacts * 20 < counts.swept, "{counts:?}");
}
