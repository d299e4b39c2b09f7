//! `itarl plot`: the figures of a run and their tables, into its folder `plots/`.

use std::{collections::BTreeSet, fs};

use anyhow::Context;
use figures::{Error, FIGURES, Figure, Options, Results};
use runs::atomic;

use super::{Outcome, print_line};
use crate::{
    catalogue::Catalogue,
    cli::{Format, Plot},
    progress::{Counter, notify},
};

pub(super) fn plot(arguments: &Plot) -> anyhow::Result<Outcome> {
    let counter = Counter::new(arguments.run.display().to_string());
    let catalogue = Catalogue::open(&arguments.run)?;
    let (results, omitted) =
        catalogue.results(&|done, total| counter.report(done, total, "cells read"))?;
    counter.aside(|| omitted.iter().for_each(notify));

    let folder = arguments.run.join("plots");
    fs::create_dir_all(&folder).with_context(|| format!("{}: making it", folder.display()))?;
    // Each once, however often it's asked for.
    let formats: BTreeSet<_> = arguments.format.iter().copied().collect();
    let options = Options { settings: arguments.settings.clone(), two_best: arguments.two_best };
    let is_asked = |figure: &&Figure| arguments.figures.iter().any(|name| name == figure.name);
    let all = arguments.figures.is_empty();
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
