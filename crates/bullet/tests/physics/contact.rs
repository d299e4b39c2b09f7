//! Collisions, resting, sleeping; where what touches.

use bullet::{
    AxisSettings, Body, BodyId, CollisionFilter, Joint, JointKind, Lengthwise, Push, Shape, Stop,
    World, WorldSettings,
};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use crate::lab::{
    EPS, G, assert_all_near, assert_near, at, ball, contacts, cuboid, grounded, position, see,
    spin, steps, still_ground, velocity, weightless, world,
};

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
