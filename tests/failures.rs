//! What fails is said, with its place and its reason, and takes nothing else along.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    thread,
};

use crate::common::*;
use tempfile::TempDir;

/// A run that stands at update 10 of 30, and one of its cells.
fn stopped() -> (TempDir, PathBuf, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &["--stop-after", "10"]).ends(STOPPED);
    let cell = run.join("cells/xi=1/seed=1");
    (folder, run, cell)
}

/// What a run leaves that nothing happened to.
fn through() -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &[]).ends(DONE);
    results(&run)
}

/// Its other three cells are done.
fn status_of_others(run: &Path) {
    itarl(&["status", text(run)]).prints(&["3 done"]);
}

/// As on a full disk (`ENOSPC` itself is tried beside the code that writes): a folder has the name
/// of the temporary file.
#[test]
fn a_file_that_cannot_be_written_costs_nothing_that_was_saved() {
    let through = through();
    for file in ["checkpoint", "policy.safetensors", "replay.safetensors"] {
        let (_folder, run, cell) = stopped();
        let saved = fs::read(cell.join("checkpoint")).unwrap();
        let in_the_way = cell.join(format!("{file}.tmp"));
        fs::create_dir(&in_the_way).unwrap();
        let place = format!("{}: removing what is in the way: ", in_the_way.display());
        let said = itarl(&["resume", text(&run)]).ends(FAILED).complains(&[&place]);
        said.prints(&["3 of 4 cells done, 1 failed"]);
        status_of_others(&run);
        if file == "checkpoint" {
            assert!(fs::read(cell.join(file)).unwrap() == saved, "the older one stays");
        }
        fs::remove_dir(&in_the_way).unwrap();
        itarl(&["resume", text(&run)]).ends(DONE);
        assert_same(&results(&run), &through);
    }
}

/// `ulimit -f`: the system's signal ends a process without a word, if it isn't caught.
#[test]
fn files_that_cannot_grow_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    // Stopped before it began anything: the folder is there, and no cell is.
    train(&run, &["--stop-after", "0"]).ends(STOPPED);
    let limited = |blocks: u32, file: &str, doing: &str| {
        let limit = format!("ulimit -f {blocks}; exec \"$0\" \"$@\"");
        let resume = command(&["resume", text(&run)]);
        let mut shell = std::process::Command::new("bash");
        shell.args(["-c", &limit]).arg(resume.get_program()).args(resume.get_args());
        let said = Said::of(shell.output().unwrap()).ends(FAILED);
        for cell in ["xi=0.75/seed=1", "xi=0.75/seed=2", "xi=1/seed=1", "xi=1/seed=2"] {
            let path = run.join("cells").join(cell).join(file);
            assert!(
                said.err.contains(&format!("{}: {doing}: File too large", path.display())),
                "{said:?}"
            );
        }
        said.prints(&["0 of 4 cells done, 4 failed"]);
    };
    limited(0, "metrics.csv", "appending");
    limited(2, "checkpoint", "writing");
    itarl(&["resume", text(&run)]).ends(DONE);
    assert_same(&results(&run), &through());
}

/// As root, who may write anywhere, a file in the place of a folder is what can't be written into.
#[test]
fn folders_that_cannot_be_made_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "not a run").unwrap();
    let inside = file.join("run");
    train(&inside, &[]).ends(FAILED).complains(&[text(&file), ": making the folder: "]);
    train(&file, &[])
        .ends(FAILED)
        .complains(&[text(&file), ": a file, and not the folder of a run"]);
    assert_eq!(fs::read_to_string(&file).unwrap(), "not a run");

    let run = folder.path().join("run");
    train(&run, &["--stop-after", "4"]).ends(STOPPED);
    let cell = run.join("cells/xi=1/seed=1");
    fs::remove_dir_all(&cell).unwrap();
    fs::write(&cell, "").unwrap();
    itarl(&["resume", text(&run)]).ends(FAILED).complains(&[text(&cell)]);
    status_of_others(&run);
    fs::remove_dir_all(run.join("cells")).unwrap();
    fs::write(run.join("cells"), "").unwrap();
    let place = run.join("cells");
    itarl(&["resume", text(&run)]).ends(FAILED).complains(&[text(&place)]);
    fs::remove_file(&place).unwrap();
    itarl(&["resume", text(&run)]).ends(DONE);
    assert_same(&results(&run), &through());
}

/// What may happen to a file's bytes.
type Harm = fn(Vec<u8>) -> Vec<u8>;

