//! What stepping in lanes is worth: Svenjas under random actions, stepped together and one by one
//! by Bullet's own solver, by turns in one process. Each world step has the servo law with it.
//!
//! `cargo bench -p svenja --bench lockstep -- none` prints the ratios alone. Machines have modes, by
//! load and by clock: compare ratios within a mode, for which the time of Bullet's own step stands.
#![allow(missing_docs, clippy::unwrap_used)]

use std::{
    path::Path,
    time::{Duration, Instant},
};

use bullet::{Instructions, Lockstep, SCALAR_BYTES, World, WorldSettings};
use criterion::Criterion;
use rand_pcg::{
    Pcg64Mcg,
    rand_core::{Rng, SeedableRng},
};
use svenja::{Morphology, Robot, add_ground};

/// Physics steps in a row of one kind, one control step.
const BLOCK: usize = 10;
const BLOCKS: usize = 150;

struct Walker {
    world: World,
    robot: Robot,
    random: Pcg64Mcg,
}

impl Walker {
    fn new(morphology: &Morphology, seed: usize) -> Self {
        let mut world = World::new(&WorldSettings::default()).unwrap();
        add_ground(&mut world).unwrap();
        let robot = Robot::spawn(morphology, &mut world).unwrap();
        Self { world, robot, random: Pcg64Mcg::seed_from_u64(seed as u64) }
    }

    fn choose(&mut self) {
        let bits = self.random.next_u64();
        let target = |i| if bits >> i & 1 == 1 { 1.0 } else { -1.0 };
        let targets: Vec<f64> = (0..self.robot.n_actuators()).map(target).collect();
        self.robot.actuate(&targets).unwrap();
    }
}

/// Some walkers twice: stepped together, and alone.
struct Race {
    together: Vec<Walker>,
    alone: Vec<Walker>,
    lockstep: Lockstep,
}

impl Race {
    fn new(morphology: &Morphology, instructions: Instructions, n: usize) -> Self {
        let walkers = |n| (0..n).map(|seed| Walker::new(morphology, seed)).collect::<Vec<_>>();
        let lockstep = Lockstep::with(instructions).unwrap();
        let mut race = Self { together: walkers(n), alone: walkers(n.min(2)), lockstep };
        for _ in 0..20 {
            race.step_together();
            race.step_alone();
        }
        race
    }

    /// Of a world step, a control step long.
    fn step_together(&mut self) -> Duration {
        self.together.iter_mut().for_each(Walker::choose);
        let mut results = Vec::new();
        let start = Instant::now();
        for _ in 0..BLOCK {
            for walker in &mut self.together {
                walker.robot.drive(&mut walker.world).unwrap();
            }
            let mut worlds: Vec<&mut World> =
                self.together.iter_mut().map(|walker| &mut walker.world).collect();
            self.lockstep.step(&mut worlds, &mut results).unwrap();
        }
        start.elapsed() / (BLOCK * self.together.len()) as u32
    }

    fn step_alone(&mut self) -> Duration {
        self.alone.iter_mut().for_each(Walker::choose);
        let start = Instant::now();
        for walker in &mut self.alone {
            for _ in 0..BLOCK {
                walker.robot.drive(&mut walker.world).unwrap();
                walker.world.step().unwrap();
            }
        }
        start.elapsed() / (BLOCK * self.alone.len()) as u32
    }

    fn run(&mut self) -> String {
        let before = self.lockstep.times();
        let (mut ours, mut theirs, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..BLOCKS {
            let together = self.step_together().as_secs_f64();
            let alone = self.step_alone().as_secs_f64();
            ours.push(together);
            theirs.push(alone);
            ratios.push(alone / together);
        }
        let now = self.lockstep.times();
        let steps = (BLOCKS * BLOCK * self.together.len()) as f64;
        let part = |now: f64, before: f64| (now - before) / steps * 1e6;
        format!(
            "{:5.2} times; {:4.0} us a world step against {:4.0}: begin {:.1}, pack {:.1}, sweep \
             {:.1}, unpack {:.1}, end {:.1}",
            median(ratios),
            median(ours) * 1e6,
            median(theirs) * 1e6,
            part(now.begin, before.begin),
            part(now.pack, before.pack),
            part(now.sweep, before.sweep),
            part(now.unpack, before.unpack),
            part(now.end, before.end),
        )
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/svenja.toml");
    let morphology = Morphology::open(&path).unwrap();
    let best = Instructions::best();
    let mut criterion = Criterion::default().sample_size(20).configure_from_args();
    let mut race = Race::new(&morphology, best, best.lanes());
    criterion.bench_function("a world step in lanes", |bencher| {
        bencher.iter_custom(|n| (0..n).map(|_| race.step_together()).sum());
    });
    criterion.bench_function("a world step alone", |bencher| {
        bencher.iter_custom(|n| (0..n).map(|_| race.step_alone()).sum());
    });
    criterion.final_summary();

    if std::env::args().any(|argument| argument == "--bench") {
        let bits = 8 * SCALAR_BYTES;
        for instructions in Instructions::ALL.into_iter().filter(|it| it.are_available()) {
            let lanes = instructions.lanes();
            let found = Race::new(&morphology, instructions, lanes).run();
            println!("f{bits}, {instructions:?}, {lanes} worlds: {found}");
        }
        let found = Race::new(&morphology, best, 1).run();
        println!("f{bits}, one world: {found}");
    }
}
