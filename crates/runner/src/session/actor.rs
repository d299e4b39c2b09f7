//! One world of a cell: a robot that lives there by the cell's policy.
//!
//! A cell has one actor or several. Its learner says by which parameters they act; each has random
//! numbers, a perturbation and a window of readings of its own, so what one does with the same
//! parameters depends neither on how many there are nor on who is stepped beside it.

use std::time::{Duration, Instant};

use policy::Policy;
use rand_chacha::rand_core::Rng;
use reward::Terms;
use runs::Ring;
use svenja::Morphology;

use super::{Episode, Error, Perturbation, learner::Learner, update_sums::UpdateSums};
use crate::experiment::Experiment;

/// A robot in its world, with what it has of its own.
pub(super) struct Actor {
    pub(super) episode: Episode,
    pub(super) policy: Box<dyn Policy>,
    perturbation: Perturbation,
    pub(super) sums: UpdateSums,
    pub(super) buffers: Buffers,
    /// What the last control step was worth.
    pub(super) terms: Terms,
    /// Spent in the policy's act and score, for `itarl bench`; no result knows it.
    pub(super) policy_time: Duration,
}

/// What passes from row to row of a control step.
pub(super) struct Buffers {
    /// The policy's own output, `[n_outputs]`.
    pub(super) output: Vec<bool>,
    /// What is executed of it, `[n_outputs]`.
    pub(super) action: Vec<bool>,
    /// `[n_parameters]`
    pub(super) score: Vec<f64>,
}

impl Actor {
    /// The cell's actor in its world of this number, counted from 0, before it has settled. It acts by
    /// this policy, with random numbers of its own.
    ///
    /// # Errors
    /// Settings that don't fit the model.
    pub(super) fn new(
        experiment: &Experiment,
        morphology: &Morphology,
        mut policy: Box<dyn Policy>,
        seed: u64,
        world: usize,
    ) -> Result<Self, Error> {
        let build = |error: &dyn std::fmt::Display| Error::Build(error.to_string());
        let episode = Episode::new(experiment, morphology, seed_of(world, seed))
            .map_err(|error| build(&error))?;
        policy.draw_from(seed, &stream("policy", world));
        let n = policy.parameters().len();
        let perturbation = &experiment.perturbation;
        let stream = stream("perturbation", world);
        Ok(Self {
            perturbation: Perturbation::new(
                perturbation.every,
                perturbation.length,
                perturbation.flip_probability,
                seed,
                &stream,
            ),
            sums: UpdateSums::default(),
            buffers: Buffers {
                output: vec![false; policy.n_outputs()],
                action: vec![false; policy.n_outputs()],
                score: vec![0.0; n],
            },
            terms: Terms::default(),
            policy_time: Duration::ZERO,
            episode,
            policy,
        })
    }

    /// Before the first control step of an update.
    pub(super) fn begin_update(&mut self) {
        self.sums = UpdateSums::begin(self.episode.state());
    }

    /// Before the physics of a control step: what the robot shall do. The score is only made if it's
    /// needed.
    pub(super) fn before(&mut self, step: u64, needs_score: bool) -> anyhow::Result<()> {
        if self.episode.is_settling() { self.episode.rest() } else { self.act(step, needs_score) }
    }

    /// Rows 2 to 4: bits of the readings, bits of the action with its score, targets.
    fn act(&mut self, step: u64, needs_score: bool) -> anyhow::Result<()> {
        let Buffers { output, action, score } = &mut self.buffers;
        let start = Instant::now();
        if needs_score {
            self.policy.act_and_score(self.episode.inputs(), output, score)?;
        } else {
            self.policy.act(self.episode.inputs(), output)?;
        }
        self.policy_time += start.elapsed();
        action.copy_from_slice(output);
        self.perturbation.perturb(step, action);
        self.episode.act(action)
    }

    /// After the physics of a control step, rows 6 to 8: the new readings, what they are worth, which
    /// the learner takes in.
    pub(super) fn after(
        &mut self,
        updates: u64,
        world: usize,
        learner: &mut dyn Learner,
    ) -> anyhow::Result<()> {
        if self.episode.is_settling() {
            return self.episode.settle();
        }
        let step = self.episode.evaluate(updates)?;
        self.sums.add(&step);
        self.sums.entropy_nats += self.policy.entropy_nats(&self.buffers.output)?;
        learner.observe(world, &self.buffers.score, step.terms.reward)?;
        self.terms = step.terms;
        Ok(())
    }

    /// Row 9: the last control step, for a recording.
    pub(super) fn record(&self, ring: &mut Ring) -> Result<(), runs::Error> {
        ring.push(self.episode.recorded(&self.terms.as_array()))
    }
}

/// The seed of what is drawn in a world for its own sake, as a reward's points.
fn seed_of(world: usize, seed: u64) -> u64 {
    if world == 0 { seed } else { streams::named(seed, &stream("seed", world)).next_u64() }
}

/// The name of a world's stream of random numbers. The first one has those of a cell of one world.
fn stream(name: &str, world: usize) -> String {
    if world == 0 { name.to_owned() } else { format!("{name} of world {}", world + 1) }
}
