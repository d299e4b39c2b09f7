//! What a run came to is told by its own task, and its information by its own kind, with their units,
//! wherever they're told; by what all measure, where there are several.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use crate::common::*;
use base64::{Engine, engine::general_purpose::STANDARD};
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
    for command in ["status", "summary", "plot", "findings", "report"] {
        let said = itarl(&[command, text(run)]).ends(DONE);
        told.insert(command.to_owned(), said.out + &said.err);
    }
    let setting = fs::read_dir(run.join("cells")).unwrap().next().unwrap().unwrap();
    let cell = setting.path().join("seed=1");
    let said = itarl(&["rollout", text(&cell), "--steps", "20"]).ends(DONE);
    told.insert("rollout".into(), said.out);
    let page = run.join("replay.html");
    itarl(&["replay", text(&cell), "--html", text(&page)]).ends(DONE);
    told.insert("replay.html".into(), fs::read_to_string(page).unwrap());
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

/// One cell for each of these values of a key, with two seeds.
fn swept(set: &str, sweep: &str) -> (TempDir, PathBuf, String) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("swept.toml");
    let crawler = fs::read_to_string(root().join(CRAWLER)).unwrap();
    let crawler = crawler.replace("../models", text(&root().join("tests/models")));
    let crawler = crawler.replace("updates = 30", "updates = 12");
    let crawler = crawler.replace("\"reward.mix.xi\" = [0.75, 1]", sweep);
    fs::write(&file, format!("{set}\n{crawler}")).unwrap();
    let run = folder.path().join("run");
    let said = itarl(&["train", text(&file), "--out", text(&run)]).ends(DONE);
    (folder, run, said.err)
}

/// Whether a text says nats: packed numbers might have these four letters anywhere.
fn says_nats(text: &str) -> bool {
    [" nats", "\"nats", "[nats"].iter().any(|nats| text.contains(nats))
}

/// Whether a text says a symbol with an index: in figures the index is below the line. Pages have words of
/// three.js in them that go on like one.
fn says(name: &str, text: &str, symbol: &str) -> bool {
    let (_, index) = symbol.split_once('_').unwrap();
    let begins = |(at, _)| !text[..at].ends_with(|it: char| it.is_ascii_alphanumeric());
    let is_below = || name.ends_with(".svg") && text.contains(&format!("\n{index}\n"));
    text.match_indices(symbol).any(begins) || is_below()
}

#[test]
fn a_run_with_transfer_entropy_is_told_by_it_everywhere() {
    let set = "reward.intrinsic.kind = 'transfer_entropy'";
    let (_folder, run, progress) = swept(set, "\"reward.mix.xi\" = [0.75, 1]");
    let mut told = told(&run);
    told.insert("progress".into(), progress);
    for (name, text) in &told {
        assert!(!says(name, text, "R_MI"), "{name} says R_MI");
        assert!(!text.to_lowercase().contains("mutual information"), "{name}");
        assert!(!text.contains("nats per variable"), "{name}");
    }
    let names = [
        "status",
        "summary",
        "findings",
        "rollout",
        "replay.html",
        "learning-curves.svg",
        "scatter.svg",
        "correlation.csv",
        "report.html",
    ];
    for name in names {
        assert!(says(name, &told[name], "R_TE"), "{name}");
    }
    for name in ["learning-curves.svg", "scatter.svg", "rollout"] {
        assert!(told[name].contains("nats per link"), "{name}");
    }
    assert!(told["correlation.csv"].contains("pearson_R_Loc_R_TE"));
}

#[test]
fn a_run_without_information_tells_of_none() {
    let set = "reward.intrinsic.kind = 'none'";
    let (_folder, run, progress) = swept(set, "\"reward.mix.xi\" = [1]");
    let mut told = told(&run);
    told.insert("progress".into(), progress);
    for (name, text) in &told {
        let is_said = says(name, text, "R_MI") || says(name, text, "R_TE");
        // As the entropy of the outputs is.
        assert!(!is_said && !says_nats(&text.replace("nats per bit", "")), "{name}");
    }
    assert!(told.contains_key("learning-curves.svg"));
    assert!(!told.contains_key("scatter.svg") && !told.contains_key("correlation.csv"));
    let scatter = itarl(&["plot", text(&run), "scatter"]).ends(FAILED);
    scatter.complains(&["left out scatter: ", "reward.intrinsic.kind", "none"]);
}

/// They have one unit, and still are other things.
#[test]
fn a_run_of_several_kinds_of_information_says_so() {
    let kinds = "['mutual_information', 'transfer_entropy']";
    let (_folder, run, _) = swept("", &format!("\"reward.intrinsic.kind\" = {kinds}"));
    let told = told(&run);
    let caveat = "different kinds of information (mutual information, transfer entropy)";
    for name in ["status", "summary", "scatter.svg", "findings", "report.html"] {
        // Each clip of the report has the information of its own cell.
        let is_said = says(name, &told[name], "R_MI") || says(name, &told[name], "R_TE");
        assert!(!is_said || name == "report.html", "{name}");
        assert!(told[name].contains(caveat) && told[name].contains("information"), "{name}");
    }
    assert!(told["correlation.csv"].contains("pearson_R_Loc_information"));
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
