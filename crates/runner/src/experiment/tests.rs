//! Files read, written and compared.
#![allow(clippy::unwrap_used)]

use std::{fs, path::Path};

use config::Document;
use policy::KindSettings;
use proptest::prelude::*;
use reward::{ExtrinsicSettings, intrinsic::IntrinsicSettings};

use super::{Experiment, Plan, leaves};

fn experiment(text: &str) -> Experiment {
    let read = Document::parse("f", text).and_then(|document| document.read(Experiment::read));
    read.unwrap_or_else(|problems| panic!("{problems}\n{text}"))
}

/// A file in a folder of its own, opened.
fn open(text: &str, overrides: &[&str]) -> Result<Plan, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.toml");
    fs::write(&file, text).unwrap();
    let overrides: Vec<_> = overrides.iter().map(|text| text.to_string()).collect();
    Plan::open(&file, &overrides)
        .map_err(|problems| problems.to_string().replace(&file.display().to_string(), "x.toml"))
}

fn plan(text: &str) -> Plan {
    open(text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"))
}

fn folders(plan: &Plan) -> Vec<String> {
    plan.cells().iter().map(|cell| cell.folder().display().to_string()).collect()
}

/// All keys, with what they are when a file says nothing but its model.
const DEFAULTS: &str = r#"model = "m.toml"

[physics]
frequency_hz = 100.0
iterations = 200
warm_starting = true

[control]
frequency_hz = 10.0
settle_steps = 20

[codec]
sensor_bits = 1
actuator_bits = 1

[policy]
hidden_units = 50
gibbs_updates = 10
samples = 60
connectivity = "full"
memory = 0
initial_scale = 0.01

[reward]
scale = 1.0
penalty = 0.0001

[reward.extrinsic]
kind = "locomotion"
scale = "model"

[reward.intrinsic]
kind = "mutual_information"
sensors = "positions"
group = "sensor"
window = 100
lag = 1
past = 1
max = 0.1

[reward.mix]
kind = "geometric"
xi = 0.75
power = 2.0
sign_at_zero_xi = true

[perturbation]
every = 1000
length = 10
flip_probability = 0.1

[learning]
updates = 30000
steps_per_update = 100
discount = 0.75
baseline = false
optimiser = "momentum"
rate = 1.0
decay = 0.00001
momentum = 0.5

[record]
steps = 600
pose_every = 2

[checkpoint]
every = 100
"#;

#[test]
fn the_defaults_are_the_papers() {
    assert_eq!(experiment("model = 'm.toml'").to_toml(), DEFAULTS);
    assert_eq!(experiment("model = 'm.toml'").physics_steps_per_control_step(), 10);
}

#[test]
fn the_penalty_is_one_percent_of_the_mix() {
    let penalty = |mix: &str| experiment(&format!("model = 'm'\n{mix}")).reward.penalty;
    assert_eq!(penalty(""), 0.0001);
    assert_eq!(penalty("reward.mix.power = 1"), 0.001);
    assert_eq!(penalty("reward.mix.kind = 'linear'"), 0.001);
    assert_eq!(penalty("reward.penalty = 0"), 0.0);
}

/// Values of each key that go with all other ones of this table.
const CHOICES: [(&str, &[&str]); 34] = [
    ("description", &["'what for?'", "'''a\nb \"c\" é'''"]),
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
    ("reward.extrinsic.kind", &["'locomotion'", "'turning'", "'reach'", "'height'"]),
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
            lines.push(format!("{key} = {value}"));
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

#[test]
fn the_first_swept_key_is_the_slowest_and_seeds_are_the_fastest() {
    let plan = plan(
        "model = 'm'\n[sweep]\nseeds = 2\n'reward.mix.xi' = [0.75, 1]\n\
                     'reward.mix.power' = [1.0, 2]",
    );
    let expected = [
        "xi=0.75,power=1/seed=1",
        "xi=0.75,power=1/seed=2",
        "xi=0.75,power=2/seed=1",
        "xi=0.75,power=2/seed=2",
        "xi=1,power=1/seed=1",
        "xi=1,power=1/seed=2",
        "xi=1,power=2/seed=1",
        "xi=1,power=2/seed=2",
    ];
    assert_eq!(folders(&plan), expected);
    let listing: Vec<_> = plan.listing().collect();
    assert_eq!(listing[5], (5, "xi=1,power=1", 2));
    assert_eq!(plan.cells()[5].experiment.reward.mix.get().xi().at(0), 1.0);
}

#[test]
fn swept_keys_are_written_in_quotes_or_as_tables() {
    let expected = plan("model = '/m'\n[sweep]\n'learning.rate' = [1, 3]");
    for sweep in [
        "[sweep]\nlearning.rate = [1, 3]",
        "[sweep.learning]\nrate = [1, 3]",
        "sweep = { learning = { rate = [1, 3] } }",
    ] {
        assert_eq!(plan(&format!("model = '/m'\n{sweep}")), expected, "{sweep}");
    }
}

#[test]
fn without_a_sweep_there_is_one_cell() {
    assert_eq!(folders(&plan("model = 'm'")), ["base/seed=1"]);
    assert_eq!(folders(&plan("model = 'm'\nsweep.seeds = [7, 3]")), ["base/seed=7", "base/seed=3"]);
}

#[test]
fn folders_have_the_shortest_names_that_tell_keys_apart() {
    let sweep = "model = 'm'\n[sweep]\n'reward.scale' = [1, 10]\n\
                 'reward.extrinsic.scale' = ['model', -2.5]\n'learning.baseline' = [false, 1e-5]";
    assert_eq!(
        plan(sweep).cells()[7].setting,
        "reward.scale=10,reward.extrinsic.scale=-2.5,baseline=1e-5"
    );
}

#[test]
fn values_in_folders_are_safe_characters() {
    let setting =
        |text: &str| plan(&format!("model = 'm'\n[sweep]\n{text}")).cells()[0].setting.clone();
    assert_eq!(setting("description = ['a b/../c,=é']"), "description=a-b-..-c---");
    assert_eq!(setting("'reward.mix.schedule' = [[[0, 0.5], [9, 1]]]"), "schedule=0-0.5-9-1");
    let both = "codec = [{ sensor_bits = 2, actuator_bits = 1 }]";
    assert_eq!(setting(both), "codec=sensor_bits-2-actuator_bits-1");
    let model = open("[sweep]\nmodel = ['../models/a.toml', 'b.toml']", &[]).unwrap();
    assert_eq!(model.cells()[0].setting, "model=a");
}

#[test]
fn a_table_sets_several_keys_together() {
    let plan = plan(
        "model = 'm'\nreward.scale = 3\n[sweep]\n\
         codec = [{ sensor_bits = 2 }, { sensor_bits = 4, actuator_bits = 3 }]",
    );
    let bits = plan.cells().iter().map(|cell| &cell.experiment.codec);
    let bits: Vec<_> = bits.map(|codec| (codec.sensor_bits, codec.actuator_bits)).collect();
    assert_eq!(bits, [(2, 1), (4, 3)]);
    assert_eq!(self::plan(&plan.to_toml()), plan, "{}", plan.to_toml());
}

/// What varies with a kind is left out of the complete file, and comes back from the kind.
#[test]
fn kinds_can_be_swept() {
    let plan = plan(
        "model = 'm'\n[sweep]\n'reward.mix.kind' = ['geometric', 'linear']\n\
                     'learning.optimiser' = ['momentum', 'adam']",
    );
    let text = plan.to_toml();
    assert!(!text.contains("penalty") && !text.contains("rate") && text.contains("xi"), "{text}");
    assert_eq!(self::plan(&text), plan);
    let penalties: Vec<_> =
        plan.cells().iter().map(|cell| cell.experiment.reward.penalty).collect();
    assert_eq!(penalties, [0.0001, 0.0001, 0.001, 0.001]);
}

/// Keys that one kind of policy has go with it, in the file and in the complete one.
#[test]
fn policies_can_be_swept() {
    let kinds = KindSettings::all();
    let kinds: Vec<_> = kinds.iter().map(KindSettings::name).collect();
    let by_kind = plan(&format!("model = '/m'\n[sweep]\n'policy.kind' = {kinds:?}"));
    assert_eq!(by_kind.cells()[0].experiment, experiment("model = '/m'"));
    assert_eq!(self::plan(&by_kind.to_toml()), by_kind, "{}", by_kind.to_toml());

    let tables = plan(
        "model = '/m'\npolicy.memory = 1\n[sweep]\npolicy = [{ label = 'paper' }, \
         { connectivity = 'per_group', inputs = 'neighbours' }, \
         { kind = 'modular', hidden_units = 3 }, { kind = 'logistic' }, { initial = '/a/b.x' }]",
    );
    let names: Vec<_> = tables.listing().map(|(_, setting, _)| setting).collect();
    let expected = [
        "policy=paper",
        "policy=connectivity-per_group-inputs-neighbours",
        "policy=kind-modular-hidden_units-3",
        "policy=kind-logistic",
        "policy=initial-b",
    ];
    assert_eq!(names, expected);
    assert_eq!(self::plan(&tables.to_toml()), tables, "{}", tables.to_toml());
    assert!(!tables.to_toml().contains("initial_scale"), "{}", tables.to_toml());
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

/// Table before plain key, plain value after table: what TOML's own writer puts the other way round.
#[test]
fn the_order_of_a_sweep_is_that_of_the_file() {
    let text = "model = '/m'\n[sweep]\n\
                reward = [{ mix = { power = 1 }, scale = 10 }, { mix.power = 2, scale = 100 }]\n\
                'reward.mix.xi' = [0.75, 1]";
    let expected = "[sweep]\nreward = [\n    { mix = { power = 1 }, scale = 10 },\n    \
                    { mix = { power = 2 }, scale = 100 },\n]\n\"reward.mix.xi\" = [0.75, 1]\n\
                    seeds = 1\n";
    let written = plan(text).to_toml();
    assert!(written.ends_with(expected), "{written}");
    assert_eq!(plan(&written).cells()[1].setting, "reward=mix-power-1-scale-10,xi=1");
    // As it always was, where that was right.
    let written = plan("model = '/m'\n[sweep]\n'reward.mix.xi' = [0.75, 1]\nseeds = 8").to_toml();
    assert!(
        written.ends_with("\n\n[sweep]\n\"reward.mix.xi\" = [0.75, 1]\nseeds = 8\n"),
        "{written}"
    );
}

#[test]
fn a_label_names_a_table_and_sets_nothing() {
    let text = "model = '/m'\n[sweep]\nlearning = [{ label = 'paper' }, \
                { optimiser = 'adam', adam.rate = 0.003, label = 'adam_.+-3' }, { rate = 2 }]";
    let plan = plan(text);
    let names: Vec<_> = plan.listing().map(|(_, setting, _)| setting).collect();
    assert_eq!(names, ["learning=paper", "learning=adam_.+-3", "learning=rate-2"]);
    assert_eq!(plan.cells()[0].experiment, experiment("model = '/m'"));
    assert_eq!(self::plan(&plan.to_toml()), plan);
    assert!(plan.to_toml().contains("{ label = \"paper\" }"), "{}", plan.to_toml());
}

#[test]
fn what_sensors_cannot_tell_is_warned_of() {
    let warnings = |text: &str| {
        let plan = open(&format!("model = 'm'\n{text}"), &[]).unwrap();
        let shown = plan.warnings().iter().map(ToString::to_string);
        shown.map(|text| text.split_once("x.toml:").unwrap().1.to_owned()).collect::<Vec<_>>()
    };
    let expected = "2:21: codec: with 2 sensor_bits and 1 actuator_bits the servos' targets lie \
                    exactly on edges of the sensors' bins, so a joint that is at its target flips \
                    between two bins; take at least as many actuator_bits as sensor_bits";
    assert_eq!(warnings("codec.sensor_bits = 2\nsweep.'reward.mix.xi' = [0, 1]"), [expected]);
    assert_eq!(warnings("codec = { sensor_bits = 2, actuator_bits = 2 }"), [""; 0]);
    assert_eq!(warnings("codec.actuator_bits = 2"), [""; 0]);
    let swept = warnings(
        "[sweep]\ncodec = [{ label = 'a' }, { sensor_bits = 3, actuator_bits = 2 }]\nseeds = 3",
    );
    assert_eq!(swept.len(), 1);
    assert!(swept[0].starts_with("3:43: codec: with 3 sensor_bits and 2 "), "{swept:?}");
    let swept = warnings("codec.actuator_bits = 2\n[sweep]\n'codec.sensor_bits' = [1, 2, 3, 4]");
    assert_eq!(swept.len(), 2);
    assert!(swept[1].starts_with("4:33: codec: with 4 sensor_bits and 2 "), "{swept:?}");
}

/// A run that was begun before such mistakes were found goes on.
#[test]
fn what_a_run_was_made_with_is_read_again() {
    let text = "model = '/m'\n[sweep]\n'reward.mix.xi' = [0.0, -0.0]";
    assert!(open(text, &[]).is_err());
    let plan = Plan::written(Path::new("/run/experiment.toml"), text).unwrap();
    assert_eq!(folders(&plan), ["xi=0/seed=1", "xi=-0/seed=1"]);
}

#[test]
fn more_updates_are_checked_as_those_of_a_file_are() {
    let path = Path::new("/run/experiment.toml");
    let extended = |text: &str, updates| {
        let text = format!("model = '/m'\n{text}");
        Plan::extended(path, &text, updates).map_err(|problems| problems.to_string())
    };
    let plan = extended("learning.updates = 3", 1_000_000_000).unwrap();
    assert_eq!(plan.cells()[0].experiment.learning.updates, 1_000_000_000);
    let range = "learning: updates must be a whole number from 1 to 1000000000";
    for updates in [0, 1_000_000_001, 2_000_000_000] {
        let expected = format!("--updates {updates}: {range}, got {updates}");
        assert_eq!(extended("", updates).unwrap_err(), expected);
    }
    let expected =
        format!("--updates {0}: a number that 64 bits can hold expected, got {0}", u64::MAX);
    assert_eq!(extended("", u64::MAX).unwrap_err(), expected);
    for sweep in ["'learning.updates' = [1, 2]", "learning = [{ updates = 2 }, { rate = 2 }]"] {
        let expected = "--updates 7: learning.updates is swept by /run/experiment.toml:3:1, so it \
                        can't be set";
        assert_eq!(extended(&format!("[sweep]\n{sweep}"), 7).unwrap_err(), expected);
    }
}

#[test]
fn models_are_found_from_the_file_or_from_where_the_command_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().canonicalize().unwrap();
    fs::create_dir(folder.join("experiments")).unwrap();
    fs::write(folder.join("robot.toml"), "").unwrap();
    let file = folder.join("experiments/x.toml");
    fs::write(&file, "model = '../robot.toml'").unwrap();
    let model = |overrides: &[String]| {
        Plan::open(&file, overrides).unwrap().cells()[0].experiment.model.clone()
    };
    assert_eq!(Path::new(&model(&[])), folder.join("robot.toml"));
    let here = std::env::current_dir().unwrap();
    assert_eq!(Path::new(&model(&["model='other.toml'".into()])), here.join("other.toml"));
}

/// However the key is written, in a sweep or not.
#[test]
fn policies_to_start_from_are_found_likewise() {
    let initial = |text: &str, overrides: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        let (file, place) = (folder.path().join("x.toml"), folder.path().canonicalize().unwrap());
        fs::write(&file, format!("model = 'm'\n{text}")).unwrap();
        let overrides: Vec<_> = overrides.iter().map(|text| (*text).to_owned()).collect();
        let plan = Plan::open(&file, &overrides).unwrap();
        let path = plan.cells().last().unwrap().experiment.initial().unwrap();
        path.replace(place.to_str().unwrap(), "HERE")
    };
    for text in [
        "policy.initial = 'a/b'",
        "[policy]\ninitial = './a/b'",
        "[sweep]\n'policy.initial' = ['c', 'a/b']",
        "[sweep.policy]\ninitial = ['c', 'a/b']",
        "[sweep]\npolicy = [{ label = 'none' }, { initial = 'a/b' }]",
    ] {
        assert_eq!(initial(text, &[]), "HERE/a/b", "{text}");
    }
    let here = std::env::current_dir().unwrap().join("a/b");
    for set in ["policy.initial='a/b'", "policy={ initial = 'a/b' }"] {
        assert_eq!(Path::new(&initial("policy.initial = 'c'", &[set])), here, "{set}");
    }
    let set = "sweep.policy=[{ label = 'none' }, { initial = 'a/b' }]";
    assert_eq!(Path::new(&initial("", &[set])), here);
}

/// Two cells of two runs export files of the same name.
#[test]
fn cells_are_named_by_the_cells_that_they_start_from() {
    let export = |run: &str| format!("'/{run}/cells/xi=1/seed=2/policy.safetensors'");
    let paths = format!("{}, {}, '/x/good.safetensors'", export("a"), export("b"));
    let plan = plan(&format!("model = '/m'\n[sweep]\n'policy.initial' = [{paths}]"));
    let names: Vec<_> = plan.listing().map(|(_, setting, _)| setting).collect();
    assert_eq!(names, ["initial=xi-1-seed-2", "initial=xi-1-seed-2-2", "initial=good"]);
}

#[test]
fn overrides_are_checked_like_the_file() {
    let found = open("model = '/m'", &["learning.rate=0.3", "sweep.seeds = 7"]).unwrap();
    assert_eq!(found, plan("model = '/m'\nlearning.rate = 0.3\nsweep.seeds = 7"));
    let found = open("model = '/m'", &["learning.rate=-1", "learning.x.y=3", "z", "codec=1"]);
    let expected = "--set codec=1: codec must be a table, got 1\n\
                    --set learning.rate=-1: learning: rate must be > 0 and at most 1e100, got -1\n\
                    --set learning.x.y=3: learning: unknown key 'x', expected one of \
                    'updates', 'steps_per_update', 'discount', 'baseline', 'optimiser', 'rate', \
                    'decay', 'momentum'\n\
                    --set z: key=value expected, as in --set learning.rate=0.3";
    assert_eq!(found.unwrap_err(), expected);
}

#[test]
fn a_sweep_of_the_largest_size_is_read_and_no_larger_one() {
    let text = |n: usize| {
        let values: Vec<_> = (1..=n).map(|i| i.to_string()).collect();
        format!("model = 'm'\n[sweep]\n'learning.updates' = [{}]\nseeds = 10000", values.join(", "))
    };
    assert_eq!(plan(&text(10)).cells().len(), 100_000);
    let expected = "x.toml:2:1: sweep must make at most 100000 cells, got 110000";
    assert_eq!(open(&text(11), &[]).unwrap_err(), expected);
}

/// With what it is and with its tensors.
#[test]
fn every_kind_of_policy_stands_in_the_documentation() {
    let page = |name: &str| {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
        fs::read_to_string(docs.join(name)).unwrap()
    };
    let (settings, folders) = (page("experiment-files.md"), page("run-folders.md"));
    let row = settings.lines().find(|line| line.starts_with("| `policy.kind` |")).unwrap();
    for kind in KindSettings::all() {
        assert!(row.contains(&format!("`\"{}\"`: ", kind.name())), "{row}");
        assert!(folders.contains(&format!("\n| `{}` | `", kind.name())), "{}", kind.name());
    }
}

/// With what it is, what it's called and its unit.
#[test]
fn every_kind_of_reward_stands_in_the_documentation() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let page = |name: &str| fs::read_to_string(docs.join(name)).unwrap();
    let (settings, notation) = (page("experiment-files.md"), page("notation.md"));
    let row = |key: &str| {
        let start = format!("| `{key}` |");
        settings.lines().find(|line| line.starts_with(&start)).unwrap()
    };
    // R_Loc is a mean, and r_Loc,t what it's the mean of.
    let in_a_step = |symbol: &str| match symbol.strip_prefix("R_") {
        Some(index) => format!("\n| r_{index},t |"),
        None => format!("\n| {symbol} |"),
    };
    for task in ExtrinsicSettings::all() {
        let (name, task) = (task.kind(), task.get());
        let said = format!("`\"{name}\"` ({}, {}): ", task.symbol(), task.unit());
        assert!(row("reward.extrinsic.kind").contains(&said), "{said}");
        assert!(notation.contains(&in_a_step(task.symbol())), "{}", task.symbol());
    }
    for information in IntrinsicSettings::all() {
        let (name, symbol) = (information.kind(), information.get().symbol());
        assert!(row("reward.intrinsic.kind").contains(&format!("`\"{name}\"`: ")), "{name}");
        assert!(name == symbol || notation.contains(&in_a_step(symbol)), "{symbol}");
    }
}

