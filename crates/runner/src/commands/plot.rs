//! `itarl plot`: the figures of a run and their tables, into its folder `plots/`; or those of several runs,
//! each in all of them.

use std::{collections::BTreeSet, fs, path::PathBuf};

use anyhow::{Context, bail};
use figures::{Error, FIGURES, Figure, Options, Results};
use runs::atomic;

use super::{Outcome, joined, print_line};
use crate::{
    cli::{Format, Plot, Shown},
    comparison::Comparison,
    progress::{Counter, notify},
};

pub(super) fn plot(arguments: &Plot) -> anyhow::Result<Outcome> {
    let (runs, asked) = sorted_out(&arguments.shown)?;
    let counter = Counter::new(joined(&runs));
    let comparison = Comparison::open(&runs)?.until(arguments.until);
    let (results, omitted) =
        comparison.results(&|done, total| counter.report(done, total, "cells read"))?;
    counter.aside(|| omitted.iter().for_each(notify));

    let folder = arguments.out.clone().unwrap_or_else(|| match &runs[..] {
        [run] => run.join("plots"),
        _ => PathBuf::from("comparison"),
    });
    fs::create_dir_all(&folder).with_context(|| format!("{}: making it", folder.display()))?;
    // Each once, however often it's asked for.
    let formats: BTreeSet<_> = arguments.format.iter().copied().collect();
    let options = Options { settings: arguments.settings.clone(), two_best: arguments.two_best };
    let is_asked = |figure: &&Figure| asked.contains(&figure.name);
    let all = asked.is_empty();
    let figures: Vec<_> = FIGURES.iter().filter(|figure| all || is_asked(figure)).collect();

    let mut is_missing = false;
    for (i, figure) in figures.iter().enumerate() {
        let (files, missing) = files(&results, figure, &options, &formats)?;
        if let Some(why) = missing {
            // A robot may have none of this; asked for by name, it's missed.
            is_missing |= !all;
            counter.aside(|| notify(format_args!("left out {why}")));
        }
        for (name, bytes) in files {
            let path = folder.join(name);
            atomic::write(&path, &bytes)?;
            counter.aside(|| print_line(path.display()))?;
        }
        counter.report(i + 1, figures.len(), "figures drawn");
    }
    Ok(if omitted.is_empty() && !is_missing { Outcome::Done } else { Outcome::Failed })
}

/// The runs and the figures that are named, as they come.
fn sorted_out(shown: &[Shown]) -> anyhow::Result<(Vec<PathBuf>, Vec<&'static str>)> {
    let (mut runs, mut figures) = (Vec::new(), Vec::new());
    for it in shown {
        match it {
            Shown::Run(folder) => runs.push(folder.clone()),
            Shown::Figure(name) => figures.push(*name),
        }
    }
    if runs.is_empty() {
        bail!("a run's folder expected, got figures alone: {}", figures.join(", "));
    }
    Ok((runs, figures))
}

/// A file's name and bytes.
type File = (String, Vec<u8>);

/// What belongs to a figure, and why it's not drawn itself if this run has nothing to show in it.
fn files(
    results: &Results,
    figure: &Figure,
    options: &Options,
    formats: &BTreeSet<Format>,
) -> Result<(Vec<File>, Option<Error>), Error> {
    let mut files = Vec::new();
    let mut missing = None;
    match figures::draw(results, figure, options) {
        Ok(drawing) => {
            for format in formats {
                let (extension, bytes) = match format {
                    Format::Svg => ("svg", drawing.svg.clone().into_bytes()),
                    Format::Png => ("png", drawing.png()?),
                };
                files.push((format!("{}.{extension}", drawing.file_stem), bytes));
            }
        }
        Err(error @ Error::Nothing { .. }) => missing = Some(error),
        Err(error) => return Err(error),
    }
    let tables = figure.tables(results);
    files.extend(tables.iter().map(|table| (format!("{}.csv", table.name), table.csv())));
    Ok((files, missing))
}
