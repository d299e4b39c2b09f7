//! Workers: processes on one run's folder, started and ended at any time, on as many machines as one
//! likes. Each cell is trained once, and the bytes are those of one process.
//!
//! `STARTS` is how often 64 of them start at the same moment, `CRASHES` how many kills must hit, `CELLS`
//! how many cells a large run has.

use std::{
    collections::BTreeMap,
    env,
    fs::{self, File, Permissions},
    io::{BufRead, BufReader},
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
    process::{Child, Command},
    thread,
    time::{Duration, Instant, SystemTime},
};

use crate::common::*;
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use runner::catalogue::Catalogue;
use runs::{CellFolder, Checkpoint, Header};

/// Sixteen small cells, in four groups.
const SIXTEEN: [&str; 8] =
    ["--set", "sweep.seeds=8", "--set", "learning.updates=6", "--threads", "1", "--lanes", "4"];

fn number(name: &str, default: u32) -> u32 {
    env::var(name).map_or(default, |n| n.parse().unwrap())
}

/// What one process makes of them, alone.
fn alone(words: &[&str]) -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, words).ends(DONE);
    results(&run)
}

#[test]
fn many_that_start_at_the_same_moment_make_one_run_and_no_cell_twice() {
    let expected = alone(&SIXTEEN);
    let folder = tempfile::tempdir().unwrap();
    for attempt in 0..number("STARTS", 1) {
        let run = folder.path().join(format!("run {attempt}"));
        let words = train_words(&run, &SIXTEEN);
        let workers: Vec<_> = (0..64).map(|_| start(&words)).collect();
        let said: Vec<_> = workers.into_iter().map(end).collect();
        for said in &said {
            assert!([Some(DONE), Some(STOPPED)].contains(&said.code), "{said:?}");
            assert!(!said.err.contains("panicked"), "{said:?}");
        }
        let trained = |cell: &str| {
            let line = format!("{}: {cell}: done", run.display());
            said.iter().flat_map(|said| said.err.lines()).filter(|it| **it == line).count()
        };
        for setting in ["xi=0.75", "xi=1"] {
            for seed in 1..=8 {
                let cell = format!("{setting}/seed={seed}");
                assert_eq!(trained(&cell), 1, "{cell}");
            }
        }
        itarl(&["status", text(&run)]).ends(DONE).prints(&["16 cells: 16 done"]);
        assert_same(&results(&run), &expected);
        let names = fs::read_dir(folder.path()).unwrap().map(|it| it.unwrap().file_name());
        assert_eq!(names.collect::<Vec<_>>(), [run.file_name().unwrap()]);
        fs::remove_dir_all(&run).unwrap();
    }
}

/// Three at work at any time, until all is done.
#[test]
fn killed_beside_others_they_end_with_the_same_bytes() {
    let longer = [&SIXTEEN[..2], &["--set", "learning.updates=60"], &SIXTEEN[4..]].concat();
    let expected = alone(&longer);
    let n_crashes = number("CRASHES", 8);
    let folder = tempfile::tempdir().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (mut hits, mut runs) = (0, 0);
    while hits < n_crashes {
        let run = folder.path().join(format!("run {runs}"));
        let words = train_words(&run, &longer);
        let mut workers: Vec<Child> = (0..3).map(|_| start(&words)).collect();
        // One worker alone, or the last one would never come to an end.
        for _ in 0..4 {
            thread::sleep(Duration::from_millis(u64::from(rng.next_u32() % 700)));
            let mut victim = workers.remove(rng.next_u32() as usize % workers.len());
            victim.kill().unwrap();
            hits += u32::from(end(victim).code.is_none());
            workers.push(start(&words));
        }
        for worker in workers {
            let said = end(worker);
            assert!([Some(DONE), Some(STOPPED)].contains(&said.code), "{said:?}");
        }
        train(&run, &longer).ends(DONE);
        let mut files = results(&run);
        files.retain(|name, _| !name.ends_with(".tmp"));
        assert_same(&files, &expected);
        fs::remove_dir_all(&run).unwrap();
        runs += 1;
        assert!(runs <= n_crashes + 2, "only {hits} hits in {runs} runs");
    }
    println!("{hits} kills in {runs} runs");
}

