//! A run opened for work: its folder, its cells with their settings, their robots.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, bail};
use config::Problems;
use svenja::Morphology;
use toml::{Table, Value};

use crate::{
    catalogue::{Catalogue, LabCell},
    experiment::{Cell, Experiment, Plan},
    session::Session,
    store::{self, Bullet, NewRun, Precision, Run},
};

/// Where a run folder keeps the models, seen from its experiment file.
const MODELS: &str = "models";

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
        let experiment = in_folder(plan, &files)?;
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
        let mut run = Run::create(folder, &new)?;
        extend(&mut run, &new.experiment)?;
        Self::of(run)
    }

    /// Opens a run that is there; `updates` extends it.
    ///
    /// # Errors
    /// What isn't a run, a damaged one, or one of another Bullet.
    pub fn open(folder: &Path, updates: Option<u64>) -> anyhow::Result<Self> {
        let mut run = Run::open(folder)?;
        if let Some(updates) = updates {
            let mut table: Table = toml::from_str(run.experiment())?;
            let learning = table.entry("learning").or_insert_with(|| Table::new().into());
            if let Value::Table(learning) = learning {
                learning.insert("updates".into(), Value::Integer(i64::try_from(updates)?));
            }
            let text = table.to_string();
            extend(&mut run, &text)?;
        }
        Self::of(run)
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

/// More updates are written into the run; fewer are refused.
fn extend(run: &mut Run, experiment: &str) -> anyhow::Result<()> {
    let updates = |text: &str| -> anyhow::Result<Option<i64>> {
        let table: Table = toml::from_str(text)?;
        Ok(table.get("learning").and_then(|l| l.get("updates")).and_then(Value::as_integer))
    };
    let (there, here) = (updates(run.experiment())?, updates(experiment)?);
    if here > there {
        run.extend(experiment)?;
    } else if here < there {
        bail!(
            "{}: learning.updates: {} there, {} here: a run can be extended, not cut short",
            run.folder().display(),
            there.unwrap_or_default(),
            here.unwrap_or_default()
        );
    }
    Ok(())
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
    let mut files: Vec<ModelFile> = Vec::new();
    let mut problems = Vec::new();
    for cell in plan.cells() {
        let path = &cell.experiment.model;
        if files.iter().any(|file| file.path == *path) {
            continue;
        }
        if let Err(found) = Morphology::open(Path::new(path)) {
            problems.extend(Vec::from(found));
        }
        let bytes = if problems.is_empty() {
            fs::read(path).with_context(|| format!("{path}: reading"))?
        } else {
            Vec::new()
        };
        let path_of = PathBuf::from(path);
        let stem = path_of.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let taken = |name: &str| files.iter().any(|file| file.name == name);
        let mut name = format!("{stem}.toml");
        for number in 2.. {
            if !taken(&name) {
                break;
            }
            name = format!("{stem}-{number}.toml");
        }
        files.push(ModelFile { path: path.clone(), name, bytes });
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

/// The plan's text with models as the run folder has them.
fn in_folder(plan: &Plan, files: &[ModelFile]) -> anyhow::Result<String> {
    let mut table: Table = toml::from_str(&plan.to_toml())?;
    let rename = |value: &mut Value| {
        let file = files.iter().find(|file| value.as_str() == Some(&file.path));
        if let Some(file) = file {
            *value = format!("{MODELS}/{}", file.name).into();
        }
    };
    if let Some(model) = table.get_mut("model") {
        rename(model);
    }
    let swept = table.get_mut("sweep").and_then(|sweep| sweep.get_mut("model"));
    if let Some(Value::Array(models)) = swept {
        models.iter_mut().for_each(rename);
    }
    Ok(table.to_string())
}
