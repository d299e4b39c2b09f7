//! Motors as servos under load, and springs.

use std::f64::consts::PI;

use bullet::{
    Axis, AxisSettings, Body, Joint, JointId, JointKind, Motor, MotorCommand, Spring, Stop, World,
};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::lab::{
    EPS, G, assert_near, at, ball, cuboid, joint_of, period, velocity, weightless, world,
};

/// A joint whose axis (of those it can drive) is the frame's z, for angles, or x, for lengths.
pub(crate) fn driven(axis: Axis, class: &str, motor: Motor) -> (JointKind, Axis) {
    let settings = AxisSettings { motor: Some(motor), ..AxisSettings::free() };
    let kind = match (class, axis) {
        ("hinge", _) => JointKind::Hinge(settings),
        ("slider", Axis::LinearX) => JointKind::Slider {
            linear: settings,
            angular: AxisSettings::locked(),
            held: Stop::BULLET,
        },
        ("slider", _) => JointKind::Slider {
            linear: AxisSettings::locked(),
            angular: settings,
            held: Stop::BULLET,
        },
        _ => {
            let mut axes = [AxisSettings::locked(); 6];
            axes[axis.index()] = settings;
            JointKind::SixDofSpring(Box::new(axes))
        }
    };
    (kind, axis)
}

/// Turns the frame's axis (x, y or z) to a direction.
pub(crate) fn frame(axis: Axis, direction: Vector3<f64>) -> UnitQuaternion<f64> {
    let mut from = Vector3::zeros();
    from[axis.index() % 3] = 1.0;
    // None where they are opposite, as y and -y.
    UnitQuaternion::rotation_between(&from, &direction)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), PI))
}

pub(crate) const TURNING: [(&str, Axis); 5] = [
    ("hinge", Axis::AngularZ),
    ("slider", Axis::AngularX),
    ("6-dof", Axis::AngularX),
    ("6-dof", Axis::AngularY),
    ("6-dof", Axis::AngularZ),
];
pub(crate) const SHIFTING: [(&str, Axis); 4] = [
    ("slider", Axis::LinearX),
    ("6-dof", Axis::LinearX),
    ("6-dof", Axis::LinearY),
    ("6-dof", Axis::LinearZ),
];

/// Where a servo, velocity = clamp(10/s (0 - position)), has brought its axis from -0.3 in 3 s.
pub(crate) fn servo(world: &mut World, joint: JointId, axis: Axis, max_force: f64) -> f64 {
    for _ in 0..300 {
        let error = -joint_of(world, joint).position_of(axis);
        let target_velocity = (10.0 * error).clamp(-2.0, 2.0);
        world.set_motors(&[MotorCommand { joint, axis, target_velocity, max_force }]).unwrap();
        world.step().unwrap();
    }
    joint_of(world, joint).position_of(axis)
}

#[test]
fn a_servo_lifts_an_arm_if_its_torque_exceeds_the_load() {
    let (mass, length) = (2.0, 0.5);
    let load = mass * G * length;
    for (class, axis) in TURNING {
        for share in [1.1, 0.9] {
            let mut world = world(-G * Vector3::z(), 0.01);
            let shape = ball(&mut world, 0.05);
            // A rod: a point mass on a long arm takes the solver far more sweeps.
            let rod = cuboid(&mut world, length, 0.05, 0.05);
            let pivot = at(0.0, 0.0, 1.0);
            // The arm points along x at 0 and turns about -y: up.
            let frame = pivot * frame(axis, -Vector3::y());
            let level = pivot * at(length, 0.0, 0.0);
            let down = UnitQuaternion::from_axis_angle(&-Vector3::y_axis(), -0.3);
            let post = world.add_body(&Body::fixed(shape, pivot)).unwrap();
            let arm = world
                .add_body(&Body::dynamic(rod, mass, pivot * down * at(length, 0.0, 0.0)))
                .unwrap();
            let motor = Motor { target_velocity: 0.0, max_force: 0.0 };
            let (kind, axis) = driven(axis, class, motor);
            let joint =
                world.add_joint(&Joint::at(&frame, kind, (post, &pivot), (arm, &level))).unwrap();
            assert_near("start", joint_of(&world, joint).position_of(axis), -0.3, 4.0 * EPS);
            let end = servo(&mut world, joint, axis, share * load);
            if share > 1.0 {
                assert_near(&format!("{class} {axis:?}"), end, 0.0, 1e-3);
            } else {
                // It hangs and swings about the angle where the load is 0.9 of that at level,
                // and can't get above its start.
                assert!(end < -0.3, "{class} {axis:?} got up to {end}");
            }
        }
    }
}

