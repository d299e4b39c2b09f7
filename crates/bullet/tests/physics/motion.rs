//! Free bodies, pushes, inertia, pendulums.

use std::f64::consts::{FRAC_PI_2, PI};

use bullet::{AxisSettings, Body, Joint, JointKind, Lengthwise, Push, Shape};
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};

use crate::lab::{
    EPS, G, askew, assert_all_near, assert_near, at, ball, cuboid, period, position, see, spin,
    velocity, weightless, world,
};

// Integration

#[test]
fn free_fall_follows_the_integrators_closed_form_in_every_step() {
    let (dt, start) = (0.01, Vector3::new(1.0, -2.0, 50.0));
    for v0 in [Vector3::zeros(), Vector3::new(1.5, -0.5, 3.0)] {
        let mut world = world(-G * Vector3::z(), dt);
        let shape = ball(&mut world, 0.1);
        let pose = Isometry3::from_parts(start.into(), UnitQuaternion::identity());
        let body = world.add_body(&Body::dynamic(shape, 2.0, pose)).unwrap();
        world.set_velocity(body, &v0, &Vector3::zeros()).unwrap();
        for step in 1..=200 {
            world.step().unwrap();
            let n = f64::from(step);
            let v = v0 - n * dt * G * Vector3::z();
            let x = start + n * dt * v0 - G * dt * dt * n * (n + 1.0) / 2.0 * Vector3::z();
            // Each step rounds a speed below 32 m/s and a height below 64 m once, and the rounding
            // of the speeds adds up in the position.
            let rounding = n * EPS * 32.0;
            assert_all_near("velocity", velocity(&world, body), v, rounding);
            assert_all_near("position", position(&world, body), x, rounding * (2.0 + n * dt));
        }
    }
}

#[test]
fn a_ball_spins_on_without_torque() {
    let dt = 0.01;
    let omega = Vector3::new(1.0, 2.0, -3.0);
    let mut world = weightless(dt);
    let shape = ball(&mut world, 0.3);
    let body = world.add_body(&Body::dynamic(shape, 2.0, askew())).unwrap();
    world.set_velocity(body, &Vector3::zeros(), &omega).unwrap();
    let steps = 300;
    for step in 1..=steps {
        world.step().unwrap();
        let expected = Rotation3::new(omega * dt * f64::from(step)) * askew().rotation;
        let got = Matrix3::from_row_slice(&see(&world, body).rotation);
        // A step goes from the matrix to a quaternion, multiplies, and goes back: a few roundings.
        let tolerance = f64::from(step) * 4.0 * EPS + 4.0 * EPS;
        assert!(
            (got - expected.to_rotation_matrix().matrix()).amax() < tolerance,
            "step {step}: {got} {expected}"
        );
        assert_all_near("spin", spin(&world, body), omega, tolerance);
    }
}

#[test]
fn damping_leaves_its_share_of_the_velocity_after_a_second() {
    let (dt, linear, angular) = (0.01, 0.3, 0.6);
    let (v, omega) = (Vector3::new(1.0, -2.0, 3.0), Vector3::new(-0.5, 0.25, 1.0));
    let mut world = weightless(dt);
    let shape = ball(&mut world, 0.3);
    let body = world
        .add_body(&Body {
            linear_damping: linear,
            angular_damping: angular,
            ..Body::dynamic(shape, 2.0, Isometry3::identity())
        })
        .unwrap();
    world.set_velocity(body, &v, &omega).unwrap();
    for step in 1..=200 {
        world.step().unwrap();
        let t = f64::from(step) * dt;
        // A factor and a product, both rounded, each step.
        let tolerance = f64::from(step) * 2.0 * EPS * 3.0;
        assert_all_near("v", velocity(&world, body), v * (1.0 - linear).powf(t), tolerance);
        assert_all_near("omega", spin(&world, body), omega * (1.0 - angular).powf(t), tolerance);
    }
}

// Mass, pushes

