//! Svenja on the ground and in free space.
#![cfg(feature = "bullet")]
#![allow(clippy::unwrap_used, missing_docs)]

use std::path::Path;

use bullet::{JointState, Lockstep, Push, World, WorldSettings};
use nalgebra::{UnitQuaternion, Vector3};
use rand_pcg::{
    Pcg64,
    rand_core::{Rng, SeedableRng},
};
use svenja::{JointKind, Morphology, Readings, Robot, add_ground};

fn morphology() -> Morphology {
    Morphology::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/svenja.toml"))
        .unwrap()
}

struct Stage {
    world: World,
    robot: Robot,
    readings: Readings,
}

fn on_ground(morphology: &Morphology) -> Stage {
    let mut world = World::new(&WorldSettings::default()).unwrap();
    add_ground(&mut world).unwrap();
    let robot = Robot::spawn(morphology, &mut world).unwrap();
    Stage { world, robot, readings: Readings::default() }
}

fn in_space(morphology: &Morphology) -> Stage {
    let gravity = Vector3::zeros();
    let mut world = World::new(&WorldSettings { gravity, ..WorldSettings::default() }).unwrap();
    let robot = Robot::spawn(morphology, &mut world).unwrap();
    Stage { world, robot, readings: Readings::default() }
}

impl Stage {
    fn sense(&mut self) {
        self.robot.sense(&self.world, &mut self.readings).unwrap();
    }

    fn control_step(&mut self, targets: &[f64]) {
        self.robot.actuate(targets).unwrap();
        self.robot.step(&mut self.world, 10).unwrap();
        self.sense();
    }

    /// How far the main body's up is from up, in rad.
    fn tilt(&self) -> f64 {
        (self.robot.pose(0).rotation * Vector3::z()).angle(&Vector3::z())
    }

    fn height(&self) -> f64 {
        self.robot.pose(0).translation.z
    }
}

/// Worst of what joints ought not to do, over all physics steps.
#[derive(Default)]
struct Worst {
    /// In m: of a joint's anchors from each other.
    drift: f64,
    /// In rad: beyond the range, which is narrower than the stops by 0.1.
    hip: f64,
    /// In rad: beyond the range, where the stops are.
    knee: f64,
}

impl Worst {
    fn look(&mut self, morphology: &Morphology, stage: &Stage, states: &mut Vec<JointState>) {
        stage.world.read_joints(states).unwrap();
        for (index, joint) in morphology.joints().iter().enumerate() {
            let state = &states[stage.robot.joint_id(index).index()];
            let [x, y, z, ..] = state.position;
            self.drift = self.drift.max(Vector3::new(x, y, z).norm());
            for axis in &joint.axes {
                let (worst, place) = match joint.kind {
                    JointKind::Spherical => (&mut self.hip, 3 + axis.freedom.direction().index()),
                    _ => (&mut self.knee, 3),
                };
                let angle = state.position[place];
                let [lower, upper] = axis.range.unwrap();
                *worst = worst.max(angle - upper).max(lower - angle);
            }
        }
    }
}

#[test]
fn stands_at_the_neutral_command() {
    let morphology = morphology();
    let mut stage = on_ground(&morphology);
    let neutral = vec![0.0; morphology.actuators().len()];
    for _ in 0..20 {
        stage.control_step(&neutral);
    }
    let (height, position) = (stage.height(), stage.robot.centre_of_gravity_m());
    for step in 20..600 {
        stage.control_step(&neutral);
        assert_eq!(stage.robot.n_penalised_contacts(), 0, "step {step}");
        assert!(stage.tilt() < 0.05, "step {step}: {}", stage.tilt());
        assert!((stage.height() - height).abs() < 0.01, "step {step}: {}", stage.height());
    }
    // It creeps, as friction that a solver works out step by step lets it.
    assert!((stage.robot.centre_of_gravity_m() - position).norm() < 0.3);
    let n_feet: f64 = stage.readings.values[24..].iter().sum();
    assert!(n_feet >= 3.0);
    // Its servos reach their targets to within what holds them against gravity: at full torque
    // they'd be 3 degrees off, a tenth of a narrow range.
    assert!(stage.readings.values[..24].iter().all(|value| value.abs() < 0.1));
}

