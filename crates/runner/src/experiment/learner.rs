//! What the learner is: in the table `learning`, `kind` and the keys that belong to that kind.

use config::{Section, above, count, one_of, or_false, within};
use gpomdp::EstimatorSettings;
use serde::{Serialize, Serializer, ser::SerializeMap};

/// What makes gradients of control steps.
#[derive(Clone, Debug, PartialEq)]
pub enum LearnerSettings {
    /// GPOMDP in each world: the paper's.
    Gpomdp(EstimatorSettings),
    /// An evolution strategy, whose population is the worlds.
    Evolution(EvolutionSettings),
}

/// Settings of the evolution strategy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EvolutionSettings {
    /// The standard deviation of the candidates' parameters, above 0, to 1e8; 0.1.
    pub sigma: f64,
    /// Control steps at the start of an episode that don't count, fewer than it has; 20.
    pub skip: u64,
}

const GPOMDP: &str = "gpomdp";
const EVOLUTION: &str = "evolution";

impl LearnerSettings {
    /// The kind as it's written.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Gpomdp(_) => GPOMDP,
            Self::Evolution(_) => EVOLUTION,
        }
    }

    /// Worlds where the file doesn't say.
    pub(super) fn default_worlds(kind: &str) -> usize {
        if kind == EVOLUTION { 32 } else { 1 }
    }

    pub(super) fn read_kind(section: &mut Section<'_>) -> Option<&'static str> {
        let kinds = [GPOMDP, EVOLUTION].map(|kind| (kind, kind));
        let kind = section.given_or("kind", one_of(&kinds), GPOMDP);
        if kind.is_none() {
            section.accept_all();
        }
        kind
    }

    /// The keys of a kind, for updates of so many control steps in so many worlds.
    pub(super) fn read(
        section: &mut Section<'_>,
        kind: &str,
        steps_per_update: u64,
        worlds: usize,
    ) -> Option<Self> {
        if kind == GPOMDP {
            let default = EstimatorSettings::default().discount;
            let discount = section.or("discount", within(0.0, 1.0), default);
            let baseline_factor = section.or("baseline", or_false(within(0.0, 1.0)), None);
            return Some(Self::Gpomdp(EstimatorSettings { discount, baseline_factor }));
        }
        section.call("learning 'evolution'");
        if !worlds.is_multiple_of(2) {
            let message = format!("worlds are a population in pairs: an even number, got {worlds}");
            section.complain(&section.place_of("worlds"), message);
        }
        section.table_or_empty(EVOLUTION, |table| {
            table.call("learning.evolution");
            let sigma = table.or("sigma", above(0.0), 0.1);
            if sigma > 1e8 {
                table.refuse("sigma", "at most 1e8", sigma.to_string());
            }
            let skip: u64 = table.or("skip", count(0, 1_000_000_000), 20);
            if skip >= steps_per_update {
                let message = format!(
                    "skip must leave some of the {steps_per_update} steps_per_update, got {skip}"
                );
                table.complain(&table.place_of("skip"), message);
            }
            Some(Self::Evolution(EvolutionSettings { sigma, skip }))
        })
    }
}

/// As it's read, and for GPOMDP as it was before there was another kind: what cells are told apart
/// by stays the same.
impl Serialize for LearnerSettings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        match self {
            Self::Gpomdp(settings) => {
                map.serialize_entry("discount", &settings.discount)?;
                match settings.baseline_factor {
                    Some(factor) => map.serialize_entry("baseline", &factor)?,
                    None => map.serialize_entry("baseline", &false)?,
                }
            }
            Self::Evolution(settings) => {
                map.serialize_entry("kind", EVOLUTION)?;
                map.serialize_entry(EVOLUTION, settings)?;
            }
        }
        map.end()
    }
}