const HARMS: [(&str, Harm); 4] = [
    ("cut in half", |bytes| bytes[..bytes.len() / 2].to_vec()),
    ("empty", |_| Vec::new()),
    ("a bit flipped near the beginning", |bytes| flipped(bytes, 20)),
    ("a bit flipped near the end", |bytes| {
        let at = bytes.len() - 20;
        flipped(bytes, at)
    }),
];

fn flipped(mut bytes: Vec<u8>, at: usize) -> Vec<u8> {
    bytes[at] ^= 4;
    bytes
}

#[test]
fn damage_is_named_and_nothing_is_overwritten() {
    let (_folder, run, cell) = stopped();
    let saved = tree(&run);
    let names: Vec<_> = saved.keys().filter(|it| it.starts_with("cells/xi=1/seed=1/")).collect();
    assert_eq!(names.len(), 5, "{names:?}");
    for file in ["checkpoint", "metrics.csv", "policy.safetensors", "replay.safetensors"] {
        let path = cell.join(file);
        for (what, harm) in HARMS {
            fs::write(&path, harm(saved[&format!("cells/xi=1/seed=1/{file}")].clone())).unwrap();
            let before = tree(&cell);
            let place = format!("{}: damaged: ", path.display());
            let said = itarl(&["resume", text(&run)]);
            assert!(said.err.contains(&place), "{file} {what}: {said:?}");
            said.ends(FAILED).prints(&["3 of 4 cells done, 1 failed"]);
            assert_same(&tree(&cell), &before);
        }
        // Put back, it goes on.
        fs::write(&path, &saved[&format!("cells/xi=1/seed=1/{file}")]).unwrap();
    }
    itarl(&["resume", text(&run)]).ends(DONE);
    assert_same(&results(&run), &through());
}

/// Of a cell that is done only headers and lengths are looked at: a worker that finds thousands of them
/// has nothing to do. `status --check` reads them.
#[test]
fn what_is_done_is_not_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &[]).ends(DONE);
    for file in ["checkpoint", "policy.safetensors", "replay.safetensors"] {
        let path = run.join("cells/xi=1/seed=1").join(file);
        let whole = fs::read(&path).unwrap();
        fs::write(&path, flipped(whole.clone(), whole.len() - 20)).unwrap();
        let before = tree(&run);
        train(&run, &[]).ends(DONE).prints(&["4 of 4 cells done"]);
        itarl(&["resume", text(&run)]).ends(DONE).prints(&["4 of 4 cells done"]);
        assert_same(&tree(&run), &before);
        if file == "checkpoint" {
            itarl(&["status", text(&run), "--check"]).ends(FAILED).prints(&["checkpoint: damaged"]);
        }
        fs::write(&path, whole).unwrap();
    }
}

#[test]
fn a_damaged_policy_is_refused_by_a_rollout() {
    let (_folder, _run, cell) = stopped();
    let path = cell.join("policy.safetensors");
    let whole = fs::read(&path).unwrap();
    let roll = || itarl(&["rollout", text(&cell), "--steps", "5"]);
    roll().ends(DONE);
    for (_, harm) in HARMS {
        let bytes = harm(whole.clone());
        fs::write(&path, &bytes).unwrap();
        roll().ends(FAILED).complains(&[text(&path)]);
        assert!(fs::read(&path).unwrap() == bytes);
    }
    fs::remove_file(&path).unwrap();
    roll().ends(FAILED).complains(&[text(&path), "none before the first checkpoint"]);
    fs::write(&path, &whole).unwrap();
    roll().ends(DONE);
}

#[test]
fn damaged_settings_are_named() {
    let (_folder, run, _) = stopped();
    for file in ["experiment.toml", "manifest.json", "models/crawler.toml"] {
        let path = run.join(file);
        let whole = fs::read(&path).unwrap();
        for (what, harm) in HARMS {
            fs::write(&path, harm(whole.clone())).unwrap();
            let before = tree(&run);
            let said = itarl(&["resume", text(&run)]);
            // Half of the settings are damaged, or other settings than the manifest's.
            assert!(said.err.contains(text(&path)), "{file} {what}: {said:?}");
            said.ends(FAILED);
            assert_same(&tree(&run), &before);
        }
        fs::write(&path, whole).unwrap();
    }
    itarl(&["resume", text(&run)]).ends(DONE);
}

/// An update that doesn't end while a test runs.
const ENDLESS: [&str; 2] = ["--set", "learning.steps_per_update=100000000"];

