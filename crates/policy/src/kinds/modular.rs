//! One small conditional restricted Boltzmann machine for each of the robot's groups: a leg draws its
//! own targets from what it sees.
//!
//! ```text
//! p(y|x) = prod_g p_g(y_g|x_g)         score = the modules' scores, side by side
//! ```
//!
//! The distributions are those of one machine with a block of hidden units for each group that sees
//! the same inputs ([`Connectivity::PerGroup`](super::Connectivity::PerGroup)); but each module has
//! its own chains, its own part of the parameters, and its own tensors in a file: `front left/V`,
//! `front left/c`, `front left/W`, `front left/b`.

use std::ops::Range;

use config::{Rule, Section, one_of};
use crbm::{ChainRng, Instructions, Layout};
use serde::Serialize;

use super::{Build, MachineSettings};
use crate::{
    Error, Inputs, Link, Policy, Structure,
    error::{check_length, zeros},
    policy::check_act,
    tensors::{Tensors, expect_same_layout},
};

/// Settings of the modules.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModularSettings {
    /// Sizes and sampling of each.
    #[serde(flatten)]
    pub machine: MachineSettings,
    /// Which inputs each of them sees.
    pub inputs: Inputs,
}

impl Default for ModularSettings {
    fn default() -> Self {
        Self { machine: MachineSettings::with(8), inputs: Inputs::OwnGroup }
    }
}

impl ModularSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let default = Self::default();
        let inputs = one_of(&Inputs::WORDS).about(Inputs::ABOUT);
        Some(Self {
            machine: MachineSettings::read(section, &default.machine),
            inputs: section.or("inputs", inputs, default.inputs),
        })
    }
}

impl Build for ModularSettings {
    fn build(&self, structure: &Structure) -> Result<Box<dyn Policy>, Error> {
        Ok(Box::new(Modular::new(self, structure)?))
    }
}

/// A machine for each group that has actuators.
#[derive(Clone, Debug)]
pub struct Modular {
    n_inputs: usize,
    n_outputs: usize,
    modules: Vec<Module>,
    parameters: Vec<f64>,
    tensors: Tensors,
}

/// A group's machine.
#[derive(Clone, Debug)]
struct Module {
    /// The group's name.
    name: String,
    /// Which of the robot's inputs it sees, increasing.
    inputs: Vec<usize>,
    /// Which of the robot's outputs it draws, increasing.
    outputs: Vec<usize>,
    /// Where its parameters are among all.
    parameters: Range<usize>,
    machine: crbm::Policy,
    chains: ChainRng,
    /// What it sees, as long as `inputs`.
    x: Vec<bool>,
    /// What it drew, as long as `outputs`.
    y: Vec<bool>,
}

impl Modular {
    /// With all parameters 0.
    ///
    /// # Errors
    /// A group whose module would be too large, or an actuator that is in no group.
    pub fn new(settings: &ModularSettings, structure: &Structure) -> Result<Self, Error> {
        structure.check()?;
        let (groups, of_actuators) = structure.acting_groups("policy.kind", "modular")?;
        let (mut modules, mut tensors, mut end) = (Vec::new(), Vec::new(), 0);
        for (number, &group) in groups.iter().enumerate() {
            let bits = structure.bits_per_actuator;
            let is_own = |&output: &usize| of_actuators[output / bits] == number;
            let seen = structure.seen_by(group, settings.inputs);
            let module = Module::new(
                settings,
                &structure.groups[group].name,
                (0..seen.len()).filter(|&input| seen[input]).collect(),
                (0..structure.n_outputs()).filter(is_own).collect(),
                end,
            )?;
            end = module.parameters.end;
            tensors.extend(module.tensors());
            modules.push(module);
        }
        Ok(Self {
            n_inputs: structure.n_inputs(),
            n_outputs: structure.n_outputs(),
            modules,
            parameters: zeros(end)?,
            tensors: Tensors::new("modular", tensors),
        })
    }

    /// Each module's name, layout and place among the parameters.
    pub fn modules(&self) -> impl Iterator<Item = (&str, &Layout, Range<usize>)> {
        self.modules
            .iter()
            .map(|module| (&*module.name, module.machine.layout(), module.parameters.clone()))
    }

    /// Runs on these instructions from now on. The results are the same.
    ///
    /// # Errors
    /// If the processor doesn't have them.
    pub fn set_instructions(&mut self, instructions: Instructions) -> Result<(), Error> {
        for module in &mut self.modules {
            module.machine.set_instructions(instructions)?;
        }
        Ok(())
    }
}

