//! The diffs of CONTRIBUTING.md, and `git apply`.

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

/// The repository.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// The diffs of the page, each with the heading that it's under.
pub(crate) fn diffs() -> Vec<(String, String)> {
    let page = fs::read_to_string(root().join("CONTRIBUTING.md")).unwrap();
    let sections = page.split("\n## ").skip(1).filter_map(|section| {
        let (_, rest) = section.split_once("```diff\n")?;
        // What is added has fences of its own, behind a plus.
        let (diff, rest) = rest.split_once("\n```\n")?;
        assert!(!rest.contains("```diff"), "one diff a section");
        Some((section.lines().next()?.to_owned(), format!("{diff}\n")))
    });
    sections.collect()
}

/// `git apply` in a folder, which needn't be a repository.
pub(crate) fn apply(folder: &Path, arguments: &[&str], diff: &str, heading: &str) {
    let mut git = Command::new("git")
        .arg("apply")
        .args(arguments)
        .arg("-")
        .current_dir(folder)
        // A folder in a folder of some repository isn't that one's.
        .env("GIT_CEILING_DIRECTORIES", folder.parent().unwrap())
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    git.stdin.take().unwrap().write_all(diff.as_bytes()).unwrap();
    assert!(
        git.wait().unwrap().success(),
        "the diff of {heading:?} in CONTRIBUTING.md doesn't apply"
    );
}
