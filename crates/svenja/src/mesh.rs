//! Points of mesh files: STL, binary (80 bytes, a count, then 50 bytes a triangle) and as text
//! (`vertex X Y Z`), and OBJ (`v X Y Z`). Told apart by the file's name; only points are read.

use std::{fs::File, io::Read, path::Path};

use config::shown;
use nalgebra::Point3;

use crate::Hull;

/// Bytes: more than a million triangles.
const LARGEST_FILE: u64 = 64 << 20;

/// The farthest that a point may be, in the file's unit.
const FARTHEST: f64 = 1e9;

/// The corners of the hull around a mesh file's points, in the file's unit.
///
/// # Errors
/// What is wrong with it, to be put behind its name: `: ...`, or with a line of a text, `:3: ...`.
pub(crate) fn corners(path: &Path) -> Result<Vec<Point3<f64>>, String> {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    let points_of = match ending.to_str() {
        Some("stl") => stl,
        Some("obj") => obj,
        _ => return Err(": a name that ends in .stl or .obj expected".into()),
    };
    let bytes = read(path).map_err(|error| format!(": can't be read: {error}"))?;
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(": at most 64 MiB expected, got more".into());
    }
    let points = points_of(&bytes)?;
    if let Some(bad) = points.iter().find(|it| !it.coords.iter().all(|it| it.abs() <= FARTHEST)) {
        let [x, y, z] = bad.coords.into();
        return Err(format!(": numbers from -1e9 to 1e9 expected, got {x} {y} {z}"));
    }
    match Hull::around(&points) {
        Some(hull) => Ok(hull.points_m().to_vec()),
        None => {
            let n = points.len();
            Err(format!(": points that span a volume expected, got {n} that don't"))
        }
    }
}

/// Never more than one byte beyond the limit, whatever the file is.
fn read(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(LARGEST_FILE + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// A binary file may begin with `solid`, too: it's one if it's as long as its count says.
fn stl(bytes: &[u8]) -> Result<Vec<Point3<f64>>, String> {
    const HEAD: usize = 84;
    const TRIANGLE: usize = 50;
    let count =
        bytes.get(80..HEAD).and_then(|it| it.first_chunk()).copied().map(u32::from_le_bytes);
    let expected = count.map(|count| HEAD as u64 + TRIANGLE as u64 * u64::from(count));
    if expected != Some(bytes.len() as u64) {
        if bytes.trim_ascii_start().starts_with(b"solid") {
            return text(bytes, "vertex");
        }
        let expected = expected.map_or(HEAD as u64, |expected| expected);
        return Err(format!(
            ": an STL file expected, that begins with \"solid\" or is as long as its count of \
             triangles says, {expected} bytes, got {}",
            bytes.len()
        ));
    }
    let number =
        |bytes: &[u8]| bytes.first_chunk().map_or(f64::NAN, |it| f32::from_le_bytes(*it).into());
    let corner =
        |bytes: &[u8]| Point3::new(number(bytes), number(&bytes[4..]), number(&bytes[8..]));
    let triangles = bytes[HEAD..].chunks_exact(TRIANGLE);
    // After the normal.
    Ok(triangles.flat_map(|it| [12, 24, 36].map(|at| corner(&it[at..]))).collect())
}

fn obj(bytes: &[u8]) -> Result<Vec<Point3<f64>>, String> {
    text(bytes, "v")
}

/// The lines that begin with a word and have three numbers behind it.
fn text(bytes: &[u8], word: &str) -> Result<Vec<Point3<f64>>, String> {
    let mut points = Vec::new();
    for (i, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let line = String::from_utf8_lossy(line);
        let mut words = line.split_ascii_whitespace();
        if words.next() != Some(word) {
            continue;
        }
        let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).take(3).collect();
        let &[x, y, z] = &numbers[..] else {
            let line = shown(line.trim());
            return Err(format!(":{}: \"{word}\" and three numbers expected, got `{line}`", i + 1));
        };
        points.push(Point3::new(x, y, z));
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const TETRAHEDRON: [[f32; 3]; 4] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.25, 0.25, 3.0]];

    fn binary() -> Vec<u8> {
        let mut bytes = b"solid by its name alone".to_vec();
        bytes.resize(80, b' ');
        bytes.extend(4_u32.to_le_bytes());
        for left_out in 0..4 {
            let corners = (0..4).filter(|&i| i != left_out).map(|i| TETRAHEDRON[i]);
            let numbers = [[0.0; 3]].into_iter().chain(corners).flatten();
            bytes.extend(numbers.flat_map(f32::to_le_bytes));
            bytes.extend([0; 2]);
        }
        bytes
    }

    fn read_as(name: &str, bytes: &[u8]) -> Result<Vec<Point3<f64>>, String> {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        corners(&path).map_err(|what| format!("{name}{what}"))
    }

    #[test]
    fn the_same_points_in_all_forms() {
        let expected: Vec<Point3<f64>> =
            [0, 2, 3, 1].map(|i| Point3::from(TETRAHEDRON[i].map(f64::from))).to_vec();
        assert_eq!(read_as("a.stl", &binary()), Ok(expected.clone()));
        let lines = |word: &str| {
            let line = |[x, y, z]: [f32; 3]| format!("  {word} {x} {y:e} {z}\r\n");
            TETRAHEDRON.map(line).concat()
        };
        let ascii =
            format!("solid x\nfacet normal 0 0 1\nouter loop\n{}endloop\n", lines("vertex"));
        assert_eq!(read_as("a.STL", ascii.as_bytes()), Ok(expected.clone()));
        let obj = format!("# v 1\nvn 0 0 1\nvt 0 0\n{}f 1 2 3\nf 1//1 2//2 4//4\n", lines("v"));
        assert_eq!(read_as("a.obj", obj.as_bytes()), Ok(expected));
    }

    #[test]
    fn what_is_no_mesh_is_said() {
        let refused = |name: &str, bytes: &[u8], expected: &str| {
            assert_eq!(read_as(name, bytes).unwrap_err(), expected);
        };
        let binary = binary();
        let form = "an STL file expected, that begins with \"solid\" or is as long as its count of \
                    triangles says";
        refused("a.stl", b"", &format!("a.stl: {form}, 84 bytes, got 0"));
        refused(
            "a.stl",
            &[b"-", &binary[1..283]].concat(),
            &format!("a.stl: {form}, 284 bytes, got 283"),
        );
        refused("a.dae", &binary, "a.dae: a name that ends in .stl or .obj expected");
        refused(
            "a.stl",
            b"solid\nvertex 1 2 3\nvertex 1 2\n",
            "a.stl:3: \"vertex\" and three numbers expected, got `vertex 1 2`",
        );
        refused("a.obj", b"v 1 2 nan", "a.obj: numbers from -1e9 to 1e9 expected, got 1 2 NaN");
        let flat = "points that span a volume expected, got";
        refused("a.obj", b"v 1 2 3\n\xff\xfe", &format!("a.obj: {flat} 1 that don't"));
        refused("a.obj", b"", &format!("a.obj: {flat} 0 that don't"));
        let missing = corners(Path::new("/nowhere/a.stl")).unwrap_err();
        assert_eq!(missing, ": can't be read: No such file or directory (os error 2)");
    }
}
