//! `itarl train`, `itarl resume` and `itarl cell`.

use std::{
    num::NonZero,
    path::{Path, PathBuf},
    thread,
};

use anyhow::bail;

use super::{Outcome, say};
use crate::{
    cli::{Cell, Resume, Train, Work},
    experiment::Plan,
    progress::{self, tell},
    training::{Ending, Lab, Limits, Stop, train_all, train_cell},
};

pub(super) fn train(arguments: &Train) -> anyhow::Result<Outcome> {
    let file = &arguments.experiment.file;
    let plan = Plan::open(file, &arguments.experiment.set)?;
    if arguments.list {
        for (index, setting, seed) in plan.listing() {
            say(format_args!("{index}\t{setting}/seed={seed}"))?;
        }
        return Ok(Outcome::Done);
    }
    let out = arguments.out.clone().unwrap_or_else(|| default_folder(file));
    work(&Lab::begin(&plan, &out)?, &arguments.work)
}

pub(super) fn resume(arguments: &Resume) -> anyhow::Result<Outcome> {
    work(&Lab::open(&arguments.run, arguments.updates)?, &arguments.work)
}

pub(super) fn cell(arguments: &Cell) -> anyhow::Result<Outcome> {
    let plan = Plan::open(&arguments.experiment.file, &arguments.experiment.set)?;
    let (index, n) = (arguments.index, plan.cells().len());
    if index >= n {
        bail!("--index must be a cell's number from 0 to {}, got {index}", n - 1);
    }
    let lab = Lab::begin(&plan, &arguments.out)?;
    let cell = &lab.cells()[index];
    let observer = progress::observer(&lab, [cell]);
    let limits = Limits { stop_after: arguments.stop_after };
    let ending = train_cell(&lab, cell, limits, &Stop::at_signals()?, &*observer);
    observer.end(cell, &ending);
    drop(observer);
    report(&lab, &[(cell.folder.path(), &ending)])
}

/// runs/NAME for NAME.toml
fn default_folder(file: &Path) -> PathBuf {
    Path::new("runs").join(file.file_stem().unwrap_or_default())
}

fn work(lab: &Lab, work: &Work) -> anyhow::Result<Outcome> {
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let n_threads = work.threads.map_or(cores, usize::from);
    let limits = Limits { stop_after: work.stop_after };
    let stop = Stop::at_signals()?;
    let observer = progress::observer(lab, lab.cells());
    let endings = train_all(lab, n_threads, limits, &stop, &*observer);
    drop(observer);
    let folders = lab.cells().iter().map(|cell| cell.folder.path());
    report(lab, &folders.zip(&endings).collect::<Vec<_>>())
}

/// Says how it ended, and what to do next.
fn report(lab: &Lab, endings: &[(&Path, &Ending)]) -> anyhow::Result<Outcome> {
    let mut n_stopped = 0;
    let mut n_failed = 0;
    for (folder, ending) in endings {
        match ending {
            Ending::Done => {}
            Ending::Stopped => n_stopped += 1,
            Ending::Failed(reason) => {
                n_failed += 1;
                tell(format_args!("{}: failed: {reason}", folder.display()));
            }
            Ending::Broken(error) => {
                n_failed += 1;
                tell(format_args!("{error:#}"));
            }
        }
    }
    let run = lab.run().folder().display();
    let n_done = endings.len() - n_stopped - n_failed;
    say(format_args!(
        "{run}: {n_done} of {} cells done{}{}",
        endings.len(),
        if n_stopped > 0 {
            format!(", {n_stopped} to go on: itarl resume {run}")
        } else {
            String::new()
        },
        if n_failed > 0 { format!(", {n_failed} failed") } else { String::new() },
    ))?;
    Ok(match (n_failed, n_stopped) {
        (0, 0) => Outcome::Done,
        (0, _) => Outcome::Stopped,
        _ => Outcome::Failed,
    })
}
