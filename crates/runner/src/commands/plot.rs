//! `itarl plot`: the figures of a run and their tables, into its folder `plots/`.

use std::{collections::BTreeSet, fs, path::Path};

use anyhow::Context;

use super::{Outcome, say};
use crate::{
    cli::{Format, Plot},
    plots::{self, Drawing, Error, FIGURES, Figure, Options, Run},
    progress::{Counter, tell},
    store::atomic,
};

pub(super) fn plot(arguments: &Plot) -> anyhow::Result<Outcome> {
    let counter = Counter::new(arguments.run.display().to_string());
    let (run, omitted) =
        Run::read(&arguments.run, &|done, total| counter.report(done, total, "cells read"))?;
    omitted.iter().for_each(tell);

    let folder = arguments.run.join("plots");
    fs::create_dir_all(&folder).with_context(|| format!("{}: making it", folder.display()))?;
    let options = Options { settings: arguments.settings.clone(), two_best: arguments.two_best };
    let is_asked = |figure: &&Figure| arguments.figures.iter().any(|name| name == figure.name);
    let all = arguments.figures.is_empty();
    let figures: Vec<_> = FIGURES.iter().filter(|figure| all || is_asked(figure)).collect();

    let mut is_missing = false;
    for (i, figure) in figures.iter().enumerate() {
        match plots::draw(&run, figure, &options) {
            Ok(drawing) => write(&folder, &drawing, &arguments.format)?,
            // There may be none of this robot; asked for by name, it's missed.
            Err(error @ Error::Nothing { .. }) if all => tell(format_args!("skipped {error}")),
            Err(error @ Error::Nothing { .. }) => {
                is_missing = true;
                tell(error);
            }
            Err(error) => return Err(error.into()),
        }
        for table in figure.tables(&run) {
            write_file(&folder.join(format!("{}.csv", table.name)), &table.csv())?;
        }
        counter.report(i + 1, figures.len(), "figures drawn");
    }
    Ok(if omitted.is_empty() && !is_missing { Outcome::Done } else { Outcome::Failed })
}

fn write(folder: &Path, drawing: &Drawing, formats: &[Format]) -> anyhow::Result<()> {
    // Each once, however often it's asked for.
    let formats: BTreeSet<_> = formats.iter().collect();
    for format in formats {
        let stem = drawing.file_stem;
        match format {
            Format::Svg => {
                write_file(&folder.join(format!("{stem}.svg")), drawing.svg.as_bytes())?;
            }
            Format::Png => write_file(&folder.join(format!("{stem}.png")), &drawing.png()?)?,
        }
    }
    Ok(())
}

fn write_file(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    atomic::write(path, bytes)?;
    say(path.display())?;
    Ok(())
}
