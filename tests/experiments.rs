//! An experiment's way through the program: from its file to the run folder, and back from there.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use crate::common::{
    CRAWLER, DONE, FAILED, STOPPED, USAGE, assert_same, itarl, root, text, train, tree,
};
use tempfile::TempDir;

fn list(file: &Path) -> String {
    itarl(&["train", text(file), "--list"]).ends(DONE).out
}

/// The cells of a run as `--list` shows those of its file.
fn cells(run: &Path) -> String {
    let manifest = fs::read(run.join("manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_slice(&manifest).unwrap();
    let cells = manifest["cells"].as_array().unwrap().iter();
    let line = |cell: &serde_json::Value| {
        let setting = cell["setting"].as_str().unwrap();
        format!("{}\t{setting}/seed={}\n", cell["index"], cell["seed"])
    };
    cells.map(line).collect()
}

/// Begun and not trained; its file is then changed as little as that takes.
fn begun(more: &[&str]) -> (TempDir, PathBuf, BTreeMap<String, Vec<u8>>) {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &[&["--stop-after", "0"], more].concat()).ends(STOPPED);
    let before = tree(&run);
    (folder, run, before)
}

#[test]
fn every_experiment_is_begun_resumed_and_written_again() {
    let folder = tempfile::tempdir().unwrap();
    let again = folder.path().join("again.toml");
    let files = fs::read_dir(root().join("experiments")).unwrap();
    let files = files.map(|entry| entry.unwrap().path());
    let files: Vec<_> =
        files.filter(|path| path.extension().is_some_and(|it| it == "toml")).collect();
    assert!(files.len() >= 10, "{files:?}");
    for file in files {
        let listed = list(&file);
        // From another folder, too: the model is found.
        let printed = itarl(&["config", text(&file)]).ends(DONE).out;
        fs::write(&again, &printed).unwrap();
        assert_eq!(list(&again), listed, "{}", file.display());
        assert_eq!(itarl(&["config", text(&again)]).ends(DONE).out, printed);

        // Two seeds are as good as thirty.
        let run = folder.path().join(file.file_stem().unwrap());
        let words = ["train", text(&file), "--set", "sweep.seeds=2", "--out", text(&run)];
        itarl(&[&words[..], &["--stop-after", "0"]].concat()).ends(STOPPED);
        itarl(&["resume", text(&run), "--stop-after", "0"]).ends(STOPPED);
        let names = |list: &str, seeds: &str| {
            let names = list.lines().map(|line| line.split_once('\t').unwrap().1);
            names.filter(|name| name.ends_with(seeds)).map(str::to_owned).collect::<Vec<_>>()
        };
        for seed in ["/seed=1", "/seed=2"] {
            assert_eq!(names(&cells(&run), seed), names(&listed, seed), "{}", file.display());
        }
        itarl(&["status", text(&run)]).ends(STOPPED);
        fs::remove_dir_all(&run).unwrap();
    }
}

/// Whatever is changed, and by whichever way: what isn't accepted changes no byte of the run.
#[test]
fn a_refused_change_leaves_a_run_as_it_is() {
    let (_folder, run, before) = begun(&[]);
    let config = itarl(&["config", CRAWLER]).ends(DONE).out;
    let settings: toml::Table = config.parse().unwrap();
    let mut keys = Vec::new();
    collect("", &settings, &mut keys);
    assert!(keys.len() > 30, "{keys:?}");
    for (key, value) in keys {
        // Another value that the file could have, or just one that isn't right: both are refused.
        let other = match &value {
            toml::Value::Float(number) => (number / 2.0).to_string(),
            toml::Value::Integer(number) => (number + 1).to_string(),
            toml::Value::Boolean(flag) => (!flag).to_string(),
            _ => "'other'".into(),
        };
        for value in [other.as_str(), "-1", "[]", "{ x = 1 }"] {
            // More updates or more cells.
            if ["learning.updates", "sweep.seeds"].contains(&key.as_str()) && value == other {
                continue;
            }
            let set = format!("{key}={value}");
            let said = train(&run, &["--set", &set]).ends(FAILED);
            assert!(!said.err.is_empty() && said.out.is_empty(), "{set}: {said:?}");
        }
        assert_same(&tree(&run), &before);
    }
    itarl(&["status", text(&run)]).ends(STOPPED);
}

/// Keys that hold no table, the sweep's but for its seeds left out.
fn collect(path: &str, table: &toml::Table, keys: &mut Vec<(String, toml::Value)>) {
    for (name, value) in table {
        let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        match value {
            toml::Value::Table(inner) => collect(&path, inner, keys),
            _ if path.starts_with("sweep.") && path != "sweep.seeds" => {}
            _ => keys.push((path, value.clone())),
        }
    }
}

#[test]
fn updates_out_of_range_are_refused_and_the_run_goes_on() {
    let (_folder, run, before) = begun(&[]);
    let range = "learning: updates must be a whole number from 1 to 1000000000, got ";
    let large = u64::MAX.to_string();
    for (updates, message) in [
        ("0", range),
        ("1000000001", range),
        ("2000000000", range),
        (large.as_str(), "a number that 64 bits can hold expected"),
        ("29", "learning.updates: 30 there, 29 here: a run can be extended, not cut short"),
    ] {
        itarl(&["resume", text(&run), "--updates", updates]).ends(FAILED).complains(&[message]);
        let set = format!("learning.updates={updates}");
        train(&run, &["--set", &set]).ends(FAILED).complains(&[message]);
    }
    itarl(&["resume", text(&run), "--updates", "x"]).ends(USAGE);
    assert_same(&tree(&run), &before);
    itarl(&["status", text(&run)]).ends(STOPPED);
    // The largest is all right, and so is one that it has.
    let words = ["resume", text(&run), "--stop-after", "0", "--updates"];
    itarl(&[&words[..], &["30"]].concat()).ends(STOPPED);
    assert_same(&tree(&run), &before);
    itarl(&[&words[..], &["1000000000"]].concat()).ends(STOPPED);
    itarl(&["status", text(&run)]).ends(STOPPED).prints(&["0/1000000000"]);
    let mut after = tree(&run);
    after.remove("lock");
    assert_ne!(after["experiment.toml"], before["experiment.toml"]);
    after.insert("experiment.toml".into(), before["experiment.toml"].clone());
    assert_same(&after, &before);
}

#[test]
fn a_run_that_sweeps_its_updates_is_not_extended() {
    for sweep in [
        "sweep.'learning.updates'=[2, 3]",
        "sweep.learning=[{ updates = 2 }, { label = 'more', updates = 3 }]",
        "sweep.learning=[{ updates = 2 }, { discount = 0.5 }]",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let (file, run) = (folder.path().join("x.toml"), folder.path().join("run"));
        let settings = fs::read_to_string(root().join(CRAWLER)).unwrap();
        let settings = settings.replace("../models", text(&root().join("tests/models")));
        fs::write(
            &file,
            settings.replace("updates = 30", "")
                + "\n"
                + &sweep["sweep.".len()..].replacen('=', " = ", 1),
        )
        .unwrap();
        itarl(&["train", text(&file), "--out", text(&run), "--stop-after", "0"]).ends(STOPPED);
        let before = tree(&run);
        for updates in ["1", "7", "2000000000"] {
            itarl(&["resume", text(&run), "--updates", updates]).ends(FAILED).complains(&[
                &format!("--updates {updates}: learning.updates is swept by "),
                "experiment.toml:",
            ]);
            let set = format!("learning.updates={updates}");
            let words = ["train", text(&file), "--out", text(&run), "--set", &set];
            itarl(&words).ends(FAILED).complains(&["learning.updates is swept by"]);
        }
        assert_same(&tree(&run), &before);
        itarl(&["resume", text(&run), "--stop-after", "0"]).ends(STOPPED);
    }
}

#[test]
fn labels_name_folders_and_rows() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let sweep = "sweep.learning=[{ label = 'paper' }, { label = 'adam', optimiser = 'adam' }]";
    let sets = ["--set", sweep, "--set", "sweep.seeds=1", "--stop-after", "1"];
    train(&run, &sets).ends(STOPPED);
    for setting in ["xi=0.75,learning=paper", "xi=1,learning=adam"] {
        assert!(run.join("cells").join(setting).join("seed=1").is_dir(), "{setting}");
        itarl(&["status", text(&run)]).ends(STOPPED).prints(&[setting]);
    }
    itarl(&["plot", text(&run), "learning-curves"]).ends(DONE);
    let figure = fs::read_to_string(run.join("plots/learning-curves.svg")).unwrap();
    assert!(figure.contains("learning = adam"), "{figure}");
}

