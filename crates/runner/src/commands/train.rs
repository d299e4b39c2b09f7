//! `itarl train`, `itarl resume` and `itarl cell`.

use std::{
    num::NonZero,
    path::{Path, PathBuf},
    thread,
};

use anyhow::bail;
use bullet::LockstepCounts;

use super::{Outcome, open, print_line};
use crate::{
    cli::{Cell, Resume, Train, Work},
    progress::{self, notify},
    training::{Ending, How, Limits, OpenRun, RunCell, StopSignal, check_files, train_all},
};

pub(super) fn train(arguments: &Train) -> anyhow::Result<Outcome> {
    let plan = open(&arguments.experiment)?;
    if arguments.list {
        check_files(&plan)?;
        for (index, setting, seed) in plan.listing() {
            print_line(format_args!("{index}\t{setting}/seed={seed}"))?;
        }
        return Ok(Outcome::Done);
    }
    let out = arguments.out.clone().unwrap_or_else(|| default_folder(&arguments.experiment.file));
    work(&OpenRun::begin(&plan, &out)?, &arguments.work)
}

pub(super) fn resume(arguments: &Resume) -> anyhow::Result<Outcome> {
    work(&OpenRun::open(&arguments.run, arguments.updates)?, &arguments.work)
}

pub(super) fn cell(arguments: &Cell) -> anyhow::Result<Outcome> {
    let plan = open(&arguments.experiment)?;
    let (index, n) = (arguments.index, plan.cells().len());
    if index >= n {
        bail!("--index must be a cell's number from 0 to {}, got {index}", n - 1);
    }
    let open_run = OpenRun::begin(&plan, &arguments.out)?;
    let limits = Limits { stop_after: arguments.stop_after };
    let how = How { threads: 1, solver: arguments.solver, lanes: None, limits };
    train_cells(&open_run, &[&open_run.cells()[index]], &how)
}

/// runs/NAME for NAME.toml
fn default_folder(file: &Path) -> PathBuf {
    Path::new("runs").join(file.file_stem().unwrap_or_default())
}

fn work(open_run: &OpenRun, work: &Work) -> anyhow::Result<Outcome> {
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let how = How {
        threads: work.threads.map_or(cores, usize::from),
        solver: work.solver,
        lanes: work.lanes.map(usize::from),
        limits: Limits { stop_after: work.stop_after },
    };
    train_cells(open_run, &open_run.cells().iter().collect::<Vec<_>>(), &how)
}

fn train_cells(open_run: &OpenRun, cells: &[&RunCell], how: &How) -> anyhow::Result<Outcome> {
    let stop = StopSignal::at_signals()?;
    let observer = progress::observer(open_run, cells.iter().copied());
    let trained = train_all(open_run, cells, how, &stop, &*observer);
    drop(observer);
    let trained = trained?;
    warn(&trained.counts);
    if let Some(error) = &trained.crowded {
        notify(format_args!("note: fewer cells were trained at a time: {error:#}{ADVICE}"));
    }
    let folders = cells.iter().map(|cell| cell.folder.path());
    report(open_run, &folders.zip(&trained.endings).collect::<Vec<_>>())
}

/// For whoever has too few open files.
const ADVICE: &str = ": ulimit -n has the limit of a process, fs.file-max that of the system";

/// Says so if lanes were little used, which nobody would see otherwise.
fn warn(counts: &LockstepCounts) {
    let own = counts.unsupported + counts.maybe_converged + counts.not_finite;
    let all = own + counts.swept;
    if own * 100 > all {
        notify(format_args!(
            "note: lanes didn't cover {:.0} % of the physics steps, which took Bullet's own solver: \
             the bits are the same, but it's slower ({} for rolling friction, {} for changes too \
             small to tell from none, {} for numbers that weren't finite)",
            100.0 * own as f64 / all as f64,
            counts.unsupported,
            counts.maybe_converged,
            counts.not_finite
        ));
    }
}

/// Says how it ended, and what to do next.
fn report(open_run: &OpenRun, endings: &[(&Path, &Ending)]) -> anyhow::Result<Outcome> {
    let (mut n_stopped, mut n_elsewhere, mut n_failed) = (0, 0, 0);
    for (folder, ending) in endings {
        match ending {
            Ending::Done => {}
            Ending::Stopped => n_stopped += 1,
            Ending::Elsewhere => n_elsewhere += 1,
            Ending::Crowded(error) => {
                n_stopped += 1;
                notify(format_args!("{error:#}{ADVICE}"));
            }
            Ending::Failed(reason) => {
                n_failed += 1;
                notify(format_args!("{}: failed: {reason}", folder.display()));
            }
            Ending::Broken(error) => {
                n_failed += 1;
                notify(format_args!("{error:#}"));
            }
        }
    }
    let run = open_run.run().folder().display();
    let n_done = endings.len() - n_stopped - n_elsewhere - n_failed;
    let mut said = format!("{run}: {n_done} of {} cells done", endings.len());
    if n_stopped > 0 {
        said += &format!(", {n_stopped} to go on: itarl resume {run}");
    }
    if n_elsewhere > 0 {
        said += &format!(", {n_elsewhere} elsewhere: another process is at work there");
    }
    if n_failed > 0 {
        said += &format!(", {n_failed} failed");
    }
    print_line(said)?;
    Ok(match (n_failed, n_stopped + n_elsewhere) {
        (0, 0) => Outcome::Done,
        (0, _) => Outcome::Stopped,
        _ => Outcome::Failed,
    })
}
