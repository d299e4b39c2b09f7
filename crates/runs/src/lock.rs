//! One process at a time: a lock on a file, which the operating system frees however it ends.

use std::{
    fs::{self, File, Metadata, OpenOptions, TryLockError},
    io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    thread,
    time::Duration,
};

use super::{Error, atomic::folder_of, error::At};

/// How often, and how long apart, a lock is asked for: [`is_locked`] holds a shared lock for some
/// microseconds, and must not make a process fail that begins just then.
const ATTEMPTS: u32 = 20;
const PAUSE: Duration = Duration::from_millis(5);

/// Held until it's dropped or the process ends. The file stays, empty: taking it away would let
/// two processes lock two files of one name.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    file: File,
}

impl Lock {
    /// Locks a file, and makes it if it isn't there.
    ///
    /// # Errors
    /// [`Error::Locked`], with the file's folder, if another process (or another part of this one)
    /// holds it.
    pub fn acquire(path: &Path) -> Result<Self, Error> {
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(path);
        let file = file.at(path, "opening")?;
        for attempt in 1..=ATTEMPTS {
            match file.try_lock() {
                Ok(()) => return Ok(Self { path: path.into(), file }),
                Err(TryLockError::Error(error)) => return Err(error).at(path, "locking"),
                Err(TryLockError::WouldBlock) if attempt < ATTEMPTS => thread::sleep(PAUSE),
                Err(TryLockError::WouldBlock) => {}
            }
        }
        Err(Error::Locked { path: folder_of(path).into() })
    }
}

impl Lock {
    /// Locks a file that is there, as soon as nobody else holds it. For what takes a moment.
    ///
    /// # Errors
    /// If it can't be opened or locked.
    pub(crate) fn wait(path: &Path) -> Result<Self, Error> {
        let file = File::open(path).at(path, "opening")?;
        file.lock().at(path, "locking")?;
        Ok(Self { path: path.into(), file })
    }

    /// That the locked file is still the one at its path. If not, whatever is there belongs to others:
    /// the folder was renamed, say, and another run begun in its place.
    ///
    /// # Errors
    /// [`Error::Moved`], with the file's folder; what asking runs into.
    pub fn require(&self) -> Result<(), Error> {
        let doing = "asking which file it is";
        let held = self.file.metadata().at(&self.path, doing)?;
        let there = match fs::metadata(&self.path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            there => Some(there.at(&self.path, doing)?),
        };
        let file = |it: &Metadata| (it.dev(), it.ino());
        match there {
            Some(there) if file(&there) == file(&held) => Ok(()),
            _ => Err(Error::Moved { path: folder_of(&self.path).into() }),
        }
    }
}

/// Whether someone holds the lock. Neither a holder nor one who is about to lock is disturbed.
///
/// # Errors
/// If the file is there and can't be opened or asked.
pub fn is_locked(path: &Path) -> Result<bool, Error> {
    let file = match File::open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
        opened => opened.at(path, "opening")?,
    };
    match file.try_lock_shared() {
        Ok(()) => Ok(false),
        Err(TryLockError::WouldBlock) => Ok(true),
        Err(TryLockError::Error(error)) => Err(error).at(path, "asking for its lock"),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;

    #[test]
    fn the_second_one_is_refused_until_the_first_is_gone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        assert!(!is_locked(&path).unwrap());
        let lock = Lock::acquire(&path).unwrap();
        assert!(is_locked(&path).unwrap());
        let error = Lock::acquire(&path).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}: another", folder.path().display())), "{error}");
        drop(lock);
        assert!(!is_locked(&path).unwrap());
        Lock::acquire(&path).unwrap();
    }

    #[test]
    fn another_file_at_the_path_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let [here, elsewhere] = ["here", "elsewhere"].map(|name| folder.path().join(name));
        fs::create_dir(&here).unwrap();
        let path = here.join("lock");
        let lock = Lock::acquire(&path).unwrap();
        lock.require().unwrap();
        fs::rename(&here, &elsewhere).unwrap();
        let is_moved =
            |lock: &Lock| matches!(lock.require(), Err(Error::Moved { path }) if path == here);
        assert!(is_moved(&lock));
        fs::create_dir(&here).unwrap();
        let other = Lock::acquire(&path).unwrap();
        assert!(is_moved(&lock));
        other.require().unwrap();
        fs::remove_dir_all(&here).unwrap();
        fs::rename(&elsewhere, &here).unwrap();
        lock.require().unwrap();
        assert!(is_moved(&other));
    }

    #[test]
    fn being_asked_about_does_not_refuse_anyone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        let done = AtomicBool::new(false);
        thread::scope(|scope| {
            scope.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    is_locked(&path).unwrap();
                    thread::sleep(Duration::from_micros(50));
                }
            });
            let locked = (0..100).all(|_| Lock::acquire(&path).is_ok());
            done.store(true, Ordering::Relaxed);
            assert!(locked);
        });
    }

    #[test]
    fn a_lock_that_cannot_be_made_says_where() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("nowhere").join("lock");
        let error = Lock::acquire(&path).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}: opening: ", path.display())), "{error}");
    }
}
