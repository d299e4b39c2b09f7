//! Files read, written and compared.
#![allow(clippy::unwrap_used)]

mod documentation;
mod paths;
mod round_trips;
mod settings;
mod sweeps;

use std::fs;

use config::Document;

use super::{Experiment, Plan};

fn experiment(text: &str) -> Experiment {
    let read = Document::parse("f", text).and_then(|document| document.read(Experiment::read));
    read.unwrap_or_else(|problems| panic!("{problems}\n{text}"))
}

/// A file in a folder of its own, opened.
fn open(text: &str, overrides: &[&str]) -> Result<Plan, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.toml");
    fs::write(&file, text).unwrap();
    let overrides: Vec<_> = overrides.iter().map(|text| text.to_string()).collect();
    Plan::open(&file, &overrides)
        .map_err(|problems| problems.to_string().replace(&file.display().to_string(), "x.toml"))
}

fn plan(text: &str) -> Plan {
    open(text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"))
}

fn folders(plan: &Plan) -> Vec<String> {
    plan.cells().iter().map(|cell| cell.folder().display().to_string()).collect()
}
