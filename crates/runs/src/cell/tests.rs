//! A cell's files: interrupted, damaged, written to by others.

use std::fs;

use super::*;
use crate::{Signature, Writer, read_all, read_last};

const EXPECTED: Expected = Expected { identity: 7, updates: 100, steps_per_update: 100 };

fn row(update: u64) -> Row {
    Row { update, control_steps: 100 * update, reward: 0.1 / update as f64, ..Row::default() }
}

fn snapshot(updates: u64) -> Snapshot<'static> {
    let sections = BTreeMap::from([("world".to_string(), vec![updates as u8; 9])]);
    Snapshot { updates, control_steps: 100 * updates, sections, policy: b"p", replay: b"r" }
}

/// From where it stands to `end`, with a checkpoint every `every` updates and at the end.
fn run(folder: &CellFolder, end: u64, every: u64) {
    let (mut cell, checkpoint) = OpenCell::open(folder.clone(), EXPECTED).unwrap();
    let begin = checkpoint.map_or(0, |checkpoint| checkpoint.header.updates);
    for update in begin + 1..=end {
        cell.append(&row(update)).unwrap();
        if update % every == 0 {
            cell.save(snapshot(update)).unwrap();
        }
    }
}

/// All files but the lock, which says who was there.
fn files(folder: &CellFolder) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap());
    let entries = entries.filter(|it| it.path() != folder.lock());
    let mut files: Vec<_> = entries
        .map(|it| (it.file_name().into_string().unwrap(), fs::read(it.path()).unwrap()))
        .collect();
    files.sort();
    files
}

fn cells() -> (tempfile::TempDir, [CellFolder; 2]) {
    let folder = tempfile::tempdir().unwrap();
    let cells = ["a", "b"].map(|name| CellFolder::new(folder.path().join("cells").join(name)));
    (folder, cells)
}

#[test]
fn interrupted_anywhere_it_ends_with_the_same_bytes() {
    let (_folder, [through, interrupted]) = cells();
    run(&through, 12, 4);
    for end in [1, 3, 6, 4, 8, 11, 12] {
        run(&interrupted, end, 4);
        // What a process leaves that is killed within a write.
        fs::write(interrupted.path().join("checkpoint.tmp"), b"half").unwrap();
        let half_a_row = [fs::read(interrupted.metrics()).unwrap(), b"7,70".to_vec()].concat();
        fs::write(interrupted.metrics(), half_a_row).unwrap();
    }
    // Nothing is left to do but to open it, which cuts the metrics back.
    run(&interrupted, 12, 4);
    fs::remove_file(interrupted.path().join("checkpoint.tmp")).unwrap();
    assert_eq!(files(&interrupted), files(&through));
    assert_eq!(read_all(&through.metrics()).unwrap(), (1..=12).map(row).collect::<Vec<_>>());
    assert_eq!(read_last(&through.metrics()).unwrap(), Some(row(12)));
}

/// A cell of the first version: the same bytes as if that went on with it.
#[test]
fn a_cell_goes_on_with_the_columns_that_it_was_begun_with() {
    let (_folder, [new, old]) = cells();
    run(&new, 8, 4);
    run(&old, 4, 4);
    let shortened = |cell: &CellFolder| {
        let text = fs::read_to_string(cell.metrics()).unwrap();
        let lines = text.lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned() + "\n");
        lines.collect::<String>()
    };
    let text = shortened(&old);
    fs::write(old.metrics(), &text).unwrap();
    let mut checkpoint = Checkpoint::read(&old.checkpoint(), EXPECTED).unwrap().unwrap();
    let xxh3 = xxhash_rust::xxh3::xxh3_64(text.as_bytes());
    checkpoint.header.metrics = crate::Extent { length: text.len() as u64, xxh3 };
    checkpoint.write(&old.checkpoint()).unwrap();
    run(&old, 8, 4);
    assert_eq!(fs::read_to_string(old.metrics()).unwrap(), shortened(&new));
}

#[test]
fn one_process_at_a_time() {
    let (_folder, [folder, _]) = cells();
    let open = OpenCell::open(folder.clone(), EXPECTED).unwrap();
    let error = OpenCell::open(folder.clone(), EXPECTED).err().unwrap();
    assert!(matches!(error, Error::Locked { path } if path == folder.path()));
    drop(open);
    OpenCell::open(folder, EXPECTED).unwrap();
}

