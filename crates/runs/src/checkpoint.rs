//! The envelope of a cell's state: whose it is, how far it got, and whether it's whole.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `ITARL-CP` |
//! | 4 | version of this format |
//! | 4 | number of sections |
//! | 8 | identity: hash of setting, seed and resolved settings without `learning.updates` |
//! | 8 | updates done |
//! | 8 | control steps done: more than its updates have, if it stands within one |
//! | 8 | length of `metrics.csv` |
//! | 8 | XXH3 of these bytes of `metrics.csv` |
//! | 8 | XXH3 of all bytes before: the header can be read alone |
//! | .. | sections, by name: length of the name (4), name, length of the bytes (8), bytes |
//! | 8 | XXH3 of all bytes before |
//!
//! All numbers are little-endian. What the sections hold is the affair of who wrote them.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, Read},
    os::unix::fs::FileExt,
    path::Path,
};

use xxhash_rust::xxh3::xxh3_64;

use super::{Error, Extent, atomic, error::At};

const MAGIC: &[u8; 8] = b"ITARL-CP";
const VERSION: u32 = 1;
const HEADER: usize = 64;
const CHECKSUM: usize = 8;

/// What a checkpoint says without its sections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// The cell's identity: a hash of setting, seed and resolved settings without `learning.updates`.
    pub identity: u64,
    /// The number of updates done.
    pub updates: u64,
    /// The number of control steps done.
    pub control_steps: u64,
    /// The length and the hash of what `metrics.csv` held.
    pub metrics: Extent,
}

/// What a checkpoint must say to be one of a cell, in its experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expected {
    /// Hash of setting, seed and resolved settings without `learning.updates`.
    pub identity: u64,
    /// `learning.updates`: it has no more.
    pub updates: u64,
    /// Control steps of an update, in all worlds of the cell together.
    pub steps_per_update: u64,
}

/// A cell's whole state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checkpoint {
    /// Whose it is and how far it got.
    pub header: Header,
    /// The state, by parts: world, policy, estimator, ...
    pub sections: BTreeMap<String, Vec<u8>>,
}

impl Checkpoint {
    /// The file's bytes, the same ones for the same state.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let size: usize =
            self.sections.iter().map(|(name, part)| 12 + name.len() + part.len()).sum();
        let mut bytes = Vec::with_capacity(HEADER + size + CHECKSUM);
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&VERSION.to_le_bytes());
        bytes.extend_from_slice(&(self.sections.len() as u32).to_le_bytes());
        let Header { identity, updates, control_steps, metrics } = self.header;
        for number in [identity, updates, control_steps, metrics.length, metrics.xxh3] {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
        bytes.extend_from_slice(&xxh3_64(&bytes).to_le_bytes());
        for (name, part) in &self.sections {
            bytes.extend_from_slice(&(name.len() as u32).to_le_bytes());
            bytes.extend_from_slice(name.as_bytes());
            bytes.extend_from_slice(&(part.len() as u64).to_le_bytes());
            bytes.extend_from_slice(part);
        }
        bytes.extend_from_slice(&xxh3_64(&bytes).to_le_bytes());
        bytes
    }

    /// The state in a file's bytes. `path` is for the messages.
    ///
    /// # Errors
    /// [`Error::Damaged`] if they aren't exactly what was written, [`Error::Version`].
    pub fn decode(path: &Path, bytes: &[u8]) -> Result<Self, Error> {
        let (header, n_sections) = decode_header(path, bytes)?;
        let damaged = |what: &str| Error::damaged(path, what);
        let Some((body, checksum)) =
            bytes.split_last_chunk().filter(|(body, _)| body.len() >= HEADER)
        else {
            return Err(damaged("cut off behind its header"));
        };
        if u64::from_le_bytes(*checksum) != xxh3_64(body) {
            return Err(damaged("its checksum is wrong: bytes are missing or have changed"));
        }
        let mut rest = &body[HEADER..];
        let mut sections = BTreeMap::new();
        for _ in 0..n_sections {
            let (name, part) =
                take_section(&mut rest).ok_or_else(|| damaged("a section is cut off"))?;
            if sections.last_key_value().is_some_and(|(last, _): (&String, _)| *last >= name) {
                return Err(damaged("its sections aren't in order"));
            }
            sections.insert(name, part);
        }
        if !rest.is_empty() {
            return Err(damaged("more bytes than its sections have"));
        }
        Ok(Self { header, sections })
    }

    /// Writes the file as a whole.
    ///
    /// # Errors
    /// As [`atomic::write`]; an older checkpoint then stays.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        atomic::write(path, &self.encode())
    }

    /// The state in a file; none if there's no such file.
    ///
    /// # Errors
    /// As [`Checkpoint::decode`] and [`Header::check`], and what reading runs into.
    pub fn read(path: &Path, expected: Expected) -> Result<Option<Self>, Error> {
        let Some(bytes) = atomic::read(path)? else { return Ok(None) };
        let checkpoint = Self::decode(path, &bytes)?;
        checkpoint.header.check(path, expected)?;
        Ok(Some(checkpoint))
    }
}

