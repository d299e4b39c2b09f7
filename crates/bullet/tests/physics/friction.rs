//! What surfaces do to each other: friction, restitution, rolling and spinning friction.

use bullet::{Body, BodyId, Shape, World, WorldSettings};
use nalgebra::Vector3;

use crate::lab::{
    EPS, G, assert_near, at, ball, contacts, cuboid, grounded, position, see, spin, steps,
    still_ground, velocity, weightless, world,
};

/// A block that lies on z = 0 under a gravity that is tilted by an angle of this tangent, towards
/// x. Gravity is tilted, not the plane: the contact normal then has no rounding and all four
/// corners are alike.
fn on_a_slope(tangent: f64, block: f64, plane: f64) -> (World, BodyId) {
    let dt = 0.01;
    let angle = tangent.atan();
    let mut world = world(G * Vector3::new(angle.sin(), 0.0, -angle.cos()), dt);
    let ground = world.add_shape(&Shape::ground()).unwrap();
    // Flat enough not to tip over.
    let shape = cuboid(&mut world, 0.5, 0.5, 0.1);
    world.add_body(&Body { friction: plane, ..still_ground(ground) }).unwrap();
    let body = world
        .add_body(&Body { friction: block, ..Body::dynamic(shape, 2.0, at(0.0, 0.0, 0.1)) })
        .unwrap();
    (world, body)
}

#[test]
fn a_block_sticks_below_the_friction_angle_and_slides_above_it() {
    // The coefficients multiply: 0.8 * 0.5.
    let (block, plane, friction) = (0.8, 0.5, 0.4);
    let (mut world, body) = on_a_slope(0.98 * friction, block, plane);
    // The corners take up their loads within half a second, slipping a little.
    steps(&mut world, 50);
    let start = position(&world, body).x;
    steps(&mut world, 200);
    assert_near("way below the friction angle", position(&world, body).x, start, 1e-6);
    for steeper in [1.02, 1.5] {
        let angle: f64 = (steeper * friction).atan();
        let acceleration = G * (angle.sin() - friction * angle.cos());
        let (mut world, body) = on_a_slope(steeper * friction, block, plane);
        steps(&mut world, 50);
        let start = velocity(&world, body).x;
        steps(&mut world, 200);
        let gained = (velocity(&world, body).x - start) / 2.0;
        // Bullet drops contact points that slid too far (1.4 cm here) and finds the corners anew: the block nods
        // at that, and lands on them with some friction more than its weight's, half a percent.
        assert_near("above the friction angle", gained, acceleration, 0.01 * friction * G);
    }
}

#[test]
fn friction_holds_a_block_with_the_impulse_of_its_weight_downhill() {
    let (dt, mass, tangent): (f64, f64, f64) = (0.01, 2.0, 0.3);
    let (mut world, _) = on_a_slope(tangent, 0.8, 0.5);
    steps(&mut world, 100);
    let contacts = contacts(&world);
    let angle = tangent.atan();
    let friction: Vector3<f64> = contacts.iter().map(|c| Vector3::from(c.friction_impulse)).sum();
    let normal: f64 = contacts.iter().map(|c| c.impulse).sum();
    let weight = mass * G * dt;
    assert_near("friction", friction.x, -weight * angle.sin(), 5e-3 * weight);
    assert_near("normal", normal, weight * angle.cos(), 5e-3 * weight);
}

/// How fast a ball comes back that meets the ground with this speed: it touches as the step
/// begins, and there is no gravity.
fn bounce(speed: f64, ball_e: f64, ground_e: f64) -> f64 {
    let mut world = weightless(0.01);
    let ground = world.add_shape(&Shape::ground()).unwrap();
    let shape = ball(&mut world, 0.125);
    world.add_body(&Body { restitution: ground_e, ..still_ground(ground) }).unwrap();
    let body = world
        .add_body(&Body { restitution: ball_e, ..Body::dynamic(shape, 2.0, at(0.0, 0.0, 0.125)) })
        .unwrap();
    world.set_velocity(body, &(-speed * Vector3::z()), &Vector3::zeros()).unwrap();
    world.step().unwrap();
    velocity(&world, body).z
}

#[test]
fn a_collision_gives_back_the_product_of_the_restitutions() {
    for speed in [0.25, 1.0, 5.0] {
        let tolerance = 8.0 * EPS * speed;
        assert_near("both", bounce(speed, 0.8, 0.5), 0.4 * speed, tolerance);
        assert_near("all", bounce(speed, 1.0, 1.0), speed, tolerance);
        assert_near("none", bounce(speed, 1.0, 0.0), 0.0, tolerance);
    }
    assert_near("slower than 0.2 m/s", bounce(0.19, 1.0, 1.0), 0.0, 8.0 * EPS);
}

