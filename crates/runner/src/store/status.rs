//! Where each cell of a run stands, also while it runs: looked up in file ends, nothing disturbed.

use super::{CellFolder, Error, Header, Row, Run, is_locked, read_last};

/// What a cell is doing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// It has no checkpoint yet, and no process is at it.
    Waiting,
    /// A process is at it.
    Running,
    /// It goes on from its checkpoint when it's resumed.
    Stopped,
    /// It has all its updates.
    Done,
    /// It ended, for this reason.
    Failed(String),
    /// Its files can't be read, for this reason.
    Unreadable(String),
}

/// Where a cell stands.
#[derive(Clone, Debug, PartialEq)]
pub struct CellStatus {
    /// Its number in the manifest.
    pub index: usize,
    /// The swept settings, as its folder is named.
    pub setting: String,
    /// Its seed.
    pub seed: u64,
    /// What it's doing.
    pub state: State,
    /// Updates in its checkpoint, from where it would go on; 0 without one.
    pub saved_updates: u64,
    /// Updates that it's to have.
    pub target_updates: u64,
    /// Its newest row, which may be ahead of the checkpoint.
    pub latest: Option<Row>,
}

impl CellStatus {
    /// Updates done: of a running cell those in its metrics, else those in its checkpoint.
    #[must_use]
    pub fn updates(&self) -> u64 {
        match (&self.state, &self.latest) {
            (State::Running, Some(row)) => row.update.max(self.saved_updates),
            _ => self.saved_updates,
        }
    }
}

/// Where the cells stand, in the order of their indices. `target_of` has the `learning.updates` of a
/// cell, by index. A cell that can't be read doesn't hide the others.
#[must_use]
pub fn status(run: &Run, target_of: impl Fn(usize) -> u64) -> Vec<CellStatus> {
    let cells = run.manifest().cells.iter();
    cells
        .map(|cell| {
            let target_updates = target_of(cell.index);
            let (state, saved_updates, latest) = look(&run.cell(cell), target_updates)
                .unwrap_or_else(|error| (State::Unreadable(error.to_string()), 0, None));
            CellStatus {
                index: cell.index,
                setting: cell.setting.clone(),
                seed: cell.seed,
                state,
                saved_updates,
                target_updates,
                latest,
            }
        })
        .collect()
}

/// The lock is asked first: a cell that ends meanwhile is then still running, and not stopped
/// before its last checkpoint.
fn look(folder: &CellFolder, target_updates: u64) -> Result<(State, u64, Option<Row>), Error> {
    let is_running = is_locked(&folder.lock())?;
    let saved_updates = Header::read(&folder.checkpoint())?.map(|header| header.updates);
    let state = match (folder.failure()?, saved_updates) {
        (Some(reason), _) => State::Failed(reason),
        (None, _) if is_running => State::Running,
        (None, None) => State::Waiting,
        (None, Some(updates)) if updates >= target_updates => State::Done,
        (None, Some(_)) => State::Stopped,
    };
    Ok((state, saved_updates.unwrap_or(0), read_last(&folder.metrics())?))
}

#[cfg(test)]
mod tests {
    use std::{collections::BTreeMap, fs, path::Path};

    use super::*;
    use crate::store::{Bullet, Cell, NewRun, OpenCell, Precision, Snapshot};

    const TARGET: u64 = 4;

    fn run(folder: &Path, n_cells: usize) -> Run {
        let cells =
            (0..n_cells).map(|index| Cell { index, setting: "base".into(), seed: index as u64 });
        let new = NewRun {
            experiment: "learning.updates = 4".into(),
            itarl: "0.1.0".into(),
            bullet: Bullet { version: 325, precision: Precision::Single },
            models: Vec::new(),
            seeds: (0..n_cells as u64).collect(),
            cells: cells.collect(),
        };
        Run::create(folder, &new).unwrap()
    }

    /// A cell with a checkpoint at `saved` and `rows` rows.
    fn open(run: &Run, index: usize, saved: u64, rows: u64) -> OpenCell {
        let (mut cell, _) = OpenCell::open(run.cell(&run.manifest().cells[index]), 7).unwrap();
        for update in 1..=rows {
            cell.append(&Row { update, ..Row::default() }).unwrap();
            if update == saved {
                let sections = BTreeMap::new();
                let (policy, replay) = (&[][..], &[][..]);
                cell.save(Snapshot { updates: saved, control_steps: 0, sections, policy, replay })
                    .unwrap();
            }
        }
        cell
    }

    #[test]
    fn every_state_is_told() {
        let parent = tempfile::tempdir().unwrap();
        let run = run(&parent.path().join("run"), 8);
        drop(open(&run, 1, 0, 1));
        let running = open(&run, 2, 2, 3);
        drop(open(&run, 3, 2, 3));
        drop(open(&run, 4, TARGET, TARGET));
        let mut failing = open(&run, 5, 2, 3);
        failing.fail("blew up").unwrap();
        fs::write(open(&run, 6, 2, 3).folder().checkpoint(), "?").unwrap();
        let beginning = open(&run, 7, 0, 0);

        let found: Vec<_> = status(&run, |_| TARGET)
            .into_iter()
            .map(|it| (it.updates(), it.saved_updates, it.latest.map(|row| row.update), it.state))
            .collect();
        let unreadable = &found[6].3;
        assert!(
            matches!(unreadable, State::Unreadable(why) if why.contains("checkpoint: damaged"))
        );
        assert_eq!(
            found,
            [
                (0, 0, None, State::Waiting),
                (0, 0, Some(1), State::Waiting),
                (3, 2, Some(3), State::Running),
                (2, 2, Some(3), State::Stopped),
                (4, 4, Some(4), State::Done),
                (2, 2, Some(3), State::Failed("blew up".into())),
                (0, 0, None, unreadable.clone()),
                (0, 0, None, State::Running),
            ]
        );
        drop((running, beginning));
        assert_eq!(status(&run, |_| TARGET)[2].state, State::Stopped);
        let second_ends_sooner = status(&run, |index| if index == 2 { 2 } else { TARGET });
        assert_eq!(second_ends_sooner[2].state, State::Done);
        assert_eq!(second_ends_sooner[3].state, State::Stopped);
    }
}
