//! Noise isn't roughness: measures of noisy values have the answer within their interval as often as they
//! say, and noise alone has no optimum in 95 % of slices.

use super::*;

/// How noise can be: of its own at each point, in common to neighbours, and of another size elsewhere.
fn noise(kind: usize, n_repeats: usize, slice: usize) -> Repeats {
    let mut normals = Normals::new(slice as u64, "noise");
    let mut repeat = || -> Vec<f64> {
        let mut last = normals.draw();
        line(41)
            .map(|t| {
                let draw = normals.draw();
                last = 0.8 * last + 0.6 * draw;
                match kind {
                    0 => draw,
                    1 => last,
                    _ => draw * (3.0 * t).exp(),
                }
            })
            .collect()
    };
    Repeats::new((0..n_repeats).map(|_| repeat()).collect()).unwrap()
}

/// At most 5 % of 400 slices, and three standard errors of such a share.
#[test]
fn noise_alone_has_no_optimum_in_95_percent_of_slices() {
    let slices = 400;
    let most = 0.05 + 3.0 * (0.05_f64 * 0.95 / slices as f64).sqrt();
    for kind in 0..3 {
        for n_repeats in [2, 3, 5, 8] {
            let found = (0..slices).filter(|&slice| n_optima(&noise(kind, n_repeats, slice)) > 0);
            let share = found.count() as f64 / slices as f64;
            assert!(share <= most, "noise {kind}, {n_repeats} repeats: {share}");
        }
    }
}

/// The share of 300 noisy slices whose interval holds what the function itself has.
fn coverage(truth: f64, measure: impl Fn(usize) -> Option<Estimate>) -> f64 {
    let found: Vec<_> = (0..300).filter_map(measure).collect();
    assert!(found.len() > 270, "only {} have one", found.len());
    found.iter().filter(|it| it.holds(truth)).count() as f64 / found.len() as f64
}

/// Intervals are those of Student's t for what isn't quite normal: 90 % will do for a nominal 95 %, whose
/// share of 300 has a standard error of 1.3 %.
#[test]
fn intervals_hold_the_answer() {
    let wave = |t: f64| (4.0 * PI * t).sin();
    let distances: Vec<f64> = line(41).map(f64::abs).collect();
    let of = |f: &dyn Fn(f64) -> f64, slice: usize| noisy(f, 0.3, 6, &format!("slice {slice}"));

    let exact = curvature(&noisy(wave, 0.0, 3, "")).unwrap().value;
    let share = coverage(exact, |slice| curvature(&of(&wave, slice)));
    assert!(share > 0.9, "curvature: {share}");

    let dome = |t: f64| -t * t;
    let exact = distance_correlation(&noisy(dome, 0.0, 3, ""), &distances).unwrap().value;
    let share = coverage(exact, |slice| distance_correlation(&of(&dome, slice), &distances));
    assert!(share > 0.9, "distance correlation: {share}");

    let t: Vec<f64> = line(41).collect();
    let share = coverage(2.0, |slice| slope(&of(&|t| 2.0 * t - t * t, slice), &t, 4));
    assert!(share > 0.9, "slope: {share}");

    let share = coverage(1.5, |slice| Some(barrier(&of(&two_hills, slice))));
    assert!(share > 0.9, "barrier: {share}");
}

/// Without taking noise out, the curvature of a dome would be that of the noise, ten times as large, and
/// a slope would have a barrier.
#[test]
fn noise_is_taken_out() {
    let dome = |t: f64| 1.0 - t * t;
    let exact = curvature(&noisy(dome, 0.0, 3, "")).unwrap().value;
    let found: Vec<_> = (0..50)
        .filter_map(|slice| curvature(&noisy(dome, 0.02, 6, &format!("{slice}"))))
        .map(|it| it.value * it.value)
        .collect();
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    assert!(mean.sqrt() < 3.0 * exact, "{} for {exact}", mean.sqrt());

    let of = |slice: usize| barrier(&noisy(|t| t, 0.3, 6, &format!("{slice}"))).value;
    let mean = (0..200).map(of).sum::<f64>() / 200.0;
    // Single depths have a deviation of 0.3 and more.
    assert!(mean < 0.05, "{mean}");
}

/// Two gradients at 60 degrees whose estimates are mostly noise, partly the same noise: plain cosines of
/// these are far from 0.5.
#[test]
fn cosines_are_those_of_the_gradients_and_not_of_their_noise() {
    let n = 200;
    let estimates = |slice: usize| {
        let mut normals = Normals::new(slice as u64, "gradients");
        let pairs = (0..8).map(|_| {
            let common: Vec<f64> = (0..n).map(|_| normals.draw()).collect();
            let mut at = |direction: [f64; 2]| -> Vec<f64> {
                let signal = |i: usize| 8.0 * direction.get(i).copied().unwrap_or(0.0);
                (0..n).map(|i| signal(i) + common[i] + 0.5 * normals.draw()).collect()
            };
            (at([1.0, 0.0]), at([0.5, 0.75_f64.sqrt()]))
        });
        let (g, h): (Vec<_>, Vec<_>) = pairs.unzip();
        cosine(&g, &h)
    };
    let share = coverage(0.5, estimates);
    assert!(share > 0.9, "{share}");
}
