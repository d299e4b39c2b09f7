//! Searches a gait: `cargo run --release -p runner --example find_gait -- MODEL SEED TRIALS [together]`.
//!
//! In a gait each axis on the left is on for a part of the period that begins at some phase; the axis
//! of the same name on the right does the same half a period later, or at the same time if
//! `together` is said, as in a bound. That's two numbers for each of these axes, and the period. The
//! search changes a few of them at a time and keeps what walks at least as fast, measured along the
//! heading over three periods after one to get going. It ends with the gait file.
#![allow(clippy::unwrap_used)]

use std::{env, path::Path};

use bullet::{World, WorldSettings};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use svenja::{Morphology, Readings, Robot, add_ground};

const LONGEST: u32 = 24;

/// What a pattern is for: of each actuator which of the pattern's axes it follows, and whether that
/// is the other side's.
struct Plan {
    follows: Vec<(usize, bool)>,
    n_axes: usize,
    /// How many actuators a group of columns has.
    group: usize,
    together: bool,
}

impl Plan {
    fn new(morphology: &Morphology, together: bool) -> Self {
        let names: Vec<_> =
            morphology.actuators().iter().map(|id| morphology.axis_name(*id)).collect();
        let mut leads = Vec::new();
        let mut follows = Vec::new();
        for name in &names {
            let other = name.replace("right", "left");
            let lead = leads.iter().position(|lead| *lead == other);
            follows.push((lead.unwrap_or(leads.len()), lead.is_some()));
            if lead.is_none() {
                leads.push(name.clone());
            }
        }
        let group = names.len() / morphology.groups().len().max(1);
        Self { follows, n_axes: leads.len(), group: group.max(1), together }
    }
}

#[derive(Clone)]
struct Pattern {
    /// In control steps, even.
    period: u32,
    /// `[n_axes]`: when an axis goes on, and for how long, in control steps.
    on: Vec<(u32, u32)>,
}

impl Pattern {
    fn random(n_axes: usize, rng: &mut ChaCha8Rng) -> Self {
        let period = 2 * (4 + rng.next_u32() % (LONGEST / 2 - 3));
        let on = (0..n_axes).map(|_| (rng.next_u32() % period, rng.next_u32() % (period + 1)));
        Self { period, on: on.collect() }
    }

    fn changed(&self, rng: &mut ChaCha8Rng) -> Self {
        let mut new = self.clone();
        if rng.next_u32().is_multiple_of(8) {
            let longer = rng.next_u32() & 1 == 1;
            new.period = if longer { LONGEST.min(new.period + 2) } else { 8.max(new.period - 2) };
        }
        for _ in 0..=rng.next_u32() % 3 {
            let axis = rng.next_u32() as usize % self.on.len();
            new.on[axis] = (rng.next_u32() % new.period, rng.next_u32() % (new.period + 1));
        }
        new
    }

    fn row(&self, plan: &Plan, step: u32) -> Vec<bool> {
        let bit = |&(axis, other): &(usize, bool)| {
            let (start, length) = self.on[axis];
            let later = if other && !plan.together { self.period / 2 } else { 0 };
            (step + later + self.period - start % self.period) % self.period < length
        };
        plan.follows.iter().map(bit).collect()
    }
}

/// In m along the heading per control step.
fn speed(morphology: &Morphology, plan: &Plan, pattern: &Pattern) -> f64 {
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
            pattern.row(plan, step).iter().map(|&bit| if bit { 0.5 } else { -0.5 }).collect();
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
    let mut arguments = env::args().skip(1);
    let model = arguments.next().unwrap_or_else(|| "models/svenja.toml".into());
    let mut number = |default| arguments.next().map_or(default, |text| text.parse().unwrap());
    let (seed, trials) = (number(1), number(400));
    let together = arguments.next().is_some_and(|word| word == "together");
    let morphology = Morphology::open(Path::new(&model)).unwrap();
    let plan = Plan::new(&morphology, together);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut best = Pattern::random(plan.n_axes, &mut rng);
    let mut fastest = speed(&morphology, &plan, &best);
    for trial in 0..trials {
        // A tenth of them at random, to see where to begin.
        let new = match trial < trials / 10 {
            true => Pattern::random(plan.n_axes, &mut rng),
            false => best.changed(&mut rng),
        };
        let speed = speed(&morphology, &plan, &new);
        if speed >= fastest {
            (best, fastest) = (new, speed);
            eprintln!("trial {trial}: {fastest:.4} m per control step, period {}", best.period);
        }
    }
    println!("name = \"seed {seed}, {fastest:.4} m per control step\"\nbits = 1\nsteps = [");
    for step in 0..best.period {
        let digits: Vec<_> =
            best.row(&plan, step).iter().map(|&bit| if bit { "1" } else { "0" }).collect();
        let groups: Vec<_> = digits.chunks(plan.group).map(<[&str]>::concat).collect();
        println!("    \"{}\",", groups.join(" "));
    }
    println!("]");
}
