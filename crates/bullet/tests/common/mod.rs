//! A scene with everything in it, and the bits of what it does.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used)]

use bullet::{
    Axis, AxisSettings, Body, BodyId, BodyState, Contact, Joint, JointId, JointKind, JointState,
    Lengthwise, Motor, MotorCommand, MotorState, Push, Range, Shape, ShapeId, Spring, Stop, World,
    WorldSettings,
};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

/// A heap of all shapes falling onto a plane, a mesh and each other, pushed by a kinematic paddle,
/// and a driven chain of all kinds of joints falling with them.
pub struct Playground {
    pub world: World,
    heap: Vec<BodyId>,
    paddle: BodyId,
    motors: Vec<(JointId, Axis)>,
}

impl Playground {
    pub fn new(settings: &WorldSettings) -> Self {
        let mut world = World::new(settings).unwrap();
        build_ground(&mut world);
        let heap = build_heap(&mut world);
        let paddle = {
            let shape = world
                .add_shape(&Shape::Box { half_extents: Vector3::new(0.05, 0.6, 0.3) })
                .unwrap();
            world.add_body(&Body::kinematic(shape, paddle_pose(0))).unwrap()
        };
        let motors = build_chain(&mut world);
        Self { world, heap, paddle, motors }
    }

    /// Square waves for all motors.
    pub fn motor_commands(&self) -> Vec<MotorCommand> {
        let forward = (self.world.steps() / 25).is_multiple_of(2);
        let target_velocity = if forward { 2.0 } else { -2.0 };
        let command =
            |&(joint, axis)| MotorCommand { joint, axis, target_velocity, max_force: 20.0 };
        self.motors.iter().map(command).collect()
    }

    /// One step, with the commands that belong to its number.
    pub fn step(&mut self) {
        self.prepare();
        self.world.step().unwrap();
    }

    /// The commands of the next step.
    pub fn prepare(&mut self) {
        let n = self.world.steps();
        let commands = self.motor_commands();
        self.world.set_motors(&commands).unwrap();
        self.world.set_pose(self.paddle, &paddle_pose(n)).unwrap();
        if n % 40 == 20 {
            let body = self.heap[(n / 40) as usize % self.heap.len()];
            let force = Vector3::new(3.0, -20.0, 150.0);
            self.world.push(body, Push::Force, &force, None).unwrap();
        }
    }

    pub fn run(&mut self, steps: u32) {
        for _ in 0..steps {
            self.step();
        }
    }
}

/// Swings to and fro through the heap.
fn paddle_pose(step: u64) -> Isometry3<f64> {
    let phase = (step % 200) as f64 / 200.0;
    let x = if phase < 0.5 { -1.2 + 4.0 * phase } else { 2.8 - 4.0 * phase };
    Isometry3::translation(x, 0.0, 0.35)
}

fn build_ground(world: &mut World) {
    let plane = world.add_shape(&Shape::ground()).unwrap();
    world.add_body(&Body { friction: 1.0, ..Body::fixed(plane, Isometry3::identity()) }).unwrap();
    // A low pyramid.
    let mesh = world
        .add_shape(&Shape::Mesh {
            vertices: vec![
                Point3::new(-1.0, -1.0, 0.0),
                Point3::new(1.0, -1.0, 0.0),
                Point3::new(1.0, 1.0, 0.0),
                Point3::new(-1.0, 1.0, 0.0),
                Point3::new(0.1, 0.0, 0.3),
            ],
            triangles: vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
        })
        .unwrap();
    world.add_body(&Body { friction: 0.7, ..Body::fixed(mesh, Isometry3::identity()) }).unwrap();
}

fn build_heap(world: &mut World) -> Vec<BodyId> {
    let shapes = all_solid_shapes(world);
    (0..3 * shapes.len())
        .map(|i| {
            let angle = i as f64;
            let pose = Isometry3::from_parts(
                Translation3::new(
                    0.25 * (2.4 * angle).cos(),
                    0.25 * (2.4 * angle).sin(),
                    0.6 + 0.2 * angle,
                ),
                UnitQuaternion::from_euler_angles(angle, 0.7 * angle, 0.3 * angle),
            );
            world
                .add_body(&Body {
                    friction: 0.8,
                    restitution: 0.3,
                    rolling_friction: if i % 2 == 0 { 0.01 } else { 0.0 },
                    linear_damping: 0.05,
                    ..Body::dynamic(shapes[i % shapes.len()], 0.5 + 0.1 * angle, pose)
                })
                .unwrap()
        })
        .collect()
}

fn all_solid_shapes(world: &mut World) -> Vec<ShapeId> {
    let mut add = |shape: Shape| world.add_shape(&shape).unwrap();
    let cube = add(Shape::Box { half_extents: Vector3::new(0.15, 0.1, 0.12) });
    let ball = add(Shape::Sphere { radius: 0.12 });
    let capsule = add(Shape::Capsule { radius: 0.08, length: 0.2, along: Lengthwise::X });
    let cylinder = add(Shape::Cylinder { radius: 0.1, length: 0.2, along: Lengthwise::Z });
    let hull = add(Shape::Hull {
        points: vec![
            Point3::new(0.15, 0.0, -0.1),
            Point3::new(-0.1, 0.13, -0.1),
            Point3::new(-0.1, -0.13, -0.1),
            Point3::new(0.0, 0.0, 0.15),
        ],
        margin: 0.02,
    });
    let dumbbell = add(Shape::Compound {
        children: vec![
            (cube, Isometry3::translation(-0.2, 0.0, 0.0)),
            (ball, Isometry3::translation(0.2, 0.0, 0.0)),
            (capsule, Isometry3::identity()),
        ],
    });
    let cross = add(Shape::Compound {
        children: vec![
            (capsule, Isometry3::identity()),
            (capsule, Isometry3::rotation(Vector3::z() * std::f64::consts::FRAC_PI_2)),
        ],
    });
    vec![cube, ball, capsule, cylinder, hull, dumbbell, cross]
}

