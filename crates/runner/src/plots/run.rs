//! A run folder as figures need it: settings, their instances, columns of numbers.
//!
//! Only recorded files are read, and nothing is written. What can't be read is left out and named.

use std::{
    collections::BTreeSet,
    iter,
    num::NonZero,
    path::{Path, PathBuf},
    sync::atomic::{AtomicUsize, Ordering},
    thread,
};

use super::{Contacts, Error, Outcome, choice};
use crate::store::{self, Cell, CellFolder, Recording, Row};

/// Beyond it a number isn't one that learning gives, and its square has no place in an f64.
const LARGEST: f64 = 1e100;

/// What a run has recorded so far.
#[derive(Clone, Debug)]
pub struct Run {
    /// Its folder.
    pub folder: PathBuf,
    /// The settings that have an instance, in the order of the sweep.
    pub settings: Vec<Setting>,
    /// Updates of the first and of the last window, by which instances are judged: a tenth of those
    /// of the longest instance, at least 1.
    pub window: usize,
}

/// The instances of one setting.
#[derive(Clone, Debug)]
pub struct Setting {
    /// As its folder is named, `xi=0.75,power=2`.
    pub name: String,
    /// Those that have an update, in the order of their seeds in the experiment.
    pub instances: Vec<Instance>,
}

/// One training instance. Its columns have one value an update, at least one.
#[derive(Clone, Debug)]
pub struct Instance {
    /// As it's called, `xi=0.75/seed=3`.
    pub cell: String,
    /// Its seed.
    pub seed: u64,
    /// The cell's folder.
    pub folder: PathBuf,
    /// R, the reward that is optimised.
    pub reward: Vec<f64>,
    /// R_MI, nats for each variable.
    pub information_nats: Vec<f64>,
    /// R_Loc, metres for each control step.
    pub locomotion_m: Vec<f64>,
    /// What it came to.
    pub outcome: Outcome,
    /// The feet of the last control steps; only read for instances that [`best_and_median`] has.
    ///
    /// [`best_and_median`]: super::best_and_median
    pub contacts: Option<Contacts>,
}

/// Something that was left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Omitted {
    /// The cell, `xi=0.75/seed=3`.
    pub cell: String,
    /// Why: the file, what was expected and what was found.
    pub reason: String,
}

impl std::fmt::Display for Omitted {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}: left out: {}", self.cell, self.reason)
    }
}

impl Run {
    /// Reads a run folder, finished or not. `progress` is told how many of how many cells are read,
    /// from any thread.
    ///
    /// # Errors
    /// If there's no run, or no update in it yet.
    pub fn read(
        folder: &Path,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<(Self, Vec<Omitted>), Error> {
        let run = store::Run::open(folder)?;
        let cells = &run.manifest().cells;
        let mut omitted = Vec::new();
        let mut settings: Vec<Setting> = Vec::new();
        for (cell, read) in cells.iter().zip(read_all(&run, progress)) {
            let instance = match read {
                Ok(instance) => instance,
                Err(error) => {
                    omitted.push(Omitted { cell: cell.folder(), reason: error.to_string() });
                    None
                }
            };
            let Some(instance) = instance else { continue };
            match settings.iter_mut().find(|setting| setting.name == cell.setting) {
                Some(setting) => setting.instances.push(instance),
                None => {
                    settings.push(Setting { name: cell.setting.clone(), instances: vec![instance] })
                }
            }
        }
        if settings.is_empty() {
            return Err(Error::Empty { folder: folder.into(), omitted });
        }
        let mut read = Self { folder: folder.into(), settings, window: 1 };
        Outcome::judge(&mut read);
        read.read_contacts(&mut omitted);
        Ok((read, omitted))
    }

    /// All instances, setting by setting.
    pub fn instances(&self) -> impl Iterator<Item = &Instance> + Clone {
        self.settings.iter().flat_map(|setting| &setting.instances)
    }

    /// Updates of the longest instance.
    #[must_use]
    pub fn longest(&self) -> usize {
        self.instances().map(Instance::updates).max().unwrap_or(0)
    }

    /// Only of those that may be drawn: a recording has some megabytes.
    fn read_contacts(&mut self, omitted: &mut Vec<Omitted>) {
        for setting in &mut self.settings {
            let chosen = choice(&setting.instances);
            let indices = [Some(chosen.best), chosen.second, Some(chosen.median)];
            for index in indices.into_iter().flatten().collect::<BTreeSet<_>>() {
                let instance = &mut setting.instances[index];
                match Recording::read(&CellFolder::new(&instance.folder).replay()) {
                    Ok(recording) => instance.contacts = recording.map(|it| Contacts::of(&it)),
                    Err(error) => omitted
                        .push(Omitted { cell: instance.cell.clone(), reason: error.to_string() }),
                }
            }
        }
    }
}

impl Setting {
    /// The last-window means of R_Loc, instance by instance.
    #[must_use]
    pub fn last(&self) -> Vec<f64> {
        self.instances.iter().map(|instance| instance.outcome.last).collect()
    }
}

impl Instance {
    /// Updates done.
    #[must_use]
    pub fn updates(&self) -> usize {
        self.locomotion_m.len()
    }

