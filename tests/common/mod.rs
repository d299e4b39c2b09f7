//! The program as a user runs it: commands, what they said, and what they left.
#![allow(dead_code, missing_docs)] // Each test uses a part of it.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Output, Stdio},
    thread,
    time::{Duration, Instant},
};

/// Four cells of a small robot.
pub(crate) const CRAWLER: &str = "tests/experiments/crawler.toml";

/// What a shell and a scheduler see.
pub(crate) const DONE: i32 = 0;
pub(crate) const FAILED: i32 = 1;
pub(crate) const USAGE: i32 = 2;
pub(crate) const STOPPED: i32 = 75;

/// Longer than anything here takes, on the slowest machine.
const PATIENCE: Duration = Duration::from_secs(120);

pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// How a command ended and what it said.
#[derive(Debug)]
pub(crate) struct Said {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Said {
    pub(crate) fn of(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Self { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }

    /// Panics, with all that was said, if it didn't end like that.
    #[track_caller]
    pub(crate) fn ends(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{self:?}");
        // A panic's message, whatever the code.
        assert!(!self.err.contains("panicked"), "{self:?}");
        // The system's text, once in each line.
        let twice = |line: &str| line.matches("(os error ").count() > 1;
        assert!(!self.err.lines().any(twice), "{self:?}");
        self
    }

    /// All of these are in what was said to people.
    #[track_caller]
    pub(crate) fn complains(self, texts: &[&str]) -> Self {
        for text in texts {
            assert!(self.err.contains(text), "{text:?} isn't in {}", self.err);
        }
        self
    }

    /// All of these are in what was printed.
    #[track_caller]
    pub(crate) fn prints(self, texts: &[&str]) -> Self {
        for text in texts {
            assert!(self.out.contains(text), "{text:?} isn't in {}", self.out);
        }
        self
    }
}

/// The program, in the repository's root.
pub(crate) fn command(words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_itarl"));
    command.args(words).current_dir(root()).stdin(Stdio::null());
    command
}

/// Runs it to its end.
pub(crate) fn itarl(words: &[&str]) -> Said {
    Said::of(command(words).output().unwrap())
}

/// Starts it.
pub(crate) fn start(words: &[&str]) -> Child {
    command(words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits for its end.
pub(crate) fn end(child: Child) -> Said {
    Said::of(child.wait_with_output().unwrap())
}

/// `itarl train` of the four cells into a folder, with changes.
pub(crate) fn train(run: &Path, more: &[&str]) -> Said {
    itarl(&train_words(run, more))
}

pub(crate) fn train_words<'a>(run: &'a Path, more: &[&'a str]) -> Vec<&'a str> {
    [&["train", CRAWLER, "--out", text(run)], more].concat()
}

pub(crate) fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Waits until something holds.
pub(crate) fn wait_until(mut it: impl FnMut() -> bool) {
    let start = Instant::now();
    while !it() {
        assert!(start.elapsed() < PATIENCE, "nothing happened");
        thread::sleep(Duration::from_millis(2));
    }
}

/// `TERM`, `INT` and others, as a shell sends them.
pub(crate) fn signal(child: &Child, name: &str) {
    let kill = format!("kill -{name} {}", child.id());
    let status: ExitStatus = Command::new("sh").args(["-c", &kill]).status().unwrap();
    assert!(status.success());
}

/// What all cells have learned: each file's bytes by its path. Locks have who was there, which is no result.
pub(crate) fn results(run: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = tree(&run.join("cells"));
    files.retain(|name, _| !name.ends_with("/lock"));
    files
}

/// All files below a folder.
pub(crate) fn tree(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = text(path.strip_prefix(folder).unwrap()).to_owned();
                files.insert(name, fs::read(path).unwrap());
            }
        }
    }
    files
}

/// The same files with the same bytes; says which differ, and not all their bytes.
#[track_caller]
pub(crate) fn assert_same(one: &BTreeMap<String, Vec<u8>>, other: &BTreeMap<String, Vec<u8>>) {
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(one), names(other));
    let differ: Vec<_> = one.iter().filter(|(name, bytes)| other[*name] != **bytes).collect();
    let differ: Vec<_> = differ.into_iter().map(|(name, _)| name).collect();
    assert!(differ.is_empty(), "other bytes in {differ:?}");
}

/// A column of a cell's `metrics.csv`.
pub(crate) fn column(cell: &Path, name: &str) -> Vec<f64> {
    let metrics = fs::read_to_string(cell.join("metrics.csv")).unwrap();
    let mut lines = metrics.lines();
    let index = lines.next().unwrap().split(',').position(|column| column == name).unwrap();
    lines.map(|line| line.split(',').nth(index).unwrap().parse().unwrap()).collect()
}
