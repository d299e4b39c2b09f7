//! What a policy is told of the robot: its bits, and which of them belong together.

use std::collections::BTreeSet;

use serde::Serialize;

use crate::Error;

/// Bits of readings and of targets, by actuators and groups.
///
/// The policy's inputs are the bits of the last readings, one reading after the other: input k is
/// bit k mod [`bits_per_reading`](Self::bits_per_reading) of its reading. Its outputs are the bits
/// of the targets, one actuator after the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Structure {
    /// Bits of a reading.
    pub bits_per_reading: usize,
    /// Readings that the policy sees: the newest, and those that it remembers.
    pub readings: usize,
    /// Names of the actuators, for messages.
    pub actuators: Vec<String>,
    /// Bits of an actuator's target.
    pub bits_per_actuator: usize,
    /// Parts of the robot, as its legs. What is in none of them belongs to the whole.
    pub groups: Vec<Group>,
}

/// A part of a robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Unique among the groups.
    pub name: String,
    /// Bits of a reading, below [`Structure::bits_per_reading`].
    pub inputs: Vec<usize>,
    /// Indices of actuators. One that is in several groups counts for the first.
    pub actuators: Vec<usize>,
    /// Indices of the groups beside it; [`beside`](crate::beside) finds them.
    pub neighbours: Vec<usize>,
}

/// Which inputs the part of a policy sees that acts for a group. Inputs of no group are seen by all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Inputs {
    /// Every unit sees every input.
    #[default]
    All,
    /// Those of the group.
    OwnGroup,
    /// Those of the group and of the groups beside it.
    Neighbours,
}

impl Inputs {
    /// The words for it in files.
    pub(crate) const WORDS: [(&str, Self); 3] =
        [("all", Self::All), ("own_group", Self::OwnGroup), ("neighbours", Self::Neighbours)];

    /// What the key means that chooses among these words.
    pub(crate) const ABOUT: &str = "which inputs a block or a group's machine sees: `\"all\"`; \
        `\"own_group\"`: those of the group that its outputs are in; `\"neighbours\"`: those of the \
        groups beside it, too";

    pub(crate) fn word(self) -> &'static str {
        Self::WORDS.iter().find(|(_, inputs)| *inputs == self).map_or("", |(word, _)| word)
    }

    pub(crate) fn is_all(&self) -> bool {
        *self == Self::All
    }
}

impl Structure {
    /// Bits that the policy sees.
    #[must_use]
    pub fn n_inputs(&self) -> usize {
        self.readings * self.bits_per_reading
    }

    /// Bits that the policy draws.
    #[must_use]
    pub fn n_outputs(&self) -> usize {
        self.actuators.len() * self.bits_per_actuator
    }

