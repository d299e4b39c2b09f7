//! On functions whose answer is known the measures give it.
#![allow(clippy::unwrap_used)]

mod noise;
mod properties;

use std::f64::consts::{PI, TAU};

use streams::Normals;

use super::*;

/// Points of a line from -1 to 1.
fn line(n: usize) -> impl Iterator<Item = f64> {
    (0..n).map(move |i| 2.0 * i as f64 / (n - 1) as f64 - 1.0)
}

/// A function on a line of 41 points, with noise of this deviation in each of `n_repeats`.
fn noisy(f: impl Fn(f64) -> f64, deviation: f64, n_repeats: usize, name: &str) -> Repeats {
    let mut normals = Normals::new(7, name);
    let mut repeat = || line(41).map(|t| f(t) + deviation * normals.draw()).collect();
    Repeats::new((0..n_repeats).map(|_| repeat()).collect()).unwrap()
}

/// A hill with k ripples of equal height from one end to the other.
fn ripples(k: usize) -> impl Fn(f64) -> f64 {
    move |t| 0.3 * (1.0 - t * t) - (k as f64 * PI * (t + 1.0)).cos()
}

fn n_optima(repeats: &Repeats) -> usize {
    Optima::of(repeats, &Grid::line(repeats.n_points())).n
}

#[test]
fn a_slope_has_no_optimum_a_dome_has_one_and_k_ripples_have_k() {
    for deviation in [0.0, 0.05, 0.15] {
        for n_repeats in [2, 5, 8] {
            let of = |f: &dyn Fn(f64) -> f64| n_optima(&noisy(f, deviation, n_repeats, "optima"));
            assert_eq!(of(&|t| 3.0 * t), 0, "{deviation} {n_repeats}");
            assert_eq!(of(&|t| 2.0 - 2.0 * t * t), 1, "{deviation} {n_repeats}");
            for k in 1..=5 {
                assert_eq!(of(&ripples(k)), k, "{deviation} {n_repeats}");
            }
        }
    }
}

/// The hill of height 1 stands on the higher one's slope, which is at 0.25 between them.
#[test]
fn prominences_worked_by_hand() {
    let heights = [0.0, 3.0, 0.25, 1.0, 0.5, -1.0];
    let peak = |index, prominence| Peak { index, prominence };
    // The higher one's feet are 0 and -1, the lower one's way up goes by 0.25.
    assert_eq!(Grid::line(6).prominences(&heights), [peak(1, 3.0), peak(3, 0.75)]);
    assert_eq!(Grid::line(3).prominences(&[1.0, 2.0, 3.0]), []);
    // A plateau is one hill.
    assert_eq!(Grid::line(4).prominences(&[0.0, 2.0, 2.0, 1.0]), [peak(1, 1.0)]);
}

#[test]
fn a_plane_has_as_many_optima_as_hills() {
    let n = 15;
    let at = |f: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        line(n).flat_map(|y| line(n).map(move |x| (x, y))).map(|(x, y)| f(x, y)).collect()
    };
    let of = |f: &dyn Fn(f64, f64) -> f64| Grid::plane(n, n).prominences(&at(f)).len();
    assert_eq!(of(&|x, y| x + y), 0);
    assert_eq!(of(&|x, y| -x * x - y * y), 1);
    // A saddle rises to the edge.
    assert_eq!(of(&|x, y| x * x - y * y), 0);
    // Four whole hills of a chequerboard, and none at its edge.
    assert_eq!(of(&|x, y| -(TAU * x).cos() - (TAU * y).cos()), 4);
    // A ridge has many local optima along a line that aren't any in the plane: it's a way up.
    assert_eq!(of(&|x, y| x - 4.0 * y * y), 0);
}

#[test]
fn variation_counts_each_way_up_and_down() {
    let of = |f: &dyn Fn(f64) -> f64, threshold| {
        variation(&line(41).map(f).collect::<Vec<_>>(), threshold)
    };
    assert_eq!(of(&|t| 3.0 * t, 0.0), Some(1.0));
    assert_eq!(of(&|t| -t * t, 0.0), Some(2.0));
    for k in 1..=5 {
        // Five ripples have four steps up; the ends of each are points.
        let found = of(&|t| -(k as f64 * PI * (t + 1.0)).cos(), 0.1).unwrap();
        assert!((found - 2.0 * k as f64).abs() < 0.1 * k as f64, "{k}: {found}");
    }
    assert_eq!(of(&|_| 2.0, 0.0), None);
    // Small ripples on a slope are none if they don't count.
    let rough = |t: f64| t + 0.01 * (40.0 * PI * t).cos();
    assert!((of(&rough, 0.03).unwrap() - 1.0).abs() < 0.03);
}

/// 41 points have a period of 40 / k for k waves.
#[test]
fn the_curvature_of_a_wave_is_that_of_its_period() {
    for k in [1, 2, 5] {
        let expected = 4.0 * (PI * k as f64 / 40.0).sin().powi(2);
        let wave = |t: f64| (k as f64 * PI * t).sin();
        let found = curvature(&noisy(wave, 0.0, 3, "wave")).unwrap();
        // The two ends have no second difference.
        assert!((found.value / expected - 1.0).abs() < 0.05, "{k}: {found:?}, not {expected}");
        assert!(found.holds(found.value));
    }
    // A line of slope has none; what doesn't vary has no measure.
    assert!(curvature(&noisy(|t| t, 0.0, 3, "slope")).unwrap().value < 1e-6);
    assert_eq!(curvature(&noisy(|_| 2.0, 0.0, 3, "flat")), None);
}

/// Hills of heights 1 and 2 at the ends, and between them a valley of depth 1.5 below their chord.
fn two_hills(t: f64) -> f64 {
    1.5 + 0.5 * t - 1.5 * (PI * (t + 1.0) / 2.0).sin().powi(2)
}

