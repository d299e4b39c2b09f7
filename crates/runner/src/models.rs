//! The robots of experiments and of runs: models found and read, in whatever format they are, with what
//! an experiment changes of them; and a run's copies of them.

use std::path::Path;

use anyhow::Context;
use config::{Document, Problems};
use formats::{Imported, Options};
use runs::Run;
use svenja::Morphology;

use crate::experiment::{Experiment, RobotSettings, absolute};

/// The text of a model file, or what a robot in another format is imported as.
///
/// # Errors
/// A file that can't be read, or imported.
fn text(path: &Path) -> Result<String, Problems> {
    if formats::is_foreign(path) {
        let Imported { text, .. } = formats::import(path, &Options::default())?;
        return Ok(text);
    }
    config::read_text(path)
}

/// A model as its file has it.
///
/// # Errors
/// All that is wrong with it.
pub(crate) fn open_model(path: &Path) -> Result<Morphology, Problems> {
    Morphology::parse(&path.display().to_string(), &text(path)?)
}

/// The text of a model's copy, which needs no other files.
///
/// # Errors
/// All that is wrong with the model.
pub(crate) fn copied(path: &Path) -> Result<String, Problems> {
    let text = text(path)?;
    let meshes = Morphology::parse(&path.display().to_string(), &text)?.meshes_as_text();
    Ok(text + &meshes)
}

/// The robot of an experiment.
///
/// # Errors
/// All that is wrong with its file, or with what the experiment changes of it.
pub fn open(experiment: &Experiment) -> Result<Morphology, Problems> {
    let path = Path::new(&experiment.model);
    changed(path, &text(path)?, &experiment.robot)
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
    Ok(changed(&run.model_path(&model.file), &run.model(model)?, robot)?)
}

fn changed(path: &Path, text: &str, robot: &RobotSettings) -> Result<Morphology, Problems> {
    let mut model = Document::parse(&path.display().to_string(), text)?;
    robot.change(&mut model)?;
    Morphology::read(&model, path)
}