#[test]
fn damage_is_named_and_nothing_is_overwritten() {
    let (_folder, [folder, _]) = cells();
    run(&folder, 6, 4);
    let before = files(&folder);
    let refused = |identity, message: &str| {
        let damaged = files(&folder);
        let expected = Expected { identity, ..EXPECTED };
        let error = OpenCell::open(folder.clone(), expected).err().unwrap().to_string();
        assert!(error.contains(message), "{error}");
        assert_eq!(files(&folder), damaged);
        before.iter().for_each(|(name, it)| fs::write(folder.path().join(name), it).unwrap());
    };
    refused(8, "checkpoint: of another cell");
    let mut bytes = fs::read(folder.checkpoint()).unwrap();
    bytes[70] ^= 1;
    fs::write(folder.checkpoint(), &bytes).unwrap();
    refused(7, "checkpoint: damaged: its checksum is wrong");
    fs::remove_file(folder.checkpoint()).unwrap();
    refused(7, "checkpoint: damaged: missing, though policy.safetensors was made from one");
    let mut bytes = fs::read(folder.metrics()).unwrap();
    bytes[200] ^= 1;
    fs::write(folder.metrics(), &bytes).unwrap();
    refused(7, "metrics.csv: damaged: its first");
    fs::write(folder.metrics(), &bytes[..200]).unwrap();
    refused(7, "metrics.csv: damaged: 200 bytes, and");
    OpenCell::open(folder.clone(), EXPECTED).unwrap();
}

#[test]
fn a_failed_write_keeps_the_older_checkpoint() {
    let (_folder, [folder, _]) = cells();
    run(&folder, 4, 4);
    let (mut cell, _) = OpenCell::open(folder.clone(), EXPECTED).unwrap();
    fs::create_dir(folder.path().join("checkpoint.tmp")).unwrap();
    cell.append(&row(5)).unwrap();
    let error = cell.save(snapshot(5)).unwrap_err().to_string();
    assert!(error.contains("checkpoint.tmp: removing what is in the way: "), "{error}");
    drop(cell);
    let (_, checkpoint) = OpenCell::open(folder, EXPECTED).unwrap();
    assert_eq!(checkpoint.unwrap().header.updates, 4);
}

/// A process was stopped, its folder renamed, and another run begun in its place.
#[test]
fn a_forgotten_process_writes_nothing_into_the_run_in_its_place() {
    let (parent, [folder, _]) = cells();
    run(&folder, 4, 4);
    let (mut forgotten, _) = OpenCell::open(folder.clone(), EXPECTED).unwrap();
    let renamed = parent.path().join("renamed");
    fs::rename(folder.path(), &renamed).unwrap();
    let is_refused = |result| match result {
        Err(Error::Moved { path }) => path == folder.path(),
        _ => false,
    };
    assert!(is_refused(forgotten.save(snapshot(5))));
    assert!(!folder.path().exists());

    run(&folder, 60, 4);
    let before = files(&folder);
    forgotten.append(&row(5)).unwrap();
    assert!(is_refused(forgotten.save(snapshot(5))));
    assert!(is_refused(forgotten.export(b"other", b"other")));
    assert!(is_refused(forgotten.fail("it blew up")));
    assert_eq!(files(&folder), before);

    // Its own folder is whole.
    drop(forgotten);
    let (_, checkpoint) = OpenCell::open(CellFolder::new(renamed), EXPECTED).unwrap();
    assert_eq!(checkpoint.unwrap().header.updates, 4);
}

#[test]
fn more_updates_than_the_experiment_has_are_damage() {
    let (_folder, [folder, _]) = cells();
    run(&folder, 6, 4);
    let before = files(&folder);
    let fewer = Expected { updates: 3, ..EXPECTED };
    let error = OpenCell::open(folder.clone(), fewer).err().unwrap().to_string();
    assert!(error.contains("checkpoint: damaged: it has 4 updates, and the experiment ends at 3"));
    assert_eq!(files(&folder), before);
}

/// As another process would.
fn sign(folder: &CellFolder) -> Writer {
    let writer = Writer { process: 0, ..Writer::this().clone() };
    let signature = Signature { writer: writer.clone(), updates: 0 };
    fs::write(folder.lock(), serde_json::to_vec(&signature).unwrap()).unwrap();
    writer
}

