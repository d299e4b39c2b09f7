//! The models of a run: its copies of their files, found and read.

use anyhow::Context;
use runs::Run;
use svenja::Morphology;

use crate::experiment::absolute;

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
