//! The crate's trajectories are Bullet's own, bit for bit.
//!
//! `reference/chain.cc` builds a scene on Bullet's API alone, with the signs and units of Bullet's
//! classes. Here the same scene is built through the crate, number by number, and every body must
//! have the same bits after every step: the crate's conventions, defaults, reading and joint
//! feedback add nothing. Contacts make the scene chaotic, so one wrong bit soon is in all numbers.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod reference;

use std::{array, collections::BTreeSet, f64::consts::FRAC_1_SQRT_2, process::Command};

use bullet::{
    Axis, AxisSettings, Body, BodyId, BodyState, Contact, Joint, JointId, JointKind, JointState,
    Lengthwise, Motor, MotorCommand, Push, SCALAR_BYTES, Shape, ShapeId, Spring, Stop, World,
    WorldSettings,
};
use nalgebra::{Isometry3, Point3, Quaternion, UnitQuaternion, Vector3};

const STEPS: usize = 2000;
/// Numbers of a body's state, as `reference/plain.h` writes them.
const NUMBERS: usize = 18;

#[test]
fn every_body_has_the_bits_of_plain_bullet_after_every_step() {
    let program = reference::compile("chain.cc", SCALAR_BYTES, SCALAR_BYTES)
        .unwrap_or_else(|error| panic!("{error}"));
    let output = Command::new(&program).output().unwrap();
    assert!(output.status.success(), "{program:?}: {}", output.status);
    let expected: Vec<f64> =
        output.stdout.as_chunks().0.iter().map(|bytes| f64::from_ne_bytes(*bytes)).collect();

    let mut chain = Chain::new();
    let mut bodies = Vec::new();
    chain.world.read_bodies(&mut bodies).unwrap();
    assert_eq!(expected.len(), STEPS * bodies.len() * NUMBERS, "numbers from chain.cc");
    for (step, expected) in expected.chunks(bodies.len() * NUMBERS).enumerate() {
        chain.advance(step, &bodies);
        chain.world.read_bodies(&mut bodies).unwrap();
        for (slot, (body, expected)) in bodies.iter().zip(expected.chunks(NUMBERS)).enumerate() {
            for ((number, ours), theirs) in numbers(body).iter().enumerate().zip(expected) {
                assert!(
                    ours.to_bits() == theirs.to_bits(),
                    "after step {step}, body {slot}, {}: {ours:?}, and plain Bullet has {theirs:?}",
                    name(number)
                );
            }
        }
    }
}

/// What makes the test above worth something: all that it should cover does happen. The bounds are
/// far below what the scene does, and far above what it would do lying still.
#[test]
fn the_scene_is_lively() {
    let mut chain = Chain::new();
    let mut bodies = Vec::new();
    let mut joints = Vec::new();
    let mut contacts = Vec::new();
    let mut touching = BTreeSet::new();
    let (mut made, mut broken, mut made_above_ground, mut last_made) = (0, 0, 0, 0);
    let mut at_lower_limit = [0; 6];
    let mut at_upper_limit = [0; 6];
    chain.world.read_bodies(&mut bodies).unwrap();
    for step in 0..STEPS {
        chain.advance(step, &bodies);
        chain.world.read_bodies(&mut bodies).unwrap();
        chain.world.read_joints(&mut joints).unwrap();
        chain.world.read_contacts(&mut contacts).unwrap();

        let pressing = |contact: &&Contact| contact.impulse > 0.0;
        let pairs: BTreeSet<(BodyId, BodyId)> =
            contacts.iter().filter(pressing).map(|contact| (contact.a, contact.b)).collect();
        let moving = |pair: &&(BodyId, BodyId)| pair.0 != chain.ground && pair.1 != chain.ground;
        made += pairs.difference(&touching).count();
        made_above_ground += pairs.difference(&touching).filter(moving).count();
        broken += touching.difference(&pairs).count();
        if pairs.difference(&touching).next().is_some() {
            last_made = step;
        }
        touching = pairs;

        for (i, (joint, axis, lower, upper)) in chain.limited.iter().enumerate() {
            let state: &JointState = &joints[joint.index()];
            // Bullet's 6-dof motors slow down to stop just short of a limit.
            let nearly = 1e-3;
            at_lower_limit[i] += usize::from(state.position_of(*axis) <= *lower + nearly);
            at_upper_limit[i] += usize::from(state.position_of(*axis) >= *upper - nearly);
        }
        for (slot, body) in bodies.iter().enumerate().skip(1) {
            assert!(body.awake, "body {slot} sleeps after step {step}");
            // A fall from the greatest height in the scene ends at 4 m/s.
            let speed = Vector3::from(body.linear_velocity).norm();
            assert!(speed < 20.0, "body {slot} flies off at {speed} m/s after step {step}");
        }
    }
    assert!(made > 200 && broken > 200, "{made} contacts made, {broken} broken");
    assert!(last_made > STEPS - 100, "no contact was made after step {last_made}");
    assert!(made_above_ground > 20, "{made_above_ground} contacts made between moving bodies");
    assert!(at_lower_limit.iter().all(|&steps| steps > 5), "lower limits: {at_lower_limit:?}");
    assert!(at_upper_limit.iter().all(|&steps| steps > 5), "upper limits: {at_upper_limit:?}");
}

