//! A restored world continues with the same bits, and nothing but its own snapshot restores it.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use bullet::{Body, Error, Shape, SnapshotError, SolverMode, World, WorldSettings};
use common::{Playground, Readings, assert_same, trajectory};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

/// Few iterations: the bits at stake are the same, and the tests quicker.
fn settings() -> WorldSettings {
    WorldSettings { iterations: 20, ..WorldSettings::default() }
}

fn snapshot_of(world: &mut World) -> Vec<u8> {
    let mut bytes = Vec::new();
    world.snapshot(&mut bytes).unwrap();
    bytes
}

/// Takes a snapshot every `every` steps and, from each, continues in a fresh world and in the
/// same world after it went on elsewhere.
fn assert_continues(settings: &WorldSettings, snapshots: u32, every: u32) {
    const CONTINUATION: u32 = 60;
    let mut world = Playground::new(settings);
    let mut contacts_seen = 0;
    for k in 0..snapshots {
        world.run(every);
        let bytes = snapshot_of(&mut world.world);
        contacts_seen = contacts_seen.max(Readings::of(&world.world).contacts.len());
        let what = format!("snapshot {k} of {settings:?}");

        let expected = trajectory(&mut world, CONTINUATION);
        let end = snapshot_of(&mut world.world);

        let mut fresh = Playground::new(settings);
        fresh.world.restore(&bytes).unwrap();
        assert!(snapshot_of(&mut fresh.world) == bytes, "{what}: written again");
        assert_same(&trajectory(&mut fresh, CONTINUATION), &expected, &format!("{what}, fresh"));
        assert!(snapshot_of(&mut fresh.world) == end, "{what}: at the end, fresh");

        world.world.restore(&bytes).unwrap();
        assert_same(&trajectory(&mut world, CONTINUATION), &expected, &format!("{what}, again"));
        world.world.restore(&bytes).unwrap();
    }
    assert!(contacts_seen > 40, "only {contacts_seen} contacts: the scene proves little");
}

#[test]
fn continues_with_warm_starting() {
    assert_continues(&settings(), 12, 15);
}

#[test]
fn continues_without_warm_starting() {
    let solver_mode = SolverMode::default() - SolverMode::WARM_STARTING;
    assert_continues(&WorldSettings { solver_mode, ..settings() }, 12, 15);
}

#[test]
fn continues_in_the_middle_of_impacts() {
    // Every step of the time in which the heap comes down.
    let mut world = Playground::new(&settings());
    world.run(40);
    for step in 40..80 {
        let bytes = snapshot_of(&mut world.world);
        let mut fresh = Playground::new(&settings());
        fresh.world.restore(&bytes).unwrap();
        let expected = trajectory(&mut world, 1);
        assert_same(&trajectory(&mut fresh, 1), &expected, &format!("restored at {step}"));
        let same = snapshot_of(&mut fresh.world) == snapshot_of(&mut world.world);
        assert!(same, "one step after {step}");
    }
}

#[test]
fn continues_with_cached_friction_directions_in_random_order_and_asleep() {
    let solver_mode = SolverMode::default()
        | SolverMode::TWO_FRICTION_DIRECTIONS
        | SolverMode::CACHED_FRICTION_DIRECTIONS
        | SolverMode::RANDOM_ORDER;
    assert_continues(&WorldSettings { solver_mode, sleeping: true, ..settings() }, 6, 20);
}

#[test]
fn continues_with_bodies_asleep_and_waking() {
    // One box sleeps on the ground, until another one falls on it.
    let build = || {
        let mut world = World::new(&WorldSettings { sleeping: true, ..settings() }).unwrap();
        let plane = world.add_shape(&Shape::ground()).unwrap();
        let cube = world.add_shape(&Shape::Box { half_extents: Vector3::repeat(0.2) }).unwrap();
        world.add_body(&Body::fixed(plane, Isometry3::identity())).unwrap();
        for z in [0.2, 60.0] {
            let pose = Isometry3::translation(0.05 * z / 60.0, 0.0, z);
            world.add_body(&Body::dynamic(cube, 1.0, pose)).unwrap();
        }
        world
    };
    let mut world = build();
    let mut asleep = 0;
    for step in 0..450 {
        let mut continued = (step % 10 == 0).then(|| {
            let mut fresh = build();
            fresh.restore(&snapshot_of(&mut world)).unwrap();
            fresh
        });
        world.step().unwrap();
        let readings = Readings::of(&world);
        asleep += u32::from(!readings.bodies[1].awake);
        if let Some(fresh) = &mut continued {
            fresh.step().unwrap();
            assert_eq!(Readings::of(fresh).bits(), readings.bits(), "step {step}");
            assert!(snapshot_of(fresh) == snapshot_of(&mut world), "step {step}");
        }
    }
    assert!((50..400).contains(&asleep), "slept {asleep} steps, and was woken");
}