impl Header {
    /// The header of a checkpoint file, without reading on: for a look, not to go on from. None if
    /// there's no such file.
    ///
    /// # Errors
    /// [`Error::Damaged`], [`Error::Version`], and what reading runs into.
    pub fn read(path: &Path) -> Result<Option<Self>, Error> {
        let file = match File::open(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            opened => opened.at(path, "opening")?,
        };
        let mut bytes = Vec::with_capacity(HEADER);
        file.take(HEADER as u64).read_to_end(&mut bytes).at(path, "reading")?;
        decode_header(path, &bytes).map(|(header, _)| Some(header))
    }

    /// The header of a checkpoint that is as long as its sections make it, whose bytes aren't read. None
    /// of any other: who reads it as a whole is told what is wrong.
    pub(super) fn of_right_length(path: &Path) -> Option<Self> {
        let file = File::open(path).ok()?;
        let mut bytes = [0; HEADER];
        file.read_exact_at(&mut bytes, 0).ok()?;
        let (header, n_sections) = decode_header(path, &bytes).ok()?;
        let mut end = HEADER as u64;
        for _ in 0..n_sections {
            // Of the name, then of the part.
            for size in [4, 8] {
                let length = &mut [0; 8][..size];
                file.read_exact_at(length, end).ok()?;
                end = end.checked_add(size as u64)?.checked_add(little_endian(length))?;
            }
        }
        let length = file.metadata().ok()?.len();
        (length == end.checked_add(CHECKSUM as u64)?).then_some(header)
    }

    /// That it's of a cell, and as far as a cell of its experiment can be: a checkpoint may also be
    /// made inside of an update. `path` is for the messages.
    ///
    /// # Errors
    /// [`Error::OtherCell`], [`Error::Beyond`], and [`Error::Damaged`] if the numbers of updates and
    /// of control steps contradict each other.
    pub fn check(&self, path: &Path, expected: Expected) -> Result<(), Error> {
        let Self { identity, updates, control_steps, .. } = *self;
        let Expected { steps_per_update, .. } = expected;
        if identity != expected.identity {
            return Err(Error::OtherCell { path: path.into() });
        }
        if updates > expected.updates {
            return Err(Error::Beyond { path: path.into(), updates, most: expected.updates });
        }
        let since_the_last = updates
            .checked_mul(steps_per_update)
            .and_then(|until_the_last| control_steps.checked_sub(until_the_last));
        if since_the_last.is_none_or(|steps| steps > steps_per_update) {
            let what = format!(
                "it has {updates} updates and {control_steps} control steps, and an update has \
                 {steps_per_update}"
            );
            return Err(Error::damaged(path, what));
        }
        Ok(())
    }
}

/// The header and the number of sections, checked against the header's own checksum.
fn decode_header(path: &Path, bytes: &[u8]) -> Result<(Header, u32), Error> {
    let damaged = |what: &str| Err(Error::damaged(path, what));
    if !bytes.starts_with(MAGIC) {
        return damaged("it doesn't begin as a checkpoint does");
    }
    if bytes.len() < HEADER {
        return damaged("cut off within its header");
    }
    let u32_at = |at| little_endian(&bytes[at..at + 4]) as u32;
    let u64_at = |at| little_endian(&bytes[at..at + 8]);
    if u64_at(HEADER - CHECKSUM) != xxh3_64(&bytes[..HEADER - CHECKSUM]) {
        return damaged("its header's checksum is wrong");
    }
    let version = u32_at(8);
    if version != VERSION {
        let (found, expected) = (version.into(), VERSION.into());
        return Err(Error::Version { path: path.into(), found, expected });
    }
    let metrics = Extent { length: u64_at(40), xxh3: u64_at(48) };
    let (identity, updates, control_steps) = (u64_at(16), u64_at(24), u64_at(32));
    Ok((Header { identity, updates, control_steps, metrics }, u32_at(12)))
}

