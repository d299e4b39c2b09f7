//! Which parts of a body are beside each other, from where they are: the relative neighbourhood
//! graph (G. T. Toussaint, The relative neighbourhood graph of a finite planar set, Pattern
//! Recognition 12 (1980), 261-268).
//!
//! Two points are neighbours if no third is nearer to both than they are to each other. So the legs
//! of a hexapod make a ladder, those of a quadruped a ring, the segments of a worm a chain; and all
//! points hang together.

/// Parts of rounding by which a distance must be less than another.
const TOLERANCE: f64 = 1e-9;

/// The neighbours of each point, increasing. The points' unit is of no importance.
///
/// ```
/// // Front left, front right, centre left, centre right, rear left, rear right.
/// let hips = [[-1., 2., 0.], [1., 2., 0.], [-1., 0., 0.], [1., 0., 0.], [-1., -2., 0.], [1., -2., 0.]];
/// assert_eq!(policy::beside(&hips)[2], [0, 3, 4], "a centre leg: front, rear and across");
/// ```
#[must_use]
pub fn beside(points: &[[f64; 3]]) -> Vec<Vec<usize>> {
    let square = |a: usize, b: usize| -> f64 {
        points[a].iter().zip(points[b]).map(|(a, b)| (a - b) * (a - b)).sum()
    };
    let all = 0..points.len();
    let is_beside = |a: usize, b: usize| {
        let bound = square(a, b) * (1.0 - TOLERANCE);
        a != b && !all.clone().any(|c| square(a, c) < bound && square(b, c) < bound)
    };
    all.clone().map(|a| all.clone().filter(|&b| is_beside(a, b)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadruped_is_a_ring_and_a_worm_a_chain() {
        let corners = [[-1.0, 1.0, 0.5], [1.0, 1.0, 0.5], [-1.0, -1.0, 0.5], [1.0, -1.0, 0.5]];
        assert_eq!(beside(&corners), [[1, 2], [0, 3], [0, 3], [1, 2]]);
        let segments = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 2.0, 0.1]];
        assert_eq!(beside(&segments), [vec![1], vec![0, 2], vec![1]]);
        assert_eq!(beside(&[[0.0; 3]]), [[0; 0]]);
    }

    /// Three legs at equal distances: whatever rounding does to them, all are beside each other.
    #[test]
    fn rounding_decides_nothing() {
        for turn in 0..100 {
            let points = [0, 1, 2].map(|leg| {
                let angle = f64::from(turn) + f64::from(leg) * std::f64::consts::TAU / 3.0;
                [libm::cos(angle), libm::sin(angle), 0.0]
            });
            assert_eq!(beside(&points), [[1, 2], [0, 2], [0, 1]], "{turn}");
        }
    }
}
