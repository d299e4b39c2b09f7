//! Robots to act in: what `itarl.Env` and `itarl.VectorEnv` step.

use std::{collections::BTreeSet, path::PathBuf};

use anyhow::{Context, bail, ensure};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use reward::Terms;
use runner::{
    experiment::{Experiment, Plan},
    models,
    session::{Episode, Evaluation, Stepped, recorded_layout},
};

use crate::failure::{Exclusive, Failure};

/// Columns of what a world's step is told as, besides the reward's terms.
const MORE: [&str; 7] = [
    "advance_m",
    "heading_change_rad",
    "penalised_contacts",
    "clipped_readings",
    "x_m",
    "y_m",
    "z_m",
];

/// Worlds of an experiment's robot in lanes.
#[pyclass(frozen)]
pub(crate) struct Worlds {
    inner: Exclusive<runner::session::Worlds>,
    /// Names of the readings: positions, then contacts.
    #[pyo3(get)]
    sensors: Vec<String>,
    /// How many of the readings are contacts, 0 or 1, the last ones.
    #[pyo3(get)]
    n_contacts: usize,
    /// Names of the actuators.
    #[pyo3(get)]
    actuators: Vec<String>,
    /// Control steps in a second.
    #[pyo3(get)]
    frequency_hz: f64,
    /// Physics steps in a control step.
    #[pyo3(get)]
    physics_steps: u64,
    /// All settings, as an experiment file.
    #[pyo3(get)]
    settings: String,
}

/// What a step came to.
type Told<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Vec<Option<String>>);

#[pymethods]
impl Worlds {
    /// So many worlds of a model, of an experiment file, or of an experiment with another model, with
    /// settings as of `--set`. A file that sweeps says with `setting` which of its settings is meant.
    #[new]
    #[pyo3(signature = (model, experiment, setting, changes, n_worlds))]
    fn new(
        py: Python<'_>,
        model: Option<PathBuf>,
        experiment: Option<PathBuf>,
        setting: Option<String>,
        changes: Vec<String>,
        n_worlds: usize,
    ) -> PyResult<Self> {
        Ok(py.detach(|| -> Result<_, Failure> {
            let experiment = open(model, experiment, setting.as_deref(), changes)?;
            let morphology = models::open(&experiment)?;
            let layout = recorded_layout(&experiment, &morphology);
            Ok(Self {
                sensors: layout.sensors,
                n_contacts: morphology.contacts().len(),
                actuators: layout.actuators,
                frequency_hz: experiment.control.frequency_hz,
                physics_steps: experiment.physics_steps_per_control_step(),
                settings: experiment.to_toml(),
                inner: Exclusive::new(
                    "the environment",
                    runner::session::Worlds::new(experiment, morphology, n_worlds)?,
                ),
            })
        })?)
    }

    /// Names of what [`Worlds::step`] tells of each world: the terms of its reward, the first of which
    /// is the reward itself, and what else it did.
    #[classattr]
    const COLUMNS: [&'static str; Terms::NAMES.len() + MORE.len()] = columns();

    /// A world begins anew where the robot has settled: its readings.
    fn begin<'py>(
        &self,
        py: Python<'py>,
        world: usize,
        seed: u64,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let readings = py.detach(|| {
            self.inner.with(|worlds| {
                worlds.begin(world, seed)?;
                Ok(worlds.look(world)?.readings().values.clone())
            })
        })?;
        Ok(PyArray1::from_vec(py, readings))
    }

    /// A control step of the worlds that `moves` names, `[n_worlds]`, with targets `[n_worlds x
    /// n_actuators]`: readings of all `[n_worlds x n_readings]`; what each did, `[n_worlds x
    /// n_columns]`, zeros where it didn't move; and for each why it blew up, if it did.
    fn step<'py>(
        &self,
        py: Python<'py>,
        targets: PyReadonlyArray2<'py, f64>,
        moves: PyReadonlyArray1<'py, bool>,
    ) -> PyResult<Told<'py>> {
        let n_actuators = self.actuators.len();
        let expected = [moves.len(), n_actuators];
        if targets.shape() != expected {
            let found = targets.shape();
            let text = format!("targets of shape {expected:?} expected, got {found:?}");
            return Err(Failure::Refused(anyhow::Error::msg(text)).into());
        }
        let targets: Vec<f64> = targets.as_array().iter().copied().collect();
        let moves: Vec<bool> = moves.as_array().iter().copied().collect();
        let n_worlds = moves.len();
        let (readings, did, blew_up) = py.detach(|| {
            self.inner.with(|worlds| Ok(step(worlds, &targets, &moves, n_actuators)?))
        })?;
        let shaped = |values, n_columns| shaped(py, values, [n_worlds, n_columns]);
        Ok((shaped(readings, self.sensors.len())?, shaped(did, Self::COLUMNS.len())?, blew_up))
    }

    /// Gives the worlds back. All else is refused from then on.
    fn close(&self) -> PyResult<()> {
        Ok(self.inner.close()?)
    }
}

