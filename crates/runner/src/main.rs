//! `itarl`: the lab's command line.

#![forbid(unsafe_code)]

use std::{io, process::ExitCode};

use clap::Parser;
use runner::{cli::Cli, commands, progress::tell};

fn main() -> ExitCode {
    match commands::run(Cli::parse().command) {
        Ok(outcome) => outcome.into(),
        // Whoever reads our output has had enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            tell(format_args!("{error:#}"));
            ExitCode::FAILURE
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let broken = |cause: &(dyn std::error::Error + 'static)| {
        cause.downcast_ref::<io::Error>().is_some_and(|it| it.kind() == io::ErrorKind::BrokenPipe)
    };
    error.chain().any(broken)
}
