//! `replay.safetensors`: T control steps with F frames of B bodies, from the oldest to the newest.
//!
//! | tensor | type, shape |
//! |---|---|
//! | `poses` | F32 `[T x F x B x 7]` |
//! | `sensors` | F32 `[T x n_sensors]` |
//! | `actions` | F32 `[T x n_actuators]` |
//! | `contacts` | U8 `[T x B]` |
//! | `terms` | F64 `[T x n_terms]` |
//!
//! The metadata's one entry, `itarl`, is JSON with everything else, its keys sorted. (One entry,
//! because the format's library writes several in any order.)
//!
//! Version 2's checksum is of all that's believed: of the tensors' bytes, then of T and the metadata.
//! Version 1's is of the tensors alone. It's still read; and it's still what a checkpoint has in it,
//! which has a checksum of its own over all. Version 3 is 2 with `poses` in I16, as [`Packing`] has
//! them: what is published, half as large.

use std::{collections::HashMap, path::Path};

use safetensors::{
    Dtype, SafeTensors,
    tensor::{TensorView, serialize},
};
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::Xxh3;

use super::{Error, POSE, Packing, RecordingLayout};
use crate::{Hash, atomic};

/// The tensors' names.
pub const TENSORS: [&str; 5] = ["poses", "sensors", "actions", "contacts", "terms"];

/// The one entry of the metadata.
pub(crate) const ENTRY: &str = "itarl";
const VERSION: u64 = 2;
/// With poses in 16 bits a number.
const PACKED: u64 = 3;
/// Of tensors whose metadata is guarded by whoever holds the bytes.
const UNGUARDED: u64 = 1;

/// Some control steps as they were. Arrays are row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// What a control step consists of.
    pub layout: RecordingLayout,
    /// Number of the oldest control step, counted from 0.
    pub first_control_step: u64,
    /// The number T of control steps.
    pub n_steps: usize,
    /// \[T x frames_per_step x n_bodies x 7\]: x y z in metres, quaternion x y z w
    pub poses: Vec<f32>,
    /// \[T x n_sensors\], within -1 to 1
    pub sensors: Vec<f32>,
    /// \[T x n_actuators\], within -1 to 1
    pub actions: Vec<f32>,
    /// \[T x n_bodies\], 0 or 1
    pub contacts: Vec<u8>,
    /// \[T x n_terms\]
    pub terms: Vec<f64>,
}

/// What stands in the metadata. The fields are sorted by name, and so are the keys.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Metadata {
    first_control_step: u64,
    format: u64,
    layout: RecordingLayout,
    /// Of packed poses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    packing: Option<Packing>,
    /// As [`hash`] makes it.
    xxh3: Hash,
}

/// What is read first: another version may have other keys.
#[derive(Deserialize)]
struct Format {
    format: u64,
}

impl Recording {
    /// The bytes of a safetensors file, the same ones for the same content.
    ///
    /// # Errors
    /// If an array isn't as long as the layout and T say.
    pub fn encode(&self) -> Result<Vec<u8>, Error> {
        self.encode_as(VERSION)
    }

    /// The bytes of a checkpoint's section, the same ones for the same content and for all versions
    /// of this program: a checkpoint's bytes are a result.
    ///
    /// # Errors
    /// As [`Recording::encode`].
    pub fn section(&self) -> Result<Vec<u8>, Error> {
        self.encode_as(UNGUARDED)
    }

    /// The bytes of a safetensors file with poses in 16 bits a number: each comes back to half of a
    /// [`Packing`]'s step.
    ///
    /// # Errors
    /// As [`Recording::encode`]; a pose that isn't finite.
    pub fn encode_packed(&self) -> Result<Vec<u8>, Error> {
        if !self.poses.iter().all(|number| number.is_finite()) {
            let (expected, found) = ("finite numbers", "NaN or an infinity");
            return Err(Error::argument("Recording::encode_packed", "poses", expected, found));
        }
        self.encode_as(PACKED)
    }

    /// Its last control steps: as many as packed tensors of so many bytes hold, at least one.
    #[must_use]
    pub fn fitting(&self, most_bytes: usize) -> Self {
        let Self { layout, n_steps, .. } = self;
        let Some(widths) = layout.widths() else { return self.clone() };
        let bytes = widths.iter().zip(PACKED_BYTES).map(|(width, size)| width.saturating_mul(size));
        let step = bytes.fold(0, usize::saturating_add).max(1);
        let kept = (most_bytes / step).max(1).min(*n_steps);
        let dropped = n_steps - kept;
        let [poses, sensors, actions, contacts, terms] = widths.map(|width| width * dropped);
        Self {
            layout: layout.clone(),
            first_control_step: self.first_control_step + dropped as u64,
            n_steps: kept,
            poses: self.poses[poses..].to_vec(),
            sensors: self.sensors[sensors..].to_vec(),
            actions: self.actions[actions..].to_vec(),
            contacts: self.contacts[contacts..].to_vec(),
            terms: self.terms[terms..].to_vec(),
        }
    }

