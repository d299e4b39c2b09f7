//! The lab for Python: the module `itarl._itarl`, which the package `itarl` beside it makes pleasant.
//!
//! | file | what |
//! |---|---|
//! | `worlds.rs` | robots to act in: [`runner::session::Worlds`] |
//! | `runs.rs` | a run's folder: its cells, their rows, what they learned and recorded |
//! | `sampler.rs` | a learned policy that draws its actions |
//! | `failure.rs` | what goes wrong, as exceptions |
//!
//! What always holds: nothing that Python says panics or ends the process; whoever steps or reads
//! lets other Python threads run, and an object that one thread is at says so to another.

#![forbid(unsafe_code)]

mod failure;
mod runs;
mod sampler;
mod worlds;

use pyo3::prelude::*;

/// The module's contents.
#[pymodule(name = "_itarl")]
mod module {
    #[pymodule_export]
    use super::{failure::Error, runs::RunFolder, sampler::Sampler, worlds::Worlds};

    /// The version of the lab.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
