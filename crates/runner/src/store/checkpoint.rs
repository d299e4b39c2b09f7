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
    /// Of which cell: a hash of setting, seed and resolved settings without `learning.updates`.
    pub identity: u64,
    /// Updates done.
    pub updates: u64,
    /// Control steps done.
    pub control_steps: u64,
    /// What `metrics.csv` held.
    pub metrics: Extent,
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
    /// [`Error::Damaged`] if they aren't exactly what was written, [`Error::Version`],
    /// [`Error::OtherCell`] if they have another identity.
    pub fn decode(path: &Path, bytes: &[u8], identity: u64) -> Result<Self, Error> {
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
        if header.identity != identity {
            return Err(Error::OtherCell { path: path.into() });
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
    /// As [`Checkpoint::decode`], and what reading runs into.
    pub fn read(path: &Path, identity: u64) -> Result<Option<Self>, Error> {
        atomic::read(path)?.map(|bytes| Self::decode(path, &bytes, identity)).transpose()
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

    fn decode(bytes: &[u8], identity: u64) -> Result<Checkpoint, Error> {
        Checkpoint::decode(Path::new("checkpoint"), bytes, identity)
    }

    proptest! {
        #[test]
        fn what_was_encoded_is_decoded(checkpoint in checkpoints()) {
            let bytes = checkpoint.encode();
            let identity = checkpoint.header.identity;
            let decoded = decode(&bytes, identity).unwrap();
            prop_assert_eq!(decoded.encode(), bytes.clone());
            prop_assert_eq!(&decoded, &checkpoint);
            let (header, _) = decode_header(Path::new("checkpoint"), &bytes[..HEADER]).unwrap();
            prop_assert_eq!(header, checkpoint.header);
            let other = matches!(decode(&bytes, !identity), Err(Error::OtherCell { .. }));
            prop_assert!(other);
        }

        #[test]
        fn any_truncation_or_flipped_bit_is_damage(
            checkpoint in checkpoints(),
            place: prop::sample::Index,
            bit in 0_u8..8,
        ) {
            let mut bytes = checkpoint.encode();
            let identity = checkpoint.header.identity;
            let place = place.index(bytes.len());
            let cut = matches!(decode(&bytes[..place], identity), Err(Error::Damaged { .. }));
            prop_assert!(cut);
            bytes[place] ^= 1 << bit;
            let flipped = matches!(decode(&bytes, identity), Err(Error::Damaged { .. }));
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
                let damaged = matches!(decode(&bytes, 0), Err(Error::Damaged { .. }));
                prop_assert!(damaged);
            }
        }

        #[test]
        fn random_bytes_are_damage(bytes: Vec<u8>) {
            for bytes in [&bytes[..], &[&MAGIC[..], &bytes].concat()] {
                let damaged = matches!(decode(bytes, 7), Err(Error::Damaged { .. }));
                prop_assert!(damaged);
            }
        }
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
        let error = decode(&bytes, 1).unwrap_err().to_string();
        assert!(error.starts_with("checkpoint: format version 9, and this program reads 1"));
    }

    #[test]
    fn a_file_is_written_and_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint");
        assert_eq!(Checkpoint::read(&path, 1).unwrap(), None);
        assert_eq!(Header::read(&path).unwrap(), None);
        let metrics = Extent { length: 8, xxh3: 9 };
        let header = Header { identity: 1, updates: 2, control_steps: 200, metrics };
        let sections = BTreeMap::from([("world".to_string(), vec![1, 2, 3])]);
        let checkpoint = Checkpoint { header, sections };
        checkpoint.write(&path).unwrap();
        assert_eq!(Checkpoint::read(&path, 1).unwrap(), Some(checkpoint));
        assert_eq!(Header::read(&path).unwrap(), Some(header));
    }
}
