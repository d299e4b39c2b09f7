//! The same experiment gives the same bytes: however often it runs, over however many threads and
//! lanes and by whichever solver, in a sweep or alone, in one go or in many, to its end at once or
//! extended.

use std::{collections::BTreeMap, fs, path::Path};

use crate::common::*;

/// What a cell leaves.
const FILES: [&str; 4] = ["checkpoint", "metrics.csv", "policy.safetensors", "replay.safetensors"];

/// All that the four cells leave, trained with these words; the folder's name is one of them.
fn trained(name: &str, more: &[&str]) -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join(name);
    train(&run, more).ends(DONE);
    results(&run)
}

#[test]
fn any_number_of_threads_and_lanes_and_either_solver_agree() {
    let one = trained("run", &["--threads", "1"]);
    let names: Vec<_> = ["xi=0.75", "xi=1"]
        .iter()
        .flat_map(|xi| [1, 2].map(|seed| format!("{xi}/seed={seed}")))
        .flat_map(|cell| FILES.map(|file| format!("{cell}/{file}")))
        .collect();
    assert_eq!(one.keys().cloned().collect::<Vec<_>>(), names);
    assert_same(&one, &trained("elsewhere", &["--threads", "3"]));
    // Nor does it matter who steps the worlds, and how many cells are stepped together.
    for how in [
        &["--solver", "bullet"][..],
        &["--solver", "lockstep", "--lanes", "1"],
        &["--lanes", "3", "--threads", "1"],
        &["--lanes", "2", "--threads", "2"],
    ] {
        assert_same(&one, &trained("run", how));
    }
    // Bytes that no setting changes would agree, too.
    for file in FILES {
        let of = |cell: &str| &one[&format!("{cell}/{file}")];
        assert!(of("xi=1/seed=1") != of("xi=1/seed=2"), "{file}");
        assert!(of("xi=0.75/seed=1") != of("xi=1/seed=1"), "{file}");
    }
}

#[test]
fn a_cell_alone_is_as_in_the_sweep() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    // Backwards, and each in a process of its own.
    for index in ["3", "2", "1", "0"] {
        itarl(&["cell", CRAWLER, "--index", index, "--out", text(&run)]).ends(DONE);
    }
    assert_same(&results(&run), &trained("run", &[]));
}

/// Goes on in calls of so many updates until all is done.
fn in_calls(run: &Path, lengths: &[&str]) -> usize {
    let mut calls = 1;
    let mut lengths = lengths.iter().cycle();
    let mut said = train(run, &["--stop-after", lengths.next().unwrap()]);
    while said.code == Some(STOPPED) {
        calls += 1;
        said = itarl(&["resume", text(run), "--stop-after", lengths.next().unwrap()]);
    }
    said.ends(DONE);
    calls
}

#[test]
fn in_one_go_or_in_many() {
    let through = trained("run", &[]);
    // A checkpoint is due at every fourth of 30 updates: these stop beside them and on them.
    for (lengths, n) in [(["1", "2", "10"], 9), (["4", "8", "4"], 6), (["7", "7", "7"], 5)] {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("run");
        assert_eq!(in_calls(&run, &lengths), n);
        assert_same(&results(&run), &through);
    }
}

#[test]
fn extended_or_as_long_from_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &["--set", "learning.updates=18"]).ends(DONE);
    let short = results(&run);
    itarl(&["resume", text(&run), "--updates", "22"]).ends(DONE);
    train(&run, &[]).ends(DONE);
    let through = folder.path().join("through");
    train(&through, &[]).ends(DONE);
    assert_same(&results(&run), &results(&through));
    assert!(short["xi=1/seed=1/checkpoint"] != results(&run)["xi=1/seed=1/checkpoint"]);
    for file in ["manifest.json", "experiment.toml"] {
        let of = |run: &Path| fs::read_to_string(run.join(file)).unwrap();
        assert_eq!(of(&run), of(&through), "{file}");
    }
}

/// Cells of one world and of several, and populations, which share threads and lanes.
#[test]
fn cells_of_many_worlds_too() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("worlds.toml");
    let model = root().join("tests/models/crawler.toml");
    let crawler = fs::read_to_string(root().join(CRAWLER)).unwrap();
    let learning = "\"learning\" = [{ label = \"one\" }, { label = \"five\", worlds = 5 }, \
                    { label = \"population\", kind = \"evolution\", worlds = 6, evolution.skip = 4 }]";
    let crawler = crawler
        .replace("../models/crawler.toml", text(&model))
        .replace("\"reward.mix.xi\" = [0.75, 1]", learning);
    fs::write(&file, crawler).unwrap();
    let run = |name: &str, more: &[&str], code| {
        let run = folder.path().join(name);
        itarl(&[&["train", text(&file), "--out", text(&run)], more].concat()).ends(code);
        results(&run)
    };
    let through = run("through", &["--threads", "1"], DONE);
    assert_eq!(through.len(), 3 * 2 * FILES.len());
    for (how, name) in [
        (&["--threads", "4"][..], "threads"),
        (&["--lanes", "4", "--threads", "2"], "lanes"),
        (&["--solver", "bullet"], "stock"),
    ] {
        assert_same(&run(name, how, DONE), &through);
    }
    run("cut", &["--stop-after", "7"], STOPPED);
    assert_same(&run("cut", &["--threads", "2"], DONE), &through);

    // Control steps are those of all worlds.
    let metrics = String::from_utf8(through["learning=five/seed=1/metrics.csv"].clone()).unwrap();
    assert!(metrics.lines().last().unwrap().starts_with("30,1500,"), "{metrics}");
    itarl(&["status", text(&folder.path().join("cut"))]).ends(DONE).prints(&["30/30"]);
}

/// With all the paper's settings but the lengths.
#[test]
fn svenja_too() {
    let folder = tempfile::tempdir().unwrap();
    let sets = [
        "learning.updates=3",
        "learning.steps_per_update=5",
        "control.settle_steps=2",
        "checkpoint.every=2",
        "sweep.seeds=1",
    ];
    let sets = sets.iter().flat_map(|it| ["--set", it]);
    let words: Vec<_> = ["train", "experiments/beginning.toml"].into_iter().chain(sets).collect();
    let run = |name: &str, more: &[&str], code| {
        let run = folder.path().join(name);
        itarl(&[&words[..], &["--out", text(&run)], more].concat()).ends(code);
        results(&run)
    };
    let through = run("through", &["--threads", "1"], DONE);
    assert_eq!(through.len(), 2 * FILES.len());
    run("cut", &["--stop-after", "1"], STOPPED);
    assert_same(&run("cut", &["--threads", "2"], DONE), &through);
    assert_same(&run("stock", &["--solver", "bullet"], DONE), &through);
}
