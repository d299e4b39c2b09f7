//! A cell as a reader may believe it: its checkpoint is of this cell, and the metrics begin with what
//! was written before it. Of the rows behind, of a cell at work, nobody can say more than that they
//! are rows.

use std::fs;

use super::{CellFolder, Checkpoint, Error, Expected, Header, Row, atomic, metrics::parse};

/// How often a cell is read again that was saved or begun anew meanwhile.
const ATTEMPTS: usize = 3;

impl CellFolder {
    /// How far its checkpoint is, without its sections being looked at; none if there's none yet.
    ///
    /// # Errors
    /// [`Error::Damaged`], [`Error::OtherCell`], [`Error::Beyond`] or [`Error::Version`], as a resume
    /// would refuse it; what reading runs into.
    pub fn header(&self, expected: Expected) -> Result<Option<Header>, Error> {
        Ok(self.vouched(expected)?.0)
    }

    /// All rows; none before the first update.
    ///
    /// # Errors
    /// As [`CellFolder::header`]; [`Error::Damaged`] with the line's number if it's no row.
    pub fn rows(&self, expected: Expected) -> Result<Vec<Row>, Error> {
        let (header, bytes) = self.vouched(expected)?;
        let rows = parse(&self.metrics(), &bytes)?;
        let saved = header.map_or(0, |header| header.updates);
        if (rows.len() as u64) < saved {
            let what = format!("{} rows, and the checkpoint has {saved} updates", rows.len());
            return Err(Error::damaged(&self.metrics(), what));
        }
        Ok(rows)
    }

    /// The whole checkpoint, sections and all, if it and the metrics are as they were written; none if
    /// there's none yet.
    ///
    /// # Errors
    /// As [`CellFolder::header`].
    pub fn whole(&self, expected: Expected) -> Result<Option<Checkpoint>, Error> {
        self.vouched(expected)?;
        Checkpoint::read(&self.checkpoint(), expected)
    }

    /// How far its checkpoint is, if its header and the lengths of its files are as a resume would have
    /// them; neither what it holds nor the metrics are read. Where something is wrong, all is, to say
    /// what.
    ///
    /// # Errors
    /// As [`CellFolder::whole`].
    pub(super) fn glance(&self, expected: Expected) -> Result<Option<Header>, Error> {
        let fits = |header: &Header| {
            let length = fs::metadata(self.metrics()).map(|it| it.len());
            header.check(&self.checkpoint(), expected).is_ok()
                && length.is_ok_and(|length| length >= header.metrics.length)
        };
        match Header::of_right_length(&self.checkpoint()).filter(fits) {
            Some(header) => Ok(Some(header)),
            None => Ok(self.whole(expected)?.map(|checkpoint| checkpoint.header)),
        }
    }

    /// The checkpoint's header with the bytes of the metrics. A process may be at the cell just now:
    /// only what is wrong while the checkpoint stays the same is wrong.
    fn vouched(&self, expected: Expected) -> Result<(Option<Header>, Vec<u8>), Error> {
        let mut header = Header::read(&self.checkpoint())?;
        for _ in 1..ATTEMPTS {
            match self.metrics_behind(header, expected) {
                Ok(bytes) => return Ok((header, bytes)),
                Err(error) => {
                    let now = Header::read(&self.checkpoint())?;
                    if now == header {
                        return Err(error);
                    }
                    header = now;
                }
            }
        }
        Ok((header, self.metrics_behind(header, expected)?))
    }

