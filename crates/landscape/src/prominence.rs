//! How far a local optimum stands out:
//!
//! ```text
//! prominence = its height - the highest point at which one has to pass to get to higher ground
//! ```
//!
//! Ground outside of the slice counts as higher: what rises to the edge may rise on. So a slope has no
//! optimum, and a dome's prominence is its height over the higher of its feet. This is the persistence of
//! the superlevel sets' components (H. Edelsbrunner, D. Letscher and A. Zomorodian, *Topological
//! persistence and simplification*, Discrete and Computational Geometry 28, 2002): points are taken from
//! the highest one down, each joins its neighbours that were taken already, and where two hills meet the
//! lower one ends.

/// How a slice's points lie: row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grid {
    n_rows: usize,
    n_columns: usize,
}

/// A local optimum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// The point.
    pub index: usize,
    /// How far it stands out.
    pub prominence: f64,
}

impl Grid {
    /// Points in a line.
    #[must_use]
    pub fn line(n: usize) -> Self {
        Self { n_rows: 1, n_columns: n }
    }

    /// Points of a plane. Those beside each other, also by a corner, are neighbours.
    #[must_use]
    pub fn plane(n_rows: usize, n_columns: usize) -> Self {
        Self { n_rows, n_columns }
    }

    /// The number of points.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.n_rows * self.n_columns
    }

    /// All optima of a slice's heights, `[n_points]`, the most prominent first. Of equal neighbours one
    /// stands for all.
    #[must_use]
    pub fn prominences(&self, heights: &[f64]) -> Vec<Peak> {
        let outside = self.n_points();
        let mut hills = Hills::new(heights, outside);
        let mut order: Vec<usize> = (0..outside).collect();
        order.sort_by(|&a, &b| heights[b].total_cmp(&heights[a]).then(a.cmp(&b)));
        for point in order {
            hills.take(point);
            for neighbour in self.neighbours(point) {
                hills.join(point, neighbour.unwrap_or(outside));
            }
        }
        let mut peaks = hills.ended;
        peaks.sort_by(|a, b| b.prominence.total_cmp(&a.prominence).then(a.index.cmp(&b.index)));
        peaks
    }

    /// The points beside a point; none for what is outside.
    fn neighbours(&self, point: usize) -> impl Iterator<Item = Option<usize>> + '_ {
        let (row, column) = (point / self.n_columns, point % self.n_columns);
        // A line has no outside above and below it.
        let rows = if self.n_rows == 1 { 1..=1 } else { 0..=2 };
        let steps = rows.flat_map(|down| (0..=2).map(move |right| (down, right)));
        steps.filter(|&step| step != (1, 1)).map(move |(down, right)| {
            let row = (row + down).checked_sub(1).filter(|row| *row < self.n_rows)?;
            let column = (column + right).checked_sub(1).filter(|it| *it < self.n_columns)?;
            Some(row * self.n_columns + column)
        })
    }
}

/// The hills above the water while it falls: sets of points, each known by its summit.
struct Hills<'a> {
    heights: &'a [f64],
    /// The next point on the way to the summit; none while under water.
    towards: Vec<Option<usize>>,
    ended: Vec<Peak>,
}

impl<'a> Hills<'a> {
    fn new(heights: &'a [f64], outside: usize) -> Self {
        let mut towards = vec![None; outside + 1];
        towards[outside] = Some(outside);
        Self { heights, towards, ended: Vec::new() }
    }

    fn take(&mut self, point: usize) {
        self.towards[point] = Some(point);
    }

    fn summit(&mut self, mut point: usize) -> Option<usize> {
        loop {
            let next = self.towards[point]?;
            if next == point {
                return Some(point);
            }
            // Shortens the way for the next one.
            self.towards[point] = self.towards[next];
            point = next;
        }
    }

    /// The water stands at `point`; if its neighbour is above it, their hills are one.
    fn join(&mut self, point: usize, neighbour: usize) {
        let (Some(a), Some(b)) = (self.summit(point), self.summit(neighbour)) else { return };
        if a == b {
            return;
        }
        let height = |summit: usize| self.heights.get(summit).copied().unwrap_or(f64::INFINITY);
        let (higher, lower) = if height(a) > height(b) { (a, b) } else { (b, a) };
        self.towards[lower] = Some(higher);
        let prominence = self.heights[lower] - self.heights[point];
        if prominence > 0.0 {
            self.ended.push(Peak { index: lower, prominence });
        }
    }
}