#[test]
fn a_dropped_ball_rises_to_the_square_of_its_restitution() {
    // Bullet slows what it sees coming, from 4 mm above the ground, and pushes out what has sunk
    // in, by contact_erp of the depth a step: both change the height. This drop passes from
    // 0.048 m above to 0.001 m below in one step, and isn't pushed out.
    let (dt, radius, drop, e) = (0.01, 0.125, 1.25, 0.8);
    let mut world =
        World::new(&WorldSettings { time_step: dt, contact_erp: 0.0, ..WorldSettings::default() })
            .unwrap();
    let ground = world.add_shape(&Shape::ground()).unwrap();
    let shape = ball(&mut world, radius);
    world.add_body(&Body { restitution: 1.0, ..still_ground(ground) }).unwrap();
    let body = world
        .add_body(&Body {
            restitution: e,
            ..Body::dynamic(shape, 2.0, at(0.0, 0.0, radius + drop))
        })
        .unwrap();
    let mut top = 0.0_f64;
    for _ in 0..100 {
        world.step().unwrap();
        let state = see(&world, body);
        if state.linear_velocity[2] > 0.0 {
            top = top.max(state.position[2] - radius);
        }
    }
    // Euler's heights are half a step's travel off.
    let landing = (2.0 * G * drop).sqrt();
    assert_near("top", top, e * e * drop, landing * dt / 2.0);
}

#[test]
fn rolling_friction_slows_a_rolling_ball() {
    let (dt, mass, radius, speed) = (0.005, 2.0, 0.25, 2.0);
    let roll = |own: f64, grounds: f64| {
        let (mut world, _) = grounded(dt, |plane| Body {
            friction: 0.5,
            rolling_friction: grounds,
            ..still_ground(plane)
        });
        let shape = ball(&mut world, radius);
        let body = world
            .add_body(&Body {
                friction: 0.8,
                rolling_friction: own,
                ..Body::dynamic(shape, mass, at(0.0, 0.0, radius))
            })
            .unwrap();
        world
            .set_velocity(body, &(speed * Vector3::x()), &(speed / radius * Vector3::y()))
            .unwrap();
        steps(&mut world, 200);
        (velocity(&world, body).x, spin(&world, body).y)
    };
    for (own, grounds) in [(0.0, 0.0), (0.02, 0.0), (0.0, 0.02), (0.01, 0.02)] {
        // Each arm times the other's friction. In 1 s the torque m g arm slows a rolling mass of
        // 7/5 m.
        let arm = own * 0.5 + grounds * 0.8;
        let expected = speed - G * arm / (1.4 * radius);
        let (v, omega) = roll(own, grounds);
        // The ball sinks in a little where it starts, and bounces back: 1e-3 of its weight.
        assert_near("speed", v, expected, 2e-3);
        assert_near("rolls without slipping", omega * radius, v, 2e-3);
    }
}

#[test]
fn spinning_friction_slows_a_top() {
    let (dt, mass, radius, omega) = (0.005, 2.0, 0.25, 10.0);
    let arm = 0.02;
    let spin_down = |rolling_friction: f64| {
        let (mut world, _) = grounded(dt, |plane| Body { friction: 1.0, ..still_ground(plane) });
        let shape = ball(&mut world, radius);
        let body = world
            .add_body(&Body {
                rolling_friction,
                spinning_friction: arm,
                ..Body::dynamic(shape, mass, at(0.0, 0.0, radius))
            })
            .unwrap();
        world.set_velocity(body, &Vector3::zeros(), &(omega * Vector3::z())).unwrap();
        steps(&mut world, 100);
        spin(&world, body).z
    };
    let expected = omega - 0.5 * arm * G / (0.4 * radius * radius);
    assert_near("spin", spin_down(0.01), expected, 1e-2);
    // Bullet makes the row against spinning only together with those against rolling.
    assert_near("spin without rolling friction", spin_down(0.0), omega, 1e-2);
}

#[test]
fn a_moving_platform_carries_a_box_by_friction() {
    let (dt, speed) = (0.01, 0.5);
    let mut world = world(-G * Vector3::z(), dt);
    let slab = cuboid(&mut world, 3.0, 1.0, 0.1);
    let shape = cuboid(&mut world, 0.2, 0.2, 0.1);
    let platform = world.add_body(&Body::kinematic(slab, at(0.0, 0.0, -0.1))).unwrap();
    let load = world.add_body(&Body::dynamic(shape, 1.0, at(0.0, 0.0, 0.1))).unwrap();
    let mut way = 0.0;
    for _ in 0..200 {
        way += speed * dt;
        world.set_pose(platform, &at(way, 0.0, -0.1)).unwrap();
        world.step().unwrap();
    }
    assert_near("platform", velocity(&world, platform).x, speed, 400.0 * EPS);
    assert_near("load", velocity(&world, load).x, speed, 1e-3);
    // Friction 0.5 * 0.5 gets it up to speed within v/(mu g), while it lags by half that way.
    let lag = speed * speed / (2.0 * 0.25 * G);
    assert_near("lag", way - position(&world, load).x, lag, speed * dt);
}