    /// None if there's no update yet.
    fn read(folder: &CellFolder, cell: &Cell) -> Result<Option<Self>, store::Error> {
        let path = folder.metrics();
        let rows = store::read_all(&path)?;
        if let Some(what) = rows.iter().enumerate().find_map(|(i, row)| wrong(i, row)) {
            return Err(store::Error::Damaged { path, what });
        }
        let column = |of: fn(&Row) -> f64| rows.iter().map(of).collect();
        Ok((!rows.is_empty()).then(|| Self {
            cell: cell.folder(),
            seed: cell.seed,
            folder: folder.path().into(),
            reward: column(|row| row.reward),
            information_nats: column(|row| row.information_nats),
            locomotion_m: column(|row| row.locomotion_m),
            outcome: Outcome::default(),
            contacts: None,
        }))
    }
}

/// What is wrong with the row `i`, counted from 0, if anything.
fn wrong(i: usize, row: &Row) -> Option<String> {
    if row.update != i as u64 + 1 {
        return Some(format!("line {}: update {} expected, got {}", i + 2, i + 1, row.update));
    }
    let values =
        [("R", row.reward), ("R_MI_nats", row.information_nats), ("R_Loc", row.locomotion_m)];
    let (name, value) =
        values.into_iter().find(|(_, value)| value.is_nan() || value.abs() > LARGEST)?;
    Some(format!("line {}: {name} must be within -1e100 to 1e100, got {value}", i + 2))
}

/// The cells in their order, read by as many threads as there are cores.
fn read_all(
    run: &store::Run,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Vec<Result<Option<Instance>, store::Error>> {
    let cells = &run.manifest().cells;
    let n_cells = cells.len();
    let n_threads = thread::available_parallelism().map_or(1, NonZero::get).min(n_cells);
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || {
        let cells =
            iter::from_fn(|| cells.iter().enumerate().nth(next.fetch_add(1, Ordering::Relaxed)));
        cells
            .map(|(i, cell)| {
                let read = Instance::read(&run.cell(cell), cell);
                progress(done.fetch_add(1, Ordering::Relaxed) + 1, n_cells);
                (i, read)
            })
            .collect::<Vec<_>>()
    };
    let mut all = thread::scope(|scope| {
        let threads: Vec<_> = (1..n_threads).map(|_| scope.spawn(work)).collect();
        let mut all = work();
        for thread in threads {
            match thread.join() {
                Ok(read) => all.extend(read),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        all
    });
    all.sort_by_key(|&(i, _)| i);
    all.into_iter().map(|(_, read)| read).collect()
}
