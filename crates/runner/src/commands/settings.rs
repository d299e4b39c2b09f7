//! `itarl config`: the complete settings of an experiment file.

use super::{Outcome, say};
use crate::{cli::ExperimentFile, experiment::Plan};

pub(super) fn config(arguments: &ExperimentFile) -> anyhow::Result<Outcome> {
    say(Plan::open(&arguments.file, &arguments.set)?.to_toml().trim_end())?;
    Ok(Outcome::Done)
}
