//! What others need of a run, put into a small folder.
//!
//! The folder is read before it has its name, as everybody will read it: what's chosen of the curves,
//! as the best and the median cell of each setting, is chosen of the published ones.

use std::path::Path;

use anyhow::bail;
use figures::{Omitted, best_and_median};
use runs::{CellStatus, Look, Publication, Recording, Row};

use crate::{
    catalogue::{Catalogue, RunCell},
    report::Progress,
};

/// Rows that a cell has at most, if nothing else is asked for.
const ROWS: u64 = 300;

/// What all recordings together may take, in kB, if nothing else is asked for. Of five settings that's half
/// a minute of each robot.
pub const RECORDINGS_KB: u64 = 5000;

/// What was published.
#[derive(Debug)]
pub struct Said {
    /// Updates that a row is the mean of.
    pub every: u64,
    /// Where the cells stood.
    pub cells: Vec<CellStatus>,
    /// What couldn't be read.
    pub omitted: Vec<Omitted>,
}

/// Publishes a run, finished or not: its cells with means over `every` updates, by default so many that
/// the longest has up to 300 rows, and the recordings of each setting's best and median cell, of which
/// all together have up to `recordings_kb`, or a control step each.
///
/// # Errors
/// A folder that is no run, or itself published; something at the new folder's place; no cell that has
/// a row; what can't be written. There's then nothing at the place.
pub fn publish(
    folder: &Path,
    out: &Path,
    every: Option<u64>,
    recordings_kb: u64,
    progress: &Progress<'_>,
) -> anyhow::Result<Said> {
    let catalogue = Catalogue::open(folder)?;
    if catalogue.run().manifest().published.is_some() {
        let folder = folder.display();
        bail!("{folder}: published already: copy it, or publish the run that it was made of");
    }
    let (cells, mut omitted) = read(&catalogue);
    let longest = cells.iter().map(|(_, rows)| rows.len() as u64).max().unwrap_or(0);
    if longest == 0 {
        bail!("{}: no cell has an update yet", folder.display());
    }
    let every = every.unwrap_or(longest.div_ceil(ROWS));
    if longest < every {
        bail!(
            "{}: no cell has the {every} updates that a row is to be the mean of: the longest has \
             {longest}",
            folder.display()
        );
    }
    let mut publication = Publication::begin(catalogue.run(), out, every)?;
    let measure = catalogue.measure();
    for (i, (cell, rows)) in cells.iter().enumerate() {
        let listed = &catalogue.run().manifest().cells[cell.cell.index];
        let completed: Vec<_> = rows.iter().map(|row| cell.completed(*row)).collect();
        let moments = measure.moments(&completed);
        publication.add(listed, &cell.folder, (rows, moments))?;
        progress(i + 1, cells.len(), "cells published");
    }
    omitted.extend(record(&catalogue, &mut publication, recordings_kb)?);
    let published = Catalogue::of(publication.finish()?)?;
    Ok(Said { every, cells: published.status(Look::Thorough), omitted })
}

/// The cells with their rows as they are, and what can't be read of them.
type Read<'a> = (Vec<(&'a RunCell, Vec<Row>)>, Vec<Omitted>);

fn read(catalogue: &Catalogue) -> Read<'_> {
    let (mut cells, mut omitted) = (Vec::new(), Vec::new());
    let rows = |cell: &RunCell| catalogue.expecting(cell, |expected| cell.folder.rows(expected));
    for (cell, rows) in catalogue.cells().iter().zip(runs::parallel::map(catalogue.cells(), rows)) {
        match rows {
            Ok(rows) => cells.push((cell, rows)),
            Err(error) => omitted.push(Omitted::new(cell.cell.folder().display(), error)),
        }
    }
    (cells, omitted)
}

/// Adds the recordings of each setting's best and median cell, their ends where they are too long;
/// gives those that can't be read.
fn record(
    from: &Catalogue,
    publication: &mut Publication,
    most_kb: u64,
) -> anyhow::Result<Vec<Omitted>> {
    let to = Catalogue::of(publication.run()?)?;
    let (results, mut omitted) = to.results(None, &|_, _| {})?;
    let mut wanted = Vec::new();
    for (setting, choice) in results.settings.iter().zip(best_and_median(&results)) {
        let mut chosen = vec![&setting.cells[choice.best], &setting.cells[choice.median]];
        chosen.dedup_by_key(|cell| cell.seed);
        wanted.extend(chosen);
    }
    let all_bytes = usize::try_from(most_kb.saturating_mul(1000)).unwrap_or(usize::MAX);
    let most_bytes = all_bytes / wanted.len().max(1);
    for cell in from.cells() {
        let name = cell.cell.folder().display().to_string();
        if wanted.iter().all(|it| it.name != name) {
            continue;
        }
        match Recording::read(&cell.folder.replay()) {
            Ok(None) => {}
            Ok(Some(recording)) => {
                let listed = &from.run().manifest().cells[cell.cell.index];
                publication.record(listed, &recording.fitting(most_bytes))?;
            }
            Err(error) => omitted.push(Omitted::new(name, error)),
        }
    }
    Ok(omitted)
}