#[test]
fn an_impulse_at_a_point_changes_both_velocities_at_once() {
    let mut world = weightless(0.01);
    let shape = cuboid(&mut world, 0.2, 0.3, 0.5);
    let (mass, inertia) = (2.5, Vector3::new(0.3, 0.5, 0.7));
    let body = world
        .add_body(&Body { inertia: Some(inertia), ..Body::dynamic(shape, mass, askew()) })
        .unwrap();
    let point = askew() * Point3::new(0.2, -0.1, 0.4);
    let impulse = Vector3::new(1.0, 2.0, -0.5);
    world.push(body, Push::Impulse, &impulse, Some(&point)).unwrap();

    let turn = askew().rotation.to_rotation_matrix();
    let inverse = turn * Matrix3::from_diagonal(&inertia.map(f64::recip)) * turn.transpose();
    let arm = point.coords - askew().translation.vector;
    // A dozen roundings of numbers below 8.
    let tolerance = 12.0 * 8.0 * EPS;
    assert_all_near("v", velocity(&world, body), impulse / mass, tolerance);
    assert_all_near("omega", spin(&world, body), inverse * arm.cross(&impulse), tolerance);

    let twist = Vector3::new(-0.2, 0.1, 0.3);
    let before = spin(&world, body);
    world.push(body, Push::AngularImpulse, &twist, None).unwrap();
    assert_all_near("omega", spin(&world, body), before + inverse * twist, tolerance);
    world.push(body, Push::Impulse, &impulse, None).unwrap();
    assert_all_near("v", velocity(&world, body), 2.0 * impulse / mass, tolerance);
    assert_all_near("omega", spin(&world, body), before + inverse * twist, tolerance);
}

#[test]
fn a_force_and_a_torque_act_for_one_step() {
    let dt = 0.01;
    let mut world = weightless(dt);
    // A ball, so that nothing but the push changes its spin.
    let shape = ball(&mut world, 0.3);
    let (mass, moment) = (2.5, 0.4);
    let body = world
        .add_body(&Body {
            inertia: Some(Vector3::repeat(moment)),
            ..Body::dynamic(shape, mass, askew())
        })
        .unwrap();
    let (force, torque) = (Vector3::new(30.0, -20.0, 10.0), Vector3::new(1.0, 2.0, -3.0));
    let arm = Vector3::new(0.1, 0.2, -0.3);
    let point = Point3::from(askew().translation.vector + arm);
    world.push(body, Push::Force, &force, Some(&point)).unwrap();
    world.push(body, Push::Torque, &torque, None).unwrap();
    assert_all_near("v before the step", velocity(&world, body), Vector3::zeros(), 0.0);
    let v = dt / mass * force;
    let omega = dt / moment * (torque + arm.cross(&force));
    for _ in 0..3 {
        world.step().unwrap();
        // A dozen roundings of numbers of size 1.
        assert_all_near("v", velocity(&world, body), v, 12.0 * EPS);
        assert_all_near("omega", spin(&world, body), omega, 12.0 * EPS);
    }
}

/// m/12 (b² + c², c² + a², a² + b²) of a box with these edges.
fn box_inertia(mass: f64, edges: Vector3<f64>) -> Vector3<f64> {
    let square = edges.component_mul(&edges);
    mass / 12.0 * Vector3::new(square.y + square.z, square.z + square.x, square.x + square.y)
}

