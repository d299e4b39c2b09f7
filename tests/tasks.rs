//! What a run came to is told by its own task, with its unit, wherever it's told; by what all
//! measure, where there are several.
#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use base64::{Engine, engine::general_purpose::STANDARD};
use common::*;
use tempfile::TempDir;

/// Four cells of 12 updates with other settings, done.
fn trained(more: &[&str]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &[&["--set", "learning.updates=12"], more].concat()).ends(DONE);
    (folder, run)
}

/// All that the readers of a run print and write, by what it is.
fn told(run: &Path) -> BTreeMap<String, String> {
    let mut told = BTreeMap::new();
    for command in ["status", "summary", "plot", "report"] {
        let said = itarl(&[command, text(run)]).ends(DONE);
        told.insert(command.to_owned(), said.out + &said.err);
    }
    for (name, bytes) in tree(&run.join("plots")) {
        told.insert(name, String::from_utf8(bytes).unwrap());
    }
    let page = fs::read_to_string(run.join("report.html")).unwrap();
    let pictures = page.split("data:image/svg+xml;base64,").skip(1);
    for (i, picture) in pictures.enumerate() {
        let (data, _) = picture.split_once('"').unwrap();
        let svg = String::from_utf8(STANDARD.decode(data).unwrap()).unwrap();
        told.insert(format!("picture {i} of the report"), svg);
    }
    assert!(told.contains_key("picture 5 of the report"));
    told.insert("report.html".into(), page);
    told
}

/// The field of a row of `instances.csv`, by the column's name.
fn instances(run: &Path, name: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(run.join("plots/instances.csv")).unwrap();
    let rows = reader.deserialize().map(|row| row.unwrap());
    let rows: Vec<BTreeMap<String, String>> = rows.collect();
    rows.iter().map(|row| row[name].parse().unwrap()).collect()
}

#[test]
fn a_turning_run_is_told_by_turning_everywhere() {
    let (_folder, run) = trained(&["--set", "reward.extrinsic.kind='turning'"]);
    let told = told(&run);
    for (name, text) in &told {
        assert!(!text.contains("R_Loc"), "{name} says R_Loc");
        // As an axis is named: R with an index.
        assert!(!name.ends_with(".svg") || !text.contains("\nLoc\n"), "{name} has an index Loc");
    }
    let names = [
        "status",
        "summary",
        "learning-curves.svg",
        "close-up.svg",
        "feet.svg",
        "scatter.svg",
        "final.svg",
        "settings.csv",
        "instances.csv",
        "report.html",
    ];
    for name in names {
        assert!(told[name].contains("turning") && told[name].contains("rad"), "{name}");
    }
    assert!(told["correlation.csv"].contains("pearson_turning_R_MI"));

    // The column is the heading's change in a control step, and the table has its last window.
    for (cell, last) in ["xi=0.75/seed=1", "xi=0.75/seed=2", "xi=1/seed=1", "xi=1/seed=2"]
        .into_iter()
        .zip(instances(&run, "turning_last_window_rad"))
    {
        let cell = run.join("cells").join(cell);
        let (task, turn) = (column(&cell, "task"), column(&cell, "heading_change_rad"));
        assert_eq!(task, turn.iter().map(|rad| rad / 10.0).collect::<Vec<_>>());
        assert_eq!(task[11], last);
    }
}

#[test]
fn a_walking_run_is_told_by_the_papers_symbol() {
    let (_folder, run) = trained(&[]);
    let told = told(&run);
    for name in ["status", "summary", "close-up.svg", "feet.svg", "settings.csv", "report.html"] {
        assert!(told[name].contains("R_Loc") && !told[name].contains("turning"), "{name}");
    }
    let cell = run.join("cells/xi=1/seed=2");
    assert_eq!(column(&cell, "task"), column(&cell, "R_Loc"));
}

/// Metres and radians are never compared, nor drawn on one axis.
#[test]
fn a_run_of_several_tasks_is_told_by_what_all_of_them_measure() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tasks.toml");
    let crawler = fs::read_to_string(root().join(CRAWLER)).unwrap();
    let crawler = crawler.replace("../models", text(&root().join("tests/models")));
    let swept = "\"reward.extrinsic.kind\" = [\"locomotion\", \"turning\"]";
    fs::write(&file, crawler.replace("\"reward.mix.xi\" = [0.75, 1]", swept)).unwrap();
    let run = folder.path().join("run");
    itarl(&["train", text(&file), "--out", text(&run)]).ends(DONE);
    let told = told(&run);
    let caveat = "different tasks (locomotion, turning)";
    for name in ["status", "summary", "close-up.svg", "feet.svg", "scatter.svg", "report.html"] {
        assert!(told[name].contains("R_Loc") && told[name].contains(caveat), "{name}");
    }
    let last = instances(&run, "R_Loc_last_window_m");
    for (seed, last) in [1, 2].iter().zip(&last[2..]) {
        let cell = run.join(format!("cells/kind=turning/seed={seed}"));
        let way = column(&cell, "R_Loc");
        assert_eq!(way[27..].iter().sum::<f64>() / 3.0, *last);
        assert_ne!(way, column(&cell, "task"));
    }
}