fn build_chain(world: &mut World) -> Vec<(JointId, Axis)> {
    let motor = Some(Motor { target_velocity: 0.0, max_force: 20.0 });
    let stop = Stop { erp: Some(1.0), cfm: Some(0.0), bounce: None };
    let driven = AxisSettings { motor, stop, ..AxisSettings::limited(-0.8, 0.6) };
    let sprung = AxisSettings {
        spring: Some(Spring { stiffness: 30.0, damping: 0.5, equilibrium: 0.2 }),
        range: Range::Limited { lower: -1.0, upper: 1.0 },
        ..driven
    };
    let locked = AxisSettings::locked();
    let kinds = [
        JointKind::Fixed,
        JointKind::Hinge(driven),
        JointKind::PointToPoint,
        JointKind::Slider { linear: locked, angular: driven, held: Stop::BULLET },
        JointKind::Slider {
            linear: AxisSettings { motor, ..AxisSettings::limited(-0.05, 0.05) },
            angular: locked,
            held: stop,
        },
        JointKind::SixDofSpring(Box::new([locked, locked, locked, driven, locked, sprung])),
    ];
    let link = world
        .add_shape(&Shape::Capsule { radius: 0.06, length: 0.2, along: Lengthwise::Y })
        .unwrap();
    let pose = |i: usize| Isometry3::translation(1.5, 0.35 * i as f64 - 1.0, 0.5);
    let mut parent =
        world.add_body(&Body { friction: 1.0, ..Body::dynamic(link, 1.0, pose(0)) }).unwrap();
    let mut motors = Vec::new();
    for (i, kind) in kinds.into_iter().enumerate() {
        let child = world
            .add_body(&Body { friction: 1.0, ..Body::dynamic(link, 1.0, pose(i + 1)) })
            .unwrap();
        let axes: &[_] = match i {
            1 => &[Axis::AngularZ],
            3 => &[Axis::AngularX],
            4 => &[Axis::LinearX],
            5 => &[Axis::AngularX, Axis::AngularZ],
            _ => &[],
        };
        let frame = pose(i) * Isometry3::translation(0.0, 0.175, 0.0);
        let joint = Joint::at(&frame, kind, (parent, &pose(i)), (child, &pose(i + 1)));
        let id = world.add_joint(&joint).unwrap();
        motors.extend(axes.iter().map(|&axis| (id, axis)));
        parent = child;
    }
    motors
}

/// All that can be read of a world, to be compared bit for bit.
#[derive(Debug, Default)]
pub struct Readings {
    pub bodies: Vec<BodyState>,
    pub joints: Vec<JointState>,
    pub contacts: Vec<Contact>,
    /// Of all joints that are there; none where motors aren't measured.
    pub motors: Vec<MotorState>,
    ids: Vec<JointId>,
}

impl Readings {
    pub fn of(world: &World) -> Self {
        let mut readings = Self::default();
        readings.read(world);
        readings
    }

    pub fn read(&mut self, world: &World) {
        world.read_bodies(&mut self.bodies).unwrap();
        world.read_joints(&mut self.joints).unwrap();
        world.read_contacts(&mut self.contacts).unwrap();
        let slots = (0..).map(|slot| JointId { slot }).zip(&self.joints);
        self.ids.clear();
        self.ids.extend(slots.filter(|(_, joint)| joint.exists).map(|(id, _)| id));
        if world.read_motors_of(&self.ids, &mut self.motors).is_err() {
            self.motors.clear();
        }
    }

    /// Every number's bits, so that NaN and the sign of zero count.
    pub fn bits(&self) -> Vec<u64> {
        let bodies = self.bodies.iter().flat_map(|b| {
            [&b.position[..], &b.rotation, &b.linear_velocity, &b.angular_velocity].concat()
        });
        let joints = self
            .joints
            .iter()
            .flat_map(|j| [&j.position[..], &j.velocity, &j.force, &j.torque].concat());
        let contacts = self.contacts.iter().flat_map(|c| {
            let pair = [f64::from(c.a.slot), f64::from(c.b.slot), c.distance, c.impulse];
            [&pair[..], &c.point, &c.normal, &c.friction_impulse].concat()
        });
        let motors = self.motors.iter().flat_map(|m| [m.force, m.work].concat());
        bodies.chain(joints).chain(contacts).chain(motors).map(f64::to_bits).collect()
    }
}

/// The bits of all readings of `steps` steps.
pub fn trajectory(playground: &mut Playground, steps: u32) -> Vec<Vec<u64>> {
    (0..steps)
        .map(|_| {
            playground.step();
            Readings::of(&playground.world).bits()
        })
        .collect()
}

/// Asserts equality with a message that doesn't print a million numbers.
pub fn assert_same(one: &[Vec<u64>], other: &[Vec<u64>], what: &str) {
    assert_eq!(one.len(), other.len(), "{what}: number of steps");
    for (step, (a, b)) in one.iter().zip(other).enumerate() {
        assert_eq!(a.len(), b.len(), "{what}: number of readings in step {step}");
        let different = a.iter().zip(b).filter(|(a, b)| a != b).count();
        assert_eq!(different, 0, "{what}: {different} readings differ in step {step}");
    }
}
