//! `itarl check`: what is wrong with runs that were made to go wrong, and nothing of one that goes well.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::common::*;
use serde_json::Value;
use tempfile::TempDir;

/// A run of the crawler with other settings, done or failed.
fn run(settings: &[&str]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let sets = settings.iter().flat_map(|it| ["--set", it]);
    train(&run, &sets.collect::<Vec<_>>());
    (folder, run)
}

/// The symptoms that are found, each with the update where it began.
fn found(run: &Path) -> Vec<(String, Option<u64>)> {
    let said = itarl(&["check", text(run), "--json"]);
    let value: Value = serde_json::from_str(&said.out).unwrap();
    let symptoms = value["symptoms"].as_array().unwrap();
    assert_eq!(said.code, Some(if symptoms.is_empty() { DONE } else { FAILED }), "{said:?}");
    let symptom = |it: &Value| (it["symptom"].as_str().unwrap().to_owned(), it["since"].as_u64());
    symptoms.iter().map(symptom).collect()
}

#[track_caller]
fn has(run: &Path, symptom: &str) {
    let found = found(run);
    assert!(found.iter().any(|(it, _)| it == symptom), "{symptom}: {found:?}");
    itarl(&["check", text(run)]).ends(FAILED).prints(&[symptom, "What to try:"]);
}

#[track_caller]
fn hasnt(run: &Path, symptom: &str) {
    let found = found(run);
    assert!(found.iter().all(|(it, _)| it != symptom), "{symptom}: {found:?}");
}

#[test]
fn a_rate_that_is_far_too_high_freezes_the_policy_and_its_parameters_run_away() {
    let (_folder, run) = run(&["learning.rate=300000"]);
    has(&run, "policy frozen");
    has(&run, "parameters running away");
    // In the report, too.
    itarl(&["report", text(&run)]).ends(DONE);
    let page = fs::read_to_string(run.join("report.html")).unwrap();
    assert!(page.contains("<td class=\"text\">policy frozen</td>"));
}

#[test]
fn a_rate_that_is_far_too_low_moves_nothing() {
    let (_folder, run) = run(&["learning.rate=0.001"]);
    has(&run, "parameters hardly move");
    hasnt(&run, "policy frozen");
    hasnt(&run, "parameters running away");
}

#[test]
fn a_window_of_two_is_biased() {
    let (_folder, short) = run(&["reward.intrinsic.window=2"]);
    has(&short, "information biased");
}

/// A crawler that mustn't touch the ground with its block, on which it lies.
#[test]
fn a_robot_that_fell_touches_with_what_should_not() {
    let folder = tempfile::tempdir().unwrap();
    let model = fs::read_to_string(root().join("tests/models/crawler.toml")).unwrap();
    let fallen = model.replace("penalised = [\"upper arm\"]", "penalised = [\"block\"]");
    assert_ne!(fallen, model);
    let file = folder.path().join("fallen.toml");
    fs::write(&file, fallen).unwrap();
    let (_other, run) = run(&[&format!("model='{}'", text(&file))]);
    has(&run, "parts touch that shouldn't");
}

#[test]
fn noise_is_told_where_it_is_known() {
    let (_folder, run) = run(&["learning.worlds=4", "learning.updates=40"]);
    let metrics = fs::read_to_string(run.join("cells/xi=1/seed=1/metrics.csv")).unwrap();
    let header: Vec<_> = metrics.lines().next().unwrap().split(',').collect();
    assert_eq!(header[17..], ["output_entropy_nats", "gradient_error"]);
    for line in metrics.lines().skip(1) {
        let values: Vec<f64> = line.split(',').map(|it| it.parse().unwrap()).collect();
        assert!((0.0..=std::f64::consts::LN_2 + 1e-12).contains(&values[17]), "{line}");
        assert!(values[18] > 0.0, "{line}");
    }
    // One world knows no error.
    let (_folder, one) = self::run(&["learning.updates=12"]);
    let metrics = fs::read_to_string(one.join("cells/xi=1/seed=1/metrics.csv")).unwrap();
    assert!(metrics.lines().skip(1).all(|line| line.ends_with(",NaN")));
    hasnt(&one, "gradient lost in noise");
}