fn numbers(body: &BodyState) -> [f64; NUMBERS] {
    array::from_fn(|i| match i {
        0..3 => body.position[i],
        3..12 => body.rotation[i - 3],
        12..15 => body.linear_velocity[i - 12],
        _ => body.angular_velocity[i - 15],
    })
}

fn name(number: usize) -> String {
    let axis = ["x", "y", "z"][number % 3];
    match number {
        0..3 => format!("position {axis}"),
        3..12 => format!("rotation row {} column {}", number / 3 - 1, number % 3),
        12..15 => format!("linear velocity {axis}"),
        _ => format!("angular velocity {axis}"),
    }
}

/// The scene of `reference/chain.cc`.
struct Chain {
    world: World,
    ground: BodyId,
    /// From its head to the wheel.
    links: [BodyId; 9],
    elbow: JointId,
    piston: JointId,
    knee: JointId,
    hip: JointId,
    wheel: JointId,
    /// Axes with a lower and an upper limit.
    limited: [(JointId, Axis, f64, f64); 6],
}

/// Quaternions x, y, z, w that turn z to y, x to z, z to x.
const Z_TO_Y: [f64; 4] = [-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];
const X_TO_Z: [f64; 4] = [0.0, -FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2];
const Z_TO_X: [f64; 4] = [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2];
const UNTURNED: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

const BEFORE: [f64; 3] = [-0.15, 0.0, 0.0];
const BEHIND: [f64; 3] = [0.15, 0.0, 0.0];

/// Not normalised: nalgebra would round it again.
fn pose(position: [f64; 3], rotation: [f64; 4]) -> Isometry3<f64> {
    let rotation = UnitQuaternion::new_unchecked(Quaternion::from(rotation));
    Isometry3::from_parts(Point3::from(position).into(), rotation)
}

fn at(position: [f64; 3]) -> Isometry3<f64> {
    pose(position, UNTURNED)
}

/// 1 and -1 by turns, for `half` steps each.
fn square(step: usize, half: usize) -> f64 {
    if (step / half).is_multiple_of(2) { 1.0 } else { -1.0 }
}

