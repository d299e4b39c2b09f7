//! Asked to stop by a signal, it stops at its next control step, with all saved.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use crate::common::*;

/// What a terminal, a shell and a scheduler ask with, and the exit code of an end at once.
const SIGNALS: [(&str, i32); 4] = [("HUP", 129), ("INT", 130), ("USR1", 138), ("TERM", 143)];

/// An update that doesn't end while a test runs.
const ENDLESS: &str = "learning.steps_per_update=1000000000";

fn sets<'a>(sets: &[&'a str]) -> Vec<&'a str> {
    sets.iter().flat_map(|it| ["--set", it]).collect()
}

/// Starts it with a signal at its default, which the one who runs this test may ignore, or ignored.
fn start_with(how: &str, signal: &str, words: &[&str]) -> Child {
    Command::new("env")
        .arg(format!("--{how}-signal={signal}"))
        .arg(env!("CARGO_BIN_EXE_itarl"))
        .args(words)
        .current_dir(root())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits for the end of one that was asked to stop, and not for ever.
fn stopping(mut child: Child) -> Said {
    let asked = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if asked.elapsed() > Duration::from_secs(30) {
            child.kill().unwrap();
        }
        thread::sleep(Duration::from_millis(2));
    }
    end(child)
}

fn cell(run: &Path) -> PathBuf {
    run.join("cells/xi=0.75/seed=1")
}

fn n_rows(run: &Path) -> usize {
    let metrics = fs::read_to_string(cell(run).join("metrics.csv"));
    metrics.map_or(0, |it| it.lines().skip(1).count())
}

/// Updates and control steps in the header of a cell's checkpoint, if there is one.
fn progress(run: &Path) -> Option<(u64, u64)> {
    let bytes = fs::read(cell(run).join("checkpoint")).ok()?;
    let number = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    Some((number(24), number(32)))
}

#[test]
fn asked_to_stop_it_saves_all_and_goes_on() {
    // No checkpoint is due before the end: what is saved is saved by the stop.
    let words = sets(&["learning.updates=600", "checkpoint.every=1000"]);
    let words = [&words[..], &["--threads", "1"]].concat();
    let folder = tempfile::tempdir().unwrap();
    let through = folder.path().join("through");
    train(&through, &words).ends(DONE);
    for (name, _) in SIGNALS {
        let run = folder.path().join(name);
        let child = start_with("default", name, &train_words(&run, &words));
        wait_until(|| n_rows(&run) > 2);
        signal(&child, name);
        let next = format!("to go on: itarl resume {}", run.display());
        stopping(child).ends(STOPPED).prints(&[&next]);
        for file in ["checkpoint", "policy.safetensors", "replay.safetensors"] {
            assert!(cell(&run).join(file).exists(), "{file}");
        }
        let said = itarl(&["status", text(&run)]).ends(STOPPED);
        let row = said.out.lines().find(|line| line.starts_with("|    0 ")).unwrap();
        assert!(row.contains(&format!(" {}/600 ", n_rows(&run))), "all rows are saved: {row}");
        itarl(&["resume", text(&run)]).ends(DONE);
        assert_same(&results(&run), &results(&through));
    }
}

/// Stopped again and again, mostly within updates, which take a second or so each.
#[test]
fn stopped_within_updates_it_ends_with_the_same_bytes() {
    let words = sets(&["learning.steps_per_update=4000", "learning.updates=3"]);
    let folder = tempfile::tempdir().unwrap();
    let through = folder.path().join("through");
    train(&through, &words).ends(DONE);
    let run = folder.path().join("run");
    let mut n_within = 0;
    for attempt in 0_u64.. {
        let child = start(&train_words(&run, &words));
        thread::sleep(Duration::from_millis(100 + 60 * attempt));
        signal(&child, "TERM");
        let said = stopping(child);
        match said.code {
            Some(DONE) => break,
            // Asked before it could be told: it hadn't begun.
            Some(STOPPED) | None => {}
            _ => panic!("{said:?}"),
        }
        let within = |(updates, control_steps)| control_steps > 4000 * updates;
        n_within += u32::from(progress(&run).is_some_and(within));
    }
    assert!(n_within > 0, "it was never stopped within an update");
    assert_same(&results(&run), &results(&through));
}

#[test]
fn an_endless_update_is_left_and_gone_on_with() {
    let words = sets(&[ENDLESS]);
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let mut before = 0;
    for attempt in 0..3 {
        let child = start(&train_words(&run, &words));
        wait_until(|| cell(&run).join("metrics.csv").exists());
        thread::sleep(Duration::from_millis(500 * (attempt + 1)));
        signal(&child, "TERM");
        stopping(child).ends(STOPPED).prints(&["0 of 4 cells done, 4 to go on"]);
        let said = itarl(&["status", text(&run)]).ends(STOPPED).prints(&["4 stopped"]);
        assert!(said.out.contains(" 0/30 "), "{said:?}");
        let (updates, control_steps) = progress(&run).unwrap();
        assert!(updates == 0 && control_steps > before, "{control_steps} after {before}");
        before = control_steps;
    }
    itarl(&["rollout", text(&cell(&run)), "--steps", "2"]).ends(DONE);
}

/// It has nothing to save yet.
#[test]
fn a_robot_that_settles_is_left_and_begun_again() {
    let words = sets(&["control.settle_steps=1000000"]);
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let child = start(&train_words(&run, &words));
    wait_until(|| cell(&run).join("metrics.csv").exists());
    signal(&child, "TERM");
    stopping(child).ends(STOPPED).prints(&["0 of 4 cells done, 4 to go on"]);
    itarl(&["status", text(&run)]).ends(STOPPED).prints(&["4 cells: 4 waiting"]);
}

/// As `timeout` does it, which tells the process and then its group.
#[test]
fn two_signals_right_after_each_other_are_one_wish() {
    for second in ["TERM", "INT"] {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("run");
        let child = start(&train_words(&run, &sets(&[ENDLESS])));
        wait_until(|| cell(&run).join("metrics.csv").exists());
        signal(&child, "TERM");
        // It may have ended before the second one.
        let kill = format!("kill -{second} {} 2>/dev/null", child.id());
        let _ = Command::new("sh").args(["-c", &kill]).status().unwrap();
        stopping(child).ends(STOPPED);
    }
}

#[test]
fn a_second_signal_later_ends_it_at_once() {
    // A single control step takes longer than this test waits.
    let words = sets(&[
        "physics.frequency_hz=100000",
        "control.frequency_hz=0.01",
        "control.settle_steps=0",
        "record.pose_every=1000000",
    ]);
    for (name, code) in SIGNALS {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("run");
        let mut child = start_with("default", name, &train_words(&run, &words));
        wait_until(|| cell(&run).join("metrics.csv").exists());
        signal(&child, name);
        thread::sleep(Duration::from_millis(1200));
        assert!(child.try_wait().unwrap().is_none(), "its control step isn't over");
        signal(&child, name);
        stopping(child).ends(code);
    }
}

#[test]
fn under_nohup_a_closed_terminal_is_no_wish_to_stop() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let words = sets(&["learning.updates=120"]);
    let child = start_with("ignore", "HUP", &train_words(&run, &words));
    wait_until(|| n_rows(&run) > 2);
    signal(&child, "HUP");
    end(child).ends(DONE);
}
