//! One process at a time: a lock on a file, which the operating system frees however it ends.

use std::{
    fs::{File, OpenOptions, TryLockError},
    io,
    path::Path,
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
    _file: File,
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
                Ok(()) => return Ok(Self { _file: file }),
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
        Ok(Self { _file: file })
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
