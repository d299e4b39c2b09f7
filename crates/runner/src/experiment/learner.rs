//! What the learner is: in the table `learning`, `kind` and the keys that belong to that kind.

use config::{Rule, Section, count, or_false, within};
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
    /// The standard deviation of the candidates' parameters.
    pub sigma: f64,
    /// Control steps at the start of an episode that don't count.
    pub skip: u64,
}

const GPOMDP: &str = "gpomdp";
const EVOLUTION: &str = "evolution";
const KINDS: [(&str, &str); 2] = [
    (GPOMDP, "The gradient of scores and rewards, by GPOMDP in each world: the paper's."),
    (EVOLUTION, "An evolution strategy, which needs no scores; its population is the worlds."),
];

const WORLDS: &str = "worlds in which the policy acts at a time, each with random numbers, a perturbation, a window and \
     a trace of its own: an update follows the mean of their gradients, and costs `worlds` times \
     `steps_per_update` control steps, which are counted so";
const POPULATION: &str = "candidates of an update, half of them opposite to the other half, each in a world of its own: an \
     update costs `worlds` times `steps_per_update` control steps, which are counted so";

impl LearnerSettings {
    /// The worlds, the kind, and its own keys, for updates of so many control steps.
    pub(super) fn read(section: &mut Section<'_>, steps_per_update: u64) -> Option<(usize, Self)> {
        section.kind("kind", "what makes the gradient", &KINDS, |section, kind| {
            let (about, condition, default) = match kind {
                GPOMDP => (WORLDS, "times `steps_per_update` at most 1000000000", 1),
                _ => (POPULATION, "even, times `steps_per_update` at most 1000000000", 32),
            };
            let worlds = count(1, 1024).about(about).condition(condition);
            let worlds: usize = section.or("worlds", worlds, default);
            if kind == GPOMDP {
                return Some((worlds, Self::Gpomdp(read_estimator(section))));
            }
            section.call("learning 'evolution'");
            if !worlds.is_multiple_of(2) {
                let message =
                    format!("worlds are a population of pairs: an even number, got {worlds}");
                section.complain(&section.place_of("worlds"), message);
            }
            section.table_or_empty(EVOLUTION, |table| {
                table.call("learning.evolution");
                Some((worlds, Self::Evolution(EvolutionSettings::read(table, steps_per_update))))
            })
        })
    }
}

fn read_estimator(section: &mut Section<'_>) -> EstimatorSettings {
    let discount = within(0.0, 1.0).about("discount of the trace of scores");
    let discount = section.or("discount", discount, EstimatorSettings::default().discount);
    let baseline = or_false(within(0.0, 1.0)).about(
        "factor per control step of the running average that is subtracted from rewards (0.998 is \
         a good start); `false`: none",
    );
    EstimatorSettings { discount, baseline_factor: section.or("baseline", baseline, None) }
}

impl EvolutionSettings {
    fn read(table: &mut Section<'_>, steps_per_update: u64) -> Self {
        let sigma = within(1e-8, 1e8).about(
            "standard deviation of the candidates' parameters around those that are learned",
        );
        let skip = count(0, 1_000_000_000)
            .about(
                "control steps at the start of an episode that don't count for the fitness, the mean \
                 reward of the others",
            )
            .condition("less than `steps_per_update`");
        let settings =
            Self { sigma: table.or("sigma", sigma, 0.1), skip: table.or("skip", skip, 20) };
        if settings.skip >= steps_per_update {
            let message = format!(
                "skip must be less than steps_per_update, {steps_per_update}, got {}",
                settings.skip
            );
            table.complain(&table.place_of("skip"), message);
        }
        settings
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
