//! Worlds stepped in lanes have the bits of worlds stepped alone by Bullet's own solver: every
//! model, every set of vector instructions that this machine has, any number of worlds.
//!
//! `LOCKSTEP_STEPS` makes it longer than the 300 steps of every test run. `make lockstep-test` has
//! 2,000 with all models, `make verify-lockstep` 100,000 with Svenja.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::{env, path::Path, thread};

use bullet::{
    BodyState, Contact, Instructions, JointId, JointState, Lockstep, LockstepCounts, MotorState,
    Push, World, WorldSettings,
};
use nalgebra::Vector3;
use rand_pcg::{
    Pcg64Mcg,
    rand_core::{Rng, SeedableRng},
};
use svenja::{Morphology, Robot, add_ground};

/// More than one sweep has lanes for.
const WORLDS: usize = 20;

fn steps() -> usize {
    env::var("LOCKSTEP_STEPS").map_or(300, |steps| steps.parse().expect("LOCKSTEP_STEPS"))
}

/// A robot that is dropped, driven at random, pushed and thrown.
struct Rehearsal {
    world: World,
    robot: Robot,
    random: Pcg64Mcg,
    steps: usize,
}

impl Rehearsal {
    fn new(morphology: &Morphology, number: usize, measured: bool) -> Self {
        let mut world = World::new(&WorldSettings::default()).unwrap();
        world.measure_motors(measured);
        add_ground(&mut world).unwrap();
        let robot = Robot::spawn(morphology, &mut world).unwrap();
        let random = Pcg64Mcg::seed_from_u64(number as u64);
        Self { world, robot, random, steps: 0 }
    }

