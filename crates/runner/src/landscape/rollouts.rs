//! Policies at work beside each other, in lanes, without learning and without wind: each does what
//! [`roll_out`](crate::rollout::roll_out) does with it, to the last bit.

use gpomdp::{Estimator, EstimatorSettings};
use policy::Policy;
use reward::Terms;

use super::Centre;
use crate::{
    experiment::LearnerSettings,
    session::{Episode, Solver, build_policy, simulate},
};

/// A policy's parameters and the seed of its rollout.
pub(super) struct Job {
    /// `[n_parameters]`
    pub(super) parameters: Vec<f64>,
    /// Where its random numbers come from.
    pub(super) seed: u64,
}

/// Rewards of a control step for which gradients are wished.
pub(super) type Rewards<'a> = dyn Fn(&Terms) -> Vec<f64> + Sync + 'a;

/// Lets each act for so many control steps, all in step: the terms of all steps, `[n_jobs][n_steps]`, NaN
/// from where a world blew up. None if `is_stopped` says so before the end.
///
/// # Errors
/// Settings that don't fit.
pub(super) fn roll_out(
    centre: &Centre,
    jobs: &[Job],
    n_steps: u64,
    solver: &mut Solver,
    is_stopped: &dyn Fn() -> bool,
) -> anyhow::Result<Option<Vec<Vec<Terms>>>> {
    let mut walkers =
        jobs.iter().map(|job| Walker::new(centre, job, None)).collect::<Result<Vec<_>, _>>()?;
    let finished = walk(&mut walkers, n_steps, solver, is_stopped)?;
    Ok(finished.then(|| walkers.into_iter().map(|it| it.terms).collect()))
}

/// The policy gradient of each rollout for each of `rewards`: `[n_jobs][n_rewards][n_parameters]`, by
/// GPOMDP with the cell's discount and the rollout's own mean of the reward as its baseline.
///
/// # Errors
/// As [`roll_out`].
pub(super) fn gradients(
    centre: &Centre,
    jobs: &[Job],
    n_steps: u64,
    solver: &mut Solver,
    rewards: &Rewards<'_>,
    is_stopped: &dyn Fn() -> bool,
) -> anyhow::Result<Option<Vec<Vec<Vec<f64>>>>> {
    let mut walkers = jobs
        .iter()
        .map(|job| Walker::new(centre, job, Some(rewards)))
        .collect::<Result<Vec<_>, _>>()?;
    if !walk(&mut walkers, n_steps, solver, is_stopped)? {
        return Ok(None);
    }
    walkers.into_iter().map(Walker::gradients).collect::<Result<_, _>>().map(Some)
}

