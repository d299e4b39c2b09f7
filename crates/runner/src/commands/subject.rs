//! What is rolled out: a cell's robot or a model's, and who decides about its targets.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use config::Document;
use crbm::{Layout, Policy, Sampling};
use svenja::Morphology;

use crate::{
    experiment::Experiment,
    gait::Gait,
    rollout::Driver,
    store::{CellFolder, atomic},
    training::Lab,
};

/// What is rolled out.
pub(super) struct Subject {
    pub(super) experiment: Experiment,
    pub(super) morphology: Morphology,
    /// Of a cell.
    pub(super) folder: Option<CellFolder>,
}

impl Subject {
    /// A cell's folder, or a model file with the paper's settings.
    pub(super) fn open(what: &Path) -> anyhow::Result<Self> {
        if what.is_dir() { cell(what) } else { model(what) }
    }

    /// `learned`, `random`, `neutral` or a gait file.
    pub(super) fn driver(&self, policy: &str, seed: u64) -> anyhow::Result<Driver> {
        match policy {
            "learned" => {
                let Some(folder) = &self.folder else {
                    bail!(
                        "--policy learned: a model alone has learned nothing; name a cell's folder"
                    );
                };
                Ok(Driver::learned(read_policy(&folder.policy(), &self.experiment)?, seed))
            }
            "random" => Ok(Driver::random(seed)),
            "neutral" => Ok(Driver::Neutral),
            file if file.ends_with(".toml") => {
                let n_actuators = self.morphology.actuators().len();
                Driver::gait(Gait::open(&PathBuf::from(file), n_actuators)?)
            }
            other => {
                bail!(
                    "--policy must be learned, random, neutral or a gait's FILE.toml, got {other}"
                )
            }
        }
    }
}

fn cell(folder: &Path) -> anyhow::Result<Subject> {
    let not_a_cell = || {
        format!("{}: a cell's folder expected, DIR/cells/SETTING/seed=N of a run", folder.display())
    };
    let folder = folder.canonicalize().with_context(not_a_cell)?;
    let run = folder.ancestors().nth(3).with_context(not_a_cell)?;
    let lab = Lab::open(run, None).with_context(not_a_cell)?;
    let is_here = |path: &Path| path.canonicalize().is_ok_and(|path| path == folder);
    let cell = lab.cells().iter().find(|cell| is_here(cell.folder.path()));
    let cell = cell.with_context(not_a_cell)?;
    Ok(Subject {
        experiment: cell.cell.experiment.clone(),
        morphology: lab.morphology(cell).clone(),
        folder: Some(cell.folder.clone()),
    })
}

/// With the paper's settings.
fn model(path: &Path) -> anyhow::Result<Subject> {
    let morphology = Morphology::open(path)?;
    let text = format!("model = {}", toml::Value::String(path.display().to_string()));
    let experiment = Document::parse("defaults", &text)?.read(Experiment::read)?;
    Ok(Subject { experiment, morphology, folder: None })
}

fn read_policy(path: &Path, experiment: &Experiment) -> anyhow::Result<Policy> {
    let name = || path.display().to_string();
    let bytes = atomic::read(path)?
        .with_context(|| format!("{}: there's none before the first checkpoint", name()))?;
    let (layout, parameters) = Layout::from_safetensors(&bytes).with_context(name)?;
    let sampling = Sampling {
        gibbs_updates: experiment.policy.gibbs_updates,
        samples: experiment.policy.samples,
    };
    Policy::new(layout, sampling, &parameters).with_context(name)
}