impl Chain {
    fn new() -> Self {
        let mut world = World::new(&WorldSettings::default()).unwrap();
        let (ground, links) = add_bodies(&mut world);
        let mut join = |kind: JointKind, parent: usize, frame_in_parent, frame_in_child| {
            let (parent, child) = (links[parent], links[parent + 1]);
            // The wheel is the one that may touch what it's joined to.
            let collide_connected = child == links[8];
            let joint =
                Joint { kind, parent, child, frame_in_parent, frame_in_child, collide_connected };
            world.add_joint(&joint).unwrap()
        };
        let motor = |max_force| Some(Motor { target_velocity: 0.0, max_force });

        join(JointKind::Fixed, 0, at(BEHIND), at(BEFORE));
        join(JointKind::PointToPoint, 1, at(BEHIND), at(BEFORE));

        let bend = AxisSettings { motor: motor(1.5), ..AxisSettings::limited(-0.7, 0.4) };
        let elbow = join(JointKind::Hinge(bend), 2, pose(BEHIND, Z_TO_Y), pose(BEFORE, Z_TO_Y));

        let thrust = AxisSettings {
            motor: motor(12.0),
            stop: Stop { erp: Some(0.25), cfm: Some(0.001), bounce: None },
            ..AxisSettings::limited(-0.05, 0.08)
        };
        let slider = JointKind::Slider {
            linear: thrust,
            angular: AxisSettings::locked(),
            held: Stop::BULLET,
        };
        let piston = join(slider, 3, at(BEHIND), at(BEFORE));

        let bend = AxisSettings {
            motor: motor(2.5),
            stop: Stop { erp: Some(1.0), cfm: Some(0.0), bounce: None },
            ..AxisSettings::limited(-0.5, 0.9)
        };
        let held = Stop { erp: Some(0.6), cfm: Some(0.0005), bounce: None };
        let slider = JointKind::Slider { linear: AxisSettings::locked(), angular: bend, held };
        let knee = join(slider, 4, pose(BEHIND, X_TO_Z), pose(BEFORE, X_TO_Z));

        let hip = JointKind::SixDofSpring(Box::new([
            AxisSettings::locked(),
            AxisSettings::locked(),
            AxisSettings {
                motor: motor(20.0),
                spring: Some(Spring { stiffness: 60.0, damping: 2.0, equilibrium: 0.01 }),
                ..AxisSettings::limited(-0.04, 0.06)
            },
            AxisSettings { motor: motor(0.5), ..AxisSettings::free() },
            AxisSettings {
                spring: Some(Spring { stiffness: 1.5, damping: 0.02, equilibrium: 0.2 }),
                ..AxisSettings::limited(-0.4, 0.6)
            },
            AxisSettings {
                motor: motor(2.0),
                stop: Stop { erp: Some(0.7), cfm: Some(0.0001), bounce: Some(0.2) },
                ..AxisSettings::limited(-0.3, 0.7)
            },
        ]));
        let tilt = [0.0, 0.28, 0.0, 0.96];
        let hip = join(hip, 5, pose(BEHIND, tilt), pose(BEFORE, tilt));

        let swing = AxisSettings {
            stop: Stop { erp: Some(0.8), cfm: Some(0.0002), bounce: Some(0.3) },
            ..AxisSettings::limited(-0.8, 0.6)
        };
        let tail = join(JointKind::Hinge(swing), 6, at(BEHIND), pose([0.0, 0.0, -0.15], X_TO_Z));

        let roll = AxisSettings { motor: motor(1.0), ..AxisSettings::free() };
        let axle = pose([0.0, 0.1, 0.15], [-0.5, -0.5, -0.5, 0.5]);
        let wheel = join(JointKind::Hinge(roll), 7, axle, pose([0.0; 3], Z_TO_Y));

        let limited = [
            (elbow, Axis::AngularZ, -0.7, 0.4),
            (piston, Axis::LinearX, -0.05, 0.08),
            (knee, Axis::AngularX, -0.5, 0.9),
            (hip, Axis::LinearZ, -0.04, 0.06),
            (hip, Axis::AngularZ, -0.3, 0.7),
            (tail, Axis::AngularZ, -0.8, 0.6),
        ];
        Self { world, ground, links, elbow, piston, knee, hip, wheel, limited }
    }

    fn advance(&mut self, step: usize, bodies: &[BodyState]) {
        let command = |joint, axis, target_velocity, max_force| MotorCommand {
            joint,
            axis,
            target_velocity,
            max_force,
        };
        let commands = [
            command(self.elbow, Axis::AngularZ, 2.5 * square(step, 70), 1.5),
            command(self.piston, Axis::LinearX, 0.6 * square(step, 45), 12.0),
            command(self.knee, Axis::AngularX, 3.0 * square(step, 110), 2.5),
            command(self.hip, Axis::LinearZ, 0.4 * square(step, 35), 20.0),
            command(self.hip, Axis::AngularX, 2.0 * square(step, 150), 0.5),
            command(self.hip, Axis::AngularZ, 1.5 * square(step, 60), 2.0),
            command(
                self.wheel,
                Axis::AngularZ,
                8.0 * square(step, 240),
                1.25 + 0.75 * square(step, 130),
            ),
        ];
        self.world.set_motors(&commands).unwrap();

        let mut push = |link: usize, kind, vector, point: Option<Point3<f64>>| {
            self.world.push(self.links[link], kind, &vector, point.as_ref()).unwrap();
        };
        if step % 200 < 90 {
            let along = Vector3::new(45.0 * square(step, 400), 0.0, 6.0);
            let across = Vector3::new(0.0, 45.0 * square(step, 800), 6.0);
            let [x, y, z] = bodies[self.links[0].index()].position;
            let force = if (step / 200).is_multiple_of(2) { along } else { across };
            push(0, Push::Force, force, Some(Point3::new(x + 0.02, y, z + 0.05)));
        }
        if step % 170 < 5 {
            push(5, Push::Torque, Vector3::new(4.0, -3.0, 5.0), None);
        }
        if step % 230 == 100 {
            push(8, Push::Impulse, Vector3::new(-0.5, 0.3, 2.5), None);
        }
        if step % 310 == 200 {
            push(3, Push::AngularImpulse, Vector3::new(0.1, -0.05, 0.15), None);
        }
        self.world.step().unwrap();
    }
}

