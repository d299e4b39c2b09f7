//! Motors as servos: those with the same limits are one, and what a file leaves open is chosen.

use crate::{
    robot::{Motion, Motor, MotorKind, Robot},
    xml::Log,
};

/// Of a motor without a speed limit: about a turn a second; one that is told torques isn't slowed.
const SPEED_RAD_S: f64 = 6.0;
const TORQUE_MOTOR_RAD_S: f64 = 30.0;
const SPEED_M_S: f64 = 1.0;
const FORCE_MOTOR_M_S: f64 = 10.0;

/// In m/s^2.
const GRAVITY: f64 = 9.81;

/// Bounds of a limit in a model file, less what is nonsense.
const LEAST: f64 = 1e-9;
const MOST: f64 = 1e9;

/// A kind of motor.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Servo {
    pub(crate) name: String,
    pub(crate) kind: MotorKind,
    pub(crate) motion: Motion,
    pub(crate) speed: f64,
    pub(crate) effort: f64,
}

/// The servos of a robot in the order of its joints, and the index of each axis'.
pub(crate) struct Servos {
    pub(crate) list: Vec<Servo>,
    of: Vec<Vec<Option<usize>>>,
}

impl Servos {
    pub(crate) fn of(robot: &Robot, log: &Log) -> Self {
        let mut servos = Self { list: Vec::new(), of: Vec::new() };
        let weight_n = robot.mass_kg() * GRAVITY;
        let reach_m = reach_m(robot);
        for joint in &robot.joints {
            let axes = joint.axes.iter();
            let own = axes.map(|axis| {
                let motor = axis.motor?;
                Some(servos.index(&motor, axis.motion, weight_n, reach_m, log))
            });
            let own = own.collect();
            servos.of.push(own);
        }
        servos.name();
        servos
    }

    pub(crate) fn name_of(&self, joint: usize, axis: usize) -> Option<&str> {
        self.of[joint][axis].map(|index| self.list[index].name.as_str())
    }

    fn index(
        &mut self,
        motor: &Motor,
        motion: Motion,
        weight_n: f64,
        reach_m: f64,
        log: &Log,
    ) -> usize {
        let given = |limit: Option<f64>| limit.filter(|limit| (LEAST..=MOST).contains(limit));
        let turns = motion == Motion::Turns;
        let (unit, force_unit) = if turns { ("rad/s", "N m") } else { ("m/s", "N") };
        let speed = given(motor.speed).unwrap_or_else(|| {
            let speed = match (motor.kind, turns) {
                (MotorKind::Torque, true) => TORQUE_MOTOR_RAD_S,
                (MotorKind::Torque, false) => FORCE_MOTOR_M_S,
                (_, true) => SPEED_RAD_S,
                (_, false) => SPEED_M_S,
            };
            log.chose("the speed limit of a motor that has none", &format!("{speed} {unit}"));
            speed
        });
        let effort = given(motor.effort).unwrap_or_else(|| {
            let effort = weight_n * if turns { reach_m } else { 1.0 };
            let effort = three_digits(effort).clamp(LEAST, MOST);
            let how =
                if turns { "the robot's weight at half its size" } else { "the robot's weight" };
            let what = format!(
                "the {} limit of a motor that has none",
                if turns { "torque" } else { "force" }
            );
            log.chose(&what, &format!("{effort} {force_unit}: {how}"));
            effort
        });
        let servo = Servo { name: String::new(), kind: motor.kind, motion, speed, effort };
        let known = self.list.iter().position(|other| *other == servo);
        known.unwrap_or_else(|| {
            self.list.push(servo);
            self.list.len() - 1
        })
    }

    /// After what tells them apart: the limit of torque, and that of speed where it takes that, too.
    fn name(&mut self) {
        let short = |servo: &Servo| {
            let kind = match servo.kind {
                MotorKind::Position => "",
                MotorKind::Speed => "speed, ",
                MotorKind::Torque => "torque, ",
            };
            let unit = if servo.motion == Motion::Turns { "N m" } else { "N" };
            format!("{kind}{} {unit}", three_digits(servo.effort))
        };
        let long = |servo: &Servo| {
            let unit = if servo.motion == Motion::Turns { "rad" } else { "m" };
            format!("{} at {} {unit} per s", short(servo), three_digits(servo.speed))
        };
        let shorts: Vec<_> = self.list.iter().map(short).collect();
        let longs: Vec<_> = self.list.iter().map(long).collect();
        for (i, servo) in self.list.iter_mut().enumerate() {
            let once =
                |names: &[String]| names.iter().filter(|name| **name == names[i]).count() == 1;
            servo.name = match (once(&shorts), once(&longs)) {
                (true, _) => shorts[i].clone(),
                (false, true) => longs[i].clone(),
                // Alike in three digits.
                (false, false) => format!("{}, kind {}", longs[i], i + 1),
            };
        }
    }
}

fn three_digits(number: f64) -> f64 {
    format!("{number:.2e}").parse().unwrap_or(number)
}

/// Half the size of a robot, from centre to centre of its links, in m.
fn reach_m(robot: &Robot) -> f64 {
    let centres: Vec<_> =
        robot.links.iter().filter_map(|link| Some(link.pose * link.inertial?.centre_m)).collect();
    let extent = |i: usize| {
        let all = centres.iter().map(|centre| centre[i]);
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), it| {
            (low.min(it), high.max(it))
        });
        (high - low).max(0.0)
    };
    let largest = (0..3).map(extent).fold(0.0, f64::max);
    if largest > 1e-3 { largest / 2.0 } else { 0.1 }
}
