//! `itarl export`: event files that have the numbers of `metrics.csv`, of runs of all kinds.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use crate::common::*;

const FILE: &str = "events.out.tfevents.itarl";

fn export(runs: &[&Path], out: &Path) -> Said {
    let runs: Vec<_> = runs.iter().map(|it| text(it)).collect();
    itarl(&[&["export"], &runs[..], &["--tensorboard", text(out)]].concat())
}

/// The event files below a folder, by their folder.
fn event_files(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let all = tree(out).into_iter();
    all.map(|(path, bytes)| {
        let path = path.to_string();
        (path.strip_suffix(FILE).unwrap().trim_end_matches('/').to_owned(), bytes)
    })
    .collect()
}

/// The records in a file: their bytes without the frames.
fn records(mut bytes: &[u8]) -> Vec<&[u8]> {
    let mut all = Vec::new();
    while let Some((length, rest)) = bytes.split_first_chunk::<8>() {
        let length = u64::from_le_bytes(*length) as usize;
        all.push(&rest[4..4 + length]);
        bytes = &rest[8 + length..];
    }
    all
}

/// A tag's value in an event: what follows its name is field 2, a float.
fn value(event: &[u8], tag: &str) -> f32 {
    let place = event.windows(tag.len()).position(|it| it == tag.as_bytes()).unwrap();
    let rest = &event[place + tag.len()..];
    assert_eq!(rest[0], 2 << 3 | 5);
    f32::from_le_bytes(rest[1..5].try_into().unwrap())
}

const CELLS: [&str; 4] = ["xi=0.75/seed=1", "xi=0.75/seed=2", "xi=1/seed=1", "xi=1/seed=2"];

#[test]
fn a_cell_is_a_file_with_its_rows_while_it_runs_and_published() {
    let folder = tempfile::tempdir().unwrap();
    let [run, out, published, small] =
        ["run", "out", "published", "small"].map(|name| folder.path().join(name));
    train(&run, &["--stop-after", "12"]).ends(STOPPED);
    export(&[&run], &out).ends(DONE).prints(&["out: 4 cells; to see them: tensorboard --logdir"]);
    let before = event_files(&out);
    assert_eq!(before.keys().map(String::as_str).collect::<Vec<_>>(), CELLS);

    itarl(&["resume", text(&run)]).ends(DONE);
    export(&[&run], &out).ends(DONE);
    let after = event_files(&out);
    for cell in CELLS {
        assert!(after[cell].starts_with(&before[cell]) && after[cell] != before[cell]);
        let events = records(&after[cell]);
        assert_eq!(events.len(), 31, "a head and 30 updates");
        for (section, name) in
            [("robot", "R_Loc"), ("reward", "R"), ("learning", "gradient_norm"), ("robot", "task")]
        {
            let told: Vec<_> = column(&run.join("cells").join(cell), name);
            let found = events[1..].iter().map(|it| value(it, &format!("{section}/{name}")));
            assert_eq!(
                found.collect::<Vec<_>>(),
                told.iter().map(|it| *it as f32).collect::<Vec<_>>()
            );
        }
    }

    itarl(&["publish", text(&run), "--out", text(&published), "--every", "5"]).ends(DONE);
    export(&[&published], &small).ends(DONE);
    for (cell, bytes) in event_files(&small) {
        let told = column(&published.join("cells").join(cell), "R");
        let found: Vec<_> = records(&bytes)[1..].iter().map(|it| value(it, "reward/R")).collect();
        assert_eq!(found, told.iter().map(|it| *it as f32).collect::<Vec<_>>());
    }
    // Both side by side, called by what tells them apart.
    let both = folder.path().join("both");
    export(&[&run, &published], &both).ends(DONE).prints(&["both: 8 cells"]);
    assert!(event_files(&both).contains_key("published,xi=1/seed=2"));
}

#[test]
fn what_it_did_not_write_stays() {
    let folder = tempfile::tempdir().unwrap();
    let [run, other, out] = ["run", "other", "out"].map(|name| folder.path().join(name));
    train(&run, &["--stop-after", "2"]).ends(STOPPED);
    train(&other, &["--stop-after", "2", "--set", "learning.rate=0.5"]).ends(STOPPED);
    export(&[&run], &out).ends(DONE);
    let path: PathBuf = out.join("xi=1/seed=2").join(FILE);
    let ours = fs::read(&path).unwrap();
    let complaint =
        "seed=2/events.out.tfevents.itarl: it wasn't made of this cell, and is left as it is";
    for wrong in [b"".to_vec(), b"mine".to_vec(), ours[..30].to_vec()] {
        fs::write(&path, &wrong).unwrap();
        let before = tree(&out);
        export(&[&run], &out).ends(FAILED).complains(&[complaint]);
        assert_same(&tree(&out), &before);
    }
    // Nor those of another run's cells.
    fs::write(&path, &ours).unwrap();
    let before = tree(&out);
    export(&[&other], &out).ends(FAILED).complains(&["it wasn't made of this cell"]);
    assert_same(&tree(&out), &before);
}

#[test]
fn what_cannot_be_exported_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let [run, out] = ["run", "out"].map(|name| folder.path().join(name));
    train(&run, &["--stop-after", "2"]).ends(STOPPED);
    fs::write(run.join("cells/xi=0.75/seed=1/checkpoint"), "?").unwrap();
    fs::remove_dir_all(run.join("cells/xi=1/seed=1")).unwrap();
    export(&[&run], &out)
        .ends(FAILED)
        .complains(&["xi=0.75/seed=1: left out: ", "checkpoint: damaged"])
        .prints(&["out: 2 of 4 cells"]);
    assert_eq!(event_files(&out).len(), 2);
    fs::remove_dir_all(run.join("cells")).unwrap();
    export(&[&run], &out).ends(FAILED).complains(&["run: no cell has an update that can be read"]);
    itarl(&["export", text(&run)]).ends(USAGE).complains(&["--tensorboard <FOLDER>"]);
    export(&[folder.path()], &out).ends(FAILED);
}
