//! Meshes: the corners and triangles of STL and OBJ files, read for their size and their mass.

use std::{
    fs::File,
    io::{self, Read},
    path::Path,
};

use nalgebra::{Matrix3, Point3, Vector3};

use svenja::Hull;

use crate::robot::Inertial;

/// Bytes that a mesh may have.
const LARGEST_MESH: u64 = 64 << 20;

/// A surface.
#[derive(Debug, Default)]
pub(crate) struct Mesh {
    points: Vec<Point3<f64>>,
    /// Of the hull that a model file makes of it.
    pub(crate) corners: Vec<Point3<f64>>,
    triangles: Vec<[usize; 3]>,
}

impl Mesh {
    /// Reads an STL or OBJ file.
    ///
    /// # Errors
    /// Why it can't be used, to be put behind its name.
    pub(crate) fn open(path: &Path) -> Result<Self, String> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        if !["stl", "obj"].contains(&ending.as_str()) {
            return Err(format!("is .{ending}: only STL and OBJ can be read"));
        }
        let bytes = read(path).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => "isn't there".into(),
            _ => format!("can't be read: {error}"),
        })?;
        let mesh = if ending == "obj" { obj(&bytes) } else { stl(&bytes) };
        let mesh = mesh.ok_or_else(|| format!("isn't {}", ending.to_uppercase()))?;
        let fits = mesh.points.iter().all(|p| p.iter().all(|x| x.is_finite() && x.abs() < 1e9));
        let hull = Hull::around(&mesh.points).filter(|_| fits);
        match hull {
            Some(hull) => Ok(Self { corners: hull.points_m().to_vec(), ..mesh }),
            None => Err("has points that span no volume".into()),
        }
    }

    /// What it weighs, filled evenly, at so many kg/m^3: the sum over the pyramids between a point inside
    /// and each triangle. As MuJoCo has it, each counts, whichever way round its triangle is, so that
    /// surfaces with holes and turned faces weigh something, too. `None` of one around nothing.
    pub(crate) fn filled(&self, scale: &Vector3<f64>, density: f64) -> Option<Inertial> {
        let point = |i: usize| self.points[i].coords.component_mul(scale);
        let triangles: Vec<[Vector3<f64>; 3]> =
            self.triangles.iter().map(|corners| corners.map(point)).collect();
        let area = |[a, b, c]: &[Vector3<f64>; 3]| (b - a).cross(&(c - a)).norm() / 2.0;
        let surface: f64 = triangles.iter().map(area).sum();
        let middle = |corners: &[Vector3<f64>; 3]| corners.iter().sum::<Vector3<f64>>() / 3.0;
        let inside: Vector3<f64> =
            triangles.iter().map(|it| middle(it) * (area(it) / surface)).sum();
        let (volume, first, _) = pyramids(&triangles, &inside);
        if volume.is_nan() || volume <= 1e-15 {
            return None;
        }
        let centre = inside + first / volume;
        // From the centre of mass anew, where some pyramids may be others.
        let (volume, _, second) = pyramids(&triangles, &centre);
        let tensor = Matrix3::identity() * second.trace() - second;
        Some(Inertial {
            mass_kg: volume * density,
            centre_m: centre.into(),
            tensor_kg_m2: tensor * density,
        })
    }
}

/// Volume, and first and second moments about the tip that all pyramids have in common.
fn pyramids(
    triangles: &[[Vector3<f64>; 3]],
    tip: &Vector3<f64>,
) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let (mut volume, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
    for corners in triangles {
        let [a, b, c] = corners.map(|corner| corner - tip);
        let v = a.dot(&b.cross(&c)).abs() / 6.0;
        let s = a + b + c;
        volume += v;
        first += s * (v / 4.0);
        let squares = a * a.transpose() + b * b.transpose() + c * c.transpose();
        second += (squares + s * s.transpose()) * (v / 20.0);
    }
    (volume, first, second)
}

fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(LARGEST_MESH + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LARGEST_MESH {
        return Err(io::Error::other(format!("it has more than {} MiB", LARGEST_MESH >> 20)));
    }
    Ok(bytes)
}

