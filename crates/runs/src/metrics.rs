//! `metrics.csv`: how learning goes, one row an update.
//!
//! The first line has the columns' names: those that there were when the file was begun. A number is
//! written with as few digits as give the same f64 again.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom},
    iter,
    path::Path,
};

use super::{
    Error, Row, atomic,
    error::At,
    row::{Columns, header_line},
};

/// Longer than two rows: each has 15 numbers of up to 24 characters and 4 counts of up to 20.
const TAIL: u64 = 1024;

/// The columns of a file; none if its first line isn't there yet, or not whole.
pub(super) fn read_columns(path: &Path) -> Result<Option<Columns>, Error> {
    let mut file = match File::open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        opened => opened.at(path, "opening")?,
    };
    let first = read_part(&mut file, 0, header_line().len() as u64).at(path, "reading")?;
    if !first.contains(&b'\n') && header_line().as_bytes().starts_with(&first) {
        return Ok(None);
    }
    columns(path, &first).map(Some)
}

/// The newest row; none if there's none yet, or no such file. Only the file's ends are read, and a
/// last line without a line break, which is just being written, isn't looked at.
///
/// # Errors
/// [`Error::Damaged`] if the first line or the newest row isn't what was written.
pub fn read_last(path: &Path) -> Result<Option<Row>, Error> {
    let Some(columns) = read_columns(path)? else { return Ok(None) };
    let header = columns.header_line();
    let mut file = File::open(path).at(path, "opening")?;
    let length = file.metadata().at(path, "asking for its length")?.len();
    let begin = length.saturating_sub(TAIL).max(header.len() as u64);
    let tail = read_part(&mut file, begin, TAIL).at(path, "reading")?;
    let whole = whole_lines(&tail);
    let Some(rest) = whole.strip_suffix(b"\n") else { return Ok(None) };
    let line = rest.rsplit(|&byte| byte == b'\n').next().unwrap_or_default();
    match rows(&[header.as_bytes(), line].concat(), &columns).next() {
        Some(Ok(row)) => Ok(Some(row)),
        Some(Err(error)) => {
            Err(Error::damaged(path, format!("last row: {}", explain(&error, &columns))))
        }
        None => Err(Error::damaged(path, "last row: empty")),
    }
}

/// All rows; none if there's no such file. A last line without a line break, which is just being
/// written, isn't looked at.
///
/// # Errors
/// [`Error::Damaged`], with the line's number.
pub fn read_all(path: &Path) -> Result<Vec<Row>, Error> {
    parse(path, &atomic::read(path)?.unwrap_or_default())
}

/// All rows in a file's bytes. `path` is for the messages.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<Row>, Error> {
    let whole = whole_lines(bytes);
    if whole.is_empty() {
        return Ok(Vec::new());
    }
    let columns = columns(path, whole)?;
    rows(whole, &columns)
        .map(|row| {
            row.map_err(|error| {
                let line = error.position().map_or(0, csv::Position::line);
                Error::damaged(path, format!("line {line}: {}", explain(&error, &columns)))
            })
        })
        .collect()
}

/// Up to the last line break, with it.
fn whole_lines(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |last| last + 1);
    &bytes[..end]
}

