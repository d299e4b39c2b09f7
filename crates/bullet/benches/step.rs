//! What the crate costs: a world stepped through it, with all states of bodies, joints and
//! contacts read after each step, against plain C++ on Bullet's own API that steps the same scene
//! and reads nothing.
//!
//! The scene is a crawling walker with 21 bodies and 20 joints. The C++ program
//! (`tests/reference/walker.cc`) is a child process that makes steps on demand and times them
//! itself. Both are in the same state after every block of steps, to the bit, or the benchmark
//! fails. The last line printed is the one that counts: single timings wander with the machine's
//! load, the ratio of neighbouring blocks doesn't. `cargo bench -p bullet -- none` prints it alone.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../tests/reference/mod.rs"]
mod reference;

use std::{
    hint::black_box,
    io::{BufRead, BufReader, Write},
    path::Path,
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
    time::{Duration, Instant},
};

use bullet::{
    Axis, AxisSettings, Body, BodyId, BodyState, Contact, Joint, JointId, JointKind, JointState,
    Lengthwise, Motor, MotorCommand, SCALAR_BYTES, Shape, Spring, Stop, World, WorldSettings,
};
use criterion::Criterion;
use nalgebra::{Isometry3, Vector3};

/// Few steps, and many blocks: most then fit between two interruptions by other programs.
const BLOCK: u64 = 10;
const BLOCKS: usize = 400;

fn main() {
    let program = reference::compile("walker.cc", SCALAR_BYTES, SCALAR_BYTES)
        .unwrap_or_else(|error| panic!("{error}"));
    check_same_bits(&program);

    let mut criterion = Criterion::default().sample_size(20).configure_from_args();
    let mut walker = Walker::new();
    criterion.bench_function("crate, step and read all", |bencher| {
        bencher.iter_custom(|steps| walker.advance(steps));
    });
    let mut plain = Plain::new(&program);
    criterion.bench_function("plain C++, step", |bencher| {
        bencher.iter_custom(|steps| plain.advance(steps).0);
    });
    criterion.final_summary();

    // Not when `cargo test --benches` only sees whether all this runs.
    if std::env::args().any(|argument| argument == "--bench") {
        compare(&program);
    }
}

fn check_same_bits(program: &Path) {
    let (mut walker, mut plain) = (Walker::new(), Plain::new(program));
    for step in 0..200 {
        walker.advance(1);
        assert!(walker.bits() == plain.advance(1).1, "other bits after step {step}");
    }
}