#[test]
fn a_warning_is_told_once_and_no_error() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let set = ["--set", "codec={ sensor_bits = 2 }"];
    let warning = "--set codec={ sensor_bits = 2 }: warning: codec: with 2 sensor_bits and 1 \
                   actuator_bits the servos' targets lie exactly on edges of the sensors' bins";
    for words in [
        &["config", CRAWLER][..],
        &["train", CRAWLER, "--list"],
        &["train", CRAWLER, "--stop-after", "0", "--out", text(&run)],
        &["cell", CRAWLER, "--index", "0", "--stop-after", "0", "--out", text(&run)],
    ] {
        let said = itarl(&[words, &set[..]].concat());
        assert!([Some(DONE), Some(STOPPED)].contains(&said.code), "{said:?}");
        assert_eq!(said.err.matches(warning).count(), 1, "{said:?}");
        assert!(!said.out.contains("warning"), "{said:?}");
    }
    // It has been told when the run was begun.
    let said = itarl(&["resume", text(&run), "--stop-after", "0"]).ends(STOPPED);
    assert!(!said.err.contains("warning"), "{said:?}");
}

#[test]
fn a_listing_needs_its_models() {
    let nowhere = ["--set", "model='nowhere.toml'"];
    let words = [&["train", CRAWLER, "--list"], &nowhere[..]].concat();
    let said = itarl(&words).ends(FAILED).complains(&["nowhere.toml: can't be read: No such file"]);
    assert!(said.out.is_empty(), "{said:?}");
    let bad = "tests/models/bad/mass_zero.toml";
    let set = format!("model='{bad}'");
    let words = ["train", CRAWLER, "--list", "--set", &set];
    itarl(&words).ends(FAILED).complains(&["mass_zero.toml:", "mass_kg must be"]);
}

