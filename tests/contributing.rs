//! CONTRIBUTING.md adds one of each thing, as diffs: they fit the code, touch one new file, one list and
//! the docs, and what they add passes the tests that are there for all.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// The diffs of the page, each with the heading that it's under.
fn diffs() -> Vec<(String, String)> {
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
fn apply(folder: &Path, arguments: &[&str], diff: &str, heading: &str) {
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

#[test]
fn each_addition_is_one_new_file_and_one_list_and_docs() {
    let headings: Vec<_> = diffs().into_iter().map(|(heading, _)| heading).collect();
    let expected =
        ["An extrinsic reward", "An intrinsic reward", "A policy", "A robot", "A figure"];
    assert_eq!(headings, expected);
    for (heading, diff) in diffs() {
        apply(&root(), &["--check"], &diff, &heading);
        let files = diff.split("diff --git ").skip(1);
        let (new, changed): (Vec<_>, Vec<_>) =
            files.partition(|file| file.contains("\nnew file mode"));
        assert_eq!(new.len(), 1, "new files of {heading:?}");
        let is_doc = |file: &&str| file.lines().next().unwrap().ends_with(".md");
        // All files of models/ are robots: that list is its page.
        let n_lists = usize::from(heading != "A robot");
        let lists = changed.iter().filter(|file| !is_doc(file)).count();
        assert_eq!(lists, n_lists, "changed files of {heading:?} that are no docs");
    }
}

/// A copy of all tracked files, as they are now.
fn copy_to(folder: &Path) {
    let list = Command::new("git").arg("ls-files").current_dir(root()).output().unwrap();
    for file in String::from_utf8(list.stdout).unwrap().lines() {
        let to = folder.join(file);
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(root().join(file), to).unwrap();
    }
}

/// All of them together, which is one build. What is tested is built without Bullet: nothing that is
/// added here needs it, and it takes as long as all else.
#[test]
fn what_is_added_passes_the_tests_of_its_kind() {
    let folder = tempfile::tempdir().unwrap();
    copy_to(folder.path());
    for (heading, diff) in diffs() {
        apply(folder.path(), &[], &diff, &heading);
    }
    // Cargo tells crates apart by their version and their place in the workspace: with another
    // version the copy's lie beside ours in the target folder, and only ours are built again.
    let manifest = folder.path().join("Cargo.toml");
    let text = fs::read_to_string(&manifest).unwrap();
    let renamed = text.replacen("version = \"0.1.0\"", "version = \"0.1.0-contributing\"", 1);
    assert_ne!(renamed, text, "no version in the workspace's Cargo.toml");
    fs::write(&manifest, renamed).unwrap();

    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let crates = ["reward", "policy", "figures", "svenja"].map(|name| ["-p", name]);
    let tests = ["--lib", "--test", "contract", "--test", "models"];
    let said = Command::new(env!("CARGO"))
        .args(["test", "--offline", "--no-default-features"])
        .args(crates.as_flattened())
        .args(tests)
        .current_dir(folder.path())
        .env("CARGO_TARGET_DIR", target)
        .output()
        .unwrap();
    let [out, errors] = [&said.stdout, &said.stderr].map(|it| String::from_utf8_lossy(it));
    assert!(said.status.success(), "{out}\n{errors}");
    // The tests that come with what is added are among them.
    for test in ["sideways::tests::", "variety::tests::"] {
        assert!(out.contains(test), "no {test} in\n{out}");
    }
}
