//! Files written and read back, whatever is in them.

use std::{fs, path::Path};

use proptest::prelude::*;

use super::{experiment, folders, open, plan};
use crate::experiment::Plan;

/// Values of each key that go with all other ones of this table.
const CHOICES: [(&str, &[&str]); 35] = [
    ("description", &["'what for?'", "'''a\nb \"c\" é'''"]),
    ("robot.servo.front leg.speed_limit_rad_s", &["0.5", "2"]),
    ("physics.frequency_hz", &["100", "200", "1000"]),
    ("physics.iterations", &["1", "50"]),
    ("physics.warm_starting", &["false"]),
    ("control.frequency_hz", &["10", "5", "12.5", "0.1"]),
    ("control.settle_steps", &["0", "7"]),
    ("codec.sensor_bits", &["1", "8"]),
    ("codec.actuator_bits", &["2"]),
    ("policy.hidden_units", &["1", "16384"]),
    ("policy.gibbs_updates", &["0", "3"]),
    ("policy.samples", &["1"]),
    ("policy.connectivity", &["'full'", "'per_actuator'", "'per_group'"]),
    ("policy.memory", &["2"]),
    ("policy.initial_scale", &["0", "1e-7", "0.3"]),
    ("reward.scale", &["10", "100", "1e-50"]),
    ("reward.penalty", &["0", "0.1"]),
    ("reward.extrinsic.kind", &["'locomotion'", "'turning'"]),
    ("reward.extrinsic.scale", &["2", "-1.5"]),
    ("reward.intrinsic.sensors", &["'positions'", "'all'"]),
    ("reward.intrinsic.group", &["'group'", "'body'"]),
    ("reward.intrinsic.window", &["2", "1000"]),
    ("reward.intrinsic.lag", &["3"]),
    ("reward.intrinsic.past", &["4"]),
    ("reward.intrinsic.max", &["1"]),
    ("reward.mix.kind", &["'linear'", "'geometric'"]),
    ("reward.mix.xi", &["0", "0.5", "1"]),
    ("perturbation.every", &["0", "500"]),
    ("perturbation.length", &["1", "20"]),
    ("perturbation.flip_probability", &["1"]),
    ("learning.updates", &["1", "1_000_000_000"]),
    ("learning.baseline", &["0.998", "false"]),
    ("learning.optimiser", &["'momentum'", "'adam'", "'rprop'"]),
    ("record.pose_every", &["1", "4"]),
    ("checkpoint.every", &["1"]),
];

/// For each key nothing, one value, or a sweep over all of them.
fn settings() -> impl Strategy<Value = Vec<usize>> {
    CHOICES.iter().map(|(_, values)| 0..values.len() + 2).collect::<Vec<_>>()
}

/// What the settings say, with or without sweeps.
fn file(settings: &[usize], swept: bool) -> String {
    let (mut lines, mut sweep) = (vec!["model = 'm'".to_owned()], vec!["[sweep]".to_owned()]);
    for ((key, values), &choice) in CHOICES.iter().zip(settings) {
        // Three swept keys, or there will be too many cells.
        if choice > values.len() && swept && sweep.len() < 4 && *key != "description" {
            sweep.push(format!("'{key}' = [{}]", values.join(", ")));
        } else if let Some(value) = choice.checked_sub(1).and_then(|choice| values.get(choice)) {
            lines.push(format!("{} = {value}", key.replace("front leg", "'front leg'")));
        }
    }
    lines.extend(sweep);
    lines.join("\n")
}

