//! What makes of an update's control steps the gradient that the optimiser follows. One file a kind:
//! its settings in `experiment/learner.rs`, and a line in [`build`].

mod evolution;
mod gpomdp;

use crate::experiment::{LearnerSettings, LearningSettings};

/// A cell's way to learn, over all of its worlds.
pub(super) trait Learner: Send {
    /// Whether each update is an episode of its own that begins where the robot has settled.
    fn begins_anew(&self) -> bool {
        false
    }

    /// Whether it needs the scores of the actions.
    fn needs_scores(&self) -> bool {
        false
    }

    /// The parameters by which a world acts in an update, given theta; both `[n_parameters]`. It
    /// depends on nothing else that changes.
    fn candidate(&self, update: u64, world: usize, theta: &[f64], candidate: &mut [f64]);

    /// Takes in a control step of a world: the score of the action, `[n_parameters]`, if it's needed,
    /// and the reward that followed.
    fn observe(&mut self, world: usize, score: &[f64], reward: f64) -> anyhow::Result<()>;

    /// Control steps of a world that it has taken in during this update.
    fn steps(&self, world: usize) -> u64;

    /// After the last control step of an update: the gradient, `[n_parameters]`. The next update
    /// begins.
    fn gradient(&mut self, update: u64, gradient: &mut [f64]) -> anyhow::Result<()>;

    /// The standard error of the last gradient, as its norm is: the root of the expected square of the
    /// distance to what it estimates; NaN where it isn't known.
    fn gradient_error(&self) -> f64 {
        f64::NAN
    }

    /// All that changes with a world's steps, for [`restore`](Self::restore).
    fn state(&self, world: usize) -> Vec<f64>;

    /// Goes on from a world's state with the same bits.
    fn restore(&mut self, world: usize, state: &[f64]) -> anyhow::Result<()>;
}

/// The learner of an experiment.
///
/// # Errors
/// Settings that are out of range.
pub(super) fn build(
    settings: &LearningSettings,
    n_parameters: usize,
    seed: u64,
) -> anyhow::Result<Box<dyn Learner>> {
    let worlds = settings.worlds;
    Ok(match &settings.learner {
        LearnerSettings::Gpomdp(settings) => {
            Box::new(gpomdp::Gpomdp::new(settings, n_parameters, worlds)?)
        }
        LearnerSettings::Evolution(settings) => {
            Box::new(evolution::Evolution::new(settings, worlds, seed)?)
        }
    })
}
