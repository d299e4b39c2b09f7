//! `metrics.csv`: how learning goes, one row an update.
//!
//! The first line has the columns' names. A number is written with as few digits as give the same
//! f64 again.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom},
    path::Path,
};

use serde::{Deserialize, Serialize};

use super::{Error, atomic, error::At};

/// Longer than two rows: each has 12 numbers of up to 24 characters and 4 counts of up to 20.
const TAIL: u64 = 1024;

/// One update. Unless it says otherwise, a value is the mean over the update's control steps.
///
/// The fields' order is the columns' order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Number of the update, from 1.
    pub update: u64,
    /// Control steps done by its end.
    pub control_steps: u64,
    /// R: the reward that is optimised, with everything in it.
    #[serde(rename = "R")]
    pub reward: f64,
    /// R_MI as it is, nats for each variable.
    #[serde(rename = "R_MI_nats")]
    pub information_nats: f64,
    /// R_MI with the Miller-Madow correction of its bias, nats for each variable.
    #[serde(rename = "R_MI_miller_madow_nats")]
    pub information_miller_madow_nats: f64,
    /// R_MI as scaled for the mix.
    #[serde(rename = "R_MI")]
    pub information: f64,
    /// R_Loc, metres along the heading for each control step.
    #[serde(rename = "R_Loc")]
    pub locomotion_m: f64,
    /// The extrinsic reward as scaled for the mix.
    pub extrinsic: f64,
    /// What was subtracted for touching parts.
    pub penalty: f64,
    /// The share of the extrinsic reward in the mix, 0 to 1.
    pub xi: f64,
    /// Metres in the XY plane from where the update began to where it ended.
    pub net_displacement_m: f64,
    /// How far the heading turned over the update, rad, counter-clockwise.
    pub heading_change_rad: f64,
    /// How often a part that shouldn't touched the ground: control steps times parts, a sum.
    pub penalised_contacts: u64,
    /// How many readings lay outside of their range, a sum.
    pub clipped_readings: u64,
    /// Euclidean norm of the parameters after the update.
    pub parameter_norm: f64,
    /// Euclidean norm of the gradient that the update followed.
    pub gradient_norm: f64,
}

/// The columns' names, in their order.
pub const COLUMNS: [&str; 16] = [
    "update",
    "control_steps",
    "R",
    "R_MI_nats",
    "R_MI_miller_madow_nats",
    "R_MI",
    "R_Loc",
    "extrinsic",
    "penalty",
    "xi",
    "net_displacement_m",
    "heading_change_rad",
    "penalised_contacts",
    "clipped_readings",
    "parameter_norm",
    "gradient_norm",
];

/// The first line, with its line break.
#[must_use]
pub fn header_line() -> String {
    COLUMNS.join(",") + "\n"
}

impl Row {
    /// The row's line, with its line break.
    pub(crate) fn line(&self) -> io::Result<Vec<u8>> {
        let mut line = Vec::new();
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(&mut line);
        writer.serialize(self)?;
        writer.flush()?;
        drop(writer);
        Ok(line)
    }
}

