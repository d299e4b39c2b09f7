//! `make setup` on a machine where another apt is at work. Its apt is a script of ours.

use std::{
    fs::{self, Permissions},
    os::unix::fs::PermissionsExt,
    path::Path,
    process::{Command, Output},
};

const LOCKED: &str = "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 7";

/// Runs the target where nothing is installed, with an apt-get that fails so often.
fn set_up(folder: &Path, failures: usize, message: &str) -> (Output, String) {
    let script = |name: &str, text: String| {
        let path = folder.join(name);
        fs::write(&path, format!("#!/bin/sh\n{text}\n")).unwrap();
        fs::set_permissions(&path, Permissions::from_mode(0o755)).unwrap();
    };
    let calls = folder.join("calls");
    fs::write(&calls, "").unwrap();
    script("dpkg-query", "exit 1".into());
    script("id", "echo 0".into());
    script(
        "apt-get",
        format!(
            "echo \"$1\" >> {0}\n\
             test $(wc -l < {0}) -gt {failures} || {{ echo '{message}' >&2; exit 100; }}",
            calls.display()
        ),
    );
    let path = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap());
    let output = Command::new("make")
        .args(["-C", concat!(env!("CARGO_MANIFEST_DIR"), "/../.."), "setup"])
        .args(["APT_PAUSE=0", "APT_ATTEMPTS=5"])
        .env("PATH", path)
        .env_remove("MAKEFLAGS")
        .output()
        .unwrap();
    (output, fs::read_to_string(calls).unwrap())
}

#[test]
fn another_apt_is_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let (output, calls) = set_up(folder.path(), 3, LOCKED);
    assert!(output.status.success(), "{output:?}");
    assert_eq!(calls, "update\nupdate\nupdate\nupdate\ninstall\n");
}

#[test]
fn but_not_for_ever() {
    let folder = tempfile::tempdir().unwrap();
    let (output, calls) = set_up(folder.path(), 100, LOCKED);
    assert!(!output.status.success());
    assert_eq!(calls, "update\n".repeat(5));
    assert!(String::from_utf8_lossy(&output.stderr).contains("It is held by process 7"));
}

#[test]
fn other_failures_end_it_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let (output, calls) = set_up(folder.path(), 100, "E: Unable to locate package g++");
    assert!(!output.status.success());
    assert_eq!(calls, "update\n");
}