/// An array of two dimensions.
fn shaped(
    py: Python<'_>,
    values: Vec<f64>,
    shape: [usize; 2],
) -> PyResult<Bound<'_, PyArray2<f64>>> {
    use numpy::PyArrayMethods;
    PyArray1::from_vec(py, values).reshape(shape)
}

/// The names of the terms, and those of what else is told.
const fn columns() -> [&'static str; Terms::NAMES.len() + MORE.len()] {
    let mut columns = [""; Terms::NAMES.len() + MORE.len()];
    let mut i = 0;
    while i < columns.len() {
        let n_terms = Terms::NAMES.len();
        columns[i] = if i < n_terms { Terms::NAMES[i] } else { MORE[i - n_terms] };
        i += 1;
    }
    columns
}

/// One setting of an experiment.
fn open(
    model: Option<PathBuf>,
    experiment: Option<PathBuf>,
    setting: Option<&str>,
    mut changes: Vec<String>,
) -> anyhow::Result<Experiment> {
    let plan = match (model, experiment) {
        (None, None) => bail!("a model's file or an experiment's expected, got neither"),
        (Some(model), None) => Plan::of_model(&model, &changes)?,
        (model, Some(file)) => {
            if let Some(model) = model {
                let path = model.to_str().context("model: a path in UTF-8 expected")?;
                changes.push(format!("model={}", toml::Value::from(path)));
            }
            Plan::open(&file, &changes)?
        }
    };
    let settings: BTreeSet<&str> = plan.cells().iter().map(|it| it.setting.as_str()).collect();
    let all = || settings.iter().copied().collect::<Vec<_>>().join(", ");
    let setting = match setting {
        Some(setting) => setting,
        None => {
            ensure!(settings.len() == 1, "setting: one of {} expected, got none", all());
            &plan.cells()[0].setting
        }
    };
    let cell = plan.cells().iter().find(|cell| cell.setting == setting);
    let cell =
        cell.with_context(|| format!("setting: one of {} expected, got {setting}", all()))?;
    Ok(cell.experiment.clone())
}

/// Readings, what each world did, and why it blew up.
type Steps = (Vec<f64>, Vec<f64>, Vec<Option<String>>);

fn step(
    worlds: &mut runner::session::Worlds,
    targets: &[f64],
    moves: &[bool],
    n_actuators: usize,
) -> anyhow::Result<Steps> {
    let mut given = targets.chunks(n_actuators.max(1));
    let given: Vec<_> = moves.iter().map(|&moves| given.next().filter(|_| moves)).collect();
    let results = worlds.step(&given)?;
    let (mut readings, mut table, mut blew_up) = (Vec::new(), Vec::new(), Vec::new());
    for (world, result) in results.into_iter().enumerate() {
        let episode = worlds.look(world)?;
        readings.extend_from_slice(&episode.readings().values);
        let (row, reason) = match result {
            Some(Stepped::Did(did)) => (row(&did, episode), None),
            Some(Stepped::BlewUp(reason)) => ([0.0; Worlds::COLUMNS.len()], Some(reason)),
            None => ([0.0; Worlds::COLUMNS.len()], None),
        };
        table.extend(row);
        blew_up.push(reason);
    }
    Ok((readings, table, blew_up))
}

/// In the order of [`Worlds::COLUMNS`].
fn row(did: &Evaluation, episode: &Episode) -> [f64; Worlds::COLUMNS.len()] {
    let mut row = [0.0; Worlds::COLUMNS.len()];
    let centre = episode.state().centre_of_gravity_m;
    let values = did.terms.as_array().into_iter().chain([
        did.advance_m,
        did.heading_change_rad,
        did.penalised_contacts as f64,
        did.clipped_readings as f64,
        centre.x,
        centre.y,
        centre.z,
    ]);
    row.iter_mut().zip(values).for_each(|(to, value)| *to = value);
    row
}
