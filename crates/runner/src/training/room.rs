//! How many cells a process can be at, by the number of files that the system lets it hold open.

use std::fs;

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Files of a cell at work: its lock and its metrics.
const PER_CELL: usize = 2;
/// At most that many more while a thread reads or writes a cell's files.
const PER_THREAD: usize = 3;
/// For whatever else the process and its libraries may open.
const SPARE: usize = 8;

/// Cells at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Room {
    /// Threads, at least 1.
    pub(super) threads: usize,
    /// Cells of a thread, at least 1.
    pub(super) lanes: usize,
}

impl Room {
    /// The part of what's wanted that there are files for, once the system's limit on them is raised
    /// as far as this process may.
    pub(super) fn make(wanted: Self) -> Self {
        raise_limit();
        let limit = getrlimit(Resource::Nofile).current.and_then(|n| usize::try_from(n).ok());
        wanted.within(limit.unwrap_or(usize::MAX).saturating_sub(n_open() + SPARE))
    }

    /// The part of it that so many files are enough for; a cell at a time is always tried.
    fn within(self, files: usize) -> Self {
        let threads = self.threads.min(files / (PER_THREAD + PER_CELL)).max(1);
        let lanes = self.lanes.min((files / threads).saturating_sub(PER_THREAD) / PER_CELL).max(1);
        Self { threads, lanes }
    }
}

/// A process that may not raise it lives with what it has.
fn raise_limit() {
    let maximum = getrlimit(Resource::Nofile).maximum;
    let _ = setrlimit(Resource::Nofile, Rlimit { current: maximum, maximum });
}

/// Files that are open now, or many where the system doesn't tell.
fn n_open() -> usize {
    fs::read_dir("/proc/self/fd").map_or(32, Iterator::count)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn few_files_make_smaller_crews_and_then_fewer_threads() {
        let within = |threads, lanes, files| {
            let Room { threads, lanes } = Room { threads, lanes }.within(files);
            (threads, lanes)
        };
        assert_eq!(within(32, 16, 1100), (32, 15));
        assert_eq!(within(2, 16, 70), (2, 16));
        assert_eq!(within(2, 16, 50), (2, 11));
        assert_eq!(within(32, 16, 50), (10, 1));
        assert_eq!(within(4, 16, 0), (1, 1));
    }

    proptest! {
        #[test]
        fn it_is_never_more_than_wanted_or_than_there_are_files_for(
            threads in 1_usize..100,
            lanes in 1_usize..100,
            files in 5_usize..10_000,
        ) {
            let wanted = Room { threads, lanes };
            let room = wanted.within(files);
            prop_assert!((1..=threads).contains(&room.threads) && (1..=lanes).contains(&room.lanes));
            prop_assert!(room.threads * (PER_THREAD + room.lanes * PER_CELL) <= files);
            // One more cell for each thread would be wanted and too many, or isn't wanted.
            let more = room.threads * (PER_THREAD + (room.lanes + 1) * PER_CELL);
            prop_assert!(room.lanes == lanes || more > files);
        }
    }
}
