//! The table `control`: when the policy acts.

use config::{Place, Rule, Section, count, within};
use serde::Serialize;

use super::PhysicsSettings;

/// When the policy acts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ControlSettings {
    /// Control steps in a second.
    pub frequency_hz: f64,
    /// Control steps at the start in which the robot drops and settles.
    pub settle_steps: u64,
}

impl ControlSettings {
    /// With the number of physics steps in a control step. The physics settings come with the place
    /// of their frequency.
    pub(super) fn read(
        section: &mut Section<'_>,
        physics: Option<&(PhysicsSettings, Place)>,
    ) -> Option<(Self, u64)> {
        let frequency_hz = within(0.01, 100_000.0).about("control steps in a second");
        let frequency_hz = section.given_or("frequency_hz", frequency_hz, 10.0);
        let settle_steps = count(0, 1_000_000).about(
            "control steps at the start that hold the neutral pose, while the robot drops and \
             settles; they enter nothing: no learning, no window, no clock",
        );
        let settle_steps = section.or("settle_steps", settle_steps, 20);
        let (physics, physics_place) = physics?;
        let frequency_hz = frequency_hz?;
        let steps = physics.frequency_hz / frequency_hz;
        if steps < 1.0 || steps.fract() != 0.0 {
            let given = section.has("frequency_hz");
            let place = if given { &section.place_of("frequency_hz") } else { physics_place };
            let message = format!(
                "physics.frequency_hz must be a whole multiple of control.frequency_hz, \
                 got {} and {frequency_hz}",
                physics.frequency_hz
            );
            section.complain(place, message);
            return None;
        }
        Some((Self { frequency_hz, settle_steps }, steps as u64))
    }
}
