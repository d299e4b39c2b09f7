//! Where a cell stands, also while it runs: nothing is disturbed.

use std::fs;

use super::{
    Cell, CellFolder, Error, Expected, Header, Row, Signature, Writer, is_locked, read_last,
};

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
    /// Its files can't be read, or aren't what was written, for this reason.
    Unreadable(String),
}

/// How much of a cell that nobody is at is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// What tells where it stands: headers, lengths, the newest row. Bytes that changed within a file
    /// aren't noticed.
    Quick,
    /// All of its checkpoint and metrics, as a resume would.
    Thorough,
}

/// Where a cell stands.
#[derive(Clone, Debug, PartialEq)]
pub struct CellStatus {
    /// Its number in the manifest.
    pub index: usize,
    /// The swept settings, as its folder is named.
    pub setting: String,
    /// The seed that its random numbers come from.
    pub seed: u64,
    /// The state that it's in.
    pub state: State,
    /// Updates in its checkpoint, from where it would go on; 0 without one.
    pub saved_updates: u64,
    /// Updates that it's to have.
    pub target_updates: u64,
    /// Its newest row, which may be ahead of the checkpoint.
    pub latest: Option<Row>,
    /// Who is at it, where it's running and its lock says so.
    pub writer: Option<Writer>,
    /// Updates in a second since that one came to it, once there is one.
    pub pace: Option<f64>,
}

impl CellStatus {
    /// A cell that's to have `target_updates`, as it was seen. One that can't be read says why.
    #[must_use]
    pub fn new(cell: &Cell, target_updates: u64, look: Result<Inspection, Error>) -> Self {
        let Inspection { state, saved_updates, latest, writer, pace } =
            look.unwrap_or_else(|error| Inspection {
                state: State::Unreadable(error.to_string()),
                saved_updates: 0,
                latest: None,
                writer: None,
                pace: None,
            });
        Self {
            index: cell.index,
            setting: cell.setting.clone(),
            seed: cell.seed,
            state,
            saved_updates,
            target_updates,
            latest,
            writer,
            pace,
        }
    }

    /// Updates done: of a running cell those in its metrics, else those in its checkpoint.
    #[must_use]
    pub fn updates(&self) -> u64 {
        match (&self.state, &self.latest) {
            (State::Running, Some(row)) => row.update.max(self.saved_updates),
            _ => self.saved_updates,
        }
    }
}

/// What can be seen of a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// The state that it's in.
    pub state: State,
    /// Updates in its checkpoint; 0 without one.
    pub saved_updates: u64,
    /// Its newest row.
    pub latest: Option<Row>,
    /// Who is at it, where it's running and its lock says so.
    pub writer: Option<Writer>,
    /// Updates in a second since that one came to it, once there is one.
    pub pace: Option<f64>,
}

impl CellFolder {
    /// Where the cell stands.
    ///
    /// The lock is asked first: a cell that ends meanwhile is then still running, and not stopped
    /// before its last checkpoint.
    ///
    /// # Errors
    /// As [`CellFolder::whole`].
    pub fn inspect(&self, expected: Expected, look: Look) -> Result<Inspection, Error> {
        let is_running = is_locked(&self.lock())?;
        let header = match (is_running, look) {
            (true, _) => Header::read(&self.checkpoint())?,
            (false, Look::Quick) => self.glance(expected)?,
            (false, Look::Thorough) => self.whole(expected)?.map(|checkpoint| checkpoint.header),
        };
        let saved_updates = header.map(|header| header.updates);
        let state = match (self.failure()?, saved_updates) {
            (Some(reason), _) => State::Failed(reason),
            (None, _) if is_running => State::Running,
            (None, None) => State::Waiting,
            (None, Some(updates)) if updates >= expected.updates => State::Done,
            (None, Some(_)) => State::Stopped,
        };
        let latest = read_last(&self.metrics())?;
        let signature = if is_running { Signature::read(&self.lock())? } else { None };
        let pace = signature.as_ref().and_then(|it| self.pace(it.updates, latest?.update));
        let (saved_updates, writer) = (saved_updates.unwrap_or(0), signature.map(|it| it.writer));
        Ok(Inspection { state, saved_updates, latest, writer, pace })
    }

    /// Updates in a second since the lock was signed, which was at `from`, by the file system's clock.
    fn pace(&self, from: u64, update: u64) -> Option<f64> {
        let changed = |path| fs::metadata(path).and_then(|it| it.modified()).ok();
        let time = changed(self.metrics())?.duration_since(changed(self.lock())?).ok()?;
        let made = update.checked_sub(from).filter(|&made| made > 0)?;
        Some(made as f64 / time.as_secs_f64().max(1e-3))
    }
}

#[cfg(test)]
mod tests {
    use std::{collections::BTreeMap, fs, path::Path};

    use super::*;
    use crate::{OpenCell, Snapshot};

    const TARGET: u64 = 4;
    const EXPECTED: Expected = Expected { identity: 7, updates: TARGET, steps_per_update: 10 };

    fn folder(parent: &Path, index: u64) -> CellFolder {
        CellFolder::new(parent.join(format!("seed={index}")))
    }

