//! What a policy is told of a robot, and the policy that an experiment makes of it.

use std::path::Path;

use anyhow::Context;
use nalgebra::Vector3;
use policy::{Group, Policy, Structure, beside};
use runs::atomic;
use svenja::Morphology;

use super::{Error, episode::robot_layout};
use crate::experiment::Experiment;

/// The policy of an experiment, for the seed's random numbers. Its parameters are 0 where they come
/// from a file.
///
/// # Errors
/// Settings that don't fit the model: one without sensors or actuators, or without groups where the
/// policy goes by groups.
pub fn build_policy(
    experiment: &Experiment,
    morphology: &Morphology,
    seed: u64,
) -> Result<Box<dyn Policy>, Error> {
    Ok(experiment.policy.build(&structure(experiment, morphology), seed)?)
}

/// The policy whose parameters a cell has exported to a file, for any random numbers.
///
/// # Errors
/// As [`build_policy`]; a file that isn't there, is damaged, or is another policy's.
pub fn learned_policy(
    experiment: &Experiment,
    morphology: &Morphology,
    path: &Path,
) -> anyhow::Result<Box<dyn Policy>> {
    let name = || path.display().to_string();
    let bytes = atomic::read(path)?
        .with_context(|| format!("{}: there's none before the first checkpoint", name()))?;
    let mut policy = build_policy(experiment, morphology, 0)?;
    let parameters = policy.read_safetensors(&bytes).with_context(name)?;
    policy.set_parameters(&parameters).with_context(name)?;
    Ok(policy)
}

/// Sets the parameters at the beginning to those of the bytes of a file at `path`.
///
/// # Errors
/// [`Error::Initial`]
pub(super) fn start_from(policy: &mut dyn Policy, path: &str, bytes: &[u8]) -> Result<(), Error> {
    let set = policy.read_safetensors(bytes).and_then(|it| policy.set_parameters(&it));
    set.map_err(|cause| Error::Initial { path: path.into(), cause })
}

/// The robot's bits, and which of them belong together.
fn structure(experiment: &Experiment, morphology: &Morphology) -> Structure {
    let bits = experiment.codec.sensor_bits as usize;
    let sensors = robot_layout(experiment, morphology);
    let bits_of_positions = sensors.n_positions * bits;
    let centres: Vec<_> =
        morphology.groups().iter().map(|group| centre_m(group, morphology)).collect();
    let neighbours = beside(&centres).into_iter();
    let groups = morphology.groups().iter().zip(&sensors.groups).zip(neighbours);
    let group = |((group, sensors), neighbours): ((&svenja::Group, &reward::Group), _)| {
        let positions = sensors.positions.iter().flat_map(|i| i * bits..(i + 1) * bits);
        let contacts = sensors.contacts.iter().map(|i| bits_of_positions + i);
        let is_own = |&i: &usize| group.joints.contains(&morphology.actuators()[i].joint);
        Group {
            name: group.name.clone(),
            inputs: positions.chain(contacts).collect(),
            actuators: (0..morphology.actuators().len()).filter(is_own).collect(),
            neighbours,
        }
    };
    Structure {
        bits_per_reading: bits_of_positions + sensors.n_contacts,
        readings: experiment.policy.memory + 1,
        actuators: morphology.actuators().iter().map(|&id| morphology.axis_name(id)).collect(),
        bits_per_actuator: experiment.codec.actuator_bits as usize,
        groups: groups.map(group).collect(),
    }
}

/// Where a group is, as the model is drawn: the mean position of the bodies that its joints move, or,
/// if it has no joints, of those whose contacts it has.
fn centre_m(group: &svenja::Group, morphology: &Morphology) -> [f64; 3] {
    let moved = group.joints.iter().map(|&joint| morphology.joints()[joint].child);
    let mut bodies: Vec<usize> = moved.collect();
    if bodies.is_empty() {
        bodies.clone_from(&group.contacts);
    }
    let position = |&body: &usize| morphology.bodies()[body].pose.translation.vector;
    let sum: Vector3<f64> = bodies.iter().map(position).sum();
    (sum / bodies.len().max(1) as f64).into()
}

#[cfg(test)]
mod tests {
    use config::Document;
    use proptest::prelude::*;

    use super::*;

    fn structure_of(model: &str, settings: &str) -> Structure {
        let path = format!("{}/../../models/{model}.toml", env!("CARGO_MANIFEST_DIR"));
        let morphology = Morphology::open(path.as_ref()).unwrap();
        let text = format!("model = 'm'\n{settings}");
        let experiment = Document::parse("x", &text).unwrap().read(Experiment::read).unwrap();
        structure(&experiment, &morphology)
    }

    fn neighbours(structure: &Structure) -> Vec<(&str, Vec<&str>)> {
        let name = |&i: &usize| structure.groups[i].name.as_str();
        let of = |group: &Group| group.neighbours.iter().map(name).collect();
        let groups = structure.groups.iter();
        groups.map(|group| (group.name.as_str(), of(group))).collect()
    }

    #[test]
    fn legs_are_beside_those_before_behind_and_across() {
        let expected = [
            ("front left", vec!["front right", "centre left"]),
            ("front right", vec!["front left", "centre right"]),
            ("centre left", vec!["front left", "centre right", "rear left"]),
            ("centre right", vec!["front right", "centre left", "rear right"]),
            ("rear left", vec!["centre left", "rear right"]),
            ("rear right", vec!["centre right", "rear left"]),
        ];
        for model in ["svenja", "svenja-constrained", "hexapod"] {
            assert_eq!(neighbours(&structure_of(model, "")), expected, "{model}");
        }
        let expected = [
            ("front", vec!["middle"]),
            ("middle", vec!["front", "rear"]),
            ("rear", vec!["middle"]),
        ];
        assert_eq!(neighbours(&structure_of("worm", "")), expected);
    }

    #[test]
    fn a_leg_has_the_bits_of_its_joints_and_of_its_foot() {
        let legs = structure_of("svenja", "policy.memory = 2");
        assert_eq!((legs.n_inputs(), legs.n_outputs()), (3 * 30, 24));
        let inputs: Vec<_> = legs.groups.iter().map(|leg| leg.inputs.clone()).collect();
        assert_eq!(inputs[1], [4, 5, 6, 7, 25]);
        assert_eq!(legs.groups[5].actuators, [20, 21, 22, 23]);
        let legs = structure_of("svenja", "codec = { sensor_bits = 2, actuator_bits = 3 }");
        assert_eq!((legs.n_inputs(), legs.n_outputs()), (54, 72));
        assert_eq!(legs.groups[1].inputs, [8, 9, 10, 11, 12, 13, 14, 15, 49]);
    }

    /// Whatever is drawn: each bit of Svenja's, and each actuator, is of one leg.
    #[test]
    fn every_bit_is_of_one_leg() {
        proptest!(|(sensor_bits in 1..8_usize, actuator_bits in 1..8_usize)| {
            let text = format!(
                "codec = {{ sensor_bits = {sensor_bits}, actuator_bits = {actuator_bits} }}"
            );
            let legs = structure_of("svenja", &text);
            let all = |of: fn(&Group) -> &[usize]| {
                let mut all: Vec<_> = legs.groups.iter().flat_map(of).copied().collect();
                all.sort_unstable();
                all
            };
            prop_assert_eq!(all(|leg| &leg.inputs), Vec::from_iter(0..legs.bits_per_reading));
            prop_assert_eq!(all(|leg| &leg.actuators), Vec::from_iter(0..24));
        });
    }
}