/// Lengths are compared with what is there before anything is allocated.
fn take_section(rest: &mut &[u8]) -> Option<(String, Vec<u8>)> {
    let length = rest.split_off(..4)?;
    let name = rest.split_off(..usize::try_from(little_endian(length)).ok()?)?;
    let length = rest.split_off(..8)?;
    let part = rest.split_off(..usize::try_from(little_endian(length)).ok()?)?;
    Some((str::from_utf8(name).ok()?.into(), part.into()))
}

/// Of up to 8 bytes.
fn little_endian(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u64::from(byte))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use proptest::prelude::*;

    use super::*;

    fn checkpoints() -> impl Strategy<Value = Checkpoint> {
        let sections = proptest::collection::btree_map(".{0,8}", any::<Vec<u8>>(), 0..4);
        (any::<[u64; 5]>(), sections).prop_map(|(numbers, sections)| {
            let [identity, updates, control_steps, length, xxh3] = numbers;
            let metrics = Extent { length, xxh3 };
            Checkpoint { header: Header { identity, updates, control_steps, metrics }, sections }
        })
    }

    fn decode(bytes: &[u8]) -> Result<Checkpoint, Error> {
        Checkpoint::decode(Path::new("checkpoint"), bytes)
    }

    proptest! {
        #[test]
        fn what_was_encoded_is_decoded(checkpoint in checkpoints()) {
            let bytes = checkpoint.encode();
            let decoded = decode(&bytes).unwrap();
            prop_assert_eq!(decoded.encode(), bytes.clone());
            prop_assert_eq!(&decoded, &checkpoint);
            let (header, _) = decode_header(Path::new("checkpoint"), &bytes[..HEADER]).unwrap();
            prop_assert_eq!(header, checkpoint.header);
        }

        #[test]
        fn any_truncation_or_flipped_bit_is_damage(
            checkpoint in checkpoints(),
            place: prop::sample::Index,
            bit in 0_u8..8,
        ) {
            let mut bytes = checkpoint.encode();
            let place = place.index(bytes.len());
            let cut = matches!(decode(&bytes[..place]), Err(Error::Damaged { .. }));
            prop_assert!(cut);
            bytes[place] ^= 1 << bit;
            let flipped = matches!(decode(&bytes), Err(Error::Damaged { .. }));
            prop_assert!(flipped);
        }

        /// With right checksums, so that what lies behind them is tried too.
        #[test]
        fn senseless_sections_are_damage(n_sections: u32, mut body: Vec<u8>, length: u64) {
            let sections = BTreeMap::new();
            let metrics = Extent::empty();
            let header = Header { identity: 0, updates: 0, control_steps: 0, metrics };
            let mut bytes = Checkpoint { header, sections }.encode();
            bytes[12..16].copy_from_slice(&n_sections.to_le_bytes());
            let checksum = xxh3_64(&bytes[..HEADER - CHECKSUM]);
            bytes[HEADER - CHECKSUM..HEADER].copy_from_slice(&checksum.to_le_bytes());
            for first in [&[][..], &[0; 4], &[1, 0, 0, 0, b'a']] {
                bytes.truncate(HEADER);
                bytes.extend_from_slice(first);
                bytes.extend_from_slice(&length.to_le_bytes());
                bytes.append(&mut body);
                bytes.extend_from_slice(&xxh3_64(&bytes).to_le_bytes());
                let damaged = matches!(decode(&bytes), Err(Error::Damaged { .. }));
                prop_assert!(damaged);
            }
        }

        #[test]
        fn random_bytes_are_damage(bytes: Vec<u8>) {
            for bytes in [&bytes[..], &[&MAGIC[..], &bytes].concat()] {
                let damaged = matches!(decode(bytes), Err(Error::Damaged { .. }));
                prop_assert!(damaged);
            }
        }
    }

    #[test]
    fn what_no_cell_of_the_experiment_can_have_is_refused() {
        let expected = Expected { identity: 7, updates: 300, steps_per_update: 100 };
        let check = |identity, updates, control_steps| {
            let metrics = Extent::empty();
            let header = Header { identity, updates, control_steps, metrics };
            header.check(Path::new("checkpoint"), expected).map_err(|error| error.to_string())
        };
        for (updates, control_steps) in
            [(0, 0), (0, 42), (3, 300), (3, 399), (3, 400), (300, 30_000)]
        {
            check(7, updates, control_steps).unwrap();
        }
        let refused = |identity, updates, control_steps, message: &str| {
            let error = check(identity, updates, control_steps).unwrap_err();
            assert!(error.starts_with(&format!("checkpoint: {message}")), "{error}");
        };
        refused(8, 3, 300, "of another cell: ");
        refused(7, 301, 30_100, "damaged: it has 301 updates, and the experiment ends at 300");
        let huge = 6_735_281_601_315_911_789;
        refused(7, huge, 300, "damaged: it has 6735281601315911789 updates, and the experiment");
        for control_steps in [0, 299, 401, u64::MAX] {
            refused(
                7,
                3,
                control_steps,
                &format!("damaged: it has 3 updates and {control_steps} "),
            );
        }
        let endless = Expected { identity: 7, updates: u64::MAX, steps_per_update: u64::MAX };
        let metrics = Extent::empty();
        let header = Header { identity: 7, updates: huge, control_steps: huge, metrics };
        assert!(header.check(Path::new("checkpoint"), endless).is_err());
    }

    #[test]
    fn another_version_is_named() {
        let metrics = Extent::empty();
        let header = Header { identity: 1, updates: 2, control_steps: 3, metrics };
        let mut bytes = Checkpoint { header, sections: BTreeMap::new() }.encode();
        bytes[8] = 9;
        let checksum = xxh3_64(&bytes[..HEADER - CHECKSUM]);
        bytes[HEADER - CHECKSUM..HEADER].copy_from_slice(&checksum.to_le_bytes());
        let n = bytes.len() - CHECKSUM;
        let checksum = xxh3_64(&bytes[..n]);
        bytes[n..].copy_from_slice(&checksum.to_le_bytes());
        let error = decode(&bytes).unwrap_err().to_string();
        assert!(error.starts_with("checkpoint: format version 9, and this program reads 1"));
    }

    /// What has lost bytes, or has too many, isn't taken for whole; of others only bytes tell.
    #[test]
    fn a_checkpoint_of_another_length_is_seen_by_its_header() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint");
        let metrics = Extent { length: 8, xxh3: 9 };
        let header = Header { identity: 1, updates: 2, control_steps: 200, metrics };
        for names in [&[][..], &["a"], &["policy", "world"]] {
            let sections = names.iter().map(|it| ((*it).to_string(), vec![7; 300])).collect();
            let bytes = Checkpoint { header, sections }.encode();
            let seen = |bytes: &[u8]| {
                fs::write(&path, bytes).unwrap();
                Header::of_right_length(&path)
            };
            assert_eq!(seen(&bytes), Some(header));
            assert!((0..bytes.len()).all(|length| seen(&bytes[..length]).is_none()));
            assert_eq!(seen(&[&bytes[..], b"x"].concat()), None);
            assert!((0..HEADER).all(|place| {
                let mut flipped = bytes.clone();
                flipped[place] ^= 1;
                seen(&flipped).is_none()
            }));
        }
        fs::remove_file(&path).unwrap();
        assert_eq!(Header::of_right_length(&path), None);
    }

    #[test]
    fn a_file_is_written_and_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint");
        let expected = Expected { identity: 1, updates: 2, steps_per_update: 100 };
        assert_eq!(Checkpoint::read(&path, expected).unwrap(), None);
        assert_eq!(Header::read(&path).unwrap(), None);
        let metrics = Extent { length: 8, xxh3: 9 };
        let header = Header { identity: 1, updates: 2, control_steps: 200, metrics };
        let sections = BTreeMap::from([("world".to_string(), vec![1, 2, 3])]);
        let checkpoint = Checkpoint { header, sections };
        checkpoint.write(&path).unwrap();
        assert_eq!(Checkpoint::read(&path, expected).unwrap(), Some(checkpoint));
        let other = Expected { identity: 3, ..expected };
        assert!(matches!(Checkpoint::read(&path, other), Err(Error::OtherCell { .. })));
        assert_eq!(Header::read(&path).unwrap(), Some(header));
    }
}
