//! What can go wrong with a run's files: which file, what was being done, what to do about it.

use std::{
    fmt, io,
    path::{Path, PathBuf},
};

use rustix::io::Errno;

use super::Writer;

/// Why something couldn't be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused.
    #[error("{}: {doing}: {cause}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was being done with it, as in "writing".
        doing: &'static str,
        /// Why it didn't work. Not called `source`: whoever prints a chain of errors has it already.
        cause: io::Error,
    },
    /// A file isn't as it was written. Nothing was overwritten.
    #[error("{}: damaged: {what}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where in the file.
        what: String,
    },
    /// Whole, but in another version of its format.
    #[error(
        "{}: format version {found}, and this program reads {expected}: go on with the itarl that \
         wrote it",
        path.display()
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// What the file says.
        found: u64,
        /// What would do.
        expected: u64,
    },
    /// Another process writes there.
    #[error("{}: another process is at work in this folder; wait for it or end it", path.display())]
    Locked {
        /// The folder.
        path: PathBuf,
    },
    /// The file system has no locks.
    #[error(
        "{}: this file system locks no files, so that two processes could be at one cell: choose a \
         folder elsewhere, or have it mounted with locks (Lustre: -o flock; NFS 3: with lockd): \
         {cause}",
        path.display()
    )]
    NoLocks {
        /// The file.
        path: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
    /// Another process writes where this one does, though it holds the lock.
    #[error(
        "{}: {writer} (since {}) writes to this cell, too, though it's locked here: locks of this file \
         system don't hold between machines (Lustre: mount it with -o flock, not localflock); this \
         process left the cell to that one",
        path.display(),
        writer.start
    )]
    Foreign {
        /// The cell's folder.
        path: PathBuf,
        /// The other one.
        writer: Writer,
    },
    /// Another process replaced the checkpoint of this one, though it holds the lock.
    #[error(
        "{}: another process wrote it, at update {found}, and this one's was at {written}; so that one is \
         at this cell, too, though it's locked here: locks of this file system don't hold between \
         machines (Lustre: mount it with -o flock, not localflock); this process left the cell to it",
        path.display()
    )]
    ForeignCheckpoint {
        /// The checkpoint.
        path: PathBuf,
        /// Updates in the one that is there.
        found: u64,
        /// Updates in the one that this process wrote last.
        written: u64,
    },
    /// The folder that this process locked is no longer the one at its path.
    #[error(
        "{}: no longer the folder that this process works in: it was renamed or removed, or its lock \
         was, and another process may be at work here; nothing was written",
        path.display()
    )]
    Moved {
        /// The folder.
        path: PathBuf,
    },
    /// A folder that is no run.
    #[error("{}: {what}", path.display())]
    NotARun {
        /// The folder.
        path: PathBuf,
        /// What is there instead, and what to do.
        what: &'static str,
    },
    /// A run that was made in another way.
    #[error(
        "{}: this run was made differently:{}\ngo on as it was made, or choose another folder",
        path.display(),
        Lines(differences)
    )]
    Differs {
        /// The run's folder.
        path: PathBuf,
        /// In what, at least one.
        differences: Vec<Difference>,
    },
    /// A published run, where one to go on with was asked for.
    #[error(
        "{}: a published run, to be read: it has means over {every} updates and no checkpoints, so \
         nothing can go on from it; go on with the run that it was made of, or choose another folder",
        path.display()
    )]
    Published {
        /// The folder.
        path: PathBuf,
        /// The number of updates that a row is the mean of.
        every: u64,
    },
    /// Fewer updates than the run has.
    #[error(
        "{}: learning.updates: {there} there, {here} here: a run can be extended, not cut short",
        path.display()
    )]
    Shorter {
        /// The run's folder.
        path: PathBuf,
        /// Updates of the run.
        there: i64,
        /// Updates that were asked for.
        here: i64,
    },
    /// A whole checkpoint, but not of this cell.
    #[error(
        "{}: of another cell: its settings or seed are not those of this folder; put the right \
         file back, or delete the cell's folder to begin it again",
        path.display()
    )]
    OtherCell {
        /// The checkpoint.
        path: PathBuf,
    },
    /// A checkpoint with more updates than its experiment has.
    #[error(
        "{}: damaged: it has {updates} updates, and the experiment ends at {most}; put the right file \
         back, or delete the cell's folder to begin it again",
        path.display()
    )]
    Beyond {
        /// The checkpoint.
        path: PathBuf,
        /// What it says.
        updates: u64,
        /// `learning.updates`
        most: u64,
    },
    /// An argument without meaning here.
    #[error("{call}: {argument} must be {expected}, got {value}")]
    Argument {
        /// The function that refused.
        call: &'static str,
        /// Its argument, or the part of it.
        argument: String,
        /// What it should be.
        expected: String,
        /// What it was.
        value: String,
    },
}

/// Something that isn't the same in a run's folder and in what is asked of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// What differs: a setting, as in `learning.rate`, or a file.
    pub what: String,
    /// The value in the folder.
    pub there: String,
    /// The value that is asked for.
    pub here: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {} there, {} here", self.what, self.there, self.here)
    }
}

/// The first ones, one a line: a sweep with another seed differs in every cell.
struct Lines<'a>(&'a [Difference]);

const SHOWN: usize = 10;

impl fmt::Display for Lines<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = &self.0[..self.0.len().min(SHOWN)];
        shown.iter().try_for_each(|difference| write!(formatter, "\n  {difference}"))?;
        match self.0.len() - shown.len() {
            0 => Ok(()),
            more => write!(formatter, "\n  and {more} more"),
        }
    }
}

impl Error {
    /// Whether the process, or the whole system, has as many files open as it may: no fault of the
    /// file.
    #[must_use]
    pub fn is_lack_of_files(&self) -> bool {
        let lacks = [Errno::MFILE, Errno::NFILE].map(|it| Some(it.raw_os_error()));
        matches!(self, Self::Io { cause, .. } if lacks.contains(&cause.raw_os_error()))
    }

    /// That a file isn't as it was written, with what is wrong and where in it.
    pub fn damaged(path: &Path, what: impl Into<String>) -> Self {
        Self::Damaged { path: path.into(), what: what.into() }
    }

    pub(crate) fn argument(
        call: &'static str,
        argument: impl Into<String>,
        expected: impl Into<String>,
        value: impl ToString,
    ) -> Self {
        let (argument, expected) = (argument.into(), expected.into());
        Self::Argument { call, argument, expected, value: value.to_string() }
    }
}

/// Names the file and what was being done with it.
pub(crate) trait At<T> {
    fn at(self, path: &Path, doing: &'static str) -> Result<T, Error>;
}

impl<T> At<T> for io::Result<T> {
    fn at(self, path: &Path, doing: &'static str) -> Result<T, Error> {
        self.map_err(|cause| Error::Io { path: path.into(), doing, cause })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_differences_are_cut_short() {
        let difference =
            |i| Difference { what: format!("cell {i}"), there: "a".into(), here: "b".into() };
        let shown = |n: usize| Lines(&(0..n).map(difference).collect::<Vec<_>>()).to_string();
        assert!(shown(10).ends_with("\n  cell 9: a there, b here"));
        assert!(shown(12).ends_with("\n  cell 9: a there, b here\n  and 2 more"));
    }
}