#[test]
fn a_cell_belongs_to_one_process_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let words = ["cell", CRAWLER, "--index", "2", "--out", text(&run)];
    let words = [&words[..], &ENDLESS].concat();
    let mut first = start(&words);
    let cell = run.join("cells/xi=1/seed=1");
    wait_until(|| cell.join("metrics.csv").exists());
    let said = itarl(&words).ends(STOPPED).prints(&["0 of 1 cells done, 1 elsewhere"]);
    said.complains(&["xi=1/seed=1: elsewhere"]);
    itarl(&["status", text(&run)]).ends(STOPPED).prints(&["1 running", "3 waiting"]);
    first.kill().unwrap();
    first.wait().unwrap();
    // The lock ended with the process.
    itarl(&["status", text(&run)]).ends(STOPPED).prints(&["4 waiting"]);
}

/// A run that isn't begun, and the lock of its first cell, held as by another process.
fn held() -> (TempDir, PathBuf, PathBuf, File) {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &["--stop-after", "0"]).ends(STOPPED);
    let first = run.join("cells/xi=0.75/seed=1");
    let lock = File::create(first.join("lock")).unwrap();
    lock.lock().unwrap();
    (folder, run, first, lock)
}

#[test]
fn a_cell_that_is_elsewhere_is_left_and_the_others_are_done() {
    let (_folder, run, first, lock) = held();
    let before = tree(&first);
    let said = itarl(&["resume", text(&run)]).ends(STOPPED);
    said.prints(&["3 of 4 cells done, 1 elsewhere"]);
    assert_same(&tree(&first), &before);
    itarl(&["status", text(&run)]).ends(STOPPED).prints(&["3 done, 1 running"]);
    drop(lock);
    itarl(&["resume", text(&run)]).ends(DONE).prints(&["4 of 4 cells done"]);
    assert_same(&results(&run), &through());
}

/// Left by the other process, as it was or done, while the others are at work.
#[test]
fn a_cell_that_was_elsewhere_is_looked_at_again() {
    let through = through();
    for done_by_the_other in [false, true] {
        let (_folder, run, first, lock) = held();
        let words = ["resume", text(&run), "--threads", "1", "--lanes", "1"];
        let child = start(&words);
        wait_until(|| {
            let next = fs::read_to_string(run.join("cells/xi=0.75/seed=2/metrics.csv"));
            next.is_ok_and(|it| it.lines().count() > 1)
        });
        if done_by_the_other {
            for (name, bytes) in &through {
                if let Some(name) = name.strip_prefix("xi=0.75/seed=1/") {
                    fs::write(first.join(name), bytes).unwrap();
                }
            }
        }
        drop(lock);
        let said = end(child).ends(DONE).prints(&["4 of 4 cells done"]);
        said.complains(&["xi=0.75/seed=1: elsewhere", "xi=0.75/seed=1: done"]);
        assert_same(&results(&run), &through);
    }
}

/// Runs it with a limit on open files, as `ulimit` sets it.
fn with_files(limit: &str, words: &[&str]) -> Said {
    let shell = format!("ulimit {limit}; exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &shell, env!("CARGO_BIN_EXE_itarl")]).args(words).current_dir(root());
    Said::of(command.stdin(Stdio::null()).output().unwrap())
}

/// Forty cells, wanted all at once.
const MANY: [&str; 8] =
    ["--set", "sweep.seeds=20", "--set", "learning.updates=3", "--threads", "3", "--lanes", "16"];

#[test]
fn few_open_files_mean_fewer_cells_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let through = folder.path().join("through");
    train(&through, &MANY).ends(DONE);
    // Hard limits; then a soft one, which is raised.
    for (n, limit) in ["-n 64", "-n 20", "-n 12", "-Sn 12"].into_iter().enumerate() {
        let run = folder.path().join(format!("run {n}"));
        let said = with_files(limit, &train_words(&run, &MANY)).ends(DONE);
        let said = said.prints(&["40 of 40 cells done\n"]);
        assert!(!said.err.contains("Too many open files"), "{limit}: {said:?}");
        itarl(&["status", text(&run)]).ends(DONE).prints(&["40 cells: 40 done"]);
        assert_same(&results(&run), &results(&through));
    }
}

/// With fewer than a single cell takes, to begin it or to save it, none is broken: they're gone on
/// with later.
#[test]
fn too_few_open_files_break_no_cell() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &["--stop-after", "4"]).ends(STOPPED);
    let saved = fs::read(run.join("cells/xi=1/seed=1/checkpoint")).unwrap();
    for limit in ["-n 6", "-n 7"] {
        let said = with_files(limit, &["resume", text(&run)]).ends(STOPPED);
        said.complains(&["Too many open files", "ulimit -n"])
            .prints(&["0 of 4 cells done, 4 to go on"]);
        assert!(fs::read(run.join("cells/xi=1/seed=1/checkpoint")).unwrap() == saved);
        itarl(&["status", text(&run)]).ends(STOPPED).prints(&["4 cells: 4 stopped"]);
    }
    itarl(&["resume", text(&run)]).ends(DONE);
    assert_same(&results(&run), &through());
}

