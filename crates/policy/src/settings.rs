//! The table `policy` of an experiment file: a kind with its own keys, and the keys that all kinds
//! share.

use config::{Rule, Section, count, one_of, text, within};
use crbm::MAX_PARAMETER;
use serde::{Serialize, Serializer};

use crate::{Error, KindSettings, Policy, Structure, centred::Centred};

/// Which policy acts, and what it begins with.
#[derive(Clone, Debug, PartialEq)]
pub struct PolicySettings {
    /// The kind, with the keys that are its own.
    pub kind: KindSettings,
    /// Earlier readings that the policy sees besides the newest.
    pub memory: usize,
    /// What the parameters count a unit that is off as.
    pub coding: Coding,
    /// The parameters at the beginning.
    pub start: Start,
}

/// Which parameters are learned: the policies that they stand for are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Coding {
    /// A unit is 0 or 1.
    #[default]
    Binary,
    /// A unit is -1/2 or 1/2.
    Centred,
}

impl Coding {
    fn is_binary(&self) -> bool {
        *self == Self::Binary
    }
}

/// The default of `initial_scale`.
const INITIAL_SCALE: f64 = 0.01;

/// The parameters at the beginning.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// Drawn from N(0, s^2) with `initial_scale` for s.
    Random(f64),
    /// `initial`: those of another policy of the same layout, in a safetensors file.
    File(String),
}

impl Default for PolicySettings {
    fn default() -> Self {
        Self {
            kind: KindSettings::default(),
            memory: 0,
            coding: Coding::Binary,
            start: Start::Random(INITIAL_SCALE),
        }
    }
}

impl PolicySettings {
    /// Reads the table.
    pub fn read(section: &mut Section<'_>) -> Option<Self> {
        let kind = KindSettings::read(section);
        let memory =
            count(0, 100).about("earlier readings that the policy sees besides the newest");
        let memory = section.or("memory", memory, 0);
        let coding = one_of(&[("binary", Coding::Binary), ("centred", Coding::Centred)]).about(
            "which parameters are learned, of the same policies: `\"binary\"`: a unit (input, hidden, \
             output) counts 0 or 1; `\"centred\"`: -1/2 or 1/2, so that a weight's gradient is there \
             whether its input is on or off. `policy.safetensors` has those of binary units in any case",
        );
        let coding = section.or("coding", coding, Coding::Binary);
        // No draw is as far out as 10 standard deviations.
        let scale = within(0.0, MAX_PARAMETER / 10.0)
            .about("standard deviation of the random parameters at the start");
        let scale = section.or("initial_scale", scale, INITIAL_SCALE);
        let initial = text()
            .about(
                "in place of random parameters those of a file, as the `policy.safetensors` of \
                 another run's cell, with the same kind, sizes and connections; the run has a copy \
                 of it",
            )
            .condition("a file's path, found as that of `model` is");
        let initial = section.optional("initial", initial);
        if section.has("initial_scale") && section.has("initial") {
            let message = "initial_scale is for random parameters, and initial takes a file's";
            section.complain(&section.place_of("initial_scale"), message);
        }
        let start = match initial {
            Some(path) => Start::File(path),
            None => Start::Random(scale),
        };
        Some(Self { kind: kind?, memory, coding, start })
    }

    /// The policy for a robot, whose [`readings`](Structure::readings) are these settings' memory
    /// and one. Parameters come from the seed's stream `start`, or are 0 as long as those of a file
    /// haven't been [set](Policy::set_parameters); random numbers from its stream `policy`.
    ///
    /// # Errors
    /// Settings that don't fit the robot.
    pub fn build(&self, structure: &Structure, seed: u64) -> Result<Box<dyn Policy>, Error> {
        structure.check()?;
        let mut policy = self.kind.get().build(structure)?;
        if self.coding == Coding::Centred {
            policy = Box::new(Centred::new(policy));
        }
        if let Start::Random(scale) = self.start {
            let n = policy.parameters().len();
            policy.set_parameters(&crbm::random_parameters(n, scale, seed, "start")?)?;
        }
        policy.draw_from(seed, "policy");
        Ok(policy)
    }
}

