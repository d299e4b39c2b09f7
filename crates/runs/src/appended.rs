//! A file that only grows: a row at a time, cut back to what a checkpoint knows of.

use std::{
    fs::{File, OpenOptions},
    io::{self, Read},
    os::unix::fs::FileExt,
    path::{Path, PathBuf},
};

use xxhash_rust::xxh3::{Xxh3, xxh3_64};

use super::{
    Error, atomic,
    atomic::{folder_of, sync_folder},
    error::At,
};

/// How much of a growing file is meant, and what it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Bytes from the file's beginning.
    pub length: u64,
    /// XXH3 (64 bits) of these bytes.
    pub xxh3: u64,
}

impl Extent {
    /// The extent of an empty file.
    #[must_use]
    pub fn empty() -> Self {
        Self { length: 0, xxh3: xxh3_64(b"") }
    }

    /// The running hash of what is meant of a file's bytes, if that's how they begin. `path` is for
    /// the messages.
    pub(super) fn check(self, path: &Path, bytes: &[u8]) -> Result<Xxh3, Error> {
        let Self { length, xxh3 } = self;
        let Some(known) = usize::try_from(length).ok().and_then(|length| bytes.get(..length))
        else {
            let what = format!("{} bytes, and the checkpoint goes on from {length}", bytes.len());
            return Err(Error::damaged(path, what));
        };
        let mut hash = Xxh3::new();
        hash.update(known);
        if hash.digest() != xxh3 {
            let what = format!(
                "its first {length} bytes aren't those that were written before the checkpoint"
            );
            return Err(Error::damaged(path, what));
        }
        Ok(hash)
    }
}

/// A growing file, open for appending.
///
/// There's no buffer: an update appends one row, so the system call costs nothing beside it, and
/// whoever reads the file sees the row at once.
pub struct Appended {
    path: PathBuf,
    file: File,
    length: u64,
    hash: Xxh3,
}

impl Appended {
    /// An empty file, in the place of one that no checkpoint knows. Its name is forced to the disk: a
    /// power cut must not leave a checkpoint without the file that it goes on from.
    ///
    /// # Errors
    /// If it can't be made.
    pub fn begin(path: &Path) -> Result<Self, Error> {
        // Not emptied: it may be a link to a file that is none of ours.
        atomic::remove(path)?;
        let file =
            OpenOptions::new().write(true).create_new(true).open(path).at(path, "making it")?;
        sync_folder(folder_of(path))?;
        Ok(Self { path: path.into(), file, length: 0, hash: Xxh3::new() })
    }

    /// Opens a file that is there, and cuts off what stands behind `extent`.
    ///
    /// # Errors
    /// [`Error::Damaged`] if the file is missing or shorter than `extent`, or has other bytes there.
    /// It's then left as it was.
    pub fn open(path: &Path, extent: Extent) -> Result<Self, Error> {
        let file = match OpenOptions::new().read(true).write(true).open(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Err(Error::damaged(path, "missing, and the checkpoint goes on from it"));
            }
            opened => opened.at(path, "opening")?,
        };
        let length = file.metadata().at(path, "asking for its length")?.len();
        let mut known = Vec::new();
        (&file).take(extent.length).read_to_end(&mut known).at(path, "reading")?;
        let hash = extent.check(path, &known)?;
        if length > extent.length {
            file.set_len(extent.length).at(path, "cutting off what no checkpoint knows")?;
        }
        Ok(Self { path: path.into(), file, length: extent.length, hash })
    }

    /// Adds bytes at the end.
    ///
    /// # Errors
    /// If they can't be written; the file is then as before, as far as the system lets it.
    pub fn append(&mut self, bytes: &[u8]) -> Result<(), Error> {
        if let Err(error) = self.file.write_all_at(bytes, self.length) {
            // What fails here too is cut off when the file is opened again.
            let _ = self.file.set_len(self.length);
            return Err(error).at(&self.path, "appending");
        }
        self.length += bytes.len() as u64;
        self.hash.update(bytes);
        Ok(())
    }

    /// Forces all that was appended to the disk, and says how much that is.
    ///
    /// # Errors
    /// If the disk can't take it.
    pub fn sync(&mut self) -> Result<Extent, Error> {
        self.file.sync_data().at(&self.path, "forcing to the disk")?;
        Ok(Extent { length: self.length, xxh3: self.hash.digest() })
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn rows_are_seen_at_once_and_cut_back_to_the_extent() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows");
        let mut rows = Appended::begin(&path).unwrap();
        rows.append(b"a\nb\n").unwrap();
        let extent = rows.sync().unwrap();
        rows.append(b"c\n").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"a\nb\nc\n");
        drop(rows);

        let mut rows = Appended::open(&path, extent).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"a\nb\n");
        rows.append(b"d\n").unwrap();
        let extent = rows.sync().unwrap();
        assert_eq!(extent, Extent { length: 6, xxh3: xxh3_64(b"a\nb\nd\n") });
        assert_eq!(fs::read(&path).unwrap(), b"a\nb\nd\n");

        Appended::begin(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"");
    }

    #[test]
    fn a_missing_file_is_damage_and_stays_missing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows");
        let extent = Extent { length: 1, xxh3: xxh3_64(b"a") };
        let error = Appended::open(&path, extent).err().unwrap();
        assert!(matches!(error, Error::Damaged { .. }), "{error}");
        assert!(!path.exists());
    }

    #[test]
    fn a_full_disk_is_reported() {
        let file = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let mut rows = Appended { path: "rows".into(), file, length: 0, hash: Xxh3::new() };
        let error = rows.append(b"a\n").unwrap_err().to_string();
        assert!(error.contains("rows: appending: No space left on device"), "{error}");
    }

    /// Power cuts may keep some names of a folder and lose others.
    #[test]
    fn the_name_of_a_new_file_is_on_the_disk_before_a_row() {
        let folder = tempfile::tempdir().unwrap();
        atomic::tests::SYNCED.take();
        Appended::begin(&folder.path().join("rows")).unwrap();
        let synced = atomic::tests::SYNCED.take();
        assert_eq!(synced, [(folder.path().to_path_buf(), vec!["rows".to_string()])]);
    }

    #[test]
    fn a_link_in_the_place_of_a_new_file_is_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let (path, victim) = (folder.path().join("rows"), folder.path().join("victim"));
        fs::write(&victim, b"precious").unwrap();
        std::os::unix::fs::symlink(&victim, &path).unwrap();
        Appended::begin(&path).unwrap().append(b"a\n").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"a\n");
        assert_eq!(fs::read(&victim).unwrap(), b"precious");
    }

    proptest! {
        // Each case forces files to the disk.
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn damage_before_the_extent_is_an_error_and_nothing_is_overwritten(
            known in proptest::collection::vec(any::<u8>(), 1..400),
            behind: Vec<u8>,
            place: prop::sample::Index,
            bit in 0_u8..8,
        ) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("rows");
            let extent = Extent { length: known.len() as u64, xxh3: xxh3_64(&known) };
            let place = place.index(known.len());

            let short = known[..place].to_vec();
            let mut flipped = [&known[..], &behind].concat();
            flipped[place] ^= 1 << bit;
            for damaged in [short, flipped] {
                fs::write(&path, &damaged).unwrap();
                let is_damaged =
                    matches!(Appended::open(&path, extent), Err(Error::Damaged { .. }));
                prop_assert!(is_damaged);
                prop_assert_eq!(fs::read(&path).unwrap(), damaged);
            }
        }
    }
}
