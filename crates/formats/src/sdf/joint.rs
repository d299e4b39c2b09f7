//! Joints of an SDF model, with their axes.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Unit, Vector3};

use super::Reader;
use crate::{
    robot::{Axis, Joint, Motion, Motor, MotorKind, Spring, ball},
    xml::{Element, LARGEST, Log},
};

impl<'a> Reader<'a> {
    pub(super) fn joint(
        &mut self,
        element: &'a Element,
        scope: &str,
        names: &BTreeMap<String, usize>,
    ) {
        let log = self.log;
        let Some(name) = element.get("name") else { return };
        let full = format!("{scope}{name}");
        let types = [
            "revolute",
            "continuous",
            "prismatic",
            "fixed",
            "ball",
            "universal",
            "revolute2",
            "screw",
            "gearbox",
        ];
        element.required("type", log);
        let Some(kind) = element.word("type", &types, log) else { return };
        if kind == "gearbox" {
            log.left_out("joint of type gearbox", element.place());
            return;
        }
        let end = |end: &str| {
            let Some(found) = element.child(end) else {
                log.problem(element.problem(format!("<joint> must have a <{end}>, got none")));
                return None;
            };
            if found.text == "world" {
                return Some(None);
            }
            let link = self.link_of(&format!("{scope}{}", found.text), names);
            if link.is_none() {
                self.unknown(found, &found.text, scope);
            }
            link.map(Some)
        };
        let (Some(parent), Some(child)) = (end("parent"), end("child")) else { return };
        let Some(child) = child else {
            log.left_out("joint whose child is the world", element.place());
            return;
        };
        let Some(frame) = self.placed(&full) else { return };
        let axes = self.axes(element, kind, &frame, scope);
        for child in &element.children {
            match child.name.as_str() {
                "parent" | "child" | "pose" | "axis" | "axis2" => {}
                name => log.left_out(&format!("joint/{name}"), child.place()),
            }
        }
        let place = element.place();
        let joint = Joint { name: full, place, parent, child, axes, floats: false };
        self.robot.joints.push(joint);
    }

    fn axes(
        &self,
        element: &Element,
        kind: &str,
        frame: &Isometry3<f64>,
        scope: &str,
    ) -> Vec<Axis> {
        let log = self.log;
        let anchor = frame * nalgebra::Point3::origin();
        let named = |mut axis: Axis, name: &str| {
            axis.name = name.into();
            axis
        };
        match kind {
            "fixed" => Vec::new(),
            "ball" => ball(frame).into(),
            _ => {
                if kind == "screw" {
                    log.left_out("joint/thread_pitch: a screw's shift", element.place());
                }
                let wanted: &[&str] = if kind == "universal" || kind == "revolute2" {
                    &["axis", "axis2"]
                } else {
                    &["axis"]
                };
                let mut axes = Vec::new();
                for name in wanted {
                    let axis = element.child(name);
                    if axis.is_none() {
                        log.problem(
                            element.problem(format!("<joint> must have an <{name}>, got none")),
                        );
                    }
                    let Some(axis) = axis else { continue };
                    let motion = if kind == "prismatic" { Motion::Slides } else { Motion::Turns };
                    let Some(direction) = self.direction(axis, frame, scope) else {
                        continue;
                    };
                    let mut read = Axis::new(motion, direction, anchor);
                    limits(&mut read, axis, kind == "continuous", log);
                    axes.push(if wanted.len() > 1 { named(read, name) } else { read });
                }
                axes
            }
        }
    }

    /// In the drawing.
    fn direction(
        &self,
        axis: &Element,
        frame: &Isometry3<f64>,
        scope: &str,
    ) -> Option<Unit<Vector3<f64>>> {
        let log = self.log;
        let xyz = axis.child("xyz");
        let written = xyz.map_or(Some([0.0, 0.0, 1.0]), |xyz| xyz.own_numbers(log))?;
        let Some(direction) = Unit::try_new(Vector3::from(written), 1e-9) else {
            log.problem(axis.problem("<xyz> must be a direction, got 0 0 0"));
            return None;
        };
        let old = axis.child("use_parent_model_frame");
        let expressed_in = xyz.and_then(|xyz| xyz.get("expressed_in")).filter(|it| !it.is_empty());
        let rotation = match expressed_in {
            Some(name) => {
                let full = format!("{scope}{name}");
                if name == "__model__" {
                    self.frames.get(&full)?.pose.rotation
                } else if self.frames.contains_key(&full) {
                    self.placed(&full)?.rotation
                } else {
                    self.unknown(axis, name, scope);
                    return None;
                }
            }
            None if old.is_some_and(|it| ["true", "1"].contains(&it.text.as_str())) => {
                self.frames.get(&format!("{scope}__model__"))?.pose.rotation
            }
            None => frame.rotation,
        };
        Some(Unit::new_normalize(rotation * direction.into_inner()))
    }
}

fn limits(axis: &mut Axis, element: &Element, continuous: bool, log: &Log) {
    let limit = element.child("limit");
    let number = |name| limit.and_then(|limit| limit.number_in(name, log));
    let lower = number("lower").unwrap_or(-LARGEST);
    let upper = number("upper").unwrap_or(LARGEST);
    if !continuous && (lower > -LARGEST || upper < LARGEST) {
        axis.range = Some([lower, upper]);
    }
    if let Some(dynamics) = element.child("dynamics") {
        let number = |name| dynamics.number_in(name, log).unwrap_or_default();
        axis.damping = number("damping");
        axis.friction = number("friction");
        let (stiffness, rest) = (number("spring_stiffness"), number("spring_reference"));
        axis.spring = (stiffness > 0.0).then_some(Spring { stiffness, rest });
    }
    let is_wheel = axis.range.is_none() && axis.motion == Motion::Turns;
    axis.motor = Some(Motor {
        kind: if is_wheel { MotorKind::Speed } else { MotorKind::Position },
        speed: number("velocity"),
        effort: number("effort"),
    });
}
