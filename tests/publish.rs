//! `itarl publish`: what is told of a run is told of the folder that was made of it, which nothing can
//! go on from; and `itarl findings`, of both.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::common::*;
use tempfile::TempDir;

/// Four cells of 30 updates, done; and where they may be published.
fn done() -> (TempDir, PathBuf, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let [run, out] = ["run", "out"].map(|name| folder.path().join(name));
    train(&run, &[]).ends(DONE);
    (folder, run, out)
}

fn publish(run: &Path, out: &Path, more: &[&str]) -> Said {
    itarl(&[&["publish", text(run), "--out", text(out)], more].concat())
}

/// What a command says of a folder, but for what it says of its being published.
fn told(command: &[&str], folder: &Path) -> String {
    let said = itarl(&[&command[..1], &[text(folder)], &command[1..]].concat()).ends(DONE);
    let lines = said.out.lines().filter(|line| !line.starts_with("published"));
    lines.map(|line| line.replace(text(folder), "DIR") + "\n").collect()
}

/// The tables of a report, and what the paper found.
fn numbers(folder: &Path) -> String {
    itarl(&["report", text(folder)]).ends(DONE);
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    let (_, numbers) = page.split_once("What came of it").unwrap();
    numbers.split_once("The robots").unwrap().0.to_owned()
}

#[test]
fn with_a_row_for_each_update_the_same_is_told() {
    let (_folder, run, out) = done();
    let said = publish(&run, &out, &[]).ends(DONE);
    said.prints(&["out: a row is a mean over 1 update; 4 cells: 4 done"]);
    for (name, bytes) in results(&out) {
        if name.ends_with("metrics.csv") || name.ends_with("policy.safetensors") {
            assert!(results(&run)[&name] == bytes, "{name}");
        }
    }
    for command in [&["status"][..], &["summary"], &["plot"], &["findings"]] {
        assert_eq!(told(command, &out), told(command, &run), "{command:?}");
    }
    assert_same(&tree(&out.join("plots")), &tree(&run.join("plots")));
    assert_eq!(numbers(&out), numbers(&run));
    itarl(&["status", text(&out)]).prints(&["published, to be read: it has no checkpoints"]);
}

#[test]
fn rows_are_means_and_readers_know_of_how_many() {
    let (_folder, run, out) = done();
    publish(&run, &out, &["--every", "5"]).ends(DONE).prints(&["a mean over 5 updates"]);
    for cell in ["xi=0.75/seed=1", "xi=1/seed=2"] {
        let [of_run, of_out] = [&run, &out].map(|folder| folder.join("cells").join(cell));
        assert_eq!(column(&of_out, "update"), [5.0, 10.0, 15.0, 20.0, 25.0, 30.0]);
        for name in ["R", "R_Loc", "R_MI_nats", "clipped_readings", "gradient_norm", "task"] {
            let means = column(&of_run, name);
            let means: Vec<_> = means.chunks(5).map(|it| it.iter().sum::<f64>() / 5.0).collect();
            // Seven digits of them.
            for (found, mean) in column(&of_out, name).into_iter().zip(means) {
                assert!((found - mean).abs() <= 5.1e-7 * mean.abs(), "{name}: {found}, not {mean}");
            }
        }
    }
    // A tenth is 3 updates of the run, and in whole rows 5.
    let windows = ["summary", "--early", "1-5", "--late", "26-30"];
    assert_eq!(told(&["summary"], &out), told(&windows, &run));
    assert_eq!(told(&windows, &out), told(&windows, &run));
    itarl(&["summary", text(&out), "--early", "1-7"]).ends(FAILED).complains(&[
        "--early must have whole rows, which are means over 5 updates in this published run, as in 1-10, \
         got 1-7",
    ]);
    itarl(&["plot", text(&out)]).ends(DONE);
    itarl(&["plot", text(&run)]).ends(DONE);
    let table =
        |folder: &Path, name: &str| fs::read_to_string(folder.join("plots").join(name)).unwrap();
    // Of single updates, whatever a row is.
    assert_eq!(table(&out, "correlation.csv"), table(&run, "correlation.csv"));
    let line = |text: &str, i: usize| -> Vec<String> {
        text.lines().nth(i).unwrap().split(',').map(str::to_owned).collect()
    };
    let settings = line(&table(&out, "settings.csv"), 1);
    assert_eq!(settings[..4], ["xi=0.75", "2", "0", "5"]);
    let last = |seed: u64| {
        let cell = run.join(format!("cells/xi=0.75/seed={seed}"));
        column(&cell, "R_Loc")[25..].iter().sum::<f64>() / 5.0
    };
    let maximum = settings[4].parse::<f64>().unwrap();
    assert!((maximum / last(1).max(last(2)) - 1.0).abs() < 1e-6, "{maximum}");
    let curves = table(&out, "learning-curves.svg");
    assert!(curves.contains("a point is its mean over 5 updates"), "{curves}");
    itarl(&["report", text(&out)]).ends(DONE);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("with curves as means over 5 updates, and without checkpoints"));
}