    fn encode_as(&self, format: u64) -> Result<Vec<u8>, Error> {
        let refused = |what: &str, expected: String, found: String| {
            Error::argument("Recording::encode", what, expected, found)
        };
        let poses = || self.poses.chunks_exact(POSE);
        let packing = (format == PACKED).then(|| Packing::covering(poses()));
        let parts = [
            match packing {
                None => little_endian(&self.poses, f32::to_le_bytes),
                Some(packing) => {
                    let packed: Vec<_> = poses().flat_map(|pose| packing.pack(pose)).collect();
                    little_endian(&packed, i16::to_le_bytes)
                }
            },
            little_endian(&self.sensors, f32::to_le_bytes),
            little_endian(&self.actions, f32::to_le_bytes),
            self.contacts.clone(),
            little_endian(&self.terms, f64::to_le_bytes),
        ];
        let unwritable = |error: serde_json::Error| {
            refused("the layout", "what JSON can hold".into(), error.to_string())
        };
        let mut metadata = Metadata {
            first_control_step: self.first_control_step,
            format,
            layout: self.layout.clone(),
            packing,
            xxh3: Hash(0),
        };
        let slices = parts.each_ref().map(Vec::as_slice);
        metadata.xxh3 = hash(slices, self.n_steps, &metadata).map_err(unwritable)?;
        let metadata = serde_json::to_string(&metadata).map_err(unwritable)?;
        let views: Result<Vec<_>, _> = tensors(&self.layout, self.n_steps, format)
            .into_iter()
            .zip(&parts)
            .map(|((name, dtype, shape), part)| {
                TensorView::new(dtype, shape, part).map(|view| (name, view))
            })
            .collect();
        views
            .and_then(|views| serialize(views, Some(HashMap::from([(ENTRY.into(), metadata)]))))
            .map_err(|error| {
                refused("the arrays", format!("{} control steps", self.n_steps), error.to_string())
            })
    }

    /// The content of a file's bytes. `path` is for the messages.
    ///
    /// # Errors
    /// [`Error::Damaged`] if they aren't what was written, [`Error::Version`].
    pub fn decode(path: &Path, bytes: &[u8]) -> Result<Self, Error> {
        let damaged = |what: String| Error::damaged(path, what);
        let file = SafeTensors::deserialize(bytes).map_err(|error| damaged(error.to_string()))?;
        let metadata = metadata(path, bytes)?;
        let layout = &metadata.layout;
        let steps_of = |name| file.tensor(name).ok().and_then(|view| view.shape().first().copied());
        let n_steps = steps_of("terms").ok_or_else(|| damaged("no tensor `terms`".into()))?;
        let mut parts = [&[][..]; TENSORS.len()];
        for ((name, dtype, shape), part) in
            tensors(layout, n_steps, metadata.format).into_iter().zip(&mut parts)
        {
            let view = file.tensor(name).map_err(|error| damaged(error.to_string()))?;
            if (view.dtype(), view.shape()) != (dtype, &shape) {
                let found = format!("{} {:?}", view.dtype(), view.shape());
                return Err(damaged(format!("{name}: expected {dtype} {shape:?}, found {found}")));
            }
            *part = view.data();
        }
        let packing = metadata.packing;
        if packing.is_some() != (metadata.format == PACKED) {
            return Err(damaged(format!("version {} and `packing`", metadata.format)));
        }
        let hash = hash(parts, n_steps, &metadata).map_err(|error| damaged(error.to_string()))?;
        if hash != metadata.xxh3 {
            return Err(damaged("its checksum is wrong".into()));
        }
        Ok(Self {
            layout: metadata.layout,
            first_control_step: metadata.first_control_step,
            n_steps,
            poses: match packing {
                None => numbers(parts[0], f32::from_le_bytes),
                Some(packing) => {
                    let packed = numbers(parts[0], i16::from_le_bytes);
                    packed.as_chunks().0.iter().flat_map(|&pose| packing.unpack(pose)).collect()
                }
            },
            sensors: numbers(parts[1], f32::from_le_bytes),
            actions: numbers(parts[2], f32::from_le_bytes),
            contacts: parts[3].to_vec(),
            terms: numbers(parts[4], f64::from_le_bytes),
        })
    }

    /// The content of a file; none if there's no such file.
    ///
    /// # Errors
    /// As [`Recording::decode`], and what reading runs into.
    pub fn read(path: &Path) -> Result<Option<Self>, Error> {
        atomic::read(path)?.map(|bytes| Self::decode(path, &bytes)).transpose()
    }
}

