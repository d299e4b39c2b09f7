//! `itarl export`: a run's curves for other programs.

use std::{
    fs::File,
    io::{self, Read},
    path::{Path, PathBuf},
    sync::atomic::{AtomicUsize, Ordering},
};

use anyhow::{Context, bail};
use figures::Omitted;
use runs::{atomic, make_folder, parallel};

use super::{Outcome, joined, print_line};
use crate::{
    catalogue::{Catalogue, RunCell},
    cli::Export,
    comparison::Comparison,
    progress::{Counter, notify},
    tensorboard::{FILE_NAME, event_file, head},
};

/// A cell, its run, and the folder that its event file comes into.
type Place<'a> = (usize, &'a RunCell, PathBuf);

/// What became of a cell.
enum Exported {
    Written,
    /// It has no update yet.
    Nothing,
    /// It can't be read.
    Omitted(Omitted),
}

pub(super) fn export(arguments: &Export) -> anyhow::Result<Outcome> {
    let Export { runs, tensorboard: out } = arguments;
    let counter = Counter::new(joined(runs));
    let comparison = Comparison::open(runs)?;
    let places = places(&comparison, out);
    // All of them before the first is written.
    places.iter().try_for_each(|(_, cell, folder)| require_own(cell, &folder.join(FILE_NAME)))?;
    let n_done = AtomicUsize::new(0);
    let exported = parallel::map(&places, |place| {
        let exported = write(&comparison, place);
        let done = n_done.fetch_add(1, Ordering::Relaxed) + 1;
        counter.report(done, places.len(), "cells exported");
        exported
    });
    let (mut n_written, mut n_omitted) = (0, 0);
    for it in exported {
        match it? {
            Exported::Written => n_written += 1,
            Exported::Nothing => {}
            Exported::Omitted(omitted) => {
                n_omitted += 1;
                counter.aside(|| notify(omitted));
            }
        }
    }
    if n_written == 0 {
        bail!("{}: no cell has an update that can be read", joined(runs));
    }
    let of = if n_written < places.len() { format!(" of {}", places.len()) } else { String::new() };
    let out = out.display();
    print_line(format_args!(
        "{out}: {n_written}{of} cells; to see them: tensorboard --logdir {out}"
    ))?;
    Ok(if n_omitted == 0 { Outcome::Done } else { Outcome::Failed })
}

/// Each cell below the folder, as in its run; of several runs by what tells their settings apart.
fn places<'a>(comparison: &'a Comparison, out: &Path) -> Vec<Place<'a>> {
    let of_run = |(run, catalogue): (usize, &'a Catalogue)| {
        catalogue.cells().iter().map(move |cell| {
            let setting = comparison.named(run, &cell.cell.setting);
            (run, cell, out.join(setting).join(format!("seed={}", cell.cell.seed)))
        })
    };
    comparison.catalogues().iter().enumerate().flat_map(of_run).collect()
}

/// That nothing is overwritten but what was made of this cell.
fn require_own(cell: &RunCell, path: &Path) -> anyhow::Result<()> {
    let head = head(cell);
    let mut found = Vec::new();
    let read = match File::open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        opened => opened.and_then(|it| it.take(head.len() as u64).read_to_end(&mut found)),
    };
    read.with_context(|| format!("{}: reading what is there", path.display()))?;
    if found != head {
        bail!(
            "{}: it wasn't made of this cell, and is left as it is: remove it, or choose another folder",
            path.display()
        );
    }
    Ok(())
}

fn write(comparison: &Comparison, (run, cell, folder): &Place<'_>) -> anyhow::Result<Exported> {
    let rows = match comparison.catalogues()[*run].rows(cell) {
        Ok(rows) => rows,
        Err(error) => {
            let omitted = Omitted::new(cell.cell.folder().display(), error);
            return Ok(Exported::Omitted(comparison.of_run(*run, omitted)));
        }
    };
    if rows.is_empty() {
        return Ok(Exported::Nothing);
    }
    make_folder(folder)?;
    atomic::write(&folder.join(FILE_NAME), &event_file(cell, &rows))?;
    Ok(Exported::Written)
}
