//! Convex hulls: of all points of a mesh the corners that span it, with the triangles between them.
//!
//! Quickhull (Barber, Dobkin, Huhdanpaa, 1996), with the point first that lies farthest outside, so
//! that it can end early: with [`MOST_POINTS`] corners the hull has what matters most. Sums over
//! the tetrahedra from one point to all triangles give volume, centre and inertia:
//!
//! ```text
//! v = a · (b × c) / 6      centre: v (a + b + c) / 4
//! second moments: v/20 (a a^T + b b^T + c c^T + s s^T), s = a + b + c
//! ```
//!
//! The same points in any order give the same hull, and the corners of a hull give that hull again.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::rotation::Mirror;

/// Corners that a hull has at most. Bullet asks all of them several times a contact.
pub const MOST_POINTS: usize = 64;

/// What lies outside by less than this share of the size is taken to be on the surface.
const FLAT: f64 = 1e-6;

/// A hull is thicker than this share of its length, or it's flat: single precision can't tell.
const THINNEST: f64 = 1e-4;

/// A convex body between corners.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    points_m: Vec<Point3<f64>>,
    triangles: Vec<[usize; 3]>,
}

impl Hull {
    /// Around points, with at most [`MOST_POINTS`] of them as corners; None if they don't span a
    /// volume, or one isn't finite.
    #[must_use]
    pub fn around(points: &[Point3<f64>]) -> Option<Self> {
        if points.iter().any(|point| !point.coords.iter().all(|it| it.is_finite())) {
            return None;
        }
        let mut points_m = points.to_vec();
        loop {
            points_m.sort_by(|a, b| {
                let by = |i: usize| a[i].total_cmp(&b[i]);
                by(0).then(by(1)).then(by(2))
            });
            points_m.dedup();
            let triangles = Growing::hull(&points_m)?;
            let mut is_corner = vec![false; points_m.len()];
            triangles.iter().flatten().for_each(|&corner| is_corner[corner] = true);
            if is_corner.iter().all(|&is| is) {
                return Some(Self { points_m, triangles });
            }
            // Again among the corners alone: what began as one may have been left inside.
            let mut is_corner = is_corner.into_iter();
            points_m.retain(|_| is_corner.next().unwrap_or(false));
        }
    }

    /// The corners, in m.
    #[must_use]
    pub fn points_m(&self) -> &[Point3<f64>] {
        &self.points_m
    }

    /// The corners of each triangle of the surface, anticlockwise from outside: indices of points.
    #[must_use]
    pub fn triangles(&self) -> &[[usize; 3]] {
        &self.triangles
    }

    /// The corners of each triangle, in m.
    pub fn facets_m(&self) -> impl Iterator<Item = [Point3<f64>; 3]> {
        self.triangles.iter().map(|corners| corners.map(|corner| self.points_m[corner]))
    }

    pub(crate) fn image(&self, mirror: Mirror) -> Self {
        Self {
            points_m: self.points_m.iter().map(|point| mirror.point(point)).collect(),
            triangles: self.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(),
        }
    }

    /// Volume in m³; centre in m from the first corner; second moments there, in m⁵.
    fn sums(&self) -> (f64, Vector3<f64>, Matrix3<f64>) {
        let origin = self.points_m[0];
        let (mut volume, mut moment, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for facet in self.facets_m() {
            let [a, b, c] = facet.map(|corner| corner - origin);
            let v = a.dot(&b.cross(&c)) / 6.0;
            let s = a + b + c;
            volume += v;
            moment += s * (v / 4.0);
            let squares = [a, b, c, s].map(|it| it * it.transpose());
            second += squares.into_iter().sum::<Matrix3<f64>>() * (v / 20.0);
        }
        (volume, moment / volume, second)
    }

    pub(crate) fn volume_m3(&self) -> f64 {
        self.sums().0
    }

    /// Its centre of mass, filled evenly, in m.
    #[must_use]
    pub fn centre_m(&self) -> Point3<f64> {
        self.points_m[0] + self.sums().1
    }

    /// About the centre, in kg m², of a mass in kg that fills it evenly.
    pub(crate) fn inertia_kg_m2(&self, mass_kg: f64) -> Matrix3<f64> {
        let (volume, centre, second) = self.sums();
        let second = second / volume - centre * centre.transpose();
        (Matrix3::from_diagonal_element(second.trace()) - second) * mass_kg
    }
}

/// A triangle of a hull that isn't done, with the points outside of it.
struct Facet {
    corners: [usize; 3],
    /// Outwards, of length 1.
    normal: Vector3<f64>,
    /// Each with how far out it is.
    outside: Vec<(usize, f64)>,
}

struct Growing<'a> {
    points: &'a [Point3<f64>],
    facets: Vec<Facet>,
    flat: f64,
}

