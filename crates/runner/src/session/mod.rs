//! A cell alive: a robot, a policy, and what makes the policy better.
//!
//! [`control_step`] is one step of the loop for some cells in step, row by row as in
//! ARCHITECTURE.md; after T of them, [`Session::learn`] takes a step of the optimiser.

mod body;
mod codec;
mod error;
mod machine;
mod solver;
mod state;
mod tally;
mod wind;

use std::time::{Duration, Instant};

use crbm::{ChainRng, Policy, Sampling};
use gpomdp::{Estimator, EstimatorSettings, Optimiser};
use svenja::Morphology;

pub use body::{Body, Whereabouts, hold};
pub use codec::{Codec, CodecShape};
pub use error::Error;
pub use solver::Solver;
pub use wind::Wind;

use crate::{
    experiment::Experiment,
    reward::{Group, Reward, SensorLayout, Terms},
    store::{Layout, Recording, Ring, Row, Step as Recorded},
};
use tally::Tally;

/// One training instance at work.
pub struct Session {
    steps_per_update: u64,
    body: Body,
    codec: Codec,
    policy: Policy,
    /// theta, `[n_parameters]`.
    parameters: Vec<f64>,
    chains: ChainRng,
    wind: Wind,
    reward: Reward,
    estimator: Estimator,
    optimiser: Box<dyn Optimiser>,
    ring: Ring,
    tally: Tally,
    /// Control steps in which the robot settles, and how many of them are done.
    settling: (u64, u64),
    /// Control steps done, settling not counted.
    steps: u64,
    updates: u64,
    /// At the end of the last control step.
    whereabouts: Whereabouts,
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
    /// `[n_actuators]`
    targets: Vec<f64>,
    /// `[n_parameters]`
    score: Vec<f64>,
    /// For the record: `[n_sensors]`, `[n_actuators]`, `[n_bodies]`.
    recorded: (Vec<f32>, Vec<f32>, Vec<u8>),
}

impl Session {
    /// A cell that hasn't moved yet.
    ///
    /// # Errors
    /// Settings that don't fit the model.
    pub fn build(
        experiment: &Experiment,
        morphology: &Morphology,
        seed: u64,
    ) -> Result<Self, Error> {
        let build = |error: &dyn std::fmt::Display| Error::Build(error.to_string());
        let body = Body::new(experiment, morphology).map_err(|error| build(&error))?;
        let codec = Codec::new(&codec_shape(experiment, morphology)).map_err(|e| build(&e))?;
        let layout = machine::layout(experiment, morphology, codec.inputs().len())?;
        let parameters = layout
            .random_parameters(experiment.policy.initial_scale, seed, "start")
            .map_err(|error| build(&error))?;
        let sampling = Sampling {
            gibbs_updates: experiment.policy.gibbs_updates,
            samples: experiment.policy.samples,
        };
        let policy = Policy::new(layout, sampling, &parameters).map_err(|error| build(&error))?;
        let sensors = sensor_layout(experiment, morphology);
        let reward = Reward::new(&experiment.reward, &sensors, morphology.locomotion_scale())
            .map_err(|error| build(&error))?;
        let learning = &experiment.learning;
        let estimator =
            EstimatorSettings { discount: learning.discount, baseline_factor: learning.baseline };
        let n = parameters.len();
        let ring_layout = recorded_layout(experiment, morphology, body.frames_per_step());
        let wind = &experiment.perturbation;
        let mut session = Self {
            steps_per_update: learning.steps_per_update,
            wind: Wind::new(wind.every, wind.length, wind.flip_probability, seed),
            estimator: Estimator::new(n, &estimator).map_err(|error| build(&error))?,
            optimiser: learning.optimiser.build(n).map_err(|error| build(&error))?,
            ring: Ring::new(ring_layout, experiment.record.steps as usize)
                .map_err(|e| build(&e))?,
            chains: policy.rng(seed, "policy"),
            whereabouts: body.whereabouts(),
            tally: Tally::default(),
            settling: (experiment.control.settle_steps, 0),
            steps: 0,
            updates: 0,
            policy_time: Duration::ZERO,
            buffers: Buffers {
                output: vec![false; policy.layout().n_outputs()],
                action: vec![false; policy.layout().n_outputs()],
                targets: vec![0.0; morphology.actuators().len()],
                score: vec![0.0; n],
                recorded: Default::default(),
            },
            body,
            codec,
            policy,
            parameters,
            reward,
        };
        if !session.is_settling() {
            session.begin()?;
        }
        Ok(session)
    }

