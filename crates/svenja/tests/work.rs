//! The mechanical work of a robot's servos.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;

use bullet::{World, WorldSettings};
use svenja::{Error, JointKind, Morphology, Readings, Robot, add_ground};

fn model(name: &str) -> Morphology {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models").join(name);
    Morphology::open(&path).unwrap()
}

fn spawn(morphology: &Morphology) -> (World, Robot) {
    let mut world = World::new(&WorldSettings::default()).unwrap();
    add_ground(&mut world).unwrap();
    let robot = Robot::spawn(morphology, &mut world).unwrap();
    (world, robot)
}

/// Each actuator's work is its own torque, within its limit, times how far its own axis turned.
#[test]
fn work_is_torque_times_the_turned_angle_of_the_same_axis() {
    for name in ["svenja.toml", "hexapod.toml", "quadruped.toml", "worm.toml"] {
        let morphology = model(name);
        let (mut world, mut robot) = spawn(&morphology);
        world.measure_motors(true);
        let n = morphology.actuators().len();
        let (mut readings, mut total) = (Readings::default(), 0.0);
        robot.sense(&world, &mut readings).unwrap();
        for step in 0..200 {
            // Square waves of different periods.
            let targets: Vec<f64> =
                (0..n).map(|i| if step / (10 + i) % 2 == 0 { 0.9 } else { -0.9 }).collect();
            robot.actuate(&targets).unwrap();
            let before = readings.clone();
            robot.step(&mut world, 1).unwrap();
            robot.sense(&world, &mut readings).unwrap();
            let mut work_j = vec![0.0; n];
            robot.add_work(&world, &mut work_j).unwrap();
            for (work_j, &id) in work_j.iter().zip(morphology.actuators()) {
                let Some(sensor) = morphology.sensors().iter().position(|&it| it == id) else {
                    continue;
                };
                let (axis, joint) = (morphology.axis(id), &morphology.joints()[id.joint]);
                let angle = |readings: &Readings| axis.position_of(readings.values[sensor]);
                let turned = angle(&readings) - angle(&before);
                let most = axis.servo.unwrap().force_limit;
                if before.clipped[sensor] || readings.clipped[sensor] {
                    continue;
                }
                // Angles are of single precision, some 1e-6 rad. Where a joint has three, what a step
                // turns about one of them moves the others, by the product of two such turns.
                let slack_rad = if joint.kind == JointKind::Spherical { 2e-3 } else { 5e-6 };
                assert!(
                    work_j.abs() <= most * (1.05 * turned.abs() + slack_rad),
                    "{name}, step {step}, {}: {work_j} J for {turned} rad at {most} N m",
                    morphology.axis_name(id)
                );
            }
            total += work_j.iter().map(|work| work.abs()).sum::<f64>();
        }
        assert!(total > 0.0, "{name}");
    }
}

#[test]
fn work_of_a_world_that_does_not_measure_it_is_an_error() {
    let morphology = model("worm.toml");
    let (world, mut robot) = spawn(&morphology);
    let mut work_j = vec![0.0; robot.n_actuators()];
    let error = robot.add_work(&world, &mut work_j).unwrap_err().to_string();
    assert!(error.contains("the world must be one that measures its motors"), "{error}");
    let mut empty = World::new(&WorldSettings::default()).unwrap();
    empty.measure_motors(true);
    assert_eq!(robot.add_work(&empty, &mut work_j), Err(Error::OtherWorld));
}
