//! The one convention of all joints (`src/joint.rs`), against geometry: signs, frames, limits,
//! motors, springs, stops and reactions of each kind.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use bullet::{
    Axis, AxisSettings, Body, BodyId, BodyState, Joint, JointId, JointKind, JointState, Motor,
    MotorCommand, Push, SCALAR_BYTES, Shape, Spring, Stop, World, WorldSettings,
};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

/// Distance of 1 from the next number, in Bullet's precision.
const EPS: f64 = if SCALAR_BYTES == 8 { f64::EPSILON } else { f32::EPSILON as f64 };
const DT: f64 = 0.01;
/// What btHingeConstraint multiplies its stop's erp and bounce by, a float in both precisions.
const HINGE_BIAS: f64 = 0.3_f32 as f64;

/// The classes of joints that have ranges, motors and stops.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Class {
    Hinge,
    Slider,
    SixDof,
}

/// Each of their axes.
const DRIVEN: [(Class, Axis); 9] = [
    (Class::Hinge, Axis::AngularZ),
    (Class::Slider, Axis::LinearX),
    (Class::Slider, Axis::AngularX),
    (Class::SixDof, Axis::LinearX),
    (Class::SixDof, Axis::LinearY),
    (Class::SixDof, Axis::LinearZ),
    (Class::SixDof, Axis::AngularX),
    (Class::SixDof, Axis::AngularY),
    (Class::SixDof, Axis::AngularZ),
];

/// A joint that lets one axis move, the others locked.
fn kind((class, axis): (Class, Axis), settings: AxisSettings) -> JointKind {
    let locked = AxisSettings::locked();
    match (class, axis) {
        (Class::Hinge, _) => JointKind::Hinge(settings),
        (Class::Slider, Axis::LinearX) => {
            JointKind::Slider { linear: settings, angular: locked, held: Stop::BULLET }
        }
        (Class::Slider, _) => {
            JointKind::Slider { linear: locked, angular: settings, held: Stop::BULLET }
        }
        (Class::SixDof, _) => {
            let mut axes = [locked; 6];
            axes[axis.index()] = settings;
            JointKind::SixDofSpring(Box::new(axes))
        }
    }
}

fn is_angular(axis: Axis) -> bool {
    axis.index() >= 3
}

/// The child's frame seen from the parent's, at these six positions: R = Rz Ry Rx.
fn placed(position: [f64; 6]) -> Isometry3<f64> {
    let [x, y, z, roll, pitch, yaw] = position;
    let turn = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
    Isometry3::from_parts(
        Translation3::new(x, y, z),
        turn(Vector3::z_axis(), yaw)
            * turn(Vector3::y_axis(), pitch)
            * turn(Vector3::x_axis(), roll),
    )
}

fn along(axis: Axis, value: f64) -> [f64; 6] {
    let mut position = [0.0; 6];
    position[axis.index()] = value;
    position
}

/// Poses with nothing special about them: of the parent, and of the joint's frame in each body.
fn askew() -> [Isometry3<f64>; 3] {
    let pose = |x, y, z, a, b, c| {
        Isometry3::from_parts(
            Translation3::new(x, y, z),
            UnitQuaternion::from_euler_angles(a, b, c),
        )
    };
    [
        pose(0.4, -0.3, 0.8, 0.7, -0.4, 2.5),
        pose(0.2, 0.1, -0.3, -1.9, 0.6, 0.3),
        pose(-0.1, 0.25, 0.15, 0.5, 1.2, -0.8),
    ]
}

/// Two bodies and a joint between them in a world without gravity.
struct Pair {
    world: World,
    parent: BodyId,
    child: BodyId,
    joint: JointId,
    frames: [Isometry3<f64>; 2],
}

const MASS: f64 = 2.0;
const MOMENT: f64 = 0.5;

impl Pair {
    /// The joint begins with its axes at `start`. With a `parent_mass` the parent moves; its
    /// moment is a quarter of it.
    fn new(
        settings: &WorldSettings,
        kind: JointKind,
        [parent_pose, in_parent, in_child]: [Isometry3<f64>; 3],
        parent_mass: Option<f64>,
        start: [f64; 6],
    ) -> Self {
        let mut world = World::new(settings).unwrap();
        let shape = world.add_shape(&Shape::Sphere { radius: 0.1 }).unwrap();
        let body = |mass: f64, pose| Body {
            inertia: Some(Vector3::repeat(mass / MASS * MOMENT)),
            ..Body::dynamic(shape, mass, pose)
        };
        let parent = match parent_mass {
            Some(mass) => body(mass, parent_pose),
            None => Body::fixed(shape, parent_pose),
        };
        let child = body(MASS, parent_pose * in_parent * placed(start) * in_child.inverse());
        let parent = world.add_body(&parent).unwrap();
        let child = world.add_body(&child).unwrap();
        let joint = Joint {
            kind,
            parent,
            child,
            frame_in_parent: in_parent,
            frame_in_child: in_child,
            collide_connected: false,
        };
        let joint = world.add_joint(&joint).unwrap();
        Self { world, parent, child, joint, frames: [in_parent, in_child] }
    }

    /// Frames at the bodies' centres, the parent fixed.
    fn centred(kind: JointKind, start: [f64; 6]) -> Self {
        Self::new(&weightless(), kind, [Isometry3::identity(); 3], None, start)
    }

    fn state(&self) -> JointState {
        let mut joints = Vec::new();
        self.world.read_joints(&mut joints).unwrap();
        joints[self.joint.index()]
    }

    fn body(&self, id: BodyId) -> BodyState {
        let mut bodies = Vec::new();
        self.world.read_bodies(&mut bodies).unwrap();
        bodies[id.index()]
    }

    /// Gives the child the velocity that moves one axis; the frames must be at the centres and
    /// the parent at rest at the origin.
    fn set_speed(&mut self, axis: Axis, speed: f64) {
        let mut vectors = [Vector3::zeros(); 2];
        vectors[axis.index() / 3][axis.index() % 3] = speed;
        self.world.set_velocity(self.child, &vectors[0], &vectors[1]).unwrap();
    }

    fn steps(&mut self, count: u32) {
        for _ in 0..count {
            self.world.step().unwrap();
        }
    }
}

fn weightless() -> WorldSettings {
    WorldSettings { gravity: Vector3::zeros(), time_step: DT, ..WorldSettings::default() }
}

#[track_caller]
fn assert_near(what: &str, got: f64, expected: f64, tolerance: f64) {
    assert!(
        (got - expected).abs() <= tolerance,
        "{what}: {got} is {:e} from {expected}, more than {tolerance:e}",
        got - expected
    );
}

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