#[test]
fn a_barrier_is_the_depth_below_the_chord() {
    assert!((barrier(&noisy(two_hills, 0.0, 3, "hills")).value - 1.5).abs() < 1e-9);
    assert!(barrier(&noisy(|t| 1.0 - t * t, 0.0, 3, "dome")).value.abs() < 1e-12);
}

/// -|t| falls with distance by a line. Of -d^2, d uniform on 0 to 1, r = -sqrt(15) / 4.
#[test]
fn distance_correlations_worked_by_hand() {
    let distances: Vec<f64> = line(41).map(f64::abs).collect();
    let of = |f: &dyn Fn(f64) -> f64| distance_correlation(&noisy(f, 0.0, 3, "fdc"), &distances);
    assert!((of(&|t| -t.abs()).unwrap().value + 1.0).abs() < 1e-12);
    assert!((of(&|t| -t * t).unwrap().value + 15_f64.sqrt() / 4.0).abs() < 5e-3);
    assert!(of(&|t| t).unwrap().value.abs() < 1e-12);
    assert_eq!(of(&|_| 1.0), None);
}

#[test]
fn slopes_worked_by_hand() {
    let t: Vec<f64> = line(41).collect();
    let of = |f: &dyn Fn(f64) -> f64, reach| slope(&noisy(f, 0.0, 3, "slope"), &t, reach);
    // Neither a height nor a curvature has a part in it.
    assert!((of(&|t| 7.0 - 3.0 * t + 5.0 * t * t, 4).unwrap().value + 3.0).abs() < 1e-12);
    // Of t^3 at -d and d it's d^2.
    assert!((of(&|t| t * t * t, 1).unwrap().value - 0.05 * 0.05).abs() < 1e-12);
    assert_eq!(of(&|t| t, 21), None);
}

#[test]
fn cosines_worked_by_hand() {
    let of = |g: [f64; 2], h: [f64; 2]| cosine(&vec![g.to_vec(); 3], &vec![h.to_vec(); 3]);
    assert!((of([3.0, 0.0], [2.0, 2.0]).unwrap().value - 0.5_f64.sqrt()).abs() < 1e-12);
    assert!((of([1.0, 1.0], [-2.0, -2.0]).unwrap().value + 1.0).abs() < 1e-12);
    assert_eq!(of([0.0, 0.0], [1.0, 0.0]), None);
}

#[test]
fn directions_have_the_size_of_each_block() {
    let centre = [3.0, 4.0, 0.0, 0.6, 0.8, 7.0];
    let blocks = [vec![0, 1], vec![2], vec![3, 4]];
    let direction = random_direction(&centre, &blocks, 1, "a");
    assert!((direction[0].hypot(direction[1]) - 5.0).abs() < 1e-12);
    assert!((direction[3].hypot(direction[4]) - 1.0).abs() < 1e-12);
    // A block of nothing stays nothing, and what is in no block stays.
    assert_eq!((direction[2], direction[5]), (0.0, 0.0));
    assert_eq!(direction, random_direction(&centre, &blocks, 1, "a"));
    assert_ne!(direction, random_direction(&centre, &blocks, 1, "b"));
}

/// Two units of two weights with a bias each, and a parameter that has no weights.
#[test]
fn blocks_are_units_with_their_weights() {
    let links = [(0, Some(4)), (1, Some(4)), (2, Some(5)), (3, Some(5))];
    let found = blocks(7, links.into_iter());
    assert_eq!(found, [vec![0, 1, 4], vec![2, 3, 5], vec![6]]);
    assert_eq!(blocks(2, std::iter::empty()), [vec![0, 1]]);
}

/// A path in the plane of the first and the third of four parameters.
#[test]
fn the_principal_plane_has_the_path_in_it() {
    let path: Vec<Vec<f64>> = [[8.0, 0.0], [4.0, 1.0], [2.0, 1.0], [0.0, 0.0]]
        .map(|[a, b]| vec![a + 1.0, 5.0, b, -2.0])
        .into();
    let plane = PrincipalPlane::of(&path).unwrap();
    assert!((plane.share - 1.0).abs() < 1e-12);
    let [first, second] = &plane.directions;
    for (point, [a, b]) in path.iter().zip(&plane.path) {
        for (i, value) in point.iter().enumerate() {
            let found = path[3][i] + a * first[i] + b * second[i];
            assert!((found - value).abs() < 1e-9, "{found}, not {value}");
        }
    }
    // It begins on the positive side, and reaches 1.
    assert!((plane.path[0][0] - 1.0).abs() < 1e-9 && plane.path[3] == [0.0, 0.0]);
    assert!(first.iter().zip(second).map(|(a, b)| a * b).sum::<f64>().abs() < 1e-9);
    let straight: Vec<_> = (0..4).map(|i| vec![f64::from(i), 2.0 * f64::from(i)]).collect();
    assert_eq!(PrincipalPlane::of(&straight), None);
    assert_eq!(PrincipalPlane::of(&[]), None);
}

#[test]
fn what_is_no_slice_is_refused() {
    let message = |values| Repeats::new(values).unwrap_err().to_string();
    assert_eq!(message(vec![]), "repeats of a slice: expected at least 2 of them, got 0");
    assert_eq!(
        message(vec![vec![1.0; 2]; 2]),
        "repeats of a slice: expected at least 3 points, got 2"
    );
    let uneven = vec![vec![1.0; 3], vec![1.0; 4]];
    assert_eq!(message(uneven), "repeats of a slice: expected as many points in each, got 4");
    let blown_up = vec![vec![1.0, f64::NAN, 1.0]; 2];
    assert_eq!(message(blown_up), "a value of a slice: expected a finite number, got NaN");
}