/// A run of 30 updates with rows of 8: the last 6 don't fill one, and are no row; that they were done
/// is said.
#[test]
fn updates_that_fill_no_row_are_counted() {
    let (_folder, run, out) = done();
    publish(&run, &out, &["--every", "8"]).ends(DONE);
    assert_eq!(column(&out.join("cells/xi=1/seed=1"), "update"), [8.0, 16.0, 24.0]);
    itarl(&["status", text(&out)]).ends(DONE).prints(&["30/30", "4 cells: 4 done"]);
    itarl(&["plot", text(&out)]).ends(DONE);
    publish(&run, &out.with_extension("2"), &["--every", "31"]).ends(FAILED).complains(&[
        "run: no cell has the 31 updates that a row is to be the mean of: the longest has 30",
    ]);
    assert!(!out.with_extension("2").exists());
}

#[test]
fn robots_are_seen_and_policies_go_on_walking() {
    let (folder, run, out) = done();
    publish(&run, &out, &["--every", "3"]).ends(DONE);
    // Of two cells of a setting both are recorded: one is the best, the other the median.
    let recordings = tree(&out.join("cells"));
    let recordings = recordings.keys().filter(|name| name.ends_with("replay.safetensors"));
    assert_eq!(recordings.count(), 4);
    let cell = |of: &Path| of.join("cells/xi=1/seed=1");
    let page = folder.path().join("page.html");
    itarl(&["replay", text(&cell(&out)), "--html", text(&page)]).ends(DONE);
    let walk = |of: &Path| itarl(&["rollout", text(&cell(of)), "--steps", "9"]).ends(DONE).out;
    assert_eq!(walk(&out), walk(&run));

    fs::remove_file(cell(&out).join("replay.safetensors")).unwrap();
    itarl(&["replay", text(&cell(&out)), "--html", text(&page)]).ends(FAILED).complains(&[
        "replay.safetensors: published are those of each setting's best and median cell; --policy \
         learned shows what another one does",
    ]);
    itarl(&["replay", text(&cell(&out)), "--policy", "learned", "--html", text(&page)]).ends(DONE);
}

#[test]
fn only_the_best_and_the_median_are_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let [run, out] = ["run", "out"].map(|name| folder.path().join(name));
    train(&run, &["--set", "sweep.seeds=5", "--set", "learning.updates=12"]).ends(DONE);
    publish(&run, &out, &["--every", "4"]).ends(DONE);
    let recordings = tree(&out.join("cells"));
    let recordings = recordings.keys().filter(|name| name.ends_with("replay.safetensors"));
    assert_eq!(recordings.count(), 4);
    itarl(&["plot", text(&out)]).ends(DONE);
    itarl(&["report", text(&out)]).ends(DONE);

    let small = folder.path().join("small");
    publish(&run, &small, &["--every", "4", "--recordings", "8"]).ends(DONE);
    let sizes = |of: &Path| -> Vec<usize> {
        let files = tree(&of.join("cells")).into_iter();
        files
            .filter(|(name, _)| name.ends_with("replay.safetensors"))
            .map(|it| it.1.len())
            .collect()
    };
    let (all, ends) = (sizes(&out), sizes(&small));
    assert_eq!(ends.len(), 4);
    // A quarter of 8 kB each, to which a header comes that the longer ones have, too.
    assert!(all.iter().zip(&ends).all(|(all, end)| *end + 1000 < *all), "{all:?} {ends:?}");
    itarl(&["report", text(&small)]).ends(DONE);
}

#[test]
fn nothing_goes_on_from_it() {
    let (_folder, run, out) = done();
    publish(&run, &out, &[]).ends(DONE);
    let before = tree(&out);
    let train = ["train", CRAWLER, "--out", text(&out)];
    let ways: [&[&str]; 5] = [
        &train,
        &[&train[..], &["--set", "learning.rate=0.3"]].concat(),
        &["resume", text(&out)],
        &["resume", text(&out), "--updates", "40"],
        &["cell", CRAWLER, "--index", "0", "--out", text(&out)],
    ];
    for words in ways {
        let said = itarl(words).ends(FAILED);
        assert!(said.err.contains("out: a published run, to be read: "), "{said:?}");
        assert_eq!(said.err.trim_end().lines().count(), 1, "{said:?}");
    }
    let again = out.with_file_name("again");
    publish(&out, &again, &[])
        .ends(FAILED)
        .complains(&["out: published already: copy it, or publish the run that it was made of"]);
    assert!(!again.exists());
    assert_same(&tree(&out), &before);
}

