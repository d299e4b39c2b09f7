//! Whoever reads a run believes what a resume would go on from, names what else there is, and leaves it
//! out.

use std::{
    ffi::OsStr,
    fs::{self, OpenOptions},
    os::unix::{
        ffi::{OsStrExt, OsStringExt},
        fs::symlink,
    },
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use crate::common::*;
use runner::catalogue::Catalogue;
use runs::{Checkpoint, Header, Run};
use tempfile::TempDir;

/// Four cells of 30 updates, done; and one of them.
fn done() -> (TempDir, PathBuf, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &[]).ends(DONE);
    let cell = run.join("cells/xi=1/seed=2");
    (folder, run, cell)
}

/// What reads a run as a whole.
const READERS: [&[&str]; 5] =
    [&["status", "--check"], &["summary"], &["plot", "final"], &["findings"], &["report"]];

fn read(reader: &[&str], run: &Path) -> Said {
    itarl(&[&reader[..1], &[text(run)], &reader[1..]].concat())
}

/// A checkpoint with right checksums that says something else.
fn rewrite(cell: &Path, change: impl Fn(&mut Header)) {
    let path = cell.join("checkpoint");
    let mut checkpoint = Checkpoint::decode(&path, &fs::read(&path).unwrap()).unwrap();
    change(&mut checkpoint.header);
    checkpoint.write(&path).unwrap();
}

/// What may happen to a cell beside others, and what is then said of it.
type Harm = (&'static str, fn(&Path), &'static str);

const HARMS: [Harm; 10] = [
    (
        "a digit of R_Loc in a row",
        |cell| {
            let path = cell.join("metrics.csv");
            let rows = fs::read_to_string(&path).unwrap();
            let fifth = rows.lines().nth(5).unwrap();
            let mut values: Vec<_> = fifth.split(',').map(str::to_owned).collect();
            values[6] = values[6].replacen("0.", "8.", 1);
            fs::write(&path, rows.replace(fifth, &values.join(","))).unwrap();
        },
        "metrics.csv: damaged: its first ",
    ),
    (
        "rows cut off",
        |cell| {
            let path = cell.join("metrics.csv");
            let rows = fs::read_to_string(&path).unwrap();
            let kept: Vec<_> = rows.lines().take(20).collect();
            fs::write(&path, kept.join("\n") + "\n").unwrap();
        },
        "metrics.csv: damaged: ",
    ),
    (
        "no metrics",
        |cell| fs::remove_file(cell.join("metrics.csv")).unwrap(),
        "metrics.csv: damaged: missing, and the checkpoint goes on from it",
    ),
    (
        "no checkpoint",
        |cell| fs::remove_file(cell.join("checkpoint")).unwrap(),
        "checkpoint: damaged: missing, though policy.safetensors was made from one",
    ),
    (
        "a cell that is a link to its neighbour",
        |cell| {
            fs::remove_dir_all(cell).unwrap();
            symlink("seed=1", cell).unwrap();
        },
        "checkpoint: of another cell: ",
    ),
    (
        "a copy of a cell of another setting",
        |cell| {
            let other = cell.join("../../xi=0.75/seed=2");
            for file in ["checkpoint", "metrics.csv", "policy.safetensors", "replay.safetensors"] {
                fs::copy(other.join(file), cell.join(file)).unwrap();
            }
        },
        "checkpoint: of another cell: ",
    ),
    (
        "more updates than the experiment has",
        |cell| rewrite(cell, |header| header.updates = 6_735_281_601_315_911_789),
        "checkpoint: damaged: it has 6735281601315911789 updates, and the experiment ends at 30",
    ),
    (
        "control steps that aren't those of its updates",
        |cell| rewrite(cell, |header| header.control_steps = u64::MAX),
        "checkpoint: damaged: it has 30 updates and 18446744073709551615 control steps",
    ),
    (
        "a bit in the checkpoint's header",
        |cell| {
            let path = cell.join("checkpoint");
            let mut bytes = fs::read(&path).unwrap();
            bytes[25] ^= 4;
            fs::write(&path, bytes).unwrap();
        },
        "checkpoint: damaged: its header's checksum is wrong",
    ),
    (
        "the metrics of its neighbour",
        |cell| {
            fs::remove_file(cell.join("metrics.csv")).unwrap();
            symlink("../seed=1/metrics.csv", cell.join("metrics.csv")).unwrap();
        },
        "metrics.csv: damaged: ",
    ),
];

