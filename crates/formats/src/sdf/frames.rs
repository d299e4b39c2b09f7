//! Frames of an SDF model: links, joints, frames and models, each with a pose relative to another.

use std::collections::BTreeMap;

use config::{Problem, shown};
use nalgebra::{Isometry3, Vector3};

use super::Reader;
use crate::{robot::roll_pitch_yaw, xml::Element};

/// What has a pose: a link, a joint, a frame or a model.
pub(super) struct Frame<'a> {
    element: &'a Element,
    /// What the pose is relative to, as written.
    relative_to: Option<String>,
    /// Where names are looked up: `outer::`.
    scope: String,
    /// The link that it's part of, as far as known.
    attached_to: Option<String>,
    pub(super) pose: Isometry3<f64>,
}

impl<'a> Reader<'a> {
    /// Of a model and of all that is in it.
    pub(super) fn model_frames(&mut self, model: &'a Element, scope: &str, outer: &Isometry3<f64>) {
        let first = || model.child("link").and_then(|link| link.get("name"));
        let canonical = model.get("canonical_link").or_else(first);
        let frame = Frame {
            element: model,
            relative_to: None,
            scope: scope.into(),
            attached_to: canonical.map(|link| format!("{scope}{link}")),
            pose: *outer,
        };
        self.frames.insert(format!("{scope}__model__"), frame);
        for child in &model.children {
            let kind = child.name.as_str();
            if !["link", "joint", "frame", "model"].contains(&kind) {
                continue;
            }
            let Some(name) = child.required("name", self.log) else { continue };
            let full = format!("{scope}{name}");
            let (pose, relative_to) = self.pose(child);
            if kind == "model" {
                let pose = outer * pose;
                self.model_frames(child, &format!("{full}::"), &pose);
                continue;
            }
            let attached_to = match kind {
                "frame" => child.get("attached_to").map(str::to_owned),
                _ => child.child("child").map(|child| child.text.clone()),
            };
            // A joint is where its child is, a frame where what it's attached to is.
            let relative_to =
                relative_to.or_else(|| attached_to.clone().filter(|_| kind != "link"));
            let attached_to = if kind == "link" { None } else { attached_to };
            let frame =
                Frame { element: child, relative_to, scope: scope.into(), attached_to, pose };
            if self.frames.insert(full, frame).is_some() {
                let message = format!("there is another '{}' in its model", shown(name));
                self.log.problem(child.problem(message));
            }
        }
    }

    /// A pose, and what it's relative to where that is said.
    pub(super) fn pose(&self, element: &Element) -> (Isometry3<f64>, Option<String>) {
        let Some(pose) = element.child("pose") else { return (Isometry3::identity(), None) };
        let relative_to = pose.get("relative_to").filter(|name| !name.is_empty());
        let relative_to = relative_to.map(str::to_owned);
        if pose.text.is_empty() {
            return (Isometry3::identity(), relative_to);
        }
        let degrees = pose.get("degrees").is_some_and(|it| ["true", "1"].contains(&it));
        let unit = if degrees { 1_f64.to_radians() } else { 1.0 };
        if pose.get("rotation_format") == Some("quat_xyzw") {
            let numbers = pose.own_numbers::<7>(self.log).unwrap_or([0.0; 7]);
            let [x, y, z, i, j, k, w] = numbers;
            let turn =
                nalgebra::UnitQuaternion::try_new(nalgebra::Quaternion::new(w, i, j, k), 1e-9);
            let position = Vector3::new(x, y, z).into();
            return (Isometry3::from_parts(position, turn.unwrap_or_default()), relative_to);
        }
        let [x, y, z, roll, pitch, yaw] = pose.own_numbers::<6>(self.log).unwrap_or([0.0; 6]);
        let turn = roll_pitch_yaw([roll, pitch, yaw].map(|angle| angle * unit));
        (Isometry3::from_parts(Vector3::new(x, y, z).into(), turn), relative_to)
    }

    /// Where something is in the drawing.
    pub(super) fn placed(&self, full: &str) -> Option<Isometry3<f64>> {
        let mut pose = Isometry3::identity();
        let mut name = full.to_owned();
        // A chain longer than there are frames goes round.
        for _ in 0..=self.frames.len() {
            let frame = self.frames.get(&name)?;
            pose = frame.pose * pose;
            if name.ends_with("__model__") {
                return Some(pose);
            }
            name = match &frame.relative_to {
                Some(other) if other == "world" => return Some(pose),
                Some(other) => {
                    let other_full = format!("{}{other}", frame.scope);
                    let other_full = if self.frames.contains_key(&other_full) {
                        other_full
                    } else {
                        // A model within is found by its own frame.
                        format!("{other_full}::__model__")
                    };
                    if !self.frames.contains_key(&other_full) {
                        self.unknown(frame.element, other, &frame.scope);
                        return None;
                    }
                    other_full
                }
                None => format!("{}__model__", frame.scope),
            };
        }
        let element = self.frames.get(full)?.element;
        let message = "poses must not be relative to each other in a circle";
        self.log.problem(element.problem(message));
        None
    }

    pub(super) fn unknown(&self, element: &Element, name: &str, scope: &str) {
        let known = self.frames.keys().filter_map(|known| known.strip_prefix(scope));
        let likely = self.log.likely(name, known);
        let message = format!(
            "<{}> must refer to a link, a joint or a frame of its model, got \"{}\"{likely}",
            element.name,
            shown(name)
        );
        self.log.problem(Problem { place: element.place(), message });
    }

    /// The link that a name stands for, or that a frame of that name is attached to.
    pub(super) fn link_of(&self, full: &str, names: &BTreeMap<String, usize>) -> Option<usize> {
        let mut name = full.to_owned();
        for _ in 0..=self.frames.len() {
            if let Some(link) = names.get(&name) {
                return Some(*link);
            }
            let (scope, attached) = match self.frames.get(&name) {
                Some(frame) => (frame.scope.clone(), frame.attached_to.clone()),
                None => (String::new(), Some(format!("{name}::__model__"))),
            };
            let attached = attached?;
            // Those of models have their scope in them.
            name = if self.frames.contains_key(&attached) {
                attached
            } else {
                format!("{scope}{attached}")
            };
        }
        None
    }
}
