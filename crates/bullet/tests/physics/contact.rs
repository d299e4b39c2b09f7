//! Friction, restitution, rolling, collisions, resting, sleeping.

use bullet::{
    AxisSettings, Body, BodyId, CollisionFilter, Joint, JointKind, Lengthwise, Push, Shape, Stop,
    World, WorldSettings,
};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use crate::lab::{
    EPS, G, assert_all_near, assert_near, at, ball, contacts, cuboid, grounded, position, see,
    spin, steps, still_ground, velocity, weightless, world,
};

// Friction, restitution, rolling

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

// Collisions

/// Momentum, angular momentum about the origin, and kinetic energy of balls of one moment.
fn totals(world: &World, balls: &[(BodyId, f64, f64)]) -> (Vector3<f64>, Vector3<f64>, f64) {
    let (mut p, mut l, mut e) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for &(id, mass, moment) in balls {
        let (x, v, w) = (position(world, id), velocity(world, id), spin(world, id));
        p += mass * v;
        l += mass * x.cross(&v) + moment * w;
        e += (mass * v.norm_squared() + moment * w.norm_squared()) / 2.0;
    }
    (p, l, e)
}

#[test]
fn an_oblique_collision_keeps_momentum_and_makes_no_energy() {
    let dt = 0.001;
    for (restitution, friction) in [(0.0, 0.0), (1.0, 0.0), (0.5, 0.0), (0.5, 1.0), (1.0, 1.0)] {
        // Without contact_erp: what it pushes apart gains energy, in Bullet.
        let mut world = World::new(&WorldSettings {
            gravity: Vector3::zeros(),
            time_step: dt,
            contact_erp: 0.0,
            ..WorldSettings::default()
        })
        .unwrap();
        let shape = ball(&mut world, 0.5);
        let mut add = |mass: f64, x: f64, y: f64| {
            let body = Body { restitution, friction, ..Body::dynamic(shape, mass, at(x, y, 0.2)) };
            (world.add_body(&body).unwrap(), mass, 0.4 * mass * 0.25)
        };
        let balls = [add(1.0, -0.7, 0.0), add(3.0, 0.7, 0.4)];
        world
            .set_velocity(balls[0].0, &Vector3::new(3.0, 0.5, 0.0), &Vector3::new(2.0, 0.0, -3.0))
            .unwrap();
        let before = totals(&world, &balls);
        let v = velocity(&world, balls[0].0);
        steps(&mut world, 400);
        let after = totals(&world, &balls);
        let impulse = (velocity(&world, balls[0].0) - v).norm();
        assert!(impulse > 0.5, "they didn't meet: {impulse} N s");
        // Some thousand roundings, half up, half down, of numbers below 4.
        let rounding = 400.0 * 4.0 * EPS;
        assert_all_near("momentum", after.0, before.0, rounding);
        // Friction acts on each ball's own surface, a gap or a depth of up to a step's travel
        // apart: a couple. Without it the line of action is one.
        let couple = if friction > 0.0 { impulse * 3.0 * dt } else { 0.0 };
        assert_all_near("angular momentum", after.1, before.1, 2.0 * rounding + couple);
        assert!(after.2 <= before.2 + rounding, "energy {} -> {}", before.2, after.2);
        if (restitution, friction) == (0.0, 0.0) {
            assert!(after.2 < 0.8 * before.2, "a plastic collision loses energy: {}", after.2);
        }
    }
}

#[test]
fn bodies_touch_if_each_ones_mask_has_the_others_group() {
    let falls_through = |ground: CollisionFilter, block: CollisionFilter| {
        let (mut world, _) = grounded(0.01, |plane| Body { filter: ground, ..still_ground(plane) });
        let shape = cuboid(&mut world, 0.1, 0.1, 0.1);
        let body = world
            .add_body(&Body { filter: block, ..Body::dynamic(shape, 1.0, at(0.0, 0.0, 0.1)) })
            .unwrap();
        steps(&mut world, 50);
        position(&world, body).z < -1.0
    };
    let filter = |group, mask| CollisionFilter { group, mask };
    let (still, moving) = (CollisionFilter::still(), CollisionFilter::moving());
    assert!(!falls_through(still, moving));
    assert!(!falls_through(filter(4, 8), filter(8, 4)));
    assert!(!falls_through(filter(4, 24), filter(8, 6)));
    assert!(falls_through(filter(4, 8), filter(8, 2)), "the block doesn't want");
    assert!(falls_through(filter(4, 2), filter(8, 4)), "the ground doesn't want");
    assert!(falls_through(filter(4, 8), filter(16, 4)), "the ground wants another");
}

