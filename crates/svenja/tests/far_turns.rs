//! A spherical joint that turns far about y: where no warning is given it gets where it's told to,
//! and where one is given it doesn't.
#![allow(clippy::panic, clippy::unwrap_used, missing_docs)]

use bullet::{World, WorldSettings};
use svenja::{Morphology, Readings, Robot, add_ground};

/// Of the range; a target that the servo reaches ahead of the stop.
const TARGET: f64 = 0.94;

/// A rod on a block, turned about y by up to `reach_deg` either way, and about others.
fn model(reach_deg: f64, erp: f64, others: &str) -> Morphology {
    let text = format!(
        "name = 'rod on a block'
        heading.body = 'block'
        servo.motor = {{ speed_limit_rad_s = 1.0, torque_limit_nm = 200.0 }}
        [[body]]
        name = 'block'
        mass_kg = 100.0
        position_m = [0.0, 0.0, 1.0]
        shape = {{ kind = 'box', half_extents_m = [1.0, 1.0, 1.0] }}
        [[body]]
        name = 'rod'
        mass_kg = 2.0
        position_m = [0.3, 0.0, 2.2]
        shape = {{ kind = 'capsule', radius_m = 0.05, from_m = [-0.3, 0, 0], to_m = [0.3, 0, 0] }}
        [[joint]]
        name = 'shoulder'
        kind = 'spherical'
        parent = 'block'
        child = 'rod'
        anchor_m = [0.0, 0.0, 1.2]
        axes = [
            {{ about = 'y', range_deg = [-{reach_deg}, {reach_deg}], servo = 'motor' }},
            {others}
        ]
        stop.erp = {erp}"
    );
    Morphology::parse("model.toml", &text).unwrap_or_else(|problems| panic!("{problems}"))
}

/// How far from its target an axis still is after 4 to 6 s, at the worst, on either side.
fn error_of(model: &Morphology) -> f64 {
    let mut world = World::new(&WorldSettings::default()).unwrap();
    add_ground(&mut world).unwrap();
    let mut robot = Robot::spawn(model, &mut world).unwrap();
    let mut readings = Readings::default();
    let mut worst: f64 = 0.0;
    for target in [TARGET, -TARGET] {
        let mut targets = vec![0.5; model.actuators().len()];
        targets[0] = target;
        robot.actuate(&targets).unwrap();
        for step in 0..60 {
            robot.step(&mut world, 10).unwrap();
            if step >= 40 {
                robot.sense(&world, &mut readings).unwrap();
                let errors = targets.iter().zip(&readings.values).map(|(a, b)| (a - b).abs());
                worst = errors.fold(worst, f64::max);
            }
        }
    }
    worst
}

#[test]
fn what_is_warned_of_fails_and_what_is_not_holds() {
    let [x, z] = ["x", "z"].map(|about| {
        format!("{{ about = '{about}', range_deg = [-30.0, 30.0], servo = 'motor' }},")
    });
    let both = format!("{x} {z}");
    let mut n_failed = 0;
    for (others, all_turn) in [("", false), (&z, false), (&both, true)] {
        for reach_deg in [55.0, 65.0, 75.0, 88.0_f64] {
            for erp in [1.0, 0.4, 0.1_f64] {
                let model = model(reach_deg, erp, others);
                let what = format!("{reach_deg} degrees, erp {erp}, {others}");
                let is_warned = !model.warnings().is_empty();
                let twice = 2.0 * reach_deg.to_radians().cos();
                assert_eq!(is_warned, erp >= twice && !all_turn, "{what}: {:?}", model.warnings());
                let error = error_of(&model);
                // The warning is of the stops, and the target a little ahead of them; and what is only
                // just beyond grows slowly.
                let at_target = 2.0 * (TARGET * reach_deg).to_radians().cos();
                if is_warned && erp > 1.2 * at_target {
                    n_failed += 1;
                    assert!(error > 0.05, "{what}: {error} in spite of a warning");
                } else if !is_warned {
                    assert!(error < 0.01, "{what}: {error} without a warning");
                }
            }
        }
    }
    assert!(n_failed >= 6, "{n_failed}");
}

#[test]
fn a_warning_says_where_and_what_to_do() {
    let warnings = model(80.0, 1.0, "").warnings().to_vec();
    let place = "model.toml:21:40: joint 'shoulder': axes[0]: range_deg and its stops reach";
    let expected = format!(
        "{place} 80 degrees about y, but with a stop.erp of 1 Bullet can't hold beyond 60 what the \
         joint locks; with at most 0.17, the cosine, it can up to 80"
    );
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    assert_eq!(warning.to_string(), expected);
    // As it's advised.
    assert!(model(80.0, 0.17, "").warnings().is_empty());
    let farther = model(90.0, 0.2, "").warnings()[0].to_string();
    let advice = "with a stop.erp of 0.2 Bullet can't hold beyond 84 what the joint locks; with at \
                  most 0.09, the cosine, it can up to 85";
    assert!(farther.ends_with(advice), "{farther}");
}