/// Eight of them, which step in lanes, and so for as many steps in a sixth of the time of one. What a
/// simulation with the same figures did: R_Loc of -0.005 and a mean height of 0.98 m. Seeds differ by
/// 0.0003 and 0.004 m, and by shapes, which were its own, a few centimetres.
#[test]
fn survives_random_commands() {
    const ROBOTS: usize = 8;
    let (n, morphology) = (1250, morphology());
    let mut stages: Vec<_> = (0..ROBOTS).map(|_| on_ground(&morphology)).collect();
    let mut random: Vec<_> = (1..=ROBOTS as u64).map(Pcg64::seed_from_u64).collect();
    let mut lockstep = Lockstep::new().unwrap();
    let mut targets = vec![0.0; morphology.actuators().len()];
    for stage in &mut stages {
        for _ in 0..20 {
            stage.control_step(&targets);
        }
    }
    let (mut worst, mut states) = (Worst::default(), Vec::new());
    let (mut heights, mut advance) = (0.0, 0.0);
    for step in 0..n {
        for (stage, rng) in stages.iter_mut().zip(&mut random) {
            targets.fill_with(|| if rng.next_u32() & 1 == 1 { 0.5 } else { -0.5 });
            stage.robot.actuate(&targets).unwrap();
        }
        let before: Vec<_> = stages.iter().map(|it| it.robot.centre_of_gravity_m()).collect();
        for _ in 0..10 {
            drive_and_step(&mut lockstep, &mut stages);
            stages.iter().for_each(|stage| worst.look(&morphology, stage, &mut states));
        }
        for (stage, before) in stages.iter_mut().zip(before) {
            stage.sense();
            let moved = stage.robot.centre_of_gravity_m() - before;
            advance += moved.xy().dot(&stage.robot.heading().xy());
            heights += stage.height();
            assert!(stage.readings.values.iter().all(|value| (-1.0..=1.0).contains(value)));
            assert!(stage.tilt() < 0.5, "step {step}: {}", stage.tilt());
            assert_eq!(stage.robot.n_penalised_contacts(), 0, "step {step}");
        }
    }
    let [heights, advance] = [heights, advance].map(|sum: f64| sum / (n * ROBOTS) as f64);
    println!(
        "height {heights:.4} m, {advance:.5} m a step, anchors within {:.2} mm, hips {:.3} and knees \
         {:.3} degrees beyond",
        worst.drift * 1e3,
        worst.hip.to_degrees(),
        worst.knee.to_degrees()
    );
    assert!((heights - 0.96).abs() < 0.02, "{heights}");
    assert!((advance + 0.0052).abs() < 0.0012, "{advance}");
    assert!(worst.drift < 0.005, "{}", worst.drift);
    // The stops are 0.1 rad beyond the range. 200 iterations leave 0.06 degrees of error there, 1000
    // leave 0.006.
    assert!(worst.hip < 0.1 + 0.1_f64.to_radians(), "{}", worst.hip);
    assert!(worst.knee < 0.5_f64.to_radians(), "{}", worst.knee);
}

/// A physics step of all, in lanes.
fn drive_and_step(lockstep: &mut Lockstep, stages: &mut [Stage]) {
    for Stage { world, robot, .. } in stages.iter_mut() {
        robot.drive(world).unwrap();
    }
    let mut worlds: Vec<_> = stages.iter_mut().map(|stage| &mut stage.world).collect();
    let mut results = Vec::new();
    lockstep.step(&mut worlds, &mut results).unwrap();
    results.into_iter().for_each(Result::unwrap);
}

/// Seen from outside: by how the child is turned against the parent.
#[test]
fn commands_move_each_joint_towards_the_end_they_name() {
    let morphology = morphology();
    for (i, &id) in morphology.actuators().iter().enumerate() {
        let joint = &morphology.joints()[id.joint];
        for command in [1.0, -1.0] {
            let mut stage = in_space(&morphology);
            // All others stay as drawn.
            let mut targets: Vec<_> = morphology
                .actuators()
                .iter()
                .map(|&id| morphology.axis(id).value_of(0.0))
                .collect();
            targets[i] = command;
            for _ in 0..20 {
                stage.control_step(&targets);
            }
            let rotation = |body: usize| stage.robot.pose(body).rotation;
            let turn: UnitQuaternion<f64> =
                rotation(joint.parent.unwrap()).inverse() * rotation(joint.child);
            let axis = joint.frame.rotation * morphology.axis(id).freedom.direction().unit();
            let expected = axis * morphology.axis(id).position_of(command);
            // Half a degree of the others' servos and its own, which still move everything.
            let error = (turn.scaled_axis() - expected).norm();
            assert!(error < 0.02, "{} {command}: off by {error}", morphology.axis_name(id));
            let reading = stage.readings.values[i];
            assert!((reading - command).abs() < 0.1, "{}: {reading}", morphology.axis_name(id));
        }
    }
}

/// All six legs' first axes lift them: +1 lowers the leg.
#[test]
fn plus_one_lowers_the_legs() {
    let morphology = morphology();
    let mut stage = in_space(&morphology);
    let mut targets: Vec<_> =
        morphology.actuators().iter().map(|&id| morphology.axis(id).value_of(0.0)).collect();
    stage.sense();
    let heights = |stage: &Stage| -> Vec<f64> {
        let main = stage.robot.pose(0);
        let foot = |&foot: &usize| main.inv_mul(&stage.robot.pose(foot)).translation.z;
        morphology.feet().iter().map(foot).collect()
    };
    let before = heights(&stage);
    targets.iter_mut().step_by(4).for_each(|target| *target = 1.0);
    for _ in 0..20 {
        stage.control_step(&targets);
    }
    for (foot, (before, after)) in before.iter().zip(heights(&stage)).enumerate() {
        assert!(after < before - 0.05, "foot {foot}: {before} to {after}");
    }
}

