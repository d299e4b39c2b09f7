//! The robots of experiments and of runs: models found and read, with what an experiment changes of
//! them.

use std::path::Path;

use anyhow::Context;
use config::{Document, Problems};
use runs::Run;
use svenja::Morphology;

use crate::experiment::{Experiment, RobotSettings, absolute};

/// The robot of an experiment.
///
/// # Errors
/// All that is wrong with its file, or with what the experiment changes of it.
pub(crate) fn open(experiment: &Experiment) -> Result<Morphology, Problems> {
    changed(Document::open(Path::new(&experiment.model))?, &experiment.robot)
}

/// What tells an experiment's robot from others.
pub(crate) fn key(experiment: &Experiment) -> (String, String) {
    (experiment.model.clone(), experiment.robot.to_table().to_string())
}

/// Where a run's copies of model files are, in the order of the manifest, as experiments name them.
pub(crate) fn paths(run: &Run) -> Vec<String> {
    run.manifest().models.iter().map(|model| absolute(&run.model_path(&model.file))).collect()
}

/// The robot of a copy.
///
/// # Errors
/// A copy that isn't what the run was made with.
pub(crate) fn read(run: &Run, index: usize, robot: &RobotSettings) -> anyhow::Result<Morphology> {
    let model = run.manifest().models.get(index).context("no such model in manifest.json")?;
    let source = run.model_path(&model.file).display().to_string();
    Ok(changed(Document::parse(&source, &run.model(model)?)?, robot)?)
}

fn changed(mut model: Document, robot: &RobotSettings) -> Result<Morphology, Problems> {
    robot.change(&mut model)?;
    Morphology::read(&model)
}