/// Both by turns, in alternating order, over the same stretches of the same trajectory.
fn compare(program: &Path) {
    let (mut walker, mut plain) = (Walker::new(), Plain::new(program));
    let mut ratios = Vec::new();
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for block in 0..BLOCKS {
        let (our_time, (their_time, their_bits)) = if block % 2 == 0 {
            let first = walker.advance(BLOCK);
            (first, plain.advance(BLOCK))
        } else {
            let first = plain.advance(BLOCK);
            (walker.advance(BLOCK), first)
        };
        assert!(walker.bits() == their_bits, "other bits after block {block}");
        let per_step = |time: Duration| time.as_nanos() as f64 / BLOCK as f64;
        ours.push(per_step(our_time));
        theirs.push(per_step(their_time));
        ratios.push(our_time.as_secs_f64() / their_time.as_secs_f64());
    }
    println!(
        "crate / plain C++: {:.3} (median of {BLOCKS} alternating blocks; ns per step {:.0} / {:.0})",
        median(ratios),
        median(ours),
        median(theirs)
    );
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The C++ program, which replies to a number of steps with a line: nanoseconds, then all numbers
/// of all bodies.
struct Plain {
    process: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

impl Plain {
    fn new(program: &Path) -> Self {
        let mut process = Command::new(program)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("{program:?}: {error}"));
        let to = process.stdin.take().unwrap();
        let from = BufReader::new(process.stdout.take().unwrap());
        Self { process, to, from }
    }

    fn advance(&mut self, steps: u64) -> (Duration, Vec<u64>) {
        writeln!(self.to, "{steps}").unwrap();
        let mut reply = String::new();
        self.from.read_line(&mut reply).unwrap();
        let mut numbers = reply.split_whitespace();
        let elapsed = Duration::from_nanos(numbers.next().unwrap().parse().unwrap());
        (elapsed, numbers.map(|number| number.parse::<f64>().unwrap().to_bits()).collect())
    }
}

impl Drop for Plain {
    fn drop(&mut self) {
        // Closing its stdin would end it as well, but fields are dropped after this.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The scene of `tests/reference/walker.cc`.
struct Walker {
    world: World,
    legs: Vec<[JointId; 3]>,
    steps: usize,
    commands: Vec<MotorCommand>,
    bodies: Vec<BodyState>,
    joints: Vec<JointState>,
    contacts: Vec<Contact>,
}

impl Walker {
    fn new() -> Self {
        let mut world = World::new(&WorldSettings::default()).unwrap();
        let legs = build(&mut world);
        Self {
            world,
            legs,
            steps: 0,
            commands: Vec::new(),
            bodies: Vec::new(),
            joints: Vec::new(),
            contacts: Vec::new(),
        }
    }

    fn advance(&mut self, steps: u64) -> Duration {
        let start = Instant::now();
        for _ in 0..steps {
            if self.steps.is_multiple_of(10) {
                self.turn_motors();
            }
            self.world.step().unwrap();
            self.steps += 1;
            self.world.read_bodies(&mut self.bodies).unwrap();
            self.world.read_joints(&mut self.joints).unwrap();
            self.world.read_contacts(&mut self.contacts).unwrap();
            black_box((&self.bodies, &self.joints, &self.contacts));
        }
        start.elapsed()
    }

    /// Neighbouring legs move in turns.
    fn turn_motors(&mut self) {
        self.commands.clear();
        let square = |step: usize| if (step / 40).is_multiple_of(2) { 1.0 } else { -1.0 };
        for (i, [hip, knee, ankle]) in self.legs.iter().enumerate() {
            let turn = if matches!(i % 4, 0 | 3) { 1.0 } else { -1.0 };
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            let mut command = |joint: &JointId, axis, size: f64, ahead| {
                let target_velocity = size * turn * side * square(self.steps + ahead);
                let (joint, max_force) = (*joint, TORQUE);
                self.commands.push(MotorCommand { joint, axis, target_velocity, max_force });
            };
            command(hip, Axis::AngularX, 0.5, 0);
            command(hip, Axis::AngularZ, 1.0, 20);
            command(knee, Axis::AngularX, 1.5, 0);
            command(ankle, Axis::AngularX, 1.0, 10);
        }
        self.world.set_motors(&self.commands).unwrap();
    }

    /// Of all numbers of all bodies, as `reference/plain.h` reads them.
    fn bits(&self) -> Vec<u64> {
        let numbers = |body: &BodyState| {
            [&body.position[..], &body.rotation, &body.linear_velocity, &body.angular_velocity]
                .concat()
        };
        self.bodies.iter().flat_map(numbers).map(f64::to_bits).collect()
    }
}

/// The most that a motor has, in N m.
const TORQUE: f64 = 15.0;

/// Hip, knee and ankle of each leg.
fn build(world: &mut World) -> Vec<[JointId; 3]> {
    let at = Isometry3::translation;
    let mut shape = |shape: Shape| world.add_shape(&shape).unwrap();
    let cuboid = |x, y, z| Shape::Box { half_extents: Vector3::new(x, y, z) };
    let capsule = |length, along| Shape::Capsule { radius: 0.03, length, along };
    let ground = shape(Shape::ground());
    let trunk = shape(cuboid(0.35, 0.1, 0.05));
    let end = shape(cuboid(0.05, 0.08, 0.05));
    let coxa = shape(capsule(0.06, Lengthwise::Y));
    let femur = shape(capsule(0.14, Lengthwise::Y));
    let tibia = shape(capsule(0.2, Lengthwise::Z));

    let motor = Some(Motor { target_velocity: 0.0, max_force: TORQUE });
    let spring = Some(Spring { stiffness: 2.0, damping: 0.05, equilibrium: 0.0 });
    let locked = AxisSettings::locked();
    let swing = |farthest: f64| AxisSettings {
        motor,
        spring,
        ..AxisSettings::limited(-farthest, farthest)
    };
    let hip =
        JointKind::SixDofSpring(Box::new([locked, locked, locked, swing(0.3), locked, swing(0.5)]));
    let bend = AxisSettings {
        motor,
        stop: Stop { erp: Some(1.0), cfm: Some(0.0), bounce: None },
        ..AxisSettings::limited(-0.4, 0.4)
    };
    let knee = JointKind::Slider { linear: locked, angular: bend, held: Stop::BULLET };

    let mut add = |body: Body| world.add_body(&body).unwrap();
    add(Body { friction: 1.0, ..Body::fixed(ground, Isometry3::identity()) });
    let trunk = add(Body::dynamic(trunk, 2.0, at(0.0, 0.0, 0.3)));
    let head = add(Body::dynamic(end, 0.3, at(0.42, 0.0, 0.3)));
    let tail = add(Body::dynamic(end, 0.3, at(-0.42, 0.0, 0.3)));
    let mut sides = Vec::new();
    for x in [-0.25, 0.0, 0.25] {
        for side in [1.0, -1.0] {
            let coxa = add(Body::dynamic(coxa, 0.2, at(x, side * 0.17, 0.3)));
            let femur = add(Body::dynamic(femur, 0.2, at(x, side * 0.33, 0.3)));
            let tibia = Body::dynamic(tibia, 0.2, at(x, side * 0.43, 0.18));
            sides.push((x, side, [coxa, femur, add(Body { friction: 1.0, ..tibia })]));
        }
    }

    let mut join = |kind: &JointKind, (parent, frame_in_parent), (child, frame_in_child)| {
        let (kind, collide_connected) = (kind.clone(), false);
        let joint =
            Joint { kind, parent, child, frame_in_parent, frame_in_child, collide_connected };
        world.add_joint(&joint).unwrap()
    };
    join(&JointKind::Fixed, (trunk, at(0.35, 0.0, 0.0)), (head, at(-0.07, 0.0, 0.0)));
    join(&JointKind::Fixed, (trunk, at(-0.35, 0.0, 0.0)), (tail, at(0.07, 0.0, 0.0)));
    let mut leg = |(x, side, [coxa, femur, tibia]): (f64, f64, [BodyId; 3])| {
        let along = |y| at(0.0, side * y, 0.0);
        [
            join(&hip, (trunk, at(x, side * 0.11, 0.0)), (coxa, along(-0.06))),
            join(&knee, (coxa, along(0.06)), (femur, along(-0.1))),
            join(&knee, (femur, along(0.1)), (tibia, at(0.0, 0.0, 0.12))),
        ]
    };
    sides.into_iter().map(&mut leg).collect()
}