/// Binary ones may begin with `solid`, too, so that the length tells.
fn stl(bytes: &[u8]) -> Option<Mesh> {
    let count = bytes.get(80..84).map(|n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]));
    let corners = match count {
        Some(count) if bytes.len() as u64 == 84 + 50 * u64::from(count) => {
            let corner = |n: &[u8]| f64::from(f32::from_le_bytes([n[0], n[1], n[2], n[3]]));
            let facets = bytes[84..].chunks_exact(50);
            facets.flat_map(|facet| facet[12..48].chunks_exact(4).map(corner)).collect()
        }
        _ => {
            let text =
                str::from_utf8(bytes).ok().filter(|it| it.trim_start().starts_with("solid"))?;
            let mut corners = Vec::new();
            for line in text.lines() {
                if let Some(numbers) = line.trim().strip_prefix("vertex") {
                    corners.extend(three(numbers)?);
                }
            }
            corners
        }
    };
    let points: Vec<_> = corners.chunks_exact(3).map(|p| Point3::new(p[0], p[1], p[2])).collect();
    let triangles = (0..points.len() / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Some(Mesh { points, triangles, ..Mesh::default() })
}

fn three(text: &str) -> Option<[f64; 3]> {
    let mut words = text.split_ascii_whitespace().map(|word| word.parse().ok());
    Some([words.next()??, words.next()??, words.next()??])
}

fn obj(bytes: &[u8]) -> Option<Mesh> {
    let text = String::from_utf8_lossy(bytes);
    let mut mesh = Mesh::default();
    for line in text.lines() {
        if let Some(numbers) = line.trim_start().strip_prefix("v ") {
            mesh.points.push(three(numbers)?.into());
        } else if let Some(words) = line.trim_start().strip_prefix("f ") {
            // `f 1/2/3 4//5 -1`: the first number is the point's, from 1, or back from the last one.
            let index = |word: &str| {
                let number: i64 = word.split('/').next()?.parse().ok()?;
                let from = if number < 0 { mesh.points.len() as i64 } else { -1 };
                usize::try_from(number + from).ok().filter(|i| *i < mesh.points.len())
            };
            let face: Vec<_> = words.split_ascii_whitespace().map(index).collect::<Option<_>>()?;
            let fan = face.windows(2).skip(1).map(|pair| [face[0], pair[0], pair[1]]);
            mesh.triangles.extend(fan);
        }
    }
    Some(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of 2 x 4 x 6 with a corner in the origin, as OBJ.
    const BOX: &str = "v 0 0 0\nv 2 0 0\nv 2 4 0\nv 0 4 0\nv 0 0 6\nv 2 0 6\nv 2 4 6\nv 0 4 6\n\
        f 4 3 2 1\nf 5 6 7 8\nf 1/1/1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf -8 -4 -1 -5\n";

    #[test]
    fn a_mesh_weighs_what_it_holds() {
        let mesh = obj(BOX.as_bytes()).unwrap();
        for scale in [Vector3::new(1.0, 1.0, 1.0), Vector3::new(-1.0, 1.0, 1.0)] {
            let filled = mesh.filled(&scale, 0.5).unwrap();
            // A few roundings.
            assert!((filled.mass_kg - 24.0).abs() < 1e-12);
            assert!((filled.centre_m - Point3::new(scale.x, 2.0, 3.0)).norm() < 1e-12);
            let expected = Vector3::new(4.0 + 9.0, 1.0 + 9.0, 1.0 + 4.0) * 8.0;
            assert!((filled.tensor_kg_m2 - Matrix3::from_diagonal(&expected)).amax() < 1e-10);
        }
    }

    #[test]
    fn both_kinds_of_stl_have_the_same_triangles() {
        let text = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
            vertex 0 1 0.5\nendloop\nendfacet\nendsolid";
        let mut binary = vec![0; 80];
        binary.extend(1_u32.to_le_bytes());
        for number in [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.5] {
            binary.extend(f32::to_le_bytes(number));
        }
        binary.extend([0, 0]);
        let (text, binary) = (stl(text.as_bytes()).unwrap(), stl(&binary).unwrap());
        assert_eq!((text.points.len(), &text.points), (3, &binary.points));
        assert_eq!(text.triangles, binary.triangles);
    }

    #[test]
    fn what_is_no_mesh_is_none() {
        for bytes in [&b"v 1 2"[..], b"f 1 2 3", b"v 0 0 0\nf 1 2 9", b"v 0 0 0\nf -2 1 1"] {
            assert!(obj(bytes).is_none(), "{bytes:?}");
        }
        assert!(stl(b"no").is_none() && stl(b"solid\nvertex 1 2 x").is_none());
    }
}
