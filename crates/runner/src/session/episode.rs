//! A robot's life in its world: it acts, feels what came of it, and is told what that was worth.
//! Who decides about its actions is somebody else, who may learn from that or not.
//!
//! A control step is [`Episode::act`] (or [`Episode::aim`]), [`simulate`], [`Episode::evaluate`]. Before the
//! first one the robot settles: [`Episode::rest`], [`simulate`], [`Episode::settle`], as long as it
//! [is settling](Episode::is_settling).

use reward::{Group, Reward, RobotLayout, RobotState, Terms, Transition};
use runs::{RecordingLayout, Step as Recorded};
use serde::{Deserialize, Serialize};
use svenja::{Morphology, Readings};

use super::{Body, Codec, CodecShape, Solver, body};
use crate::experiment::Experiment;

/// A body with what turns its readings into bits, bits into its targets, and its steps into rewards.
pub struct Episode {
    pub(super) body: Body,
    pub(super) codec: Codec,
    pub(super) reward: Reward,
    /// The robot at the end of the last control step, and at that of the one before.
    state: RobotState,
    before: RobotState,
    /// Control steps in which the robot settles, and how many of them are done.
    settling: (u64, u64),
    /// `[n_actuators]`, within -1 to 1.
    targets: Vec<f64>,
    /// The last control step as it's recorded: `[n_sensors]`, `[n_actuators]`, `[n_bodies]`.
    recorded: (Vec<f32>, Vec<f32>, Vec<u8>),
}

/// Where an episode stood between two control steps.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct SettledState {
    /// The world's snapshot.
    world: Vec<u8>,
    /// `[n_inputs]`
    inputs: Vec<bool>,
    /// The reward's state.
    reward: Vec<u64>,
}

/// What a control step did, and what it was worth.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation {
    /// Every term of the reward.
    pub terms: Terms,
    /// Along the heading, in m.
    pub advance_m: f64,
    /// To the left, in rad.
    pub heading_change_rad: f64,
    /// Penalised parts that touch something.
    pub penalised_contacts: usize,
    /// Readings beyond their range.
    pub clipped_readings: usize,
}

impl Episode {
    /// The robot where its model starts, before it has settled. What its task draws is of the seed.
    ///
    /// # Errors
    /// What the world refuses; settings that don't fit the model.
    pub fn new(
        experiment: &Experiment,
        morphology: &Morphology,
        seed: u64,
    ) -> anyhow::Result<Self> {
        let body = Body::new(experiment, morphology)?;
        let layout = robot_layout(experiment, morphology);
        let mut episode = Self {
            codec: Codec::new(&codec_shape(experiment, morphology))?,
            reward: Reward::new(&experiment.reward, &layout, seed)?,
            state: RobotState::default(),
            before: RobotState::default(),
            settling: (experiment.control.settle_steps, 0),
            targets: vec![0.0; morphology.actuators().len()],
            recorded: Default::default(),
            body,
        };
        episode.body.read_state(&mut episode.state);
        if !episode.is_settling() {
            episode.begin()?;
        }
        Ok(episode)
    }

    /// The robot where one like it has settled, of which there is a snapshot: what it would be after
    /// settling itself, to the last bit.
    pub(super) fn settled(
        experiment: &Experiment,
        morphology: &Morphology,
        seed: u64,
        world: &[u8],
    ) -> anyhow::Result<Self> {
        let mut episode = Self::new(experiment, morphology, seed)?;
        if episode.is_settling() {
            episode.body.restore(world)?;
            episode.settling.1 = episode.settling.0;
            episode.begin()?;
        }
        Ok(episode)
    }

    /// Whether the robot has yet to come to rest before the first control step.
    #[must_use]
    pub fn is_settling(&self) -> bool {
        self.settling.1 < self.settling.0
    }

    /// Control steps of settling that are done.
    #[must_use]
    pub fn settled_steps(&self) -> u64 {
        self.settling.1
    }

    /// Before the physics: it shall hold its neutral pose.
    ///
    /// # Errors
    /// What the robot refuses.
    pub fn rest(&mut self) -> anyhow::Result<()> {
        self.targets.fill(0.0);
        Ok(self.body.actuate(&self.targets)?)
    }

