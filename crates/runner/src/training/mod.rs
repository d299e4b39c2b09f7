//! Training: the cells of a run, over the cores, until they're done or told to stop.

mod cell;
mod deadline;
mod open_run;
mod pool;
mod room;
mod stop;

pub use cell::Ending;
pub use deadline::time_limit;
pub use open_run::{OpenRun, check_files, this_bullet};
pub use pool::{Observer, Trained, train_all};
pub use stop::StopSignal;

pub use crate::catalogue::RunCell;

/// How far a call goes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Limits {
    /// Updates of a cell in this call; all there are by default.
    pub stop_after: Option<u64>,
}

/// Who steps the worlds; the bits are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum SolverKind {
    /// Worlds in the lanes of the processor's vectors
    #[default]
    Lockstep,
    /// Bullet's own solver, one world after the other
    Bullet,
}

/// How training is done: nothing of this changes a result.
#[derive(Clone, Copy, Debug)]
pub struct How {
    /// Threads, at least 1.
    pub threads: usize,
    /// Who steps the worlds.
    pub solver: SolverKind,
    /// Worlds that a thread steps at a time, at least 1; as many as the solver has lanes by default.
    pub lanes: Option<usize>,
    /// The limits of this call.
    pub limits: Limits,
}
