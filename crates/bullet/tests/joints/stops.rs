//! Limits, stops, springs, reactions.

use super::*;

// Limits

#[test]
fn a_limit_stops_at_its_own_end() {
    let (lower, upper) = (-0.2, 0.5);
    for driven in DRIVEN {
        let axis = driven.1;
        for (speed, end) in [(1.0, upper), (-1.0, lower)] {
            for parent_mass in [None, Some(3.0)] {
                let stop = Stop { bounce: Some(0.0), ..Stop::BULLET };
                let motor = Some(Motor { target_velocity: speed, max_force: 20.0 });
                let settings = AxisSettings { stop, motor, ..AxisSettings::limited(lower, upper) };
                let kind = kind(driven, settings);
                let mut pair = Pair::new(&weightless(), kind, askew(), parent_mass, [0.0; 6]);
                let (mut lowest, mut highest) = (0.0_f64, 0.0_f64);
                for _ in 0..200 {
                    pair.steps(1);
                    let position = pair.state().position_of(axis);
                    (lowest, highest) = (lowest.min(position), highest.max(position));
                }
                let what = format!("{driven:?} to {end}, parent {parent_mass:?}");
                // A slider's rotation is pushed beyond by a step's travel over joint_erp.
                let pushed = match driven {
                    (Class::Slider, Axis::AngularX) => DT * speed / 0.2,
                    _ => 0.0,
                };
                assert_near(&what, pair.state().position_of(axis), end + pushed, 2e-3);
                // Elsewhere no more than a step's travel.
                let farthest = DT.max(pushed.abs()) + 1e-3;
                assert!(lowest >= lower - farthest, "{what}: was at {lowest}");
                assert!(highest <= upper + farthest, "{what}: was at {highest}");
            }
        }
    }
}

#[test]
fn a_locked_axis_stays_against_a_push() {
    for driven in DRIVEN {
        let axis = driven.1;
        let mut pair = Pair::centred(kind(driven, AxisSettings::locked()), [0.0; 6]);
        for _ in 0..100 {
            let mut push = Vector3::zeros();
            push[axis.index() % 3] = 5.0;
            let what = if is_angular(axis) { Push::Torque } else { Push::Force };
            pair.world.push(pair.child, what, &push, None).unwrap();
            pair.steps(1);
        }
        // A free one would be shifted by 5 N / MASS (1 s)² / 2, or turned as much.
        assert_near(&format!("{driven:?}"), pair.state().position_of(axis), 0.0, 1e-5);
    }
}

#[test]
fn stop_erp_is_the_share_of_the_overshoot_that_a_step_takes_back() {
    let (lower, upper, beyond) = (-0.2, 0.3, 0.02);
    for driven in DRIVEN {
        let axis = driven.1;
        for (start, end) in [(upper + beyond, upper), (lower - beyond, lower)] {
            for erp in [1.0, 0.5, 0.2, 0.0] {
                let stop = Stop { erp: Some(erp), bounce: Some(0.0), ..Stop::BULLET };
                let settings = AxisSettings { stop, ..AxisSettings::limited(lower, upper) };
                let mut pair = Pair::centred(kind(driven, settings), along(axis, start));
                pair.steps(1);
                let left = (pair.state().position_of(axis) - end) / (start - end);
                // Roundings of the position, seen from the overshoot.
                let tolerance = 16.0 * EPS / beyond;
                assert_near(&format!("{driven:?} at {end}"), left, 1.0 - erp, tolerance);
            }
        }
    }
}

/// Bullet takes the sine of an angle for its error.
#[test]
fn held_erp_is_the_share_of_an_error_that_a_step_takes_back() {
    let error: f64 = 0.02;
    for axis in [Axis::LinearY, Axis::LinearZ, Axis::AngularY, Axis::AngularZ] {
        for (erp, share) in [(Some(1.0), 1.0), (Some(0.5), 0.5), (Some(0.0), 0.0), (None, 0.2)] {
            let held = Stop { erp, ..Stop::BULLET };
            let locked = AxisSettings::locked();
            let slider = JointKind::Slider { linear: locked, angular: locked, held };
            let mut pair = Pair::centred(slider, along(axis, error));
            pair.steps(1);
            // A slider tells its own rotation's angle alone.
            let mut bodies = Vec::new();
            pair.world.read_bodies(&mut bodies).unwrap();
            let angle = bodies[pair.child.index()].pose().rotation.angle();
            let left =
                if is_angular(axis) { angle } else { pair.state().position_of(axis) } / error;
            let sine = if is_angular(axis) { error * error / 6.0 } else { 0.0 };
            let tolerance = 16.0 * EPS / error + sine;
            assert_near(&format!("{axis:?}, erp {erp:?}"), left, 1.0 - share, tolerance);
        }
    }
}

#[test]
fn a_stop_left_to_bullet_takes_back_joint_erp() {
    let beyond = 0.02;
    for driven in DRIVEN {
        let axis = driven.1;
        let settings = WorldSettings { joint_erp: 0.4, ..weightless() };
        let kind = kind(driven, AxisSettings::limited(-0.2, 0.3));
        let frames = [Isometry3::identity(); 3];
        let mut pair = Pair::new(&settings, kind, frames, None, along(axis, 0.3 + beyond));
        pair.steps(1);
        let left = (pair.state().position_of(axis) - 0.3) / beyond;
        let share = if driven.0 == Class::Hinge { HINGE_BIAS * 0.4 } else { 0.4 };
        assert_near(&format!("{driven:?}"), left, 1.0 - share, 16.0 * EPS / beyond);
    }
}

