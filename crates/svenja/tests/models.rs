//! What every robot in `models/` can do, whatever its body: a file put there is tested as it is.
#![allow(clippy::panic, clippy::unwrap_used, missing_docs)]

use std::{
    fs,
    path::{Path, PathBuf},
};

use nalgebra::Isometry3;
use svenja::{Body, Joint, JointAxis, Morphology, Servo, Shape};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models")
}

fn open(file: &str) -> Morphology {
    Morphology::open(&folder().join(file)).unwrap_or_else(|problems| panic!("{problems}"))
}

/// Every robot with its file's name, in the order of these.
fn models() -> Vec<(String, Morphology)> {
    let files = fs::read_dir(folder()).unwrap().map(|file| file.unwrap().path());
    let mut names: Vec<_> = files
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .map(|path| path.file_name().unwrap().to_str().unwrap().to_owned())
        .collect();
    names.sort();
    assert!(names.len() >= 6, "only {names:?}");
    names.into_iter().map(|name| (name.clone(), open(&name))).collect()
}

#[test]
fn every_robot_can_move_and_feel() {
    for (file, model) in models() {
        assert!(model.warnings().is_empty(), "{file}: {:?}", model.warnings());
        assert!(!model.name().is_empty() && !model.description().is_empty(), "{file}");
        assert!(!model.sensors().is_empty(), "{file}: no sensors");
        assert!(!model.actuators().is_empty(), "{file}: no actuators");
        assert!(!model.contacts().is_empty(), "{file}: no contact sensors");
        assert!(!model.groups().is_empty(), "{file}: no groups");
        let grey = [0x8c; 3];
        assert!(model.bodies().iter().all(|body| body.colour != grey), "{file}: colours left out");
    }
}

#[test]
fn the_page_has_a_row_for_every_robot() {
    let page = fs::read_to_string(folder().join("README.md")).unwrap();
    for (file, model) in models() {
        let row = format!(
            "| [`{file}`]({file}) | {} | {} | {} | {} + {} |",
            model.bodies().len(),
            // Sums of decimals: their rounding isn't worth showing.
            (model.total_mass_kg() * 1e6).round() / 1e6,
            model.actuators().len(),
            model.sensors().len(),
            model.contacts().len(),
        );
        assert!(page.contains(&row), "models/README.md should have the row\n{row}");
    }
}

/// The factors that the head of svenja-constrained.toml states.
const MASS: f64 = 0.7;
const TORQUE: f64 = 0.7;
const RANGE: f64 = 0.5;

/// The file has decimals: a rounding or two.
fn assert_same(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{what}: {found} {expected}");
}

/// What has no factor is equal: each part is compared with the other's, those few figures put in.
#[test]
fn svenja_constrained_is_svenja_but_for_the_stated_factors() {
    let (svenja, constrained) = (open("svenja.toml"), open("svenja-constrained.toml"));

    assert_eq!(svenja.bodies().len(), constrained.bodies().len());
    for (of, found) in svenja.bodies().iter().zip(constrained.bodies()) {
        assert_same(found.mass_kg, MASS * of.mass_kg, &of.name);
        assert_eq!(*found, Body { mass_kg: found.mass_kg, ..of.clone() });
    }

    assert_eq!(svenja.joints().len(), constrained.joints().len());
    for (of, found) in svenja.joints().iter().zip(constrained.joints()) {
        assert_eq!(*found, Joint { axes: found.axes.clone(), ..of.clone() });
        assert_eq!(of.axes.len(), found.axes.len(), "{}", of.name);
        for (of_axis, found) in of.axes.iter().zip(&found.axes) {
            let what = format!("{}/{}", of.name, of_axis.name);
            let (of_range, range) = (of_axis.range.unwrap(), found.range.unwrap());
            assert_same(range[0], RANGE * of_range[0], &what);
            assert_same(range[1], RANGE * of_range[1], &what);
            let (of_servo, servo) = (of_axis.servo.unwrap(), found.servo.unwrap());
            assert_same(servo.force_limit, TORQUE * of_servo.force_limit, &what);
            let servo = Servo { force_limit: servo.force_limit, ..of_servo };
            let expected = JointAxis { range: Some(range), servo: Some(servo), ..of_axis.clone() };
            assert_eq!(*found, expected);
        }
    }

    assert_eq!(svenja.groups(), constrained.groups());
    assert_eq!(svenja.sensors(), constrained.sensors());
    assert_eq!(svenja.actuators(), constrained.actuators());
    assert_eq!(svenja.contacts(), constrained.contacts());
    assert_eq!(svenja.feet(), constrained.feet());
    assert_eq!(svenja.penalised(), constrained.penalised());
    assert_eq!(svenja.heading(), constrained.heading());
    assert_eq!(svenja.start(), constrained.start());
    assert_eq!(svenja.self_collision(), constrained.self_collision());
    assert_eq!(svenja.locomotion_scale(), constrained.locomotion_scale());
    assert_eq!(svenja.touch_distance_m(), constrained.touch_distance_m());
}

/// Lowest point of a body's shape, as drawn: where a support function of its shape says.
#[test]
fn no_robot_is_drawn_or_started_in_the_ground() {
    for (file, model) in models() {
        for body in model.bodies() {
            for collider in &body.colliders {
                let pose = model.start() * body.pose * collider.pose;
                let lowest = lowest_m(&collider.shape, &pose);
                // Rounded figures of a model that rests on the ground.
                assert!(lowest > -1e-6, "{file}: '{}' starts at {lowest} m", body.name);
            }
        }
    }
}