/// The newest row; none if there's none yet, or no such file. Only the file's ends are read, and a
/// last line without a line break, which is just being written, isn't looked at.
///
/// # Errors
/// [`Error::Damaged`] if the first line or the newest row isn't what was written.
pub fn read_last(path: &Path) -> Result<Option<Row>, Error> {
    let mut file = match File::open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        opened => opened.at(path, "opening")?,
    };
    let header = header_line();
    let first = read_part(&mut file, 0, header.len() as u64).at(path, "reading")?;
    if !first.ends_with(b"\n") && header.as_bytes().starts_with(&first) {
        return Ok(None);
    }
    check_header(path, &first)?;

    let length = file.metadata().at(path, "asking for its length")?.len();
    let begin = length.saturating_sub(TAIL).max(header.len() as u64);
    let tail = read_part(&mut file, begin, TAIL).at(path, "reading")?;
    let whole = whole_lines(&tail);
    let Some(rest) = whole.strip_suffix(b"\n") else { return Ok(None) };
    let line = rest.rsplit(|&byte| byte == b'\n').next().unwrap_or_default();
    match rows(line).next() {
        Some(Ok(row)) => Ok(Some(row)),
        Some(Err(error)) => Err(Error::damaged(path, format!("last row: {}", explain(&error)))),
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
    check_header(path, whole)?;
    // Lines are counted here: a reader of CSV doesn't count the first one, which it isn't shown.
    rows(&whole[header_line().len()..])
        .map(|row| {
            row.map_err(|error| {
                let line = error.position().map_or(0, csv::Position::line) + 1;
                Error::damaged(path, format!("line {line}: {}", explain(&error)))
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

fn check_header(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    if bytes.starts_with(header_line().as_bytes()) {
        return Ok(());
    }
    let what = format!("line 1: expected the columns {}", COLUMNS.join(","));
    Err(Error::damaged(path, what))
}

fn rows(lines: &[u8]) -> impl Iterator<Item = csv::Result<Row>> {
    csv::ReaderBuilder::new().has_headers(false).from_reader(lines).into_deserialize()
}

/// What is wrong with a row, by the name of the column.
fn explain(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Deserialize { err, .. } => {
            let column = err.field().and_then(|field| COLUMNS.get(field as usize));
            format!("column {}: {}", column.unwrap_or(&"?"), err.kind())
        }
        csv::ErrorKind::UnequalLengths { len, .. } => {
            format!("expected {} numbers, found {len}", COLUMNS.len())
        }
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use proptest::prelude::*;

    use super::*;

    /// A file with these rows, then `tail`.
    fn file(rows: &[Row], tail: &[u8]) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics.csv");
        let mut bytes = header_line().into_bytes();
        rows.iter().for_each(|row| bytes.extend(row.line().unwrap()));
        bytes.extend_from_slice(tail);
        fs::write(&path, bytes).unwrap();
        (folder, path)
    }

    fn row((counts, v): ([u64; 4], [f64; 12])) -> Row {
        Row {
            update: counts[0],
            control_steps: counts[1],
            reward: v[0],
            information_nats: v[1],
            information_miller_madow_nats: v[2],
            information: v[3],
            locomotion_m: v[4],
            extrinsic: v[5],
            penalty: v[6],
            xi: v[7],
            net_displacement_m: v[8],
            heading_change_rad: v[9],
            penalised_contacts: counts[2],
            clipped_readings: counts[3],
            parameter_norm: v[10],
            gradient_norm: v[11],
        }
    }

    fn any_rows() -> impl Strategy<Value = Vec<Row>> {
        proptest::collection::vec((any::<[u64; 4]>(), any::<[f64; 12]>()).prop_map(row), 0..12)
    }

    #[test]
    fn the_columns_are_the_fields() {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.serialize(Row::default()).unwrap();
        let text = String::from_utf8(writer.into_inner().unwrap()).unwrap();
        assert_eq!(text.lines().next().unwrap(), header_line().trim_end());
    }

    #[test]
    fn numbers_have_as_few_digits_as_will_do() {
        let row =
            Row { update: 3, control_steps: 300, reward: 0.1, penalty: 1e-4, ..Row::default() };
        let line = String::from_utf8(row.line().unwrap()).unwrap();
        assert_eq!(line, "3,300,0.1,0.0,0.0,0.0,0.0,0.0,0.0001,0.0,0.0,0.0,0,0,0.0,0.0\n");
        let extremes = [f64::MIN_POSITIVE, -f64::MAX, f64::NAN, f64::NEG_INFINITY];
        let longest = row_of(extremes).line().unwrap();
        assert!(longest.len() as u64 <= TAIL / 2, "{} bytes", longest.len());
    }

    fn row_of([a, b, c, d]: [f64; 4]) -> Row {
        row(([u64::MAX; 4], [a, b, c, d, a, b, a, b, a, b, a, b]))
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
        let (_folder, path) = file(&rows, b"3,300,0.1,zero,0,0,0,0,0,0,0,0,0,0,0,0\n");
        let all = read_all(&path).unwrap_err().to_string();
        assert!(
            all.ends_with(": damaged: line 4: column R_MI_nats: invalid float literal"),
            "{all}"
        );
        let last = read_last(&path).unwrap_err().to_string();
        assert!(last.ends_with(": last row: column R_MI_nats: invalid float literal"), "{last}");

        let (_folder, path) = file(&rows, b"3,300,0.1\n");
        let all = read_all(&path).unwrap_err().to_string();
        assert!(all.ends_with(": damaged: line 4: expected 16 numbers, found 3"), "{all}");

        let (_folder, path) = file(&rows, b"");
        let other = fs::read_to_string(&path).unwrap().replace("penalty", "Penalty");
        fs::write(&path, other).unwrap();
        for error in [read_all(&path).unwrap_err(), read_last(&path).unwrap_err()] {
            assert!(error.to_string().contains("line 1: expected the columns update,control"));
        }
    }

    proptest! {
        #[test]
        fn what_was_written_is_read(rows in any_rows(), cut: prop::sample::Index) {
            // The last line is just being written.
            let next = row_of([0.5, -1e300, 3.0, 7.0]).line().unwrap();
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
