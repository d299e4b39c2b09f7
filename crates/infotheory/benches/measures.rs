//! What measures cost: a control step's reward for the groupings that are of use, and batches.
//!
//! A step is one reading of a hexapod taken in and its reward read: 24 joints for each joint and
//! each leg, 30 sensors for the whole body, from 100 pairs.

#![allow(clippy::unwrap_used, missing_docs)]

use criterion::{Criterion, criterion_group, criterion_main};
use infotheory::{
    Binning, Estimator, History, PermutationTest, Window, WindowSettings, all_sensors, each_sensor,
    mutual_information, transfer_entropy,
};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use std::hint::black_box;

/// Sensors that keep their symbol with odds of 3 to 1.
fn readings(n_sensors: usize, radix: u64) -> Vec<Vec<u64>> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut reading = vec![0; n_sensors];
    let mut next = || {
        for symbol in &mut reading {
            if random.next_u32() % 4 == 0 {
                *symbol = random.next_u64() % radix;
            }
        }
        reading.clone()
    };
    (0..1024).map(|_| next()).collect()
}

fn legs() -> Vec<Vec<usize>> {
    (0..6).map(|leg| (4 * leg..4 * leg + 4).collect()).collect()
}

fn windows(criterion: &mut Criterion) {
    for (name, n_sensors, radix, groups) in [
        ("24 joints, 1 bit", 24, 2, each_sensor(24)),
        ("24 joints, 2 bits", 24, 4, each_sensor(24)),
        ("24 joints, 40 bits", 24, 1 << 40, each_sensor(24)),
        ("6 legs, 4 x 1 bit", 24, 2, legs()),
        ("6 legs, 4 x 2 bits", 24, 4, legs()),
        ("whole body, 30 bits", 30, 2, all_sensors(30)),
    ] {
        let readings = readings(n_sensors, radix);
        let settings = WindowSettings::default();
        let mut window = Window::new(settings, &vec![radix; n_sensors], &groups).unwrap();
        let mut next = readings.iter().cycle();
        criterion.bench_function(&format!("window, {name}"), |bencher| {
            bencher.iter(|| {
                window.push(next.next().unwrap()).unwrap();
                black_box(window.share_of_maximum(Estimator::PlugIn))
            });
        });
        if radix == 2 && n_sensors == 24 {
            criterion.bench_function(&format!("window, {name}, corrected too"), |bencher| {
                bencher.iter(|| {
                    window.push(next.next().unwrap()).unwrap();
                    black_box(window.share_of_maximum(Estimator::PlugIn));
                    black_box(window.share_of_maximum(Estimator::MillerMadow))
                });
            });
        }
    }
}

fn batches(criterion: &mut Criterion) {
    let rows = readings(2, 4);
    let column = |i: usize| -> Vec<u64> { rows.iter().map(|row| row[i]).collect() };
    let (x, y) = (column(0), column(1));
    criterion.bench_function("mutual information, 1024 samples", |bencher| {
        bencher.iter(|| mutual_information(black_box(&x), &y, Estimator::PlugIn));
    });
    let history = History { target: 2, source: 1 };
    criterion.bench_function("transfer entropy, 1024 samples", |bencher| {
        bencher.iter(|| transfer_entropy(black_box(&x), &y, history, Estimator::PlugIn));
    });
    let test = PermutationTest { shuffles: 100, seed: 1, estimator: Estimator::PlugIn };
    criterion.bench_function("transfer entropy, 1024 samples, 100 shuffles", |bencher| {
        bencher.iter(|| test.transfer_entropy(black_box(&x), &y, history));
    });

    let binning = Binning::new(1).unwrap();
    let values: Vec<f64> = (0..24).map(|i| f64::from(i) / 12.0 - 0.97).collect();
    let mut bits = [false; 24];
    criterion.bench_function("binning, 24 values", |bencher| {
        bencher.iter(|| binning.encode(black_box(&values), &mut bits));
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = windows, batches
}
criterion_main!(benches);