impl<'a> Growing<'a> {
    /// The triangles around points, all of which differ.
    fn hull(points: &'a [Point3<f64>]) -> Option<Vec<[usize; 3]>> {
        let [a, b, c, d] = first_four(points)?;
        let flat = FLAT * (points[b] - points[a]).norm();
        let mut hull = Self { points, facets: Vec::new(), flat };
        let all: Vec<_> = (0..points.len()).collect();
        let up =
            (points[b] - points[a]).cross(&(points[c] - points[a])).dot(&(points[d] - points[a]));
        let [b, c] = if up < 0.0 { [b, c] } else { [c, b] };
        let facets = [[a, b, c], [a, c, d], [c, b, d], [b, a, d]];
        hull.add(&facets, &all);
        let mut n_corners = 4;
        while n_corners < MOST_POINTS
            && let Some(corner) = hull.farthest()
        {
            hull.grow(corner);
            n_corners += 1;
        }
        Some(hull.facets.into_iter().map(|facet| facet.corners).collect())
    }

    fn height(&self, facet: &Facet, point: usize) -> f64 {
        facet.normal.dot(&(self.points[point] - self.points[facet.corners[0]]))
    }

    /// The point that lies farthest outside of its facet.
    fn farthest(&self) -> Option<usize> {
        let outside = self.facets.iter().flat_map(|facet| &facet.outside);
        let first = |best: Option<(usize, f64)>, &(point, height): &(usize, f64)| match best {
            Some((_, highest)) if height <= highest => best,
            _ => Some((point, height)),
        };
        outside.fold(None, first).map(|(point, _)| point)
    }

    /// Adds facets, and gives each point to the first of them that it's outside of.
    fn add(&mut self, corners: &[[usize; 3]], points: &[usize]) {
        let begin = self.facets.len();
        for &[a, b, c] in corners {
            let [p, q, r] = [a, b, c].map(|corner| self.points[corner]);
            let normal = (q - p).cross(&(r - p)).normalize();
            self.facets.push(Facet { corners: [a, b, c], normal, outside: Vec::new() });
        }
        for &point in points {
            for i in begin..self.facets.len() {
                let height = self.height(&self.facets[i], point);
                if height > self.flat {
                    self.facets[i].outside.push((point, height));
                    break;
                }
            }
        }
    }

    /// Replaces the facets that a point sees by those from it to their edge.
    fn grow(&mut self, point: usize) {
        let (mut seen, mut kept) = (Vec::new(), Vec::new());
        for facet in std::mem::take(&mut self.facets) {
            let sees = self.height(&facet, point) > self.flat;
            if sees { seen.push(facet) } else { kept.push(facet) }
        }
        self.facets = kept;
        let sides = |[a, b, c]: [usize; 3]| [[a, b], [b, c], [c, a]];
        let all: Vec<_> = seen.iter().flat_map(|facet| sides(facet.corners)).collect();
        let edge = all.iter().filter(|[a, b]| !all.contains(&[*b, *a]));
        let new: Vec<_> = edge.map(|&[a, b]| [a, b, point]).collect();
        let free: Vec<_> =
            seen.iter().flat_map(|facet| &facet.outside).map(|&(other, _)| other).collect();
        self.add(&new, &free);
    }
}

