//! Training: the cells of a run, over the cores, until they're done or told to stop.

mod cell;
mod lab;
mod pool;
mod stop;

pub use cell::{Ending, train_cell};
pub use lab::{Lab, LabCell, this_bullet};
pub use pool::{Observer, train_all};
pub use stop::Stop;

/// How far a call goes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Limits {
    /// Updates of a cell in this call; all there are by default.
    pub stop_after: Option<u64>,
}
