//! `itarl report`: a run as one page, or several that are compared.

use std::path::PathBuf;

use runs::atomic;

use super::{Outcome, joined, print_line};
use crate::{
    cli,
    progress::{Counter, notify},
    report::Report,
};

pub(super) fn report(arguments: &cli::Report) -> anyhow::Result<Outcome> {
    let counter = Counter::new(joined(&arguments.runs));
    let progress = |done, total, what: &str| counter.report(done, total, what);
    let report = Report::read(&arguments.runs, &progress)?;
    let text = report.html(&progress)?;
    let path = arguments.out.clone().unwrap_or_else(|| match &arguments.runs[..] {
        [run] => run.join("report.html"),
        _ => PathBuf::from("comparison.html"),
    });
    atomic::write(&path, text.as_bytes())?;
    report.omitted().iter().for_each(notify);
    print_line(path.display())?;
    Ok(if report.omitted().is_empty() { Outcome::Done } else { Outcome::Failed })
}
