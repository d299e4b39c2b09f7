//! Experiment files: all settings of training instances, and the sweep over some of them.
//!
//! An [`Experiment`] is what one instance, a *cell*, is trained with; a [`Plan`] is a file: its
//! cells in a stable order. Each section of a file is a struct in a file of its own here, which
//! says what its keys mean and what they are by default (the paper's values: G. Montúfar,
//! K. Ghazi-Zahedi and N. Ay, *Information theoretically aided reinforcement learning for embodied
//! agents*, 2016). Values are checked against their ranges and each other; nothing is opened.
//!
//! The code that reads a key is its declaration: [`Experiment::settings`] asks it what there is, for
//! `itarl config --help KEY` and the tables of `docs/experiment-files.md`, which `make docs` writes.

mod axis;
mod codec;
mod control;
mod explain;
mod files;
mod learner;
mod learning;
mod leaves;
mod perturbation;
mod physics;
mod plan;
mod record;
mod robot;
mod sweep;
mod twice;

pub(crate) use axis::safe;
pub use codec::CodecSettings;
pub use control::ControlSettings;
pub use explain::{explained, known};
pub use files::{absolute, policy_names};
pub use learner::{EvolutionSettings, LearnerSettings};
pub use learning::LearningSettings;
pub use perturbation::PerturbationSettings;
pub use physics::PhysicsSettings;
pub use plan::{Cell, Plan};
pub use record::{CheckpointSettings, RecordSettings};
pub use robot::RobotSettings;
pub use sweep::MOST_CELLS;

use config::{Rule, Section, Setting, text};
use policy::{PolicySettings, Start};
use reward::RewardSettings;
use serde::Serialize;

/// All settings of a cell but its seed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Experiment {
    /// A line for readers, without effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// Path of the model file; absolute in a [`Plan`].
    pub model: String,
    /// In what the robot isn't as its model file says.
    #[serde(skip_serializing_if = "RobotSettings::is_empty")]
    pub robot: RobotSettings,
    /// The settings of Bullet's world.
    pub physics: PhysicsSettings,
    /// When the policy acts.
    pub control: ControlSettings,
    /// Readings to bits, bits to targets.
    pub codec: CodecSettings,
    /// What acts.
    pub policy: PolicySettings,
    /// The reward that it learns for.
    pub reward: RewardSettings,
    /// The perturbation of what the policy does, a wind.
    pub perturbation: PerturbationSettings,
    /// The settings of the gradient and its steps.
    pub learning: LearningSettings,
    /// What is kept of the last control steps.
    pub record: RecordSettings,
    /// When all is saved.
    pub checkpoint: CheckpointSettings,
}

impl Experiment {
    /// Reads a file's top level, but for its sweep.
    pub fn read(root: &mut Section<'_>) -> Option<Self> {
        let description = text().about("what it's for, for readers; changes nothing");
        let description = root.optional("description", description);
        let model = text().about("the robot's file").condition(
            "a file's path from this file's folder; with `--set`, from the current folder",
        );
        let model = root.required("model", model);
        let robot = RobotSettings::read(root);
        let physics = root.table_or_empty("physics", |section| {
            let place = section.place_of("frequency_hz");
            Some((PhysicsSettings::read(section)?, place))
        });
        let control = root
            .table_or_empty("control", |section| ControlSettings::read(section, physics.as_ref()));
        let steps = control.as_ref().map(|&(_, steps)| steps);
        let codec = root.table_or_empty("codec", CodecSettings::read);
        let policy = root.table_or_empty("policy", PolicySettings::read);
        let reward = root.table_or_empty("reward", RewardSettings::read);
        let perturbation = root.table_or_empty("perturbation", PerturbationSettings::read);
        let learning = root.table_or_empty("learning", LearningSettings::read);
        let record = root.table_or_empty("record", |section| RecordSettings::read(section, steps));
        let checkpoint = root.table_or_empty("checkpoint", CheckpointSettings::read);
        Some(Self {
            description,
            model: model?,
            robot,
            physics: physics?.0,
            control: control?.0,
            codec: codec?,
            policy: policy?,
            reward: reward?,
            perturbation: perturbation?,
            learning: learning?,
            record: record?,
            checkpoint: checkpoint?,
        })
    }

    /// All settings that a file may have but the sweep, each with what it means, its default and its
    /// range, in the order of files.
    #[must_use]
    pub fn settings() -> Vec<Setting> {
        config::settings(Self::read)
    }

    /// Path of the file that the policy's parameters are from at the beginning, if they are from one;
    /// absolute in a [`Plan`].
    #[must_use]
    pub fn initial(&self) -> Option<&str> {
        match &self.policy.start {
            Start::File(path) => Some(path),
            Start::Random(_) => None,
        }
    }

    /// With other paths in place of those of its files, or with what else tells these apart.
    #[must_use]
    pub fn with_files(mut self, other: impl Fn(&str) -> String) -> Self {
        self.model = other(&self.model);
        if let Start::File(path) = &mut self.policy.start {
            *path = other(path);
        }
        self
    }

    /// Physics steps in a control step.
    #[must_use]
    pub fn physics_steps_per_control_step(&self) -> u64 {
        // Checked to be a whole number when it was read.
        (self.physics.frequency_hz / self.control.frequency_hz) as u64
    }

    /// All keys with dots between, in the order of files, each with its value as a person would write it.
    pub(crate) fn shown(&self) -> Vec<(String, String)> {
        let all = leaves::leaves(&leaves::table(self)).into_iter();
        all.map(|(key, value)| (key, leaves::shown(&value))).collect()
    }

    /// All settings, complete: a file that gives this experiment.
    #[must_use]
    pub fn to_toml(&self) -> String {
        leaves::table(self).to_string()
    }
}

#[cfg(test)]
mod tests;