/// What is seen only by whoever reads all bytes, as `itarl status` does with `--check` alone, and a resume
/// where there's something left to do.
const HIDDEN: [&str; 2] = ["a digit of R_Loc in a row", "the metrics of its neighbour"];

#[test]
fn what_a_resume_refuses_is_named_and_left_out() {
    let (folder, run, _) = done();
    let report = |run: &Path| {
        let page = fs::read_to_string(run.join("report.html")).unwrap();
        let (_, settings) = page.split_once("id=\"table-settings\"").unwrap();
        settings.split_once("</table>").unwrap().0.to_owned()
    };
    for (i, (what, harm, reason)) in HARMS.iter().enumerate() {
        let harmed = folder.path().join(format!("harmed {i}"));
        let copied = Command::new("cp").arg("-r").args([&run, &harmed]).status().unwrap();
        assert!(copied.success());
        let cell = harmed.join("cells/xi=1/seed=2");
        harm(&cell);
        let before = tree(&cell);
        for reader in READERS {
            let said = read(reader, &harmed);
            assert_eq!(said.code, Some(FAILED), "{what}, {reader:?}: {said:?}");
            let all = format!("{}{}", said.out, said.err);
            assert!(all.contains("xi=1/seed=2: "), "{what}, {reader:?}: {said:?}");
            assert!(all.contains(reason), "{what}, {reader:?}: {said:?}");
            assert!(!all.contains("xi=1/seed=1: "), "{what}, {reader:?}: {said:?}");
        }
        if !HIDDEN.contains(what) {
            let said = read(&["status"], &harmed).ends(FAILED).prints(&[reason]);
            said.prints(&["4 cells: 3 done, 1 unreadable"]);
        }
        read(&["summary"], &harmed).prints(&["| xi=0.75 |     2 |", "| xi=1    |     1 |"]);
        let table = fs::read_to_string(harmed.join("plots/settings.csv")).unwrap();
        assert!(table.contains("\nxi=0.75,2,") && table.contains("\nxi=1,1,"), "{what}: {table}");
        assert!(report(&harmed).contains("xi=1"), "{what}");

        for words in [&["rollout", "--steps", "3"][..], &["replay", "--html", "/dev/null/page"]] {
            let said = read(words, &cell).ends(FAILED);
            assert!(said.err.contains(reason), "{what}, {words:?}: {said:?}");
        }
        let said = itarl(&["resume", text(&harmed)]);
        // The neighbour's are shorter.
        if *what == HIDDEN[0] {
            said.ends(DONE);
            let said = itarl(&["resume", text(&harmed), "--updates", "31"]).ends(FAILED);
            assert!(said.err.contains(reason), "{what}: {said:?}");
        } else {
            assert!(said.err.contains(reason), "{what}: {said:?}");
            said.ends(FAILED);
        }
        assert_same(&tree(&cell), &before);
    }
}

/// All that is done of a setting may be of another one.
#[test]
fn a_setting_that_is_a_link_to_another_counts_once() {
    let (_folder, run, _) = done();
    fs::remove_dir_all(run.join("cells/xi=1")).unwrap();
    symlink("xi=0.75", run.join("cells/xi=1")).unwrap();
    for reader in READERS {
        let said = read(reader, &run).ends(FAILED);
        let all = format!("{}{}", said.out, said.err);
        for seed in [1, 2] {
            let reason = format!("cells/xi=1/seed={seed}/checkpoint: of another cell");
            assert!(all.contains(&reason), "{reader:?}: {all}");
        }
    }
    read(&["status"], &run).prints(&["4 cells: 2 done, 2 unreadable"]);
}

/// But a link to a cell from elsewhere is followed, as is one in the way to the run.
#[test]
fn links_to_a_cell_are_followed() {
    let (folder, _, cell) = done();
    let [best, run] = ["best", "link"].map(|name| folder.path().join(name));
    symlink(&cell, &best).unwrap();
    symlink("run", &run).unwrap();
    let detour = cell.join("../seed=1/../seed=2");
    for cell in [best, run.join("cells/xi=1/seed=2"), detour] {
        itarl(&["rollout", text(&cell), "--steps", "3"]).ends(DONE);
        let page = folder.path().join("page.html");
        itarl(&["replay", text(&cell), "--html", text(&page)]).ends(DONE);
        assert!(fs::read_to_string(&page).unwrap().contains("xi=1, seed 2"));
    }
}

