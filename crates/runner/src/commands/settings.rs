//! `itarl config`: the complete settings of an experiment file.

use super::{Outcome, open, say};
use crate::cli::ExperimentFile;

pub(super) fn config(arguments: &ExperimentFile) -> anyhow::Result<Outcome> {
    say(open(arguments)?.to_toml().trim_end())?;
    Ok(Outcome::Done)
}
