//! Whole files: the old one or the new one, never a part of it.
//!
//! The bytes go to `NAME.tmp` in the same folder, are forced to the disk, and take the name by one
//! rename, which is forced to the disk too. A process killed in between leaves `NAME.tmp` behind,
//! and the next write takes it away. It's always made anew: one that is there may be a link to a file
//! that is none of ours.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, Write},
    path::{Path, PathBuf},
};

use super::{Error, error::At};

/// Writes a file, in the place of an older one if there is one.
///
/// One process at a time: the temporary name is always the same.
///
/// # Errors
/// With the path and the step that didn't work. The older file is then as it was, unless only the
/// last step failed (the folder couldn't be forced to the disk).
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let temporary = temporary(path)?;
    let written = replace(path, &temporary, bytes);
    if written.is_err() {
        // It may not have been made at all; the error to tell is the first one.
        let _ = fs::remove_file(&temporary);
    }
    written
}

fn replace(path: &Path, temporary: &Path, bytes: &[u8]) -> Result<(), Error> {
    let make = || OpenOptions::new().write(true).create_new(true).open(temporary);
    let file = match make() {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            remove(temporary)?;
            make()
        }
        made => made,
    };
    fill(file.at(path, "making a temporary file beside it")?, path, bytes)?;
    fs::rename(temporary, path).at(path, "renaming the temporary file")?;
    sync_folder(folder_of(path))
}

/// Takes any open file, so that a test can give it a full disk.
fn fill(mut file: File, path: &Path, bytes: &[u8]) -> Result<(), Error> {
    file.write_all(bytes).at(path, "writing")?;
    file.sync_all().at(path, "forcing to the disk")
}

/// Forces the names in a folder to the disk.
pub(crate) fn sync_folder(folder: &Path) -> Result<(), Error> {
    #[cfg(test)]
    tests::SYNCED.with_borrow_mut(|synced| synced.push((folder.into(), tests::names(folder))));
    File::open(folder).and_then(|file| file.sync_all()).at(folder, "forcing the folder to the disk")
}

/// Makes a folder if it isn't there, with its name and that of the folder around it forced to the disk.
///
/// # Errors
/// If it can't be made.
pub fn make_folder(folder: &Path) -> Result<(), Error> {
    if folder.is_dir() {
        return Ok(());
    }
    fs::create_dir_all(folder).at(folder, "making the folder")?;
    folder
        .ancestors()
        .skip(1)
        .take(3)
        .filter(|it| !it.as_os_str().is_empty())
        .try_for_each(sync_folder)
}

/// The folder that a file or folder is in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Removes a file, or a link and not what it leads to, if it's there.
pub(crate) fn remove(path: &Path) -> Result<(), Error> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(error).at(path, "removing what is in the way")
        }
        _ => Ok(()),
    }
}

/// The bytes of a file; none if there's no such file.
///
/// # Errors
/// With the path, if it's there and can't be read.
pub fn read(path: &Path) -> Result<Option<Vec<u8>>, Error> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error).at(path, "reading"),
    }
}

fn temporary(path: &Path) -> Result<PathBuf, Error> {
    let Some(name) = path.file_name() else {
        return Err(Error::argument("atomic::write", "path", "a file's", path.display()));
    };
    let mut name = name.to_os_string();
    name.push(".tmp");
    Ok(path.with_file_name(name))
}

#[cfg(test)]
pub(crate) mod tests {
    use std::{cell::RefCell, os::unix::fs::symlink};

    use super::*;

    thread_local! {
        /// The folders that this thread forced to the disk, each with the names that were in it. Only
        /// a power cut would show it otherwise.
        pub(crate) static SYNCED: RefCell<Vec<(PathBuf, Vec<String>)>> = RefCell::default();
    }

    pub(crate) fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).into_iter().flatten();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into()).collect();
        names.sort();
        names
    }

    #[test]
    fn the_newer_bytes_take_the_place_of_the_older() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state");
        write(&path, b"longer, the first").unwrap();
        write(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(names(folder.path()), ["state"]);
    }

    #[test]
    fn what_a_killed_process_left_is_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state");
        write(&path, b"first").unwrap();
        fs::write(folder.path().join("state.tmp"), b"half of the second, and longer").unwrap();
        write(&path, b"third").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"third");
        assert_eq!(names(folder.path()), ["state"]);
    }

    #[test]
    fn a_failed_write_names_the_file_and_leaves_the_older_one() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        write(&file, b"first").unwrap();
        let error = write(&file.join("state"), b"").unwrap_err().to_string();
        let place = file.join("state");
        assert!(error.starts_with(&format!("{}: making a temporary", place.display())), "{error}");
        assert_eq!(fs::read(&file).unwrap(), b"first");

        // The rename fails: a folder that isn't empty has the name already.
        let taken = folder.path().join("taken");
        fs::create_dir_all(taken.join("in it")).unwrap();
        let error = write(&taken, b"").unwrap_err().to_string();
        assert!(error.contains("renaming the temporary file"), "{error}");
        assert_eq!(names(folder.path()), ["file", "taken"]);
    }

    #[test]
    fn a_full_disk_is_reported_and_the_older_file_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state");
        write(&path, b"first").unwrap();
        let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let error = fill(full, &path, b"second").unwrap_err().to_string();
        assert!(error.contains("state: writing: No space left on device"), "{error}");

        // Whatever fails, the older one stays: here a folder has the temporary name.
        fs::create_dir(folder.path().join("state.tmp")).unwrap();
        let error = write(&path, b"second").unwrap_err().to_string();
        assert!(error.contains("state.tmp: removing what is in the way: "), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(names(folder.path()), ["state", "state.tmp"]);
    }

    #[test]
    fn a_link_in_the_place_of_the_temporary_file_is_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let (path, victim) = (folder.path().join("state"), folder.path().join("victim"));
        fs::write(&victim, b"precious").unwrap();
        for target in [&victim, &folder.path().join("nowhere")] {
            symlink(target, folder.path().join("state.tmp")).unwrap();
            write(&path, b"state").unwrap();
            assert_eq!(fs::read(&path).unwrap(), b"state");
            assert!(!path.is_symlink());
            assert_eq!(fs::read(&victim).unwrap(), b"precious");
            assert_eq!(names(folder.path()), ["state", "victim"]);
        }
    }
}
