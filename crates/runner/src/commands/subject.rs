//! What is rolled out: a cell's robot or a model's, and who decides about its targets.

use std::path::{Path, PathBuf};

use anyhow::bail;
use config::Document;
use policy::Policy;
use svenja::Morphology;

use crate::{
    catalogue::{Catalogue, RunCell},
    experiment::Experiment,
    gait::Gait,
    models,
    rollout::Driver,
    session::learned_policy,
    training::this_bullet,
};

/// What is rolled out.
pub(super) struct Subject {
    pub(super) experiment: Experiment,
    pub(super) morphology: Morphology,
    /// Who learned it.
    pub(super) cell: Option<(Catalogue, RunCell)>,
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
                let Some((catalogue, cell)) = &self.cell else {
                    bail!(
                        "--policy learned: a model alone has learned nothing; name a cell's folder"
                    );
                };
                catalogue.check(cell)?;
                Ok(Driver::learned(self.learned(&cell.folder.policy())?, seed))
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

    /// The policy whose parameters a cell has exported.
    pub(super) fn learned(&self, path: &Path) -> anyhow::Result<Box<dyn Policy>> {
        learned_policy(&self.experiment, &self.morphology, path)
    }
}

fn cell(folder: &Path) -> anyhow::Result<Subject> {
    let (catalogue, cell) = Catalogue::of_cell(folder)?;
    catalogue.run().require(this_bullet())?;
    Ok(Subject {
        experiment: cell.cell.experiment.clone(),
        morphology: catalogue.morphology(&cell)?,
        cell: Some((catalogue, cell)),
    })
}

fn model(path: &Path) -> anyhow::Result<Subject> {
    let morphology = models::open_model(path)?;
    let defaults = Document::parse("defaults", &models::defaults(path, &morphology))?;
    let experiment = defaults.read(Experiment::read)?;
    Ok(Subject { experiment, morphology, cell: None })
}
