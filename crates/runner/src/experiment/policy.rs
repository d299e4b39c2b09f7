//! The table `policy`: the conditional restricted Boltzmann machine that acts.

use config::{Section, one_of, within};
use crbm::{MAX_PARAMETER, MAX_UNITS, Sampling};
use serde::Serialize;

use crate::rules::count;

/// The machine that acts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PolicySettings {
    /// Hidden units, 1 to 16,384; 50. With blocks, the number in each block.
    pub hidden_units: usize,
    /// Full updates of a Gibbs chain from its random start, 0 to 100,000; 10. With 0, actions are
    /// uniform.
    pub gibbs_updates: usize,
    /// Samples for the score's second term, 1 to 100,000; 60.
    pub samples: usize,
    /// Which outputs a hidden unit sees; all.
    pub connectivity: Connectivity,
    /// Earlier readings that the machine sees besides the newest, 0 to 100; 0.
    pub memory: usize,
    /// Standard deviation of the parameters at the start, 0 to 1e8; 0.01.
    pub initial_scale: f64,
}

/// Which outputs a hidden unit sees. All see all inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Connectivity {
    /// Every hidden unit is connected with every actuator.
    Full,
    /// Those of one actuator: a block of hidden units for each.
    PerActuator,
    /// Those of one of the model's groups, of a leg: a block of hidden units for each.
    PerGroup,
}

impl Default for PolicySettings {
    fn default() -> Self {
        let Sampling { gibbs_updates, samples } = Sampling::default();
        Self {
            hidden_units: 50,
            gibbs_updates,
            samples,
            connectivity: Connectivity::Full,
            memory: 0,
            initial_scale: 0.01,
        }
    }
}

impl PolicySettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let default = Self::default();
        let connectivities = [
            ("full", Connectivity::Full),
            ("per_actuator", Connectivity::PerActuator),
            ("per_group", Connectivity::PerGroup),
        ];
        let hidden_units = count(1, MAX_UNITS as i64);
        // No draw is as far out as 10 standard deviations.
        let initial_scale = within(0.0, MAX_PARAMETER / 10.0);
        Some(Self {
            hidden_units: section.or("hidden_units", hidden_units, default.hidden_units),
            gibbs_updates: section.or("gibbs_updates", count(0, 100_000), default.gibbs_updates),
            samples: section.or("samples", count(1, 100_000), default.samples),
            connectivity: section.or("connectivity", one_of(&connectivities), default.connectivity),
            memory: section.or("memory", count(0, 100), default.memory),
            initial_scale: section.or("initial_scale", initial_scale, default.initial_scale),
        })
    }
}