#[test]
fn continues_after_bodies_and_joints_were_removed() {
    let build = || {
        let mut playground = Playground::new(&settings());
        let extra = {
            let world = &mut playground.world;
            let ball = world.add_shape(&Shape::Sphere { radius: 0.3 }).unwrap();
            let bodies = [0.0, 0.7, 1.4].map(|x| {
                let pose = Isometry3::translation(x - 3.0, 0.0, 0.31);
                world.add_body(&Body::dynamic(ball, 1.0, pose)).unwrap()
            });
            world.remove_body(bodies[1]).unwrap();
            bodies
        };
        (playground, extra)
    };
    let (mut world, extra) = build();
    world.run(70);
    world.world.remove_body(extra[0]).unwrap();
    world.run(10);
    let bytes = snapshot_of(&mut world.world);

    let (mut fresh, extra) = build();
    let refused = fresh.world.restore(&bytes);
    assert_eq!(refused, Err(Error::Snapshot(SnapshotError::OtherWorld)), "one body too many");
    fresh.world.remove_body(extra[0]).unwrap();
    fresh.world.restore(&bytes).unwrap();
    assert_same(&trajectory(&mut fresh, 60), &trajectory(&mut world, 60), "after removals");
}

#[test]
fn continues_with_bodies_that_are_kept_apart_and_with_ellipsoids() {
    let build = |apart: bool| {
        let mut playground = Playground::new(&settings());
        let world = &mut playground.world;
        let shape = Shape::Ellipsoid { radii: nalgebra::Vector3::new(0.3, 0.2, 0.25) };
        let shape = world.add_shape(&shape).unwrap();
        let bodies = [0.3, 0.5, 0.7].map(|z| {
            let pose = Isometry3::translation(-3.0, 0.01 * z, z);
            world.add_body(&Body::dynamic(shape, 1.0, pose)).unwrap()
        });
        if apart {
            world.keep_apart(bodies[0], bodies[1]).unwrap();
        }
        playground
    };
    let mut world = build(true);
    world.run(70);
    let bytes = snapshot_of(&mut world.world);
    let refused = build(false).world.restore(&bytes);
    assert_eq!(refused, Err(Error::Snapshot(SnapshotError::OtherWorld)), "not kept apart");
    let mut fresh = build(true);
    fresh.world.restore(&bytes).unwrap();
    assert_same(&trajectory(&mut fresh, 60), &trajectory(&mut world, 60), "kept apart");
}

#[test]
fn refuses_a_world_that_was_built_differently() {
    let build = |mass, friction| {
        let mut world = World::new(&settings()).unwrap();
        let ball = world.add_shape(&Shape::Sphere { radius: 0.3 }).unwrap();
        let body = Body { friction, ..Body::dynamic(ball, mass, Isometry3::identity()) };
        world.add_body(&body).unwrap();
        world
    };
    let bytes = snapshot_of(&mut build(1.0, 0.5));
    assert_eq!(build(1.0, 0.5).restore(&bytes), Ok(()));
    for mut other in [build(1.1, 0.5), build(1.0, 0.6), World::new(&settings()).unwrap()] {
        assert_eq!(other.restore(&bytes), Err(Error::Snapshot(SnapshotError::OtherWorld)));
    }
}

#[test]
fn says_what_is_wrong_with_the_bytes() {
    let mut world = World::new(&settings()).unwrap();
    let bytes = snapshot_of(&mut world);
    let mut message = |bytes: &[u8]| world.restore(bytes).unwrap_err().to_string();

    assert_eq!(message(b""), "snapshot: these bytes are not the snapshot of a world");
    assert_eq!(message(b"PNG and so on"), "snapshot: these bytes are not the snapshot of a world");
    assert_eq!(message(&bytes[..20]), "snapshot: damaged: only 20 bytes");
    let mut flipped = bytes.clone();
    flipped[40] ^= 1;
    assert_eq!(message(&flipped), "snapshot: damaged: its checksum is wrong");

    let mut newer = bytes;
    newer[8] = 99;
    let end = newer.len() - 8;
    let checksum = xxhash_rust::xxh3::xxh3_64(&newer[..end]);
    newer[end..].copy_from_slice(&checksum.to_le_bytes());
    assert_eq!(
        message(&newer),
        "snapshot: written with format version 99, and this program reads 1"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn continues_wherever_the_snapshot_was_taken(before in 0_u32..150, after in 1_u32..40) {
        let mut world = Playground::new(&settings());
        world.run(before);
        let bytes = snapshot_of(&mut world.world);
        let mut fresh = Playground::new(&settings());
        fresh.world.restore(&bytes).unwrap();
        assert_same(&trajectory(&mut fresh, after), &trajectory(&mut world, after), "restored");
    }
}

#[test]
fn any_damage_is_noticed_and_changes_nothing() {
    let mut world = Playground::new(&settings());
    world.run(60);
    let bytes = snapshot_of(&mut world.world);
    world.run(5);
    let before = snapshot_of(&mut world.world);

    for length in 0..bytes.len() {
        assert!(world.world.restore(&bytes[..length]).is_err(), "cut to {length} bytes");
    }
    // Every bit of the first and last bytes, and some of those in between.
    let ends = (0..64).chain(bytes.len() - 16..bytes.len());
    let bits = ends.flat_map(|byte| (0..8).map(move |bit| (byte, bit)));
    for (byte, bit) in bits.chain((64..bytes.len()).step_by(23).map(|byte| (byte, byte % 8))) {
        let mut damaged = bytes.clone();
        damaged[byte] ^= 1 << bit;
        assert!(world.world.restore(&damaged).is_err(), "bit {bit} of byte {byte}");
    }
    let mut longer = bytes;
    longer.push(0);
    assert!(world.world.restore(&longer).is_err(), "a byte more");

    assert!(snapshot_of(&mut world.world) == before, "the world is as before");
}