/// Where another one is at a cell, its neighbours are taken last.
#[test]
fn cells_are_taken_in_groups() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &[&SIXTEEN[..], &["--stop-after", "0"]].concat()).ends(STOPPED);
    let lock = File::create(run.join("cells/xi=0.75/seed=1/lock")).unwrap();
    lock.lock().unwrap();
    let said = train(&run, &SIXTEEN).ends(STOPPED).prints(&["15 of 16 cells done, 1 elsewhere"]);
    let done: Vec<_> = said.err.lines().filter(|line| line.ends_with(": done")).collect();
    let place = |cell: &str| {
        let line = format!("{}: {cell}: done", run.display());
        done.iter().position(|it| **it == line).unwrap()
    };
    for seed in 2..=4 {
        assert!(place(&format!("xi=0.75/seed={seed}")) >= 12, "{done:?}");
    }
    assert!(place("xi=0.75/seed=5") < 4, "{done:?}");
}

#[test]
fn cells_of_a_range_and_of_a_task_are_trained_and_no_others() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let cell = |which: &[&str]| itarl(&[&["cell", CRAWLER, "--out", text(&run)], which].concat());
    cell(&["--cells", "0-1"]).ends(DONE).prints(&["2 of 2 cells done"]);
    itarl(&["status", text(&run)]).ends(STOPPED).prints(&["2 done, 2 waiting"]);
    cell(&["--cells", "3,0-1"]).ends(DONE).prints(&["3 of 3 cells done"]);
    for task in ["1/3", "2/3", "3/3", "9/9"] {
        cell(&["--task", task]).ends(DONE);
    }
    assert_same(&results(&run), &alone(&[]));

    cell(&["--cells", "2-4"]).ends(FAILED).complains(&["--cells", "from 0 to 3, got 4"]);
    cell(&["--cells", "2-1"]).ends(USAGE).complains(&["FIRST-LAST expected", "got 2-1"]);
    cell(&["--task", "0/4"]).ends(USAGE).complains(&["K/N expected, K from 1 to N", "got 0/4"]);
    cell(&["--task", "1/4", "--index", "1"]).ends(USAGE);
    cell(&[]).ends(USAGE).complains(&["--index", "--cells", "--task"]);
}

/// An update that doesn't end while a test runs.
const ENDLESS: [&str; 2] = ["--set", "learning.steps_per_update=1000000000"];

#[test]
fn a_time_limit_ends_with_all_saved() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let words = train_words(&run, &ENDLESS);
    let limited = [&words[..], &["--for", "500ms"]].concat();
    let checkpoint = run.join("cells/xi=1/seed=2/checkpoint");
    itarl(&limited).ends(STOPPED).prints(&["4 to go on"]);
    let first = fs::read(&checkpoint).unwrap();

    // As Slurm tells it: in the environment, or asked.
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap();
    let end = (now.as_secs() + 4).to_string();
    let in_a_job = || {
        let mut command = command(&words);
        command.env("SLURM_JOB_ID", "7");
        command
    };
    let said = in_a_job().env("SLURM_JOB_END_TIME", end).output().unwrap();
    Said::of(said).ends(STOPPED);
    let second = fs::read(&checkpoint).unwrap();
    assert!(second != first);
    let squeue = folder.path().join("squeue");
    fs::write(&squeue, "#!/bin/sh\necho \"$@\" > \"$0.asked\"\necho 0:03\n").unwrap();
    fs::set_permissions(&squeue, Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:{}", folder.path().display(), env::var("PATH").unwrap());
    let said = in_a_job().env_remove("SLURM_JOB_END_TIME").env("PATH", path).output().unwrap();
    Said::of(said).ends(STOPPED);
    assert!(fs::read(&checkpoint).unwrap() != second);
    let asked = fs::read_to_string(folder.path().join("squeue.asked")).unwrap();
    assert!(asked.contains("--jobs 7"), "{asked}");

    let wrong = [&words[..], &["--for", "soon"]].concat();
    itarl(&wrong).ends(USAGE).complains(&["--for", "soon"]);
}