#[test]
fn processes_that_share_a_folder_make_it_once() {
    let folder = tempfile::tempdir().unwrap();
    for attempt in 0..5 {
        let run = folder.path().join(format!("run {attempt}"));
        let out = text(&run);
        thread::scope(|scope| {
            for index in ["0", "1", "2", "3"] {
                scope.spawn(move || {
                    itarl(&["cell", CRAWLER, "--index", index, "--out", out]).ends(DONE)
                });
            }
        });
        itarl(&["status", out]).ends(DONE).prints(&["4 cells: 4 done"]);
    }
    let names: Vec<_> =
        fs::read_dir(folder.path()).unwrap().map(|it| it.unwrap().file_name()).collect();
    assert_eq!(names.len(), 5, "{names:?}");
}

#[test]
fn another_experiment_does_not_go_into_the_folder_of_a_run() {
    let (_folder, run, _) = stopped();
    let before = tree(&run);
    train(&run, &["--set", "learning.rate=3", "--set", "policy.samples=9"]).ends(FAILED).complains(
        &[
            &format!("{}: this run was made differently:", run.display()),
            "  learning.rate: 1.0 there, 3.0 here",
            "  policy.samples: 8 there, 9 here",
        ],
    );
    train(&run, &["--set", "sweep.seeds=1"]).ends(FAILED).complains(&["seeds"]);
    let shorter = "learning.updates: 30 there, 12 here: a run can be extended, not cut short";
    train(&run, &["--set", "learning.updates=12"]).ends(FAILED).complains(&[shorter]);
    let words = ["resume", text(&run), "--updates", "29"];
    itarl(&words).ends(FAILED).complains(&["30 there, 29 here"]);
    assert_same(&tree(&run), &before);
    // The same one goes on.
    train(&run, &[]).ends(DONE);
    assert_same(&results(&run), &through());
}

#[test]
fn there_may_be_nothing_to_resume() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    itarl(&["resume", text(&run)]).ends(FAILED).complains(&[text(&run), "there's nothing here"]);
    itarl(&["status", text(&run)]).ends(FAILED).complains(&[text(&run), "there's nothing here"]);
    let no_run = root().join("models");
    itarl(&["resume", text(&no_run)]).ends(FAILED).complains(&["it has no manifest.json"]);

    train(&run, &[]).ends(DONE);
    let before = tree(&run);
    itarl(&["resume", text(&run)]).ends(DONE).prints(&["4 of 4 cells done"]);
    assert_same(&tree(&run), &before);
}

#[test]
fn a_robot_that_blows_up_leaves_the_others_running() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let said = itarl(&["train", "tests/experiments/torn.toml", "--out", text(&run)]).ends(FAILED);
    let said = said.prints(&["2 of 4 cells done, 2 failed"]);
    let reason =
        said.err.lines().find(|line| line.contains("model=torn/seed=1: failed: ")).unwrap();
    for part in ["control step ", "(update ", "blew up: (", "body 'forearm' of joint 'elbow'"] {
        assert!(reason.contains(part), "{reason}");
    }
    let said = itarl(&["status", text(&run)]).ends(FAILED);
    let row = |index: &str| said.out.lines().find(|line| line.starts_with(index)).unwrap();
    assert!(row("|    0 ").contains("failed") && row("|    1 ").contains("failed"), "{said:?}");
    assert!(row("|    2 ").contains("done") && row("|    3 ").contains("done"), "{said:?}");
    assert!(said.out.contains("body 'forearm' of joint 'elbow'"), "{said:?}");

    // It stays so, and as it was.
    let before = tree(&run);
    itarl(&["resume", text(&run)]).ends(FAILED).complains(&["'forearm'"]);
    assert_same(&tree(&run), &before);
}

#[test]
fn parameters_that_blow_up_end_the_cell() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let words = ["--set", "learning.rate=1e80"];
    let said = train(&run, &words).ends(FAILED).prints(&["0 of 4 cells done, 4 failed"]);
    said.complains(&["failed: update 1: ", "parameter 0, V[0,0] must be in "]);
    itarl(&["status", text(&run)]).ends(FAILED).prints(&["4 cells: 4 failed"]);
}
