//! `itarl check`: what is wrong with how a run's cells learn, since when, and what to try.

use comfy_table::{ContentArrangement, Table, presets::ASCII_MARKDOWN};
use figures::{KINDS, Symptom};
use serde::Serialize;

use super::{Outcome, joined, json::print_json, print_line};
use crate::{
    cli::Check,
    comparison::Comparison,
    health::{Patient, patients},
    progress::notify,
};

pub(super) fn check(arguments: &Check) -> anyhow::Result<Outcome> {
    let comparison = Comparison::open(&arguments.runs)?;
    let (patients, omitted) = patients(&comparison)?;
    omitted.iter().for_each(notify);
    let cells = comparison.catalogues().iter().map(|it| it.cells().len()).sum();
    if arguments.print.json {
        let symptoms = patients.iter().flat_map(one_by_one).collect();
        print_json("check", Report { run: joined(&arguments.runs), cells, symptoms })?;
    } else {
        print_all(&patients, cells)?;
    }
    let is_well = patients.is_empty() && omitted.is_empty();
    Ok(if is_well { Outcome::Done } else { Outcome::Failed })
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report<'a> {
    run: String,
    cells: usize,
    symptoms: Vec<Found<'a>>,
}

#[derive(Serialize)]
struct Found<'a> {
    setting: &'a str,
    seed: u64,
    symptom: &'a str,
    since: Option<u64>,
    found: &'a str,
    advice: &'a str,
}

fn one_by_one<'a>(Patient { setting, seed, symptoms }: &'a Patient) -> Vec<Found<'a>> {
    let one = |it: &'a Symptom| Found {
        setting,
        seed: *seed,
        symptom: it.kind.name,
        since: it.since,
        found: &it.found,
        advice: it.kind.advice,
    };
    symptoms.iter().map(one).collect()
}

/// A row for each symptom of each cell, then what to try, each once.
fn print_all(patients: &[Patient], cells: usize) -> anyhow::Result<()> {
    if patients.is_empty() {
        return print_line(format_args!("nothing is found in {cells} cells"));
    }
    let mut table = Table::new();
    table.load_preset(ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(["cell", "symptom", "since update", "what was found"]);
    for it in patients.iter().flat_map(one_by_one) {
        let since = it.since.map_or("-".into(), |it| it.to_string());
        let cell = format!("{}/seed={}", it.setting, it.seed);
        table.add_row([cell, it.symptom.into(), since, it.found.replace('\n', " ")]);
    }
    print_line(table)?;
    print_line(format_args!("{} of {cells} cells have a symptom. What to try:", patients.len()))?;
    let has = |name: &str| patients.iter().flat_map(one_by_one).any(|it| it.symptom == name);
    for kind in KINDS.iter().filter(|kind| has(kind.name)) {
        print_line(format_args!("  {}: {}", kind.name, kind.advice))?;
    }
    Ok(())
}
