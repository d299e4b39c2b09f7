//! The files of a survey: arrays in NumPy's format, version 1.0, `<f8`, of three dimensions.
//!
//! A file is known by what it depends on: its folder's name is the number of what was rolled out, its own
//! has the seed. So whatever is there needn't be made again, whoever asked for it, and nothing is ever
//! mixed up.

use std::path::Path;

use anyhow::{Context, ensure};
use runs::atomic;

/// Writes an array, row by row.
///
/// # Errors
/// Of the file system.
pub(super) fn write(
    path: &Path,
    shape: [usize; 3],
    values: impl Iterator<Item = f64>,
) -> anyhow::Result<()> {
    let mut bytes = header(shape);
    bytes.extend(values.flat_map(f64::to_le_bytes));
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: making it", folder.display()))?;
    }
    Ok(atomic::write(path, &bytes)?)
}

/// Reads an array of this shape; none if there's no file.
///
/// # Errors
/// A file of another shape, or cut off.
pub(super) fn read(path: &Path, shape: [usize; 3]) -> anyhow::Result<Option<Vec<f64>>> {
    let Some(bytes) = atomic::read(path)? else { return Ok(None) };
    let header = header(shape);
    let size = header.len() + shape.iter().product::<usize>() * size_of::<f64>();
    ensure!(
        bytes.len() == size && bytes.starts_with(&header),
        "{}: expected {shape:?} numbers in NumPy's format, {size} bytes, got {} bytes; if it's damaged, \
         remove it, and it's made again",
        path.display(),
        bytes.len()
    );
    let (values, _) = bytes[header.len()..].as_chunks();
    Ok(Some(values.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()))
}

/// What such a file begins with: as long as a multiple of 64 bytes.
fn header([a, b, c]: [usize; 3]) -> Vec<u8> {
    const BEFORE: usize = 10;
    let mut about =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({a}, {b}, {c}), }}");
    let length = (BEFORE + about.len() + 1).next_multiple_of(64) - BEFORE;
    while about.len() + 1 < length {
        about.push(' ');
    }
    about.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(about.as_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ab").join("7-64.npy");
        assert_eq!(read(&path, [2, 3, 2]).unwrap(), None);
        let values = (0..12).map(|i| f64::from(i) / 7.0);
        write(&path, [2, 3, 2], values.clone()).unwrap();
        assert_eq!(read(&path, [2, 3, 2]).unwrap(), Some(values.collect()));
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(bytes.len(), 128 + 12 * 8);
        assert_eq!(&bytes[..10], b"\x93NUMPY\x01\x00\x76\x00");
        assert_eq!(bytes[127], b'\n');

        for shape in [[2, 3, 3], [3, 2, 2], [1, 3, 2]] {
            let error = read(&path, shape).unwrap_err().to_string();
            assert!(error.contains("7-64.npy: expected ["), "{error}");
        }
        std::fs::write(&path, &bytes[..200]).unwrap();
        let error = read(&path, [2, 3, 2]).unwrap_err().to_string();
        assert!(error.contains("224 bytes, got 200 bytes; if it's damaged, remove it"), "{error}");
    }
}