#[test]
fn a_servo_lifts_a_load_if_its_force_exceeds_the_weight() {
    let mass = 2.0;
    for (class, axis) in SHIFTING {
        for share in [1.1, 0.9] {
            let mut world = world(-G * Vector3::z(), 0.01);
            let shape = ball(&mut world, 0.05);
            let top = at(0.0, 0.0, 1.0);
            let frame = top * frame(axis, Vector3::z());
            let post = world.add_body(&Body::fixed(shape, top)).unwrap();
            let load = world.add_body(&Body::dynamic(shape, mass, at(0.0, 0.0, 0.7))).unwrap();
            let motor = Motor { target_velocity: 0.0, max_force: 0.0 };
            let (kind, axis) = driven(axis, class, motor);
            let joint =
                world.add_joint(&Joint::at(&frame, kind, (post, &top), (load, &top))).unwrap();
            assert_near("start", joint_of(&world, joint).position_of(axis), -0.3, 4.0 * EPS);
            let end = servo(&mut world, joint, axis, share * mass * G);
            if share > 1.0 {
                assert_near(&format!("{class} {axis:?}"), end, 0.0, 1e-3);
            } else {
                // Falls with a tenth of g.
                assert_near(&format!("{class} {axis:?}"), end, -0.3 - 0.05 * G * 9.0, 0.02);
            }
        }
    }
}

/// What a spring row of btGeneric6DofSpring2Constraint does to x'' = -(k/m) x - (c/m) x': both
/// forces are those at the step's beginning.
fn spring_step((x, v): (f64, f64), k: f64, c: f64, m: f64, dt: f64) -> (f64, f64) {
    let v = v - dt / m * (k * x + c * v);
    (x + dt * v, v)
}

/// Positions of a spring's axis in every step, let go at `start`, with the body at rest.
fn swing(axis: Axis, spring: Spring, parent_mass: Option<f64>, start: f64, dt: f64) -> Vec<f64> {
    let (mass, moment) = (2.0, 0.5);
    let mut world = weightless(dt);
    let shape = ball(&mut world, 0.1);
    let inertia = Some(Vector3::repeat(moment));
    let zero = Isometry3::identity();
    let parent = world
        .add_body(&match parent_mass {
            Some(mass) => {
                let inertia = Some(Vector3::repeat(moment * mass / 2.0));
                Body { inertia, ..Body::dynamic(shape, mass, zero) }
            }
            None => Body::fixed(shape, zero),
        })
        .unwrap();
    let mut shift = Vector3::zeros();
    shift[axis.index() % 3] = start;
    let pose = if axis.index() < 3 {
        Isometry3::new(shift, Vector3::zeros())
    } else {
        Isometry3::new(Vector3::zeros(), shift)
    };
    let child = world.add_body(&Body { inertia, ..Body::dynamic(shape, mass, pose) }).unwrap();
    let mut axes = [AxisSettings::locked(); 6];
    axes[axis.index()] = AxisSettings { spring: Some(spring), ..AxisSettings::free() };
    let kind = JointKind::SixDofSpring(Box::new(axes));
    let joint = world.add_joint(&Joint::at(&zero, kind, (parent, &zero), (child, &zero))).unwrap();
    (0..1000)
        .map(|_| {
            world.step().unwrap();
            joint_of(&world, joint).position_of(axis)
        })
        .collect()
}

