//! `itarl merge`: run folders put together into one.

use super::{Outcome, print_line};
use crate::{cli::Merge, merge};

pub(super) fn merge(arguments: &Merge) -> anyhow::Result<Outcome> {
    let folders: Vec<_> = arguments.runs.iter().map(AsRef::as_ref).collect();
    let merge::Merged { cells, begun } = merge::merge(&folders, &arguments.out)?;
    let out = arguments.out.display();
    print_line(format_args!("{out}: {begun} of {cells} cells are from {} runs", folders.len()))?;
    Ok(Outcome::Done)
}
