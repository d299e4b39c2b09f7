//! All of a cell that changes, as the sections of its checkpoint: those of the learner, and those of
//! each world, with its number from the second one on (`world`, `world 2`, ...).

use std::{collections::BTreeMap, fmt::Display, path::Path};

use runs::{Checkpoint, Header, Recording};
use serde::{Serialize, de::DeserializeOwned};

use super::{Error, Session, actor::Actor};

const PARAMETERS: &str = "parameters";
const OPTIMISER: &str = "optimiser";
const RECORDING: &str = "recording";
/// Only there if each update begins where the robots settled.
const SETTLED: &str = "settled";
// Those of a world.
const WORLD: &str = "world";
const INPUTS: &str = "inputs";
/// The policy's random numbers.
const CHAINS: &str = "chains";
const REWARD: &str = "reward";
/// The learner's: of GPOMDP, its estimator.
const LEARNER: &str = "estimator";
/// Only there within an update: between two of them its sums begin anew.
const TALLY: &str = "tally";
/// Likewise, the sum that the tally didn't have at first; without it it isn't known.
const ENTROPY: &str = "entropy";

impl Session {
    /// The sections of a checkpoint. To be taken between control steps, once the robots have settled.
    ///
    /// # Errors
    /// A cell that blew up.
    pub fn save(&mut self) -> Result<BTreeMap<String, Vec<u8>>, Error> {
        let is_within = !self.is_between_updates();
        self.sections(is_within).map_err(|error| self.blew_up(error))
    }

    fn sections(&mut self, is_within: bool) -> anyhow::Result<BTreeMap<String, Vec<u8>>> {
        let mut sections = BTreeMap::from([
            (PARAMETERS.to_owned(), bytes(&self.policy.parameters())?),
            (OPTIMISER.to_owned(), bytes(&self.optimiser.state())?),
            (RECORDING.to_owned(), self.recording().section()?),
        ]);
        if let Some(settled) = &self.settled {
            sections.insert(SETTLED.to_owned(), bytes(settled)?);
        }
        for (world, actor) in self.actors.iter_mut().enumerate() {
            let mut saved = actor.save(is_within)?;
            saved.push((LEARNER, bytes(&self.learner.state(world))?));
            let saved = saved.into_iter();
            sections.extend(saved.map(|(section, bytes)| (numbered(section, world), bytes)));
        }
        Ok(sections)
    }

    /// Goes on from a checkpoint, with the same bits. The session must be a fresh
    /// [`Session::build`] of the same cell.
    ///
    /// # Errors
    /// A section that is missing or doesn't fit. The session is then of no use.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), Error> {
        let sections = Sections { checkpoint, world: 0 };
        sections.put::<Vec<f64>, _>(PARAMETERS, |it| self.policy.set_parameters(&it))?;
        sections.put::<Vec<f64>, _>(OPTIMISER, |it| self.optimiser.restore(&it))?;
        let recording = Recording::decode(Path::new("checkpoint"), sections.part(RECORDING)?);
        let recording = recording.map_err(|error| sections.misfit(RECORDING, error))?;
        self.ring.restore(&recording).map_err(|error| sections.misfit(RECORDING, error))?;
        if self.learner.begins_anew() {
            self.settled = Some(sections.read(SETTLED)?);
        }
        self.updates = checkpoint.header.updates;
        self.steps = checkpoint.header.control_steps / self.worlds() as u64;
        self.restore_worlds(checkpoint)?;
        self.hand_out_parameters()
    }

    fn restore_worlds(&mut self, checkpoint: &Checkpoint) -> Result<(), Error> {
        let within = steps_within_update(&checkpoint.header, self.steps_per_update, self.worlds());
        for (world, actor) in self.actors.iter_mut().enumerate() {
            let sections = Sections { checkpoint, world };
            actor.restore(&sections)?;
            let learner = &mut self.learner;
            sections.put::<Vec<f64>, _>(LEARNER, |state| learner.restore(world, &state))?;
            let steps = learner.steps(world);
            if within != Some(steps) {
                let Header { updates, control_steps, .. } = checkpoint.header;
                let message = format!(
                    "{steps} control steps since the last update, and the header has \
                     {control_steps} with {updates} updates of {}",
                    self.steps_per_update
                );
                return Err(sections.misfit(LEARNER, message));
            }
            if steps > 0 {
                actor.sums = sections.read(TALLY)?;
                actor.sums.entropy_nats = sections.read_or(ENTROPY, f64::NAN)?;
            }
        }
        Ok(())
    }
}