#[test]
fn a_manifest_of_other_cells_is_refused_by_all() {
    let (_folder, run, _) = done();
    let path = run.join("manifest.json");
    let whole = fs::read_to_string(&path).unwrap();
    let last = whole.rfind("\"seed\": 2").unwrap();
    let other_seed = format!("{}\"seed\": 7{}", &whole[..last], &whole[last + 9..]);
    let cells = whole.find("\"cells\"").unwrap();
    let renamed = whole[..cells].to_owned() + &whole[cells..].replace("xi=0.75", "xi=0.5");
    let fewer = {
        let mut manifest: serde_json::Value = serde_json::from_str(&whole).unwrap();
        manifest["cells"].as_array_mut().unwrap().pop();
        manifest.to_string()
    };
    let seeds = whole.replacen("    1,\n    2\n", "    1,\n    3\n", 1);
    let model = whole.replace("crawler.toml", "worm.toml");
    for (manifest, reason) in [
        (other_seed, "it lists cell xi=1/seed=7, and experiment.toml has no such cell"),
        (renamed, "it lists cell xi=0.5/seed=1, and experiment.toml has no such cell"),
        (fewer, "it doesn't list cell xi=1/seed=2, which experiment.toml has"),
        (seeds, "the seeds are [1, 3], and in experiment.toml [1, 2]"),
        (model, "it doesn't list "),
    ] {
        assert_ne!(manifest, whole);
        fs::write(&path, manifest).unwrap();
        let place = format!("{}: damaged: {reason}", path.display());
        for reader in READERS.iter().chain(&[&["resume"][..]]) {
            read(reader, &run).ends(FAILED).complains(&[&place]);
        }
        let cell = run.join("cells/xi=1/seed=1");
        itarl(&["rollout", text(&cell)]).ends(FAILED).complains(&[&place]);
        itarl(&["replay", text(&cell)]).ends(FAILED).complains(&[&place]);
    }
    assert!(!run.join("plots").exists() && !run.join("report.html").exists());
}

/// The header of a checkpoint is whole: only all of its bytes tell.
#[test]
fn a_cell_that_cannot_go_on_is_not_called_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &["--stop-after", "10"]).ends(STOPPED);
    let path = run.join("cells/xi=1/seed=2/checkpoint");
    let whole = fs::read(&path).unwrap();
    for place in [64, whole.len() / 2, whole.len() - 1] {
        let mut bytes = whole.clone();
        bytes[place] ^= 4;
        fs::write(&path, bytes).unwrap();
        read(&["status", "--check"], &run).ends(FAILED).prints(&[
            "4 cells: 3 stopped, 1 unreadable",
            "xi=1/seed=2: ",
            "checkpoint: damaged: its checksum is wrong",
        ]);
    }
    // And its length, which needs no reading.
    for bytes in [&whole[..whole.len() - 1], &[&whole[..], b"x"].concat()] {
        fs::write(&path, bytes).unwrap();
        let said = read(&["status"], &run).ends(FAILED);
        assert_eq!(said.out, read(&["status", "--check"], &run).out);
        said.prints(&["1 unreadable", "checkpoint: damaged: its checksum is wrong"]);
    }
}

/// A run may be extended while someone reads it, or trains it elsewhere.
#[test]
fn a_cell_that_was_extended_meanwhile_is_fine() {
    let (_folder, run, _) = done();
    let early = Catalogue::open(&run).unwrap();
    itarl(&["resume", text(&run), "--updates", "40"]).ends(DONE);
    for cell in early.cells() {
        early.check(cell).unwrap();
        assert_eq!(early.rows(cell).unwrap().len(), 40);
    }
    let late = Run::open(&run).unwrap();
    assert_ne!(late.experiment(), early.run().experiment());
}

/// A process is stopped, its folder renamed, another run begun in its place; then it goes on.
#[test]
fn a_forgotten_process_writes_nothing_into_another_run() {
    let folder = tempfile::tempdir().unwrap();
    let [run, renamed] = ["run", "renamed"].map(|name| folder.path().join(name));
    // With a checkpoint every few milliseconds, until it's stopped.
    let words = train_words(&run, &["--set", "learning.updates=1000000"]);
    let forgotten = start(&words);
    let cells = ["xi=0.75/seed=1", "xi=0.75/seed=2", "xi=1/seed=1", "xi=1/seed=2"];
    wait_until(|| cells.iter().all(|it| run.join("cells").join(it).join("checkpoint").exists()));
    signal(&forgotten, "STOP");
    fs::rename(&run, &renamed).unwrap();
    train(&run, &[]).ends(DONE);
    let before = tree(&run);
    signal(&forgotten, "CONT");
    let said = end(forgotten).ends(FAILED);
    said.complains(&[text(&run), "no longer the folder that this process works in"]);
    assert_same(&tree(&run), &before);
    // Nothing of it is lost.
    read(&["status"], &renamed).ends(STOPPED).prints(&["4 cells: 4 stopped"]);
}

