//! A policy at work without learning and without wind.

use infotheory::Binning;
use policy::Policy;
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use runs::{Recording, Ring};
use svenja::Morphology;

use crate::{
    experiment::Experiment,
    gait::Gait,
    session::{Episode, Evaluation, Solver, recorded_layout},
};

/// The ways to decide about targets.
pub enum Driver {
    /// A policy that was learned.
    Learned(Box<dyn Policy>),
    /// Uniform random bits.
    Random(Box<ChaCha8Rng>),
    /// 0 for all.
    Neutral,
    /// A periodic pattern.
    Gait(Gait, Binning),
}

impl Driver {
    /// A policy that was learned.
    #[must_use]
    pub fn learned(mut policy: Box<dyn Policy>, seed: u64) -> Self {
        policy.draw_from(seed, "rollout");
        Self::Learned(policy)
    }

    /// Uniform random bits.
    #[must_use]
    pub fn random(seed: u64) -> Self {
        Self::Random(Box::new(ChaCha8Rng::seed_from_u64(seed)))
    }

    /// A periodic pattern.
    ///
    /// # Errors
    /// More bits than a bin can have.
    pub fn gait(gait: Gait) -> anyhow::Result<Self> {
        let binning = Binning::new(gait.bits)?;
        Ok(Self::Gait(gait, binning))
    }

    /// What the robot shall do in a control step.
    fn decide(&mut self, step: u64, episode: &mut Episode) -> anyhow::Result<()> {
        let mut action = vec![false; episode.n_outputs()];
        match self {
            Self::Learned(policy) => {
                policy.act(episode.inputs(), &mut action)?;
                episode.act(&action)
            }
            Self::Random(rng) => {
                action.fill_with(|| rng.next_u32() >> 31 == 1);
                episode.act(&action)
            }
            Self::Neutral => episode.rest(),
            Self::Gait(gait, binning) => {
                let mut targets = vec![0.0; episode.targets().len()];
                binning.decode(gait.at(step), &mut targets)?;
                episode.aim(&targets)
            }
        }
    }
}

/// A control step of a rollout.
#[derive(Clone, Copy)]
pub struct RolloutStep<'a> {
    /// The control step, from 0 once the robot has settled.
    pub step: u64,
    /// What it did, and what it was worth with `xi` as at the start of training.
    pub did: Evaluation,
    /// The robot at its end.
    pub episode: &'a Episode,
}

/// What a rollout did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// The number of control steps.
    pub steps: u64,
    /// Mean along the heading, in m per control step.
    pub advance_m: f64,
    /// From start to end in the XY plane, in m.
    pub net_displacement_m: f64,
    /// To the left, in rad.
    pub heading_change_rad: f64,
    /// Mean information, in nats: of the intrinsic kind; 0 where none is measured.
    pub intrinsic_nats: f64,
    /// Share of control steps in which each contact sensor was on.
    pub contacts: Vec<f64>,
    /// Control steps times penalised parts that touched.
    pub penalised_contacts: u64,
    /// How many control steps set another target than the one before, of each actuator.
    pub target_changes: Vec<u64>,
}

/// Lets a driver act for so many control steps; each is shown to `see`. What the task draws is of the
/// seed.
///
/// # Errors
/// Settings that don't fit; a robot that blows up; what `see` returns.
pub fn roll_out(
    experiment: &Experiment,
    morphology: &Morphology,
    (driver, seed): (&mut Driver, u64),
    n_steps: u64,
    mut see: impl FnMut(&RolloutStep<'_>) -> anyhow::Result<()>,
) -> anyhow::Result<Summary> {
    let mut episode = Episode::new(experiment, morphology, seed)?;
    // Even one world alone is swept faster than by Bullet's own solver.
    let mut solver = Solver::lockstep()?;
    while episode.is_settling() {
        episode.rest()?;
        episode.simulate(&mut solver)?;
        episode.settle()?;
    }

    let n_contacts = morphology.contacts().len();
    let mut summary = Summary {
        steps: n_steps,
        contacts: vec![0.0; n_contacts],
        target_changes: vec![0; morphology.actuators().len()],
        ..Summary::default()
    };
    let start = episode.state().centre_of_gravity_m;
    let mut targets_before = Vec::new();
    for step in 0..n_steps {
        driver.decide(step, &mut episode)?;
        summary.compare(&targets_before, episode.targets());
        targets_before.clear();
        targets_before.extend_from_slice(episode.targets());
        episode.simulate(&mut solver)?;
        let did = episode.evaluate(0)?;
        let seen = RolloutStep { step, did, episode: &episode };
        summary.add(&seen, n_contacts);
        see(&seen)?;
    }
    let end = episode.state().centre_of_gravity_m;
    summary.net_displacement_m = (end - start).xy().norm();
    Ok(summary)
}

/// Lets a driver act for so many control steps, and keeps all of them.
///
/// # Errors
/// As [`roll_out`]; more steps than there is memory for.
pub fn record(
    experiment: &Experiment,
    morphology: &Morphology,
    (driver, seed): (&mut Driver, u64),
    n_steps: u64,
) -> anyhow::Result<Recording> {
    let layout = recorded_layout(experiment, morphology);
    let mut ring = Ring::new(layout, usize::try_from(n_steps)?)?;
    roll_out(experiment, morphology, (driver, seed), n_steps, |step| {
        Ok(ring.push(step.episode.recorded(&step.did.terms.as_array()))?)
    })?;
    Ok(ring.recording())
}

impl Summary {
    /// How many actuators keep still: their target changes in fewer than 2 % of the steps.
    #[must_use]
    pub fn still_actuators(&self) -> usize {
        let is_still = |&&changes: &&u64| 50 * changes < self.steps;
        self.target_changes.iter().filter(is_still).count()
    }

    /// The targets of a step, and of the one before if there is one.
    fn compare(&mut self, before: &[f64], targets: &[f64]) {
        for ((changes, before), target) in self.target_changes.iter_mut().zip(before).zip(targets) {
            *changes += u64::from(before != target);
        }
    }

    fn add(&mut self, step: &RolloutStep<'_>, n_contacts: usize) {
        let n = self.steps as f64;
        let Evaluation { terms, advance_m, heading_change_rad, penalised_contacts, .. } = step.did;
        self.advance_m += advance_m / n;
        self.heading_change_rad += heading_change_rad;
        self.intrinsic_nats += terms.intrinsic_nats / n;
        self.penalised_contacts += penalised_contacts as u64;
        let readings = &step.episode.readings().values;
        let contacts = &readings[readings.len() - n_contacts..];
        for (share, contact) in self.contacts.iter_mut().zip(contacts) {
            *share += contact / n;
        }
    }
}
