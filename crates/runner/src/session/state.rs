//! All of a cell that changes, as the sections of its checkpoint.

use std::{collections::BTreeMap, path::Path};

use runs::{Checkpoint, Header, Recording};
use serde::{Serialize, de::DeserializeOwned};

use super::{Error, Session};

const WORLD: &str = "world";
const INPUTS: &str = "inputs";
const PARAMETERS: &str = "parameters";
/// The policy's random numbers.
const CHAINS: &str = "chains";
const REWARD: &str = "reward";
const ESTIMATOR: &str = "estimator";
const OPTIMISER: &str = "optimiser";
const RECORDING: &str = "recording";
/// Only there within an update: between two of them its sums begin anew.
const TALLY: &str = "tally";

impl Session {
    /// The sections of a checkpoint. To be taken between control steps, once the robot has settled.
    ///
    /// # Errors
    /// A cell that blew up.
    pub fn save(&mut self) -> Result<BTreeMap<String, Vec<u8>>, Error> {
        let world = self.episode.body.save().map_err(|error| self.blew_up(error))?;
        let recording = self.recording().section().map_err(|error| self.blew_up(error))?;
        let mut sections = vec![
            (WORLD, world),
            (INPUTS, self.bytes(&self.episode.inputs())?),
            (PARAMETERS, self.bytes(&self.policy.parameters())?),
            (CHAINS, self.bytes(&self.policy.random_state())?),
            (REWARD, self.bytes(&self.episode.reward.save())?),
            (ESTIMATOR, self.bytes(&self.estimator.state())?),
            (OPTIMISER, self.bytes(&self.optimiser.state())?),
            (RECORDING, recording),
        ];
        if !self.is_between_updates() {
            sections.push((TALLY, self.bytes(&self.tally)?));
        }
        Ok(sections.into_iter().map(|(name, bytes)| (name.to_owned(), bytes)).collect())
    }

    fn bytes<T: Serialize>(&self, value: &T) -> Result<Vec<u8>, Error> {
        postcard::to_allocvec(value).map_err(|error| self.blew_up(error))
    }

    /// Goes on from a checkpoint, with the same bits. The session must be a fresh
    /// [`Session::build`] of the same cell.
    ///
    /// # Errors
    /// A section that is missing or doesn't fit. The session is then of no use.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), Error> {
        self.restore_episode(checkpoint)?;
        self.restore_learner(checkpoint)?;
        self.restore_progress(checkpoint)
    }

    fn restore_episode(&mut self, checkpoint: &Checkpoint) -> Result<(), Error> {
        let world = self.episode.body.restore(part(checkpoint, WORLD)?);
        world.map_err(|error| misfit(WORLD, error))?;

        let inputs: Vec<bool> = read(checkpoint, INPUTS)?;
        let n_inputs = self.episode.inputs().len();
        if inputs.len() != n_inputs {
            let message = format!("{} bits, and the cell has {n_inputs}", inputs.len());
            return Err(misfit(INPUTS, message));
        }
        self.episode.codec.restore(&inputs);

        let words: Vec<u64> = read(checkpoint, REWARD)?;
        self.episode.reward.restore(&words).map_err(|error| misfit(REWARD, error))?;
        self.episode.restored();
        Ok(())
    }

    fn restore_learner(&mut self, checkpoint: &Checkpoint) -> Result<(), Error> {
        let parameters: Vec<f64> = read(checkpoint, PARAMETERS)?;
        self.policy.set_parameters(&parameters).map_err(|error| misfit(PARAMETERS, error))?;
        let words: Vec<u32> = read(checkpoint, CHAINS)?;
        self.policy.set_random_state(&words).map_err(|error| misfit(CHAINS, error))?;

        let state: Vec<f64> = read(checkpoint, ESTIMATOR)?;
        self.estimator.restore(&state).map_err(|error| misfit(ESTIMATOR, error))?;
        let state: Vec<f64> = read(checkpoint, OPTIMISER)?;
        self.optimiser.restore(&state).map_err(|error| misfit(OPTIMISER, error))
    }

    fn restore_progress(&mut self, checkpoint: &Checkpoint) -> Result<(), Error> {
        let recording = Recording::decode(Path::new("checkpoint"), part(checkpoint, RECORDING)?);
        let recording = recording.map_err(|error| misfit(RECORDING, error))?;
        self.ring.restore(&recording).map_err(|error| misfit(RECORDING, error))?;

        let Header { updates, control_steps, .. } = checkpoint.header;
        let (steps, all) = (self.estimator.steps(), self.steps_per_update);
        if steps_within_update(&checkpoint.header, all) != Some(steps) {
            let message = format!(
                "{steps} control steps since the last update, and the header has {control_steps} \
                 with {updates} updates of {all}"
            );
            return Err(misfit(ESTIMATOR, message));
        }
        (self.updates, self.steps) = (updates, control_steps);
        if !self.is_between_updates() {
            self.tally = read(checkpoint, TALLY)?;
        }
        Ok(())
    }
}

/// How far within an update a checkpoint stands; none if its numbers don't fit each other.
fn steps_within_update(header: &Header, steps_per_update: u64) -> Option<u64> {
    let end = header.updates.checked_add(1)?.checked_mul(steps_per_update)?;
    let within = header.control_steps.checked_sub(end - steps_per_update)?;
    (within < steps_per_update).then_some(within)
}

fn read<T: DeserializeOwned>(checkpoint: &Checkpoint, section: &'static str) -> Result<T, Error> {
    postcard::from_bytes(part(checkpoint, section)?).map_err(|error| misfit(section, error))
}

fn part<'a>(checkpoint: &'a Checkpoint, section: &'static str) -> Result<&'a [u8], Error> {
    let part = checkpoint.sections.get(section);
    part.map(Vec::as_slice).ok_or_else(|| misfit(section, "it's missing"))
}

fn misfit(section: &'static str, message: impl std::fmt::Display) -> Error {
    Error::Checkpoint { section, message: message.to_string() }
}
