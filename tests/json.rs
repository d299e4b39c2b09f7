//! `--json`: one object a line, and every key of it is in docs/json.md.

use std::{collections::BTreeSet, fs};

use crate::common::*;
use serde_json::Value;

/// All keys, but those that are names of states or columns.
fn keys(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                found.insert(key.clone());
                if !["counts", "latest"].contains(&key.as_str()) {
                    keys(value, found);
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|item| keys(item, found)),
        _ => {}
    }
}

#[track_caller]
fn parsed(said: &Said, command: &str) -> Value {
    assert_eq!(said.out.lines().count(), 1, "{said:?}");
    let value: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!((&value["command"], &value["format"]), (&command.into(), &1.into()));
    value
}

#[test]
fn every_key_is_in_the_document() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &[]).ends(DONE);
    let cell = run.join("cells/xi=1/seed=2");
    let idle = folder.path().join("idle");
    train(&idle, &["--set", "learning.rate=1e-9"]).ends(DONE);
    let document = fs::read_to_string(root().join("docs/json.md")).unwrap();
    for (command, words) in [
        ("status", &["status", text(&run)][..]),
        ("summary", &["summary", text(&run)]),
        ("check", &["check", text(&idle)]),
        ("rollout", &["rollout", text(&cell), "--steps", "3"]),
        ("model show", &["model", "show", "tests/models/crawler.toml"]),
        ("bench", &["bench", "--seconds", "0.1", "tests/experiments/crawler.toml"]),
    ] {
        // That parameters don't move is found.
        let code = if command == "check" { FAILED } else { DONE };
        let value = parsed(&itarl(&[words, &["--json"]].concat()).ends(code), command);
        let mut found = BTreeSet::new();
        keys(&value, &mut found);
        for key in found {
            assert!(document.contains(&format!("`{key}`")), "{command}: {key}");
        }
        assert!(document.contains(&format!("## `itarl {command} ")));
    }
}

#[test]
fn who_is_where_is_told_and_watched_until_nothing_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let long = ["--set", "learning.updates=100000", "--threads", "1"];
    let worker = start(&train_words(&run, &long));
    let status = || itarl(&["status", text(&run), "--json"]);
    wait_until(|| status().out.contains("\"cells_per_hour\""));
    let value = parsed(&status().ends(STOPPED), "status");
    assert_eq!(value["pace"]["workers"], 1);
    assert!(value["pace"]["seconds_left"].as_f64().unwrap() > 0.0, "{value}");
    for cell in value["cells"].as_array().unwrap() {
        assert_eq!(cell["writer"]["process"], worker.id(), "{cell}");
        assert!(cell["latest"]["update"].as_u64().unwrap() > 0, "{cell}");
    }
    let shown = itarl(&["status", text(&run)]).ends(STOPPED).prints(&["1 worker on 1 machine: "]);
    assert!(shown.out.contains(&format!(":{} |", worker.id())), "{shown:?}");
    signal(&worker, "TERM");
    end(worker).ends(STOPPED);

    fs::remove_dir_all(&run).unwrap();
    train(&run, &["--stop-after", "4"]).ends(STOPPED);
    let watch = start(&["status", text(&run), "--json", "--watch=1"]);
    itarl(&["resume", text(&run)]).ends(DONE);
    let said = end(watch).ends(DONE);
    let last: Value = serde_json::from_str(said.out.lines().last().unwrap()).unwrap();
    assert_eq!(last["counts"]["done"], 4, "{said:?}");
}
