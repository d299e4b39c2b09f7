//! Height: how high a body's centre of mass is above the ground, z = 0, after the control step, in m.

use config::{Rule, Section, text, within};
use serde::Serialize;

use super::{Build, Extrinsic};
use crate::{Error, RobotLayout, Transition};

/// Settings of height.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeightSettings {
    /// The body's name in the model; by default the one that has the heading axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// What a metre counts; 0.1. Negative: lying low.
    pub scale: f64,
}

impl Default for HeightSettings {
    fn default() -> Self {
        Self { body: None, scale: 0.1 }
    }
}

impl HeightSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        Some(Self {
            body: section.optional(
                "body",
                text().about(
                    "the body's name in the model; by default the one that has the heading axis",
                ),
            ),
            scale: section.or(
                "scale",
                within(-1e50, 1e50).about("what a metre counts; negative: low"),
                Self::default().scale,
            ),
        })
    }
}

impl Build for HeightSettings {
    fn build(&self, layout: &RobotLayout, _: u64) -> Result<Box<dyn Extrinsic>, Error> {
        let body = match &self.body {
            None => layout.heading_body,
            Some(name) => {
                let known = || layout.bodies.iter().map(String::as_str);
                known().position(|body| body == name).ok_or_else(|| Error::UnknownBody {
                    name: name.clone(),
                    suggestion: config::suggestion(name, known()),
                    known: known().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", "),
                })?
            }
        };
        Ok(Box::new(Height { body }))
    }

    fn factor(&self, _: &RobotLayout) -> f64 {
        self.scale
    }

    fn symbol(&self) -> &'static str {
        "height"
    }

    fn unit(&self) -> &'static str {
        "m"
    }
}

#[derive(Debug)]
struct Height {
    /// Its index in the model.
    body: usize,
}

impl Extrinsic for Height {
    fn value(&mut self, transition: &Transition<'_>) -> f64 {
        transition.after.bodies[self.body].pose.translation.z
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;
    use crate::{BodyState, RobotState};

    fn layout() -> RobotLayout {
        let bodies = vec!["head".into(), "tail".into()];
        RobotLayout { bodies, heading_body: 1, ..Default::default() }
    }

    #[test]
    fn the_named_body_counts_and_else_the_one_that_heads() {
        let body =
            |z| BodyState { pose: Isometry3::translation(9.0, 8.0, z), ..Default::default() };
        let (before, after) = (
            RobotState::default(),
            RobotState { bodies: vec![body(1.5), body(0.25)], ..Default::default() },
        );
        let step = Transition::between(&before, &after);
        for (body, height) in [(None, 0.25), (Some("head"), 1.5), (Some("tail"), 0.25)] {
            let settings = HeightSettings { body: body.map(str::to_owned), scale: 1.0 };
            assert_eq!(settings.build(&layout(), 1).unwrap().value(&step), height);
        }
    }

    #[test]
    fn a_body_that_is_not_there_is_refused_with_those_that_are() {
        let settings = HeightSettings { body: Some("hea".into()), scale: 1.0 };
        let message = settings.build(&layout(), 1).unwrap_err().to_string();
        let expected = "reward.extrinsic.body must be one of the model's bodies, 'head', 'tail'; got \
                        'hea', did you mean 'head'?";
        assert_eq!(message, expected);
    }
}
