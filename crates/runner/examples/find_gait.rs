//! Searches a gait for Svenja: `cargo run --release -p runner --example find_gait -- SEED TRIALS`.
//!
//! In a gait each joint axis of a left leg is on for a part of the period that begins at some phase;
//! the right leg opposite does the same half a period later. That's two numbers for each of 12 axes
//! and the period. The search changes a few of them at a time and keeps what walks at least as
//! fast, measured along the heading over three periods after one to get going. It ends with the
//! gait file.
#![allow(clippy::unwrap_used)]

use std::{env, path::Path};

use bullet::{World, WorldSettings};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use svenja::{Morphology, Readings, Robot, add_ground};

const AXES: usize = 12;
const LONGEST: u32 = 24;

#[derive(Clone)]
struct Pattern {
    /// In control steps, even.
    period: u32,
    /// `[AXES]`: when an axis goes on, and for how long, in control steps.
    on: Vec<(u32, u32)>,
}

impl Pattern {
    fn random(rng: &mut ChaCha8Rng) -> Self {
        let period = 2 * (4 + rng.next_u32() % (LONGEST / 2 - 3));
        let on = (0..AXES).map(|_| (rng.next_u32() % period, rng.next_u32() % (period + 1)));
        Self { period, on: on.collect() }
    }

    fn changed(&self, rng: &mut ChaCha8Rng) -> Self {
        let mut new = self.clone();
        if rng.next_u32().is_multiple_of(8) {
            let longer = rng.next_u32() & 1 == 1;
            new.period = if longer { LONGEST.min(new.period + 2) } else { 8.max(new.period - 2) };
        }
        for _ in 0..=rng.next_u32() % 3 {
            let axis = rng.next_u32() as usize % AXES;
            new.on[axis] = (rng.next_u32() % new.period, rng.next_u32() % (new.period + 1));
        }
        new
    }

    fn bit(&self, step: u32, leg: usize, axis: usize) -> bool {
        let (start, length) = self.on[leg / 2 * 4 + axis];
        let right = leg as u32 % 2;
        (step + right * self.period / 2 + self.period - start % self.period) % self.period < length
    }

    fn row(&self, step: u32) -> Vec<bool> {
        (0..6).flat_map(|leg| (0..4).map(move |axis| self.bit(step, leg, axis))).collect()
    }
}

/// In m along the heading per control step.
fn speed(morphology: &Morphology, pattern: &Pattern) -> f64 {
    let mut world = World::new(&WorldSettings::default()).unwrap();
    add_ground(&mut world).unwrap();
    let mut robot = Robot::spawn(morphology, &mut world).unwrap();
    let mut readings = Readings::default();
    robot.step(&mut world, 200).unwrap();
    let mut advance = 0.0;
    for step in 0..4 * pattern.period {
        robot.sense(&world, &mut readings).unwrap();
        let before = robot.centre_of_gravity_m();
        let targets: Vec<_> =
            pattern.row(step).iter().map(|&bit| if bit { 0.5 } else { -0.5 }).collect();
        robot.actuate(&targets).unwrap();
        robot.step(&mut world, 10).unwrap();
        robot.sense(&world, &mut readings).unwrap();
        if step >= pattern.period {
            let moved = robot.centre_of_gravity_m() - before;
            advance += moved.xy().dot(&robot.heading().xy());
        }
    }
    advance / f64::from(3 * pattern.period)
}

fn main() {
    let argument = |i, default| env::args().nth(i).map_or(default, |text| text.parse().unwrap());
    let (seed, trials) = (argument(1, 1), argument(2, 400));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/svenja.toml");
    let morphology = Morphology::open(&path).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut best = Pattern::random(&mut rng);
    let mut fastest = speed(&morphology, &best);
    for trial in 0..trials {
        // A tenth of them at random, to see where to begin.
        let new =
            if trial < trials / 10 { Pattern::random(&mut rng) } else { best.changed(&mut rng) };
        let speed = speed(&morphology, &new);
        if speed >= fastest {
            (best, fastest) = (new, speed);
            eprintln!("trial {trial}: {fastest:.4} m per control step, period {}", best.period);
        }
    }
    println!("name = \"seed {seed}, {fastest:.4} m per control step\"\nbits = 1\nsteps = [");
    for step in 0..best.period {
        let digits: Vec<_> =
            best.row(step).iter().map(|&bit| if bit { "1" } else { "0" }).collect();
        let legs: Vec<_> = digits.chunks(4).map(<[&str]>::concat).collect();
        println!("    \"{}\",", legs.join(" "));
    }
    println!("]");
}
