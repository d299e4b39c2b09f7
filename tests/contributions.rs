//! What CONTRIBUTING.md adds passes the tests that are there for all: a build of its own, and so
//! `make contributing-test`.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "common/diffs.rs"]
mod diffs;

use std::{fs, path::Path, process::Command};

use diffs::{apply, diffs, root};

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