/// As the table that is read, with nothing in it that an experiment of the time before there were
/// kinds didn't have: what it was told apart by stays the same.
impl Serialize for PolicySettings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Table<'a> {
            #[serde(skip_serializing_if = "Option::is_none")]
            kind: Option<&'static str>,
            #[serde(flatten)]
            own: &'a KindSettings,
            memory: usize,
            #[serde(skip_serializing_if = "Coding::is_binary")]
            coding: Coding,
            #[serde(skip_serializing_if = "Option::is_none")]
            initial_scale: Option<f64>,
            #[serde(skip_serializing_if = "Option::is_none")]
            initial: Option<&'a str>,
        }
        let (initial_scale, initial) = match &self.start {
            Start::Random(scale) => (Some(*scale), None),
            Start::File(path) => (None, Some(path.as_str())),
        };
        let kind = self.kind.name();
        let is_default = kind == KindSettings::default().name();
        let kind = (!is_default).then_some(kind);
        Table {
            kind,
            own: &self.kind,
            memory: self.memory,
            coding: self.coding,
            initial_scale,
            initial,
        }
        .serialize(serializer)
    }
}

#[cfg(test)]
mod tests {
    use config::Document;

    use super::*;

    fn read(text: &str) -> Result<PolicySettings, String> {
        let document = Document::parse("f", text).unwrap();
        document.read(PolicySettings::read).map_err(|problems| problems.to_string())
    }

    /// Whatever kinds there will be.
    #[test]
    fn every_kind_is_read_as_it_is_written() {
        for kind in KindSettings::all() {
            for start in [Start::Random(0.25), Start::File("/a/policy.safetensors".into())] {
                let coding = Coding::Centred;
                let settings = PolicySettings { kind: kind.clone(), memory: 3, coding, start };
                let text = toml::to_string(&settings).unwrap();
                assert_eq!(read(&text).as_ref(), Ok(&settings), "{text}");
            }
            let named = read(&format!("kind = '{}'", kind.name())).unwrap();
            assert_eq!(named.kind, kind);
        }
    }

    /// The text is part of what cells are told apart by.
    #[test]
    fn a_default_policy_is_written_as_ever() {
        let expected = "hidden_units = 50\ngibbs_updates = 10\nsamples = 60\n\
                        connectivity = \"full\"\nmemory = 0\ninitial_scale = 0.01\n";
        assert_eq!(toml::to_string(&PolicySettings::default()).unwrap(), expected);
        assert_eq!(read("").unwrap(), PolicySettings::default());
    }

    #[test]
    fn all_mistakes_are_found() {
        let found = |text| read(text).unwrap_err();
        let kinds = KindSettings::all();
        let kinds: Vec<_> = kinds.iter().map(|kind| format!("{:?}", kind.name())).collect();
        let kinds = kinds.join(" or ");
        assert_eq!(
            found("kind = 'logistics'\nsamples = 3"),
            format!("f:1:8: kind must be {kinds}, got \"logistics\", did you mean 'logistic'?")
        );
        assert_eq!(
            found("kind = 'logistic'\nsamples = 3\nmemory = -1"),
            "f:2:1: policy 'logistic': unknown key 'samples', expected one of 'kind', 'memory', \
             'coding', 'initial_scale', 'initial'\n\
             f:3:10: policy 'logistic': memory must be a whole number from 0 to 100, got -1"
        );
        assert_eq!(
            found("initial_scale = 1\ninitial = 'x'"),
            "f:1:17: initial_scale is for random parameters, and initial takes a file's"
        );
        assert_eq!(
            found("inputs = 'own_group'"),
            "f:1:10: inputs must be \"all\" where connectivity is \"full\", got \"own_group\""
        );
        assert_eq!(found("initial_scale = 1e9").lines().count(), 1);
    }
}