#[test]
fn it_is_made_whole_the_same_each_time_and_in_no_ones_place() {
    let (folder, run, out) = done();
    let again = folder.path().join("below/again");
    fs::create_dir_all(&again).unwrap();
    for out in [&out, &again] {
        publish(&run, out, &["--every", "2"]).ends(DONE);
    }
    assert_same(&tree(&out), &tree(&again));
    fs::write(again.join("mine"), "").unwrap();
    let before = tree(&again);
    publish(&run, &again, &[]).ends(FAILED).complains(&["again: there's something here already"]);
    let file = folder.path().join("file");
    fs::write(&file, "mine").unwrap();
    publish(&run, &file, &[]).ends(FAILED).complains(&["file: there's something here already"]);
    publish(&run, &file.join("out"), &[]).ends(FAILED).complains(&["file: "]);
    publish(&folder.path().join("nowhere"), &folder.path().join("x"), &[])
        .ends(FAILED)
        .complains(&["there's nothing here"]);
    assert_same(&tree(&again), &before);
    let names = fs::read_dir(folder.path()).unwrap().map(|it| it.unwrap().file_name());
    let mut names: Vec<_> = names.collect();
    names.sort();
    assert_eq!(names, ["below", "file", "out", "run"]);
}

#[test]
fn an_unfinished_run_says_how_far_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let [run, out] = ["run", "out"].map(|name| folder.path().join(name));
    train(&run, &["--stop-after", "0"]).ends(STOPPED);
    publish(&run, &out, &[]).ends(FAILED).complains(&["run: no cell has an update yet"]);
    let cell = |index: &'static str| ["cell", CRAWLER, "--index", index, "--out", text(&run)];
    itarl(&cell("0")).ends(DONE);
    itarl(&[&cell("3")[..], &["--stop-after", "8"]].concat()).ends(STOPPED);
    let failed = run.join("cells/xi=1/seed=1");
    fs::write(failed.join("failed"), "body 'tibia' is at NaN\n").unwrap();
    let said = publish(&run, &out, &["--every", "3"]).ends(DONE);
    said.prints(&["4 cells: 1 done, 1 stopped, 1 waiting, 1 failed"]);
    itarl(&["status", text(&out)]).ends(FAILED).prints(&["30/30", "8/30", "0/30", "tibia"]);
    for command in ["summary", "plot", "findings", "report"] {
        itarl(&[command, text(&out)]).ends(DONE);
    }
}

#[test]
fn what_is_damaged_is_named_in_the_run_and_in_what_was_made_of_it() {
    let (_folder, run, out) = done();
    let harm = |of: &Path| {
        let path = of.join("cells/xi=1/seed=2/metrics.csv");
        let rows = fs::read_to_string(&path).unwrap();
        fs::write(path, rows.replacen("\n2,", "\n3,", 1)).unwrap();
    };
    publish(&run, &out, &[]).ends(DONE);
    harm(&out);
    let what =
        "seed=2/metrics.csv: damaged: it isn't what was published (manifest.json has its hash)";
    for reader in ["status", "summary", "plot", "report", "findings"] {
        let said = itarl(&[reader, text(&out)]).ends(FAILED);
        assert!(format!("{}{}", said.out, said.err).contains(what), "{reader}: {said:?}");
    }
    let cell = out.join("cells/xi=1/seed=2");
    itarl(&["rollout", text(&cell), "--steps", "3"]).ends(FAILED).complains(&[what]);
    fs::remove_file(cell.join("metrics.csv")).unwrap();
    itarl(&["summary", text(&out)])
        .ends(FAILED)
        .complains(&["seed=2/metrics.csv: damaged: missing, and manifest.json has its hash"]);

    harm(&run);
    let rest = out.with_file_name("rest");
    publish(&run, &rest, &[])
        .ends(FAILED)
        .complains(&["xi=1/seed=2: left out: ", "metrics.csv: damaged: its first"])
        .prints(&["4 cells: 3 done, 1 waiting"]);
    itarl(&["summary", text(&rest)]).ends(DONE);
}

#[test]
fn a_run_that_an_earlier_version_left_is_published() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let run = root().join("tests/folders/first");
    publish(&run, &out, &["--every", "2"]).ends(DONE).prints(&["2 cells: 2 stopped"]);
    let header = |of: &Path| {
        let rows = fs::read_to_string(of.join("cells/xi=1/seed=1/metrics.csv")).unwrap();
        rows.lines().next().unwrap().to_owned()
    };
    assert_eq!(header(&out), header(&run));
    // As that of the run itself would, which isn't at its end.
    itarl(&["status", text(&out)]).ends(STOPPED);
    for command in ["summary", "plot", "report", "findings"] {
        itarl(&[command, text(&out)]).ends(DONE);
    }
}

#[test]
fn findings_say_what_can_be_told() {
    let (_folder, run, _) = done();
    itarl(&["findings", text(&run)]).ends(DONE).prints(&[
        "| 0.75 |",
        "probability that a cell with xi = 0.75 ends higher than one with xi = 1: ",
        "1. xi = 0.75 gives the highest R_Loc, in maximum, mean and median: can't tell",
        "   mean minus that of xi = 1: ",
        "2. xi = 0.5 is good, too; it improves later, and is still rising at the end: can't tell \
         without cells of xi = 0.5",
        "5. R_Loc and R_MI are high together: Pearson's r 0.7888 over all updates: can't tell with 4 \
         instances",
        "No significant progress: ",
    ]);
}
