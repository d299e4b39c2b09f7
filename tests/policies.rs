//! Every kind of policy trains, goes on and is shown like any other, and starts from what another cell
//! has learned.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::common::*;
use policy::KindSettings;
use tempfile::TempDir;

/// The crawler with its two joints as two legs, in cells of 12 updates.
struct Lab(TempDir);

impl Lab {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let model = fs::read_to_string(root().join("tests/models/crawler.toml")).unwrap();
        let groups = "\n[[group]]\nname = 'upper'\njoints = ['shoulder']\n\
                      [[group]]\nname = 'lower'\njoints = ['elbow']\ncontacts = ['forearm']\n";
        fs::write(folder.path().join("crawler.toml"), model + groups).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// An experiment with these lines in its table `policy`.
    fn experiment(&self, name: &str, policy: &str) -> PathBuf {
        let text = fs::read_to_string(root().join(CRAWLER)).unwrap();
        let text = text
            .replace("../models/crawler.toml", "crawler.toml")
            .replace("hidden_units = 4\nsamples = 8", policy)
            .replace("updates = 30", "updates = 12");
        assert!(text.contains(policy) && text.contains("updates = 12"), "{text}");
        let file = self.path(&format!("{name}.toml"));
        fs::write(&file, text).unwrap();
        file
    }

    /// Trains it, with more words.
    fn train(&self, file: &Path, run: &str, more: &[&str]) -> Said {
        let run = self.path(run);
        itarl(&[&["train", text(file), "--out", text(&run)], more].concat())
    }

    /// A run of this policy, done, and what its last cell exported.
    fn done(&self, name: &str, policy: &str) -> (PathBuf, PathBuf) {
        self.train(&self.experiment(name, policy), name, &[]).ends(DONE);
        let run = self.path(name);
        let export = run.join("cells/xi=1/seed=2/policy.safetensors");
        (run, export)
    }
}

/// All kinds of the list, and variants of some.
fn policies() -> Vec<String> {
    let kinds = KindSettings::all();
    let kinds = kinds.iter().map(|kind| format!("kind = '{}'", kind.name()));
    let variants = [
        "hidden_units = 4\nsamples = 8\nconnectivity = 'per_group'\ninputs = 'own_group'",
        "hidden_units = 2\nsamples = 8\nconnectivity = 'per_actuator'\ninputs = 'neighbours'",
        "kind = 'modular'\nhidden_units = 3\nsamples = 8\ninputs = 'neighbours'\nmemory = 1",
        "kind = 'logistic'\nmemory = 2\ninitial_scale = 1",
    ];
    kinds.chain(variants.map(str::to_owned)).collect()
}

#[test]
fn every_policy_trains_with_the_same_bytes_however_it_is_done() {
    for (i, policy) in policies().iter().enumerate() {
        let lab = Lab::new();
        let file = lab.experiment("x", policy);
        lab.train(&file, "through", &["--threads", "1"]).ends(DONE);
        let through = results(&lab.path("through"));
        lab.train(&file, "otherwise", &["--threads", "2", "--lanes", "3"]).ends(DONE);
        assert_same(&results(&lab.path("otherwise")), &through);
        lab.train(&file, "alone", &["--threads", "2", "--solver", "bullet"]).ends(DONE);
        assert_same(&results(&lab.path("alone")), &through);
        let cut = lab.path(&format!("cut {i}"));
        lab.train(&file, &format!("cut {i}"), &["--stop-after", "3"]).ends(STOPPED);
        itarl(&["resume", text(&cut), "--stop-after", "6"]).ends(STOPPED);
        itarl(&["resume", text(&cut)]).ends(DONE);
        assert_same(&results(&cut), &through);
    }
}

#[test]
fn every_policy_is_rolled_out_and_shown() {
    let lab = Lab::new();
    for (i, policy) in policies().iter().enumerate() {
        let (run, export) = lab.done(&format!("run {i}"), policy);
        let cell = export.parent().unwrap();
        let roll = || itarl(&["rollout", text(cell), "--steps", "20"]).ends(DONE).out;
        assert_eq!(roll(), roll(), "{policy}");
        itarl(&["replay", text(cell), "--policy", "learned", "--html", text(&run.join("x.html"))])
            .ends(DONE);
        itarl(&["status", text(&run)]).ends(DONE).prints(&["12/12"]);
        itarl(&["summary", text(&run)]).ends(DONE);
        itarl(&["report", text(&run)]).ends(DONE);
        // What it has exported is checked when it's gone on with, and when it's rolled out.
        fs::write(&export, b"no policy").unwrap();
        for words in [&["resume", text(&run)][..], &["rollout", text(cell)]] {
            itarl(words).ends(FAILED).complains(&[text(&export), "safetensors: the file must be"]);
        }
    }
}

