//! `itarl train`, `itarl resume` and `itarl cell`.

use std::{
    collections::BTreeSet,
    num::NonZero,
    path::{Path, PathBuf},
    thread,
};

use anyhow::bail;
use bullet::LockstepCounts;
use runs::{Run, require_locks};

use super::{Outcome, open, print_line};
use crate::{
    cli::{Cell, Cells, Resume, Train, Until, Which, Work},
    experiment::Plan,
    progress::{self, notify},
    training::{
        Ending, How, Limits, OpenRun, RunCell, StopSignal, check_files, time_limit, train_all,
    },
};

pub(super) fn train(arguments: &Train) -> anyhow::Result<Outcome> {
    let plan = open(&arguments.experiment)?;
    if arguments.list {
        check_files(&plan)?;
        return list(&plan, arguments.out.as_deref());
    }
    let out = arguments.out.clone().unwrap_or_else(|| default_folder(&arguments.experiment.file));
    work(&OpenRun::begin(&plan, &out)?, &arguments.work)
}

/// The cells with their numbers: those of the run, if it's there, whose later cells are behind the
/// first, wherever the experiment has them.
fn list(plan: &Plan, out: Option<&Path>) -> anyhow::Result<Outcome> {
    let line = |index: usize, setting: &str, seed: u64| {
        print_line(format_args!("{index}\t{setting}/seed={seed}"))
    };
    match out.filter(|out| out.join(runs::MANIFEST).exists()) {
        Some(out) => {
            let run = Run::open(out)?;
            let mut cells = run.manifest().cells.iter();
            cells.try_for_each(|cell| line(cell.index, &cell.setting, cell.seed))?;
        }
        None => plan.listing().try_for_each(|(index, setting, seed)| line(index, setting, seed))?,
    }
    Ok(Outcome::Done)
}

pub(super) fn resume(arguments: &Resume) -> anyhow::Result<Outcome> {
    let open_run = OpenRun::open(&arguments.run, arguments.updates)?;
    tell_what_begins(&open_run);
    work(&open_run, &arguments.work)
}

/// Before cells begin that nobody asked for by name: `itarl cell` began others, it may be.
fn tell_what_begins(open_run: &OpenRun) {
    let cells = open_run.cells();
    let (n, run) = (cells.len(), open_run.run().folder().display());
    let n_begun = cells.iter().filter(|cell| cell.folder.lock().exists()).count();
    if (1..n).contains(&n_begun) {
        notify(format_args!(
            "note: {n_begun} of {n} cells were begun so far, and this trains all {n}; one alone: \
             itarl cell {run}/experiment.toml --index N --out {run}"
        ));
    }
}

pub(super) fn cell(arguments: &Cell) -> anyhow::Result<Outcome> {
    let plan = open(&arguments.experiment)?;
    let indices = indices(&arguments.which, plan.cells().len())?;
    let open_run = OpenRun::begin(&plan, &arguments.out)?;
    let limits = Limits { stop_after: arguments.until.stop_after };
    let how = How { threads: 1, solver: arguments.solver, lanes: None, limits };
    let cells: Vec<_> = indices.into_iter().map(|index| &open_run.cells()[index]).collect();
    train_cells(&open_run, &cells, &how, &arguments.until)
}

/// The cells that are asked for, of `n`, each once.
fn indices(which: &Which, n: usize) -> anyhow::Result<BTreeSet<usize>> {
    let within = |argument: &str, index: usize| match index < n {
        true => Ok(index),
        false => bail!("{argument} must be a cell's number from 0 to {}, got {index}", n - 1),
    };
    if let Some(task) = which.task {
        return Ok(task.cells(n).collect());
    }
    let mut indices = BTreeSet::new();
    if let Some(index) = which.index {
        indices.insert(within("--index", index)?);
    }
    for &Cells { first, last } in &which.cells {
        indices.extend(first..=within("--cells", last)?);
    }
    Ok(indices)
}

/// runs/NAME for NAME.toml
pub(super) fn default_folder(file: &Path) -> PathBuf {
    Path::new("runs").join(file.file_stem().unwrap_or_default())
}

fn work(open_run: &OpenRun, work: &Work) -> anyhow::Result<Outcome> {
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let how = How {
        threads: work.threads.map_or(cores, usize::from),
        solver: work.solver,
        lanes: work.lanes.map(usize::from),
        limits: Limits { stop_after: work.until.stop_after },
    };
    train_cells(open_run, &open_run.cells().iter().collect::<Vec<_>>(), &how, &work.until)
}

fn train_cells(
    open_run: &OpenRun,
    cells: &[&RunCell],
    how: &How,
    until: &Until,
) -> anyhow::Result<Outcome> {
    // Once for all cells.
    require_locks(&open_run.run().manifest_path())?;
    let stop = StopSignal::at_signals()?;
    let asked = until.time;
    stop.after(move || time_limit(asked))?;
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
