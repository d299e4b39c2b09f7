//! A cell alive: a robot, a policy, and what makes the policy better.
//!
//! [`control_step`] is one step of the loop for some cells in step, row by row as in
//! ARCHITECTURE.md; after T of them, [`Session::learn`] takes a step of the optimiser.

mod body;
mod codec;
mod episode;
mod error;
mod solver;
mod state;
mod structure;
mod tally;
mod wind;

use std::time::{Duration, Instant};

use gpomdp::{Estimator, EstimatorSettings, Optimiser};
use policy::Policy;
use svenja::Morphology;

pub use body::Body;
pub use codec::{Codec, CodecShape};
pub use episode::{Episode, Evaluation, hold, recorded_layout};
pub use error::Error;
pub use solver::Solver;
pub use structure::build_policy;
pub use wind::Wind;

use runs::{Recording, Ring, Row};

use crate::experiment::Experiment;
use tally::Tally;

/// One training instance at work.
pub struct Session {
    steps_per_update: u64,
    episode: Episode,
    policy: Box<dyn Policy>,
    wind: Wind,
    estimator: Estimator,
    optimiser: Box<dyn Optimiser>,
    ring: Ring,
    tally: Tally,
    /// Control steps done, settling not counted.
    steps: u64,
    updates: u64,
    buffers: Buffers,
    /// Spent in the policy's act and score, for `itarl bench`; no result knows it.
    policy_time: Duration,
}

/// What passes from row to row of a control step.
struct Buffers {
    /// The policy's own output, `[n_outputs]`.
    output: Vec<bool>,
    /// What is executed of it, `[n_outputs]`.
    action: Vec<bool>,
    /// `[n_parameters]`
    score: Vec<f64>,
    /// theta on its way through the optimiser, `[n_parameters]`.
    parameters: Vec<f64>,
}

impl Session {
    /// A cell that hasn't moved yet. `initial` has the bytes of [the file](Experiment::initial) that
    /// its policy starts from, if it starts from one.
    ///
    /// # Errors
    /// Settings that don't fit the model; parameters to start from that are another policy's.
    pub fn build(
        experiment: &Experiment,
        morphology: &Morphology,
        initial: Option<&[u8]>,
        seed: u64,
    ) -> Result<Self, Error> {
        let build = |error: &dyn std::fmt::Display| Error::Build(error.to_string());
        let episode = Episode::new(experiment, morphology, seed).map_err(|error| build(&error))?;
        let mut policy = build_policy(experiment, morphology, seed)?;
        if let Some(path) = experiment.initial() {
            structure::start_from(&mut *policy, path, initial.unwrap_or_default())?;
        }
        check_room(policy.parameters().len())?;
        let learning = &experiment.learning;
        let estimator =
            EstimatorSettings { discount: learning.discount, baseline_factor: learning.baseline };
        let n = policy.parameters().len();
        let ring_layout = recorded_layout(experiment, morphology);
        let wind = &experiment.perturbation;
        Ok(Self {
            steps_per_update: learning.steps_per_update,
            wind: Wind::new(wind.every, wind.length, wind.flip_probability, seed),
            estimator: Estimator::new(n, &estimator).map_err(|error| build(&error))?,
            optimiser: learning.optimiser.build(n).map_err(|error| build(&error))?,
            ring: Ring::new(ring_layout, experiment.record.steps as usize)
                .map_err(|e| build(&e))?,
            tally: Tally::default(),
            steps: 0,
            updates: 0,
            policy_time: Duration::ZERO,
            buffers: Buffers {
                output: vec![false; policy.n_outputs()],
                action: vec![false; policy.n_outputs()],
                score: vec![0.0; n],
                parameters: vec![0.0; n],
            },
            episode,
            policy,
        })
    }

    /// Before the physics of a control step: what the robot shall do.
    fn before(&mut self) -> Result<(), Error> {
        let told = if self.is_settling() { self.episode.rest() } else { self.act() };
        told.map_err(|error| self.blew_up(error))
    }

    /// After the physics of a control step: what it was worth.
    fn after(&mut self) -> Result<(), Error> {
        let taken_in = if self.is_settling() { self.episode.settle() } else { self.gain() };
        taken_in.map_err(|error| self.blew_up(error))
    }

    /// Rows 2 to 4: bits of the readings, bits of the action with its score, targets.
    fn act(&mut self) -> anyhow::Result<()> {
        if self.is_between_updates() {
            self.tally = Tally::begin(self.episode.state());
        }
        let Buffers { output, action, score, .. } = &mut self.buffers;
        let start = Instant::now();
        self.policy.act_and_score(self.episode.inputs(), output, score)?;
        self.policy_time += start.elapsed();
        action.copy_from_slice(output);
        self.wind.perturb(self.steps, action);
        self.episode.act(action)
    }

    /// Rows 6 to 9: the new readings, what they are worth, what is learned from it and recorded.
    fn gain(&mut self) -> anyhow::Result<()> {
        let step = self.episode.judge(self.updates)?;
        self.tally.add(&step);
        self.estimator.accumulate(&self.buffers.score, step.terms.reward)?;
        self.ring.push(self.episode.recorded(&step.terms.as_array()))?;
        self.steps += 1;
        Ok(())
    }

