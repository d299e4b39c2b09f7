//! One process at a time: a lock on a file, which the operating system frees however it ends.
//!
//! The lock is `flock`'s. NFS makes one of it that all its machines see, if the file is open for
//! writing; Lustre does where it's mounted with `flock`, and with `localflock` each machine has its
//! own locks. So a holder may leave its name in the file ([`Lock::sign`]), and look whether it's
//! still there.

use std::{
    fs::{self, File, Metadata, OpenOptions, TryLockError},
    io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    thread,
    time::Duration,
};

use rustix::io::Errno;

use super::{Error, Signature, Writer, atomic::folder_of, error::At};

/// How often, and how long apart, a lock is asked for that nobody holds for good: [`is_locked`] holds
/// a shared lock for some microseconds, and must not make a process fail that begins just then.
const ATTEMPTS: u32 = 20;
const PAUSE: Duration = Duration::from_millis(5);

/// Held until it's dropped or the process ends. The file stays: taking it away would let two
/// processes lock two files of one name.
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
    /// holds it; [`Error::NoLocks`].
    pub fn acquire(path: &Path) -> Result<Self, Error> {
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(path);
        let file = file.at(path, "opening")?;
        for _ in 0..ATTEMPTS {
            if taken(file.try_lock(), path)? {
                return Ok(Self { path: path.into(), file });
            }
            // Beside others who only look there's room for one more who does.
            if !taken(file.try_lock_shared(), path)? {
                break;
            }
            file.unlock().at(path, "unlocking")?;
            thread::sleep(PAUSE);
        }
        Err(Error::Locked { path: folder_of(path).into() })
    }

    /// Locks a file as soon as nobody else holds it, and makes it if it isn't there. For what takes a
    /// moment.
    ///
    /// # Errors
    /// If it can't be opened or locked.
    pub(crate) fn wait(path: &Path) -> Result<Self, Error> {
        // NFS locks only what is open for writing.
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(path);
        let file = file.at(path, "opening")?;
        file.lock().map_err(|cause| refused(path, cause))?;
        Ok(Self { path: path.into(), file })
    }

    /// Puts the name of this process into the file, with the updates that the cell has.
    ///
    /// # Errors
    /// If it can't be written.
    pub(crate) fn sign(&self, updates: u64) -> Result<(), Error> {
        Signature::write(&self.path, &self.file, updates)
    }

    /// That the file still has the name of this process. If not, another one has the lock, too: this
    /// file system's locks don't hold between the two.
    ///
    /// # Errors
    /// [`Error::Foreign`], with the file's folder; what reading runs into.
    pub(crate) fn require_signature(&self) -> Result<(), Error> {
        match Signature::read(&self.path)?.map(|it| it.writer) {
            Some(writer) if writer != *Writer::this() => {
                Err(Error::Foreign { path: folder_of(&self.path).into(), writer })
            }
            _ => Ok(()),
        }
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

/// Whether a lock was got.
fn taken(tried: Result<(), TryLockError>, path: &Path) -> Result<bool, Error> {
    match tried {
        Ok(()) => Ok(true),
        Err(TryLockError::WouldBlock) => Ok(false),
        Err(TryLockError::Error(cause)) => Err(refused(path, cause)),
    }
}

/// Why a file can't be locked: mostly, that its file system locks none.
fn refused(path: &Path, cause: io::Error) -> Error {
    let none = [Errno::NOLCK, Errno::NOSYS, Errno::OPNOTSUPP].map(|it| Some(it.raw_os_error()));
    let path = path.into();
    match none.contains(&cause.raw_os_error()) {
        true => Error::NoLocks { path, cause },
        false => Error::Io { path, doing: "locking", cause },
    }
}

/// That files can be locked where this one is, which is there. Nobody is disturbed.
///
/// # Errors
/// [`Error::NoLocks`]; if it can't be opened or asked.
pub fn require_locks(path: &Path) -> Result<(), Error> {
    is_locked(path).map(drop)
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
    Ok(!taken(file.try_lock_shared(), path)?)
}

#[cfg(test)]
mod tests {
    use std::{
        os::unix::fs::FileExt,
        sync::atomic::{AtomicBool, Ordering},
    };

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

    /// Where locks don't hold, the one who came later has its name there.
    #[test]
    fn another_name_in_the_file_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        let lock = Lock::acquire(&path).unwrap();
        let read = || Signature::read(&path).unwrap();
        assert_eq!(read(), None);
        lock.require_signature().unwrap();
        lock.sign(3).unwrap();
        let this = Signature { writer: Writer::this().clone(), updates: 3 };
        assert_eq!(read(), Some(this));
        lock.require_signature().unwrap();
        let other = Writer { host: "node7".into(), ..Writer::this().clone() };
        let signature = Signature { writer: other.clone(), updates: 3 };
        fs::write(&path, serde_json::to_vec(&signature).unwrap()).unwrap();
        let error = lock.require_signature().unwrap_err().to_string();
        let expected = format!("{}: process {} on node7 ", folder.path().display(), other.process);
        assert!(error.starts_with(&expected), "{error}");
    }

    /// NFS refuses to lock a file that is open for reading alone.
    #[test]
    fn what_is_locked_is_open_for_writing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        for lock in [Lock::acquire, Lock::wait] {
            lock(&path).unwrap().file.write_all_at(b"x", 0).unwrap();
        }
    }

    #[test]
    fn a_file_system_without_locks_is_named_once() {
        for errno in [Errno::NOLCK, Errno::NOSYS, Errno::OPNOTSUPP] {
            let cause = || io::Error::from_raw_os_error(errno.raw_os_error());
            let error = refused(Path::new("run/lock"), cause()).to_string();
            assert!(error.starts_with("run/lock: this file system locks no files"), "{error}");
            assert_eq!(error.matches(&cause().to_string()).count(), 1, "{error}");
            assert_eq!(error.lines().count(), 1, "{error}");
        }
    }

    #[test]
    fn a_lock_that_cannot_be_made_says_where() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("nowhere").join("lock");
        let error = Lock::acquire(&path).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}: opening: ", path.display())), "{error}");
    }
}