/// Paths are bytes; text is what some files and messages need.
#[test]
fn a_folder_whose_name_is_no_text_is_as_good_as_another() {
    let (folder, run, _) = done();
    let name = std::ffi::OsString::from_vec(b"r\xfcn".to_vec());
    let odd = folder.path().join(name);
    fs::rename(&run, &odd).unwrap();
    let said = |words: &[&OsStr]| {
        let output = command(&[]).args(words).output().unwrap();
        assert_eq!(output.status.code(), Some(DONE), "{words:?}: {output:?}");
        // On a slow machine it may say how far it has come.
        let complaints = String::from_utf8_lossy(&output.stderr);
        assert!(!complaints.contains("left out"), "{words:?}: {complaints}");
    };
    let word = OsStr::new;
    for reader in ["status", "summary", "plot", "report", "resume"] {
        // Whoever resumes is told how it goes.
        match reader {
            "resume" => assert!(
                command(&["resume"]).arg(&odd).stderr(Stdio::null()).status().unwrap().success()
            ),
            _ => said(&[word(reader), odd.as_os_str()]),
        }
    }
    let cell = odd.join("cells/xi=1/seed=2");
    said(&[word("rollout"), cell.as_os_str(), word("--steps"), word("3")]);
    let page = folder.path().join(OsStr::from_bytes(b"p\xfc.html"));
    said(&[word("replay"), cell.as_os_str(), word("--html"), page.as_os_str()]);
    let report = fs::read_to_string(odd.join("report.html")).unwrap();
    assert!(report.contains("The robots"), "the replays are in it");
}

/// Whatever is printed, and by whichever command.
#[test]
fn a_full_standard_output_is_named() {
    let (_folder, run, cell) = done();
    let words: [&[&str]; 12] = [
        &["--help"],
        &["train", "--help"],
        &["--version"],
        &["completions", "bash"],
        &["status", text(&run)],
        &["summary", text(&run)],
        &["plot", text(&run), "final"],
        &["report", text(&run)],
        &["resume", text(&run)],
        &["rollout", text(&cell), "--steps", "3"],
        &["model", "check", "models/svenja.toml"],
        &["config", CRAWLER],
    ];
    for words in words {
        let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = command(words).stdout(full).output().unwrap();
        let said = Said::of(output).ends(FAILED);
        said.complains(&["standard output: writing: No space left on device"]);
    }
}

#[test]
fn a_run_takes_the_place_of_an_empty_folder_behind_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let [disk, link] = ["disk", "link"].map(|name| folder.path().join(name));
    fs::create_dir(&disk).unwrap();
    symlink("disk", &link).unwrap();
    train(&link, &[]).ends(DONE);
    assert!(link.is_symlink());
    read(&["status"], &disk).ends(DONE).prints(&["4 done"]);
    itarl(&["resume", text(&link)]).ends(DONE);

    let dangling = folder.path().join("dangling");
    symlink("nowhere", &dangling).unwrap();
    train(&dangling, &[]).ends(FAILED).complains(&["dangling: a link to nothing: make the folder"]);
}

/// Who prints a chain of errors prints each text once, so an error that tells its cause doesn't also
/// return it. (What is called `source` or marked `#[from]` is returned by `thiserror`.)
#[test]
fn no_error_tells_a_cause_that_it_returns() {
    let mut sources = Vec::new();
    let mut folders = vec![root().join("crates")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.extension() {
                _ if path.is_dir() => folders.push(path),
                Some(extension) if extension == "rs" => sources.push(path),
                _ => {}
            }
        }
    }
    let mut n_errors = 0;
    for path in sources {
        let text = fs::read_to_string(&path).unwrap();
        for after in text.split("#[error(").skip(1) {
            n_errors += 1;
            // The message and its variant.
            let (message, variant) = after.split_once(")]\n").unwrap();
            let variant = variant.split(",\n    //").next().unwrap().split("\n}").next().unwrap();
            let tells = |name: &str| message.contains(name);
            assert!(!tells("{source"), "{}: {message}", path.display());
            assert!(!(tells("{0") && variant.contains("#[from]")), "{}: {message}", path.display());
        }
    }
    assert!(n_errors > 30, "{n_errors}");
}