/// The first point, the one farthest from it, from their line, and from their plane; the first of
/// several. None if all are in a plane.
fn first_four(points: &[Point3<f64>]) -> Option<[usize; 4]> {
    let origin = *points.first()?;
    let farthest = |distance: &dyn Fn(Vector3<f64>) -> f64| {
        let mut best = (0, 0.0);
        for (i, point) in points.iter().enumerate() {
            let distance = distance(point - origin);
            if distance > best.1 {
                best = (i, distance);
            }
        }
        best
    };
    let (b, length) = farthest(&|p| p.norm());
    let along = (points[b] - origin) / length;
    let (c, width) = farthest(&|p| along.cross(&p).norm());
    if width.is_nan() || width < THINNEST * length {
        return None;
    }
    let normal = along.cross(&(points[c] - origin)) / width;
    let (d, thickness) = farthest(&|p| normal.dot(&p).abs());
    (length > 0.0 && thickness >= THINNEST * length).then_some([0, b, c, d])
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    fn corners_of_a_cube() -> Vec<Point3<f64>> {
        let side = |i: usize, bit: usize| f64::from(u8::from(i >> bit & 1 == 1));
        (0..8).map(|i| Point3::new(side(i, 0), side(i, 1), side(i, 2))).collect()
    }

    /// Each edge is one of two triangles, once in each direction; as many corners as Euler says.
    fn check(hull: &Hull) {
        let sides = hull.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let sides: Vec<_> = sides.collect();
        let all: BTreeSet<_> = sides.iter().copied().collect();
        assert_eq!(all.len(), sides.len(), "an edge twice: {hull:?}");
        assert!(sides.iter().all(|&[a, b]| all.contains(&[b, a])), "open: {hull:?}");
        assert_eq!(hull.triangles.len(), 2 * hull.points_m.len() - 4, "{hull:?}");
        assert!(hull.volume_m3() > 0.0 && hull.points_m.len() <= MOST_POINTS);
    }

    fn deepest_outside(hull: &Hull, points: &[Point3<f64>]) -> f64 {
        let out = |point: &Point3<f64>| {
            let height =
                |[a, b, c]: [Point3<f64>; 3]| (b - a).cross(&(c - a)).normalize().dot(&(point - a));
            hull.facets_m().map(height).fold(f64::NEG_INFINITY, f64::max)
        };
        points.iter().map(out).fold(f64::NEG_INFINITY, f64::max)
    }

    #[test]
    fn a_cube_has_eight_corners_and_the_inertia_of_a_cube() {
        let mut points = corners_of_a_cube();
        // Within, on an edge, on a side, and some twice.
        points.extend([[0.5, 0.5, 0.5], [0.5, 0.0, 0.0], [0.5, 0.5, 1.0]].map(Point3::from));
        points.extend(corners_of_a_cube());
        let hull = Hull::around(&points).unwrap();
        check(&hull);
        assert_eq!(hull.points_m.len(), 8);
        assert!((hull.volume_m3() - 1.0).abs() < 1e-14);
        assert!((hull.centre_m() - Point3::new(0.5, 0.5, 0.5)).norm() < 1e-14);
        let expected = Matrix3::from_diagonal_element(2.0 / 6.0);
        assert!((hull.inertia_kg_m2(2.0) - expected).norm() < 1e-14, "{}", hull.inertia_kg_m2(2.0));
    }

    #[test]
    fn of_many_points_those_are_kept_that_matter() {
        let n = 2000;
        let point = |i: usize| {
            // Vogel's spiral on a ball.
            let z = 1.0 - (2 * i + 1) as f64 / n as f64;
            let (r, turn) = ((1.0 - z * z).sqrt(), 2.399_963_229_728_653 * i as f64);
            Point3::new(r * libm::cos(turn), r * libm::sin(turn), z)
        };
        let points: Vec<_> = (0..n).map(point).collect();
        let hull = Hull::around(&points).unwrap();
        check(&hull);
        assert_eq!(hull.points_m.len(), MOST_POINTS);
        // 64 caps of equal area reach 0.25 from their middles, whose sagitta is 0.03.
        let lost = deepest_outside(&hull, &points);
        assert!(lost < 0.08, "{lost}");
        assert_eq!(Hull::around(&hull.points_m).as_ref(), Some(&hull), "a hull is its own");
    }

    #[test]
    fn what_spans_no_volume_is_no_hull() {
        assert_eq!(Hull::around(&[]), None);
        let cube = corners_of_a_cube();
        assert_eq!(Hull::around(&cube[..1]), None);
        assert_eq!(Hull::around(&cube[..4]), None, "a square");
        assert_eq!(Hull::around(&vec![cube[3]; 10]), None);
        let line: Vec<_> = (0..9).map(|i| Point3::new(f64::from(i), 0.0, 1.0)).collect();
        assert_eq!(Hull::around(&line), None);
        let bad = [cube, vec![Point3::new(f64::NAN, 0.0, 0.0)]].concat();
        assert_eq!(Hull::around(&bad), None);
    }

    /// On grids, where many points lie in planes and lines, and in the open.
    #[test]
    fn whatever_the_points_the_hull_is_closed_and_has_them_inside() {
        let coarse = (-3..=3_i32).prop_map(f64::from).boxed();
        let fine = (-1.0..1.0_f64).boxed();
        let single = (-1.0..1.0_f32).prop_map(f64::from).boxed();
        for number in [coarse, fine, single] {
            let point = [number.clone(), number.clone(), number].prop_map(Point3::from);
            proptest!(ProptestConfig::with_cases(300), |(
                points in proptest::collection::vec(point, 4..60), shuffled in any::<u64>()
            )| {
                let Some(hull) = Hull::around(&points) else { return Ok(()) };
                check(&hull);
                let out = deepest_outside(&hull, &points);
                prop_assert!(out < 4.0 * FLAT * 12.0, "{}", out);
                prop_assert_eq!(Hull::around(hull.points_m()), Some(hull.clone()));
                let mut other = points.clone();
                let n = other.len();
                (0..n).for_each(|i| other.swap(i, (shuffled as usize).wrapping_mul(i + 7) % n));
                prop_assert_eq!(Hull::around(&other), Some(hull));
            });
        }
    }
}
