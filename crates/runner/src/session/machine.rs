//! The policy's machine for a model: how many inputs and outputs, and which hidden unit sees what.

use crbm::{Layout, Mask};
use svenja::Morphology;

use super::Error;
use crate::experiment::{Connectivity, Experiment};

/// The layout of the parameters.
///
/// # Errors
/// A model without sensors or actuators, or without groups where blocks are for groups.
pub(super) fn layout(
    experiment: &Experiment,
    morphology: &Morphology,
    n_inputs: usize,
) -> Result<Layout, Error> {
    let bits = experiment.codec.actuator_bits as usize;
    let n_outputs = morphology.actuators().len() * bits;
    let misfit = |key, message: String| Err(Error::Misfit { key, message });
    if n_inputs == 0 {
        return misfit("model", "the robot has no sensors to act by".into());
    }
    if n_outputs == 0 {
        return misfit("model", "the robot has no actuators to act with".into());
    }
    let block_of_actuator = match experiment.policy.connectivity {
        Connectivity::Full => vec![0; morphology.actuators().len()],
        Connectivity::PerActuator => (0..morphology.actuators().len()).collect(),
        Connectivity::PerGroup => groups_of_actuators(morphology)?,
    };
    let block_of_output: Vec<_> =
        block_of_actuator.iter().flat_map(|&block| std::iter::repeat_n(block, bits)).collect();
    let build = |error: crbm::Error| Error::Build(error.to_string());
    let outputs = Mask::blocks(experiment.policy.hidden_units, &block_of_output).map_err(build)?;
    let inputs = Mask::full(outputs.n_rows(), n_inputs).map_err(build)?;
    Layout::new(inputs, outputs).map_err(build)
}

/// The number of each actuator's group, counted without groups that have no actuator.
fn groups_of_actuators(morphology: &Morphology) -> Result<Vec<usize>, Error> {
    let mut numbers = vec![None; morphology.groups().len()];
    let mut n_used = 0;
    let mut of_actuators = Vec::new();
    for &id in morphology.actuators() {
        let has = |group: &svenja::Group| group.joints.contains(&id.joint);
        let Some(group) = morphology.groups().iter().position(has) else {
            let message = format!("per_group, but '{}' is in no group", morphology.axis_name(id));
            return Err(Error::Misfit { key: "policy.connectivity", message });
        };
        let number = *numbers[group].get_or_insert_with(|| {
            n_used += 1;
            n_used - 1
        });
        of_actuators.push(number);
    }
    Ok(of_actuators)
}
