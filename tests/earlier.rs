//! Runs that an earlier version left: every command opens them, and they go on with the same bytes.
#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use std::{
    fs,
    path::{Path, PathBuf},
};

use common::*;
use tempfile::TempDir;

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
    itarl(&["status", run]).ends(DONE).prints(&["2 cells: 2 stopped", "10/30"]);
    itarl(&["summary", run]).ends(DONE).prints(&["xi=0.75", "xi=1"]);
    itarl(&["plot", run]).ends(DONE);
    itarl(&["report", run]).ends(DONE);
    itarl(&["rollout", cell, "--steps", "5"]).ends(DONE).prints(&["contacts"]);
    let page = folder.path().join("page.html");
    itarl(&["replay", cell, "--html", page.to_str().unwrap()]).ends(DONE);
    assert!(fs::read_to_string(page).unwrap().contains("xi=1, seed 1"));
}

/// As if this version had trained it from the start.
#[test]
fn it_goes_on_with_the_same_bytes() {
    let (folder, run) = first();
    itarl(&["resume", run.to_str().unwrap()]).ends(DONE);
    let fresh = folder.path().join("fresh");
    let settings = ["--set", "sweep.seeds=1", "--set", "record.steps=20"];
    let train = ["train", CRAWLER, "--out", fresh.to_str().unwrap()];
    itarl(&[&train[..], &settings].concat()).ends(DONE);
    assert_same(&results(&run), &results(&fresh));
}
