//! What the commands do, one file each.

mod bench;
mod model;
mod plot;
mod replay;
mod report;
mod rollout;
mod settings;
mod status;
mod subject;
mod summary;
mod train;

use std::{
    io::{self, Write},
    process::ExitCode,
};

use clap::CommandFactory;

use crate::{
    cli::{Cli, Command},
    plain::plain,
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
        Command::Status { run } => status::status(&run),
        Command::Summary(arguments) => summary::summary(&arguments),
        Command::Plot(arguments) => plot::plot(&arguments),
        Command::Config { experiment } => settings::config(&experiment),
        Command::Rollout(arguments) => rollout::rollout(&arguments),
        Command::Report { run } => report::report(&run),
        Command::Replay(arguments) => replay::replay(&arguments),
        Command::Model(arguments) => model::model(&arguments),
        Command::Bench(arguments) => bench::bench(&arguments),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "itarl", &mut script);
            io::stdout().write_all(&script)?;
            Ok(Outcome::Done)
        }
    }
}

/// Prints a text and a line break.
fn say(text: impl std::fmt::Display) -> io::Result<()> {
    writeln!(io::stdout(), "{}", plain(&text.to_string()))
}
