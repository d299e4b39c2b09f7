//! A slice through a cell's parameters: where its points lie, and by which policy each is acted.

use std::fmt::Write;

use ::landscape::Grid;
use xxhash_rust::xxh3::xxh3_64;

use super::Centre;

/// Some points in a line or a plane.
#[derive(Clone, Debug)]
pub struct Slice {
    /// What it's called in tables: unlike for each slice of a survey.
    pub name: String,
    /// How it was laid.
    pub kind: Kind,
    /// Index of the cell whose world and reward it has.
    pub centre: usize,
    /// Where each point is; a line's second number is 0.
    pub places: Vec<[f64; 2]>,
    way: Way,
    grid: Grid,
}

/// How a slice was laid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A line in a random direction through a policy.
    Direction,
    /// A line from one policy to another.
    Between,
    /// A plane of two random directions through a policy.
    Plane,
    /// The principal plane of a path.
    Path,
}

impl Kind {
    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Direction => "direction",
            Self::Between => "between",
            Self::Plane => "plane",
            Self::Path => "path",
        }
    }
}

/// From places to parameters.
#[derive(Clone, Debug)]
enum Way {
    /// theta = origin + sum over k of place\[k\] directions\[k\]
    Directions { origin: Vec<f64>, directions: Vec<Vec<f64>> },
    /// theta = (1 - place\[0\]) from + place\[0\] to, exactly each at its end.
    Between { from: Vec<f64>, to: Vec<f64> },
}

impl Slice {
    /// A line of `n` points, an odd number, from -span to span of a direction; its middle is the origin
    /// itself.
    #[must_use]
    pub fn line(
        name: String,
        centre: usize,
        origin: &[f64],
        direction: Vec<f64>,
        (n, span): (usize, f64),
    ) -> Self {
        Self {
            name,
            kind: Kind::Direction,
            centre,
            places: (0..n).map(|i| [place(i, n, span), 0.0]).collect(),
            way: Way::Directions { origin: origin.to_vec(), directions: vec![direction] },
            grid: Grid::line(n),
        }
    }

    /// `n` points from one policy to another.
    #[must_use]
    pub fn between(
        name: String,
        centre: usize,
        (from, to): (Vec<f64>, Vec<f64>),
        n: usize,
    ) -> Self {
        Self {
            name,
            kind: Kind::Between,
            centre,
            places: (0..n).map(|i| [i as f64 / (n - 1) as f64, 0.0]).collect(),
            way: Way::Between { from, to },
            grid: Grid::line(n),
        }
    }

    /// `n` x `n` points of a plane, from -span to span of each direction, row by row: the first direction
    /// is that within a row.
    #[must_use]
    pub fn plane(
        (name, kind): (String, Kind),
        centre: usize,
        origin: &[f64],
        directions: [Vec<f64>; 2],
        (n, span): (usize, f64),
    ) -> Self {
        let at = |i| place(i, n, span);
        let rows = (0..n).flat_map(|row| (0..n).map(move |column| [at(column), at(row)]));
        Self {
            name,
            kind,
            centre,
            places: rows.collect(),
            way: Way::Directions { origin: origin.to_vec(), directions: directions.into() },
            grid: Grid::plane(n, n),
        }
    }

    /// How its points lie.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Whether it has two dimensions.
    #[must_use]
    pub fn is_plane(&self) -> bool {
        matches!(self.kind, Kind::Plane | Kind::Path)
    }

    /// Each point's distance from the origin, in units of the directions.
    #[must_use]
    pub fn distances(&self) -> Vec<f64> {
        self.places.iter().map(|[a, b]| (a * a + b * b).sqrt()).collect()
    }

    /// A line's direction through a policy, `[n_parameters]`; none of other slices.
    #[must_use]
    pub fn direction(&self) -> Option<&[f64]> {
        match &self.way {
            Way::Directions { directions, .. } if self.kind == Kind::Direction => {
                directions.first().map(Vec::as_slice)
            }
            _ => None,
        }
    }

    /// The parameters at a point, `[n_parameters]`.
    #[must_use]
    pub fn parameters(&self, point: usize) -> Vec<f64> {
        let place = self.places[point];
        match &self.way {
            Way::Directions { origin, directions } => {
                let mut theta = origin.clone();
                for (t, direction) in place.into_iter().zip(directions) {
                    theta.iter_mut().zip(direction).for_each(|(theta, d)| *theta += t * d);
                }
                theta
            }
            Way::Between { from, to } => {
                let t = place[0];
                from.iter().zip(to).map(|(from, to)| (1.0 - t) * from + t * to).collect()
            }
        }
    }

    /// A number for all that its rollouts depend on, but their seed.
    #[must_use]
    pub fn identity(&self, centre: &Centre, n_steps: u64) -> u64 {
        let mut text = format!("{:016x} {n_steps}", centre.identity);
        for point in 0..self.places.len() {
            let bytes: Vec<u8> =
                self.parameters(point).iter().flat_map(|value| value.to_le_bytes()).collect();
            // Writing to a string can't fail.
            let _ = write!(text, " {:016x}", xxh3_64(&bytes));
        }
        xxh3_64(text.as_bytes())
    }
}

/// The i-th of n places from -span to span; the middle one of an odd number is 0.
fn place(i: usize, n: usize, span: f64) -> f64 {
    let last = (n - 1) as f64;
    span * ((2 * i) as f64 - last) / last
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_a_line_and_both_ends_between_are_exact() {
        let (a, b) = (vec![0.1, -0.7], vec![0.3, 1e-9]);
        let line = Slice::line("".into(), 0, &a, vec![1.0, 3.0], (41, 0.3));
        assert_eq!(line.parameters(20), a);
        assert_eq!((line.places[0], line.places[40]), ([-0.3, 0.0], [0.3, 0.0]));
        let between = Slice::between("".into(), 0, (a.clone(), b.clone()), 7);
        assert_eq!((between.parameters(0), between.parameters(6)), (a.clone(), b));
        let directions = [vec![1.0, 0.0], vec![0.0, 2.0]];
        let plane = Slice::plane(("".into(), Kind::Plane), 0, &a, directions, (3, 1.0));
        assert_eq!(plane.parameters(4), a);
        // To the right, and up.
        assert_eq!(plane.places[5], [1.0, 0.0]);
        assert_eq!(plane.places[7], [0.0, 1.0]);
        assert_eq!(plane.parameters(7), [0.1, -0.7 + 2.0]);
    }
}