/// The keys of [`CHOICES`] below a section, without its name.
fn keys_of(section: &'static str) -> Vec<(&'static str, &'static [&'static str])> {
    let below = |(key, values): &(&'static str, &'static [&'static str])| {
        Some((key.strip_prefix(section)?.strip_prefix('.')?, *values))
    };
    CHOICES.iter().filter_map(below).collect()
}

/// Some keys of a section in any order with a value each, some with dots, which make tables of them;
/// with or without a label.
fn swept_table(section: &'static str) -> impl Strategy<Value = String> {
    let keys = keys_of(section);
    let chosen = prop::sample::subsequence(keys.clone(), 1..=keys.len().min(4)).prop_shuffle();
    let label = prop::option::of("[a-z0-9][a-z0-9._+-]{0,5}");
    (chosen, label, any::<prop::sample::Index>()).prop_map(|(chosen, label, index)| {
        let value = |values: &[&'static str]| values[index.index(values.len())];
        let entries = chosen.iter().map(|(key, values)| format!("{key} = {}", value(values)));
        let label = label.map(|label| format!("label = '{label}'"));
        format!("{{ {} }}", entries.chain(label).collect::<Vec<_>>().join(", "))
    })
}

/// A section, swept by one of its keys or by tables.
fn axis(section: &'static str) -> impl Strategy<Value = (&'static str, String)> {
    let plain = prop::sample::select(keys_of(section))
        .prop_map(move |(key, values)| format!("'{section}.{key}' = [{}]", values.join(", ")));
    let tables = prop::collection::vec(swept_table(section), 1..4)
        .prop_map(move |tables| format!("{section} = [{}]", tables.join(", ")));
    (Just(section), prop_oneof![plain, tables])
}

/// A file that sweeps some sections in any order, tables before plain keys and after them. Some are
/// refused: where two values are the same, say.
fn sweeps() -> impl Strategy<Value = String> {
    let sections = ["physics", "control", "codec", "policy", "reward", "learning", "record"];
    let axes = prop::sample::subsequence(sections.to_vec(), 0..=4).prop_shuffle();
    let axes = axes.prop_flat_map(|sections| sections.into_iter().map(axis).collect::<Vec<_>>());
    let seeds = prop::sample::select(vec!["", "seeds = 3", "seeds = [7, 3]"]);
    (axes, seeds, settings()).prop_map(|(axes, seeds, settings)| {
        let (sections, mut lines): (Vec<_>, Vec<_>) = axes.into_iter().unzip();
        let is_swept = |line: &&str| sections.iter().any(|section| line.starts_with(section));
        let rest = file(&settings, false);
        lines.splice(0..0, rest.lines().filter(|line| !is_swept(line)).map(str::to_owned));
        lines.join("\n") + "\n" + seeds
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// To the letter of each cell's name, and whatever stands before what.
    #[test]
    fn any_sweep_read_back_has_the_same_cells(text in sweeps()) {
        let plan = open(&text, &[]);
        prop_assume!(plan.is_ok());
        let plan = plan.unwrap();
        let written = plan.to_toml();
        let again = self::plan(&written);
        prop_assert_eq!(folders(&again), folders(&plan), "{}", written);
        prop_assert!(again == plan, "{}", written);
        prop_assert_eq!(again.to_toml(), written);
    }

    #[test]
    fn resolved_settings_read_back_are_the_same(settings in settings()) {
        let text = file(&settings, false).replace("[sweep]", "");
        let experiment = experiment(&text);
        prop_assert_eq!(self::experiment(&experiment.to_toml()), experiment);
    }

    #[test]
    fn a_resolved_plan_read_back_is_the_same(settings in settings()) {
        let plan = plan(&file(&settings, true));
        let text = plan.to_toml();
        let again = self::plan(&text);
        prop_assert!(again == plan, "{}", text);
        prop_assert_eq!(again.to_toml(), text);
    }

    #[test]
    fn no_text_makes_it_panic(text in "[a-z_.= \\[\\]'{}0-9\n#,-]{0,200}") {
        let _ = open(&text, &[]);
        let _ = open(&format!("model = 'm'\n[sweep]\n{text}"), &[]);
        let _ = open("model = 'm'", &[&text]);
    }
}

/// All that is trained by the files here, through the files that they are written to.
#[test]
fn every_experiment_is_written_as_it_is() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments");
    let mut n = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            let plan = Plan::open(&path, &[]).unwrap_or_else(|problems| panic!("{problems}"));
            assert_eq!(self::plan(&plan.to_toml()), plan, "{}", plan.to_toml());
            assert!(plan.warnings().is_empty(), "{:?}", plan.warnings());
            n += 1;
        }
    }
    assert!(n >= 10, "{n}");
}

/// A run that was begun before such mistakes were found goes on.
#[test]
fn what_a_run_was_made_with_is_read_again() {
    let text = "model = '/m'\n[sweep]\n'reward.mix.xi' = [0.0, -0.0]";
    assert!(open(text, &[]).is_err());
    let plan = Plan::written(Path::new("/run/experiment.toml"), text).unwrap();
    assert_eq!(folders(&plan), ["xi=0/seed=1", "xi=-0/seed=1"]);
}