/// All of them until the end, if nobody stops them.
fn walk(
    walkers: &mut [Walker<'_>],
    n_steps: u64,
    solver: &mut Solver,
    is_stopped: &dyn Fn() -> bool,
) -> anyhow::Result<bool> {
    let is_settling = |walker: &Walker<'_>| !walker.is_lost && walker.episode.is_settling();
    while walkers.iter().any(is_settling) {
        step(walkers, solver, Walker::rest, Walker::settle)?;
    }
    for _ in 0..n_steps {
        if is_stopped() {
            return Ok(false);
        }
        step(walkers, solver, Walker::act, Walker::evaluate)?;
    }
    walkers.iter_mut().for_each(|walker| walker.terms.resize(n_steps as usize, lost()));
    Ok(true)
}

/// A control step of those whose worlds are whole.
fn step<'r>(
    walkers: &mut [Walker<'r>],
    solver: &mut Solver,
    before: impl Fn(&mut Walker<'r>) -> anyhow::Result<()>,
    after: impl Fn(&mut Walker<'r>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut whole: Vec<_> = walkers.iter_mut().filter(|walker| !walker.is_lost).collect();
    whole.iter_mut().try_for_each(|walker| before(walker))?;
    let mut episodes: Vec<_> = whole.iter_mut().map(|walker| &mut walker.episode).collect();
    let results = simulate(&mut episodes, solver);
    for (walker, result) in whole.into_iter().zip(results) {
        walker.is_lost = result.is_err() || after(walker).is_err();
    }
    Ok(())
}

/// The terms of a control step that there wasn't.
fn lost() -> Terms {
    Terms {
        reward: f64::NAN,
        extrinsic_raw: f64::NAN,
        intrinsic_nats: f64::NAN,
        ..Terms::default()
    }
}

/// A policy in its world.
struct Walker<'r> {
    episode: Episode,
    policy: Box<dyn Policy>,
    action: Vec<bool>,
    terms: Vec<Terms>,
    is_lost: bool,
    ascent: Option<Ascent<'r>>,
}

/// What gradients are made of.
struct Ascent<'r> {
    rewards: &'r Rewards<'r>,
    /// The last act's, `[n_parameters]`.
    score: Vec<f64>,
    settings: EstimatorSettings,
    /// One a reward, and one more for a reward of 1, by which baselines are taken off later.
    estimators: Vec<Estimator>,
}

impl<'r> Walker<'r> {
    fn new(centre: &Centre, job: &Job, rewards: Option<&'r Rewards<'r>>) -> anyhow::Result<Self> {
        let Centre { experiment, morphology, .. } = centre;
        let mut policy = build_policy(experiment, morphology, 0)?;
        policy.set_parameters(&job.parameters)?;
        policy.draw_from(job.seed, "rollout");
        let settings = match &experiment.learning.learner {
            LearnerSettings::Gpomdp(own) => {
                EstimatorSettings { baseline_factor: None, ..own.clone() }
            }
            LearnerSettings::Evolution(_) => EstimatorSettings::default(),
        };
        let ascent = rewards.map(|rewards| Ascent {
            rewards,
            score: vec![0.0; policy.parameters().len()],
            settings,
            estimators: Vec::new(),
        });
        Ok(Self {
            episode: Episode::new(experiment, morphology, job.seed)?,
            action: vec![false; policy.n_outputs()],
            policy,
            terms: Vec::new(),
            is_lost: false,
            ascent,
        })
    }

    fn rest(&mut self) -> anyhow::Result<()> {
        self.episode.rest()
    }

    fn settle(&mut self) -> anyhow::Result<()> {
        self.episode.settle()
    }

    fn act(&mut self) -> anyhow::Result<()> {
        let inputs = self.episode.inputs();
        match &mut self.ascent {
            None => self.policy.act(inputs, &mut self.action)?,
            Some(Ascent { score, .. }) => {
                self.policy.act_and_score(inputs, &mut self.action, score)?
            }
        }
        self.episode.act(&self.action)
    }

    fn evaluate(&mut self) -> anyhow::Result<()> {
        let terms = self.episode.evaluate(0)?.terms;
        self.terms.push(terms);
        self.ascent.as_mut().map_or(Ok(()), |ascent| ascent.add(&terms))
    }

    /// `[n_rewards][n_parameters]`
    fn gradients(self) -> anyhow::Result<Vec<Vec<f64>>> {
        anyhow::ensure!(!self.is_lost, "a gradient: the robot blew up");
        let mut estimators = self.ascent.map(|ascent| ascent.estimators).unwrap_or_default();
        let Some(of_one) = estimators.pop() else { return Ok(Vec::new()) };
        let less_baseline = |it: &Estimator| {
            let baseline = it.average_reward();
            let pairs = it.gradient().iter().zip(of_one.gradient());
            pairs.map(|(gradient, one)| gradient - baseline * one).collect()
        };
        Ok(estimators.iter().map(less_baseline).collect())
    }
}

impl Ascent<'_> {
    fn add(&mut self, terms: &Terms) -> anyhow::Result<()> {
        let mut rewards = (self.rewards)(terms);
        rewards.push(1.0);
        if self.estimators.is_empty() {
            let new = |_: &f64| Estimator::new(self.score.len(), &self.settings);
            self.estimators = rewards.iter().map(new).collect::<Result<_, _>>()?;
        }
        for (estimator, reward) in self.estimators.iter_mut().zip(rewards) {
            estimator.accumulate(&self.score, reward)?;
        }
        Ok(())
    }
}