    /// Takes in the first reading.
    fn begin(&mut self) -> Result<(), Error> {
        self.codec.encode(&self.body.readings().values).map_err(|error| self.blew_up(error))?;
        self.reward.begin(self.codec.bins()).map_err(|error| self.blew_up(error))?;
        self.whereabouts = self.body.whereabouts();
        Ok(())
    }

    /// Before the physics of a control step: what the robot shall do.
    fn before(&mut self) -> Result<(), Error> {
        if self.is_settling() {
            self.buffers.targets.fill(0.0);
        } else {
            if self.is_between_updates() {
                self.tally = Tally::begin(self.whereabouts.centre_of_gravity_m);
            }
            self.act().map_err(|error| self.blew_up(error))?;
        }
        self.body.actuate(&self.buffers.targets).map_err(|error| self.blew_up(error))
    }

    /// After the physics of a control step: what it was worth.
    fn after(&mut self) -> Result<(), Error> {
        if self.is_settling() {
            self.settling.1 += 1;
            return if self.is_settling() { Ok(()) } else { self.begin() };
        }
        let terms = self.judge().map_err(|error| self.blew_up(error))?;
        let score = &self.buffers.score;
        let accumulated = self.estimator.accumulate(score, terms.reward);
        accumulated.map_err(|error| self.blew_up(error))?;
        self.record(&terms).map_err(|error| self.blew_up(error))?;
        self.steps += 1;
        Ok(())
    }

    /// Rows 2 to 4: bits of the readings, bits of the action with its score, targets.
    fn act(&mut self) -> anyhow::Result<()> {
        let Buffers { output, action, targets, score, .. } = &mut self.buffers;
        let start = Instant::now();
        self.policy.act_and_score(self.codec.inputs(), &mut self.chains, output, score)?;
        self.policy_time += start.elapsed();
        action.copy_from_slice(output);
        self.wind.perturb(self.steps, action);
        self.codec.decode(action, targets)?;
        Ok(())
    }

    /// Rows 6 and 7: the new readings and what they are worth.
    fn judge(&mut self) -> anyhow::Result<Terms> {
        self.codec.encode(&self.body.readings().values)?;
        let step = self.body.step_since(&self.whereabouts, self.codec.bins());
        let terms = self.reward.evaluate(&step, self.updates)?;
        self.tally.add(&terms, &step, self.body.readings().n_clipped());
        self.whereabouts = self.body.whereabouts();
        Ok(terms)
    }

    /// Row 9, the part that is kept of every step.
    fn record(&mut self, terms: &Terms) -> anyhow::Result<()> {
        let (sensors, actions, contacts) = &mut self.buffers.recorded;
        sensors.clear();
        sensors.extend(self.body.readings().values.iter().map(|&value| value as f32));
        actions.clear();
        actions.extend(self.buffers.targets.iter().map(|&target| target as f32));
        contacts.clear();
        contacts.extend(self.body.contacts());
        self.ring.push(Recorded {
            poses: self.body.poses(),
            sensors,
            actions,
            contacts,
            terms: &terms.as_array(),
        })?;
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
        self.optimiser.update(&mut self.parameters, self.estimator.gradient())?;
        self.policy.set_parameters(&self.parameters)?;
        self.estimator.restart();
        self.updates += 1;
        Ok(())
    }