    /// That there is something to see and something to do, and that indices and names are of
    /// something.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if self.n_inputs() == 0 {
            return Err(Error::misfit("model", "the robot has no sensors to act by"));
        }
        if self.n_outputs() == 0 {
            return Err(Error::misfit("model", "the robot has no actuators to act with"));
        }
        let mut names = BTreeSet::new();
        for group in &self.groups {
            let name = &group.name;
            let refuse = |what: &str, expected: String, value: &dyn ToString| {
                let argument = format!("{what} of group '{name}'");
                Err(Error::argument("Structure", argument, expected, value.to_string()))
            };
            if !names.insert(name) {
                return refuse("name", "unique".into(), name);
            }
            let lists = [
                ("input", &group.inputs, self.bits_per_reading),
                ("actuator", &group.actuators, self.actuators.len()),
                ("neighbour", &group.neighbours, self.groups.len()),
            ];
            for (what, indices, count) in lists {
                if let Some(index) = indices.iter().find(|&&index| index >= count) {
                    return refuse(what, format!("below {count}"), index);
                }
            }
        }
        Ok(())
    }

    /// The group of an actuator, which `key` needs.
    pub(crate) fn group_of(
        &self,
        actuator: usize,
        key: &'static str,
        value: &str,
    ) -> Result<usize, Error> {
        let group = self.groups.iter().position(|group| group.actuators.contains(&actuator));
        group.ok_or_else(|| {
            let message = format!("{value}, but '{}' is in no group", self.actuators[actuator]);
            Error::misfit(key, message)
        })
    }

    /// The groups that have actuators, in the order of these, and the number of each actuator's
    /// group among them: `[n_actuators]`.
    pub(crate) fn acting_groups(
        &self,
        key: &'static str,
        value: &str,
    ) -> Result<(Vec<usize>, Vec<usize>), Error> {
        let (mut groups, mut of_actuators) = (Vec::new(), Vec::new());
        for actuator in 0..self.actuators.len() {
            let group = self.group_of(actuator, key, value)?;
            let number = groups.iter().position(|&other| other == group).unwrap_or_else(|| {
                groups.push(group);
                groups.len() - 1
            });
            of_actuators.push(number);
        }
        Ok((groups, of_actuators))
    }

    /// Whether what acts for a group sees each input, of each reading: `[n_inputs]`.
    pub(crate) fn seen_by(&self, group: usize, inputs: Inputs) -> Vec<bool> {
        let own = &self.groups[group];
        let is_seen = |bit: usize| {
            let has = |&group: &usize| self.groups[group].inputs.contains(&bit);
            match inputs {
                Inputs::All => true,
                _ if !(0..self.groups.len()).any(|group| has(&group)) => true,
                Inputs::OwnGroup => has(&group),
                Inputs::Neighbours => has(&group) || own.neighbours.iter().any(has),
            }
        };
        let of_reading: Vec<bool> = (0..self.bits_per_reading).map(is_seen).collect();
        of_reading.repeat(self.readings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two legs beside each other and a tail; bit 4 and the last actuator belong to none.
    fn structure() -> Structure {
        let group =
            |name: &str, inputs: &[usize], actuators: &[usize], neighbours: &[usize]| Group {
                name: name.into(),
                inputs: inputs.into(),
                actuators: actuators.into(),
                neighbours: neighbours.into(),
            };
        Structure {
            bits_per_reading: 5,
            readings: 2,
            actuators: ["a", "b", "c", "d"].map(str::to_owned).into(),
            bits_per_actuator: 1,
            groups: vec![
                group("left", &[0, 3], &[2], &[1]),
                group("right", &[1], &[0, 1], &[0]),
                group("tail", &[2], &[], &[]),
            ],
        }
    }

    #[test]
    fn all_readings_are_seen_alike_and_what_belongs_to_no_group_by_all() {
        let seen = |group, inputs| -> Vec<usize> {
            let seen = structure().seen_by(group, inputs);
            (0..seen.len()).filter(|&input| seen[input]).collect()
        };
        assert_eq!(seen(0, Inputs::OwnGroup), [0, 3, 4, 5, 8, 9]);
        assert_eq!(seen(0, Inputs::Neighbours), [0, 1, 3, 4, 5, 6, 8, 9]);
        assert_eq!(seen(2, Inputs::Neighbours), [2, 4, 7, 9]);
        assert_eq!(seen(2, Inputs::All).len(), 10);
    }

    #[test]
    fn groups_are_numbered_as_their_actuators_come() {
        let mut structure = structure();
        let message = structure.acting_groups("policy.x", "y").unwrap_err().to_string();
        assert_eq!(message, "policy.x: y, but 'd' is in no group");
        structure.groups[0].actuators.push(3);
        let (groups, of_actuators) = structure.acting_groups("policy.x", "y").unwrap();
        assert_eq!((groups, of_actuators), (vec![1, 0], vec![0, 0, 1, 1]));
    }

    #[test]
    fn indices_and_names_are_checked() {
        let refused = |change: fn(&mut Structure), expected: &str| {
            let mut structure = structure();
            change(&mut structure);
            assert_eq!(structure.check().unwrap_err().to_string(), expected);
        };
        assert!(structure().check().is_ok());
        refused(|s| s.readings = 0, "model: the robot has no sensors to act by");
        refused(|s| s.actuators.clear(), "model: the robot has no actuators to act with");
        refused(
            |s| s.groups[1].inputs.push(5),
            "Structure: input of group 'right' must be below 5, got 5",
        );
        refused(
            |s| s.groups[2].neighbours.push(3),
            "Structure: neighbour of group 'tail' must be below 3, got 3",
        );
        refused(
            |s| s.groups[2].name = "left".into(),
            "Structure: name of group 'left' must be unique, got left",
        );
    }
}
