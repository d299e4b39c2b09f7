//! Cells over threads. A cell's result doesn't depend on which thread trains it, or beside which
//! others.

use std::{
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use super::{Ending, Lab, LabCell, Limits, Stop, train_cell};
use crate::store::Row;

/// Is told how training goes, from all threads.
pub trait Observer: Sync {
    /// A cell goes on from so many updates.
    fn begin(&self, cell: &LabCell, updates: u64);
    /// A cell made an update.
    fn row(&self, cell: &LabCell, row: &Row);
    /// A cell's training ended in this call.
    fn end(&self, cell: &LabCell, ending: &Ending);
}

/// Trains all cells of a run, in the order of their indices as threads get free. The endings are
/// those of the cells, by index; a cell that wasn't begun counts as stopped.
#[must_use]
pub fn train_all(
    lab: &Lab,
    n_threads: usize,
    limits: Limits,
    stop: &Stop,
    observer: &dyn Observer,
) -> Vec<Ending> {
    let next = AtomicUsize::new(0);
    let endings: Mutex<Vec<Option<Ending>>> =
        Mutex::new(lab.cells().iter().map(|_| None).collect());
    thread::scope(|scope| {
        for _ in 0..n_threads.clamp(1, lab.cells().len().max(1)) {
            scope.spawn(|| {
                while !stop.is_wished() {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(cell) = lab.cells().get(index) else { break };
                    let ending = train_cell(lab, cell, limits, stop, observer);
                    observer.end(cell, &ending);
                    endings.lock().unwrap_or_else(PoisonError::into_inner)[index] = Some(ending);
                }
            });
        }
    });
    let endings = endings.into_inner().unwrap_or_else(PoisonError::into_inner);
    endings.into_iter().map(|ending| ending.unwrap_or(Ending::Stopped)).collect()
}
