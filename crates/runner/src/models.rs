//! Models from their files: those that an experiment names, in whatever format they are, and a run's
//! copies of them.

use std::path::Path;

use anyhow::Context;
use config::Problems;
use formats::{Imported, Options};
use runs::Run;
use svenja::Morphology;

use crate::experiment::absolute;

/// A robot with the text of its model file.
pub(crate) struct Model {
    pub(crate) morphology: Morphology,
    pub(crate) text: String,
}

impl Model {
    /// Reads a model file, or imports a robot in another format.
    ///
    /// # Errors
    /// All that is wrong with it.
    pub(crate) fn open(path: &Path) -> Result<Self, Problems> {
        if formats::is_foreign(path) {
            let Imported { text, .. } = formats::import(path, &Options::default())?;
            let morphology = Morphology::parse(&path.display().to_string(), &text)?;
            return Ok(Self { morphology, text });
        }
        let text = config::read_text(path)?;
        let morphology = Morphology::parse(&path.display().to_string(), &text)?;
        // A copy needs no other files.
        let text = text + &morphology.meshes_as_text();
        Ok(Self { morphology, text })
    }
}

/// Where the copies are, in the order of the manifest, as experiments name them.
pub(crate) fn paths(run: &Run) -> Vec<String> {
    run.manifest().models.iter().map(|model| absolute(&run.model_path(&model.file))).collect()
}

/// The robot of a copy.
///
/// # Errors
/// A copy that isn't what the run was made with.
pub(crate) fn read(run: &Run, index: usize) -> anyhow::Result<Morphology> {
    let model = run.manifest().models.get(index).context("no such model in manifest.json")?;
    let source = run.model_path(&model.file).display().to_string();
    Ok(Morphology::parse(&source, &run.model(model)?)?)
}