fn lowest_m(shape: &Shape, pose: &Isometry3<f64>) -> f64 {
    match shape {
        Shape::Ellipsoid { radii_m } => {
            let down = pose.rotation.inverse() * nalgebra::Vector3::z();
            pose.translation.z - down.component_mul(radii_m).norm()
        }
        Shape::Hull(hull) => {
            hull.points_m().iter().map(|it| (pose * it).z).fold(f64::INFINITY, f64::min)
        }
        Shape::Sphere { radius_m } => pose.translation.z - radius_m,
        Shape::Box { half_extents_m } => {
            let down = pose.rotation.inverse() * nalgebra::Vector3::z();
            pose.translation.z - down.abs().dot(half_extents_m)
        }
        Shape::Capsule(rod) => (pose * rod.from_m).z.min((pose * rod.to_m).z) - rod.radius_m,
        Shape::Cylinder(rod) => {
            let (from, to) = (pose * rod.from_m, pose * rod.to_m);
            let slope = (to - from).normalize().z;
            from.z.min(to.z) - rod.radius_m * (1.0 - slope * slope).max(0.0).sqrt()
        }
    }
}

#[cfg(feature = "bullet")]
mod in_a_world {
    use bullet::{World, WorldSettings};
    use rand_pcg::{
        Pcg64,
        rand_core::{Rng, SeedableRng},
    };
    use svenja::{Readings, Robot, add_ground};

    use super::*;

    struct Stage<'a> {
        file: &'a str,
        model: &'a Morphology,
        world: World,
        robot: Robot,
        readings: Readings,
        /// Of the positions, the lowest and the highest so far.
        seen: Vec<[f64; 2]>,
        /// Of the contact sensors, whether they ever felt anything.
        felt: Vec<bool>,
    }

    impl<'a> Stage<'a> {
        fn new(file: &'a str, model: &'a Morphology) -> Self {
            let mut world = World::new(&WorldSettings::default()).unwrap();
            add_ground(&mut world).unwrap();
            let robot = Robot::spawn(model, &mut world).unwrap();
            let seen = vec![[f64::INFINITY, f64::NEG_INFINITY]; model.sensors().len()];
            let felt = vec![false; model.contacts().len()];
            Self { file, model, world, robot, readings: Readings::default(), seen, felt }
        }

        /// A tenth of a second. What isn't finite is an error of `step`.
        fn control_step(&mut self, targets: &[f64]) {
            let file = self.file;
            self.robot.actuate(targets).unwrap();
            self.robot.step(&mut self.world, 10).unwrap_or_else(|error| panic!("{file}: {error}"));
            self.robot.sense(&self.world, &mut self.readings).unwrap();

            let values = &self.readings.values;
            assert_eq!(values.len(), self.model.n_readings(), "{file}");
            let (positions, contacts) = values.split_at(self.model.sensors().len());
            for (seen, &value) in self.seen.iter_mut().zip(positions) {
                assert!((-1.0..=1.0).contains(&value), "{file}: reading {value}");
                *seen = [seen[0].min(value), seen[1].max(value)];
            }
            for (felt, &contact) in self.felt.iter_mut().zip(contacts) {
                assert!(contact == 0.0 || contact == 1.0, "{file}: contact {contact}");
                *felt |= contact == 1.0;
            }
        }

        fn height_m(&self) -> f64 {
            self.robot.pose(self.model.heading().body).translation.z
        }
    }

    /// 20 s: two to settle, then hardly a millimetre up or down.
    #[test]
    fn every_robot_stands_or_lies_still() {
        for (file, model) in models() {
            let mut stage = Stage::new(&file, &model);
            let neutral = vec![0.0; model.actuators().len()];
            for _ in 0..20 {
                stage.control_step(&neutral);
            }
            let height = stage.height_m();
            for step in 20..200 {
                stage.control_step(&neutral);
                let drift = stage.height_m() - height;
                assert!(drift.abs() < 0.002, "{file}: {drift} m in step {step}");
                assert_eq!(stage.robot.n_penalised_contacts(), 0, "{file}: in step {step}");
            }
            // As nearly as its servos reach their targets against gravity: 3 degrees off they'd turn
            // at full speed. Of Svenja's narrowest range, 12.5 degrees if constrained, a tenth of the
            // half is 0.6.
            for (&id, value) in model.sensors().iter().zip(&stage.readings.values) {
                assert!(value.abs() < 0.15, "{file}: {} at {value}", model.axis_name(id));
            }
        }
    }

    /// 50 s of random actions of one bit an actuator.
    #[test]
    fn every_robot_can_be_shaken_and_feels_it() {
        for (file, model) in models() {
            let mut stage = Stage::new(&file, &model);
            let mut rng = Pcg64::seed_from_u64(1);
            let mut targets = vec![0.0; model.actuators().len()];
            for _ in 0..500 {
                for target in &mut targets {
                    *target = if rng.next_u32() & 1 == 1 { 0.5 } else { -0.5 };
                }
                stage.control_step(&targets);
            }
            // Targets are 1 apart. A servo that never gets anywhere near one has no strength.
            for (&id, [low, high]) in model.sensors().iter().zip(&stage.seen) {
                let name = model.axis_name(id);
                assert!(high - low > 0.5, "{file}: {name} only from {low} to {high}");
            }
            for (&body, felt) in model.contacts().iter().zip(&stage.felt) {
                assert!(felt, "{file}: '{}' never touched anything", model.bodies()[body].name);
            }
        }
    }
}
