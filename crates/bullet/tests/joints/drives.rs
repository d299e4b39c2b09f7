//! Positions, velocities, motors.

use super::*;

// Positions

#[test]
fn the_position_is_the_childs_frame_seen_from_the_parents() {
    let free = AxisSettings::free();
    let six_free = JointKind::SixDofSpring(Box::new([free; 6]));
    let one = |axis, value| along(axis, value);
    let mut cases: Vec<(JointKind, [f64; 6])> = vec![
        (six_free.clone(), [0.3, -0.2, 0.1, 0.4, -0.9, 2.1]),
        (six_free.clone(), [-0.1, 0.2, 0.5, -3.0, 1.5, -2.9]),
        (JointKind::Fixed, [0.01, -0.02, 0.03, 0.04, -0.05, 0.06]),
        (JointKind::PointToPoint, [0.0, 0.0, 0.0, 0.9, 0.8, -0.7]),
        (
            JointKind::Slider { linear: free, angular: free, held: Stop::BULLET },
            [0.3, 0.0, 0.0, -2.0, 0.0, 0.0],
        ),
    ];
    for value in [-3.1, -1.5, -0.2, 0.2, 1.5, 3.1] {
        for (class, axis) in DRIVEN {
            // The middle angle reaches a quarter turn.
            if axis == Axis::AngularY && f64::abs(value) > 1.55 {
                continue;
            }
            cases.push((kind((class, axis), free), one(axis, value)));
        }
    }
    for (kind, position) in cases {
        // Once as built, once moved there from elsewhere, with the parent moved as well.
        let mut pair = Pair::new(&weightless(), kind.clone(), askew(), Some(3.0), position);
        // A matrix product or two of numbers below 4, their roundings; the middle angle's arc sine
        // makes more of them near a quarter turn, 1/cos(1.5) = 14 times.
        let tolerance = 8.0 * 4.0 * EPS * if position[4].abs() > 1.0 { 14.0 } else { 1.0 };
        let check = |pair: &Pair, what: &str| {
            for axis in Axis::ALL {
                assert_near(
                    &format!("{kind:?} {what}: {axis:?}"),
                    pair.state().position_of(axis),
                    position[axis.index()],
                    tolerance,
                );
            }
        };
        check(&pair, "built");
        let elsewhere = Isometry3::from_parts(
            Translation3::new(-0.6, 0.5, 0.2),
            UnitQuaternion::from_euler_angles(2.0, 0.3, -1.4),
        );
        let child = elsewhere * pair.frames[0] * placed(position) * pair.frames[1].inverse();
        pair.world.set_pose(pair.parent, &elsewhere).unwrap();
        pair.world.set_pose(pair.child, &child).unwrap();
        check(&pair, "moved");
    }
}

#[test]
fn the_velocity_is_the_rate_of_the_position_while_both_bodies_move() {
    let free = AxisSettings::free();
    let mut kinds = vec![
        // Far from 0 in all three angles, where their rates and the spin differ.
        (JointKind::PointToPoint, [0.0, 0.0, 0.0, 0.5, 0.9, -0.4]),
        (JointKind::SixDofSpring(Box::new([free; 6])), [0.1, -0.2, 0.3, 0.5, 0.9, -0.4]),
        (
            JointKind::Slider { linear: free, angular: free, held: Stop::BULLET },
            [0.3, 0.0, 0.0, 0.5, 0.0, 0.0],
        ),
    ];
    kinds.extend(DRIVEN.map(|driven| (kind(driven, free), [0.0; 6])));
    for (kind, start) in kinds {
        let settings = WorldSettings { time_step: 0.001, ..weightless() };
        let mut pair = Pair::new(&settings, kind.clone(), askew(), Some(3.0), start);
        let (v, w) = (Vector3::new(0.5, -0.3, 0.2), Vector3::new(1.0, -0.6, 0.4));
        pair.world.set_velocity(pair.parent, &v, &w).unwrap();
        pair.world.set_velocity(pair.child, &-w, &-v).unwrap();
        let mut moved = 0.0_f64;
        pair.steps(20);
        let mut before = pair.state();
        for _ in 0..300 {
            pair.steps(1);
            let after = pair.state();
            for axis in Axis::ALL {
                let rate = (after.position_of(axis) - before.position_of(axis)) / 0.001;
                // Of the order of the step, times accelerations of some m/s² and rad/s²; and the
                // difference of two rounded positions.
                let tolerance = 0.001 * 6.0 + 8.0 * EPS / 0.001;
                assert_near(
                    &format!("{kind:?} {axis:?}"),
                    after.velocity_of(axis),
                    rate,
                    tolerance,
                );
                moved = moved.max(rate.abs());
            }
            before = after;
        }
        assert!(moved > 0.2, "{kind:?} hardly moved: {moved}");
    }
}

// Motors

#[test]
fn a_positive_motor_velocity_makes_the_position_grow() {
    for driven in DRIVEN {
        let axis = driven.1;
        for parent_mass in [None, Some(3.0)] {
            for built in [0.5, -0.5] {
                let motor = Some(Motor { target_velocity: built, max_force: 1e3 });
                let settings = AxisSettings { motor, ..AxisSettings::free() };
                let kind = kind(driven, settings);
                let mut pair = Pair::new(&weightless(), kind, askew(), parent_mass, [0.0; 6]);
                pair.steps(100);
                let what = format!("{driven:?}, parent {parent_mass:?}");
                // 1 s. The joint's errors, as it is pulled straight, move some mm of it elsewhere.
                let state = pair.state();
                assert_near(&what, state.position_of(axis), built, 2e-3);
                assert_near(&what, state.velocity_of(axis), built, 4e-3);
                // And back again, faster.
                let command = MotorCommand {
                    joint: pair.joint,
                    axis,
                    target_velocity: -2.0 * built,
                    max_force: 1e3,
                };
                pair.world.set_motors(&[command]).unwrap();
                pair.steps(50);
                let state = pair.state();
                assert_near(&what, state.position_of(axis), 0.0, 4e-3);
                assert_near(&what, state.velocity_of(axis), -2.0 * built, 4e-3);
            }
        }
    }
}

#[test]
fn a_motor_accelerates_with_its_limit() {
    for driven in DRIVEN {
        let axis = driven.1;
        let motor = Some(Motor { target_velocity: 100.0, max_force: 3.0 });
        let mut pair =
            Pair::centred(kind(driven, AxisSettings { motor, ..AxisSettings::free() }), [0.0; 6]);
        pair.steps(10);
        let inertia = if is_angular(axis) { MOMENT } else { MASS };
        let expected = 3.0 / inertia * 10.0 * DT;
        // A few roundings a step.
        let tolerance = 40.0 * EPS * expected;
        assert_near(&format!("{driven:?}"), pair.state().velocity_of(axis), expected, tolerance);
    }
}
