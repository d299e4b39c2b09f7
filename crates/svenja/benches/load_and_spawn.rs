//! What a robot costs: reading its file, building it, and a control step around Bullet's own.
#![allow(missing_docs, clippy::unwrap_used)]

use std::{fs, hint::black_box, path::Path};

use bullet::{World, WorldSettings};
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use svenja::{Morphology, Readings, Robot, add_ground};

fn world() -> World {
    let mut world = World::new(&WorldSettings::default()).unwrap();
    add_ground(&mut world).unwrap();
    world
}

fn load_and_spawn(criterion: &mut Criterion) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/svenja.toml");
    let text = fs::read_to_string(path).unwrap();
    criterion.bench_function("read and check Svenja", |bench| {
        bench.iter(|| Morphology::parse("svenja.toml", black_box(&text)).unwrap());
    });

    let morphology = Morphology::parse("svenja.toml", &text).unwrap();
    criterion.bench_function("build Svenja", |bench| {
        let build = |mut world: World| {
            let robot = Robot::spawn(&morphology, &mut world).unwrap();
            (world, robot)
        };
        bench.iter_batched(world, build, BatchSize::SmallInput);
    });

    let mut world = world();
    let mut robot = Robot::spawn(&morphology, &mut world).unwrap();
    let mut readings = Readings::default();
    criterion.bench_function("sense", |bench| {
        bench.iter(|| robot.sense(&world, &mut readings).unwrap());
    });
    criterion.bench_function("drive", |bench| bench.iter(|| robot.drive(&mut world).unwrap()));
}

criterion_group!(benches, load_and_spawn);
criterion_main!(benches);