    fn uniform(&mut self) -> f64 {
        (self.random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
    }

    fn uniforms(&mut self) -> Vector3<f64> {
        Vector3::new(self.uniform(), self.uniform(), self.uniform())
    }

    /// What happens to it before its next step.
    fn prepare(&mut self) {
        if self.steps.is_multiple_of(10) {
            let targets: Vec<f64> =
                (0..self.robot.n_actuators()).map(|_| self.uniform().signum()).collect();
            self.robot.actuate(&targets).unwrap();
        }
        let trunk = self.robot.body_id(0);
        if self.steps % 97 == 60 {
            let force = 3000.0 * self.uniforms();
            self.world.push(trunk, Push::Force, &force, None).unwrap();
        }
        if self.steps % 211 == 150 {
            let impulse = 150.0 * (self.uniforms() + Vector3::z());
            self.world.push(trunk, Push::Impulse, &impulse, None).unwrap();
        }
        self.robot.drive(&mut self.world).unwrap();
        self.steps += 1;
    }
}

/// A hash of all that can be read of a world: poses, velocities, impulses of joints, motors and contacts.
#[derive(Default)]
struct Reader {
    bodies: Vec<BodyState>,
    joints: Vec<JointState>,
    contacts: Vec<Contact>,
    motors: Vec<MotorState>,
}

impl Reader {
    fn hash(&mut self, world: &World) -> u64 {
        world.read_bodies(&mut self.bodies).unwrap();
        world.read_joints(&mut self.joints).unwrap();
        world.read_contacts(&mut self.contacts).unwrap();
        let ids: Vec<_> = (0..self.joints.len() as u32).map(|slot| JointId { slot }).collect();
        if world.read_motors_of(&ids, &mut self.motors).is_err() {
            self.motors.clear(); // they aren't measured
        }
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut take = |numbers: &[f64]| {
            for number in numbers {
                hash = (hash ^ number.to_bits()).wrapping_mul(0x0000_0100_0000_01b3);
                hash ^= hash >> 29;
            }
        };
        for body in &self.bodies {
            take(&body.position);
            take(&body.rotation);
            take(&body.linear_velocity);
            take(&body.angular_velocity);
        }
        for joint in &self.joints {
            take(&joint.force);
            take(&joint.torque);
        }
        for motor in &self.motors {
            take(&motor.force);
            take(&motor.work);
        }
        for contact in &self.contacts {
            take(&[contact.distance, contact.impulse]);
            take(&contact.friction_impulse);
        }
        hash
    }
}

fn alone(morphology: &Morphology, number: usize, n: usize, measured: bool) -> Vec<u64> {
    let mut rehearsal = Rehearsal::new(morphology, number, measured);
    let mut reader = Reader::default();
    let step = |_| {
        rehearsal.prepare();
        rehearsal.world.step().unwrap();
        reader.hash(&rehearsal.world)
    };
    (0..n).map(step).collect()
}

/// What lanes are expected to do of a model.
#[derive(Clone, Copy, PartialEq)]
enum Rows {
    /// All of its joints have lanes that make their rows.
    InLanes,
    /// Some haven't: hinges, and joints to what doesn't move.
    Bullets,
    Either,
}

fn check(model: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models").join(model);
    let rows = if model.starts_with("svenja") { Rows::InLanes } else { Rows::Either };
    let counts = check_model(model, &Morphology::open(&path).unwrap(), rows);
    assert!(counts.bullet_moves * 10 < counts.swept, "{model}: {counts:?}");
    // But for steps before which it's pushed, or sinks in too deep.
    let lives_in_lanes = counts.bullet_contacts * 5 < counts.swept;
    assert!(lives_in_lanes || rows == Rows::Either, "{model}: {counts:?}");
}

/// Returns what the widest instructions did last.
fn check_model(model: &str, morphology: &Morphology, rows: Rows) -> LockstepCounts {
    let n = steps();
    let expected: Vec<Vec<u64>> = in_threads(WORLDS, |i| alone(morphology, i, n, false));
    let available = Instructions::ALL.into_iter().filter(|it| it.are_available());
    let sets: Vec<_> =
        available.flat_map(|it| [1, 3, 8, 16, 20].map(|worlds| (it, worlds))).collect();
    let counts = in_threads(sets.len(), |i| {
        let (instructions, count) = sets[i];
        let what = format!("{model}, {instructions:?}, {count} worlds");
        let counts = together(morphology, instructions, &expected[..count], &what, false);
        // Or nothing was compared.
        assert!(counts.swept * 10 > (n * count) as u64 * 9, "{what}: {counts:?}");
        let in_lanes = counts.bullet_rows == 0;
        assert!(rows == Rows::Either || in_lanes == (rows == Rows::InLanes), "{what}: {counts:?}");
        if count == 3 {
            check_measured(model, morphology, instructions);
        }
        println!("{what}: {counts:?}");
        counts
    });
    *counts.last().unwrap()
}

/// Worlds that measure their motors have Bullet's rows.
fn check_measured(model: &str, morphology: &Morphology, instructions: Instructions) {
    let what = format!("{model}, {instructions:?}, motors measured");
    let expected: Vec<_> = (0..3).map(|i| alone(morphology, i, steps().min(60), true)).collect();
    let counts = together(morphology, instructions, &expected, &what, true);
    assert!(counts.swept > 0 && counts.bullet_rows == counts.swept, "{what}: {counts:?}");
}

/// What `make` says for each number below `n`, each in a thread of its own.
fn in_threads<T: Send>(n: usize, make: impl Fn(usize) -> T + Sync) -> Vec<T> {
    thread::scope(|scope| {
        let make = &make;
        let threads: Vec<_> = (0..n).map(|i| scope.spawn(move || make(i))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

/// Steps worlds together, and compares them with what each does alone.
fn together(
    morphology: &Morphology,
    instructions: Instructions,
    expected: &[Vec<u64>],
    what: &str,
    measured: bool,
) -> LockstepCounts {
    let mut group: Vec<_> =
        (0..expected.len()).map(|i| Rehearsal::new(morphology, i, measured)).collect();
    let mut lockstep = Lockstep::with(instructions).unwrap();
    let (mut reader, mut results) = (Reader::default(), Vec::new());
    let alone = |world: usize, step: usize| expected[world][step];
    for step in 0..expected[0].len() {
        group.iter_mut().for_each(Rehearsal::prepare);
        let mut worlds: Vec<&mut World> = group.iter_mut().map(|it| &mut it.world).collect();
        lockstep.step(&mut worlds, &mut results).unwrap();
        for (i, rehearsal) in group.iter().enumerate() {
            results[i].as_ref().unwrap();
            let same = reader.hash(&rehearsal.world) == alone(i, step);
            assert!(same, "{what}: other bits in world {i} after step {}", step + 1);
        }
    }
    lockstep.counts()
}

macro_rules! models {
    ($($name:ident: $file:literal,)*) => {$(
        #[test]
        fn $name() {
            check($file);
        }
    )*

        #[test]
        fn every_model_is_checked() {
            let listed = [$($file),*];
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
            for entry in folder.read_dir().unwrap() {
                let name = entry.unwrap().file_name().into_string().unwrap();
                assert!(!name.ends_with(".toml") || listed.contains(&name.as_str()), "{name}");
            }
        }
    };
}

models! {
    biped: "biped.toml",
    hexapod: "hexapod.toml",
    quadruped: "quadruped.toml",
    svenja: "svenja.toml",
    svenja_constrained: "svenja-constrained.toml",
    worm: "worm.toml",
}

/// The robot of docs/formats.md, which has everything that a file can have.
#[test]
fn all_keys_at_once() {
    let page = include_str!("../../../docs/formats.md");
    let snippets = page.split("```toml\n").skip(2).map(|rest| rest.split_once("```").unwrap().0);
    let model = Morphology::parse("formats.md", &snippets.collect::<String>()).unwrap();
    check_model("formats.md", &model, Rows::Bullets);
}

/// What slides, turns on for ever, is resisted, has several shapes or none: all of it in lanes.
#[test]
fn a_cart_of_new_kinds() {
    let model = Morphology::parse("cart.toml", CART).unwrap();
    check_model("cart", &model, Rows::InLanes);
}

const CART: &str = r#"
name = "Cart"
heading = { body = "cart" }
mirror = { from = "left", to = "right" }
self_collision = true
no_collision = [["cart", "boom"]]
touch = ["boom"]
servo.wheel = { kind = "speed", speed_limit_rad_s = 8.0, torque_limit_nm = 20.0 }
servo.boom = { kind = "torque", speed_limit_m_s = 2.0, force_limit_n = 300.0 }
servo.turn = { speed_limit_rad_s = 3.0, torque_limit_nm = 50.0 }

[[body]]
name = "cart"
mass_kg = 8.0
position_m = [0.0, 0.0, 0.5]
shapes = [
    { kind = "box", half_extents_m = [0.2, 0.5, 0.05] },
    { kind = "capsule", radius_m = 0.05, from_m = [-0.2, 0.0, 0.0], to_m = [0.2, 0.0, 0.0], position_m = [0.0, 0.4, 0.1] },
]

[[body]]
name = "left wheel"
mass_kg = 1.0
friction = 0.9
position_m = [-0.35, 0.3, 0.25]
shape = { kind = "ellipsoid", radii_m = [0.08, 0.2, 0.2] }

[[body]]
name = "left caster"
mass_kg = 0.5
position_m = [-0.3, -0.4, 0.25]
shape = { kind = "hull", file = "caster.stl", scale = 0.1 }

[[body]]
name = "swivel"
mass_kg = 0.5
position_m = [0.0, 0.0, 0.6]
inertia_kg_m2 = [0.01, 0.01, 0.02]

[[body]]
name = "boom"
mass_kg = 1.5
position_m = [0.0, 0.3, 0.7]
inertia_kg_m2 = [0.05, 0.01, 0.05]
shape = { kind = "box", half_extents_m = [0.04, 0.4, 0.04], position_m = [0.0, 0.1, 0.0], rotation_deg = [5.0, 0.0, 0.0] }

[[mesh]]
file = "caster.stl"
points = [[1, 1, 1], [-1, 1, 1], [1, -1, 1], [-1, -1, 1], [0, 0, -2]]

[[joint]]
name = "left wheel"
kind = "spherical"
parent = "cart"
child = "left wheel"
anchor_m = [-0.35, 0.3, -0.25]
axes = [{ about = "x", servo = "wheel", friction_nm = 0.2, damping_nms_rad = 0.3 }]

[[joint]]
name = "left caster"
kind = "slider"
parent = "cart"
child = "left caster"
anchor_m = [-0.3, -0.4, -0.25]
axes = [{ along = "z", range_m = [-0.1, 0.1], spring = { stiffness_n_m = 800.0, damping_ns_m = 40.0 }, friction_n = 3.0 }]

[[joint]]
name = "swivel"
kind = "general"
parent = "cart"
child = "swivel"
anchor_m = [0.0, 0.0, 0.1]
axes = [{ about = "z", servo = "turn" }]

[[joint]]
name = "boom"
kind = "general"
parent = "swivel"
child = "boom"
anchor_m = [0.0, 0.0, 0.1]
axes = [
    { along = "y", range_m = [-0.2, 0.4], servo = "boom", damping_ns_m = 10.0 },
    { about = "x", range_deg = [-30.0, 30.0], damping_nms_rad = 0.5 },
    { along = "z", range_m = [-0.05, 0.05], spring = { stiffness_n_m = 500.0, damping_ns_m = 5.0 } },
]
"#;