#[test]
fn jointed_bodies_collide_only_if_told_to() {
    let nearest = |collide_connected: bool| {
        let mut world = weightless(0.01);
        let shape = ball(&mut world, 0.1);
        let (left, right) = (at(0.0, 0.0, 0.0), at(0.5, 0.0, 0.0));
        let parent = world.add_body(&Body::fixed(shape, left)).unwrap();
        let child = world.add_body(&Body::dynamic(shape, 1.0, right)).unwrap();
        let rail = JointKind::Slider {
            linear: AxisSettings::free(),
            angular: AxisSettings::locked(),
            held: Stop::BULLET,
        };
        let joint =
            Joint { collide_connected, ..Joint::at(&left, rail, (parent, &left), (child, &right)) };
        world.add_joint(&joint).unwrap();
        world.set_velocity(child, &(-Vector3::x()), &Vector3::zeros()).unwrap();
        let mut nearest = f64::INFINITY;
        for _ in 0..100 {
            world.step().unwrap();
            nearest = nearest.min(position(&world, child).x);
        }
        nearest
    };
    // Two radii, less a step's travel.
    assert_near("they touch", nearest(true), 0.2, 0.01);
    assert_near("it passes", nearest(false), 0.5 - 1.0, 1e-3);
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

#[test]
fn shapes_carry_their_bodies_at_the_right_height() {
    let corner = |x: f64, y: f64| Point3::new(3.0 * x, 3.0 * y, 0.0);
    let ground = Shape::ground();
    let mesh = Shape::Mesh {
        vertices: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let block = Shape::Box { half_extents: Vector3::new(0.3, 0.3, 0.1) };
    let tetrahedron = |margin: f64| Shape::Hull {
        points: vec![
            Point3::new(-0.3, -0.3, -0.1),
            Point3::new(0.3, -0.3, -0.1),
            Point3::new(0.0, 0.3, -0.1),
            Point3::new(0.0, 0.0, 0.3),
        ],
        margin,
    };
    let cylinder = |along| Shape::Cylinder { radius: 0.2, length: 0.6, along };
    let capsule = |along| Shape::Capsule { radius: 0.2, length: 0.6, along };
    let cases = [
        ("box on plane", &ground, block.clone(), 0.1),
        ("ball on plane", &ground, Shape::Sphere { radius: 0.2 }, 0.2),
        ("hull on plane", &ground, tetrahedron(0.0), 0.1),
        ("rounded hull on plane", &ground, tetrahedron(0.04), 0.14),
        ("standing cylinder on plane", &ground, cylinder(Lengthwise::Z), 0.3),
        ("lying cylinder on plane", &ground, cylinder(Lengthwise::X), 0.2),
        ("other lying cylinder on plane", &ground, cylinder(Lengthwise::Y), 0.2),
        ("lying capsule on plane", &ground, capsule(Lengthwise::X), 0.2),
        ("standing capsule on plane", &ground, capsule(Lengthwise::Z), 0.5),
        ("box on mesh", &mesh, block.clone(), 0.1),
        ("ball on mesh", &mesh, Shape::Sphere { radius: 0.2 }, 0.2),
        ("hull on mesh", &mesh, tetrahedron(0.04), 0.14),
        ("cylinder on mesh", &mesh, cylinder(Lengthwise::Z), 0.3),
        ("capsule on mesh", &mesh, capsule(Lengthwise::X), 0.2),
    ];
    for (what, below, above, height) in cases {
        let mut world = world(-G * Vector3::z(), 0.01);
        let below = world.add_shape(below).unwrap();
        let above = world.add_shape(&above).unwrap();
        world.add_body(&Body::fixed(below, Isometry3::identity())).unwrap();
        let body = world.add_body(&Body::dynamic(above, 1.0, at(0.0, 0.0, height + 0.05))).unwrap();
        steps(&mut world, 200);
        // 5 cm fallen, 2 s ago: the rest of contact_erp's corrections.
        assert_near(what, position(&world, body).z, height, 1e-5);
    }
}

#[test]
fn a_resting_box_stands_on_four_corners_that_carry_its_weight() {
    let (dt, mass) = (0.01, 2.0);
    let (mut world, ground) = grounded(dt, still_ground);
    let shape = cuboid(&mut world, 0.3, 0.2, 0.1);
    let body = world.add_body(&Body::dynamic(shape, mass, at(0.0, 0.0, 0.1))).unwrap();
    steps(&mut world, 100);
    let contacts = contacts(&world);
    assert_eq!(contacts.len(), 4);
    for contact in &contacts {
        // From b to a: up if the box is a.
        let up = match (contact.a, contact.b) {
            (a, b) if (a, b) == (body, ground) => 1.0,
            (a, b) if (a, b) == (ground, body) => -1.0,
            other => panic!("a contact between {other:?}"),
        };
        assert_all_near("normal", contact.normal.into(), up * Vector3::z(), EPS);
        assert_near("distance", contact.distance, 0.0, 1e-3);
        assert_near("x", contact.point[0].abs(), 0.3, 1e-3);
        assert_near("y", contact.point[1].abs(), 0.2, 1e-3);
    }
    let weight = mass * G * dt;
    let carried: f64 = contacts.iter().map(|contact| contact.impulse).sum();
    assert_near("carried", carried, weight, 5e-3 * weight);
}

#[test]
fn a_plane_gives_one_contact_point_a_step_and_a_slab_gives_all_corners_at_once() {
    let landing = |ground: &Shape, pose: Isometry3<f64>| {
        let mut world = world(-G * Vector3::z(), 0.01);
        let ground = world.add_shape(ground).unwrap();
        world.add_body(&Body::fixed(ground, pose)).unwrap();
        let shape = cuboid(&mut world, 0.3, 0.2, 0.1);
        world.add_body(&Body::dynamic(shape, 1.0, at(0.0, 0.0, 0.1))).unwrap();
        world.step().unwrap();
        contacts(&world).len()
    };
    assert_eq!(landing(&Shape::ground(), Isometry3::identity()), 1);
    let slab = Shape::Box { half_extents: Vector3::new(1.0, 1.0, 0.1) };
    assert_eq!(landing(&slab, at(0.0, 0.0, -0.1)), 4);
}

#[test]
fn a_resting_body_falls_asleep_after_two_seconds_and_a_push_wakes_it() {
    let run = |sleeping: bool| {
        let settings = WorldSettings { sleeping, ..WorldSettings::default() };
        let mut world = World::new(&settings).unwrap();
        let plane = world.add_shape(&Shape::ground()).unwrap();
        let shape = cuboid(&mut world, 0.1, 0.1, 0.1);
        world.add_body(&still_ground(plane)).unwrap();
        let body = world.add_body(&Body::dynamic(shape, 1.0, at(0.0, 0.0, 0.1))).unwrap();
        (world, body)
    };
    let (mut world, body) = run(true);
    steps(&mut world, 190);
    assert!(see(&world, body).awake, "asleep before 2 s");
    steps(&mut world, 30);
    assert!(!see(&world, body).awake, "awake after 2.2 s");
    let height = position(&world, body).z;
    steps(&mut world, 10);
    assert_near("height asleep", position(&world, body).z, height, 0.0);
    world.push(body, Push::Impulse, &Vector3::z(), None).unwrap();
    assert!(see(&world, body).awake);
    world.step().unwrap();
    assert_near("height after the push", position(&world, body).z, height + 0.01, 2e-3);

    let (mut world, body) = run(false);
    steps(&mut world, 400);
    assert!(see(&world, body).awake, "fell asleep, though told not to");
}

#[test]
fn what_sleeps_on_a_body_wakes_when_that_is_put_elsewhere_or_removed() {
    for removed in [false, true] {
        let settings = WorldSettings { sleeping: true, ..WorldSettings::default() };
        let mut world = World::new(&settings).unwrap();
        let plane = world.add_shape(&Shape::ground()).unwrap();
        world.add_body(&still_ground(plane)).unwrap();
        let shape = cuboid(&mut world, 0.2, 0.2, 0.2);
        let lower = world.add_body(&Body::dynamic(shape, 1.0, at(0.0, 0.0, 0.2))).unwrap();
        let upper = world.add_body(&Body::dynamic(shape, 1.0, at(0.0, 0.0, 0.6))).unwrap();
        steps(&mut world, 400);
        assert!(!see(&world, upper).awake);
        if removed {
            world.remove_body(lower).unwrap();
        } else {
            world.set_pose(lower, &at(5.0, 0.0, 0.2)).unwrap();
        }
        steps(&mut world, 100);
        assert!(position(&world, upper).z < 0.3, "it hangs in the air");
    }
}

/// Bullet looks for contacts up to 2 % of the smaller body's radius ahead, a ball's own here.
#[test]
fn a_contact_is_found_as_far_ahead_as_the_smaller_body_is_large() {
    for radius in [0.05, 0.5] {
        // The radius is that of the ball around the bounding box.
        let ahead = 0.02 * 3.0_f64.sqrt() * radius;
        for (gap, found) in [(0.9 * ahead, true), (1.1 * ahead, false)] {
            let mut world = weightless(0.01);
            let plane = world.add_shape(&Shape::ground()).unwrap();
            world.add_body(&still_ground(plane)).unwrap();
            let shape = ball(&mut world, radius);
            world.add_body(&Body::dynamic(shape, 1.0, at(0.0, 0.0, radius + gap))).unwrap();
            steps(&mut world, 1);
            assert_eq!(!contacts(&world).is_empty(), found, "{radius}, {gap}");
        }
    }
}

/// One above the other on the ground: they end in each other, or one on top. A joint that comes and goes
/// makes no difference, and neither does what is put in the place of a removed body.
#[test]
fn what_is_kept_apart_falls_through_each_other() {
    let fallen = |kept: bool| {
        let (mut world, _) = grounded(0.01, still_ground);
        let shape = cuboid(&mut world, 0.2, 0.2, 0.2);
        let lower = world.add_body(&Body::dynamic(shape, 1.0, at(0.0, 0.0, 0.2))).unwrap();
        let upper = world.add_body(&Body::dynamic(shape, 1.0, at(0.0, 0.0, 0.61))).unwrap();
        steps(&mut world, 20);
        let settings = JointKind::Hinge(AxisSettings::free());
        if kept {
            // They touch already.
            world.keep_apart(upper, lower).unwrap();
            let joint = Joint::at(
                &at(0.0, 0.0, 0.4),
                settings,
                (lower, &at(0.0, 0.0, 0.2)),
                (upper, &at(0.0, 0.0, 0.6)),
            );
            let joint = world.add_joint(&joint).unwrap();
            world.remove_joint(joint).unwrap();
        }
        steps(&mut world, 200);
        let height = position(&world, upper).z;
        world.remove_body(upper).unwrap();
        // Likely where the removed one was.
        let next = world.add_body(&Body::dynamic(shape, 1.0, at(0.0, 0.0, 0.61))).unwrap();
        steps(&mut world, 200);
        assert!(position(&world, next).z > 0.55, "it isn't kept apart");
        height
    };
    assert_near("on top", fallen(false), 0.6, 0.01);
    assert_near("within", fallen(true), 0.2, 0.01);
}

/// Along n the farthest point is |a n| from the centre, with the radii a.
#[test]
fn an_ellipsoid_touches_where_its_surface_is() {
    let radii = Vector3::new(0.3, 0.1, 0.5);
    for turn in [[0.0, 0.0, 0.0], [1.57, 0.0, 0.0], [0.4, -0.9, 2.1], [2.0, 1.0, 0.0]] {
        let turn = UnitQuaternion::from_euler_angles(turn[0], turn[1], turn[2]);
        let mut world = weightless(0.01);
        let plane = world.add_shape(&Shape::ground()).unwrap();
        world.add_body(&still_ground(plane)).unwrap();
        let shape = world.add_shape(&Shape::Ellipsoid { radii }).unwrap();
        let down = turn.inverse() * -Vector3::z();
        let stretched = radii.component_mul(&down);
        let height = stretched.norm();
        let gap = 0.001;
        let pose = Isometry3::from_parts(Vector3::new(0.5, 0.0, height + gap).into(), turn);
        let body = world.add_body(&Body::dynamic(shape, 2.0, pose)).unwrap();
        steps(&mut world, 1);
        let contacts = contacts(&world);
        let nearest = contacts.iter().min_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap();
        assert_near("gap", nearest.distance, gap, 20.0 * EPS);
        let lowest = pose * Point3::from(radii.component_mul(&stretched) / height);
        let found = Point3::from(nearest.point);
        assert_near("where", (found.xy() - lowest.xy().coords).coords.norm(), 0.0, 1e-5);
        // Two fifths of the mass, as for a ball; any handbook.
        let (_, inertia) = world.mass_properties(body).unwrap();
        let squares = radii.component_mul(&radii) * (2.0 / 5.0);
        assert_near("inertia", inertia.x, squares.y + squares.z, 10.0 * EPS);
        assert_near("inertia", inertia.z, squares.x + squares.y, 10.0 * EPS);
    }
}

/// Two that fall upon each other: what touches isn't the boxes around them.
#[test]
fn ellipsoids_meet_each_other() {
    let (mut world, _) = grounded(0.01, still_ground);
    let radii = Vector3::new(0.2, 0.2, 0.1);
    let shape = world.add_shape(&Shape::Ellipsoid { radii }).unwrap();
    let mut body = |z: f64| {
        let body = Body {
            friction: 1.0,
            rolling_friction: 0.05,
            ..Body::dynamic(shape, 1.0, at(0.0, 0.0, z))
        };
        world.add_body(&body).unwrap()
    };
    let (lower, upper) = (body(0.1), body(0.31));
    steps(&mut world, 30);
    assert_near("on the ground", position(&world, lower).z, 0.1, 2e-3);
    assert_near("on the other", position(&world, upper).z, 0.3, 4e-3);
}