/// `itarl cell` may have begun a run of which no one wants the rest.
#[test]
fn what_a_resume_begins_is_said_first() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    itarl(&["cell", CRAWLER, "--index", "1", "--out", text(&run), "--stop-after", "5"])
        .ends(STOPPED);
    let file = run.join("experiment.toml");
    let alone = format!("itarl cell {} --index N --out {}", file.display(), run.display());
    let note = "note: 1 of 4 cells were begun so far, and this trains all 4; one alone: ";
    let said = itarl(&["resume", text(&run), "--stop-after", "0"]).ends(STOPPED);
    assert!(said.err.starts_with(&format!("{note}{alone}\n")), "{said:?}");
    // As advised.
    itarl(&["cell", text(&file), "--index", "1", "--out", text(&run)]).ends(DONE);
    let said = itarl(&["resume", text(&run)]).ends(DONE);
    assert!(!said.err.contains("note: "), "{said:?}");
}

/// The program with another `flock` than the system's.
fn with_flock(folder: &Path, body: &str) -> PathBuf {
    let (source, library) = (folder.join("flock.c"), folder.join("flock.so"));
    fs::write(&source, format!("#include <errno.h>\nint flock(int f, int o) {{ {body} }}\n"))
        .unwrap();
    let mut compiler = Command::new("cc");
    compiler.args(["-shared", "-fPIC", "-o"]).arg(&library).arg(&source);
    assert!(compiler.status().unwrap().success());
    library
}

#[test]
fn a_file_system_without_locks_is_told_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let library = with_flock(folder.path(), "errno = ENOLCK; return -1;");
    for _ in 0..2 {
        let said = command(&train_words(&run, &[])).env("LD_PRELOAD", &library).output().unwrap();
        let said = Said::of(said).ends(FAILED);
        let line = format!("{}/manifest.json: this file system locks no files", run.display());
        assert!(said.err.starts_with(&line), "{said:?}");
        assert_eq!((said.err.lines().count(), said.out.as_str()), (1, ""), "{said:?}");
        assert!(said.err.contains("No locks available"), "{said:?}");
    }
    train(&run, &[]).ends(DONE);
}

/// As on Lustre with `localflock`, where each machine has its own locks.
#[test]
fn a_second_worker_at_a_cell_is_never_silent() {
    let longer = ["--set", "learning.updates=160", "--threads", "1"];
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let library = with_flock(folder.path(), "errno = 0; return 0;");
    let words = train_words(&run, &longer);
    let worker = || {
        let mut command = command(&words);
        let pipe = std::process::Stdio::piped;
        command.env("LD_PRELOAD", &library).stdout(pipe()).stderr(pipe()).spawn().unwrap()
    };
    let first = worker();
    wait_until(|| run.join("cells/xi=1/seed=2/checkpoint").exists());
    let second = worker();
    let name = format!("process {} on ", second.id());
    let said = end(first).ends(FAILED).prints(&["4 failed"]);
    for cell in ["xi=0.75/seed=1", "xi=1/seed=2"] {
        let left = format!("{}: {name}", run.join("cells").join(cell).display());
        said.err.lines().find(|line| line.contains(&left)).unwrap();
    }
    end(second).ends(DONE);
    assert_same(&results(&run), &alone(&longer));
}

/// As on a file system that also hides what is in the lock: its checkpoint alone tells of another one.
#[test]
fn a_checkpoint_of_another_process_ends_the_cell_and_no_other() {
    let longer = ["--set", "learning.updates=160", "--set", "checkpoint.every=1"];
    let folder = tempfile::tempdir().unwrap();
    let [run, other] = ["run", "other"].map(|name| folder.path().join(name));
    train(&other, &[&longer[..], &["--stop-after", "5"]].concat()).ends(STOPPED);
    let worker = start(&train_words(&run, &longer));
    let name = "cells/xi=1/seed=2/checkpoint";
    let [path, of_another] = [&run, &other].map(|run| run.join(name));
    let updates = || Header::read(&path).unwrap().map_or(0, |header| header.updates);
    wait_until(|| updates() > 5);
    let beside = folder.path().join("checkpoint");
    fs::copy(&of_another, &beside).unwrap();
    fs::rename(&beside, &path).unwrap();
    let said = end(worker).ends(FAILED).prints(&["3 of 4 cells done, 1 failed"]);
    let place =
        format!("{}: another process wrote it, at update 5, and this one's ", path.display());
    said.complains(&[&place]);
    assert_eq!(updates(), 5);
    // It goes on from there, to the same bytes.
    itarl(&["resume", text(&run)]).ends(DONE);
    assert_same(&results(&run), &alone(&longer));
}

