//! A policy at work without learning and without wind.

use crbm::{ChainRng, Policy};
use infotheory::Binning;
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use svenja::Morphology;

use crate::{
    experiment::Experiment,
    gait::Gait,
    reward::{Reward, Terms},
    session::{Body, Codec, Solver, codec_shape, recorded_layout, sensor_layout},
    store::{Recording, Ring, Step},
};

/// What decides about targets.
pub enum Driver {
    /// A policy that was learned, with its random numbers.
    Learned(Box<Policy>, ChainRng),
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
    pub fn learned(policy: Policy, seed: u64) -> Self {
        let chains = policy.rng(seed, "rollout");
        Self::Learned(Box::new(policy), chains)
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

    fn decide(&mut self, step: u64, codec: &Codec, targets: &mut [f64]) -> anyhow::Result<()> {
        match self {
            Self::Learned(policy, chains) => {
                let mut action = vec![false; policy.layout().n_outputs()];
                policy.act(codec.inputs(), chains, &mut action)?;
                codec.decode(&action, targets)?;
            }
            Self::Random(rng) => {
                let bits = codec.actuator_bits() as usize;
                let action: Vec<_> =
                    (0..targets.len() * bits).map(|_| rng.next_u32() >> 31 == 1).collect();
                codec.decode(&action, targets)?;
            }
            Self::Neutral => targets.fill(0.0),
            Self::Gait(gait, binning) => binning.decode(gait.at(step), targets)?,
        }
        Ok(())
    }
}

/// A control step of a rollout.
#[derive(Clone, Copy, Debug)]
pub struct RolloutStep<'a> {
    /// From 0; settling is over.
    pub step: u64,
    /// Centre of gravity in m.
    pub position_m: [f64; 3],
    /// Every term of the reward, `r` with `xi` as at the start of training.
    pub terms: Terms,
    /// Along the heading, in m.
    pub advance_m: f64,
    /// To the left, in rad.
    pub heading_change_rad: f64,
    /// Penalised parts that touch something.
    pub penalised_contacts: usize,
    /// `[n_positions + n_contacts]`
    pub readings: &'a [f64],
    /// `[n_actuators]`
    pub targets: &'a [f64],
    /// `[frames_per_step x n_bodies x 7]`: x y z in m, quaternion x y z w.
    pub poses: &'a [f32],
    /// `[n_bodies]`: 1 for a body that touches something, else 0.
    pub touching: &'a [u8],
}

/// What a rollout did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Control steps.
    pub steps: u64,
    /// Mean along the heading, in m per control step.
    pub advance_m: f64,
    /// From start to end in the XY plane, in m.
    pub net_displacement_m: f64,
    /// To the left, in rad.
    pub heading_change_rad: f64,
    /// Mean information, in nats per sensor or group.
    pub information_nats: f64,
    /// Share of control steps in which each contact sensor was on.
    pub contacts: Vec<f64>,
    /// Control steps times penalised parts that touched.
    pub penalised_contacts: u64,
}

/// Lets a driver act for so many control steps; each is shown to `see`.
///
/// # Errors
/// Settings that don't fit; a robot that blows up; what `see` returns.
pub fn roll_out(
    experiment: &Experiment,
    morphology: &Morphology,
    driver: &mut Driver,
    n_steps: u64,
    mut see: impl FnMut(&RolloutStep<'_>) -> anyhow::Result<()>,
) -> anyhow::Result<Summary> {
    let mut body = Body::new(experiment, morphology)?;
    let mut codec = Codec::new(&codec_shape(experiment, morphology))?;
    let sensors = sensor_layout(experiment, morphology);
    let mut reward = Reward::new(&experiment.reward, &sensors, morphology.locomotion_scale())?;
    let mut targets = vec![0.0; morphology.actuators().len()];
    // Even one world alone is swept faster than by Bullet's own solver.
    let mut solver = Solver::lockstep()?;
    body.actuate(&targets)?;
    for _ in 0..experiment.control.settle_steps {
        body.hold(&mut solver)?;
    }
    codec.encode(&body.readings().values)?;
    reward.begin(codec.bins())?;

    let n_contacts = morphology.contacts().len();
    let mut summary =
        Summary { steps: n_steps, contacts: vec![0.0; n_contacts], ..Summary::default() };
    let start = body.whereabouts().centre_of_gravity_m;
    let mut touching = Vec::new();
    for step in 0..n_steps {
        let before = body.whereabouts();
        driver.decide(step, &codec, &mut targets)?;
        body.actuate(&targets)?;
        body.hold(&mut solver)?;
        codec.encode(&body.readings().values)?;
        let did = body.step_since(&before, codec.bins());
        touching.clear();
        touching.extend(body.contacts());
        let seen = RolloutStep {
            step,
            position_m: body.whereabouts().centre_of_gravity_m.coords.into(),
            terms: reward.evaluate(&did, 0)?,
            advance_m: did.advance_m,
            heading_change_rad: did.heading_change_rad,
            penalised_contacts: did.penalised_contacts,
            readings: &body.readings().values,
            targets: &targets,
            poses: body.poses(),
            touching: &touching,
        };
        summary.add(&seen, n_contacts);
        see(&seen)?;
    }
    let end = body.whereabouts().centre_of_gravity_m;
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
    driver: &mut Driver,
    n_steps: u64,
) -> anyhow::Result<Recording> {
    let frames = experiment.physics_steps_per_control_step() / experiment.record.pose_every;
    let layout = recorded_layout(experiment, morphology, usize::try_from(frames)?);
    let mut ring = Ring::new(layout, usize::try_from(n_steps)?)?;
    let single = |values: &[f64]| values.iter().map(|&value| value as f32).collect::<Vec<_>>();
    roll_out(experiment, morphology, driver, n_steps, |step| {
        ring.push(Step {
            poses: step.poses,
            sensors: &single(step.readings),
            actions: &single(step.targets),
            contacts: step.touching,
            terms: &step.terms.as_array(),
        })?;
        Ok(())
    })?;
    Ok(ring.recording())
}

impl Summary {
    fn add(&mut self, step: &RolloutStep<'_>, n_contacts: usize) {
        let n = self.steps as f64;
        self.advance_m += step.advance_m / n;
        self.heading_change_rad += step.heading_change_rad;
        self.information_nats += step.terms.intrinsic_nats / n;
        self.penalised_contacts += step.penalised_contacts as u64;
        let contacts = &step.readings[step.readings.len() - n_contacts..];
        for (share, contact) in self.contacts.iter_mut().zip(contacts) {
            *share += contact / n;
        }
    }
}
