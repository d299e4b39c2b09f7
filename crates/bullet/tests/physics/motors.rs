//! What motors are measured to do: force, work, and where the energy goes.

use bullet::{
    Axis, AxisSettings, Body, BodyId, JointId, JointKind, Motor, MotorCommand, MotorState, Spring,
    Stop, World,
};
use bullet::{Joint, Lockstep};
use nalgebra::{Isometry3, Vector3};

use crate::{
    drives::{SHIFTING, TURNING, driven, frame},
    lab::{EPS, G, askew, assert_near, at, ball, cuboid, joint_of, see, weightless, world},
};

const DT: f64 = 0.01;

fn motor_of(world: &World, id: JointId) -> MotorState {
    let mut motors = Vec::new();
    world.read_motors_of(&[id], &mut motors).unwrap();
    motors[0]
}

fn command(joint: JointId, axis: Axis, target_velocity: f64, max_force: f64) -> MotorCommand {
    MotorCommand { joint, axis, target_velocity, max_force }
}

/// A load on a post, under gravity: an arm that is level at 0 and turns up, or a weight that is lifted.
struct Crane {
    world: World,
    load: BodyId,
    joint: JointId,
    axis: Axis,
}

const MASS: f64 = 2.0;
const LENGTH: f64 = 0.5;

impl Crane {
    fn new(class: &str, axis: Axis) -> Self {
        let mut world = world(-G * Vector3::z(), DT);
        world.measure_motors(true);
        let top = at(0.0, 0.0, 1.0);
        let (direction, shape, pose) = if axis.index() < 3 {
            (Vector3::z(), ball(&mut world, 0.05), top)
        } else {
            // A rod: a point mass on a long arm takes the solver far more sweeps.
            (-Vector3::y(), cuboid(&mut world, LENGTH, 0.05, 0.05), top * at(LENGTH, 0.0, 0.0))
        };
        let post = world.add_body(&Body::fixed(shape, top)).unwrap();
        let load = world.add_body(&Body::dynamic(shape, MASS, pose)).unwrap();
        let motor = Motor { target_velocity: 0.0, max_force: 100.0 };
        let (kind, axis) = driven(axis, class, motor);
        let turned = top * frame(axis, direction);
        let joint = Joint::at(&turned, kind, (post, &top), (load, &pose));
        let joint = world.add_joint(&joint).unwrap();
        Self { world, load, joint, axis }
    }

    fn step(&mut self, target_velocity: f64, max_force: f64) -> MotorState {
        let command = command(self.joint, self.axis, target_velocity, max_force);
        self.world.set_motors(&[command]).unwrap();
        self.world.step().unwrap();
        motor_of(&self.world, self.joint)
    }

    /// Of movement and of height, in J.
    fn energy(&self) -> f64 {
        let state = see(&self.world, self.load);
        MASS * G * state.position[2] + self.kinetic(state.linear_velocity, state.angular_velocity)
    }

    fn kinetic(&self, velocity: [f64; 3], spin: [f64; 3]) -> f64 {
        let (_, moments) = self.world.mass_properties(self.load).unwrap();
        // About y in the world, which is a principal axis all the time.
        let spin = Vector3::from(spin);
        0.5 * (MASS * Vector3::from(velocity).norm_squared() + moments.y * spin.norm_squared())
    }
}

#[test]
fn a_motor_that_holds_a_load_carries_its_weight_and_does_no_work() {
    for (class, axis) in TURNING.into_iter().chain(SHIFTING) {
        let mut crane = Crane::new(class, axis);
        let load = if axis.index() < 3 { MASS * G } else { MASS * G * LENGTH };
        for _ in 0..50 {
            let motor = crane.step(0.0, 100.0);
            // Rows that hold the anchor have settled to some parts in ten thousand after 200 sweeps.
            assert_near(&format!("{class} {axis:?}"), motor.force[axis.index()], load, 1e-3 * load);
            assert!(motor.work[axis.index()].abs() < 1e-4, "{motor:?}");
            let others = (0..6).filter(|&other| other != axis.index());
            assert!(others.map(|i| motor.force[i].abs() + motor.work[i].abs()).sum::<f64>() == 0.0);
        }
    }
}

