//! Settings are declared once, where they're read: the tables of docs/experiment-files.md are made from
//! that.

use std::{
    collections::{BTreeMap, BTreeSet},
    env,
    fmt::Write,
    fs,
    path::PathBuf,
};

use config::{Presence, Setting};
use policy::KindSettings;
use reward::{ExtrinsicSettings, intrinsic::IntrinsicSettings};

use super::experiment;
use crate::experiment::{Experiment, explained, known, leaves};

/// What a table stands after; then come the keys that it has in common, as in `: reward.mix`.
const BEGIN: &str = "<!-- settings";

/// What a table stands before.
const END: &str = "<!-- end -->";

fn page(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(name)
}

#[test]
fn the_tables_of_the_page_are_those_of_the_code() {
    let path = page("experiment-files.md");
    let found = fs::read_to_string(&path).unwrap();
    let expected = with_tables(&found, &Experiment::settings());
    if env::var_os("WRITE_DOCS").is_some() {
        fs::write(&path, expected).unwrap();
    } else {
        assert!(
            found == expected,
            "the tables of docs/experiment-files.md aren't those of the code: `make docs` writes them"
        );
    }
}

/// The page with all tables made anew.
fn with_tables(page: &str, settings: &[Setting]) -> String {
    let places: Vec<_> = page.lines().filter_map(place).collect();
    assert!(places.contains(&""), "there is a table for what has no other");
    // The table of the longest path.
    let belongs = |setting: &Setting, path: &str| {
        let is_in = |path: &str| path.is_empty() || setting.key.starts_with(&format!("{path}."));
        places.iter().filter(|path| is_in(path)).max_by_key(|path| path.len()) == Some(&path)
    };
    let (mut text, mut is_inside) = (String::new(), false);
    for line in page.lines() {
        is_inside &= line != END;
        if !is_inside {
            writeln!(text, "{line}").unwrap();
        }
        if let Some(path) = place(line) {
            let own: Vec<_> = settings.iter().filter(|setting| belongs(setting, path)).collect();
            writeln!(text, "\n{}", table(&own)).unwrap();
            is_inside = true;
        }
    }
    text
}

/// The path of the table that a line is the beginning of.
fn place(line: &str) -> Option<&str> {
    Some(line.strip_prefix(BEGIN)?.strip_suffix("-->")?.trim_start_matches(':').trim())
}

/// The settings of a section, and the kinds that can be chosen there.
fn table(settings: &[&Setting]) -> String {
    let has_kinds = settings.iter().any(|setting| setting.only.is_some());
    let mut text = match has_kinds {
        true => "| key | of | meaning | default | value |\n|---|---|---|---|---|\n".to_owned(),
        false => "| key | meaning | default | value |\n|---|---|---|---|\n".into(),
    };
    for Setting { key, about, expected, presence, only, .. } in settings {
        let default = match presence {
            Presence::Required => "required".into(),
            Presence::Optional => "none".into(),
            Presence::Default(value) => format!("`{value}`"),
        };
        let kinds = only.iter().flat_map(|only| &only.kinds);
        let kinds: Vec<_> = kinds.map(|kind| format!("`\"{kind}\"`")).collect();
        let kinds = if has_kinds { format!(" {} |", kinds.join(", ")) } else { String::new() };
        let row = format!("| `{key}` |{kinds} {} | {default} | {} |", cell(about), cell(expected));
        writeln!(text, "{}", row.replace("|  |", "| |")).unwrap();
    }
    for Setting { key, kinds, .. } in settings.iter().filter(|setting| !setting.kinds.is_empty()) {
        write!(text, "\n| `{key}` | what it is |\n|---|---|\n").unwrap();
        for (kind, about) in kinds {
            writeln!(text, "| `\"{kind}\"` | {} |", cell(about)).unwrap();
        }
    }
    text
}

/// A text as a cell of a table has it.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

#[test]
fn every_setting_says_what_it_means() {
    for Setting { key, about, expected, kinds, .. } in Experiment::settings() {
        assert!(!about.is_empty(), "{key} needs a text: rule.about(\"...\")");
        assert!(!expected.is_empty(), "{key}");
        for (kind, about) in kinds {
            let is_sentence = about.starts_with(char::is_uppercase) && about.ends_with('.');
            assert!(
                is_sentence,
                "{key} = \"{kind}\" needs a sentence above it in the list: {about}"
            );
        }
    }
}

/// The kind that is chosen, by the key that chooses it.
type Chosen = BTreeMap<String, String>;