#[test]
fn every_key_stands_in_the_documentation() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/experiment-files.md");
    let page = fs::read_to_string(page).unwrap();
    let texts = [
        "",
        "reward = { mix.kind = 'linear', extrinsic.kind = 'turning' }\nlearning.optimiser = 'adam'",
        "reward = { mix.xi = 1, intrinsic.kind = 'none' }\nlearning.optimiser = 'rprop'",
        "reward.extrinsic = { kind = 'height', body = 'x' }",
        "description = 'x'\nreward.mix.schedule = [[0, 1]]",
        "policy = { connectivity = 'per_group', inputs = 'own_group' }",
        "policy.initial = 'x'",
    ];
    let kinds = KindSettings::all();
    let kinds = kinds.iter().map(|kind| format!("policy.kind = '{}'", kind.name()));
    let tasks = ExtrinsicSettings::all();
    let tasks = tasks.iter().map(|task| format!("reward.extrinsic.kind = '{}'", task.kind()));
    let information = ["mutual_information", "transfer_entropy"];
    let information = information.map(|kind| format!("reward.intrinsic.kind = '{kind}'"));
    let kinds = kinds.chain(tasks).chain(information);
    for text in texts.map(str::to_owned).into_iter().chain(kinds) {
        let experiment = experiment(&format!("model = 'm'\n{text}"));
        for (key, _) in leaves::leaves(&leaves::table(&experiment)) {
            assert!(page.contains(&format!("| `{key}` |")), "docs/experiment-files.md lacks {key}");
        }
    }
}