/// Over each step the impulses p of all rows and of gravity change the velocity from v to v', and
/// p v' = change of energy + M (v' - v)^2 / 2: what semi-implicit Euler loses.
#[test]
fn work_is_the_energy_gained_and_what_the_integrator_loses() {
    for (class, axis) in TURNING.into_iter().chain(SHIFTING) {
        let mut crane = Crane::new(class, axis);
        let start = crane.energy();
        let (mut work, mut lost, mut most) = (0.0, 0.0, 0.0_f64);
        for n in 0..60 {
            let before = see(&crane.world, crane.load);
            // Up, held, and half way down.
            let speed = [1.0, 0.0, -0.5][n / 20];
            let done = crane.step(speed, 40.0).work[axis.index()];
            work += done;
            most = most.max(done.abs());
            let after = see(&crane.world, crane.load);
            let change = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| b[i] - a[i]);
            lost += crane.kinetic(
                change(before.linear_velocity, after.linear_velocity),
                change(before.angular_velocity, after.angular_velocity),
            );
        }
        assert!(work > 1.0 && lost > 0.0, "{class} {axis:?}: {work} J, {lost} J");
        // A shifted load has no rows that do work but its motor's: 60 roundings of some 20 J of height.
        // An arm leaves its circle by (w dt)^2 r / 2 = 25 um a step, which the anchor's rows take back
        // against a centrifugal force m w^2 r of 1 N; and it turns about where its weight was.
        let tolerance = if axis.index() < 3 { 60.0 * EPS * 20.0 } else { 0.01 * work };
        let what = format!("{class} {axis:?}, most {most} J a step");
        assert_near(&what, work, crane.energy() - start + lost, tolerance);
    }
}

/// Two free bodies, with a motor that is told something else all the time.
#[test]
fn work_is_force_times_how_far_the_axis_moves() {
    for (class, axis) in TURNING.into_iter().chain(SHIFTING) {
        let mut world = weightless(DT);
        world.measure_motors(true);
        let shape = cuboid(&mut world, 0.1, 0.2, 0.15);
        let (here, there) = (askew(), askew() * at(0.3, 0.1, -0.2));
        let a = world.add_body(&Body::dynamic(shape, 1.0, here)).unwrap();
        let b = world.add_body(&Body::dynamic(shape, 2.0, there)).unwrap();
        let (kind, axis) = driven(axis, class, Motor { target_velocity: 0.0, max_force: 1.0 });
        let joint = Joint::at(&there, kind, (a, &here), (b, &there));
        let joint = world.add_joint(&joint).unwrap();
        let mut position = 0.0;
        for n in 0..100 {
            // From -1 to 1, evenly and never the same.
            let wish = (0.618_034 * f64::from(n)).fract() * 2.0 - 1.0;
            world.set_motors(&[command(joint, axis, wish, 0.5 + wish.abs())]).unwrap();
            world.step().unwrap();
            let now = joint_of(&world, joint).position_of(axis);
            let MotorState { force, work } = motor_of(&world, joint);
            let (force, work) = (force[axis.index()], work[axis.index()]);
            assert!(force.abs() <= (0.5 + wish.abs()) * (1.0 + 4.0 * EPS), "{force} for {wish}");
            // Positions are differences of numbers of about 1, and slide by what a step turns of the
            // frame: 0.02 rad, squared.
            let tolerance = force.abs() * (20.0 * EPS + 5e-4 * (now - position).abs());
            assert_near(&format!("{class} {axis:?}"), work, force * (now - position), tolerance);
            position = now;
        }
    }
}

