//! A learned policy that draws its actions, as `itarl rollout` has it.

use numpy::{PyArray1, PyReadonlyArray1};
use policy::Policy;
use pyo3::prelude::*;
use runner::{
    experiment::Experiment,
    session::{Codec, codec_shape},
};
use svenja::Morphology;

use crate::failure::Exclusive;

/// A policy with random numbers of its own, and with the readings that it remembers.
#[pyclass(frozen)]
pub(crate) struct Sampler {
    inner: Exclusive<Inner>,
}

struct Inner {
    codec: Codec,
    policy: Box<dyn Policy>,
    /// `[n_outputs]`
    action: Vec<bool>,
    /// `[n_actuators]`
    targets: Vec<f64>,
}

impl Sampler {
    /// Draws from the start of a named stream of a seed.
    pub(crate) fn new(
        experiment: &Experiment,
        morphology: &Morphology,
        mut policy: Box<dyn Policy>,
        seed: u64,
        stream: &str,
    ) -> anyhow::Result<Self> {
        policy.draw_from(seed, stream);
        let inner = Inner {
            codec: Codec::new(&codec_shape(experiment, morphology))?,
            action: vec![false; policy.n_outputs()],
            targets: vec![0.0; morphology.actuators().len()],
            policy,
        };
        Ok(Self { inner: Exclusive::new("the sampler", inner) })
    }
}

/// `[n_outputs]` and `[n_actuators]`
type Drawn<'py> = (Bound<'py, PyArray1<bool>>, Bound<'py, PyArray1<f64>>);

#[pymethods]
impl Sampler {
    /// Takes in the next reading, and draws an action: its bits, and the targets that they mean.
    fn draw<'py>(
        &self,
        py: Python<'py>,
        reading: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Drawn<'py>> {
        let reading: Vec<f64> = reading.as_array().iter().copied().collect();
        let (bits, targets) = py.detach(|| {
            self.inner.with(|it| {
                it.codec.encode(&reading)?;
                it.policy.act(it.codec.inputs(), &mut it.action)?;
                it.codec.decode(&it.action, &mut it.targets)?;
                Ok((it.action.clone(), it.targets.clone()))
            })
        })?;
        Ok((PyArray1::from_vec(py, bits), PyArray1::from_vec(py, targets)))
    }
}
