//! A run's folder with what it's made of: the cells that `experiment.toml` and `manifest.json` both
//! have, each with its settings, its folder, and what its checkpoint must say to be its own.
//!
//! Whoever trains and whoever reads begins here, so that both believe the same.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, absolute},
};

use anyhow::Context;
use figures::{Information, Measure, Omitted, Results};
use policy::Start;
use runs::{
    CELLS, CellFolder, CellStatus, Expected, FileCopy, Inspection, Look, MODELS, Manifest,
    POLICIES, PublishedCell, Row, Run,
};
use svenja::Morphology;
use xxhash_rust::xxh3::xxh3_64;

use crate::{
    experiment::{self, Cell, Experiment, Plan},
    models,
};

/// A run, opened to be read or to be gone on with.
#[derive(Clone, Debug)]
pub struct Catalogue {
    run: Run,
    plan: Plan,
    cells: Vec<RunCell>,
    /// Of each robot, the first cell that has it.
    robots: Vec<usize>,
}

/// A cell of a run.
#[derive(Clone, Debug)]
pub struct RunCell {
    /// Setting, seed and all other settings.
    pub cell: Cell,
    /// The folder with its files.
    pub folder: CellFolder,
    /// The number that its checkpoints are known by.
    pub identity: u64,
    /// Index of its robot's file among the models of `manifest.json`.
    pub(crate) model: usize,
    /// Index of its robot among those of the run, each another file or changed in another way.
    pub(crate) robot: usize,
    /// Index of the file that its policy starts from among the policies of `manifest.json`.
    pub(crate) initial: Option<usize>,
}

/// The information in an experiment's reward; none if it measures none.
pub(crate) fn information(experiment: &Experiment) -> Option<Information> {
    let settings = &experiment.reward.intrinsic;
    let kind = settings.get();
    kind.is_measured()
        .then(|| Information::of_kind(settings.kind(), kind.symbol(), [kind.unit(), kind.per()]))
}

impl RunCell {
    /// What its checkpoints must say.
    #[must_use]
    pub fn expected(&self) -> Expected {
        let learning = &self.cell.experiment.learning;
        let (updates, steps_per_update) = (learning.updates, learning.control_steps_per_update());
        Expected { identity: self.identity, updates, steps_per_update }
    }

    /// The task's own value, by which the cell alone is judged, and its information.
    #[must_use]
    pub fn task(&self) -> Measure {
        let settings = &self.cell.experiment.reward.extrinsic;
        let task = settings.get();
        let information = information(&self.cell.experiment);
        Measure::of_task(settings.kind(), task.symbol(), task.unit()).with(information, None)
    }

    /// A row as if its file had all columns: one from before there was `task` has the numbers that
    /// the tasks of then were made of.
    pub(crate) fn completed(&self, row: Row) -> Row {
        let experiment = &self.cell.experiment;
        let task = match experiment.reward.extrinsic.kind() {
            _ if !row.task.is_nan() => row.task,
            "locomotion" => row.advance_m,
            "turning" => row.heading_change_rad / experiment.learning.steps_per_update as f64,
            _ => f64::NAN,
        };
        Row { task, ..row }
    }
}

impl Catalogue {
    /// Opens a run's folder, of any Bullet.
    ///
    /// # Errors
    /// What isn't a run; a damaged one, which includes a manifest that lists other cells, seeds or
    /// models than the experiment has.
    pub fn open(folder: &Path) -> anyhow::Result<Self> {
        Self::of(Run::open(folder)?)
    }

    /// The catalogue of a run that is open.
    ///
    /// # Errors
    /// As [`Catalogue::open`].
    pub fn of(run: Run) -> anyhow::Result<Self> {
        let plan = Plan::written(&run.experiment_path(), run.experiment())?;
        let listed = run.manifest();
        let damaged = |what: String| runs::Error::damaged(&run.manifest_path(), what);
        if let Some(what) = contradiction(&plan, listed) {
            return Err(damaged(what).into());
        }
        let mut cells = identified(run.folder(), &plan, listed).map_err(damaged)?;
        let mut sorted = Vec::with_capacity(cells.len());
        let (mut robots, mut known) = (Vec::new(), BTreeMap::new());
        for in_manifest in &listed.cells {
            // Each of them is there, as nothing contradicts.
            let key = (in_manifest.setting.clone(), in_manifest.seed);
            let Some(mut it) = cells.remove(&key) else { continue };
            it.cell.index = in_manifest.index;
            it.robot = *known.entry(models::key(&it.cell.experiment)).or_insert_with(|| {
                robots.push(sorted.len());
                robots.len() - 1
            });
            sorted.push(it);
        }
        Ok(Self { run, plan, cells: sorted, robots })
    }