/// So slow that its parameters stay what they are.
const STILL: [&str; 8] = [
    "--set",
    "learning.rate=1e-100",
    "--set",
    "learning.decay=0",
    "--set",
    "learning.momentum=0",
    "--set",
    "learning.updates=1",
];

#[test]
fn a_cell_starts_from_what_another_has_learned() {
    let lab = Lab::new();
    for (i, policy) in policies().iter().enumerate() {
        if policy.contains("initial_scale") {
            continue;
        }
        let (_, export) = lab.done(&format!("first {i}"), policy);
        // As a path from the experiment's folder.
        let path = export.strip_prefix(lab.0.path()).unwrap();
        let later = format!("{policy}\ninitial = '{}'", text(path));
        let file = lab.experiment("later", &later);
        lab.train(&file, &format!("later {i}"), &STILL).ends(DONE);
        for cell in ["xi=0.75/seed=1", "xi=1/seed=2"] {
            let run = lab.path(&format!("later {i}/cells")).join(cell);
            let [first, later] =
                [&export, &run.join("policy.safetensors")].map(|file| fs::read(file).unwrap());
            assert!(first == later, "{policy} {cell}");
        }
    }
}

/// Neither the run nor the file that it started from stays where it was.
#[test]
fn a_run_that_starts_from_another_goes_on_anywhere() {
    let lab = Lab::new();
    let (first, export) = lab.done("first", "kind = 'logistic'");
    let start = format!("kind = 'logistic'\ninitial = '{}'", text(&export));
    let file = lab.experiment("later", &start);
    lab.train(&file, "through", &[]).ends(DONE);
    lab.train(&file, "run", &["--stop-after", "5"]).ends(STOPPED);
    let settings = fs::read_to_string(lab.path("run/experiment.toml")).unwrap();
    assert!(settings.contains("initial = \"policies/xi-1-seed-2.safetensors\""), "{settings}");
    let copy = fs::read(lab.path("run/policies/xi-1-seed-2.safetensors")).unwrap();
    assert!(copy == fs::read(&export).unwrap());

    // The same command goes on; with another file in its place it's another run.
    lab.train(&file, "run", &["--stop-after", "1"]).ends(STOPPED);
    fs::copy(first.join("cells/xi=1/seed=1/policy.safetensors"), &export).unwrap();
    let before = tree(&lab.path("run"));
    lab.train(&file, "run", &[])
        .ends(FAILED)
        .complains(&["made differently:\n  policies/xi-1-seed-2.safetensors: XXH3 "]);
    assert_same(&tree(&lab.path("run")), &before);

    fs::remove_dir_all(&first).unwrap();
    let moved = lab.path("elsewhere");
    fs::rename(lab.path("run"), &moved).unwrap();
    itarl(&["resume", text(&moved)]).ends(DONE);
    assert_same(&results(&moved), &results(&lab.path("through")));
    itarl(&["resume", text(&moved), "--updates", "14"]).ends(DONE);
    itarl(&["status", text(&moved)]).ends(DONE).prints(&["14/14"]);

    // What it goes on from is its copy, and checked.
    let copy = moved.join("policies/xi-1-seed-2.safetensors");
    let mut bytes = fs::read(&copy).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&copy, bytes).unwrap();
    itarl(&["resume", text(&moved)])
        .ends(FAILED)
        .complains(&[text(&copy), "damaged: it isn't what the run was made with"]);
    fs::remove_file(&copy).unwrap();
    itarl(&["resume", text(&moved)]).ends(FAILED).complains(&[text(&copy), "damaged: missing"]);
    // Readers have no use for it.
    itarl(&["status", text(&moved)]).ends(DONE);
    itarl(&["rollout", text(&moved.join("cells/xi=1/seed=1")), "--steps", "5"]).ends(DONE);
}

