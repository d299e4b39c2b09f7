//! A cell's folder: what one training instance leaves, and in which order it's written.
//!
//! [`OpenCell::save`] has the order: first the metrics are forced to the disk, then the checkpoint
//! that counts on them takes its name, then the exports follow. Killed in between, the older
//! checkpoint goes on from metrics that are cut back, or the exports are older than the checkpoint
//! until the next one; after the last one [`OpenCell::export`] makes up for it.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use super::{
    Appended, Checkpoint, Error, Expected, Header, Lock, Row, atomic,
    atomic::make_folder,
    error::At,
    metrics::read_columns,
    row::{Columns, header_line},
};

/// The folder of a cell and the names in it. Nothing needs to be there yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellFolder(PathBuf);

/// What is saved at a checkpoint.
#[derive(Debug)]
pub struct Snapshot<'a> {
    /// The number of updates done.
    pub updates: u64,
    /// The number of control steps done.
    pub control_steps: u64,
    /// The whole state, by parts.
    pub sections: BTreeMap<String, Vec<u8>>,
    /// The bytes of `policy.safetensors`, derived from that state.
    pub policy: &'a [u8],
    /// The bytes of `replay.safetensors`, derived from that state.
    pub replay: &'a [u8],
}

impl CellFolder {
    /// A folder, there or not.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self(path.into())
    }

    /// The path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// The path of `metrics.csv`.
    #[must_use]
    pub fn metrics(&self) -> PathBuf {
        self.0.join("metrics.csv")
    }

    /// The path of `checkpoint`.
    #[must_use]
    pub fn checkpoint(&self) -> PathBuf {
        self.0.join("checkpoint")
    }

    /// The path of `policy.safetensors`.
    #[must_use]
    pub fn policy(&self) -> PathBuf {
        self.0.join("policy.safetensors")
    }

    /// The path of `replay.safetensors`.
    #[must_use]
    pub fn replay(&self) -> PathBuf {
        self.0.join("replay.safetensors")
    }

    /// The path of `failed`.
    #[must_use]
    pub fn failed(&self) -> PathBuf {
        self.0.join("failed")
    }

    /// The path of `lock`.
    #[must_use]
    pub fn lock(&self) -> PathBuf {
        self.0.join("lock")
    }

    /// Why the cell ended; none if it didn't fail.
    ///
    /// # Errors
    /// If the file is there and can't be read.
    pub fn failure(&self) -> Result<Option<String>, Error> {
        let bytes = atomic::read(&self.failed())?;
        Ok(bytes.map(|bytes| String::from_utf8_lossy(&bytes).trim_end().to_string()))
    }

    /// That nothing was derived from a checkpoint, where there's none: it was lost then.
    pub(super) fn require_no_exports(&self) -> Result<(), Error> {
        let exports = [self.policy(), self.replay()];
        let Some(export) = exports.iter().find(|path| path.exists()) else { return Ok(()) };
        let name = export.file_name().unwrap_or_default().display();
        let what =
            format!("missing, though {name} was made from one: put it back, or delete the folder");
        Err(Error::damaged(&self.checkpoint(), what))
    }
}

/// A cell that this process writes to, alone.
pub struct OpenCell {
    folder: CellFolder,
    identity: u64,
    metrics: Appended,
    columns: Columns,
    lock: Lock,
    /// At its checkpoint when it was opened.
    updates: u64,
    /// Whether the lock has the name of this process.
    is_signed: bool,
    /// Of the last checkpoint that this process wrote.
    written: Option<Header>,
}

impl OpenCell {
    /// Makes the folder if it isn't there, locks it, and opens what is in it: at its checkpoint, or
    /// at the beginning if there's none. A cell that failed is opened like any other:
    /// [`CellFolder::failure`] says so.
    ///
    /// # Errors
    /// [`Error::Locked`]; [`Error::Damaged`], [`Error::Version`], [`Error::OtherCell`] or
    /// [`Error::Beyond`], with nothing overwritten; what the system refuses.
    pub fn open(
        folder: CellFolder,
        expected: Expected,
    ) -> Result<(Self, Option<Checkpoint>), Error> {
        make_folder(folder.path())?;
        let lock = Lock::acquire(&folder.lock())?;
        let checkpoint = Checkpoint::read(&folder.checkpoint(), expected)?;
        let metrics = match &checkpoint {
            Some(checkpoint) => Appended::open(&folder.metrics(), checkpoint.header.metrics)?,
            None => begin(&folder)?,
        };
        // It goes on as it was begun, so that its bytes don't depend on who goes on with it.
        let columns = read_columns(&folder.metrics())?
            .ok_or_else(|| Error::damaged(&folder.metrics(), "it has no first line"))?;
        let identity = expected.identity;
        let updates = checkpoint.as_ref().map_or(0, |it| it.header.updates);
        let (is_signed, written) = (false, None);
        let cell = Self { folder, identity, metrics, columns, lock, updates, is_signed, written };
        Ok((cell, checkpoint))
    }