impl Module {
    fn new(
        settings: &ModularSettings,
        name: &str,
        inputs: Vec<usize>,
        outputs: Vec<usize>,
        start: usize,
    ) -> Result<Self, Error> {
        let layout = Layout::full(inputs.len(), settings.machine.hidden_units, outputs.len())?;
        let n = layout.n_parameters();
        let machine = crbm::Policy::new(layout, settings.machine.sampling(), &zeros(n)?)?;
        Ok(Self {
            name: name.into(),
            x: vec![false; inputs.len()],
            y: vec![false; outputs.len()],
            inputs,
            outputs,
            parameters: start..start + n,
            chains: machine.rng(0, name),
            machine,
        })
    }

    /// Its tensors' names and shapes, in the order of its parameters.
    fn tensors(&self) -> [(String, Vec<usize>); 4] {
        let layout = self.machine.layout();
        let (m, k, n) = (layout.n_hidden(), layout.n_inputs(), layout.n_outputs());
        let shapes = [("V", vec![m, k]), ("c", vec![m]), ("W", vec![m, n]), ("b", vec![n])];
        shapes.map(|(letter, shape)| (format!("{}/{letter}", self.name), shape))
    }

    /// Draws, and scores if there is a place for it; `score` is that of all modules.
    fn act(
        &mut self,
        inputs: &[bool],
        outputs: &mut [bool],
        score: Option<&mut [f64]>,
    ) -> Result<(), Error> {
        for (x, &input) in self.x.iter_mut().zip(&self.inputs) {
            *x = inputs[input];
        }
        let Self { machine, chains, x, y, .. } = self;
        match score {
            Some(score) => {
                machine.act_and_score(x, chains, y, &mut score[self.parameters.clone()])?;
            }
            None => machine.act(x, chains, y)?,
        }
        for (&y, &output) in self.y.iter().zip(&self.outputs) {
            outputs[output] = y;
        }
        Ok(())
    }
}

impl Policy for Modular {
    fn n_inputs(&self) -> usize {
        self.n_inputs
    }

    fn n_outputs(&self) -> usize {
        self.n_outputs
    }

    fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), Error> {
        // All of them before the first module changes.
        self.tensors.check("Policy::set_parameters", parameters)?;
        for module in &mut self.modules {
            module.machine.set_parameters(&parameters[module.parameters.clone()])?;
        }
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
        self.modules.iter_mut().try_for_each(|module| module.act(inputs, outputs, Some(score)))
    }

    fn act(&mut self, inputs: &[bool], outputs: &mut [bool]) -> Result<(), Error> {
        check_act(self, inputs, outputs, None)?;
        self.modules.iter_mut().try_for_each(|module| module.act(inputs, outputs, None))
    }

    /// An estimate, as that of its machines: [`crbm::Policy::entropy_nats`].
    fn entropy_nats(&mut self, outputs: &[bool]) -> Result<f64, Error> {
        check_length("Policy::entropy_nats", "outputs", self.n_outputs, outputs.len())?;
        let mut sum = 0.0;
        for Module { machine, y, .. } in &mut self.modules {
            sum += machine.entropy_nats(y)? * y.len() as f64;
        }
        Ok(sum / self.n_outputs as f64)
    }

    /// Each module's chains are a stream of their own: `policy/front left`.
    fn links(&self) -> Vec<Link> {
        let of = |module: &Module| super::links(module.machine.layout(), module.parameters.start);
        self.modules.iter().flat_map(of).collect()
    }

    fn draw_from(&mut self, seed: u64, stream: &str) {
        for module in &mut self.modules {
            module.chains = module.machine.rng(seed, &format!("{stream}/{}", module.name));
        }
    }

    fn random_state(&self) -> Vec<u32> {
        self.modules.iter().flat_map(|module| module.chains.words()).collect()
    }

    fn set_random_state(&mut self, state: &[u32]) -> Result<(), Error> {
        let expected = self.random_state().len();
        check_length("Policy::set_random_state", "state", expected, state.len())?;
        // Modules have the same number of chains.
        let parts = state.chunks(expected / self.modules.len());
        let chains = parts.map(ChainRng::from_words).collect::<Result<Vec<_>, _>>()?;
        for (module, chains) in self.modules.iter_mut().zip(chains) {
            module.chains = chains;
        }
        Ok(())
    }

    fn to_safetensors(&self) -> Result<Vec<u8>, Error> {
        let Self { n_inputs, n_outputs, modules, .. } = self;
        let sizes = format!("modules={} n_inputs={n_inputs} n_outputs={n_outputs}", modules.len());
        self.tensors.write(&sizes, &self.parameters)
    }

    fn read_safetensors(&self, bytes: &[u8]) -> Result<Vec<f64>, Error> {
        expect_same_layout(bytes, &self.to_safetensors()?)?;
        self.tensors.read(bytes)
    }
}