#[test]
fn files_to_start_from_can_be_swept() {
    let lab = Lab::new();
    let (_, a) = lab.done("a", "kind = 'logistic'");
    let (_, b) = lab.done("b", "kind = 'logistic'\nmemory = 1");
    let sweeps = [
        format!("sweep.policy.initial=['{}', '{}']", text(&a), text(&a).replace("=2/", "=1/")),
        format!(
            "sweep.policy=[{{ label = 'none' }}, {{ initial = '{}' }}, \
             {{ initial = '{}', memory = 1 }}]",
            text(&a),
            text(&b)
        ),
    ];
    let names = [
        &["initial=xi-1-seed-2", "initial=xi-1-seed-1"][..],
        &["policy=none", "policy=initial-xi-1-seed-2", "policy=initial-xi-1-seed-2-2-memory-1"],
    ];
    let file = lab.experiment("x", "kind = 'logistic'");
    for (i, (sweep, names)) in sweeps.iter().zip(names).enumerate() {
        let run = lab.path(&format!("run {i}"));
        let words = ["--set", sweep, "--set", "sweep.seeds=1", "--set", "learning.updates=2"];
        lab.train(&file, &format!("run {i}"), &words).ends(DONE);
        for name in names {
            let cell = run.join(format!("cells/xi=1,{name}/seed=1"));
            assert!(cell.join("policy.safetensors").exists(), "{}", cell.display());
        }
        itarl(&["resume", text(&run), "--updates", "3"]).ends(DONE);
    }
}

#[test]
fn what_cannot_be_started_from_is_refused_before_anything_is_begun() {
    let lab = Lab::new();
    let (run, export) = lab.done("first", "hidden_units = 3\nsamples = 8");
    let file = lab.experiment("x", "hidden_units = 4\nsamples = 8");
    let refused = |more: &[&str], messages: &[&str]| {
        lab.train(&file, "run", more).ends(FAILED).complains(messages);
        assert!(!lab.path("run").exists(), "{more:?}");
    };
    let from = |path: &Path| format!("policy.initial='{}'", text(path));
    let set = from(&export);
    let place = format!("policy.initial: {}: another policy's parameters: ", text(&export));
    refused(&["--set", &set], &[&place, "V: [3, 3] there, [4, 3] here; W: [3, 2] there, [4, 2]"]);
    let memory = ["--set", "policy={ hidden_units = 3, memory = 1 }", "--set", &set];
    refused(&memory, &[&place, "V: [3, 3] there, [3, 6] here"]);

    let logistic = lab.experiment("logistic", "kind = 'logistic'");
    let said = lab.train(&logistic, "run", &["--set", &set]).ends(FAILED);
    said.complains(&[&place, "there, "]);
    let (_, other) = lab.done("modular", "kind = 'modular'");
    let set = from(&other);
    lab.train(&logistic, "run", &["--set", &set])
        .ends(FAILED)
        .complains(&["setting xi=0.75", "kind: modular there, logistic here"]);
    assert!(!lab.path("run").exists());

    let damaged = lab.path("damaged");
    fs::write(&damaged, &fs::read(&export).unwrap()[..50]).unwrap();
    refused(&["--set", &from(&damaged)], &[text(&damaged), "safetensors: the file must be"]);
    let nowhere = lab.path("nowhere");
    refused(&["--set", &from(&nowhere)], &[text(&nowhere), ": can't be read: No such file"]);
    refused(&["--set", &from(&nowhere), "--list"], &[text(&nowhere)]);
    refused(&["--set", &from(&run)], &[text(&run), ": a file expected, as a cell's policy"]);
    refused(&["--set", &from(Path::new("/dev/zero"))], &["/dev/zero: a file expected"]);
}

/// The crawler of the other tests has no groups.
#[test]
fn a_policy_of_groups_needs_some() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    for (set, message) in [
        ("policy={ kind = 'modular' }", "policy.kind: modular, but 'shoulder' is in no group"),
        (
            "policy={ connectivity = 'per_group' }",
            "policy.connectivity: per_group, but 'shoulder' is in no group",
        ),
        (
            "policy={ connectivity = 'per_actuator', inputs = 'own_group' }",
            "policy.inputs: own_group, but 'shoulder' is in no group",
        ),
    ] {
        train(&run, &["--set", set]).ends(FAILED).complains(&["setting xi=0.75", message]);
        assert!(!run.exists(), "{set}");
    }
}