fn add_bodies(world: &mut World) -> (BodyId, [BodyId; 9]) {
    let mut shape = |shape: Shape| world.add_shape(&shape).unwrap();
    let cuboid = |x, y, z| Shape::Box { half_extents: Vector3::new(x, y, z) };
    let ball = |radius| Shape::Sphere { radius };
    let capsule = |radius, length, along| Shape::Capsule { radius, length, along };
    let cylinder = |radius, length, along| Shape::Cylinder { radius, length, along };

    let ground = shape(Shape::ground());
    let corners = [
        [0.12, 0.0, -0.03],
        [-0.06, 0.09, -0.03],
        [-0.06, -0.09, -0.03],
        [0.04, 0.02, 0.07],
        [-0.04, 0.05, 0.06],
        [-0.05, -0.04, 0.05],
    ];
    let hull = shape(Shape::Hull { points: corners.map(Point3::from).to_vec(), margin: 0.01 });
    let children = vec![
        (shape(cuboid(0.07, 0.05, 0.04)), pose([-0.04, 0.0, 0.0], [0.0, 0.0, 0.6, 0.8])),
        (shape(ball(0.06)), at([0.07, 0.02, -0.01])),
    ];
    let compound = shape(Shape::Compound { children });

    let head = shape(cuboid(0.12, 0.1, 0.08));
    let neck = shape(ball(0.08));
    let upper_arm = shape(capsule(0.05, 0.14, Lengthwise::X));
    let lower_arm = shape(cylinder(0.06, 0.18, Lengthwise::X));
    let pelvis = shape(cuboid(0.1, 0.07, 0.05));
    let tail = shape(capsule(0.06, 0.1, Lengthwise::Z));
    let wheel = shape(cylinder(0.12, 0.08, Lengthwise::Y));
    let loose_box = shape(cuboid(0.1, 0.1, 0.1));
    let loose_ball = shape(ball(0.1));
    let loose_cylinder = shape(cylinder(0.08, 0.24, Lengthwise::Z));

    let mut add = |body: Body| world.add_body(&body).unwrap();
    let link = |shape: ShapeId, mass, x| Body::dynamic(shape, mass, at([x, 0.0, 0.4]));
    let ground = add(Body { friction: 0.8, restitution: 0.5, ..Body::fixed(ground, at([0.0; 3])) });
    let links = [
        add(Body {
            inertia: Some(Vector3::new(0.006, 0.008, 0.01)),
            friction: 0.7,
            ..link(head, 1.0, 0.0)
        }),
        add(Body {
            restitution: 0.4,
            rolling_friction: 0.01,
            spinning_friction: 0.02,
            ..link(neck, 0.6, 0.3)
        }),
        add(Body { linear_damping: 0.05, angular_damping: 0.1, ..link(upper_arm, 0.5, 0.6) }),
        add(link(lower_arm, 0.8, 0.9)),
        add(link(hull, 0.7, 1.2)),
        add(link(compound, 0.9, 1.5)),
        add(link(pelvis, 0.4, 1.8)),
        add(Body::dynamic(tail, 0.6, pose([2.1, 0.0, 0.4], Z_TO_X))),
        add(Body { friction: 1.2, ..Body::dynamic(wheel, 0.5, at([2.25, 0.1, 0.4])) }),
    ];
    add(Body::dynamic(loose_box, 0.5, at([0.4, 0.12, 0.1])));
    add(Body {
        restitution: 0.9,
        rolling_friction: 0.02,
        ..Body::dynamic(loose_ball, 0.3, at([1.2, 0.05, 0.8]))
    });
    let tilted = pose([1.9, -0.35, 0.3], [0.6, 0.0, 0.0, 0.8]);
    add(Body::dynamic(loose_cylinder, 0.5, tilted));
    (ground, links)
}