    /// Read after the header: metrics only grow, so they begin with what the header knows.
    fn metrics_behind(&self, header: Option<Header>, expected: Expected) -> Result<Vec<u8>, Error> {
        let path = self.metrics();
        let Some(header) = header else {
            self.require_no_exports()?;
            return Ok(atomic::read(&path)?.unwrap_or_default());
        };
        header.check(&self.checkpoint(), expected)?;
        let bytes = atomic::read(&path)?
            .ok_or_else(|| Error::damaged(&path, "missing, and the checkpoint goes on from it"))?;
        header.metrics.check(&path, &bytes)?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use std::{
        collections::BTreeMap,
        sync::atomic::{AtomicBool, Ordering},
        thread,
    };

    use proptest::prelude::*;

    use super::*;
    use crate::{OpenCell, Snapshot};

    const EXPECTED: Expected = Expected { identity: 7, updates: 1000, steps_per_update: 10 };

    fn append(cell: &mut OpenCell, update: u64) {
        let reward = 0.1 / update as f64;
        cell.append(&Row { update, control_steps: 10 * update, reward, ..Row::default() }).unwrap();
    }

    fn save(cell: &mut OpenCell, updates: u64) {
        let sections = BTreeMap::from([("world".to_string(), vec![updates as u8; 9])]);
        let (policy, replay) = (&b"p"[..], &b"r"[..]);
        cell.save(Snapshot { updates, control_steps: 10 * updates, sections, policy, replay })
            .unwrap();
    }

    /// A cell with a checkpoint at `saved` and `rows` rows.
    fn cell(saved: u64, rows: u64) -> (tempfile::TempDir, CellFolder) {
        let folder = tempfile::tempdir().unwrap();
        let cell = CellFolder::new(folder.path().join("seed=1"));
        let (mut open, _) = OpenCell::open(cell.clone(), EXPECTED).unwrap();
        for update in 1..=rows {
            append(&mut open, update);
            if update == saved {
                save(&mut open, saved);
            }
        }
        (folder, cell)
    }

    /// What a resume refuses, a reader refuses; both for the same reason.
    #[track_caller]
    fn refused(cell: &CellFolder, expected: Expected, message: &str) {
        let errors = [
            cell.rows(expected).map(|_| ()).unwrap_err().to_string(),
            cell.whole(expected).map(|_| ()).unwrap_err().to_string(),
            OpenCell::open(cell.clone(), expected).map(|_| ()).unwrap_err().to_string(),
        ];
        for error in &errors {
            assert!(error.contains(message), "{error}");
            assert_eq!(*error, errors[0]);
        }
    }

    #[test]
    fn rows_behind_the_checkpoint_are_read_too() {
        let (_folder, cell) = cell(4, 6);
        assert_eq!(cell.rows(EXPECTED).unwrap().len(), 6);
        assert_eq!(cell.header(EXPECTED).unwrap().unwrap().updates, 4);
        // Half of a row.
        let bytes = fs::read(cell.metrics()).unwrap();
        fs::write(cell.metrics(), &bytes[..bytes.len() - 9]).unwrap();
        assert_eq!(cell.rows(EXPECTED).unwrap().len(), 5);
    }

    #[test]
    fn before_the_first_checkpoint_rows_stand_alone() {
        let (_folder, cell) = cell(9, 3);
        assert_eq!(cell.rows(EXPECTED).unwrap().len(), 3);
        assert_eq!(cell.header(EXPECTED).unwrap(), None);
        let nowhere = CellFolder::new(cell.path().join("nowhere"));
        assert_eq!(nowhere.rows(EXPECTED).unwrap(), []);
    }

    #[test]
    fn what_a_resume_refuses_is_refused() {
        let (_folder, cell) = cell(4, 6);
        refused(&cell, Expected { identity: 8, ..EXPECTED }, "checkpoint: of another cell");
        refused(
            &cell,
            Expected { updates: 3, ..EXPECTED },
            "4 updates, and the experiment ends at 3",
        );
        refused(
            &cell,
            Expected { steps_per_update: 7, ..EXPECTED },
            "4 updates and 40 control steps",
        );
        let checkpoint = fs::read(cell.checkpoint()).unwrap();
        fs::remove_file(cell.checkpoint()).unwrap();
        refused(
            &cell,
            EXPECTED,
            "checkpoint: damaged: missing, though policy.safetensors was made",
        );
        fs::write(cell.checkpoint(), checkpoint).unwrap();
        fs::remove_file(cell.metrics()).unwrap();
        refused(
            &cell,
            EXPECTED,
            "metrics.csv: damaged: missing, and the checkpoint goes on from it",
        );
    }

    /// Its header is whole, so that a look at it alone finds nothing.
    #[test]
    fn damage_in_the_sections_of_a_checkpoint_is_found() {
        let (_folder, cell) = cell(4, 6);
        let mut bytes = fs::read(cell.checkpoint()).unwrap();
        bytes[80] ^= 1;
        fs::write(cell.checkpoint(), bytes).unwrap();
        assert!(cell.header(EXPECTED).is_ok());
        let error = cell.whole(EXPECTED).unwrap_err().to_string();
        assert!(error.contains("checkpoint: damaged: its checksum is wrong"), "{error}");
    }

    /// A checkpoint with right checksums that counts more updates than there are rows.
    #[test]
    fn updates_without_rows_are_damage() {
        let (_folder, cell) = cell(4, 4);
        let mut checkpoint = cell.whole(EXPECTED).unwrap().unwrap();
        (checkpoint.header.updates, checkpoint.header.control_steps) = (5, 50);
        checkpoint.write(&cell.checkpoint()).unwrap();
        let error = cell.rows(EXPECTED).unwrap_err().to_string();
        assert!(error.ends_with("damaged: 4 rows, and the checkpoint has 5 updates"), "{error}");
    }

    #[test]
    fn a_cell_at_work_is_never_called_damaged() {
        let (_folder, cell) = cell(0, 0);
        fs::remove_dir_all(cell.path()).unwrap();
        let done = AtomicBool::new(false);
        thread::scope(|scope| {
            scope.spawn(|| {
                for round in 0..20 {
                    let (mut open, checkpoint) = OpenCell::open(cell.clone(), EXPECTED).unwrap();
                    let saved = checkpoint.map_or(0, |it| it.header.updates);
                    assert_eq!(saved, 5 * round);
                    // The last one is cut off in the next round.
                    for update in saved + 1..=saved + 6 {
                        append(&mut open, update);
                        if update == saved + 5 {
                            save(&mut open, update);
                        }
                    }
                }
                done.store(true, Ordering::Relaxed);
            });
            let mut n_rows = 0;
            while !done.load(Ordering::Relaxed) {
                let rows = cell.rows(EXPECTED).unwrap();
                assert!(rows.iter().zip(1..).all(|(row, update)| row.update == update));
                assert!(rows.len() + 1 >= n_rows);
                n_rows = rows.len();
                cell.whole(EXPECTED).unwrap();
            }
        });
    }

    proptest! {
        // Each case forces files to the disk.
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Of the rows that the checkpoint knows, any that is lost and any bit that flips.
        #[test]
        fn damage_before_the_checkpoint_is_found(
            place: prop::sample::Index,
            bit in 0_u8..8,
            rows_behind in 0_u64..3,
        ) {
            let (_folder, cell) = cell(4, 4 + rows_behind);
            let known = cell.header(EXPECTED).unwrap().unwrap().metrics.length as usize;
            let bytes = fs::read(cell.metrics()).unwrap();
            let place = place.index(known);
            let mut flipped = bytes.clone();
            flipped[place] ^= 1 << bit;
            for damaged in [&bytes[..place], &flipped] {
                fs::write(cell.metrics(), damaged).unwrap();
                let is_damaged = matches!(cell.rows(EXPECTED), Err(Error::Damaged { .. }));
                prop_assert!(is_damaged);
            }
        }
    }
}
