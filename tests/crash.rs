//! Killed at any moment, it goes on and ends with the same bytes.
//!
//! `CRASHES` is how many kills must hit, 12 by default.

use std::{
    collections::BTreeMap,
    env, fs,
    path::Path,
    thread,
    time::{Duration, Instant},
};

use crate::common::*;
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};

/// A second of work, most of it the disk's: 30 checkpoints a cell.
const LONGER: [&str; 2] = ["--set", "learning.updates=120"];

/// The longest time to a kill, as a share of the time that all of it takes: it takes several.
const LONGEST: f64 = 0.4;

/// A number from 0 to 1.
fn share(rng: &mut ChaCha8Rng) -> f64 {
    f64::from(rng.next_u32()) / f64::from(u32::MAX)
}

#[test]
fn killed_at_random_moments_it_ends_with_the_same_bytes() {
    let n_crashes: u32 = env::var("CRASHES").map_or(12, |n| n.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let through = folder.path().join("through");
    let begin = Instant::now();
    train(&through, &LONGER).ends(DONE);
    let duration = begin.elapsed();
    let expected = results(&through);

    // The moments are the same ones in each test, as shares of that time.
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (mut hits, mut runs, mut while_saving) = (0, 0, 0);
    while hits < n_crashes {
        runs += 1;
        assert!(2 * runs <= n_crashes + 2, "only {hits} hits in {runs} runs");
        let run = folder.path().join(format!("run {runs}"));
        while kill(&run, duration.mul_f64(LONGEST * share(&mut rng))) {
            hits += 1;
            while_saving += u32::from(half_written(&run));
            itarl(&["status", text(&run)]);
        }
        assert_same(&without_leftovers(&run), &expected);
        let hidden = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
        let hidden: Vec<_> = hidden.filter(|it| it.to_string_lossy().starts_with('.')).collect();
        assert!(hidden.is_empty(), "{hidden:?}");
        fs::remove_dir_all(run).unwrap();
    }
    println!("{hits} kills, {while_saving} of them within a write, {runs} runs");
}

/// Whether the kill hit a process that wasn't done. If it was, it had ended well.
fn kill(run: &Path, after: Duration) -> bool {
    let mut child = start(&train_words(run, &LONGER));
    thread::sleep(after);
    child.kill().unwrap();
    let said = end(child);
    let is_hit = said.code.is_none();
    if !is_hit {
        said.ends(DONE);
    }
    is_hit
}

fn half_written(run: &Path) -> bool {
    run.is_dir() && tree(run).keys().any(|name| name.ends_with(".tmp"))
}

/// A kill between a file and its rename leaves NAME.tmp, which the next write goes over; after the
/// last one of a cell there's none.
fn without_leftovers(run: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = results(run);
    files.retain(|name, _| !name.ends_with(".tmp"));
    files
}

/// The last checkpoint is there, and the exports are those of the one before.
#[test]
fn killed_behind_its_last_checkpoint_it_makes_up_for_the_exports() {
    let folder = tempfile::tempdir().unwrap();
    let [run, earlier] = ["run", "earlier"].map(|name| folder.path().join(name));
    train(&run, &[]).ends(DONE);
    let through = results(&run);
    train(&earlier, &["--stop-after", "28"]).ends(STOPPED);
    // In the order in which they're written.
    let exports = ["policy.safetensors", "replay.safetensors"];
    for n_written in 0..2 {
        let of = |run: &Path, name: &str| run.join("cells/xi=1/seed=1").join(name);
        for name in &exports[n_written..] {
            fs::copy(of(&earlier, name), of(&run, name)).unwrap();
        }
        assert!(results(&run) != through);
        itarl(&["resume", text(&run)]).ends(DONE);
        assert_same(&results(&run), &through);
        fs::remove_file(of(&run, exports[n_written])).unwrap();
        itarl(&["resume", text(&run)]).ends(DONE);
        assert_same(&results(&run), &through);
    }
}

#[test]
fn what_a_killed_process_leaves_half_written_is_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let through = folder.path().join("through");
    train(&through, &[]).ends(DONE);

    let run = folder.path().join("run");
    let half_made = folder.path().join(".run.new-aB3dE6");
    fs::create_dir_all(half_made.join("cells")).unwrap();
    train(&run, &["--stop-after", "5"]).ends(STOPPED);
    assert!(!half_made.exists());
    let cell = run.join("cells/xi=1/seed=2");
    for name in ["checkpoint", "policy.safetensors", "replay.safetensors"] {
        fs::write(cell.join(format!("{name}.tmp")), "half of it, and longer than a row").unwrap();
    }
    let metrics = cell.join("metrics.csv");
    let longer = fs::read_to_string(&metrics).unwrap() + "6,60,0.00";
    fs::write(&metrics, longer).unwrap();
    itarl(&["resume", text(&run)]).ends(DONE);
    assert_same(&results(&run), &results(&through));
}
