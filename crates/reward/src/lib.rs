//! Rewards: a task, the information in the robot's own sensors, and what mixes the two.
//!
//! ```text
//! r = scale (mix(e, i) - penalty n)
//! ```
//!
//! with the extrinsic part e, the intrinsic part i, both made to have a maximum of about 0.1, and n
//! penalised parts that touch something. So `scale` changes the scale of r and nothing else. The
//! reward is that of G. Montúfar, K. Ghazi-Zahedi and N. Ay, *Information theoretically aided
//! reinforcement learning for embodied agents* (2016), with each part to be chosen from a list.
//!
//! | file | what |
//! |---|---|
//! | `lib.rs`, `terms.rs` | [`Reward`]: settings at work, step by step; [`Terms`]: every part by itself |
//! | `settings.rs`, `kinds.rs` | [`RewardSettings`]: the table `reward` of an experiment file; what makes a list of kinds |
//! | `layout.rs`, `transition.rs` | [`RobotLayout`], [`Transition`]: all that a reward is told |
//! | [`extrinsic`] | e: a file for each kind of [`ExtrinsicSettings`] |
//! | [`intrinsic`] | i: a file for each kind of [`IntrinsicSettings`](intrinsic::IntrinsicSettings) |
//! | [`mix`] | one number of both: a file for each kind of [`MixSettings`](mix::MixSettings), and the schedule of xi |
//! | `error.rs` | [`Error`] |
//!
//! ```
//! use reward::{Reward, RewardSettings, RobotLayout, RobotState, Transition};
//!
//! let layout = RobotLayout { n_positions: 2, n_bins: 4, ..RobotLayout::default() };
//! let mut reward = Reward::new(&RewardSettings::default(), &layout, 1)?;
//! reward.begin(&[0, 3])?;
//! let before = RobotState::default(); // heads along x
//! let mut after = before.clone();
//! after.centre_of_gravity_m.x = 0.02;
//! let bins = [1, 2]; // of both joints, after the step
//! let step = Transition { bins: &bins, ..Transition::between(&before, &after) };
//! let terms = reward.evaluate(&step, 0)?;
//! assert_eq!(terms.extrinsic_raw, 0.02);
//! # Ok::<(), reward::Error>(())
//! ```
//!
//! What always holds: a reward goes on from its saved state with the same bits; no term is NaN or
//! infinite; every kind of a list passes the same tests (`tests.rs`). Neither robots nor learning are
//! known here: a task sees a [`Transition`].

#![forbid(unsafe_code)]

mod error;
pub mod extrinsic;
pub mod intrinsic;
mod kinds;
mod layout;
pub mod mix;
mod settings;
mod terms;
mod transition;

pub use error::Error;
pub use extrinsic::ExtrinsicSettings;
pub use layout::{Group, RobotLayout};
pub use settings::RewardSettings;
pub use terms::Terms;
pub use transition::{BodyState, RobotState, Transition};

use extrinsic::Extrinsic;
use intrinsic::Intrinsic;

/// What both parts of a reward are made to have as their maximum, about.
pub const NOMINAL_MAXIMUM: f64 = 0.1;

/// A reward at work.
#[derive(Debug)]
pub struct Reward {
    settings: RewardSettings,
    /// Of the extrinsic part.
    factor: f64,
    extrinsic: Box<dyn Extrinsic>,
    intrinsic: Box<dyn Intrinsic>,
}

impl Reward {
    /// For this robot, with the seed's random numbers.
    ///
    /// # Errors
    /// Settings that don't fit the robot.
    pub fn new(settings: &RewardSettings, layout: &RobotLayout, seed: u64) -> Result<Self, Error> {
        let extrinsic = settings.extrinsic.get();
        Ok(Self {
            factor: extrinsic.factor(layout),
            extrinsic: extrinsic.build(layout, seed)?,
            intrinsic: settings.intrinsic.get().build(layout)?,
            settings: settings.clone(),
        })
    }

    /// Takes in the first reading, which no action led to: each sensor's bin, `[n_sensors]`.
    ///
    /// # Errors
    /// A reading that doesn't fit the layout.
    pub fn begin(&mut self, bins: &[u64]) -> Result<(), Error> {
        self.intrinsic.push(bins)
    }

    /// The reward of a control step, after so many updates of the policy.
    ///
    /// # Errors
    /// A reading that doesn't fit the layout; a term that isn't finite.
    pub fn evaluate(&mut self, step: &Transition<'_>, update: u64) -> Result<Terms, Error> {
        self.intrinsic.push(step.bins)?;
        let RewardSettings { mix, scale, penalty, .. } = &self.settings;
        let information = self.intrinsic.value();
        let extrinsic_raw = self.extrinsic.value(step);
        let extrinsic = self.factor * extrinsic_raw;
        let xi = mix.get().xi().at(update);
        let penalty = scale * penalty * step.after.penalised_contacts as f64;
        let terms = Terms {
            reward: scale * mix.get().mix(xi, extrinsic, information.scaled) - penalty,
            extrinsic_raw,
            extrinsic,
            intrinsic_nats: information.nats,
            intrinsic_nats_corrected: information.nats_corrected,
            intrinsic: information.scaled,
            penalty,
            xi,
        };
        terms.check()?;
        Ok(terms)
    }

    /// All that changes, for [`Reward::restore`]: the information's, then the task's, if it has any.
    #[must_use]
    pub fn save(&self) -> Vec<u64> {
        [self.intrinsic.save(), self.extrinsic.save()].concat()
    }

    /// Goes back to a state of a reward with the same settings and layout, and continues with the
    /// same bits.
    ///
    /// # Errors
    /// A state of another one. The reward is then as before.
    pub fn restore(&mut self, state: &[u64]) -> Result<(), Error> {
        let before = self.extrinsic.save();
        let n_words = state.len().saturating_sub(before.len());
        let (intrinsic, extrinsic) = state.split_at(n_words);
        self.extrinsic.restore(extrinsic)?;
        let restored = self.intrinsic.restore(intrinsic);
        if restored.is_err() {
            self.extrinsic.restore(&before)?;
        }
        restored
    }
}

#[cfg(test)]
mod tests;