impl Actor {
    fn save(&mut self, is_within_update: bool) -> anyhow::Result<Vec<(&'static str, Vec<u8>)>> {
        let mut sections = vec![
            (WORLD, self.episode.body.save()?),
            (INPUTS, bytes(&self.episode.inputs())?),
            (CHAINS, bytes(&self.policy.random_state())?),
            (REWARD, bytes(&self.episode.reward.save())?),
        ];
        if is_within_update {
            sections.push((TALLY, bytes(&self.sums)?));
            sections.push((ENTROPY, bytes(&self.sums.entropy_nats)?));
        }
        Ok(sections)
    }

    fn restore(&mut self, sections: &Sections<'_>) -> Result<(), Error> {
        let Self { episode, policy, .. } = self;
        let world = episode.body.restore(sections.part(WORLD)?);
        world.map_err(|error| sections.misfit(WORLD, error))?;
        let n_inputs = episode.inputs().len();
        sections.put::<Vec<bool>, _>(INPUTS, |inputs| {
            if inputs.len() != n_inputs {
                return Err(format!("{} bits, and the cell has {n_inputs}", inputs.len()));
            }
            episode.codec.restore(&inputs);
            Ok(())
        })?;
        sections.put::<Vec<u64>, _>(REWARD, |words| episode.reward.restore(&words))?;
        episode.restored();

        sections.put::<Vec<u32>, _>(CHAINS, |words| policy.set_random_state(&words))
    }
}

/// How far within an update a checkpoint stands, in control steps of each world; none if its numbers
/// don't fit each other.
fn steps_within_update(header: &Header, steps_per_update: u64, worlds: usize) -> Option<u64> {
    let worlds = worlds as u64;
    let steps = header.control_steps / worlds;
    let end = header.updates.checked_add(1)?.checked_mul(steps_per_update)?;
    let within = steps.checked_sub(end - steps_per_update)?;
    (header.control_steps.is_multiple_of(worlds) && within < steps_per_update).then_some(within)
}

/// A world's section by its name in the file. The first world's are as those of a cell of one.
fn numbered(section: &str, world: usize) -> String {
    if world == 0 { section.to_owned() } else { format!("{section} {}", world + 1) }
}

fn bytes<T: Serialize>(value: &T) -> Result<Vec<u8>, postcard::Error> {
    postcard::to_allocvec(value)
}

/// The sections of a checkpoint that one world has, with the learner's for the first.
struct Sections<'a> {
    checkpoint: &'a Checkpoint,
    world: usize,
}

impl Sections<'_> {
    fn part(&self, section: &str) -> Result<&[u8], Error> {
        let part = self.checkpoint.sections.get(&numbered(section, self.world));
        part.map(Vec::as_slice).ok_or_else(|| self.misfit(section, "it's missing"))
    }

    fn read<T: DeserializeOwned>(&self, section: &str) -> Result<T, Error> {
        postcard::from_bytes(self.part(section)?).map_err(|error| self.misfit(section, error))
    }

    /// Reads a section that older checkpoints don't have.
    fn read_or<T: DeserializeOwned>(&self, section: &str, otherwise: T) -> Result<T, Error> {
        match self.checkpoint.sections.contains_key(&numbered(section, self.world)) {
            true => self.read(section),
            false => Ok(otherwise),
        }
    }

    /// Reads a section for whoever goes back to what it has.
    fn put<T: DeserializeOwned, E: Display>(
        &self,
        section: &str,
        restore: impl FnOnce(T) -> Result<(), E>,
    ) -> Result<(), Error> {
        restore(self.read(section)?).map_err(|error| self.misfit(section, error))
    }

    fn misfit(&self, section: &str, message: impl Display) -> Error {
        Error::Checkpoint { section: numbered(section, self.world), message: message.to_string() }
    }
}
