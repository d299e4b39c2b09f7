//! Sweeps: which cells there are, and what they are called.

use policy::KindSettings;

use super::{experiment, folders, open, plan};

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

/// As the model's own keys, which aren't known here.
#[test]
fn keys_of_the_model_can_be_swept() {
    let text = "model = '/m'\nrobot.body.torso.mass_kg = 2\n[sweep]\n\
                'robot.servo.leg.speed_limit_rad_s' = [0.5, 1]\n\
                robot.start = [{ position_m = [0, 0, 1], label = 'high' }]";
    let plan = plan(text);
    let names: Vec<_> = plan.listing().map(|(_, setting, _)| setting).collect();
    assert_eq!(names, ["speed_limit_rad_s=0.5,start=high", "speed_limit_rad_s=1,start=high"]);
    let expected = "body = { torso = { mass_kg = 2 } }\n\
                    servo.leg.speed_limit_rad_s = 1\nstart.position_m = [0, 0, 1]";
    let expected: toml::Table = expected.parse().unwrap();
    assert_eq!(plan.cells()[1].experiment.robot.to_table(), expected);
    assert_eq!(self::plan(&plan.to_toml()), plan, "{}", plan.to_toml());
    assert!(plan.to_toml().contains("[robot.body.torso]\nmass_kg = 2"), "{}", plan.to_toml());

    let swept_twice = open(&format!("{text}\n'robot.servo.leg' = [{{ torque = 1 }}]"), &[]);
    assert_eq!(swept_twice.map(|plan| plan.cells().len()), Ok(2));
    let set = open(text, &["robot.servo.leg.speed_limit_rad_s=3"]).unwrap_err();
    assert!(set.contains("is swept by x.toml:4:1, so it can't be set"), "{set}");
}

/// What cells are told apart by stays what it was.
#[test]
fn a_robot_as_its_model_says_is_not_written() {
    let written = experiment("model = 'm'").to_toml();
    assert!(!written.contains("robot"), "{written}");
    assert_eq!(experiment("model = 'm'\n[robot]"), experiment("model = 'm'"));
    assert_ne!(experiment("model = 'm'\nrobot.x = 1"), experiment("model = 'm'"));
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
fn a_sweep_of_the_largest_size_is_read_and_no_larger_one() {
    let text = |n: usize| {
        let values: Vec<_> = (1..=n).map(|i| i.to_string()).collect();
        format!("model = 'm'\n[sweep]\n'learning.updates' = [{}]\nseeds = 10000", values.join(", "))
    };
    assert_eq!(plan(&text(10)).cells().len(), 100_000);
    let expected = "x.toml:2:1: sweep must make at most 100000 cells, got 110000";
    assert_eq!(open(&text(11), &[]).unwrap_err(), expected);
}