/// The greatest distance of a body from its mirror image's mirror image over the first 0.3 s of
/// mirrored random commands, before anything touches the ground. Mirrored commands are equal ones,
/// since mirrored joints have mirrored ranges.
fn asymmetry(morphology: &Morphology, iterations: u32) -> f64 {
    let mut world = World::new(&WorldSettings { iterations, ..WorldSettings::default() }).unwrap();
    let mut robot = Robot::spawn(morphology, &mut world).unwrap();
    let mut rng = Pcg64::seed_from_u64(3);
    let mut worst: f64 = 0.0;
    for _ in 0..3 {
        let mut targets = Vec::new();
        for _pair in 0..3 {
            let leg: Vec<_> =
                (0..4).map(|_| if rng.next_u32() & 1 == 1 { 0.5 } else { -0.5 }).collect();
            targets.extend(leg.iter().chain(&leg));
        }
        robot.actuate(&targets).unwrap();
        for _ in 0..10 {
            robot.step(&mut world, 1).unwrap();
            robot.sense(&world, &mut Readings::default()).unwrap();
            for (index, body) in morphology.bodies().iter().enumerate() {
                let image = if body.name.contains("left") {
                    let name = body.name.replace("left", "right");
                    morphology.bodies().iter().position(|body| body.name == name).unwrap()
                } else if body.name.contains("right") {
                    continue;
                } else {
                    index
                };
                let [a, b] = [index, image].map(|body| robot.pose(body).translation.vector);
                worst = worst.max(Vector3::new(a.x + b.x, a.y - b.y, a.z - b.z).norm());
            }
        }
    }
    worst
}

/// A solver that is cut off takes some joints before others, left ones before right ones: 200
/// iterations leave 23 mm between legs that have moved by ten times that. Rounding leaves 2e-6 m.
#[test]
fn mirrored_commands_make_mirrored_motion() {
    let morphology = morphology();
    let cut_off = asymmetry(&morphology, 200);
    assert!(cut_off < 0.03, "{cut_off}");
    let solved = asymmetry(&morphology, 20_000);
    assert!(solved < 1e-5, "{solved}");
}

#[test]
fn misfit_targets_are_refused() {
    let morphology = morphology();
    let mut stage = in_space(&morphology);
    let mut refused = |targets: &[f64]| stage.robot.actuate(targets).unwrap_err().to_string();
    assert_eq!(refused(&[0.0; 3]), "actuate: targets must be 24 targets, got 3");
    let mut targets = [0.0; 24];
    targets[5] = f64::NAN;
    assert_eq!(refused(&targets), "actuate: targets[5] must be from -1 to 1, got NaN");
    targets[5] = 1.5;
    assert_eq!(refused(&targets), "actuate: targets[5] must be from -1 to 1, got 1.5");
}

#[test]
fn a_world_without_the_robot_is_refused() {
    let morphology = morphology();
    let mut stage = on_ground(&morphology);
    stage.world = World::new(&WorldSettings::default()).unwrap();
    let stranger = "this world doesn't have the robot's bodies and joints";
    let sensed = stage.robot.sense(&stage.world, &mut stage.readings);
    assert_eq!(sensed.unwrap_err().to_string(), stranger);
    assert_eq!(stage.robot.drive(&mut stage.world).unwrap_err().to_string(), stranger);
    assert!(stage.robot.pose(20).translation.z.is_finite(), "whatever it is, it's no panic");
}

#[test]
fn a_blow_up_names_the_part_and_its_joint() {
    let text = r#"
name = "arm"
heading = { body = "base" }
body = [
    { name = "hand", mass_kg = 1.0, position_m = [0.0, 1.0, 0.0], shape = { kind = "sphere", radius_m = 0.1 } },
    { name = "base", mass_kg = 1.0, shape = { kind = "sphere", radius_m = 0.1 } },
]
joint = [{ name = "elbow", kind = "fixed", parent = "base", child = "hand", anchor_m = [0.0, 0.0, 0.0] }]
"#;
    let mut stage = in_space(&Morphology::parse("arm.toml", text).unwrap());
    let push = Vector3::repeat(1e18);
    stage.world.push(stage.robot.body_id(0), Push::Force, &push, None).unwrap();
    let error = stage.robot.step(&mut stage.world, 10).unwrap_err().to_string();
    assert!(error.starts_with("step 1: the linear velocity of body 0 blew up: ("), "{error}");
    assert!(error.ends_with(" (body 'hand' of joint 'elbow')"), "{error}");
}
