//! The scale of a task in metres: a number, or the model's own factor for metres of locomotion.

use config::{Rule, Section, or_word, within};
use serde::Serializer;

use crate::RobotLayout;

/// What stands for the model's own factor.
const OF_MODEL: &str = "model";

/// Reads `scale`; none is the model's.
pub(super) fn read(section: &mut Section<'_>) -> Option<f64> {
    let scale = or_word(within(-1e50, 1e50), OF_MODEL).about(
        "what a metre in a control step counts; `\"model\"`: what the model says of locomotion; negative: \
         the other way",
    );
    section.or("scale", scale, None)
}

/// As [`read`] takes it.
pub(super) fn write<S: Serializer>(scale: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    match scale {
        Some(scale) => serializer.serialize_f64(*scale),
        None => serializer.serialize_str(OF_MODEL),
    }
}

/// The number that it stands for.
pub(super) fn factor(scale: Option<f64>, layout: &RobotLayout) -> f64 {
    scale.unwrap_or(layout.locomotion_scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_model_sets_the_scale_unless_the_file_does() {
        let layout = RobotLayout { locomotion_scale: 2.5, ..Default::default() };
        assert_eq!(factor(None, &layout), 2.5);
        assert_eq!(factor(Some(-3.0), &layout), -3.0);
    }
}