/// The small experiment with other values of what it sweeps.
fn swept(folder: &Path, xi: &str, seeds: &str) -> PathBuf {
    let text = fs::read_to_string(root().join(CRAWLER)).unwrap();
    let model = root().join("tests/models/crawler.toml");
    let text = text
        .replace("../models/crawler.toml", model.to_str().unwrap())
        .replace("[0.75, 1]", xi)
        .replace("seeds = 2", &format!("seeds = {seeds}"));
    let file = folder.join("swept.toml");
    fs::write(&file, text).unwrap();
    file
}

/// What was there keeps its numbers and its bytes, and what came later is what it would have been.
#[test]
fn a_run_grows_by_seeds_and_by_values() {
    let folder = tempfile::tempdir().unwrap();
    let [run, through] = ["run", "through"].map(|name| folder.path().join(name));
    train(&run, &[]).ends(DONE);
    let first = results(&run);
    let file = swept(folder.path(), "[0.5, 0.75, 1]", "3");
    let call = |command, run: &Path, more: &[&str]| {
        itarl(&[&[command, text(&file), "--out", text(run)], more].concat())
    };
    call("train", &run, &["--stop-after", "0"]).ends(STOPPED);
    let grown = results(&run);
    assert_same(
        &grown.clone().into_iter().filter(|(name, _)| first.contains_key(name)).collect(),
        &first,
    );
    let said = itarl(&["status", text(&run)]).ends(STOPPED).prints(&["9 cells: 4 done, 5 waiting"]);
    for row in
        ["|    0 | xi=0.75 |    1 |", "|    3 | xi=1    |    2 |", "|    4 | xi=0.5  |    1 |"]
    {
        assert!(said.out.contains(row), "{said:?}");
    }
    // A number is the same cell's as before, and in the list.
    call("cell", &run, &["--index", "4"]).ends(DONE);
    assert!(run.join("cells/xi=0.5/seed=1/checkpoint").exists());
    let list = call("train", &run, &["--list"]).ends(DONE);
    assert!(list.out.contains("4\txi=0.5/seed=1\n"), "{list:?}");
    itarl(&["resume", text(&run)]).ends(DONE).prints(&["9 of 9 cells done"]);
    call("train", &through, &[]).ends(DONE);
    assert_same(&results(&run), &results(&through));
    itarl(&["summary", text(&run)]).ends(DONE).prints(&["xi=0.5"]);
    itarl(&["report", text(&run)]).ends(DONE);

    let before = tree(&run);
    for (set, complaint) in [
        ("sweep.seeds=2", "cell 8: xi=1/seed=3 there, nothing here"),
        ("learning.rate=3", "learning.rate: 1.0 there, 3.0 here"),
        ("learning.updates=12", "learning.updates: 30 there, 12 here"),
    ] {
        call("train", &run, &["--set", set]).ends(FAILED).complains(&[complaint]);
    }
    // Not even beside more cells.
    call("train", &run, &["--set", "sweep.seeds=4", "--set", "policy.samples=9"])
        .ends(FAILED)
        .complains(&["policy.samples: 8 there, 9 here"]);
    assert_same(&tree(&run), &before);
}

#[test]
fn a_run_that_many_let_grow_at_once_grows_once() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &["--set", "learning.updates=4"]).ends(DONE);
    let words = train_words(&run, &SIXTEEN);
    let workers: Vec<_> = (0..8).map(|_| start(&words)).collect();
    for worker in workers {
        let said = end(worker);
        assert!([Some(DONE), Some(STOPPED)].contains(&said.code), "{said:?}");
    }
    itarl(&["status", text(&run)]).ends(DONE).prints(&["16 cells: 16 done"]);
}

