//! What a step and an update cost at 4,000 parameters (a conditional restricted Boltzmann machine
//! with 30 inputs, 50 hidden units and 24 outputs has 2,774).
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use gpomdp::{Estimator, EstimatorSettings, OptimiserSettings};

const N: usize = 4000;

/// Numbers around 0 that differ.
fn numbers() -> Vec<f64> {
    (0..N).map(|i| (i * 7919 % N) as f64 / N as f64 - 0.5).collect()
}

fn accumulate(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("accumulate");
    group.throughput(Throughput::Elements(N as u64));
    for (name, baseline_factor) in [("plain", None), ("baseline", Some(0.998))] {
        let settings = EstimatorSettings { baseline_factor, ..Default::default() };
        let mut estimator = Estimator::new(N, &settings).unwrap();
        let score = numbers();
        group.bench_function(name, |bencher| {
            bencher.iter(|| estimator.accumulate(black_box(&score), black_box(0.1)).unwrap());
        });
    }
}

fn update(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("update");
    group.throughput(Throughput::Elements(N as u64));
    for settings in OptimiserSettings::all() {
        let mut optimiser = settings.build(N).unwrap();
        let gradient = numbers();
        // Against the parameters as they were, so that they don't run away.
        let start = numbers();
        let mut theta = start.clone();
        group.bench_function(settings.name(), |bencher| {
            bencher.iter(|| {
                theta.copy_from_slice(&start);
                optimiser.update(&mut theta, black_box(&gradient)).unwrap();
            });
        });
    }
}

criterion_group!(benches, accumulate, update);
criterion_main!(benches);
