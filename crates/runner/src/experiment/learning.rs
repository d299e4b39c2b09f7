//! The table `learning`: how the policy learns. What makes the gradient is in `learner.rs`.
//!
//! The settings of an optimiser are those that `gpomdp` declares, whatever the list of optimisers
//! there, and its own constructor checks their ranges. Those of the paper's optimiser, `momentum`,
//! stand in `learning` itself, those of another one in a table of its name, as in
//! `learning.adam.rate`.

use config::{Mismatch, Node, Rule, Section, count, number};
use gpomdp::OptimiserSettings;
use serde::{Serialize, Serializer, ser::SerializeMap};

use super::{
    learner::LearnerSettings,
    leaves::{shown, table},
};

/// The optimiser whose settings stand in `learning` itself.
const INLINE: &str = "momentum";

/// How the policy learns.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LearningSettings {
    /// Updates of the policy.
    pub updates: u64,
    /// Control steps for each update.
    pub steps_per_update: u64,
    /// Worlds in which the policy acts at a time. Each makes `steps_per_update` control steps for each
    /// update.
    #[serde(skip_serializing_if = "is_one")]
    pub worlds: usize,
    /// What makes gradients of control steps.
    #[serde(flatten)]
    pub learner: LearnerSettings,
    /// The optimiser, which makes steps of gradients.
    #[serde(flatten, serialize_with = "write_optimiser")]
    pub optimiser: OptimiserSettings,
}

impl LearningSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        /// So that control steps can be counted in 64 bits.
        const MOST: i64 = 1_000_000_000;
        let updates = count(1, MOST).about(
            "updates of each cell; more, with `--set` or `itarl resume --updates`, extend a run",
        );
        let updates = section.or("updates", updates, 30_000);
        let steps_per_update = count(1, MOST).about("control steps for each update, in each world");
        let steps_per_update: u64 = section.or("steps_per_update", steps_per_update, 100);
        let (worlds, learner) = LearnerSettings::read(section, steps_per_update)?;
        if steps_per_update.saturating_mul(worlds as u64) > MOST as u64 {
            let message = format!(
                "steps_per_update times worlds must be at most {MOST}, got {steps_per_update} x {worlds}"
            );
            section.complain(&section.place_of("worlds"), message);
        }
        let optimiser = read_optimiser(section)?;
        Some(Self { updates, steps_per_update, worlds, learner, optimiser })
    }

    /// Control steps of an update, in all worlds together.
    #[must_use]
    pub fn control_steps_per_update(&self) -> u64 {
        self.steps_per_update * self.worlds as u64
    }
}

fn read_optimiser(section: &mut Section<'_>) -> Option<OptimiserSettings> {
    let all = OptimiserSettings::all();
    let kinds: Vec<_> = all.iter().map(|settings| (settings.name(), settings.about())).collect();
    section.kind("optimiser", "what makes steps of gradients", &kinds, |section, chosen| {
        for other in all.iter().filter(|other| other.name() != chosen) {
            refuse_settings_of(other, chosen, section);
        }
        let default = all.iter().find(|settings| settings.name() == chosen)?;
        if chosen == INLINE {
            return read_fields(section, default);
        }
        section.table_or_empty(chosen, |table| {
            table.call(format!("learning.{chosen}"));
            read_fields(table, default)
        })
    })
}

/// A setting that would change nothing is a mistake.
fn refuse_settings_of(other: &OptimiserSettings, chosen: &str, section: &mut Section<'_>) {
    let keys = match other.name() {
        INLINE => fields(other).keys().cloned().collect(),
        name => vec![name.to_owned()],
    };
    for key in keys {
        if section.has(&key) && section.optional(&key, Anything).is_some() {
            let message = format!(
                "{key} belongs to the optimiser \"{}\", and the optimiser is \"{chosen}\"",
                other.name()
            );
            section.complain(&section.place_of(&key), message);
        }
    }
}

