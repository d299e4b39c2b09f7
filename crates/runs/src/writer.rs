//! Who writes to a cell: its lock file has the name, so that people see who is where, and so that a
//! second writer is noticed where locks don't hold between machines.

use std::{fs::File, os::unix::fs::FileExt, path::Path, process, sync::LazyLock, time::SystemTime};

use serde::{Deserialize, Serialize};

use super::{Error, atomic, error::At};

/// A process, told apart from all others on all machines.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Writer {
    /// Name of its machine.
    pub host: String,
    /// Its number there.
    pub process: u32,
    /// When it began, in UTC, as in `2026-03-01T12:00:00.000000000Z`.
    pub start: String,
}

static THIS: LazyLock<Writer> = LazyLock::new(|| Writer {
    host: rustix::system::uname().nodename().to_string_lossy().into_owned(),
    process: process::id(),
    start: humantime::format_rfc3339_nanos(SystemTime::now()).to_string(),
});

impl Writer {
    /// This process.
    #[must_use]
    pub fn this() -> &'static Self {
        &THIS
    }
}

/// What a lock file says: who came last, and where the cell stood then.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Signature {
    /// Who it is.
    #[serde(flatten)]
    pub writer: Writer,
    /// Updates that the cell had when it came.
    pub updates: u64,
}

impl Signature {
    /// The one in a lock file. None in a file of an earlier version, which has none, and while it's
    /// being written.
    ///
    /// # Errors
    /// If the file is there and can't be read.
    pub fn read(path: &Path) -> Result<Option<Self>, Error> {
        let bytes = atomic::read(path)?;
        Ok(bytes.and_then(|bytes| serde_json::from_slice(&bytes).ok()))
    }

    /// Puts this process's one into a lock file, and forces it to where other machines see it.
    pub(super) fn write(path: &Path, file: &File, updates: u64) -> Result<(), Error> {
        let mut bytes = serde_json::to_vec(&Self { writer: Writer::this().clone(), updates })
            .map_err(|error| Error::argument("Lock::sign", "the signature", "JSON", error))?;
        bytes.push(b'\n');
        file.set_len(0)
            .and_then(|()| file.write_all_at(&bytes, 0))
            .and_then(|()| file.sync_data())
            .at(path, "writing who is at work")
    }
}

impl std::fmt::Display for Writer {
    /// `process 4711 on node7`
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "process {} on {}", self.process, self.host)
    }
}