    fn row(&self) -> Row {
        Row {
            update: self.updates,
            control_steps: self.steps,
            parameter_norm: norm(&self.parameters),
            ..self.tally.row(self.whereabouts.centre_of_gravity_m, self.steps_per_update)
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
            format!("settling, control step {}", self.settling.1 + 1)
        } else {
            format!("control step {} (update {})", self.steps + 1, self.updates + 1)
        }
    }

    /// Whether the robot has yet to come to rest before the first control step.
    #[must_use]
    pub fn is_settling(&self) -> bool {
        self.settling.1 < self.settling.0
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

    /// Updates done.
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
        let bytes = self.policy.layout().to_safetensors(&self.parameters);
        bytes.map_err(|error| self.blew_up(error))
    }

    /// The last control steps.
    #[must_use]
    pub fn recording(&self) -> Recording {
        self.ring.recording()
    }
}

/// One control step of some cells in step: readings to actions, actions to worlds, worlds to
/// rewards. The cells have the same physics; what becomes of one doesn't touch the others.
pub fn control_step(sessions: &mut [&mut Session], solver: &mut Solver) -> Vec<Result<(), Error>> {
    let mut results: Vec<_> = sessions.iter_mut().map(|session| session.before()).collect();
    let mut well: Vec<_> =
        sessions.iter_mut().zip(&mut results).filter(|(_, result)| result.is_ok()).collect();
    let mut bodies: Vec<&mut Body> =
        well.iter_mut().map(|(session, _)| &mut session.body).collect();
    let held = hold(&mut bodies, solver);
    for ((session, result), held) in well.into_iter().zip(held) {
        *result = held.map_err(|error| session.lost(&error)).and_then(|()| session.after());
    }
    results
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}

/// What the codec is made for.
#[must_use]
pub fn codec_shape(experiment: &Experiment, morphology: &Morphology) -> CodecShape {
    CodecShape {
        sensor_bits: experiment.codec.sensor_bits,
        actuator_bits: experiment.codec.actuator_bits,
        memory: experiment.policy.memory,
        n_positions: morphology.sensors().len(),
        n_contacts: morphology.contacts().len(),
    }
}

/// What the reward is told of the model.
#[must_use]
pub fn sensor_layout(experiment: &Experiment, morphology: &Morphology) -> SensorLayout {
    let group = |group: &svenja::Group| {
        let position =
            |(i, id): (usize, &svenja::AxisId)| group.joints.contains(&id.joint).then_some(i);
        let contact = |(i, body): (usize, &usize)| group.contacts.contains(body).then_some(i);
        Group {
            name: group.name.clone(),
            positions: morphology.sensors().iter().enumerate().filter_map(position).collect(),
            contacts: morphology.contacts().iter().enumerate().filter_map(contact).collect(),
        }
    };
    SensorLayout {
        n_positions: morphology.sensors().len(),
        n_contacts: morphology.contacts().len(),
        n_bins: 1 << experiment.codec.sensor_bits,
        groups: morphology.groups().iter().map(group).collect(),
    }
}

/// What is recorded of a control step.
#[must_use]
pub fn recorded_layout(
    experiment: &Experiment,
    morphology: &Morphology,
    frames_per_step: usize,
) -> Layout {
    let axes = |ids: &[svenja::AxisId]| ids.iter().map(|&id| morphology.axis_name(id)).collect();
    let bodies: Vec<_> = morphology.bodies().iter().map(|body| body.name.clone()).collect();
    let contacts = morphology.contacts().iter().map(|&body| bodies[body].clone());
    let positions: Vec<String> = axes(morphology.sensors());
    Layout {
        actuators: axes(morphology.actuators()),
        frames_per_step,
        sensors: positions.into_iter().chain(contacts).collect(),
        terms: Terms::NAMES.map(str::to_owned).into(),
        seconds_per_frame: experiment.record.pose_every as f64 / experiment.physics.frequency_hz,
        bodies,
    }
}

#[cfg(test)]
mod tests;