/// All axes of a 6-dof joint drive, some have springs, some stops, one is locked: each motor's own
/// force is told, which is its limit as long as it can't reach its velocity.
#[test]
fn of_all_rows_of_a_joint_the_motors_own_is_told() {
    let limits = [1.0, 2.0, 3.0, 0.4, 0.5, 0.6];
    let mut world = weightless(DT);
    world.measure_motors(true);
    let shape = ball(&mut world, 0.1);
    let zero = Isometry3::identity();
    let post = world.add_body(&Body::fixed(shape, zero)).unwrap();
    let inertia = Some(Vector3::repeat(1.0));
    let load = world.add_body(&Body { inertia, ..Body::dynamic(shape, 1.0, zero) }).unwrap();
    let mut axes = limits.map(|max_force| AxisSettings {
        motor: Some(Motor { target_velocity: 100.0, max_force }),
        ..AxisSettings::free()
    });
    let spring = Some(Spring { stiffness: 3.0, damping: 0.1, equilibrium: -0.1 });
    for (axis, range) in
        [(0, AxisSettings::limited(-1.0, 1.0)), (3, AxisSettings::limited(-1.0, 1.0))]
    {
        axes[axis] = AxisSettings { range: range.range, spring, ..axes[axis] };
    }
    axes[1].spring = spring;
    axes[4].spring = spring;
    let kind = JointKind::SixDofSpring(Box::new(axes));
    let joint = world.add_joint(&Joint::at(&zero, kind, (post, &zero), (load, &zero))).unwrap();
    for _ in 0..10 {
        world.step().unwrap();
        let MotorState { force, work } = motor_of(&world, joint);
        for (axis, limit) in limits.into_iter().enumerate() {
            assert_near(&format!("axis {axis}"), force[axis], limit, 4.0 * EPS * limit);
            assert!(work[axis] > 0.0, "axis {axis}: {work:?}");
        }
    }
}

/// Pressed against a stop a motor has no more than its own force, and moves nothing.
#[test]
fn a_motor_at_a_stop_does_no_work() {
    for (class, axis) in TURNING.into_iter().chain(SHIFTING) {
        let mut world = weightless(DT);
        world.measure_motors(true);
        let shape = ball(&mut world, 0.1);
        let zero = Isometry3::identity();
        let post = world.add_body(&Body::fixed(shape, zero)).unwrap();
        let load = world.add_body(&Body::dynamic(shape, 1.0, zero)).unwrap();
        let (mut kind, axis) = driven(axis, class, Motor { target_velocity: 1.0, max_force: 5.0 });
        // A stop that takes back all of an overshoot at once.
        let stop = Stop { erp: Some(1.0), ..Stop::BULLET };
        let range = AxisSettings::limited(-0.2, 0.2).range;
        let hold = |it: &mut AxisSettings| {
            if it.motor.is_some() {
                *it = AxisSettings { range, stop, ..*it };
            }
        };
        match &mut kind {
            JointKind::Hinge(it) => hold(it),
            JointKind::Slider { linear, angular, .. } => {
                [linear, angular].into_iter().for_each(hold)
            }
            JointKind::SixDofSpring(axes) => axes.iter_mut().for_each(hold),
            _ => {}
        }
        let joint = world.add_joint(&Joint::at(&zero, kind, (post, &zero), (load, &zero))).unwrap();
        let mut work = 0.0;
        for n in 0..100 {
            world.step().unwrap();
            let motor = motor_of(&world, joint);
            assert!(motor.force[axis.index()].abs() <= 5.0 * (1.0 + 4.0 * EPS), "{motor:?}");
            if n >= 50 {
                work += motor.work[axis.index()];
            }
        }
        // A slider's end gives and takes: within what the motor does in a step at its speed.
        assert!(work.abs() < 5.0 * 1.0 * DT, "{class} {axis:?}: {work} J");
    }
}

#[test]
fn measuring_changes_nothing_and_is_of_the_last_step_alone() {
    let mut cranes = [false, true].map(|measure| {
        let mut crane = Crane::new("hinge", Axis::AngularZ);
        crane.world.measure_motors(measure);
        crane
    });
    let mut bytes = [Vec::new(), Vec::new()];
    for _ in 0..20 {
        for (crane, bytes) in cranes.iter_mut().zip(&mut bytes) {
            let command = command(crane.joint, crane.axis, 0.5, 30.0);
            crane.world.set_motors(&[command]).unwrap();
            crane.world.step().unwrap();
            crane.world.snapshot(bytes).unwrap();
        }
        assert!(bytes[0] == bytes[1]);
    }
    let [_, crane] = &mut cranes;
    assert!(motor_of(&crane.world, crane.joint).work[5] > 0.0);
    crane.world.restore(&bytes[0]).unwrap();
    assert_eq!(motor_of(&crane.world, crane.joint), MotorState::default());
    crane.world.step().unwrap();
    let alone = motor_of(&crane.world, crane.joint);
    crane.world.restore(&bytes[0]).unwrap();
    let mut results = Vec::new();
    Lockstep::new().unwrap().step(&mut [&mut crane.world], &mut results).unwrap();
    assert_eq!(motor_of(&crane.world, crane.joint), alone);
    assert!(alone.work[5] > 0.0);
}