    /// After the physics of a step of settling. The last one gives the first reading.
    ///
    /// # Errors
    /// A reading that can't be taken in.
    pub fn settle(&mut self) -> anyhow::Result<()> {
        self.settling.1 += 1;
        if self.is_settling() { Ok(()) } else { self.begin() }
    }

    /// Takes in the first reading, which no action led to.
    fn begin(&mut self) -> anyhow::Result<()> {
        self.codec.encode(&self.body.readings().values)?;
        self.reward.begin(self.codec.bins())?;
        self.body.read_state(&mut self.state);
        Ok(())
    }

    /// What to decide by: the bits of the newest readings, `[n_inputs]`.
    #[must_use]
    pub fn inputs(&self) -> &[bool] {
        self.codec.inputs()
    }

    /// Bits of an action.
    #[must_use]
    pub fn n_outputs(&self) -> usize {
        self.targets.len() * self.codec.actuator_bits() as usize
    }

    /// Before the physics: it shall do an action, `[n_outputs]`.
    ///
    /// # Errors
    /// Another number of bits.
    pub fn act(&mut self, action: &[bool]) -> anyhow::Result<()> {
        self.codec.decode(action, &mut self.targets)?;
        Ok(self.body.actuate(&self.targets)?)
    }

    /// Before the physics: its servos shall have these targets, `[n_actuators]`, within -1 to 1.
    ///
    /// # Errors
    /// Another number of targets, or one that's beyond.
    pub fn aim(&mut self, targets: &[f64]) -> anyhow::Result<()> {
        self.body.actuate(targets)?;
        self.targets.copy_from_slice(targets);
        Ok(())
    }

    /// The physics of a control step, alone.
    ///
    /// # Errors
    /// [`svenja::Error::BlewUp`].
    pub fn simulate(&mut self, solver: &mut Solver) -> Result<(), svenja::Error> {
        simulate(&mut [self], solver).remove(0)
    }

    /// After the physics: takes in the new readings, and tells what the control step was worth,
    /// after so many updates of the policy.
    ///
    /// # Errors
    /// A reading that can't be taken in; a reward that isn't finite.
    pub fn evaluate(&mut self, updates: u64) -> anyhow::Result<Evaluation> {
        let readings = self.body.readings();
        self.codec.encode(&readings.values)?;
        std::mem::swap(&mut self.before, &mut self.state);
        self.body.read_state(&mut self.state);
        let did = Transition {
            before: &self.before,
            after: &self.state,
            bins: self.codec.bins(),
            targets: &self.targets,
            work_j: self.body.work_j(),
        };
        let evaluation = Evaluation {
            terms: self.reward.evaluate(&did, updates)?,
            advance_m: did.advance_m(),
            heading_change_rad: did.heading_change_rad(),
            penalised_contacts: did.after.penalised_contacts,
            clipped_readings: readings.n_clipped(),
        };
        let (sensors, actions, contacts) = &mut self.recorded;
        refill(sensors, readings.values.iter().map(|&value| value as f32));
        refill(actions, self.targets.iter().map(|&target| target as f32));
        refill(contacts, self.state.contacts.iter().map(|&touches| u8::from(touches)));
        Ok(evaluation)
    }

    /// The last control step as it's recorded, with its reward's terms, `[n_terms]`.
    #[must_use]
    pub fn recorded<'a>(&'a self, terms: &'a [f64]) -> Recorded<'a> {
        let (sensors, actions, contacts) = &self.recorded;
        Recorded { poses: self.body.poses(), sensors, actions, contacts, terms }
    }

    /// The newest readings.
    #[must_use]
    pub fn readings(&self) -> &Readings {
        self.body.readings()
    }

    /// What its servos were told last, `[n_actuators]`, within -1 to 1.
    #[must_use]
    pub fn targets(&self) -> &[f64] {
        &self.targets
    }

    /// The robot at the end of the last control step.
    #[must_use]
    pub fn state(&self) -> &RobotState {
        &self.state
    }