fn metadata(path: &Path, bytes: &[u8]) -> Result<Metadata, Error> {
    let damaged = |what: String| Error::damaged(path, what);
    let (_, header) =
        SafeTensors::read_metadata(bytes).map_err(|error| damaged(error.to_string()))?;
    let entry = header.metadata().as_ref().and_then(|entries| entries.get(ENTRY));
    let entry = entry.ok_or_else(|| damaged(format!("no entry `{ENTRY}` in its metadata")))?;
    let unreadable = |error: serde_json::Error| damaged(format!("metadata `{ENTRY}`: {error}"));
    let Format { format: found } = serde_json::from_str(entry).map_err(unreadable)?;
    if ![UNGUARDED, VERSION, PACKED].contains(&found) {
        return Err(Error::Version { path: path.into(), found, expected: VERSION });
    }
    serde_json::from_str(entry).map_err(unreadable)
}

/// Bytes of a number of each tensor in version 3, in the order of [`TENSORS`].
const PACKED_BYTES: [usize; 5] = [2, 4, 4, 1, 8];

/// Name, type and shape of each tensor, in the order of [`TENSORS`].
fn tensors(
    layout: &RecordingLayout,
    n_steps: usize,
    format: u64,
) -> [(&'static str, Dtype, Vec<usize>); 5] {
    let of_poses = if format == PACKED { Dtype::I16 } else { Dtype::F32 };
    let n_bodies = layout.bodies.len();
    let [poses, sensors, actions, contacts, terms] = TENSORS;
    [
        (poses, of_poses, vec![n_steps, layout.frames_per_step, n_bodies, POSE]),
        (sensors, Dtype::F32, vec![n_steps, layout.sensors.len()]),
        (actions, Dtype::F32, vec![n_steps, layout.actuators.len()]),
        (contacts, Dtype::U8, vec![n_steps, n_bodies]),
        (terms, Dtype::F64, vec![n_steps, layout.terms.len()]),
    ]
}

/// The checksum that belongs to these tensors, in the order of [`TENSORS`], and to T and the metadata,
/// whose own one isn't looked at.
fn hash(parts: [&[u8]; 5], n_steps: usize, metadata: &Metadata) -> serde_json::Result<Hash> {
    let Metadata { first_control_step, format, layout, packing, .. } = metadata;
    let mut hash = Xxh3::new();
    parts.iter().for_each(|part| hash.update(part));
    if *format != UNGUARDED {
        hash.update(&serde_json::to_vec(&(first_control_step, format, layout, n_steps))?);
    }
    if let Some(packing) = packing {
        hash.update(&serde_json::to_vec(packing)?);
    }
    Ok(Hash(hash.digest()))
}

fn little_endian<T: Copy, const N: usize>(values: &[T], bytes: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    values.iter().flat_map(|&value| bytes(value)).collect()
}

fn numbers<T, const N: usize>(bytes: &[u8], number: impl Fn([u8; N]) -> T) -> Vec<T> {
    bytes.as_chunks().0.iter().map(|&chunk| number(chunk)).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn small() -> Recording {
        let names = |names: &[&str]| names.iter().map(ToString::to_string).collect();
        Recording {
            layout: RecordingLayout {
                actuators: names(&["hip"]),
                bodies: names(&["torso", "foot"]),
                frames_per_step: 1,
                seconds_per_frame: 0.1,
                sensors: names(&["hip", "foot touches"]),
                terms: names(&["locomotion"]),
            },
            first_control_step: 7,
            n_steps: 2,
            poses: (0..28).map(|i| i as f32).collect(),
            sensors: vec![0.5, 1.0, -0.5, 0.0],
            actions: vec![0.5, -0.5],
            contacts: vec![0, 1, 0, 0],
            terms: vec![0.1, f64::NAN],
        }
    }

    fn decode(bytes: &[u8]) -> Result<Recording, Error> {
        Recording::decode(Path::new("replay.safetensors"), bytes)
    }

    #[test]
    fn what_was_encoded_is_decoded() {
        let bytes = small().encode().unwrap();
        let decoded = decode(&bytes).unwrap();
        // NaN isn't itself, so the bytes are compared.
        assert_eq!(decoded.encode().unwrap(), bytes);
        assert_eq!(decoded.poses, small().poses);
        assert_eq!((decoded.first_control_step, decoded.layout), (7, small().layout));
    }

    #[test]
    fn the_keys_of_the_metadata_are_sorted() {
        let bytes = small().encode().unwrap();
        let (_, header) = SafeTensors::read_metadata(&bytes).unwrap();
        let entry = &header.metadata().as_ref().unwrap()[ENTRY];
        let value: serde_json::Value = serde_json::from_str(entry).unwrap();
        let mut sorted = std::collections::BTreeMap::new();
        sorted.extend(value.as_object().unwrap().iter());
        assert_eq!(&serde_json::to_string(&sorted).unwrap(), entry);
    }

    #[test]
    fn arrays_that_do_not_fit_are_refused() {
        let error = Recording { n_steps: 3, ..small() }.encode().unwrap_err().to_string();
        assert!(error.contains("the arrays must be 3 control steps"), "{error}");
        let mut short = small();
        short.terms.pop();
        assert!(short.encode().is_err());
    }

    #[test]
    fn another_version_is_named() {
        let text = b"\\\"format\\\":2";
        let mut bytes = small().encode().unwrap();
        let at = bytes.windows(text.len()).position(|part| part == text).unwrap();
        bytes[at + text.len() - 1] = b'4';
        assert!(matches!(decode(&bytes), Err(Error::Version { found: 4, expected: 2, .. })));
        // The tensors aren't those of that version.
        bytes[at + text.len() - 1] = b'3';
        assert!(matches!(decode(&bytes), Err(Error::Damaged { .. })));
    }

    /// What version 1 wrote is read; and it's part of checkpoints, whose bytes must stay what they are.
    #[test]
    fn the_first_version_stays_what_it_is() {
        let bytes = small().section().unwrap();
        assert_eq!(format!("{:016x}", xxhash_rust::xxh3::xxh3_64(&bytes)), "9de723a9c73c0e95");
        let decoded = decode(&bytes).unwrap();
        assert_eq!(decoded.section().unwrap(), bytes);
        assert_eq!(decoded.layout, small().layout);
    }

    fn posed() -> Recording {
        let turned = [0.6, 0.0, 0.0, 0.8];
        let pose = |i: usize| [&[i as f32, -0.5, 0.1 * i as f32], &turned[..]].concat();
        Recording { poses: (0..4).flat_map(pose).collect(), terms: vec![0.1, 7.0], ..small() }
    }

    #[test]
    fn a_packed_one_is_the_same_but_for_half_a_step() {
        let packed = posed().encode_packed().unwrap();
        assert_eq!(packed, posed().encode_packed().unwrap());
        let decoded = decode(&packed).unwrap();
        for (found, expected) in decoded.poses.iter().zip(posed().poses) {
            // Steps of 3 m / 65534.
            assert!((found - expected).abs() <= 2.3e-5, "{found}, not {expected}");
        }
        assert_eq!(Recording { poses: posed().poses, ..decoded }, posed());
        let mut blown = posed();
        blown.poses[3] = f32::NAN;
        let error = blown.encode_packed().unwrap_err().to_string();
        assert!(error.contains("poses must be finite numbers, got NaN"), "{error}");
        let none = Recording { n_steps: 0, poses: vec![], sensors: vec![], ..small() };
        let none = Recording { actions: vec![], contacts: vec![], terms: vec![], ..none };
        assert_eq!(decode(&none.encode_packed().unwrap()).unwrap(), none);
    }

    /// A step has 2 x 7 numbers of 2 bytes, 3 of 4, 2 bytes and a term of 8: 50 bytes.
    #[test]
    fn the_last_steps_are_kept_that_fit() {
        assert_eq!(posed().fitting(100), posed());
        for bytes in [0, 99] {
            let last = posed().fitting(bytes);
            assert_eq!((last.n_steps, last.first_control_step), (1, 8));
            assert_eq!(
                (&last.poses[..], &last.sensors[..]),
                (&posed().poses[14..], &[-0.5, 0.0][..])
            );
            assert_eq!(
                (last.actions[0], last.terms[0], &last.contacts[..]),
                (-0.5, 7.0, &[0, 0][..])
            );
            assert_eq!(decode(&last.encode().unwrap()).unwrap(), last);
        }
    }

    proptest! {
        #[test]
        fn damage_of_a_packed_one_is_an_error(place: prop::sample::Index, bit in 0_u8..8) {
            let whole = posed().encode_packed().unwrap();
            let mut bytes = whole.clone();
            bytes[place.index(whole.len())] ^= 1 << bit;
            let believed = decode(&bytes).ok();
            prop_assert!(believed.is_none_or(|it| it == decode(&whole).unwrap()));
        }

        #[test]
        fn damage_is_an_error(place: prop::sample::Index, bit in 0_u8..8) {
            let whole = small().encode().unwrap();
            let mut bytes = whole.clone();
            let place = place.index(bytes.len());
            let cut = matches!(decode(&bytes[..place]), Err(Error::Damaged { .. }));
            prop_assert!(cut);
            bytes[place] ^= 1 << bit;
            // A flipped bit in a blank of the header may go unseen; what's believed is what was
            // written.
            let believed = decode(&bytes).ok().map(|it| it.encode().unwrap());
            prop_assert!(believed.is_none_or(|believed| believed == whole));
        }
    }
}
