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

#[cfg(test)]
mod tests {
    use std::{collections::BTreeSet, path::Path};

    use config::Document;

    use super::*;

    /// `docs/run-folders.md` has the tensors that are written, whatever the connections, and no other.
    #[test]
    fn the_document_has_the_tensors_that_are_written() {
        let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
        let morphology = Morphology::open(&models.join("svenja.toml")).unwrap();
        let mut written = BTreeSet::new();
        for connectivity in ["full", "per_actuator", "per_group"] {
            let text = format!("model = 'svenja.toml'\npolicy.connectivity = '{connectivity}'");
            let experiment =
                Document::parse("test", &text).unwrap().read(Experiment::read).unwrap();
            let layout = layout(&experiment, &morphology, 30).unwrap();
            let bytes = layout.to_safetensors(&vec![0.0; layout.n_parameters()]).unwrap();
            let file = safetensors::SafeTensors::deserialize(&bytes).unwrap();
            written.extend(file.names().iter().map(|name| (*name).to_owned()));
        }
        let page = include_str!("../../../../docs/run-folders.md");
        let (_, section) = page.split_once("\n## `policy.safetensors`\n").unwrap();
        let section = section.split("\n## ").next().unwrap();
        let is_tensor =
            |word: &&str| matches!(word.trim_end_matches("_mask"), "V" | "W" | "b" | "c");
        let named = section.split('`').skip(1).step_by(2).filter(is_tensor).map(str::to_owned);
        assert_eq!(named.collect::<BTreeSet<_>>(), written);
    }
}