    /// The run that a cell's folder is in, with the cell.
    ///
    /// # Errors
    /// If the folder isn't one of a run's cell; as [`Catalogue::open`].
    pub fn of_cell(folder: &Path) -> anyhow::Result<(Self, RunCell)> {
        let not_a_cell = || {
            let folder = folder.display();
            format!("{folder}: a cell's folder expected, DIR/cells/SETTING/seed=N of a run")
        };
        // Below a run no link is followed: one from a cell to its neighbour isn't that neighbour. But
        // there may be one to a cell from elsewhere.
        let ways = [absolute(folder), folder.canonicalize()];
        let is_run = |path: &Path| path.join(runs::MANIFEST).exists();
        let found = ways.into_iter().flatten().find_map(|path| {
            let run = path.ancestors().nth(3).filter(|run| is_run(run))?.to_path_buf();
            Some((run, path))
        });
        let (run, path) = found.with_context(not_a_cell)?;
        let catalogue = Self::open(&run).with_context(not_a_cell)?;
        let cell = catalogue.cells.iter().find(|cell| cell.folder.path() == path);
        let cell = cell.with_context(not_a_cell)?.clone();
        Ok((catalogue, cell))
    }

    /// The run's folder.
    #[must_use]
    pub fn run(&self) -> &Run {
        &self.run
    }

    /// What `experiment.toml` says.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// All cells, by index.
    #[must_use]
    pub fn cells(&self) -> &[RunCell] {
        &self.cells
    }

    /// The robots of the run, in the order in which cells have them.
    ///
    /// # Errors
    /// A copy of a model file that isn't what the run was made with.
    pub fn morphologies(&self) -> anyhow::Result<Vec<Morphology>> {
        self.robots.iter().map(|&first| self.morphology(&self.cells[first])).collect()
    }

    /// The robot of a cell.
    ///
    /// # Errors
    /// As [`Catalogue::morphologies`].
    pub fn morphology(&self, cell: &RunCell) -> anyhow::Result<Morphology> {
        models::read(&self.run, cell.model, &cell.cell.experiment.robot)
    }

    /// Updates that a row is the mean of: 1, but in a published run.
    #[must_use]
    pub fn every(&self) -> u64 {
        self.run.manifest().published.as_ref().map_or(1, |published| published.every)
    }

    /// What was published of a cell; none in a run's own folder.
    #[must_use]
    pub fn published(&self, cell: &RunCell) -> Option<&PublishedCell> {
        self.run.manifest().published.as_ref()?.cells.get(cell.cell.index)
    }

    /// All rows of a cell, as [`CellFolder::rows`] or [`CellFolder::published_rows`], with the task's
    /// value in each.
    ///
    /// # Errors
    /// As these.
    pub fn rows(&self, cell: &RunCell) -> Result<Vec<Row>, runs::Error> {
        let mut rows = match self.published(cell) {
            Some(published) => cell.folder.published_rows(published)?,
            None => self.expecting(cell, |expected| cell.folder.rows(expected))?,
        };
        rows.iter_mut().for_each(|row| *row = cell.completed(*row));
        Ok(rows)
    }

    /// What the run's cells are judged by: their task's own value if they have the same task, else
    /// R_Loc.
    #[must_use]
    pub fn measure(&self) -> Measure {
        let mut tasks: Vec<&str> = Vec::new();
        for cell in &self.cells {
            let kind = cell.cell.experiment.reward.extrinsic.kind();
            if !tasks.contains(&kind) {
                tasks.push(kind);
            }
        }
        let measure = match &self.cells[..] {
            [first, ..] if tasks.len() == 1 => first.task(),
            _ => Measure::common(&tasks),
        };
        let (information, caveat) = self.information();
        measure.with(information, caveat)
    }

    /// What the information of all cells is called, and what to keep in mind where they have several
    /// kinds; none if no cell measures any.
    fn information(&self) -> (Option<Information>, Option<String>) {
        let mut kinds: Vec<Option<Information>> = Vec::new();
        for cell in &self.cells {
            let kind = information(&cell.cell.experiment);
            if !kinds.contains(&kind) {
                kinds.push(kind);
            }
        }
        let has_none = kinds.contains(&None);
        let kinds: Vec<_> = kinds.into_iter().flatten().collect();
        match &kinds[..] {
            [] => (None, None),
            [one] => {
                let caveat = "Where a setting's reward has no information in it, it's told as 0.";
                (Some(one.clone()), has_none.then(|| caveat.into()))
            }
            [first, ..] => {
                let names: Vec<_> = kinds.iter().map(|it| it.what.as_str()).collect();
                let caveat = format!(
                    "The settings have different kinds of information ({}), whose values can't be \
                     compared.",
                    names.join(", ")
                );
                (Some(Information::common(&first.unit)), Some(caveat))
            }
        }
    }

