//! The table `physics`: Bullet's world.

use config::{Section, count, flag, within};
use serde::Serialize;

/// The settings of Bullet's world and its steps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhysicsSettings {
    /// Physics steps in a second, 1 to 100,000; a whole multiple of the control frequency; 100.
    pub frequency_hz: f64,
    /// Iterations of the constraint solver in a physics step, 1 to 100,000; 200.
    pub iterations: u32,
    /// Whether the solver starts from the last step's impulses; true.
    pub warm_starting: bool,
}

impl Default for PhysicsSettings {
    fn default() -> Self {
        Self { frequency_hz: 100.0, iterations: 200, warm_starting: true }
    }
}

impl PhysicsSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let default = Self::default();
        let frequency_hz = within(1.0, 100_000.0);
        Some(Self {
            frequency_hz: section.or("frequency_hz", frequency_hz, default.frequency_hz),
            iterations: section.or("iterations", count(1, 100_000), default.iterations),
            warm_starting: section.or("warm_starting", flag(), default.warm_starting),
        })
    }
}
