//! A run opened for work: its folder, its cells with their settings, their robots.

use std::{collections::BTreeSet, fs, path::Path};

use anyhow::{Context, bail};
use config::Problems;
use svenja::Morphology;
use xxhash_rust::xxh3::xxh3_64;

use crate::{
    experiment::{Cell, Experiment, Plan, absolute},
    models,
    session::Session,
    store::{self, Bullet, CellFolder, NewRun, Precision, Run},
};

/// A run opened for work.
pub struct Lab {
    run: Run,
    cells: Vec<LabCell>,
    models: Vec<Model>,
}

/// A cell of a run.
pub struct LabCell {
    /// Setting, seed and all other settings.
    pub cell: Cell,
    /// Where its files are.
    pub folder: CellFolder,
    /// What its checkpoints are known by.
    pub identity: u64,
    /// Index of its robot.
    pub(super) model: usize,
}

struct Model {
    xxh3: u64,
    morphology: Morphology,
}

/// The physics engine of this program.
#[must_use]
pub fn this_bullet() -> Bullet {
    let precision = if bullet::SCALAR_BYTES == 4 { Precision::Single } else { Precision::Double };
    Bullet { version: bullet::BULLET_VERSION, precision }
}

impl Lab {
    /// Begins the run of an experiment file in a folder, or opens the one that is there, if it has
    /// the same settings. More updates than it has extend it.
    ///
    /// # Errors
    /// All that is wrong with the file and its models; another run in the folder.
    pub fn begin(plan: &Plan, folder: &Path) -> anyhow::Result<Self> {
        let files = model_files(plan)?;
        check_settings(plan)?;
        let names: Vec<_> =
            files.iter().map(|file| (file.path.as_str(), file.name.as_str())).collect();
        let experiment = written(plan, &names, folder)?;
        let cell = |cell: &Cell| store::Cell {
            index: cell.index,
            setting: cell.setting.clone(),
            seed: cell.seed,
        };
        let new = NewRun {
            experiment,
            itarl: env!("CARGO_PKG_VERSION").into(),
            bullet: this_bullet(),
            models: files.into_iter().map(|file| (file.name, file.bytes)).collect(),
            seeds: plan.seeds().to_vec(),
            cells: plan.cells().iter().map(cell).collect(),
        };
        Self::of(Run::create(folder, &new)?)?.extended(&new.experiment)
    }

    /// Opens a run that is there; `updates` extends it.
    ///
    /// # Errors
    /// What isn't a run, a damaged one, or one of another Bullet; updates out of range, fewer than
    /// the run has, or of a run that sweeps them.
    pub fn open(folder: &Path, updates: Option<u64>) -> anyhow::Result<Self> {
        let lab = Self::of(Run::open(folder)?)?;
        let Some(updates) = updates else { return Ok(lab) };
        let run = &lab.run;
        let plan = Plan::extended(&run.experiment_path(), run.experiment(), updates)?;
        let paths = models::paths(run);
        let files = run.manifest().models.iter().map(|model| model.file.as_str());
        let names: Vec<_> = paths.iter().map(String::as_str).zip(files).collect();
        let experiment = written(&plan, &names, folder)?;
        lab.extended(&experiment)
    }

    /// With more updates, where this text of the same experiment has more.
    fn extended(mut self, experiment: &str) -> anyhow::Result<Self> {
        let before = self.run.experiment().to_owned();
        self.run.extend(experiment)?;
        if self.run.experiment() == before { Ok(self) } else { Self::of(self.run) }
    }

    fn of(run: Run) -> anyhow::Result<Self> {
        run.require(this_bullet())?;
        let plan = Plan::written(&run.experiment_path(), run.experiment())?;
        let manifest = run.manifest();
        let model = |(index, listed): (usize, &store::Model)| -> anyhow::Result<Model> {
            Ok(Model { xxh3: listed.xxh3.0, morphology: models::read(&run, index)? })
        };
        let models: Vec<_> =
            manifest.models.iter().enumerate().map(model).collect::<Result<_, _>>()?;
        let paths = models::paths(&run);
        let mut cells = Vec::new();
        for (cell, listed) in plan.cells().iter().zip(&manifest.cells) {
            let model = models::index(&paths, &cell.experiment)
                .with_context(|| run.folder().display().to_string())?;
            let identity = identity(cell, models[model].xxh3);
            cells.push(LabCell { cell: cell.clone(), folder: run.cell(listed), identity, model });
        }
        let same = |cell: &LabCell, listed: &store::Cell| {
            (&cell.cell.setting, cell.cell.seed) == (&listed.setting, listed.seed)
        };
        let fits = plan.cells().len() == manifest.cells.len();
        if !fits || !cells.iter().zip(&manifest.cells).all(|(cell, listed)| same(cell, listed)) {
            bail!(
                "{}: manifest.json lists other cells than experiment.toml has",
                run.folder().display()
            );
        }
        Ok(Self { run, cells, models })
    }

