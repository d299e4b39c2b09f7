//! One conditional restricted Boltzmann machine for the whole robot, the paper's policy:
//!
//! ```text
//! p(y|x) = 1/Z(x) * sum_h exp(h'V x + h'W y + c'h + b'y)
//! ```
//!
//! The crate `crbm` is the machine; here are the settings that make one for a robot, and which hidden
//! unit is connected with what.

use config::{Rule, Section, one_of};
use crbm::{ChainRng, Instructions, Layout, Mask};
use serde::Serialize;

use super::{Build, MachineSettings};
use crate::{
    Error, Inputs, Link, Policy, Structure,
    error::{check_length, zeros},
    policy::check_act,
    tensors::expect_same_layout,
};

/// Settings of the machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CrbmSettings {
    /// Sizes and sampling.
    #[serde(flatten)]
    pub machine: MachineSettings,
    /// Which outputs a hidden unit sees.
    pub connectivity: Connectivity,
    /// Which inputs a hidden unit of a block sees, by the group of its outputs.
    #[serde(skip_serializing_if = "Inputs::is_all")]
    pub inputs: Inputs,
}

/// Which outputs a hidden unit sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Connectivity {
    /// Every hidden unit is connected with every output.
    Full,
    /// Those of one actuator: a block of hidden units for each.
    PerActuator,
    /// Those of one of the model's groups, of a leg: a block of hidden units for each.
    PerGroup,
}

impl Default for CrbmSettings {
    fn default() -> Self {
        let machine = MachineSettings::with(50);
        Self { machine, connectivity: Connectivity::Full, inputs: Inputs::All }
    }
}

impl CrbmSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let default = Self::default();
        let connectivities = [
            ("full", Connectivity::Full),
            ("per_actuator", Connectivity::PerActuator),
            ("per_group", Connectivity::PerGroup),
        ];
        let connectivity = one_of(&connectivities).about(
            "which outputs a hidden unit sees: `\"full\"`: all; `\"per_actuator\"`, \
             `\"per_group\"`: a block of hidden units for each actuator, or for the actuators of \
             each of the model's groups",
        );
        let inputs = one_of(&Inputs::WORDS)
            .about(Inputs::ABOUT)
            .condition("only `\"all\"` where `connectivity` is `\"full\"`");
        let settings = Self {
            machine: MachineSettings::read(section, &default.machine),
            connectivity: section.or("connectivity", connectivity, default.connectivity),
            inputs: section.or("inputs", inputs, default.inputs),
        };
        if settings.connectivity == Connectivity::Full && !settings.inputs.is_all() {
            section.refuse_value("inputs", "\"all\" where connectivity is \"full\"");
        }
        Some(settings)
    }

    /// What is connected, and with it the layout of the parameters.
    fn layout(&self, structure: &Structure) -> Result<Layout, Error> {
        let n_actuators = structure.actuators.len();
        let block_of_actuator = match self.connectivity {
            Connectivity::Full => vec![0; n_actuators],
            Connectivity::PerActuator => (0..n_actuators).collect(),
            Connectivity::PerGroup => {
                structure.acting_groups("policy.connectivity", "per_group")?.1
            }
        };
        let bits = structure.bits_per_actuator;
        let block_of_output: Vec<usize> =
            block_of_actuator.iter().flat_map(|&block| std::iter::repeat_n(block, bits)).collect();
        let outputs = Mask::blocks(self.machine.hidden_units, &block_of_output)?;
        let inputs = self.input_mask(structure, &block_of_actuator, outputs.n_rows())?;
        Ok(Layout::new(inputs, outputs)?)
    }

    fn input_mask(
        &self,
        structure: &Structure,
        block_of_actuator: &[usize],
        n_hidden: usize,
    ) -> Result<Mask, Error> {
        if self.inputs.is_all() {
            return Ok(Mask::full(n_hidden, structure.n_inputs())?);
        }
        let key = "policy.inputs";
        if self.connectivity == Connectivity::Full {
            let word = self.inputs.word();
            let message =
                format!("{word}, but with connectivity \"full\" a hidden unit is of no group");
            return Err(Error::misfit(key, message));
        }
        let mut seen_by_block: Vec<Vec<bool>> = Vec::new();
        for (actuator, &block) in block_of_actuator.iter().enumerate() {
            // Blocks are numbered in the order of their first actuators.
            if block == seen_by_block.len() {
                let group = structure.group_of(actuator, key, self.inputs.word())?;
                seen_by_block.push(structure.seen_by(group, self.inputs));
            }
        }
        Ok(Mask::from_fn(n_hidden, structure.n_inputs(), |hidden, input| {
            seen_by_block[hidden / self.machine.hidden_units][input]
        })?)
    }
}

