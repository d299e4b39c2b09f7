//! A run's folder, as every reader of the lab believes it.

use std::path::PathBuf;

use anyhow::Context;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::{prelude::*, types::PyDict};
use runner::{
    catalogue::{Catalogue, RunCell},
    session::learned_policy,
};
use runs::{COLUMNS, Recording};
use safetensors::{Dtype, SafeTensors};

use crate::{failure::Failure, sampler::Sampler};

/// A run, opened to be read.
#[pyclass(frozen)]
pub(crate) struct RunFolder {
    catalogue: Catalogue,
}

#[pymethods]
impl RunFolder {
    #[new]
    fn open(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        let catalogue = py.detach(|| Catalogue::open(&folder)).map_err(Failure::Refused)?;
        Ok(Self { catalogue })
    }

    /// The experiment's text.
    fn experiment(&self) -> &str {
        self.catalogue.run().experiment()
    }

    /// Updates that a row is the mean of: 1, but in a published run.
    fn every(&self) -> u64 {
        self.catalogue.every()
    }

    /// Of each cell its setting, its seed, its folder and its settings as an experiment file.
    fn cells(&self) -> Vec<(String, u64, PathBuf, String)> {
        let cells = self.catalogue.cells().iter().map(|it| {
            let (cell, folder) = (&it.cell, it.folder.path().to_path_buf());
            (cell.setting.clone(), cell.seed, folder, cell.experiment.to_toml())
        });
        cells.collect()
    }

    /// Why a cell ended before its end, if it did.
    fn failure(&self, index: usize) -> PyResult<Option<String>> {
        Ok(self.cell(index)?.folder.failure().map_err(Failure::from)?)
    }

    /// A cell's rows: columns by name, `[n_rows]` each.
    fn rows<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyDict>> {
        let cell = self.cell(index)?;
        let rows = py.detach(|| self.catalogue.rows(cell)).map_err(Failure::from)?;
        let columns = PyDict::new(py);
        for column in COLUMNS {
            let values = rows.iter().map(column.value).collect();
            columns.set_item(column.name, PyArray1::from_vec(py, values))?;
        }
        Ok(columns)
    }

    /// What a cell has learned: the kind of its policy, and the tensors of its file by name.
    fn policy<'py>(
        &self,
        py: Python<'py>,
        index: usize,
    ) -> PyResult<(&'static str, Bound<'py, PyDict>)> {
        let cell = self.cell(index)?;
        let bytes = py.detach(|| -> Result<_, Failure> {
            self.catalogue.check(cell)?;
            let morphology = self.catalogue.morphology(cell)?;
            let settings = &cell.cell.experiment;
            let policy = learned_policy(settings, &morphology, &cell.folder.policy())?;
            Ok(policy.to_safetensors()?)
        })?;
        let kind = cell.cell.experiment.policy.kind.name();
        Ok((kind, tensors(py, &bytes)?))
    }

    /// What a cell has learned, drawing from the start of a named stream of a seed.
    fn sampler(&self, py: Python<'_>, index: usize, seed: u64, stream: &str) -> PyResult<Sampler> {
        let cell = self.cell(index)?;
        Ok(py.detach(|| -> Result<_, Failure> {
            self.catalogue.check(cell)?;
            let morphology = self.catalogue.morphology(cell)?;
            let settings = &cell.cell.experiment;
            let policy = learned_policy(settings, &morphology, &cell.folder.policy())?;
            Ok(Sampler::new(settings, &morphology, policy, seed, stream)?)
        })?)
    }

    /// A cell's last control steps, if it has recorded some: what its arrays are of, and the arrays.
    fn recording<'py>(
        &self,
        py: Python<'py>,
        index: usize,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let cell = self.cell(index)?;
        let read = py.detach(|| -> Result<_, Failure> {
            self.catalogue.check(cell)?;
            Ok(Recording::read(&cell.folder.replay())?)
        })?;
        read.map(|recording| arrays(py, recording)).transpose()
    }
}

impl RunFolder {
    fn cell(&self, index: usize) -> Result<&RunCell, Failure> {
        let cells = self.catalogue.cells();
        let cell = cells.get(index);
        Ok(cell.with_context(|| format!("cells are 0 to {}, got {index}", cells.len() - 1))?)
    }
}

/// The tensors of a policy's file.
fn tensors<'py>(py: Python<'py>, bytes: &[u8]) -> PyResult<Bound<'py, PyDict>> {
    let by_name = PyDict::new(py);
    let file = SafeTensors::deserialize(bytes).map_err(Failure::from)?;
    for (name, view) in file.iter() {
        let (shape, data) = (view.shape(), view.data());
        let array = match view.dtype() {
            Dtype::F64 => {
                let number = |bytes: &[u8; 8]| f64::from_le_bytes(*bytes);
                shaped(py, data.as_chunks().0.iter().map(number).collect(), shape)?.into_any()
            }
            Dtype::BOOL => {
                shaped(py, data.iter().map(|&it| it != 0).collect::<Vec<bool>>(), shape)?.into_any()
            }
            other => Err(unknown(name, other))?,
        };
        by_name.set_item(name, array)?;
    }
    Ok(by_name)
}

fn unknown(name: &str, dtype: Dtype) -> Failure {
    Failure::Refused(anyhow::anyhow!("tensor {name}: F64 or BOOL expected, got {dtype:?}"))
}

/// A recording's names and arrays, as docs/run-folders.md has them.
fn arrays(py: Python<'_>, recording: Recording) -> PyResult<Bound<'_, PyDict>> {
    let (layout, t) = (recording.layout, recording.n_steps);
    let (f, b) = (layout.frames_per_step, layout.bodies.len());
    let (sensors, actuators, terms) =
        (layout.sensors.len(), layout.actuators.len(), layout.terms.len());
    let by_name = PyDict::new(py);
    by_name.set_item("first_control_step", recording.first_control_step)?;
    by_name.set_item("seconds_per_frame", layout.seconds_per_frame)?;
    by_name.set_item("bodies", layout.bodies)?;
    by_name.set_item("sensor_names", layout.sensors)?;
    by_name.set_item("actuator_names", layout.actuators)?;
    by_name.set_item("term_names", layout.terms)?;
    by_name.set_item("poses", shaped(py, recording.poses, &[t, f, b, 7])?)?;
    by_name.set_item("sensors", shaped(py, recording.sensors, &[t, sensors])?)?;
    by_name.set_item("actions", shaped(py, recording.actions, &[t, actuators])?)?;
    by_name.set_item("contacts", shaped(py, recording.contacts, &[t, b])?)?;
    by_name.set_item("terms", shaped(py, recording.terms, &[t, terms])?)?;
    Ok(by_name)
}

fn shaped<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    PyArray1::from_vec(py, values).reshape(shape)
}