#[test]
fn runs_are_merged_with_the_bytes_that_they_have() {
    let folder = tempfile::tempdir().unwrap();
    let [one, other, both, through] =
        ["one", "other", "both", "through"].map(|name| folder.path().join(name));
    train(&one, &["--set", "sweep.seeds=[1,3]"]).ends(DONE);
    let file = swept(folder.path(), "[1, 0.5]", "[2, 3]");
    itarl(&["train", text(&file), "--out", text(&other)]).ends(DONE);
    let merge = || itarl(&["merge", text(&one), text(&other), "--out", text(&both)]);
    merge().ends(DONE).prints(&["7 of 9 cells are from 2 runs"]);
    let merged = tree(&both);
    // What it was killed in the middle of goes on.
    fs::remove_file(both.join("cells/xi=1/seed=3/policy.safetensors")).unwrap();
    merge().ends(DONE);
    assert_same(&tree(&both), &merged);
    itarl(&["status", text(&both)]).ends(STOPPED).prints(&["9 cells: 7 done, 2 waiting"]);
    itarl(&["resume", text(&both)]).ends(DONE);
    let file = swept(folder.path(), "[0.75, 1, 0.5]", "3");
    itarl(&["train", text(&file), "--out", text(&through)]).ends(DONE);
    assert_same(&results(&both), &results(&through));

    fs::remove_dir_all(&both).unwrap();
    let metrics = other.join("cells/xi=1/seed=3/policy.safetensors");
    fs::write(&metrics, "else").unwrap();
    merge().ends(FAILED).complains(&["cells/xi=1/seed=3/policy.safetensors", "other bytes"]);
    fs::remove_dir_all(&other).unwrap();
    train(&other, &["--set", "learning.rate=2"]).ends(DONE);
    fs::remove_dir_all(&both).unwrap();
    merge().ends(FAILED).complains(&[text(&other), "learning.rate: 1.0 there, 2.0 here"]);
    assert!(!both.exists());
}

/// All cells of a run as if they were done, but for the last ones.
fn make_done(run: &Path, n_left: usize) {
    let catalogue = Catalogue::open(run).unwrap();
    let [first, others @ ..] = catalogue.cells() else { panic!("no cells") };
    let mut checkpoint =
        Checkpoint::read(&first.folder.checkpoint(), first.expected()).unwrap().unwrap();
    for cell in &others[..others.len() - n_left] {
        let folder = &cell.folder;
        fs::create_dir_all(folder.path()).unwrap();
        checkpoint.header.identity = cell.identity;
        fs::write(folder.checkpoint(), checkpoint.encode()).unwrap();
        let files = |it: &CellFolder| [it.metrics(), it.policy(), it.replay(), it.lock()];
        for (from, to) in files(&first.folder).into_iter().zip(files(folder)) {
            fs::copy(from, to).unwrap();
        }
    }
}

#[test]
fn a_worker_finds_the_cells_that_are_left_of_a_large_run() {
    let n = number("CELLS", 1000);
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let seeds = format!("sweep.seeds={}", n / 2);
    let more = ["--set", &seeds, "--set", "learning.updates=4"];
    let words = [&["cell", CRAWLER, "--index", "0", "--out", text(&run)], &more[..]].concat();
    itarl(&words).ends(DONE);
    make_done(&run, 3);
    let begin = Instant::now();
    let said = itarl(&["status", text(&run)]).ends(STOPPED);
    said.prints(&[&format!("{n} cells: {} done, 3 waiting", n - 3)]);
    println!("status of {n} cells: {:?}", begin.elapsed());

    let begin = Instant::now();
    let mut worker = start(&train_words(&run, &[&more[..], &["--threads", "1"]].concat()));
    let mut lines = BufReader::new(worker.stderr.take().unwrap()).lines().map(Result::unwrap);
    let first = lines.next().unwrap();
    println!("a worker's first cell of them: {:?}", begin.elapsed());
    let left = format!("{}: xi=1/seed={}: done", run.display(), n / 2 - 2);
    assert_eq!(first, left);
    assert_eq!(lines.count(), 2);
    end(worker).ends(DONE).prints(&[&format!("{n} of {n} cells done\n")]);
}
