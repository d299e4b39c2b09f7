//! What settings mean, by their keys: for `itarl config --help KEY`.

use config::{Setting, suggestion};

use super::Experiment;

/// The settings that a key names: the one of that key, of each kind that has it; those of the table;
/// those whose keys end in it, or begin with it. None if there is no such thing.
#[must_use]
pub fn explained(key: &str) -> Vec<Setting> {
    let all = Experiment::settings();
    let (below, end) = (format!("{key}."), format!(".{key}"));
    let tests: [&dyn Fn(&str) -> bool; 4] = [
        &|found| found == key,
        &|found| found.starts_with(&below),
        &|found| found.ends_with(&end),
        &|found| found.starts_with(key),
    ];
    let named = |test: &&dyn Fn(&str) -> bool| -> Vec<_> {
        all.iter().filter(|setting| test(&setting.key)).cloned().collect()
    };
    tests.iter().map(named).find(|found| !found.is_empty()).unwrap_or_default()
}

/// A key that names settings.
///
/// # Errors
/// That there are none, with one that is alike.
pub fn known(key: &str) -> Result<String, String> {
    if !explained(key).is_empty() {
        return Ok(key.into());
    }
    let all = Experiment::settings();
    // Whole keys, tables, and keys without their tables.
    let names = all.iter().flat_map(|setting| {
        let dots = setting.key.match_indices('.');
        let parts = dots.flat_map(|(dot, _)| [&setting.key[..dot], &setting.key[dot + 1..]]);
        parts.chain([setting.key.as_str()])
    });
    Err(match suggestion(key, names) {
        alike if alike.is_empty() => {
            "no such setting; docs/experiment-files.md has them all".into()
        }
        alike => format!("no such setting{alike}"),
    })
}