impl Build for CrbmSettings {
    fn build(&self, structure: &Structure) -> Result<Box<dyn Policy>, Error> {
        Ok(Box::new(Crbm::new(self, structure)?))
    }
}

/// The machine as a policy of the list.
#[derive(Clone, Debug)]
pub struct Crbm {
    machine: crbm::Policy,
    parameters: Vec<f64>,
    chains: ChainRng,
}

impl Crbm {
    /// With all parameters 0.
    ///
    /// # Errors
    /// Settings that don't fit the robot.
    pub fn new(settings: &CrbmSettings, structure: &Structure) -> Result<Self, Error> {
        structure.check()?;
        let layout = settings.layout(structure)?;
        let parameters = zeros(layout.n_parameters())?;
        let machine = crbm::Policy::new(layout, settings.machine.sampling(), &parameters)?;
        let chains = machine.rng(0, "policy");
        Ok(Self { machine, parameters, chains })
    }

    /// Sizes and connections, and where each parameter is.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        self.machine.layout()
    }

    /// Runs on these instructions from now on. The results are the same.
    ///
    /// # Errors
    /// If the processor doesn't have them.
    pub fn set_instructions(&mut self, instructions: Instructions) -> Result<(), Error> {
        Ok(self.machine.set_instructions(instructions)?)
    }
}

impl Policy for Crbm {
    fn n_inputs(&self) -> usize {
        self.layout().n_inputs()
    }

    fn n_outputs(&self) -> usize {
        self.layout().n_outputs()
    }

    fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), Error> {
        self.machine.set_parameters(parameters)?;
        self.parameters.copy_from_slice(parameters);
        Ok(())
    }

    fn act_and_score(
        &mut self,
        inputs: &[bool],
        outputs: &mut [bool],
        score: &mut [f64],
    ) -> Result<(), Error> {
        check_act(self, inputs, outputs, Some(score))?;
        Ok(self.machine.act_and_score(inputs, &mut self.chains, outputs, score)?)
    }

    fn act(&mut self, inputs: &[bool], outputs: &mut [bool]) -> Result<(), Error> {
        check_act(self, inputs, outputs, None)?;
        Ok(self.machine.act(inputs, &mut self.chains, outputs)?)
    }

    /// An estimate: [`crbm::Policy::entropy_nats`].
    fn entropy_nats(&mut self, outputs: &[bool]) -> Result<f64, Error> {
        Ok(self.machine.entropy_nats(outputs)?)
    }

    fn links(&self) -> Vec<Link> {
        super::links(self.machine.layout(), 0)
    }

    fn draw_from(&mut self, seed: u64, stream: &str) {
        self.chains = self.machine.rng(seed, stream);
    }

    fn random_state(&self) -> Vec<u32> {
        self.chains.words()
    }

    fn set_random_state(&mut self, state: &[u32]) -> Result<(), Error> {
        let expected = self.chains.words().len();
        check_length("Policy::set_random_state", "state", expected, state.len())?;
        self.chains = ChainRng::from_words(state)?;
        Ok(())
    }

    fn to_safetensors(&self) -> Result<Vec<u8>, Error> {
        Ok(self.layout().to_safetensors(&self.parameters)?)
    }

    fn read_safetensors(&self, bytes: &[u8]) -> Result<Vec<f64>, Error> {
        expect_same_layout(bytes, &self.to_safetensors()?)?;
        Ok(Layout::from_safetensors(bytes)?.1)
    }
}
