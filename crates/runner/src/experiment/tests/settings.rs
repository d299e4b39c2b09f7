//! Defaults, what depends on others, warnings, and changes from the command line.

use std::path::Path;

use super::{experiment, open, plan};
use crate::experiment::Plan;

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

#[test]
fn overrides_are_checked_like_the_file() {
    let found = open("model = '/m'", &["learning.rate=0.3", "sweep.seeds = 7"]).unwrap();
    assert_eq!(found, plan("model = '/m'\nlearning.rate = 0.3\nsweep.seeds = 7"));
    let found = open("model = '/m'", &["learning.rate=-1", "learning.x.y=3", "z", "codec=1"]);
    let expected = "--set codec=1: codec must be a table, got 1\n\
                    --set learning.rate=-1: learning: rate must be > 0 and at most 1e100, got -1\n\
                    --set learning.x.y=3: learning: unknown key 'x', expected one of \
                    'updates', 'steps_per_update', 'kind', 'worlds', 'discount', 'baseline', \
                    'optimiser', 'rate', \
                    'decay', 'momentum'\n\
                    --set z: key=value expected, as in --set learning.rate=0.3";
    assert_eq!(found.unwrap_err(), expected);
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
