//! A run folder as figures need it: settings, their instances, columns of numbers.
//!
//! Only recorded files are read, and nothing is written. What can't be read is left out and named.

use std::{
    collections::BTreeSet,
    path::PathBuf,
    sync::atomic::{AtomicUsize, Ordering},
};

use super::{Contacts, Error, Outcome, choice};
use crate::{
    catalogue::{Catalogue, LabCell},
    experiment::Cell,
    parallel,
    store::{self, CellFolder, Recording, Row},
};

/// Beyond it a number isn't one that learning gives, and its square has no place in an f64.
const LARGEST: f64 = 1e100;

/// What a run has recorded so far.
#[derive(Clone, Debug)]
pub struct Run {
    /// The run's folder.
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
    /// The name of its folder, `xi=0.75,power=2`.
    pub name: String,
    /// Those that have an update, in the order of their seeds in the experiment.
    pub instances: Vec<Instance>,
}

/// One training instance. Its columns have one value an update, at least one.
#[derive(Clone, Debug)]
pub struct Instance {
    /// The name of its cell, `xi=0.75/seed=3`.
    pub cell: String,
    /// The seed that its random numbers come from.
    pub seed: u64,
    /// The cell's folder.
    pub folder: PathBuf,
    /// R, the reward that is optimised.
    pub reward: Vec<f64>,
    /// R_MI, nats for each variable.
    pub information_nats: Vec<f64>,
    /// R_Loc, metres for each control step.
    pub locomotion_m: Vec<f64>,
    /// The outcome of its training so far.
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

impl Omitted {
    pub(crate) fn new(cell: &Cell, error: &dyn std::fmt::Display) -> Self {
        Self { cell: cell.folder().display().to_string(), reason: error.to_string() }
    }
}

impl std::fmt::Display for Omitted {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}: left out: {}", self.cell, self.reason)
    }
}

impl Run {
    /// Reads a run, finished or not. `progress` is told how many of how many cells are read, from any
    /// thread.
    ///
    /// # Errors
    /// If there's no update in it yet.
    pub fn read(
        catalogue: &Catalogue,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<(Self, Vec<Omitted>), Error> {
        let folder = catalogue.run().folder();
        let cells = catalogue.cells();
        let n_read = AtomicUsize::new(0);
        let instances = parallel::map(cells, |cell| {
            let read = Instance::read(catalogue, cell);
            progress(n_read.fetch_add(1, Ordering::Relaxed) + 1, cells.len());
            read
        });
        let mut omitted = Vec::new();
        let mut settings: Vec<Setting> = Vec::new();
        for (LabCell { cell, .. }, read) in cells.iter().zip(instances) {
            let instance = match read {
                Ok(instance) => instance,
                Err(error) => {
                    omitted.push(Omitted::new(cell, &error));
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
    /// The number of updates done.
    #[must_use]
    pub fn updates(&self) -> usize {
        self.locomotion_m.len()
    }

    /// None if there's no update yet.
    fn read(catalogue: &Catalogue, cell: &LabCell) -> Result<Option<Self>, store::Error> {
        let rows = catalogue.rows(cell)?;
        let LabCell { cell, folder, .. } = cell;
        if let Some(what) = rows.iter().enumerate().find_map(|(i, row)| wrong(i, row)) {
            return Err(store::Error::Damaged { path: folder.metrics(), what });
        }
        let column = |of: fn(&Row) -> f64| rows.iter().map(of).collect();
        Ok((!rows.is_empty()).then(|| Self {
            cell: cell.folder().display().to_string(),
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