    /// After T control steps: a step of the optimiser, and the row that tells of them.
    ///
    /// # Errors
    /// [`Error::BlewUp`]: the cell can't go on.
    pub fn learn(&mut self) -> Result<Row, Error> {
        let update = self.updates + 1;
        self.change_parameters().map_err(|error| Error::BlewUp {
            when: format!("update {update}"),
            message: error.to_string(),
        })?;
        Ok(self.row())
    }

    /// The one place where parameters change.
    fn change_parameters(&mut self) -> anyhow::Result<()> {
        self.tally.gradient_norm = norm(self.estimator.gradient());
        let parameters = &mut self.buffers.parameters;
        parameters.copy_from_slice(self.policy.parameters());
        self.optimiser.update(parameters, self.estimator.gradient())?;
        self.policy.set_parameters(parameters)?;
        self.estimator.restart();
        self.updates += 1;
        Ok(())
    }

    fn row(&self) -> Row {
        Row {
            update: self.updates,
            control_steps: self.steps,
            parameter_norm: norm(self.policy.parameters()),
            ..self.tally.row(self.episode.state(), self.steps_per_update)
        }
    }

    fn blew_up(&self, error: impl std::fmt::Display) -> Error {
        Error::BlewUp { when: self.now(), message: error.to_string() }
    }

    /// What a world that couldn't be stepped means for the cell.
    fn lost(&self, error: &svenja::Error) -> Error {
        use svenja::Error::{BlewUp, World};
        match error {
            BlewUp { .. } | World(bullet::Error::BlewUp { .. }) => self.blew_up(error),
            _ => Error::Interrupted { when: self.now(), message: error.to_string() },
        }
    }

    fn now(&self) -> String {
        if self.is_settling() {
            format!("settling, control step {}", self.episode.settled_steps() + 1)
        } else {
            format!("control step {} (update {})", self.steps + 1, self.updates + 1)
        }
    }

    /// Whether the robot has yet to come to rest before the first control step.
    #[must_use]
    pub fn is_settling(&self) -> bool {
        self.episode.is_settling()
    }

    /// Whether it stands between two updates, or before the first.
    #[must_use]
    pub fn is_between_updates(&self) -> bool {
        self.steps == self.updates * self.steps_per_update
    }

    /// Whether T control steps are done since the last update.
    #[must_use]
    pub fn is_to_learn(&self) -> bool {
        self.steps == (self.updates + 1) * self.steps_per_update
    }

    /// The number of updates done.
    #[must_use]
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// Control steps done, settling not counted.
    #[must_use]
    pub fn control_steps(&self) -> u64 {
        self.steps
    }

    /// Spent so far in the policy's act and score.
    #[must_use]
    pub fn policy_time(&self) -> Duration {
        self.policy_time
    }

    /// The policy as a safetensors file.
    ///
    /// # Errors
    /// Parameters that blew up.
    pub fn policy_file(&self) -> Result<Vec<u8>, Error> {
        self.policy.to_safetensors().map_err(|error| self.blew_up(error))
    }

    /// The last control steps.
    #[must_use]
    pub fn recording(&self) -> Recording {
        self.ring.recording()
    }
}

/// Refuses parameters that there's no memory to learn and to save, where running out of it would end
/// the program with all its cells.
fn check_room(n_parameters: usize) -> Result<(), Error> {
    // Parameters and score; trace and gradient; up to two for each of an optimiser's. Saving them has
    // these five as sections, twice while the file is put together, and the export.
    const NUMBERS: usize = 2 + 2 + 2 + 2 * 5 + 2;
    let bytes = n_parameters.saturating_mul(NUMBERS * size_of::<f64>());
    Vec::<u8>::new().try_reserve_exact(bytes).map_err(|_| {
        Error::Build(format!(
            "learning {n_parameters} parameters takes {:.0} MB, and there is no memory for them: \
             fewer hidden units, or a shorter memory, take less",
            bytes as f64 / 1e6
        ))
    })
}

/// One control step of some cells in step: readings to actions, actions to worlds, worlds to
/// rewards. The cells have the same physics; what becomes of one doesn't touch the others.
pub fn control_step(sessions: &mut [&mut Session], solver: &mut Solver) -> Vec<Result<(), Error>> {
    let mut results: Vec<_> = sessions.iter_mut().map(|session| session.before()).collect();
    let mut well: Vec<_> =
        sessions.iter_mut().zip(&mut results).filter(|(_, result)| result.is_ok()).collect();
    let mut episodes: Vec<&mut Episode> =
        well.iter_mut().map(|(session, _)| &mut session.episode).collect();
    let held = hold(&mut episodes, solver);
    for ((session, result), held) in well.into_iter().zip(held) {
        *result = held.map_err(|error| session.lost(&error)).and_then(|()| session.after());
    }
    results
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests;
