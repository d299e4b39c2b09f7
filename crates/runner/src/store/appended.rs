//! A file that only grows: a row at a time, cut back to what a checkpoint knows of.

use std::{
    fs::{File, OpenOptions},
    io::{self, Read},
    os::unix::fs::FileExt,
    path::{Path, PathBuf},
};

use xxhash_rust::xxh3::{Xxh3, xxh3_64};

use super::{Error, error::At};

/// How much of a growing file is meant, and what it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Bytes from the file's beginning.
    pub length: u64,
    /// XXH3 (64 bits) of these bytes.
    pub xxh3: u64,
}

impl Extent {
    /// Of an empty file.
    #[must_use]
    pub fn empty() -> Self {
        Self { length: 0, xxh3: xxh3_64(b"") }
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
    /// Opens a file, makes it if it isn't there, and cuts off what stands behind `extent`.
    ///
    /// # Errors
    /// [`Error::Damaged`] if the file is shorter than `extent`, or has other bytes there. It's then
    /// left as it was.
    pub fn open(path: &Path, extent: Extent) -> Result<Self, Error> {
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(extent.length == 0);
        let mut file = match options.open(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound && extent.length > 0 => {
                return Err(Error::damaged(path, "missing, and the checkpoint goes on from it"));
            }
            opened => opened.at(path, "opening")?,
        };
        let length = file.metadata().at(path, "asking for its length")?.len();
        let hash = verify(&mut file, path, length, extent)?;
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

/// The running hash of the file's first `extent.length` bytes, if they are the right ones.
fn verify(file: &mut File, path: &Path, length: u64, extent: Extent) -> Result<Xxh3, Error> {
    if length < extent.length {
        let expected = extent.length;
        let what = format!("{length} bytes, and the checkpoint goes on from {expected}");
        return Err(Error::damaged(path, what));
    }
    let mut hash = Xxh3::new();
    let mut known = file.take(extent.length);
    let mut chunk = vec![0; 1 << 16];
    loop {
        match known.read(&mut chunk).at(path, "reading")? {
            0 => break,
            n => hash.update(&chunk[..n]),
        }
    }
    if hash.digest() != extent.xxh3 {
        let what = format!(
            "its first {} bytes aren't those that were written before the checkpoint",
            extent.length
        );
        return Err(Error::damaged(path, what));
    }
    Ok(hash)
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
        let mut rows = Appended::open(&path, Extent::empty()).unwrap();
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

        Appended::open(&path, Extent::empty()).unwrap();
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
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows");
        std::os::unix::fs::symlink("/dev/full", &path).unwrap();
        let mut rows = Appended::open(&path, Extent::empty()).unwrap();
        let error = rows.append(b"a\n").unwrap_err().to_string();
        assert!(error.contains("rows: appending: No space left on device"), "{error}");
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
