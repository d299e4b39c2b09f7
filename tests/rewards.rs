//! Every kind of reward trains, goes on and is shown like any other.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use crate::common::*;
use reward::{ExtrinsicSettings, intrinsic::IntrinsicSettings};

/// All kinds of both lists, and variants of some, as lines of an experiment.
fn rewards() -> Vec<String> {
    let extrinsic = ExtrinsicSettings::all();
    let extrinsic = extrinsic.iter().map(|it| format!("reward.extrinsic.kind = '{}'", it.kind()));
    let intrinsic = IntrinsicSettings::all();
    let intrinsic = intrinsic.iter().map(|it| format!("reward.intrinsic.kind = '{}'", it.kind()));
    let variants = [
        // The crawler goes some centimetres: some points are reached.
        "reward.extrinsic = { kind = 'reach', distance_m = 0.02, radius_m = 0.015, scale = 5 }",
        "reward.extrinsic = { kind = 'height', body = 'forearm', scale = -1 }",
        "reward.extrinsic = { kind = 'efficient_locomotion', price_m_per_j = 0.05 }",
        "reward.intrinsic = { kind = 'transfer_entropy', window = 20, max = 1 }",
    ];
    extrinsic.chain(intrinsic).chain(variants.map(str::to_owned)).collect()
}

/// The crawler with this reward, in cells of 12 updates.
fn experiment(folder: &Path, reward: &str) -> PathBuf {
    let text = fs::read_to_string(root().join(CRAWLER)).unwrap();
    let model = root().join("tests/models/crawler.toml");
    let xi = if reward.contains("'none'") { "[1]" } else { "[0.75, 1]" };
    let text = text
        .replace("../models/crawler.toml", model.to_str().unwrap())
        .replace("updates = 30", "updates = 12")
        .replace("[0.75, 1]", xi);
    let file = folder.join("x.toml");
    fs::write(&file, format!("{reward}\n{text}")).unwrap();
    file
}

#[test]
fn every_reward_trains_with_the_same_bytes_however_it_is_done() {
    let mut metrics = BTreeSet::new();
    for reward in &rewards() {
        let folder = tempfile::tempdir().unwrap();
        let file = experiment(folder.path(), reward);
        let run = |name: &str| folder.path().join(name);
        let train = |name: &str, more: &[&str]| {
            itarl(&[&["train", text(&file), "--out", text(&run(name))], more].concat())
        };
        train("through", &["--threads", "1"]).ends(DONE);
        let through = results(&run("through"));
        train("lanes", &["--threads", "2", "--lanes", "3"]).ends(DONE);
        assert_same(&results(&run("lanes")), &through);
        train("alone", &["--threads", "2", "--solver", "bullet"]).ends(DONE);
        assert_same(&results(&run("alone")), &through);
        train("cut", &["--stop-after", "3"]).ends(STOPPED);
        itarl(&["resume", text(&run("cut")), "--stop-after", "6"]).ends(STOPPED);
        itarl(&["resume", text(&run("cut"))]).ends(DONE);
        assert_same(&results(&run("cut")), &through);
        metrics.insert(fs::read(run("cut/cells/xi=1/seed=2/metrics.csv")).unwrap());
    }
    // Both lists begin with the default, and all others make something else of it.
    assert_eq!(metrics.len(), rewards().len() - 1);
}

#[test]
fn every_reward_is_rolled_out_and_shown() {
    for reward in &rewards() {
        let folder = tempfile::tempdir().unwrap();
        let (file, run) = (experiment(folder.path(), reward), folder.path().join("run"));
        let words = ["--set", "learning.updates=3", "--out", text(&run)];
        itarl(&[&["train", text(&file)], &words[..]].concat()).ends(DONE);
        let cell = run.join("cells/xi=1/seed=1");
        let roll = || itarl(&["rollout", text(&cell), "--steps", "20"]).ends(DONE).out;
        assert_eq!(roll(), roll(), "{reward}");
        for command in ["status", "summary", "report"] {
            itarl(&[command, text(&run)]).ends(DONE);
        }
    }
}

#[test]
fn what_a_reward_lacks_is_named_before_anything_is_begun() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    for (set, messages) in [
        (
            "reward.extrinsic={ kind = 'height', body = 'fourarm' }",
            &[
                "setting xi=0.75",
                "reward.extrinsic.body must be one of the model's bodies, 'block', 'upper arm', \
                 'forearm'; got 'fourarm', did you mean 'forearm'?",
            ][..],
        ),
        (
            "reward.extrinsic={ kind = 'reach', radius_m = 7 }",
            &["radius_m must be below distance_m, 5, got 7"],
        ),
        (
            "reward.extrinsic={ kind = 'reach', distance_m = 0.2 }",
            &["radius_m must be below distance_m, 0.2, got 0.5"],
        ),
        (
            "reward.extrinsic={ kind = 'efficient_locomotion', price_m_per_j = -1 }",
            &["price_m_per_j must be a number from 0 to"],
        ),
        (
            "reward.extrinsic={ kind = 'turning', body = 'block' }",
            &["reward.extrinsic 'turning': unknown key 'body'"],
        ),
        (
            "reward.intrinsic={ kind = 'transfer_entropy', window = 1 }",
            &["window must be a whole number from 2 to 1048576, got 1"],
        ),
    ] {
        train(&run, &["--set", set]).ends(FAILED).complains(messages);
        assert!(!run.exists(), "{set}");
    }
}