    /// Where it stands, to [go back](Self::restart_from) to.
    pub(super) fn settled_state(&mut self) -> anyhow::Result<SettledState> {
        let (inputs, reward) = (self.inputs().to_vec(), self.reward.save());
        Ok(SettledState { world: self.body.save()?, inputs, reward })
    }

    /// Goes back to where this episode, or another one that was the same until then, stood.
    pub(super) fn restart_from(&mut self, settled: &SettledState) -> anyhow::Result<()> {
        self.body.restore(&settled.world)?;
        self.codec.restore(&settled.inputs);
        self.reward.restore(&settled.reward)?;
        self.restored();
        Ok(())
    }

    /// After body, codec and reward have gone back to what was saved of them after settling.
    pub(super) fn restored(&mut self) {
        self.settling.1 = self.settling.0;
        self.body.read_state(&mut self.state);
    }
}

/// The physics of a control step of some episodes in step, which have the same physics: their
/// robots hold their targets. What becomes of one doesn't touch the others.
pub fn simulate(
    episodes: &mut [&mut Episode],
    solver: &mut Solver,
) -> Vec<Result<(), svenja::Error>> {
    let mut bodies: Vec<&mut Body> = episodes.iter_mut().map(|it| &mut it.body).collect();
    body::simulate(&mut bodies, solver)
}

/// Other values in the same memory.
fn refill<T>(buffer: &mut Vec<T>, values: impl Iterator<Item = T>) {
    buffer.clear();
    buffer.extend(values);
}

/// What the codec of an experiment is made for.
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
pub(super) fn robot_layout(experiment: &Experiment, morphology: &Morphology) -> RobotLayout {
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
    RobotLayout {
        n_positions: morphology.sensors().len(),
        n_contacts: morphology.contacts().len(),
        n_bins: 1 << experiment.codec.sensor_bits,
        groups: morphology.groups().iter().map(group).collect(),
        neighbours: neighbours(morphology),
        bodies: morphology.bodies().iter().map(|body| body.name.clone()).collect(),
        heading_body: morphology.heading().body,
        locomotion_scale: morphology.locomotion_scale(),
    }
}

/// Pairs of positions of which one joint moves the body that the other is fixed to.
fn neighbours(morphology: &Morphology) -> Vec<[usize; 2]> {
    // Bodies that are fixed together have one number.
    let mut held: Vec<usize> = (0..morphology.bodies().len()).collect();
    for joint in morphology.joints().iter().filter(|joint| joint.axes.is_empty()) {
        let Some(parent) = joint.parent else { continue };
        let (to, from) = (held[parent], held[joint.child]);
        held.iter_mut().filter(|it| **it == from).for_each(|it| *it = to);
    }
    let joint = |position: usize| &morphology.joints()[morphology.sensors()[position].joint];
    let carries = |a: usize, b: usize| {
        joint(b).parent.is_some_and(|parent| held[joint(a).child] == held[parent])
    };
    let n = morphology.sensors().len();
    let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| [a, b]));
    pairs.filter(|&[a, b]| carries(a, b) || carries(b, a)).collect()
}

/// What is recorded of a control step.
#[must_use]
pub fn recorded_layout(experiment: &Experiment, morphology: &Morphology) -> RecordingLayout {
    let axes = |ids: &[svenja::AxisId]| ids.iter().map(|&id| morphology.axis_name(id)).collect();
    let bodies: Vec<_> = morphology.bodies().iter().map(|body| body.name.clone()).collect();
    let contacts = morphology.contacts().iter().map(|&body| bodies[body].clone());
    let positions: Vec<String> = axes(morphology.sensors());
    RecordingLayout {
        actuators: axes(morphology.actuators()),
        frames_per_step: (experiment.physics_steps_per_control_step()
            / experiment.record.pose_every) as usize,
        sensors: positions.into_iter().chain(contacts).collect(),
        terms: Terms::NAMES.map(str::to_owned).into(),
        seconds_per_frame: experiment.record.pose_every as f64 / experiment.physics.frequency_hz,
        bodies,
    }
}
