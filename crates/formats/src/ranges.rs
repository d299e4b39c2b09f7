//! How far axes move: ranges that a model can have, and the pose that the robot is drawn in for it.

use std::f64::consts::{PI, TAU};

use crate::{
    compound,
    names::quoted,
    robot::{Axis, Motion, Robot},
    xml::Log,
};

/// Of an axis that slides without end, in m.
const FARTHEST_M: f64 = 100.0;

/// Of a model file.
const STIFFEST: f64 = 1e9;

/// Of the second of three axes that turn, in rad: short of a right angle, which they can't pass.
const STEEPEST_RAD: f64 = 89.0 * PI / 180.0;

/// Gives all axes ranges around the drawing's zero, in which the robot is redrawn where it's outside.
pub(crate) fn mend(robot: &mut Robot, log: &Log) {
    for joint in 0..robot.joints.len() {
        leave_out_misfits(robot, joint, log);
        for axis in (0..robot.joints[joint].axes.len()).rev() {
            mend_axis(robot, joint, axis, log);
        }
        // One that was fixed where it's turned may have left the others askew.
        leave_out_misfits(robot, joint, log);
        bound_the_second(&mut robot.joints[joint].axes, log);
    }
}

fn mend_axis(robot: &mut Robot, joint: usize, index: usize, log: &Log) {
    let name = shown_name(robot, joint, index);
    let axis = &mut robot.joints[joint].axes[index];
    bound_resistance(axis, log);
    let is_turn = axis.motion == Motion::Turns;
    if let Some([lower, upper]) = axis.range
        && lower > upper
    {
        log.chose("a lower limit above the upper: the two change places", &quoted(&name));
        axis.range = Some([upper, lower]);
    }
    let turns_on = |[lower, upper]: [f64; 2]| upper - lower >= TAU - 1e-6;
    if is_turn && axis.range.is_some_and(turns_on) {
        log.chose("limits a full turn apart or more: turns without end", &quoted(&name));
        axis.range = None;
    }
    if !is_turn {
        let endless = |[lower, upper]: [f64; 2]| upper - lower > 2.0 * FARTHEST_M;
        if axis.range.is_none_or(endless) {
            log.chose(&format!("a slide without limits: {FARTHEST_M} m both ways"), &quoted(&name));
            axis.range = Some([-FARTHEST_M, FARTHEST_M]);
        }
    }
    let Some([lower, upper]) = axis.range else { return };
    // A thousandth of a degree, or a hundredth of a millimetre.
    if upper - lower < 1e-5 {
        log.chose("limits that leave no way: fixed there", &quoted(&name));
        robot.redraw(joint, index, lower);
        remove_axis(robot, joint, index);
        return;
    }
    let beyond = is_turn && (lower < -PI || upper > PI);
    let outside = lower > 0.0 || upper < 0.0 || beyond;
    if outside && Some(index) == second_of_three(&robot.joints[joint].axes) {
        log.chose(
            "the second of three axes, whose range hasn't 0 in it: 0 is in it",
            &quoted(&name),
        );
        robot.joints[joint].axes[index].range = Some([lower.clamp(-PI, 0.0), upper.clamp(0.0, PI)]);
    } else if outside {
        redraw_inside(robot, joint, index, log);
    }
    if let Axis { range: Some([lower, upper]), spring: Some(spring), .. } =
        &mut robot.joints[joint].axes[index]
        && !(*lower..=*upper).contains(&spring.rest)
    {
        log.chose("a spring at rest outside the range: at its end", &quoted(&name));
        spring.rest = spring.rest.clamp(*lower, *upper);
    }
}

/// Keeps damping, friction and stiffness within what a model file takes.
fn bound_resistance(axis: &mut Axis, log: &Log) {
    let stiffness = axis.spring.as_mut().map(|spring| &mut spring.stiffness);
    for value in [&mut axis.damping, &mut axis.friction].into_iter().chain(stiffness) {
        if !(0.0..=STIFFEST).contains(value) {
            log.chose(
                "damping, friction or stiffness that no model has",
                &format!("{value} is 0 to {STIFFEST:e}"),
            );
            *value = value.clamp(0.0, STIFFEST);
        }
    }
}

/// A range without 0 in it is drawn in its middle, where commands begin; one that reaches beyond half
/// a turn as near to 0 as leaves half a turn both ways.
fn redraw_inside(robot: &mut Robot, joint: usize, index: usize, log: &Log) {
    let name = shown_name(robot, joint, index);
    let axis = &robot.joints[joint].axes[index];
    let Some([lower, upper]) = axis.range else { return };
    let (position, what) = if lower > 0.0 || upper < 0.0 {
        (f64::midpoint(lower, upper), "a range without 0 in it: drawn in its middle")
    } else {
        let near = 0.0_f64.clamp(upper - PI, lower + PI);
        (near, "a range beyond 180°: drawn nearer to its middle")
    };
    let shown = match axis.motion {
        Motion::Turns => format!("{:.1}°", position.to_degrees()),
        Motion::Slides => format!("{position} m"),
    };
    log.chose(what, &format!("'{}' at {shown}", config::shown(&name)));
    robot.redraw(joint, index, position);
}

/// The middle one, if three axes of a joint turn: turned, it would leave the others askew.
fn second_of_three(axes: &[Axis]) -> Option<usize> {
    let mut turns = (0..axes.len()).filter(|axis| axes[*axis].motion == Motion::Turns);
    let second = turns.nth(1)?;
    turns.next().map(|_| second)
}

/// Of an axis for people.
pub(crate) fn shown_name(robot: &Robot, joint: usize, axis: usize) -> String {
    let joint = &robot.joints[joint];
    match joint.axes[axis].name.as_str() {
        "" => joint.name.clone(),
        own => own.into(),
    }
}

fn remove_axis(robot: &mut Robot, joint: usize, axis: usize) {
    robot.joints[joint].axes.remove(axis);
    robot.actuators.retain(|driven| *driven != [joint, axis]);
    for driven in &mut robot.actuators {
        if driven[0] == joint && driven[1] > axis {
            driven[1] -= 1;
        }
    }
}

/// Axes that can't be in one joint with those before them.
fn leave_out_misfits(robot: &mut Robot, joint: usize, log: &Log) {
    let kept = compound::fitting(&robot.joints[joint].axes);
    for axis in (0..robot.joints[joint].axes.len()).rev().filter(|axis| !kept.contains(axis)) {
        let place = robot.joints[joint].place.clone();
        log.left_out(
            "an axis that is no part of one joint with those before it (askew or apart)",
            place,
        );
        remove_axis(robot, joint, axis);
    }
}

/// Where three axes turn, the second keeps off the right angle.
fn bound_the_second(axes: &mut [Axis], log: &Log) {
    let Some(second) = second_of_three(axes) else { return };
    let second = &mut axes[second];
    let [lower, upper] = second.range.unwrap_or([-PI, PI]);
    if lower < -STEEPEST_RAD || upper > STEEPEST_RAD {
        log.chose(
            "the second of three axes in a joint: 89° both ways at most",
            &quoted(&second.name),
        );
        second.range = Some([lower.max(-STEEPEST_RAD), upper.min(STEEPEST_RAD)]);
        if let Some(spring) = &mut second.spring {
            spring.rest = spring.rest.clamp(-STEEPEST_RAD, STEEPEST_RAD);
        }
    }
}