    /// What the run came to so far, and what had to be left out; or what it had come to by the update
    /// `until`, of cells that came so far. `progress` is told how many of how many cells are read, from
    /// any thread.
    ///
    /// # Errors
    /// If there's no update in it yet.
    pub fn results(
        &self,
        until: Option<u64>,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<(Results, Vec<Omitted>), figures::Error> {
        // The manifest lists the same cells.
        let rows = |cell: &runs::Cell| {
            let mut rows = self.rows(&self.cells[cell.index])?;
            if let Some(until) = until {
                let asked = usize::try_from(until / self.every()).unwrap_or(usize::MAX);
                rows.truncate(if rows.len() < asked { 0 } else { asked });
            }
            Ok(rows)
        };
        Results::read(&self.run, self.measure(), &rows, progress)
    }

    /// That a cell's checkpoint and metrics can be believed; what is derived from them then can, too.
    ///
    /// # Errors
    /// As [`CellFolder::header`] or [`CellFolder::published_rows`].
    pub fn check(&self, cell: &RunCell) -> Result<(), runs::Error> {
        match self.published(cell) {
            Some(published) => cell.folder.published_rows(published).map(drop),
            None => self.expecting(cell, |expected| cell.folder.header(expected)).map(drop),
        }
    }

    /// Where the cells stand, by index. One that can't be read doesn't hide the others. A published
    /// run's are small, and read as a whole.
    #[must_use]
    pub fn status(&self, look: Look) -> Vec<CellStatus> {
        runs::parallel::map(&self.cells, |cell| {
            let updates = cell.cell.experiment.learning.updates;
            let look = match self.published(cell) {
                Some(published) => cell.folder.published_state(published, updates),
                None => self.expecting(cell, |expected| cell.folder.inspect(expected, look)),
            };
            let look = look.map(|seen| Inspection {
                latest: seen.latest.map(|row| cell.completed(row)),
                ..seen
            });
            let listed = &self.run.manifest().cells[cell.cell.index];
            CellStatus::new(listed, updates, look)
        })
    }

    /// Opens something of a cell with what is expected of it. If it's further than the experiment was
    /// when the run was opened, the run may have been extended since.
    ///
    /// # Errors
    /// Those of `open`.
    pub fn expecting<T>(
        &self,
        cell: &RunCell,
        open: impl Fn(Expected) -> Result<T, runs::Error>,
    ) -> Result<T, runs::Error> {
        let opened = open(cell.expected());
        if !matches!(opened, Err(runs::Error::Beyond { .. })) {
            return opened;
        }
        match Self::open(self.run.folder()) {
            Ok(now) => now.cells.get(cell.cell.index).map_or(opened, |it| open(it.expected())),
            Err(_) => opened,
        }
    }
}

/// In what the manifest isn't that of the experiment.
fn contradiction(plan: &Plan, manifest: &runs::Manifest) -> Option<String> {
    if plan.seeds() != manifest.seeds {
        let [here, there] = [&manifest.seeds[..], plan.seeds()].map(|seeds| format!("{seeds:?}"));
        return Some(format!("the seeds are {here}, and in experiment.toml {there}"));
    }
    // In any order: those that a run got later are behind the others.
    let here: BTreeSet<_> =
        manifest.cells.iter().map(|cell| (cell.setting.as_str(), cell.seed)).collect();
    let there: BTreeSet<_> =
        plan.cells().iter().map(|cell| (cell.setting.as_str(), cell.seed)).collect();
    let name = |(setting, seed): &(&str, u64)| format!("{setting}/seed={seed}");
    if let Some(cell) = here.difference(&there).next() {
        return Some(format!("it lists cell {}, and experiment.toml has no such cell", name(cell)));
    }
    let missing = there.difference(&here).next();
    missing.map(|cell| format!("it doesn't list cell {}, which experiment.toml has", name(cell)))
}

/// The cells of a plan, by setting and seed, for a run with these files in its folder, their robots not
/// counted yet; or what is missing there.
pub(crate) fn identified(
    folder: &Path,
    plan: &Plan,
    manifest: &Manifest,
) -> Result<BTreeMap<(String, u64), RunCell>, String> {
    let paths = |sub: &str, copies: &[FileCopy]| {
        let path = |copy: &FileCopy| experiment::absolute(&folder.join(sub).join(&copy.file));
        copies.iter().map(path).collect::<Vec<_>>()
    };
    let models = paths(MODELS, &manifest.models);
    let policies = paths(POLICIES, &manifest.policies);
    let listed_at = |paths: &[String], path: &str| {
        let index = paths.iter().position(|listed| listed == path);
        index.ok_or_else(|| format!("it doesn't list {path}, which experiment.toml has"))
    };
    let (mut cells, mut settings) = (BTreeMap::new(), BTreeMap::new());
    for cell in plan.cells() {
        let model = listed_at(&models, &cell.experiment.model)?;
        let initial =
            cell.experiment.initial().map(|path| listed_at(&policies, path)).transpose()?;
        let policy = initial.map(|index| &manifest.policies[index]);
        // The same for all seeds: a run may have thousands.
        let text = settings
            .entry(&cell.setting)
            .or_insert_with(|| resolved(&cell.experiment, &manifest.models[model], policy));
        let identity = identity(cell, text);
        let folder = CellFolder::new(folder.join(CELLS).join(cell.folder()));
        let key = (cell.setting.clone(), cell.seed);
        let cell = cell.clone();
        cells.insert(key, RunCell { cell, folder, identity, model, robot: 0, initial });
    }
    Ok(cells)
}

/// Of setting, seed, files and all settings, wherever the run is and however far it goes.
fn identity(cell: &Cell, resolved: &str) -> u64 {
    xxh3_64(format!("{}\n{}\n{resolved}", cell.setting, cell.seed).as_bytes())
}

/// All settings, with hashes in place of files.
fn resolved(experiment: &Experiment, model: &FileCopy, policy: Option<&FileCopy>) -> String {
    let hash = |copy: &FileCopy| format!("{:016x}", copy.xxh3.0);
    let mut experiment = experiment.clone();
    experiment.description = None;
    experiment.model = hash(model);
    if let Some(policy) = policy {
        experiment.policy.start = Start::File(hash(policy));
    }
    experiment.learning.updates = 0;
    experiment.to_toml()
}

#[cfg(test)]
mod tests {
    use super::*;
    use runs::Hash;

