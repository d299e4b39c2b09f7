//! `itarl publish`: what others need of a run, in a small folder.

use super::{Outcome, print_line, status::summary};
use crate::{
    cli::Publish,
    progress::{Counter, notify},
    publish,
};

pub(super) fn publish(arguments: &Publish) -> anyhow::Result<Outcome> {
    let Publish { run, out, every, recordings } = arguments;
    let counter = Counter::new(run.display().to_string());
    let progress = |done, total, what: &str| counter.report(done, total, what);
    let said = publish::publish(run, out, *every, *recordings, &progress)?;
    counter.aside(|| said.omitted.iter().for_each(notify));
    let (rows, cells) = (said.every, summary(&said.cells));
    let updates = if rows == 1 { "update" } else { "updates" };
    print_line(format_args!("{}: a row is a mean over {rows} {updates}; {cells}", out.display()))?;
    Ok(if said.omitted.is_empty() { Outcome::Done } else { Outcome::Failed })
}