/// Where no robot is expected, one line says what it is; where one is, it's imported.
#[test]
fn a_robot_in_another_format_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = folder.path().join("arm.urdf");
    let links = "  <link name=\"a\">\n  </link>\n".repeat(80);
    fs::write(&urdf, format!("<?xml version=\"1.0\"?>\n<robot name=\"arm\">\n{links}</robot>\n"))
        .unwrap();
    let gait = folder.path().join("gait.toml");
    fs::copy(&urdf, &gait).unwrap();
    let set = format!("model='{}'", text(&urdf));
    let crawler = "tests/models/crawler.toml";
    for words in
        [&["train", text(&urdf), "--list"][..], &["rollout", crawler, "--policy", text(&gait)]]
    {
        let said = itarl(words).ends(FAILED);
        assert_eq!(said.err.lines().count(), 1, "{said:?}");
        said.complains(&[":1:1: a file in TOML expected, got XML, a robot in URDF"]);
    }
    for words in [&["model", "check", text(&urdf)][..], &["train", CRAWLER, "--set", &set]] {
        itarl(words).ends(FAILED).complains(&["arm.urdf:5:3: there is another link 'a'"]);
    }
}

/// Nothing to replay is no mistake where nothing was to be recorded.
#[test]
fn a_run_without_recordings_has_a_report() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &["--set", "record.steps=0", "--set", "learning.updates=4"]).ends(DONE);
    itarl(&["report", text(&run)]).ends(DONE);
    let page = fs::read_to_string(run.join("report.html")).unwrap();
    assert!(page.contains("No control steps were recorded"));
    itarl(&["plot", text(&run)]).ends(DONE);
    let cell = run.join("cells/xi=1/seed=2");
    let html = folder.path().join("x.html");
    itarl(&["replay", text(&cell), "--html", text(&html)])
        .ends(FAILED)
        .complains(&["no control steps were recorded (record.steps is 0"]);
}
