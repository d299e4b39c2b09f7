//! Two resolved experiments compared, setting by setting.
//!
//! `learning.updates` is left out: a run may be extended.

use std::{collections::BTreeMap, path::Path};

use toml::{Table, Value};
use xxhash_rust::xxh3::Xxh3;

use super::{Difference, Error};

/// The setting in which a run may differ from what it was made with.
const EXTENDABLE: &str = "learning.updates";

/// All settings but the extendable one.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Settings {
    /// Dotted keys with their values, sorted by key.
    values: Vec<(String, String)>,
    /// The number of updates; none where it's swept.
    pub(crate) updates: Option<i64>,
}

impl Settings {
    /// Reads the text of a resolved experiment. `path` is for the messages.
    pub(crate) fn read(path: &Path, text: &str) -> Result<Self, Error> {
        let table: Table = toml::from_str(text)
            .map_err(|error| Error::damaged(path, error.to_string().trim_end().to_string()))?;
        let learning = table.get("learning").and_then(Value::as_table);
        let updates =
            learning.and_then(|learning| learning.get("updates")).and_then(Value::as_integer);
        let mut values = Vec::new();
        flatten(String::new(), &Value::Table(table), &mut values);
        values.retain(|(key, _)| key != EXTENDABLE);
        values.sort();
        Ok(Self { values, updates })
    }

    /// The same one for the same settings, whatever the text's order, spaces and comments.
    pub(crate) fn xxh3(&self) -> u64 {
        let mut hash = Xxh3::new();
        for part in self.values.iter().flat_map(|(key, value)| [key, value]) {
            hash.update(&(part.len() as u64).to_le_bytes());
            hash.update(part.as_bytes());
        }
        hash.digest()
    }

    /// Which settings have other values `here`.
    pub(crate) fn differences(&self, here: &Self) -> Vec<Difference> {
        let mut both: BTreeMap<&String, [Option<&String>; 2]> = BTreeMap::new();
        for (side, settings) in [self, here].into_iter().enumerate() {
            for (key, value) in &settings.values {
                both.entry(key).or_default()[side] = Some(value);
            }
        }
        let differing = both.into_iter().filter(|(_, [there, here])| there != here);
        let shown = |value: Option<&String>| value.map_or("nothing".into(), String::clone);
        differing
            .map(|(key, [there, here])| Difference {
                what: key.clone(),
                there: shown(there),
                here: shown(here),
            })
            .collect()
    }
}

/// Numbers and strings are written by Rust and not by the TOML library: the hash must not change
/// with its version.
fn flatten(key: String, value: &Value, settings: &mut Vec<(String, String)>) {
    let text = match value {
        Value::Table(table) => {
            let dot = if key.is_empty() { "" } else { "." };
            for (name, value) in table {
                flatten(format!("{key}{dot}{name}"), value, settings);
            }
            return;
        }
        Value::Array(values) if !values.is_empty() => {
            for (i, value) in values.iter().enumerate() {
                flatten(format!("{key}[{i}]"), value, settings);
            }
            return;
        }
        Value::Array(_) => "[]".into(),
        Value::String(text) => format!("{text:?}"),
        Value::Integer(number) => number.to_string(),
        Value::Float(number) => format!("{number:?}"),
        Value::Boolean(flag) => flag.to_string(),
        Value::Datetime(time) => time.to_string(),
    };
    settings.push((key, text));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Settings {
        Settings::read(Path::new("experiment.toml"), text).unwrap()
    }

    const TEXT: &str = "a = 1\n[learning]\nrate = 0.5\nupdates = 300\n[sweep]\nseeds = [1, 2]\n";

    #[test]
    fn order_comments_and_the_number_of_updates_make_no_difference() {
        let other =
            "sweep.seeds = [ 1, 2 ] # two\na = 1\nlearning = { updates = 9, rate = 5e-1 }\n";
        assert_eq!(read(TEXT).values, read(other).values);
        assert_eq!([read(TEXT), read(other)].map(|it| it.updates), [Some(300), Some(9)]);
        assert_eq!(read(TEXT).xxh3(), read(other).xxh3());
        assert!(read(TEXT).differences(&read(other)).is_empty());
    }

    #[test]
    fn differences_are_named() {
        let other = TEXT.replace("0.5", "1.0").replace("[1, 2]", "[1]").replace("a = 1", "a = '1'");
        assert_ne!(read(TEXT).xxh3(), read(&other).xxh3());
        let empty = read("a = []").differences(&read("")).pop().unwrap().to_string();
        assert_eq!(empty, "a: [] there, nothing here");
        let found: Vec<_> =
            read(TEXT).differences(&read(&other)).iter().map(ToString::to_string).collect();
        assert_eq!(
            found,
            [
                "a: 1 there, \"1\" here",
                "learning.rate: 0.5 there, 1.0 here",
                "sweep.seeds[1]: 2 there, nothing here",
            ]
        );
    }

    /// A hash that is in manifests already must stay what it is.
    #[test]
    fn the_hash_does_not_change_with_versions() {
        assert_eq!(format!("{:016x}", read(TEXT).xxh3()), "c10c1025e7fb09ea");
    }

    #[test]
    fn text_that_is_no_toml_is_damage() {
        let error = Settings::read(Path::new("experiment.toml"), "a = \n").unwrap_err();
        assert!(
            error.to_string().starts_with("experiment.toml: damaged: TOML parse error at line 1")
        );
    }
}
