//! Whether nothing is left to do at a cell, told by headers and lengths alone: a run may have thousands that
//! are done, and to read all of each takes a while.
//!
//! The last file that is written after a checkpoint is the recording, whose header says where it ends: if
//! that's where the checkpoint is, all before it was written, too.

use std::{fs, fs::File, os::unix::fs::FileExt, path::Path};

use safetensors::tensor::Metadata;
use serde::Deserialize;

use super::{
    CellFolder, Expected, Header,
    replay::{ENTRY, TENSORS},
};

impl CellFolder {
    /// Whether its checkpoint, of this cell in so many worlds, has all updates, the metrics end there, and
    /// the exports are of it. False also if one of them can't be read: who opens the cell is told what is
    /// wrong. Bytes that have changed aren't noticed, since only headers are read.
    #[must_use]
    pub fn is_complete(&self, expected: Expected, worlds: u64) -> bool {
        let Some(header) = Header::of_right_length(&self.checkpoint()) else { return false };
        let metrics = fs::metadata(self.metrics()).map(|it| it.len());
        header.updates >= expected.updates
            && header.check(&self.checkpoint(), expected).is_ok()
            && metrics.is_ok_and(|length| length == header.metrics.length)
            && tensors(&self.policy()).is_some()
            && recorded(&self.replay()) == header.control_steps.checked_div(worlds)
    }
}

/// Control steps that were done at a recording's end.
fn recorded(path: &Path) -> Option<u64> {
    #[derive(Deserialize)]
    struct First {
        first_control_step: u64,
    }
    let header = tensors(path)?;
    let First { first_control_step } =
        serde_json::from_str(header.metadata().as_ref()?.get(ENTRY)?).ok()?;
    let n_steps = *header.info(TENSORS[0])?.shape.first()?;
    first_control_step.checked_add(n_steps as u64)
}

/// The header of a safetensors file that is as long as its tensors make it.
fn tensors(path: &Path) -> Option<Metadata> {
    const SIZE: u64 = size_of::<u64>() as u64;
    let file = File::open(path).ok()?;
    let length = file.metadata().ok()?.len();
    let mut size = [0; SIZE as usize];
    file.read_exact_at(&mut size, 0).ok()?;
    // Before there's memory for it.
    let size = Some(u64::from_le_bytes(size)).filter(|size| *size <= length)?;
    let mut json = vec![0; usize::try_from(size).ok()?];
    file.read_exact_at(&mut json, SIZE).ok()?;
    let header: Metadata = serde_json::from_slice(&json).ok()?;
    (SIZE.checked_add(size)?.checked_add(header.data_len() as u64)? == length).then_some(header)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::{OpenCell, Recording, RecordingLayout, Row, Snapshot};

    const WORLDS: u64 = 2;
    const EXPECTED: Expected = Expected { identity: 7, updates: 3, steps_per_update: 10 };

    /// The recording of a cell with so many updates: its last two control steps in its first world.
    fn recording(updates: u64) -> Vec<u8> {
        let names = |names: &[&str]| names.iter().map(|it| (*it).to_owned()).collect();
        let layout = RecordingLayout {
            bodies: names(&["trunk"]),
            sensors: names(&["knee"]),
            actuators: names(&["knee"]),
            terms: names(&["reward"]),
            frames_per_step: 1,
            seconds_per_frame: 0.1,
        };
        let recording = Recording {
            layout,
            first_control_step: 10 * updates / WORLDS - 2,
            n_steps: 2,
            poses: vec![0.0; 14],
            sensors: vec![0.0; 2],
            actions: vec![0.0; 2],
            contacts: vec![0; 2],
            terms: vec![0.0; 2],
        };
        recording.encode().unwrap()
    }

    /// A cell that was saved after each of so many updates.
    fn cell(updates: u64) -> (tempfile::TempDir, CellFolder) {
        let folder = tempfile::tempdir().unwrap();
        let cell = CellFolder::new(folder.path().join("seed=1"));
        let (mut open, _) = OpenCell::open(cell.clone(), EXPECTED).unwrap();
        for update in 1..=updates {
            let control_steps = 10 * update;
            open.append(&Row { update, control_steps, ..Row::default() }).unwrap();
            let replay = recording(update);
            let sections = BTreeMap::from([("world".to_string(), vec![1; 9])]);
            // Any safetensors file will do.
            let policy = &replay[..];
            let replay = &replay[..];
            open.save(Snapshot { updates: update, control_steps, sections, policy, replay })
                .unwrap();
        }
        (folder, cell)
    }

    fn is_complete(cell: &CellFolder) -> bool {
        cell.is_complete(EXPECTED, WORLDS)
    }

    #[test]
    fn a_cell_is_complete_with_all_updates_and_no_others() {
        for updates in 0..3 {
            assert!(!is_complete(&cell(updates).1), "{updates}");
        }
        let (_folder, cell) = cell(3);
        assert!(is_complete(&cell));
        assert!(!cell.is_complete(Expected { updates: 4, ..EXPECTED }, WORLDS));
        assert!(!cell.is_complete(Expected { updates: 2, ..EXPECTED }, WORLDS));
        assert!(!cell.is_complete(Expected { identity: 8, ..EXPECTED }, WORLDS));
        assert!(!cell.is_complete(EXPECTED, 1) && !cell.is_complete(EXPECTED, 0));
    }

    /// As a process leaves it that is killed right after its last checkpoint.
    #[test]
    fn exports_of_an_earlier_checkpoint_are_noticed() {
        let (_folder, cell) = cell(3);
        fs::write(cell.replay(), recording(2)).unwrap();
        assert!(!is_complete(&cell));
        fs::write(cell.replay(), recording(3)).unwrap();
        assert!(is_complete(&cell));
    }

    #[test]
    fn what_is_missing_cut_off_or_too_long_is_noticed() {
        let (_folder, cell) = cell(3);
        for path in [cell.checkpoint(), cell.metrics(), cell.policy(), cell.replay()] {
            let bytes = fs::read(&path).unwrap();
            for length in 0..bytes.len() {
                fs::write(&path, &bytes[..length]).unwrap();
                assert!(!is_complete(&cell), "{} {length}", path.display());
            }
            fs::write(&path, [&bytes[..], b"x"].concat()).unwrap();
            assert!(!is_complete(&cell), "{}", path.display());
            fs::remove_file(&path).unwrap();
            assert!(!is_complete(&cell), "{}", path.display());
            fs::write(&path, bytes).unwrap();
        }
        assert!(is_complete(&cell));
    }
}