    /// The cell's folder.
    #[must_use]
    pub fn folder(&self) -> &CellFolder {
        &self.folder
    }

    /// Adds a row to the metrics. Readers see it at once.
    ///
    /// # Errors
    /// If it can't be written.
    pub fn append(&mut self, row: &Row) -> Result<(), Error> {
        let line = self.columns.line(row);
        let line = line.at(&self.folder.metrics(), "putting a row together")?;
        self.metrics.append(line.as_bytes())
    }

    /// Makes a checkpoint, then the exports.
    ///
    /// # Errors
    /// If something can't be written. There's then either the older checkpoint or this one, whole.
    /// [`Error::Moved`], [`Error::Foreign`] or [`Error::ForeignCheckpoint`] if the cell isn't this
    /// process's any more.
    pub fn save(&mut self, snapshot: Snapshot<'_>) -> Result<(), Error> {
        let Snapshot { updates, control_steps, sections, policy, replay } = snapshot;
        let metrics = self.metrics.sync()?;
        let header = Header { identity: self.identity, updates, control_steps, metrics };
        self.write(&self.folder.checkpoint(), &Checkpoint { header, sections }.encode())?;
        self.written = Some(header);
        self.write(&self.folder.policy(), policy)?;
        self.write(&self.folder.replay(), replay)
    }

    /// Replaces the exports that aren't these, which are derived from the checkpoint's state.
    ///
    /// # Errors
    /// If something can't be read or written.
    pub fn export(&mut self, policy: &[u8], replay: &[u8]) -> Result<(), Error> {
        for (path, bytes) in [(self.folder.policy(), policy), (self.folder.replay(), replay)] {
            if atomic::read(&path)?.as_deref() != Some(bytes) {
                self.write(&path, bytes)?;
            }
        }
        Ok(())
    }

    /// Marks the cell as failed, with the reason for a human reader. The rows until then are kept.
    ///
    /// # Errors
    /// If it can't be written.
    pub fn fail(&mut self, reason: &str) -> Result<(), Error> {
        self.metrics.sync()?;
        self.write(&self.folder.failed(), format!("{reason}\n").as_bytes())
    }

    /// Leaves the name of this process in the lock: from then on, another one that comes to the cell,
    /// too, is noticed before anything is written. The first write does it otherwise.
    ///
    /// # Errors
    /// If it can't be written.
    pub fn sign(&mut self) -> Result<(), Error> {
        self.lock.sign(self.updates)?;
        self.is_signed = true;
        Ok(())
    }

    /// A whole file, if the folder at the path is still the one that is locked: after a rename it may
    /// be that of another run. And if nobody else writes here, as may be where locks don't hold.
    fn write(&mut self, path: &Path, bytes: &[u8]) -> Result<(), Error> {
        self.lock.require()?;
        match self.is_signed {
            true => self.lock.require_signature()?,
            false => self.sign()?,
        }
        self.written.map_or(Ok(()), |written| self.require_checkpoint(written))?;
        atomic::write(path, bytes)
    }

    /// That no other process replaced the checkpoint that this one wrote. Before it wrote one, the
    /// process before may have: that one sees this one's name in the lock, and leaves.
    fn require_checkpoint(&self, written: Header) -> Result<(), Error> {
        let path = self.folder.checkpoint();
        match Header::read(&path) {
            Ok(Some(found)) if found != written => {
                let (found, written) = (found.updates, written.updates);
                Err(Error::ForeignCheckpoint { path, found, written })
            }
            // What was lost or damaged meanwhile, this process still has.
            Ok(_) | Err(Error::Damaged { .. }) => Ok(()),
            Err(error) => Err(error),
        }
    }
}

/// Metrics with the first line alone. Exports without a checkpoint aren't a beginning: the
/// checkpoint was lost, and the rows, which may be all that's left, stay.
fn begin(folder: &CellFolder) -> Result<Appended, Error> {
    folder.require_no_exports()?;
    let mut metrics = Appended::begin(&folder.metrics())?;
    metrics.append(header_line().as_bytes())?;
    Ok(metrics)
}

#[cfg(test)]
mod tests;
