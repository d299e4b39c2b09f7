//! Runs that an earlier version left: every command opens them, and they go on with the same bytes.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::common::*;
use runs::{CellFolder, Checkpoint, Extent};
use tempfile::TempDir;
use xxhash_rust::xxh3::xxh3_64;

/// A copy of a run that stands at update 10 of 30, in two cells.
fn first() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    copy(&root().join("tests/folders/first"), &run);
    (folder, run)
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let to = to.join(entry.file_name());
        match entry.file_type().unwrap().is_dir() {
            true => copy(&entry.path(), &to),
            false => drop(fs::copy(entry.path(), to).unwrap()),
        }
    }
}

#[test]
fn every_command_opens_the_run() {
    let (folder, run) = first();
    let cell = run.join("cells/xi=1/seed=1");
    let (run, cell) = (run.to_str().unwrap(), cell.to_str().unwrap());
    itarl(&["status", run]).ends(STOPPED).prints(&["2 cells: 2 stopped", "10/30"]);
    itarl(&["summary", run]).ends(DONE).prints(&["xi=0.75", "xi=1"]);
    itarl(&["plot", run]).ends(DONE);
    itarl(&["report", run]).ends(DONE);
    itarl(&["rollout", cell, "--steps", "5"]).ends(DONE).prints(&["contacts"]);
    let page = folder.path().join("page.html");
    itarl(&["replay", cell, "--html", page.to_str().unwrap()]).ends(DONE);
    assert!(fs::read_to_string(page).unwrap().contains("xi=1, seed 1"));
}

/// The cells as the first version would have left them: without the columns that came later.
fn age(run: &Path) {
    let first = root().join("tests/folders/first/cells/xi=1/seed=1/metrics.csv");
    let n_columns = fs::read_to_string(first).unwrap().lines().next().unwrap().split(',').count();
    for setting in fs::read_dir(run.join("cells")).unwrap() {
        for cell in fs::read_dir(setting.unwrap().path()).unwrap() {
            let cell = CellFolder::new(cell.unwrap().path());
            let rows = fs::read_to_string(cell.metrics()).unwrap();
            let older = |line: &str| line.split(',').take(n_columns).collect::<Vec<_>>().join(",");
            let rows: String = rows.lines().map(|line| older(line) + "\n").collect();
            fs::write(cell.metrics(), &rows).unwrap();
            let bytes = fs::read(cell.checkpoint()).unwrap();
            let mut checkpoint = Checkpoint::decode(&cell.checkpoint(), &bytes).unwrap();
            let (length, xxh3) = (rows.len() as u64, xxh3_64(rows.as_bytes()));
            checkpoint.header.metrics = Extent { length, xxh3 };
            checkpoint.write(&cell.checkpoint()).unwrap();
        }
    }
}

/// As if that version had trained it to its end: what this one trains, without what came later.
#[test]
fn it_goes_on_with_the_same_bytes() {
    let (folder, run) = first();
    itarl(&["resume", run.to_str().unwrap()]).ends(DONE);
    let fresh = folder.path().join("fresh");
    let settings = ["--set", "sweep.seeds=1", "--set", "record.steps=20"];
    let train = ["train", CRAWLER, "--out", fresh.to_str().unwrap()];
    itarl(&[&train[..], &settings].concat()).ends(DONE);
    age(&fresh);
    assert_same(&results(&run), &results(&fresh));
}

/// What the task's own column would say is in others for the tasks that there were.
#[test]
fn without_the_column_of_the_task_the_same_is_told() {
    for kind in ["locomotion", "turning"] {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("run");
        let kind = format!("reward.extrinsic.kind='{kind}'");
        train(&run, &["--set", "learning.updates=12", "--set", &kind]).ends(DONE);
        let told = || {
            itarl(&["plot", text(&run), "final", "close-up"]).ends(DONE);
            let said = ["status", "summary"].map(|it| itarl(&[it, text(&run)]).ends(DONE).out);
            (said, tree(&run.join("plots")))
        };
        let now = told();
        age(&run);
        assert!(told() == now, "{kind}");
    }
}
