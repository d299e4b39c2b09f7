//! All of a cell that changes, as the sections of its checkpoint.

use std::{collections::BTreeMap, path::Path};

use crbm::ChainRng;
use serde::{Serialize, de::DeserializeOwned};

use super::{Error, Session};
use crate::store::{Checkpoint, Recording};

const WORLD: &str = "world";
const INPUTS: &str = "inputs";
const PARAMETERS: &str = "parameters";
const CHAINS: &str = "chains";
const REWARD: &str = "reward";
const ESTIMATOR: &str = "estimator";
const OPTIMISER: &str = "optimiser";
const RECORDING: &str = "recording";

impl Session {
    /// The sections of a checkpoint. To be taken between updates.
    ///
    /// # Errors
    /// A cell that blew up.
    pub fn save(&mut self) -> Result<BTreeMap<String, Vec<u8>>, Error> {
        let world = self.body.save().map_err(|error| self.blew_up(error))?;
        let recording = self.recording().section().map_err(|error| self.blew_up(error))?;
        let sections = [
            (WORLD, world),
            (INPUTS, self.bytes(&self.codec.inputs())?),
            (PARAMETERS, self.bytes(&self.parameters)?),
            (CHAINS, self.bytes(&self.chains.words())?),
            (REWARD, self.bytes(&self.reward.save())?),
            (ESTIMATOR, self.bytes(&self.estimator.state())?),
            (OPTIMISER, self.bytes(&self.optimiser.state())?),
            (RECORDING, recording),
        ];
        Ok(sections.map(|(name, bytes)| (name.to_owned(), bytes)).into())
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
        let part = |section| {
            checkpoint
                .sections
                .get(section)
                .ok_or_else(|| Error::Checkpoint { section, message: "it's missing".into() })
        };
        let misfit = |section, error: &dyn std::fmt::Display| Error::Checkpoint {
            section,
            message: error.to_string(),
        };
        self.body.restore(part(WORLD)?).map_err(|error| misfit(WORLD, &error))?;

        let inputs: Vec<bool> = read(INPUTS, part(INPUTS)?)?;
        if inputs.len() != self.codec.inputs().len() {
            let message =
                format!("{} bits, and the cell has {}", inputs.len(), self.codec.inputs().len());
            return Err(misfit(INPUTS, &message));
        }
        self.codec.restore(&inputs);

        self.parameters = read(PARAMETERS, part(PARAMETERS)?)?;
        let set = self.policy.set_parameters(&self.parameters);
        set.map_err(|error| misfit(PARAMETERS, &error))?;

        let words: Vec<u32> = read(CHAINS, part(CHAINS)?)?;
        let chains = ChainRng::from_words(&words).map_err(|error| misfit(CHAINS, &error))?;
        if chains.n_chains() != self.chains.n_chains() {
            return Err(misfit(CHAINS, &"another number of chains"));
        }
        self.chains = chains;

        let words: Vec<u64> = read(REWARD, part(REWARD)?)?;
        self.reward.restore(&words).map_err(|error| misfit(REWARD, &error))?;
        let state: Vec<f64> = read(ESTIMATOR, part(ESTIMATOR)?)?;
        self.estimator.restore(&state).map_err(|error| misfit(ESTIMATOR, &error))?;
        let state: Vec<f64> = read(OPTIMISER, part(OPTIMISER)?)?;
        self.optimiser.restore(&state).map_err(|error| misfit(OPTIMISER, &error))?;

        let recording = Recording::decode(Path::new("checkpoint"), part(RECORDING)?);
        let recording = recording.map_err(|error| misfit(RECORDING, &error))?;
        self.ring.restore(&recording).map_err(|error| misfit(RECORDING, &error))?;

        self.settling.1 = self.settling.0;
        self.updates = checkpoint.header.updates;
        self.steps = checkpoint.header.control_steps;
        self.whereabouts = self.body.whereabouts();
        Ok(())
    }
}

fn read<T: DeserializeOwned>(section: &'static str, bytes: &[u8]) -> Result<T, Error> {
    postcard::from_bytes(bytes)
        .map_err(|error| Error::Checkpoint { section, message: error.to_string() })
}
