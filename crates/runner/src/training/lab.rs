//! A run opened for work: its folder, its cells with their settings, their robots.

use std::{collections::BTreeSet, fs, path::Path};

use anyhow::{Context, bail};
use config::Problems;
use runs::{Bullet, NewRun, Precision, Run};
use svenja::Morphology;

use crate::{
    catalogue::{Catalogue, LabCell},
    experiment::{Cell, Experiment, Plan, absolute},
    models,
    session::Session,
};

/// A run opened for work.
pub struct Lab {
    catalogue: Catalogue,
    /// In the order of `manifest.json`.
    morphologies: Vec<Morphology>,
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
        let cell = |cell: &Cell| runs::Cell {
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
        let run = lab.run();
        let plan = Plan::extended(&run.experiment_path(), run.experiment(), updates)?;
        let paths = models::paths(run);
        let files = run.manifest().models.iter().map(|model| model.file.as_str());
        let names: Vec<_> = paths.iter().map(String::as_str).zip(files).collect();
        let experiment = written(&plan, &names, folder)?;
        lab.extended(&experiment)
    }

    /// With more updates, where this text of the same experiment has more.
    fn extended(self, experiment: &str) -> anyhow::Result<Self> {
        let mut run = self.run().clone();
        run.extend(experiment)?;
        if run.experiment() == self.run().experiment() { Ok(self) } else { Self::of(run) }
    }

    fn of(run: Run) -> anyhow::Result<Self> {
        run.require(this_bullet())?;
        let catalogue = Catalogue::of(run)?;
        let morphologies = catalogue.morphologies()?;
        Ok(Self { catalogue, morphologies })
    }

    /// The run with its cells.
    #[must_use]
    pub fn catalogue(&self) -> &Catalogue {
        &self.catalogue
    }

    /// The run's folder.
    #[must_use]
    pub fn run(&self) -> &Run {
        self.catalogue.run()
    }

    /// All cells, by index.
    #[must_use]
    pub fn cells(&self) -> &[LabCell] {
        self.catalogue.cells()
    }

    /// The robot of a cell.
    #[must_use]
    pub fn morphology(&self, cell: &LabCell) -> &Morphology {
        &self.morphologies[cell.model]
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