    /// As in the checkpoints of runs that are there: others would be refused.
    #[test]
    fn identities_do_not_change_with_versions() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/beginning.toml");
        let changes = ["checkpoint.every=6", "learning.updates=12"].map(str::to_owned);
        let plan = Plan::open(&file, &changes).unwrap();
        let cells = plan.cells();
        let svenja = FileCopy { file: "svenja.toml".into(), xxh3: Hash(0xfd1a_2299_37d3_bdd4) };
        let identity = |cell: &Cell| {
            format!("{:016x}", identity(cell, &resolved(&cell.experiment, &svenja, None)))
        };
        assert_eq!(cells[0].folder(), Path::new("xi=0.75/seed=1"));
        assert_eq!(identity(&cells[0]), "0ea4cc31311e4ae5");
        assert_eq!(cells[15].folder(), Path::new("xi=1/seed=8"));
        assert_eq!(identity(&cells[15]), "3f47c3baa87971e0");
    }

    fn cell(settings: &str) -> RunCell {
        let text = format!("model = '/m'\nlearning.steps_per_update = 4\n{settings}");
        let plan = Plan::written(Path::new("/x.toml"), &text).unwrap();
        let folder = CellFolder::new("cell");
        RunCell {
            cell: plan.cells()[0].clone(),
            folder,
            identity: 0,
            model: 0,
            robot: 0,
            initial: None,
        }
    }

    #[test]
    fn an_old_row_gets_its_task_from_what_it_was_made_of() {
        let row = Row { advance_m: 0.5, heading_change_rad: 2.0, task: f64::NAN, ..Row::default() };
        for (kind, task) in [("locomotion", 0.5), ("turning", 0.5)] {
            let cell = cell(&format!("reward.extrinsic.kind = '{kind}'"));
            assert_eq!(cell.completed(row).task, task);
            assert_eq!(cell.completed(Row { task: 7.0, ..row }).task, 7.0);
        }
    }

    /// It's the same wherever the file is, and another one with another file.
    #[test]
    fn the_policy_that_a_cell_starts_from_is_known_by_its_hash() {
        let cell = |path: &str| {
            let text = format!("model = '/m'\npolicy.initial = '{path}'");
            Plan::written(Path::new("/x.toml"), &text).unwrap().cells()[0].clone()
        };
        let copy = |xxh3| FileCopy { file: "x".into(), xxh3: Hash(xxh3) };
        let of = |path, xxh3| {
            let cell = cell(path);
            identity(&cell, &resolved(&cell.experiment, &copy(1), Some(&copy(xxh3))))
        };
        assert_eq!(of("/a", 2), of("/b", 2));
        assert_ne!(of("/a", 2), of("/a", 3));
    }
}
