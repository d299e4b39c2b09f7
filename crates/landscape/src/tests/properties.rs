//! What holds for any heights.

use proptest::prelude::*;

use super::*;
use crate::optima::turns;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Two ways to simplify a line agree: the optima that stand out, and the turns that count.
    #[test]
    fn turns_have_the_optima_that_stand_out(
        heights in proptest::collection::vec(0..12_i32, 3..40), threshold in 0..6_i32,
    ) {
        let heights: Vec<f64> = heights.into_iter().map(f64::from).collect();
        let threshold = f64::from(threshold) + 0.5;
        let peaks = Grid::line(heights.len()).prominences(&heights);
        let peaks = peaks.iter().filter(|peak| peak.prominence > threshold).count();
        let turns = turns(&heights, threshold);
        let tops = turns.windows(3).filter(|it| it[1] > it[0] && it[1] > it[2]).count();
        prop_assert_eq!(tops, peaks);
    }

    /// Neither a shift nor a scale nor a reflection of the line changes a measure that has no unit.
    #[test]
    fn measures_have_no_unit(
        heights in proptest::collection::vec(-1.0..1.0_f64, 30), shift in -2.0..2.0_f64,
    ) {
        let rows = |f: &dyn Fn(f64) -> f64| -> Repeats {
            let rows = heights.chunks(10).map(|row| row.iter().map(|it| f(*it)).collect());
            Repeats::new(rows.collect()).unwrap()
        };
        let (plain, scaled) = (rows(&|x| x), rows(&|x| 4.0 * x + shift));
        let values = |it: &Repeats| {
            let distances: Vec<f64> = line(10).map(f64::abs).collect();
            [curvature(it), distance_correlation(it, &distances)].map(|it| it.map(|it| it.value))
        };
        for (a, b) in values(&plain).into_iter().zip(values(&scaled)) {
            prop_assert_eq!(a.is_some(), b.is_some());
            prop_assert!(a.zip(b).is_none_or(|(a, b)| (a - b).abs() < 1e-6 * (1.0 + a.abs())));
        }
        let grid = Grid::line(10);
        prop_assert_eq!(Optima::of(&plain, &grid).n, Optima::of(&scaled, &grid).n);
    }
}
