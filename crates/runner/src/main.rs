//! `itarl`: the lab's command line.

#![forbid(unsafe_code)]

use std::{io, process::ExitCode, sync::Arc};

use anyhow::Context;
use clap::Parser;
use runner::{
    cli::{Cli, complete},
    commands,
    progress::notify,
};
use signal_hook::{consts::SIGXFSZ, flag};

fn main() -> ExitCode {
    complete::answer();
    match run() {
        Ok(code) => code,
        // Whoever reads our output has had enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            notify(format_args!("{error:#}"));
            ExitCode::FAILURE
        }
    }
}

fn run() -> anyhow::Result<ExitCode> {
    // A file that grows to a limit of the shell's (`ulimit -f`) is then an error like a full disk, and
    // not the end without a word.
    flag::register(SIGXFSZ, Arc::default()).context("catching SIGXFSZ")?;
    match Cli::try_parse() {
        Ok(cli) => Ok(commands::run(cli.command)?.into()),
        Err(usage) => {
            let printed = usage.print();
            if !usage.use_stderr() {
                printed.context("standard output: writing")?;
            }
            Ok(u8::try_from(usage.exit_code()).map_or(ExitCode::FAILURE, ExitCode::from))
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let broken = |cause: &(dyn std::error::Error + 'static)| {
        cause.downcast_ref::<io::Error>().is_some_and(|it| it.kind() == io::ErrorKind::BrokenPipe)
    };
    error.chain().any(broken)
}
