//! What is wrong with how the cells of runs learn: symptoms in their rows, cells that failed, cells that
//! lag. `docs/health.md` says how each is found.

use figures::{Contacts, Error, Facts, Omitted, Results, Symptom, symptoms};
use runs::{Look, State};

use crate::{
    catalogue::{Catalogue, RunCell},
    comparison::Comparison,
    session::build_policy,
};

/// A cell that something is wrong with.
#[derive(Clone, Debug)]
pub struct Patient {
    /// Its setting, as it's called among the runs.
    pub setting: String,
    /// Its seed.
    pub seed: u64,
    /// What is wrong, at least one.
    pub symptoms: Vec<Symptom>,
}

/// The cells of some runs with which something is wrong, in their order; and what couldn't be read.
///
/// # Errors
/// As [`Comparison::results`], but for runs without an update, whose cells may have failed.
pub fn patients(comparison: &Comparison) -> Result<(Vec<Patient>, Vec<Omitted>), Error> {
    let (results, omitted) = match comparison.results(&|_, _| {}) {
        Ok((results, omitted)) => (Some(results), omitted),
        Err(Error::Empty { omitted, .. }) => (None, omitted),
        Err(error) => return Err(error),
    };
    Ok((of(comparison, results.as_ref()), omitted))
}

/// The same of results that are read already, if there are any.
#[must_use]
pub fn of(comparison: &Comparison, results: Option<&Results>) -> Vec<Patient> {
    let runs = comparison.catalogues().iter().enumerate();
    let all = runs.flat_map(|(run, catalogue)| {
        let failures = catalogue.status(Look::Thorough).into_iter().map(|it| match it.state {
            State::Failed(reason) => {
                let updates = it.latest.map_or(it.saved_updates, |row| row.update);
                Some(Symptom::failed(updates, reason))
            }
            _ => None,
        });
        let cells = catalogue.cells().iter().zip(failures);
        cells.map(move |(cell, failure)| {
            let learned = results.map_or_else(Vec::new, |it| of_cell(it, catalogue, cell));
            Patient {
                setting: comparison.named(run, &cell.cell.setting),
                seed: cell.cell.seed,
                symptoms: failure.into_iter().chain(learned).collect(),
            }
        })
    });
    all.filter(|it| !it.symptoms.is_empty()).collect()
}

fn of_cell(results: &Results, catalogue: &Catalogue, cell: &RunCell) -> Vec<Symptom> {
    let found = results.settings.iter().find_map(|setting| {
        let it = setting.cells.iter().find(|it| it.folder == cell.folder.path())?;
        Some((setting, it))
    });
    found.map_or_else(Vec::new, |(setting, it)| {
        symptoms(results, setting, it, &facts(catalogue, cell))
    })
}

/// What a cell's rows don't have; nothing of what can't be read, which whoever reads it says.
fn facts(catalogue: &Catalogue, cell: &RunCell) -> Facts {
    let experiment = &cell.cell.experiment;
    let contacts = Contacts::read(&cell.folder.replay()).ok().flatten();
    let Ok(morphology) = catalogue.morphology(cell) else {
        return Facts { contacts, ..Facts::default() };
    };
    let policy = build_policy(experiment, &morphology, 0);
    let steps = experiment.learning.control_steps_per_update();
    Facts {
        n_parameters: policy.map_or(0, |it| it.parameters().len()),
        readings_per_update: steps as f64 * morphology.sensors().len() as f64,
        contacts,
    }
}
