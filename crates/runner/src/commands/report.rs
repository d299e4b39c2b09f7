//! `itarl report`: a run as one page.

use std::path::Path;

use runs::atomic;

use super::{Outcome, print_line};
use crate::{
    progress::{Counter, notify},
    report::Report,
};

pub(super) fn report(folder: &Path) -> anyhow::Result<Outcome> {
    let counter = Counter::new(folder.display().to_string());
    let progress = |done, total, what: &str| counter.report(done, total, what);
    let report = Report::read(folder, &progress)?;
    let text = report.html(&progress)?;
    let path = folder.join("report.html");
    atomic::write(&path, text.as_bytes())?;
    report.omitted().iter().for_each(notify);
    print_line(path.display())?;
    Ok(if report.omitted().is_empty() { Outcome::Done } else { Outcome::Failed })
}