#[test]
fn inertia_is_that_of_the_shape_or_of_its_bounding_box() {
    let mass = 3.0;
    let mut world = weightless(0.01);
    let (radius, length) = (0.2, 0.7);
    let corners = || {
        (0..8).map(|i| {
            let sign = |bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
            Point3::new(0.1 * sign(1), 0.2 * sign(2), 0.3 * sign(4))
        })
    };
    let margin = 0.04;
    let piece = cuboid(&mut world, 0.1, 0.1, 0.1);
    // Moments of a cylinder across and along its axis.
    let across = mass * (length * length / 12.0 + radius * radius / 4.0);
    let along = mass * radius * radius / 2.0;
    let upright = Vector3::new(2.0 * radius, 2.0 * radius, length + 2.0 * radius);
    let cases = [
        (
            "box",
            Shape::Box { half_extents: Vector3::new(0.1, 0.2, 0.3) },
            box_inertia(mass, Vector3::new(0.2, 0.4, 0.6)),
        ),
        ("ball", Shape::Sphere { radius }, Vector3::repeat(0.4 * mass * radius * radius)),
        (
            "cylinder along x",
            Shape::Cylinder { radius, length, along: Lengthwise::X },
            Vector3::new(along, across, across),
        ),
        (
            "cylinder along y",
            Shape::Cylinder { radius, length, along: Lengthwise::Y },
            Vector3::new(across, along, across),
        ),
        (
            "cylinder along z",
            Shape::Cylinder { radius, length, along: Lengthwise::Z },
            Vector3::new(across, across, along),
        ),
        // btCapsuleShape::calculateLocalInertia: "the box that bounds the spheres".
        (
            "capsule along x",
            Shape::Capsule { radius, length, along: Lengthwise::X },
            box_inertia(mass, Vector3::new(upright.z, upright.x, upright.y)),
        ),
        (
            "capsule along y",
            Shape::Capsule { radius, length, along: Lengthwise::Y },
            box_inertia(mass, Vector3::new(upright.x, upright.z, upright.y)),
        ),
        (
            "capsule along z",
            Shape::Capsule { radius, length, along: Lengthwise::Z },
            box_inertia(mass, upright),
        ),
        // The margin enters three times: recalcLocalAabb, getNonvirtualAabb and
        // btPolyhedralConvexShape::calculateLocalInertia each add it on both sides.
        (
            "hull",
            Shape::Hull { points: corners().collect(), margin },
            box_inertia(mass, Vector3::new(0.2, 0.4, 0.6).add_scalar(6.0 * margin)),
        ),
        (
            "compound",
            Shape::Compound {
                children: vec![(piece, at(-0.4, 0.0, 0.0)), (piece, at(0.4, 0.0, 0.1))],
            },
            box_inertia(mass, Vector3::new(1.0, 0.2, 0.3)),
        ),
    ];
    for (what, shape, expected) in cases {
        let shape = world.add_shape(&shape).unwrap();
        let body = world.add_body(&Body::dynamic(shape, mass, Isometry3::identity())).unwrap();
        let (got_mass, inertia) = world.mass_properties(body).unwrap();
        assert_near("mass", got_mass, mass, 0.0);
        // Bullet writes 1/12 as .08333333, 4e-8 off; the rest is a dozen roundings.
        let tolerance = expected.amax() * (4e-8 + 12.0 * EPS);
        assert_all_near(what, inertia, expected, tolerance);
    }
    let given = Vector3::new(0.25, 0.5, 0.75);
    let body = world
        .add_body(&Body { inertia: Some(given), ..Body::dynamic(piece, mass, askew()) })
        .unwrap();
    assert_all_near("given", world.mass_properties(body).unwrap().1, given, EPS);
}

// Pendulums

/// Arithmetic-geometric mean.
fn agm(mut a: f64, mut b: f64) -> f64 {
    while (a - b).abs() > 1e-15 * a {
        (a, b) = ((a + b) / 2.0, (a * b).sqrt());
    }
    a
}

#[test]
fn a_pendulum_has_the_period_of_its_elliptic_integral() {
    let (dt, mass, length, moment) = (0.002, 1.5, 0.8, 0.1);
    let hinge = JointKind::Hinge(AxisSettings::free());
    for kind in [hinge, JointKind::PointToPoint] {
        for amplitude in [0.05, PI / 3.0] {
            let mut world = world(-G * Vector3::z(), dt);
            let shape = ball(&mut world, 0.05);
            let pivot = at(0.0, 0.0, 2.0);
            // A hinge along y: its frame's z axis turned there.
            let axis = pivot * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -FRAC_PI_2);
            let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), amplitude);
            let pose = pivot * turn * at(0.0, 0.0, -length);
            let post = world.add_body(&Body::fixed(shape, pivot)).unwrap();
            let bob = world
                .add_body(&Body {
                    inertia: Some(Vector3::repeat(moment)),
                    ..Body::dynamic(shape, mass, pose)
                })
                .unwrap();
            let joint = Joint::at(&axis, kind.clone(), (post, &pivot), (bob, &pose));
            world.add_joint(&joint).unwrap();

            let mut angles = Vec::new();
            for _ in 0..3000 {
                world.step().unwrap();
                let arm = position(&world, bob) - pivot.translation.vector;
                angles.push(arm.x.atan2(-arm.z));
            }
            let expected =
                2.0 * PI * ((moment + mass * length * length) / (mass * G * length)).sqrt()
                    / agm(1.0, (amplitude / 2.0).cos());
            // Semi-implicit Euler is off by (2 pi dt/T)²/24 = 2e-6; the arm, pulled back from its
            // tangent by joint_erp of the way each step, is longer by (v dt)²/(2 l erp) = 1e-4
            // of itself at most.
            let got = period(&angles, dt);
            assert_near("period", got, expected, 2e-4 * expected);
        }
    }
}
