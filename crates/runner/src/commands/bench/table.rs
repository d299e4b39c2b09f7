//! `itarl bench --table`: how cost grows as work grows, over robots, cells that are stepped together,
//! hidden units, and cores.

use std::{
    num::NonZero,
    path::Path,
    sync::Barrier,
    thread,
    time::{Duration, Instant},
};

use anyhow::Context;
use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};
use config::Document;
use serde::Serialize;
use svenja::Morphology;

use super::{
    batch::{Batch, Speed},
    from_file, papers, papers_with, sessions,
};
use crate::{
    cli::Bench,
    commands::{Outcome, json::print_json, print_line},
    experiment::Experiment,
    models,
    session::Solver,
};

const CELLS: [usize; 5] = [1, 2, 4, 8, 16];
const HIDDEN_UNITS: [usize; 3] = [50, 200, 800];

/// What is measured: so many cells on each of so many threads.
struct Work<'a> {
    name: &'a str,
    /// The hidden units, where they are what is changed.
    hidden_units: Option<usize>,
    experiment: &'a Experiment,
    morphology: &'a Morphology,
    cells: usize,
    threads: usize,
}

/// A row of the table, as `--json` prints it.
#[derive(Serialize)]
struct Row {
    name: String,
    hidden_units: Option<usize>,
    threads: usize,
    /// On each thread.
    cells: usize,
    /// Of all threads.
    control_steps_per_second: f64,
    physics_us: f64,
    policy_us: f64,
    rest_us: f64,
    /// What a cell's state takes, as a checkpoint holds it without its recording.
    state_bytes: usize,
}

/// The table of each file, or of the paper's settings and, for Svenja, of other numbers of hidden units.
pub(super) fn table(arguments: &Bench, length: Duration) -> anyhow::Result<Outcome> {
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let mut rows = Vec::new();
    let subjects = subjects(arguments)?;
    for (name, experiment, morphology) in &subjects {
        let one = Work { name, hidden_units: None, experiment, morphology, cells: 1, threads: 1 };
        for cells in CELLS {
            rows.push(measure(&Work { cells, ..one }, length)?);
        }
        if cores > 1 {
            rows.push(measure(&Work { cells: CELLS[4], threads: cores, ..one }, length)?);
        }
    }
    if arguments.files.is_empty() {
        for hidden_units in HIDDEN_UNITS {
            let (experiment, morphology) =
                papers_with(&format!("policy.hidden_units = {hidden_units}"))?;
            let work = Work {
                name: "Svenja",
                hidden_units: Some(hidden_units),
                experiment: &experiment,
                morphology: &morphology,
                cells: CELLS[4],
                threads: 1,
            };
            rows.push(measure(&work, length)?);
        }
    }
    if arguments.print.json {
        rows.iter().try_for_each(|row| print_json("bench --table", row))?;
    } else {
        print_line(drawn(&rows))?;
    }
    Ok(Outcome::Done)
}

/// A name, an experiment and its robot.
type Subject = (String, Experiment, Morphology);

fn subjects(arguments: &Bench) -> anyhow::Result<Vec<Subject>> {
    if arguments.files.is_empty() {
        let (experiment, morphology) = papers()?;
        return Ok(vec![("Svenja".to_owned(), experiment, morphology)]);
    }
    arguments.files.iter().map(|file| subject(file)).collect()
}

/// An experiment, whose first cell is measured, or a robot with the paper's settings.
fn subject(file: &Path) -> anyhow::Result<Subject> {
    let name = file.file_stem().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
    let is_experiment = !formats::is_foreign(file)
        && config::read_text(file)?
            .parse::<toml::Table>()
            .is_ok_and(|table| table.contains_key("model"));
    if is_experiment {
        let (experiment, morphology) = from_file(file)?;
        return Ok((name, experiment, morphology));
    }
    let morphology = models::open_model(file)?;
    let text = format!("model = {}", toml::Value::String(file.display().to_string()));
    let experiment = Document::parse("defaults", &text)?.read(Experiment::read)?;
    Ok((name, experiment, morphology))
}

fn measure(work: &Work<'_>, length: Duration) -> anyhow::Result<Row> {
    let together = Barrier::new(work.threads);
    let results: Vec<_> = thread::scope(|scope| {
        let start = || scope.spawn(|| on_a_thread(work, length, &together));
        let threads: Vec<_> = (0..work.threads).map(|_| start()).collect();
        threads.into_iter().map(thread::ScopedJoinHandle::join).collect()
    });
    let mut speeds = Vec::new();
    let mut state_bytes = 0;
    for result in results {
        let (speed, bytes) =
            result.map_err(|_| anyhow::anyhow!("a thread that measured panicked"))??;
        speeds.push(speed);
        state_bytes = bytes;
    }
    let mean = |of: fn(&Speed) -> f64| speeds.iter().map(of).sum::<f64>() / speeds.len() as f64;
    Ok(Row {
        name: work.name.to_owned(),
        hidden_units: work.hidden_units,
        threads: work.threads,
        cells: work.cells,
        control_steps_per_second: speeds.iter().map(|it| it.control_steps_per_second).sum(),
        physics_us: mean(|it| it.physics_us),
        policy_us: mean(|it| it.policy_us),
        rest_us: mean(|it| it.rest_us),
        state_bytes,
    })
}

/// What control steps take while the other threads make theirs, and the bytes of a cell's state.
fn on_a_thread(
    work: &Work<'_>,
    length: Duration,
    together: &Barrier,
) -> anyhow::Result<(Speed, usize)> {
    let begin = || -> anyhow::Result<(Batch, usize)> {
        let mut sessions = sessions(work.experiment, work.morphology, work.cells)?;
        let first = sessions.first_mut().context("no cells")?;
        let bytes = first.save()?.values().map(Vec::len).sum();
        Ok((Batch::begin(Solver::lockstep()?, sessions)?, bytes))
    };
    let begun = begin();
    // Whoever failed, too: the others wait for all.
    together.wait();
    let (mut batch, bytes) = begun?;
    let start = Instant::now();
    while start.elapsed() < length {
        batch.run()?;
    }
    Ok((batch.speed(), bytes))
}

fn drawn(rows: &[Row]) -> Table {
    let mut table = Table::new();
    table.load_preset(ASCII_MARKDOWN).set_header([
        "robot",
        "hidden units",
        "threads",
        "cells on each",
        "control steps/s",
        "us a control step: physics",
        "policy",
        "rest",
        "state of a cell, MB",
    ]);
    for row in rows {
        table.add_row([
            row.name.clone(),
            row.hidden_units.map_or_else(String::new, |n| n.to_string()),
            row.threads.to_string(),
            row.cells.to_string(),
            format!("{:.0}", row.control_steps_per_second),
            format!("{:.0}", row.physics_us),
            format!("{:.0}", row.policy_us),
            format!("{:.0}", row.rest_us),
            format!("{:.2}", row.state_bytes as f64 / 1e6),
        ]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