    /// The run's folder.
    #[must_use]
    pub fn run(&self) -> &Run {
        &self.run
    }

    /// All cells, by index.
    #[must_use]
    pub fn cells(&self) -> &[LabCell] {
        &self.cells
    }

    /// The robot of a cell.
    #[must_use]
    pub fn morphology(&self, cell: &LabCell) -> &Morphology {
        &self.models[cell.model].morphology
    }
}

/// That the models of a plan can be read.
///
/// # Errors
/// All that is wrong with them.
pub fn check_models(plan: &Plan) -> anyhow::Result<()> {
    model_files(plan).map(drop)
}

struct ModelFile {
    /// As the plan has it.
    path: String,
    /// In the run folder.
    name: String,
    bytes: Vec<u8>,
}

/// The model files of a plan, each once, with all problems at once.
fn model_files(plan: &Plan) -> anyhow::Result<Vec<ModelFile>> {
    let mut known = BTreeSet::new();
    let paths = plan.cells().iter().map(|cell| &cell.experiment.model);
    let mut files = Vec::new();
    let mut problems = Vec::new();
    for path in paths.filter(|path| known.insert(*path)) {
        if let Err(found) = Morphology::open(Path::new(path)) {
            problems.extend(Vec::from(found));
            continue;
        }
        let bytes = fs::read(path).with_context(|| format!("{path}: reading"))?;
        // Stems differ, or cells would share a folder.
        let stem = Path::new(path).file_stem().unwrap_or_default().to_string_lossy();
        files.push(ModelFile { path: path.clone(), name: format!("{stem}.toml"), bytes });
    }
    if problems.is_empty() { Ok(files) } else { Err(Problems::new(problems).into()) }
}

/// That each setting's cells can be built.
fn check_settings(plan: &Plan) -> anyhow::Result<()> {
    let mut last: Option<&Experiment> = None;
    for cell in plan.cells() {
        if last.is_some_and(|last| *last == cell.experiment) {
            continue;
        }
        let morphology = Morphology::open(Path::new(&cell.experiment.model))?;
        Session::build(&cell.experiment, &morphology, cell.seed)
            .with_context(|| format!("setting {}", cell.setting))?;
        last = Some(&cell.experiment);
    }
    Ok(())
}

/// The plan's text for a run folder that has these models: paths of the plan, names in the folder.
/// It has been read again, and gives the same cells.
fn written(plan: &Plan, models: &[(&str, &str)], folder: &Path) -> anyhow::Result<String> {
    let copy = |path: &str| {
        let found = models.iter().find(|(known, _)| *known == path);
        found.map_or(path.to_owned(), |(_, name)| format!("{}/{name}", models::FOLDER))
    };
    let text = plan.to_toml_with(copy);
    let again = Plan::written(&folder.join("experiment.toml"), &text);
    let same = |(cell, again): (&Cell, &Cell)| {
        let model = absolute(&folder.join(copy(&cell.experiment.model)));
        let experiment = Experiment { model, ..cell.experiment.clone() };
        *again == Cell { experiment, ..cell.clone() }
    };
    let cells = plan.cells();
    match again {
        Ok(again)
            if again.cells().len() == cells.len() && cells.iter().zip(again.cells()).all(same) =>
        {
            Ok(text)
        }
        _ => bail!(
            "{}: nothing was written, since read again it would be another experiment; that's a \
             mistake in itarl: please report it, with the experiment file",
            folder.display()
        ),
    }
}

/// Of setting, seed, model and all settings, wherever the run is and however far it goes.
fn identity(cell: &Cell, model_xxh3: u64) -> u64 {
    let mut experiment = cell.experiment.clone();
    experiment.description = None;
    experiment.model = format!("{model_xxh3:016x}");
    experiment.learning.updates = 0;
    let text = format!("{}\n{}\n{}", cell.setting, cell.seed, experiment.to_toml());
    xxh3_64(text.as_bytes())
}
