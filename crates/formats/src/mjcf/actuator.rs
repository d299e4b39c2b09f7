//! Actuators: what MuJoCo does with a control signal, as a motor of an axis.

use crate::{
    robot::{Motor, MotorKind, Robot},
    xml::{Element, Log},
};

use super::defaults::Defaults;

/// Where an actuator's joint is.
pub(super) type Found = [usize; 2];

/// Gives an axis its motor, or says that the actuator was left out.
pub(super) fn read(
    written: &Element,
    defaults: &Defaults,
    find: impl Fn(&str) -> Option<Found>,
    robot: &mut Robot,
    log: &Log,
) {
    let element = defaults.apply(written, "main", log);
    // What all kinds have in common can be in the defaults of the general one.
    let general = defaults.apply(&element.renamed("general"), "main", log);
    let element = general.renamed(&written.name);
    let kind = element.name.as_str();
    let joint = element.get("joint").or(element.get("jointinparent"));
    let Some(joint) = joint else {
        log.left_out(&format!("actuator/{kind} of something else than a joint"), element.place());
        return;
    };
    let Some([joint, axis]) = find(joint) else {
        let message = format!(
            "joint of <{kind}> must be the name of a <joint>, got \"{}\"",
            config::shown(joint)
        );
        log.problem(config::Problem { place: element.place_of("joint"), message });
        return;
    };
    let Some((motor, reversed)) = motor(&element, robot, [joint, axis], log) else {
        log.left_out(&format!("actuator/{kind}"), element.place());
        return;
    };
    let moved = &mut robot.joints[joint].axes[axis];
    if moved.motor.is_some() {
        log.left_out(&format!("actuator/{kind} of a joint that has one"), element.place());
        return;
    }
    moved.motor = Some(motor);
    moved.reversed = reversed;
    robot.actuators.push([joint, axis]);
}

/// The motor, and whether a higher signal means a lower position.
fn motor(
    element: &Element,
    robot: &Robot,
    [joint, axis]: Found,
    log: &Log,
) -> Option<(Motor, bool)> {
    let gear = element.list("gear", log).and_then(|list| list.first().copied()).unwrap_or(1.0);
    let largest = |name: &str| {
        let limited = match name {
            "ctrlrange" => element.get("ctrllimited"),
            _ => element.get("forcelimited"),
        };
        let [lower, upper] = element.numbers(name, log)?;
        (limited != Some("false")).then_some(lower.abs().max(upper.abs())).filter(|it| *it > 0.0)
    };
    let (control, force) = (largest("ctrlrange"), largest("forcerange"));
    let law = Law::of(element, log)?;
    let range = robot.joints[joint].axes[axis].range;
    let gear_ratio = gear.abs();
    let effort = |own: Option<f64>| match (own, force) {
        (Some(own), Some(force)) => Some(own.min(force) * gear_ratio),
        (own, force) => own.or(force).map(|effort| effort * gear_ratio),
    };
    let motor = match law {
        Law::Torque { gain } => Motor {
            kind: MotorKind::Torque,
            speed: None,
            effort: effort(control.map(|control| control * gain.abs())),
        },
        Law::Position { stiffness } => {
            // What it pulls with from the middle of the range to its end.
            let half = range.map_or(1.0, |[lower, upper]| (upper - lower) / 2.0);
            let own = (stiffness > 0.0).then_some(stiffness * half * gear_ratio);
            let effort = force.map(|force| force * gear_ratio).or(own.map(|it| it * gear_ratio));
            Motor { kind: MotorKind::Position, speed: None, effort }
        }
        Law::Speed { damping } => {
            let speed = control.filter(|_| gear != 0.0).map(|control| control / gear_ratio);
            let own = control.map(|control| control * damping);
            Motor { kind: MotorKind::Speed, speed, effort: effort(own) }
        }
    };
    let gain = if let Law::Torque { gain } = law { gain } else { 1.0 };
    let above_0 = |it: Option<f64>| it.filter(|it| *it > 0.0);
    let motor = Motor { speed: above_0(motor.speed), effort: above_0(motor.effort), ..motor };
    Some((motor, gear * gain < 0.0))
}

/// How force comes from the control signal.
#[derive(Clone, Copy, Debug)]
enum Law {
    Torque { gain: f64 },
    Position { stiffness: f64 },
    Speed { damping: f64 },
}

impl Law {
    /// `None` of muscles and others that have states of their own.
    fn of(element: &Element, log: &Log) -> Option<Self> {
        let number = |name: &str, default: f64| element.number(name, log).unwrap_or(default);
        match element.name.as_str() {
            "motor" => Some(Self::Torque { gain: 1.0 }),
            "position" | "intvelocity" => Some(Self::Position { stiffness: number("kp", 1.0) }),
            "velocity" => Some(Self::Speed { damping: number("kv", 1.0) }),
            "general" => {
                let dynamics = element.get("dyntype").unwrap_or("none");
                if !["none", "filter", "filterexact"].contains(&dynamics) {
                    return None;
                }
                if !["fixed", "affine"].contains(&element.get("gaintype").unwrap_or("fixed")) {
                    return None;
                }
                let list = |name| element.list(name, log).unwrap_or_default();
                let gain = list("gainprm").first().copied().unwrap_or(1.0);
                let bias = list("biasprm");
                let bias = |i: usize| bias.get(i).copied().unwrap_or_default();
                match element.get("biastype").unwrap_or("none") {
                    "none" => Some(Self::Torque { gain }),
                    "affine" if bias(1) != 0.0 => Some(Self::Position { stiffness: -bias(1) }),
                    "affine" if bias(2) != 0.0 => Some(Self::Speed { damping: -bias(2) }),
                    "affine" => Some(Self::Torque { gain }),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}