fn read_part(file: &mut File, begin: u64, length: u64) -> io::Result<Vec<u8>> {
    file.seek(SeekFrom::Start(begin))?;
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The columns that the first line of these bytes names.
fn columns(path: &Path, bytes: &[u8]) -> Result<Columns, Error> {
    let end = bytes.iter().position(|&byte| byte == b'\n');
    end.and_then(|end| Columns::of(&bytes[..end])).ok_or_else(|| {
        let [first, later] = Columns::required_and_later().map(|names| names.join(","));
        let what = format!("line 1: expected the columns {first}, then any of {later}");
        Error::damaged(path, what)
    })
}

/// The rows behind a first line, which names these columns.
fn rows(lines: &[u8], columns: &Columns) -> impl Iterator<Item = csv::Result<Row>> {
    let names = csv::ByteRecord::from(columns.names());
    // Fields are found by their place where that will do, which is faster.
    let by_name = (!columns.are_the_first()).then_some(names);
    let mut reader = csv::Reader::from_reader(lines);
    let mut record = csv::ByteRecord::new();
    iter::from_fn(move || match reader.read_byte_record(&mut record) {
        Ok(true) => Some(record.deserialize(by_name.as_ref())),
        Ok(false) => None,
        Err(error) => Some(Err(error)),
    })
}

/// What is wrong with a row, by the name of the column.
fn explain(error: &csv::Error, columns: &Columns) -> String {
    match error.kind() {
        csv::ErrorKind::Deserialize { err, .. } => {
            let column = err.field().and_then(|field| columns.names().get(field as usize));
            format!("column {}: {}", column.unwrap_or(&"?"), err.kind())
        }
        csv::ErrorKind::UnequalLengths { len, .. } => {
            format!("expected {} numbers, found {len}", columns.names().len())
        }
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use proptest::prelude::*;

    use super::*;

    fn line(row: &Row) -> Vec<u8> {
        Columns::all().line(row).unwrap().into_bytes()
    }

    /// A file with these rows, then `tail`.
    fn file(rows: &[Row], tail: &[u8]) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics.csv");
        let mut bytes = header_line().into_bytes();
        rows.iter().for_each(|row| bytes.extend(line(row)));
        bytes.extend_from_slice(tail);
        fs::write(&path, bytes).unwrap();
        (folder, path)
    }

    fn row((counts, v): ([u64; 4], [f64; 15])) -> Row {
        // What a f64 can count.
        let count = |i: usize| (counts[i] >> 11) as f64;
        Row {
            update: counts[0],
            control_steps: counts[1],
            reward: v[0],
            intrinsic_nats: v[1],
            intrinsic_nats_corrected: v[2],
            intrinsic: v[3],
            advance_m: v[4],
            extrinsic: v[5],
            penalty: v[6],
            xi: v[7],
            net_displacement_m: v[8],
            heading_change_rad: v[9],
            penalised_contacts: count(2),
            clipped_readings: count(3),
            parameter_norm: v[10],
            gradient_norm: v[11],
            task: v[12],
            output_entropy_nats: v[13],
            gradient_error: v[14],
        }
    }

    fn any_rows() -> impl Strategy<Value = Vec<Row>> {
        proptest::collection::vec((any::<[u64; 4]>(), any::<[f64; 15]>()).prop_map(row), 0..12)
    }

    #[test]
    fn numbers_have_as_few_digits_as_will_do() {
        let row =
            Row { update: 3, control_steps: 300, reward: 0.1, penalty: 1e-4, ..Row::default() };
        let text = Columns::all().line(&row).unwrap();
        assert_eq!(
            text,
            "3,300,0.1,0.0,0.0,0.0,0.0,0.0,0.0001,0.0,0.0,0.0,0,0,0.0,0.0,0.0,0.0,0.0\n"
        );
        let extremes = [f64::MIN_POSITIVE, -f64::MAX, f64::NAN, f64::NEG_INFINITY];
        let longest = line(&row_of(extremes));
        assert!(longest.len() as u64 <= TAIL / 2, "{} bytes", longest.len());
    }

    fn row_of([a, b, c, d]: [f64; 4]) -> Row {
        row(([u64::MAX; 4], [a, b, c, d, a, b, a, b, a, b, a, b, a, b, a]))
    }

    #[test]
    fn before_the_first_row_there_is_none() {
        let (folder, path) = file(&[], b"");
        assert_eq!(read_last(&path).unwrap(), None);
        assert_eq!(read_all(&path).unwrap(), []);
        let nowhere = folder.path().join("nowhere");
        assert_eq!(read_last(&nowhere).unwrap(), None);
        assert_eq!(read_all(&nowhere).unwrap(), []);
        for n in 0..header_line().len() {
            fs::write(&path, &header_line()[..n]).unwrap();
            assert_eq!(read_last(&path).unwrap(), None);
            assert_eq!(read_all(&path).unwrap(), []);
        }
    }

    #[test]
    fn mistakes_are_named_by_line_and_column() {
        let rows = [Row::default(); 2];
        let (_folder, path) = file(&rows, b"3,300,0.1,zero,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0\n");
        let all = read_all(&path).unwrap_err().to_string();
        assert!(
            all.ends_with(": damaged: line 4: column R_MI_nats: invalid float literal"),
            "{all}"
        );
        let last = read_last(&path).unwrap_err().to_string();
        assert!(last.ends_with(": last row: column R_MI_nats: invalid float literal"), "{last}");

        let (_folder, path) = file(&rows, b"3,300,0.1\n");
        let all = read_all(&path).unwrap_err().to_string();
        assert!(all.ends_with(": damaged: line 4: expected 19 numbers, found 3"), "{all}");

        let (_folder, path) = file(&rows, b"");
        let other = fs::read_to_string(&path).unwrap().replace("penalty", "Penalty");
        fs::write(&path, other).unwrap();
        for error in [read_all(&path).unwrap_err(), read_last(&path).unwrap_err()] {
            let error = error.to_string();
            assert!(error.contains("line 1: expected the columns update,control"), "{error}");
            assert!(
                error.contains(",gradient_norm, then any of task,output_entropy_nats,"),
                "{error}"
            );
        }
    }

    /// The first version's files end with the norm of the gradient.
    #[test]
    fn a_file_that_was_begun_without_a_column_has_none_of_its_values() {
        let (_folder, path) = file(&[], b"");
        let header = header_line();
        let old = header.strip_suffix(",task,output_entropy_nats,gradient_error\n").unwrap();
        let rows =
            "1,10,0.5,0,0,0,0.25,0,0,1,0,0,0,0,7.5,0.125\n2,20,0,0,0,0,0,0,0,1,0,0,0,0,8,0\n";
        fs::write(&path, format!("{old}\n{rows}")).unwrap();
        let [first, second] = read_all(&path).unwrap()[..] else { panic!() };
        assert_eq!((first.reward, first.advance_m, first.gradient_norm), (0.5, 0.25, 0.125));
        assert_eq!((second.update, second.parameter_norm), (2, 8.0));
        assert!(
            [first, second, read_last(&path).unwrap().unwrap()].iter().all(|it| it.task.is_nan())
        );
        // And a row has no more values than the first line has names.
        for (row, found) in [("3,30,0,0,0,0,0,0,0,1,0,0,0,0,8,0,1\n", 17), ("3,30\n", 2)] {
            fs::write(&path, format!("{old}\n{rows}{row}")).unwrap();
            let what = format!("expected 16 numbers, found {found}");
            let [all, last] = [read_all(&path).map(drop), read_last(&path).map(drop)];
            let (all, last) = (all.unwrap_err().to_string(), last.unwrap_err().to_string());
            assert!(all.ends_with(&format!("line 4: {what}")), "{all}");
            assert!(last.ends_with(&format!("last row: {what}")), "{last}");
        }
    }

    proptest! {
        #[test]
        fn what_was_written_is_read(rows in any_rows(), cut: prop::sample::Index) {
            // The last line is just being written.
            let next = line(&row_of([0.5, -1e300, 3.0, 7.0]));
            let (_folder, path) = file(&rows, &next[..cut.index(next.len())]);
            prop_assert_eq!(&read_all(&path).unwrap(), &rows);
            prop_assert_eq!(read_last(&path).unwrap(), rows.last().copied());
        }

        #[test]
        fn other_bytes_are_read_or_refused_but_nothing_worse(bytes: Vec<u8>) {
            let (_folder, path) = file(&[Row::default()], &bytes);
            let _ = read_all(&path);
            let _ = read_last(&path);
            fs::write(&path, &bytes).unwrap();
            let _ = read_all(&path);
            let _ = read_last(&path);
        }
    }
}
