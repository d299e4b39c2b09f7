//! The table `physics`: Bullet's world.

use config::{Rule, Section, count, flag, within};
use serde::Serialize;

/// The settings of Bullet's world and its steps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhysicsSettings {
    /// Physics steps in a second.
    pub frequency_hz: f64,
    /// Iterations of the constraint solver in a physics step.
    pub iterations: u32,
    /// Whether the solver starts from the last step's impulses.
    pub warm_starting: bool,
}

impl PhysicsSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let frequency_hz = within(1.0, 100_000.0)
            .about("physics steps in a second")
            .condition("a whole multiple of `control.frequency_hz`");
        let iterations =
            count(1, 100_000).about("iterations of Bullet's constraint solver in a physics step");
        let warm_starting =
            flag().about("whether the solver starts from the impulses of the last step");
        Some(Self {
            frequency_hz: section.or("frequency_hz", frequency_hz, 100.0),
            iterations: section.or("iterations", iterations, 200),
            warm_starting: section.or("warm_starting", warm_starting, true),
        })
    }
}