#[test]
fn a_spring_swings_with_its_frequency_and_its_damping() {
    let (dt, start) = (0.005, 0.2);
    for axis in Axis::ALL {
        // Mass or moment of the child, alone or in series with the parent's, which is three times
        // as large.
        let own = if axis.index() < 3 { 2.0 } else { 0.5 };
        for (parent_mass, m) in [(None, own), (Some(6.0), 0.75 * own)] {
            for ratio in [0.0, 0.05, 0.2] {
                let k = 50.0;
                let omega = f64::sqrt(k / m);
                let c = ratio * 2.0 * (k * m).sqrt();
                let what = format!("{axis:?} of {m} with damping ratio {ratio}");
                let spring = Spring { stiffness: k, damping: c, equilibrium: 0.0 };
                let got = swing(axis, spring, parent_mass, start, dt);

                let mut state = (start, 0.0);
                for (step, &x) in got.iter().enumerate() {
                    state = spring_step(state, k, c, m, dt);
                    // Numbers of this size, rounded in each of 1000 steps.
                    assert_near(&format!("{what}, step {step}"), x, state.0, 1000.0 * start * EPS);
                }

                // The difference equation's eigenvalues, r exp(+-i turn), and how far they are
                // from the differential equation's: of the order of the step.
                let r = (1.0 - c * dt / m).sqrt();
                let turn = ((2.0 - c * dt / m - k * dt * dt / m) / (2.0 * r)).acos();
                let step = omega * dt;
                let damped = (1.0 - ratio * ratio).sqrt();
                assert_near(&what, turn / step, damped, step * (ratio + step));
                assert_near(&what, -r.ln() / step, ratio, step * ratio);
                // Between two samples the swing is taken for straight.
                let measured = 2.0 * PI / period(&got, dt) * dt;
                assert_near(&what, measured, turn, step * step * turn);
                // The largest elongation on this side, two periods apart.
                let cycle = (2.0 * PI / turn).round() as usize;
                let top = |range: &[f64]| range.iter().copied().fold(0.0, f64::max);
                let decay =
                    top(&got[2 * cycle + cycle / 2..][..cycle]) / top(&got[cycle / 2..][..cycle]);
                assert_near(&what, decay, r.powf(4.0 * PI / turn), step * step);
            }
        }
    }
}

#[test]
fn a_spring_adds_to_gravity_only_where_it_pulls_against_it() {
    let (dt, mass, k): (f64, f64, f64) = (0.005, 2.0, 100.0);
    let first_speed = |start: f64| {
        let mut world = world(-G * Vector3::z(), dt);
        let shape = ball(&mut world, 0.1);
        let zero = Isometry3::identity();
        let parent = world.add_body(&Body::fixed(shape, zero)).unwrap();
        let child = world.add_body(&Body::dynamic(shape, mass, at(0.0, 0.0, start))).unwrap();
        let spring = Some(Spring { stiffness: k, damping: 0.0, equilibrium: 0.0 });
        let mut axes = [AxisSettings::locked(); 6];
        axes[Axis::LinearZ.index()] = AxisSettings { spring, ..AxisSettings::free() };
        let kind = JointKind::SixDofSpring(Box::new(axes));
        world.add_joint(&Joint::at(&zero, kind, (parent, &zero), (child, &zero))).unwrap();
        world.step().unwrap();
        velocity(&world, child).z
    };
    // A spring's row ends at the velocity that the spring alone would give, and never pulls the
    // other way.
    for (start, acceleration) in [
        (-0.3, 0.3 * k / mass - G),
        (-0.1, 0.1 * k / mass - G),
        (0.1, -f64::max(0.1 * k / mass, G)),
        (0.3, -f64::max(0.3 * k / mass, G)),
    ] {
        // A few roundings of speeds below 0.1 m/s.
        assert_near(
            &format!("from {start}"),
            first_speed(start),
            acceleration * dt,
            8.0 * 0.1 * EPS,
        );
    }
}

#[test]
fn a_spring_too_stiff_for_the_time_step_is_made_softer() {
    // Bullet keeps the natural frequency below a quarter of a radian a step.
    let (dt, m, start): (f64, f64, f64) = (0.01, 2.0, 0.2);
    let spring = Spring { stiffness: 1e6, damping: 0.0, equilibrium: 0.0 };
    let got = swing(Axis::LinearY, spring, None, start, dt);
    let softened = m / (16.0 * dt * dt);
    let mut state = (start, 0.0);
    for (step, &x) in got.iter().enumerate().take(100) {
        state = spring_step(state, softened, 0.0, m, dt);
        assert_near(&format!("step {step}"), x, state.0, 500.0 * EPS);
    }
}
