//! `itarl completions`: what makes a shell ask the program how a line may go on.

use anyhow::Context;
use clap_complete::Shell;

use super::{Outcome, print};
use crate::cli::complete;

pub(super) fn completions(shell: Shell) -> anyhow::Result<Outcome> {
    print(&complete::script(&shell.to_string()).context("making the completions")?)?;
    Ok(Outcome::Done)
}
