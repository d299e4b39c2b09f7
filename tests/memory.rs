//! What there's no memory for is refused with its size, before anything is begun.

use std::{fs, process::Command};

use crate::common::*;

/// What the program says of an experiment that may take so many MB of address space.
fn train(settings: &str, megabytes: u64) -> (Option<i32>, String) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("large.toml");
    let model = root().join("models/svenja.toml");
    fs::write(&file, format!("model = {model:?}\n{settings}")).unwrap();
    let out = folder.path().join("run");
    let output = Command::new("sh")
        .args(["-c", &format!("ulimit -v {}; exec \"$@\"", megabytes * 1000), "sh"])
        .arg(env!("CARGO_BIN_EXE_itarl"))
        .args(["train", "--threads", "1", "--stop-after", "0", "--out"])
        .args([&out, &file])
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    if output.status.code() == Some(1) && said.contains("setting base: ") {
        assert!(!out.exists(), "refused, and begun all the same: {said}");
    }
    (output.status.code(), said)
}

/// At every limit it's refused with a number of MB, or begun.
#[track_caller]
fn is_refused(settings: &str, megabytes: &[u64]) {
    let mut n_refused = 0;
    for &limit in megabytes {
        let (code, said) = train(settings, limit);
        assert!(matches!(code, Some(1 | 75)), "{limit} MB: {code:?}: {said}");
        if code == Some(1) {
            assert!(said.contains(" MB, and there is no memory for them"), "{limit}: {said}");
            n_refused += 1;
        }
    }
    assert!(n_refused > 0);
}

#[test]
fn a_window_of_a_million_joint_states() {
    is_refused("reward.intrinsic = { window = 1048576, group = \"body\", past = 64 }", &[600, 800]);
}

#[test]
fn fifty_million_parameters() {
    let settings = "policy = { hidden_units = 16384, memory = 100 }";
    is_refused(settings, &[300, 600, 1200, 2400, 4800]);
}

#[test]
fn as_many_in_each_of_six_machines() {
    let settings =
        "policy = { kind = \"modular\", hidden_units = 16384, memory = 100, inputs = \"all\" }";
    is_refused(settings, &[300, 1200, 4800]);
}

#[test]
fn a_recording_of_a_million_steps() {
    is_refused("record.steps = 1000000", &[500, 2000, 8000]);
}
