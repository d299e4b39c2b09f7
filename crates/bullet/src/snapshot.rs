//! The envelope of a world's dynamic state: what it's of, and whether it's whole.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `ITARL-BW` |
//! | 4 | version of this format |
//! | 4 | `BT_BULLET_VERSION` |
//! | 4 | bytes of a `btScalar`: 4 or 8 |
//! | 8 | hash of how the world was built |
//! | 8 | length of the state |
//! | .. | the state, as `cpp/snapshot.cc` writes it |
//! | 8 | XXH3 of all bytes before |
//!
//! All numbers are little-endian. The state's layout is private and changes with the version.

use xxhash_rust::xxh3::xxh3_64;

use crate::constants::{BT_BULLET_VERSION, SCALAR_BYTES};

const MAGIC: &[u8; 8] = b"ITARL-BW";
const VERSION: u32 = 1;
const HEADER: usize = 36;
const CHECKSUM: usize = 8;

/// Why bytes can't be restored. Unless it's [`SnapshotError::Malformed`], the world is as before.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// Not a snapshot at all.
    #[error("these bytes are not the snapshot of a world")]
    NotASnapshot,
    /// Shorter or longer than it says, or a bit has changed.
    #[error("damaged: {0}")]
    Damaged(String),
    /// Whole, but from another version of this format, of Bullet, or of another precision.
    #[error("written with {what} {found}, and this program reads {expected}")]
    Version {
        /// What differs.
        what: &'static str,
        /// What the bytes say.
        found: u32,
        /// What would do.
        expected: u32,
    },
    /// Whole, but of a world that was built in another way.
    #[error("of another world: its settings, shapes, bodies or joints were added differently")]
    OtherWorld,
    /// Whole, with a right checksum, and still senseless. The world is now in between and refuses
    /// to step until something else is restored.
    #[error("{0}")]
    Malformed(String),
}

pub(crate) fn seal(build: u64, state: &[u8], out: &mut Vec<u8>) {
    out.clear();
    out.extend_from_slice(MAGIC);
    out.extend_from_slice(&VERSION.to_le_bytes());
    out.extend_from_slice(&BT_BULLET_VERSION.to_le_bytes());
    out.extend_from_slice(&(SCALAR_BYTES as u32).to_le_bytes());
    out.extend_from_slice(&build.to_le_bytes());
    out.extend_from_slice(&(state.len() as u64).to_le_bytes());
    out.extend_from_slice(state);
    out.extend_from_slice(&xxh3_64(out).to_le_bytes());
}

pub(crate) fn open(build: u64, bytes: &[u8]) -> Result<&[u8], SnapshotError> {
    if !bytes.starts_with(MAGIC) {
        return Err(SnapshotError::NotASnapshot);
    }
    let damaged = |what: String| Err(SnapshotError::Damaged(what));
    if bytes.len() < HEADER + CHECKSUM {
        return damaged(format!("only {} bytes", bytes.len()));
    }
    let (body, checksum) = bytes.split_at(bytes.len() - CHECKSUM);
    let length = read_u64(&body[28..36]);
    if length != (body.len() - HEADER) as u64 {
        return damaged(format!(
            "{} bytes of state where {length} were written",
            body.len() - HEADER
        ));
    }
    if read_u64(checksum) != xxh3_64(body) {
        return damaged("its checksum is wrong".into());
    }
    let expected = [
        ("format version", VERSION),
        ("Bullet", BT_BULLET_VERSION),
        ("scalar bytes", SCALAR_BYTES as u32),
    ];
    for (i, (what, expected)) in expected.into_iter().enumerate() {
        let found = read_u64(&body[8 + 4 * i..12 + 4 * i]) as u32;
        if found != expected {
            return Err(SnapshotError::Version { what, found, expected });
        }
    }
    if read_u64(&body[20..28]) != build {
        return Err(SnapshotError::OtherWorld);
    }
    Ok(&body[HEADER..])
}

/// Little-endian, of up to 8 bytes.
fn read_u64(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u64::from(byte))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn sealed(build: u64, state: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        seal(build, state, &mut bytes);
        bytes
    }

    proptest! {
        #[test]
        fn what_was_sealed_can_be_opened(build: u64, state: Vec<u8>) {
            let bytes = sealed(build, &state);
            prop_assert_eq!(open(build, &bytes), Ok(&state[..]));
            prop_assert_eq!(open(build ^ 1, &bytes), Err(SnapshotError::OtherWorld));
        }

        #[test]
        fn damage_is_an_error(state: Vec<u8>, place: prop::sample::Index, bit in 0_u8..8) {
            let mut bytes = sealed(7, &state);
            let place = place.index(bytes.len());
            prop_assert!(open(7, &bytes[..place]).is_err());
            bytes[place] ^= 1 << bit;
            prop_assert!(open(7, &bytes).is_err());
        }

        #[test]
        fn random_bytes_are_an_error(bytes: Vec<u8>) {
            prop_assert!(open(7, &bytes).is_err());
            prop_assert!(open(7, &[&MAGIC[..], &bytes].concat()).is_err());
        }
    }
}