    /// A cell with a checkpoint at `saved` and `rows` rows.
    fn open(folder: CellFolder, saved: u64, rows: u64) -> OpenCell {
        let (mut cell, _) = OpenCell::open(folder, EXPECTED).unwrap();
        for update in 1..=rows {
            cell.append(&Row { update, ..Row::default() }).unwrap();
            if update == saved {
                let sections = BTreeMap::from([("world".to_string(), vec![1; 9])]);
                let (policy, replay) = (&[][..], &[][..]);
                let control_steps = 10 * saved;
                cell.save(Snapshot { updates: saved, control_steps, sections, policy, replay })
                    .unwrap();
            }
        }
        cell
    }

    fn seen(folder: &CellFolder, updates: u64, look: Look) -> CellStatus {
        let cell = Cell { index: 0, setting: String::new(), seed: 0 };
        CellStatus::new(&cell, updates, folder.inspect(Expected { updates, ..EXPECTED }, look))
    }

    /// A quick look and a thorough one, which agree.
    fn status(folder: &CellFolder, updates: u64) -> CellStatus {
        let [quick, thorough] =
            [Look::Quick, Look::Thorough].map(|look| seen(folder, updates, look));
        assert_eq!(quick.state, thorough.state);
        thorough
    }

    #[test]
    fn every_state_is_told() {
        let parent = tempfile::tempdir().unwrap();
        let cells: Vec<_> = (0..8).map(|index| folder(parent.path(), index)).collect();
        let cell = |index: usize| cells[index].clone();
        drop(open(cell(1), 0, 1));
        let running = open(cell(2), 2, 3);
        drop(open(cell(3), 2, 3));
        drop(open(cell(4), TARGET, TARGET));
        let mut failing = open(cell(5), 2, 3);
        failing.fail("blew up").unwrap();
        fs::write(open(cell(6), 2, 3).folder().checkpoint(), "?").unwrap();
        let beginning = open(cell(7), 0, 0);

        let found: Vec<_> = cells
            .iter()
            .map(|folder| status(folder, TARGET))
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
        let this = Some(Writer::this().clone());
        assert_eq!([2, 3].map(|index| status(&cells[index], TARGET).writer), [this, None]);
        drop((running, beginning));
        assert_eq!(status(&cells[2], TARGET).state, State::Stopped);
        assert_eq!(status(&cells[2], 2).state, State::Done);
    }

    /// What a resume would refuse isn't called stopped, nor done.
    #[test]
    fn a_thorough_look_tells_damage_of_every_byte() {
        let parent = tempfile::tempdir().unwrap();
        let cell = folder(parent.path(), 0);
        drop(open(cell.clone(), 2, 3));
        let known = cell.header(EXPECTED).unwrap().unwrap().metrics.length as usize;
        for (path, bytes) in [cell.checkpoint(), cell.metrics()].map(|path| {
            let bytes = fs::read(&path).unwrap();
            (path, bytes)
        }) {
            let length = if path == cell.metrics() { known } else { bytes.len() };
            for place in (0..length).step_by(7).chain([length - 1]) {
                let mut flipped = bytes.clone();
                flipped[place] ^= 4;
                fs::write(&path, flipped).unwrap();
                let state = seen(&cell, TARGET, Look::Thorough).state;
                assert!(matches!(state, State::Unreadable(_)), "{} {place}", path.display());
            }
            fs::write(&path, bytes).unwrap();
        }
        assert_eq!(status(&cell, TARGET).state, State::Stopped);
        assert!(matches!(status(&cell, 1).state, State::Unreadable(_)));
    }

    /// What lacks bytes is named by a quick look as by a thorough one.
    #[test]
    fn a_quick_look_tells_what_is_missing_or_cut_off() {
        let parent = tempfile::tempdir().unwrap();
        let cell = folder(parent.path(), 0);
        drop(open(cell.clone(), 2, 3));
        let known = cell.header(EXPECTED).unwrap().unwrap().metrics.length as usize;
        for (path, end) in [(cell.checkpoint(), usize::MAX), (cell.metrics(), known)] {
            let bytes = fs::read(&path).unwrap();
            for length in (0..bytes.len().min(end)).step_by(7) {
                fs::write(&path, &bytes[..length]).unwrap();
                let state = status(&cell, TARGET).state;
                assert!(matches!(state, State::Unreadable(_)), "{} {length}", path.display());
            }
            fs::remove_file(&path).unwrap();
            assert!(matches!(status(&cell, TARGET).state, State::Unreadable(_)));
            fs::write(&path, bytes).unwrap();
        }
        assert_eq!(status(&cell, TARGET).state, State::Stopped);
    }

    /// It doesn't read what it needn't: 10,000 cells are looked at in a moment.
    #[test]
    fn a_quick_look_does_not_read_what_a_checkpoint_holds() {
        let parent = tempfile::tempdir().unwrap();
        let cell = folder(parent.path(), 0);
        drop(open(cell.clone(), 2, 3));
        let mut bytes = fs::read(cell.checkpoint()).unwrap();
        let last = bytes.len() - 1;
        bytes[last] ^= 1;
        fs::write(cell.checkpoint(), bytes).unwrap();
        assert_eq!(seen(&cell, TARGET, Look::Quick).state, State::Stopped);
        assert!(matches!(seen(&cell, TARGET, Look::Thorough).state, State::Unreadable(_)));
    }
}