/// All kinds that are there by default, and then every other kind with these.
fn all_choices(settings: &[Setting]) -> Vec<Chosen> {
    let choosing = settings.iter().filter(|setting| !setting.kinds.is_empty());
    let default = choosing.clone().map(|it| (it.key.clone(), it.kinds[0].0.clone()));
    let default = Chosen::from_iter(default);
    let others = choosing.flat_map(|it| it.kinds[1..].iter().map(|(kind, _)| (&it.key, kind)));
    let other = |(key, kind): (&String, &String)| {
        let mut chosen = default.clone();
        chosen.insert(key.clone(), kind.clone());
        chosen
    };
    [default.clone()].into_iter().chain(others.map(other)).collect()
}

/// A file that chooses these kinds. Without information no other xi is allowed.
fn file(chosen: &Chosen) -> String {
    let lines = chosen.iter().map(|(key, kind)| format!("{key} = {kind:?}\n"));
    lines.collect::<String>() + "model = 'm'\nreward.mix.xi = 1\n"
}

/// The settings that there are with these kinds.
fn of<'a>(settings: &'a [Setting], chosen: &'a Chosen) -> impl Iterator<Item = &'a Setting> {
    settings.iter().filter(|setting| {
        setting.only.as_ref().is_none_or(|only| only.kinds.contains(&chosen[&only.key]))
    })
}

#[test]
fn a_default_written_out_changes_nothing() {
    let settings = Experiment::settings();
    // The file sets the one, and the other one follows the mix.
    let left_out = ["reward.mix.xi", "reward.penalty"];
    for chosen in all_choices(&settings) {
        let mut text = file(&chosen);
        for setting in of(&settings, &chosen).filter(|it| !left_out.contains(&&*it.key)) {
            if let (Presence::Default(value), None) = (&setting.presence, chosen.get(&setting.key))
            {
                writeln!(text, "{} = {value}", setting.key).unwrap();
            }
        }
        assert_eq!(experiment(&text), experiment(&file(&chosen)));
    }
}

#[test]
fn every_key_that_is_written_is_declared() {
    let settings = Experiment::settings();
    for chosen in all_choices(&settings) {
        let keys: BTreeSet<_> = of(&settings, &chosen).map(|it| it.key.as_str()).collect();
        let text = file(&chosen);
        let schedule = text.replace("mix.xi = 1", "mix.schedule = [[0, 1]]");
        let others = format!("{schedule}description = 'x'\npolicy.initial = 'x'");
        for text in [text, others] {
            let written = leaves::table(&experiment(&text));
            for (key, _) in leaves::leaves(&written) {
                assert!(keys.contains(&*key), "{key} is written with {chosen:?}, and not read");
            }
        }
    }
}

#[test]
fn settings_are_found_by_their_keys() {
    let keys =
        |key: &str| explained(key).into_iter().map(|setting| setting.key).collect::<Vec<_>>();
    assert_eq!(keys("reward.mix.xi"), ["reward.mix.xi"]);
    assert_eq!(keys("xi"), ["reward.mix.xi"]);
    assert_eq!(keys("mix.xi"), ["reward.mix.xi"]);
    assert_eq!(keys("codec"), ["codec.sensor_bits", "codec.actuator_bits"]);
    assert_eq!(keys("codec.se"), ["codec.sensor_bits"]);
    // A setting, and not what begins as it does.
    assert_eq!(keys("learning.momentum"), ["learning.momentum"]);
    assert_eq!(keys("policy.hidden_units"), ["policy.hidden_units"; 2]);
    assert_eq!(keys("nothing"), [""; 0]);
    for (key, alike) in [("reward.mix.xii", "reward.mix.xi"), ("lerning", "learning")] {
        let expected = format!("no such setting, did you mean '{alike}'?");
        assert_eq!(known(key).unwrap_err(), expected);
    }
    assert_eq!(known("policy.hidden").unwrap(), "policy.hidden");
    assert!(known("q").unwrap_err().contains("docs/experiment-files.md"));
}

#[test]
fn every_kind_of_policy_has_its_tensors_in_the_documentation() {
    let folders = fs::read_to_string(page("run-folders.md")).unwrap();
    for kind in KindSettings::all() {
        assert!(folders.contains(&format!("\n| `{}` | `", kind.name())), "{}", kind.name());
    }
}

/// A quantity has one name from the reward to the label, and the page of letters has it.
#[test]
fn every_kind_of_reward_has_its_letter() {
    let notation = fs::read_to_string(page("notation.md")).unwrap();
    // R_Loc is a mean, and r_Loc,t what it's the mean of.
    let in_a_step = |symbol: &str| match symbol.strip_prefix("R_") {
        Some(index) => format!("\n| r_{index},t |"),
        None => format!("\n| {symbol} |"),
    };
    for task in ExtrinsicSettings::all() {
        let symbol = task.get().symbol();
        assert!(notation.contains(&in_a_step(symbol)), "{symbol}");
    }
    for information in IntrinsicSettings::all() {
        let (name, symbol) = (information.kind(), information.get().symbol());
        assert!(name == symbol || notation.contains(&in_a_step(symbol)), "{symbol}");
    }
}