#[test]
fn stop_bounce_is_the_share_of_the_speed_that_comes_back() {
    let (lower, upper, overshoot) = (-0.2, 0.3, 0.005);
    let bounces = [None, Some(0.0), Some(0.5), Some(1.0)];
    for driven in DRIVEN {
        let (class, axis) = driven;
        for (speed, end) in [(1.0, upper), (-1.0, lower)] {
            for (erp, bounce) in [None, Some(0.2), Some(0.8), Some(1.0)]
                .into_iter()
                .flat_map(|erp| bounces.map(|bounce| (erp, bounce)))
            {
                // A 6-dof joint brakes before it gets there.
                if class == Class::SixDof && erp != Some(1.0) {
                    continue;
                }
                // A slider's stop along x can't bounce, and is refused a bounce.
                if driven == (Class::Slider, Axis::LinearX) && bounce > Some(0.0) {
                    continue;
                }
                let stop = Stop { erp, bounce, ..Stop::BULLET };
                let settings = AxisSettings { stop, ..AxisSettings::limited(lower, upper) };
                // 20 steps to the end and half of one beyond.
                let start = end - (0.2 - overshoot) * speed;
                let mut pair = Pair::centred(kind(driven, settings), along(axis, start));
                pair.set_speed(axis, speed);
                pair.steps(40);
                let comes_back = -pair.state().velocity_of(axis) / speed;
                let by_itself = if class == Class::Hinge { HINGE_BIAS } else { 0.0 };
                let bounce = bounce.unwrap_or(by_itself);
                // The overshoot is taken back by a velocity; a 6-dof joint lets none happen.
                let pushed = match (class, erp) {
                    (Class::SixDof, _) => 0.0,
                    (Class::Hinge, None) => HINGE_BIAS * 0.2,
                    (_, erp) => erp.unwrap_or(0.2),
                } * overshoot
                    / DT;
                // Roundings of 40 steps' positions, as a velocity.
                let tolerance = 40.0 * EPS / DT;
                let what = format!("{driven:?} at {end}, erp {erp:?}, bounce {bounce}");
                assert_near(&what, comes_back, bounce.max(pushed), tolerance);
            }
        }
    }
}

#[test]
fn a_six_dof_joint_brakes_by_its_stop_erp_ahead_of_the_stop() {
    let erp = 0.25;
    for driven in DRIVEN.into_iter().filter(|driven| driven.0 == Class::SixDof) {
        let axis = driven.1;
        let stop = Stop { erp: Some(erp), ..Stop::BULLET };
        let settings = AxisSettings { stop, ..AxisSettings::limited(-0.2, 0.3) };
        let mut pair = Pair::centred(kind(driven, settings), [0.0; 6]);
        pair.set_speed(axis, 1.0);
        let mut position = 0.0_f64;
        for step in 0..60 {
            pair.steps(1);
            position += DT.min(erp * (0.3 - position));
            let what = format!("{axis:?} step {step}");
            assert_near(&what, pair.state().position_of(axis), position, 60.0 * EPS);
        }
    }
}

// Springs

#[test]
fn a_spring_pulls_towards_its_equilibrium() {
    for axis in Axis::ALL {
        for equilibrium in [0.3, -0.4] {
            for parent_mass in [None, Some(3.0)] {
                let spring = Some(Spring { stiffness: 20.0, damping: 6.0, equilibrium });
                let settings = AxisSettings { spring, ..AxisSettings::free() };
                let kind = kind((Class::SixDof, axis), settings);
                let mut pair = Pair::new(&weightless(), kind, askew(), parent_mass, [0.0; 6]);
                let what = format!("{axis:?} to {equilibrium}, parent {parent_mass:?}");
                pair.steps(1);
                let first = pair.state().position_of(axis) / equilibrium;
                assert!(first > 1e-4 && first < 0.1, "{what}: {first} of the way at once");
                pair.steps(1000);
                assert_near(&what, pair.state().position_of(axis), equilibrium, 1e-3);
            }
        }
    }
}

// Reactions

#[test]
fn a_fixed_joint_reads_the_force_and_the_torque_that_hold_the_child() {
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let settings = WorldSettings { gravity, time_step: DT, ..WorldSettings::default() };
    let mut pair = Pair::new(&settings, JointKind::Fixed, askew(), None, [0.0; 6]);
    for (push, lever) in [
        (Vector3::zeros(), Vector3::zeros()),
        (Vector3::new(3.0, -2.0, 1.0), Vector3::zeros()),
        (Vector3::new(3.0, -2.0, 1.0), Vector3::new(0.5, 0.2, -0.4)),
    ] {
        for _ in 0..100 {
            let centre = Point3::from(pair.body(pair.child).position);
            pair.world.push(pair.child, Push::Force, &push, Some(&(centre + lever))).unwrap();
            pair.steps(1);
        }
        // What the joint does is the opposite of all else; gravity has no lever about the centre
        // of mass.
        let (force, torque) = (-(MASS * gravity + push), -lever.cross(&push));
        let state = pair.state();
        for i in 0..3 {
            // Roundings of the solver's rows, 1e-5 of the load.
            assert_near(&format!("force for {push:?}"), state.force[i], force[i], 2e-4);
            assert_near(&format!("torque for {lever:?}"), state.torque[i], torque[i], 2e-4);
        }
    }
}
