//! What this program has to show, as clips: a cell's last control steps, or what a policy does now.

use anyhow::Context;
use runs::Recording;
use scenes::{Clip, Quantity, RewardParts};
use svenja::Morphology;

use crate::{
    catalogue::{Catalogue, RunCell},
    experiment::Experiment,
};

/// A recording of an experiment's robot.
///
/// # Errors
/// As [`Clip::new`].
pub fn of_recording(
    title: String,
    experiment: &Experiment,
    morphology: Morphology,
    recording: Recording,
) -> Result<Clip, scenes::Error> {
    let (task, information) =
        (experiment.reward.extrinsic.get(), experiment.reward.intrinsic.get());
    let quantity = |symbol, unit| Quantity { symbol, unit };
    let parts = RewardParts {
        task: quantity(task.symbol(), task.unit()),
        information: information
            .is_measured()
            .then(|| quantity(information.symbol(), information.unit())),
    };
    Clip::new(title, parts, morphology, recording)
}

/// The last control steps of a cell, with the run's copy of its model.
///
/// # Errors
/// What can't be read, is damaged, or isn't there yet.
pub fn of_cell(catalogue: &Catalogue, cell: &RunCell) -> anyhow::Result<Clip> {
    let path = cell.folder.replay();
    let name = || path.display().to_string();
    let why_none = match catalogue.published(cell) {
        None => "there's none before the first checkpoint",
        Some(_) => {
            "published are those of each setting's best and median cell; --policy learned shows \
                    what another one does"
        }
    };
    let recording = Recording::read(&path)?.with_context(|| format!("{}: {why_none}", name()))?;
    let morphology = catalogue.morphology(cell)?;
    let cell = &cell.cell;
    let title = format!("{}, seed {}", cell.setting, cell.seed);
    of_recording(title, &cell.experiment, morphology, recording).with_context(name)
}

#[cfg(test)]
mod tests {
    use reward::Terms;
    use scenes::viewer::TERMS;

    /// A term that has another name is no error to the viewer: it would only be missing.
    #[test]
    fn the_viewer_knows_the_names_of_terms() {
        for term in TERMS {
            assert!(Terms::NAMES.contains(&term), "{term}");
        }
    }
}
