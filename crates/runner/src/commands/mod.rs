//! What the commands do, one file each.

mod bench;
mod check;
mod completions;
mod config;
mod export;
mod findings;
mod import;
mod json;
mod landscape;
mod man;
mod merge;
mod model;
mod plot;
mod publish;
mod replay;
mod report;
mod rollout;
mod slurm;
mod status;
mod subject;
mod summary;
mod train;

use std::{
    io::{self, Write},
    path::PathBuf,
    process::ExitCode,
};

use ::config::{Problem, Problems};
use anyhow::Context;
use figures::plain;

use crate::{
    catalogue::Catalogue,
    cli::{Command, ExperimentFile},
    comparison::Comparison,
    experiment::Plan,
    progress::notify,
};

/// How a command ended, if it ran.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All is done.
    Done,
    /// Something failed, and was said.
    Failed,
    /// Stopped at a checkpoint; there is more to do.
    Stopped,
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Done => Self::SUCCESS,
            Outcome::Failed => Self::FAILURE,
            // EX_TEMPFAIL: try again.
            Outcome::Stopped => Self::from(75),
        }
    }
}

/// Runs a command.
///
/// # Errors
/// What ended it before its end.
pub fn run(command: Command) -> anyhow::Result<Outcome> {
    match command {
        Command::Train(arguments) => train::train(&arguments),
        Command::Resume(arguments) => train::resume(&arguments),
        Command::Cell(arguments) => train::cell(&arguments),
        Command::Status(arguments) => status::status(&arguments),
        Command::Merge(arguments) => merge::merge(&arguments),
        Command::Slurm(arguments) => slurm::slurm(&arguments),
        Command::Summary(arguments) => summary::summary(&arguments),
        Command::Plot(arguments) => plot::plot(&arguments),
        Command::Config(arguments) => config::config(arguments),
        Command::Check(arguments) => check::check(&arguments),
        Command::Findings { runs, until } => findings::findings(&runs, until),
        Command::Export(arguments) => export::export(&arguments),
        Command::Publish(arguments) => publish::publish(&arguments),
        Command::Rollout(arguments) => rollout::rollout(&arguments),
        Command::Landscape(arguments) => landscape::landscape(&arguments),
        Command::Report(arguments) => report::report(&arguments),
        Command::Replay(arguments) => replay::replay(&arguments),
        Command::Model(arguments) => model::model(&arguments),
        Command::Bench(arguments) => bench::bench(&arguments),
        Command::Man { out } => man::man(out.as_deref()),
        Command::Completions { shell } => completions::completions(shell),
    }
}

/// The plan of an experiment file; what is most likely not meant in it is said.
fn open(arguments: &ExperimentFile) -> Result<Plan, Problems> {
    let plan = Plan::open(&arguments.file, &arguments.set)?;
    for Problem { place, message } in plan.warnings() {
        notify(format_args!("{place}: warning: {message}"));
    }
    Ok(plan)
}

/// What a published run is, where the run is one.
fn published_note(catalogue: &Catalogue) -> Option<String> {
    let published = catalogue.run().manifest().published.as_ref()?;
    Some(match published.every {
        1 => "published, to be read: it has no checkpoints".into(),
        n => format!("published, to be read: a row is a mean over {n} updates; no checkpoints"),
    })
}

/// The same of several, with whose it is.
fn published_notes(comparison: &Comparison) -> Vec<String> {
    let note = |catalogue: &Catalogue| {
        let note = published_note(catalogue)?;
        Some(match comparison.alone() {
            Some(_) => note,
            None => format!("{}: {note}", catalogue.run().folder().display()),
        })
    };
    comparison.catalogues().iter().filter_map(note).collect()
}

/// What runs are called together, for whoever waits.
fn joined(folders: &[PathBuf]) -> String {
    folders.iter().map(|it| it.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// Prints a text and a line break.
fn print_line(text: impl std::fmt::Display) -> anyhow::Result<()> {
    print(format!("{}\n", plain(&text.to_string())).as_bytes())
}

fn print(bytes: &[u8]) -> anyhow::Result<()> {
    let mut out = io::stdout();
    out.write_all(bytes).and_then(|()| out.flush()).context("standard output: writing")
}