/// As where two machines have a lock each.
#[test]
fn what_another_one_writes_to_is_left_to_it() {
    let (_folder, [folder, _]) = cells();
    let (mut cell, _) = OpenCell::open(folder.clone(), EXPECTED).unwrap();
    cell.append(&row(1)).unwrap();
    cell.save(snapshot(1)).unwrap();
    let other = sign(&folder);
    let before = files(&folder);
    let saved = cell.save(snapshot(2));
    assert!(matches!(saved, Err(Error::Foreign { writer, .. }) if writer == other));
    assert!(matches!(cell.fail("?"), Err(Error::Foreign { .. })));
    assert_eq!(files(&folder), before);
}

/// As of a machine whose locks and whose signature this one doesn't see.
#[test]
fn a_checkpoint_that_another_one_wrote_is_left_to_it() {
    let (_folder, [folder, _]) = cells();
    let (mut cell, _) = OpenCell::open(folder.clone(), EXPECTED).unwrap();
    let header = |updates| Header {
        identity: EXPECTED.identity,
        updates,
        control_steps: 100 * updates,
        metrics: crate::Extent::empty(),
    };
    let of_another = |updates| {
        let sections = BTreeMap::new();
        Checkpoint { header: header(updates), sections }.write(&folder.checkpoint()).unwrap();
        files(&folder)
    };
    // Of who was there before, and saw too late that this one came.
    of_another(1);
    for updates in [1, 2] {
        cell.append(&row(updates)).unwrap();
        cell.save(snapshot(updates)).unwrap();
    }
    // Behind, as far, or ahead.
    for updates in [1, 2, 3] {
        let before = of_another(updates);
        let results =
            [cell.save(snapshot(3)), cell.export(b"other", b"other"), cell.fail("it blew up")];
        for result in results {
            let is_refused = matches!(
                result,
                Err(Error::ForeignCheckpoint { found, written: 2, .. }) if found == updates
            );
            assert!(is_refused, "{updates}");
        }
        assert_eq!(files(&folder), before);
    }
}

/// What was computed isn't lost with it.
#[test]
fn a_checkpoint_that_was_lost_or_damaged_meanwhile_is_written_again() {
    let (_folder, [folder, _]) = cells();
    run(&folder, 2, 2);
    let (mut cell, _) = OpenCell::open(folder.clone(), EXPECTED).unwrap();
    let harms: [fn(&Path); 2] =
        [|path| fs::remove_file(path).unwrap(), |path| fs::write(path, "?").unwrap()];
    for (updates, harm) in (3..).zip(harms) {
        harm(&folder.checkpoint());
        cell.append(&row(updates)).unwrap();
        cell.save(snapshot(updates)).unwrap();
        let found = Header::read(&folder.checkpoint()).unwrap().unwrap();
        assert_eq!(found.updates, updates);
    }
}

/// So that the lock still tells who wrote what is there.
#[test]
fn a_cell_that_is_done_is_looked_at_without_a_name() {
    let (_folder, [folder, _]) = cells();
    run(&folder, 4, 2);
    sign(&folder);
    let other = fs::read(folder.lock()).unwrap();
    let expected = Expected { updates: 4, ..EXPECTED };
    let (mut cell, _) = OpenCell::open(folder.clone(), expected).unwrap();
    cell.export(b"p", b"r").unwrap();
    assert_eq!(fs::read(folder.lock()).unwrap(), other);
    cell.export(b"P", b"r").unwrap();
    let signature = Signature::read(&folder.lock()).unwrap().unwrap();
    assert_eq!((&signature.writer, signature.updates), (Writer::this(), 4));
}

#[test]
fn a_failure_is_marked() {
    let (_folder, [folder, _]) = cells();
    let (mut cell, _) = OpenCell::open(folder.clone(), EXPECTED).unwrap();
    assert_eq!(folder.failure().unwrap(), None);
    cell.fail("body 'tibia_3' is at NaN, control step 7").unwrap();
    let reason = folder.failure().unwrap();
    assert_eq!(reason.as_deref(), Some("body 'tibia_3' is at NaN, control step 7"));
}
