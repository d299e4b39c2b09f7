//! A cell alive: a robot, a policy, and what makes the policy better.
//!
//! [`control_step`] is one step of the loop for some cells in step, row by row as in
//! ARCHITECTURE.md; after T of them, [`Session::learn`] takes a step of the optimiser.

mod actor;
mod body;
mod codec;
mod episode;
mod error;
mod learner;
mod perturbation;
mod solver;
mod state;
mod structure;
mod update_sums;
mod worlds;

use std::time::Duration;

use gpomdp::Optimiser;
use policy::Policy;
use svenja::Morphology;

pub use body::Body;
pub use codec::{Codec, CodecShape};
pub use episode::{Episode, Evaluation, codec_shape, recorded_layout, simulate};
pub use error::Error;
pub use perturbation::Perturbation;
pub use solver::Solver;
pub use structure::{build_policy, learned_policy};
pub use worlds::{MOST_WORLDS, Stepped, Worlds};

use runs::{Recording, Ring, Row};

use crate::experiment::Experiment;
use actor::Actor;
use episode::SettledState;
use learner::Learner;

/// One training instance at work: a policy that acts in some worlds at a time, and learns from all.
pub struct Session {
    /// T, in each world.
    steps_per_update: u64,
    /// What is learned, theta: it doesn't act, but copies of it do.
    policy: Box<dyn Policy>,
    /// One a world, at least one.
    actors: Vec<Actor>,
    learner: Box<dyn Learner>,
    optimiser: Box<dyn Optimiser>,
    /// Of the first world.
    ring: Ring,
    /// Control steps done in each world, settling not counted.
    steps: u64,
    updates: u64,
    /// Where the robots settled, if each update begins there: it's the same in all worlds.
    settled: Option<SettledState>,
    /// theta, or a world's, and a gradient, on their way from here to there, `[n_parameters]`.
    parameters: Vec<f64>,
    gradient: Vec<f64>,
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
        let learning = &experiment.learning;
        let mut policy = build_policy(experiment, morphology, seed)?;
        if let Some(path) = experiment.initial() {
            structure::start_from(&mut *policy, path, initial.unwrap_or_default())?;
        }
        let n = policy.parameters().len();
        check_room(n, learning.worlds)?;
        let actor = |world| {
            let copy = build_policy(experiment, morphology, seed)?;
            Actor::new(experiment, morphology, copy, seed, world)
        };
        let ring_layout = recorded_layout(experiment, morphology);
        Ok(Self {
            steps_per_update: learning.steps_per_update,
            actors: (0..learning.worlds).map(actor).collect::<Result<_, _>>()?,
            learner: learner::build(learning, n, seed).map_err(|error| build(&error))?,
            optimiser: learning.optimiser.build(n).map_err(|error| build(&error))?,
            ring: Ring::new(ring_layout, experiment.record.steps as usize)
                .map_err(|e| build(&e))?,
            steps: 0,
            updates: 0,
            settled: None,
            parameters: vec![0.0; n],
            gradient: vec![0.0; n],
            policy,
        })
    }

    /// Before the physics of a control step: what the robots shall do.
    fn before(&mut self) -> Result<(), Error> {
        if !self.is_settling() && self.is_between_updates() {
            self.begin_update()?;
        }
        let (steps, needs_score) = (self.steps, self.learner.needs_scores());
        self.each_actor(|actor, _, _| actor.before(steps, needs_score))
    }

    /// The worlds get their parameters, and are where they shall begin.
    fn begin_update(&mut self) -> Result<(), Error> {
        if self.learner.begins_anew() && self.settled.is_none() {
            let settled = self.actors[0].episode.settled_state();
            self.settled = Some(settled.map_err(|error| self.blew_up(error))?);
        }
        let settled = self.settled.take();
        let begun = self.each_actor(|actor, _, _| {
            if let Some(settled) = &settled {
                actor.episode.restart_from(settled)?;
            }
            actor.begin_update();
            Ok(())
        });
        self.settled = settled;
        begun?;
        self.hand_out_parameters()
    }

    /// Each world's own, of this update.
    fn hand_out_parameters(&mut self) -> Result<(), Error> {
        for (world, actor) in self.actors.iter_mut().enumerate() {
            let theta = self.policy.parameters();
            self.learner.candidate(self.updates, world, theta, &mut self.parameters);
            actor.policy.set_parameters(&self.parameters)?;
        }
        Ok(())
    }

    /// After the physics of a control step: what it was worth, and what it tells.
    fn after(&mut self) -> Result<(), Error> {
        let (updates, is_settling) = (self.updates, self.is_settling());
        self.each_actor(|actor, world, learner| actor.after(updates, world, learner))?;
        if !is_settling {
            self.actors[0].record(&mut self.ring).map_err(|error| self.blew_up(error))?;
            self.steps += 1;
        }
        Ok(())
    }

    /// Does something with each; the first that fails is the cell's end.
    fn each_actor(
        &mut self,
        mut act: impl FnMut(&mut Actor, usize, &mut dyn Learner) -> anyhow::Result<()>,
    ) -> Result<(), Error> {
        for world in 0..self.actors.len() {
            act(&mut self.actors[world], world, &mut *self.learner).map_err(|error| {
                Error::BlewUp { when: self.now(world), message: error.to_string() }
            })?;
        }
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

    /// The one place where what is learned changes.
    fn change_parameters(&mut self) -> anyhow::Result<()> {
        self.learner.gradient(self.updates, &mut self.gradient)?;
        self.parameters.copy_from_slice(self.policy.parameters());
        self.optimiser.update(&mut self.parameters, &self.gradient)?;
        self.policy.set_parameters(&self.parameters)?;
        self.updates += 1;
        Ok(())
    }

    fn row(&self) -> Row {
        let sums = self.actors.iter().map(|actor| (&actor.sums, actor.episode.state()));
        Row {
            update: self.updates,
            control_steps: self.control_steps(),
            parameter_norm: norm(self.policy.parameters()),
            gradient_norm: norm(&self.gradient),
            gradient_error: self.learner.gradient_error(),
            ..update_sums::row(sums, self.steps_per_update)
        }
    }

    fn blew_up(&self, error: impl std::fmt::Display) -> Error {
        Error::BlewUp { when: self.now(0), message: error.to_string() }
    }

    /// What a world that couldn't be stepped means for the cell.
    fn lost(&self, world: usize, error: &svenja::Error) -> Error {
        use svenja::Error::{BlewUp, World};
        let (when, message) = (self.now(world), error.to_string());
        match error {
            BlewUp { .. } | World(bullet::Error::BlewUp { .. }) => Error::BlewUp { when, message },
            _ => Error::Interrupted { when, message },
        }
    }

    /// In one of its worlds, which is told only where there are several.
    fn now(&self, world: usize) -> String {
        let place = match self.actors.len() {
            1 => String::new(),
            _ => format!("world {}, ", world + 1),
        };
        if self.is_settling() {
            format!("{place}settling, control step {}", self.actors[0].episode.settled_steps() + 1)
        } else {
            format!("{place}control step {} (update {})", self.steps + 1, self.updates + 1)
        }
    }

    /// Whether the robot has yet to come to rest before the first control step.
    #[must_use]
    pub fn is_settling(&self) -> bool {
        self.actors[0].episode.is_settling()
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

    /// Control steps done in all of its worlds together, settling not counted.
    #[must_use]
    pub fn control_steps(&self) -> u64 {
        self.steps * self.worlds() as u64
    }

    /// Worlds that it has.
    #[must_use]
    pub fn worlds(&self) -> usize {
        self.actors.len()
    }

    /// Spent so far in the policy's act and score.
    #[must_use]
    pub fn policy_time(&self) -> Duration {
        self.actors.iter().map(|actor| actor.policy_time).sum()
    }

    /// The policy as a safetensors file.
    ///
    /// # Errors
    /// Parameters that blew up.
    pub fn policy_file(&self) -> Result<Vec<u8>, Error> {
        self.policy.to_safetensors().map_err(|error| self.blew_up(error))
    }

    /// The last control steps, in its first world.
    #[must_use]
    pub fn recording(&self) -> Recording {
        self.ring.recording()
    }
}

/// Refuses parameters that there's no memory to learn and to save, where running out of it would end
/// the program with all its cells.
fn check_room(n_parameters: usize, worlds: usize) -> Result<(), Error> {
    // Parameters and gradient; up to two for each of an optimiser's. Saving them has these as
    // sections, twice while the file is put together, and the export.
    const NUMBERS: usize = 2 + 2 + 2 * 3 + 2;
    // Parameters, score, trace and gradient; the last two as sections, twice.
    const OF_A_WORLD: usize = 4 + 2 * 2;
    let numbers = OF_A_WORLD.saturating_mul(worlds).saturating_add(NUMBERS);
    let bytes = n_parameters.saturating_mul(numbers).saturating_mul(size_of::<f64>());
    Vec::<u8>::new().try_reserve_exact(bytes).map_err(|_| {
        Error::Build(format!(
            "learning {n_parameters} parameters takes {:.0} MB, and there is no memory for them: \
             fewer hidden units, a shorter memory, or fewer worlds take less",
            bytes as f64 / 1e6
        ))
    })
}

/// One control step of some cells in step: readings to actions, actions to worlds, worlds to
/// rewards. The cells have the same physics; what becomes of one doesn't touch the others.
pub fn control_step(sessions: &mut [&mut Session], solver: &mut Solver) -> Vec<Result<(), Error>> {
    let mut results: Vec<_> = sessions.iter_mut().map(|session| session.before()).collect();
    let mut healthy: Vec<_> =
        sessions.iter_mut().zip(&mut results).filter(|(_, result)| result.is_ok()).collect();
    let actors = healthy.iter_mut().flat_map(|(session, _)| &mut session.actors);
    let mut episodes: Vec<&mut Episode> = actors.map(|actor| &mut actor.episode).collect();
    let mut simulated = simulate(&mut episodes, solver).into_iter();
    for (session, result) in healthy {
        let worlds: Vec<_> = simulated.by_ref().take(session.worlds()).enumerate().collect();
        let lost =
            worlds.iter().find_map(|(world, simulated)| Some((*world, simulated.as_ref().err()?)));
        *result = match lost {
            Some((world, error)) => Err(session.lost(world, error)),
            None => session.after(),
        };
    }
    results
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests;