/// Numbers all, checked by the optimiser's constructor one after the other.
fn read_fields(
    section: &mut Section<'_>,
    default: &OptimiserSettings,
) -> Option<OptimiserSettings> {
    let defaults = fields(default);
    let mut values = defaults.clone();
    let mut fit = true;
    for setting in default.settings() {
        let rule = number().about(setting.about).condition(setting.expected);
        let by_default = defaults.get(setting.name)?.as_float()?;
        if let Some(number) = section.given_or(setting.name, rule, by_default) {
            values.insert(setting.name.into(), number.into());
        } else {
            fit = false;
        }
    }
    loop {
        let all = toml::Table::from_iter([(default.name().to_owned(), values.clone().into())]);
        let settings: OptimiserSettings = match all.try_into() {
            Ok(settings) => settings,
            Err(error) => {
                section.complain(section.place(), error.to_string());
                return None;
            }
        };
        let (what, expected, value) = match settings.build(0) {
            Ok(_) => return fit.then_some(settings),
            Err(gpomdp::Error::Number { what, expected, value, .. }) => (what, expected, value),
            Err(error) => {
                section.complain(section.place(), error.to_string());
                return None;
            }
        };
        section.refuse(what, expected, shown(&value.into()));
        fit = false;
        // Goes on with the default, to see what else is wrong.
        match defaults.get(what) {
            Some(default) if values.get(what) != Some(default) => {
                values.insert(what.to_owned(), default.clone());
            }
            _ => return None,
        }
    }
}

/// Names and values of an optimiser's settings.
fn fields(settings: &OptimiserSettings) -> toml::Table {
    match table(settings).remove(settings.name()) {
        Some(toml::Value::Table(fields)) => fields,
        _ => toml::Table::new(),
    }
}

/// As [`read_optimiser`] reads it.
fn write_optimiser<S: Serializer>(
    settings: &OptimiserSettings,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(None)?;
    map.serialize_entry("optimiser", settings.name())?;
    match settings.name() {
        INLINE => {
            for (key, value) in fields(settings) {
                map.serialize_entry(&key, &value)?;
            }
        }
        name => map.serialize_entry(name, &fields(settings))?,
    }
    map.end()
}

/// Takes any value.
struct Anything;

impl Rule for Anything {
    type Out = ();

    fn expected(&self) -> String {
        "anything".into()
    }

    fn take(&self, _: &Node) -> Result<(), Mismatch> {
        Ok(())
    }

    fn written(&self, (): &()) -> String {
        self.expected()
    }
}

/// One world isn't written: what cells are told apart by stays what it was before there were several.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "what serde calls")]
fn is_one(worlds: &usize) -> bool {
    *worlds == 1
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use config::Document;

    use super::*;

    fn read(text: &str) -> Result<LearningSettings, String> {
        let document = Document::parse("f", text).unwrap();
        document.read(LearningSettings::read).map_err(|problems| problems.to_string())
    }

    /// Whatever optimisers there will be.
    #[test]
    fn every_optimiser_is_read_as_it_is_written() {
        for optimiser in OptimiserSettings::all() {
            let name = optimiser.name();
            let read_default = read(&format!("optimiser = '{name}'")).unwrap();
            assert_eq!(read_default.optimiser, optimiser);
            let text = table(&read_default).to_string();
            assert_eq!(read(&text).unwrap(), read_default, "{text}");
            assert!(text.contains(&format!("optimiser = \"{name}\"")), "{text}");
        }
    }

    #[test]
    fn all_mistakes_of_an_optimiser_are_found() {
        let expected = "f:2:8: rate must be > 0 and at most 1e100, got -1\n\
                        f:3:9: decay must be within 0 to 1, got 2\n\
                        f:4:12: momentum must be >= 0 and < 1, got 1";
        let found = read("updates = 3\nrate = -1\ndecay = 2\nmomentum = 1").unwrap_err();
        assert_eq!(found, expected);
    }

    #[test]
    fn settings_of_another_optimiser_are_refused() {
        let found = read("optimiser = 'adam'\nrate = 1\nadam.rate = 0.1\nrprop.first = 2");
        let expected = [
            "f:2:8: rate belongs to the optimiser \"momentum\", and the optimiser is \"adam\"",
            "f:4:1: rprop belongs to the optimiser \"rprop\", and the optimiser is \"adam\"",
        ];
        assert_eq!(found.unwrap_err(), expected.join("\n"));
    }
}
