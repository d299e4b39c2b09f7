//! What an action with its score costs at the paper's size: 30 inputs, 50 hidden units, 24 outputs,
//! 10 Gibbs updates, 60 samples; beside the plain scalar loop of `tests/plain`.
//!
//! The last lines printed are the ones that count: single timings wander with the machine's load,
//! the ratio of neighbouring blocks doesn't. `cargo bench -p crbm -- none` prints them alone.

#![allow(clippy::unwrap_used, missing_docs)]

#[allow(dead_code, unreachable_pub, clippy::needless_range_loop)]
#[path = "../tests/plain/mod.rs"]
mod plain;

use std::{
    hint::black_box,
    time::{Duration, Instant},
};

use crbm::{ChainRng, Instructions, Layout, Mask, Policy, Sampling};
use criterion::Criterion;
use plain::Plain;

const SIZES: [usize; 3] = [30, 50, 24];
const BLOCK: u32 = 10;
const BLOCKS: usize = 100;

fn main() {
    let mut criterion = Criterion::default().sample_size(20).configure_from_args();
    for instructions in Instructions::available() {
        let mut ours = Ours::new(Layout::full(30, 50, 24).unwrap(), instructions);
        criterion.bench_function(&format!("act and score, {instructions:?}"), |bencher| {
            bencher.iter(|| ours.act_and_score());
        });
    }
    let best = *Instructions::available().last().unwrap();
    let mut ours = Ours::new(Layout::full(30, 50, 24).unwrap(), best);
    criterion.bench_function("act alone", |bencher| bencher.iter(|| ours.act()));
    criterion.bench_function("set parameters", |bencher| bencher.iter(|| ours.set_parameters()));
    let mut ours = Ours::new(legs(), best);
    criterion.bench_function("act and score, a block of 8 hidden units a leg", |bencher| {
        bencher.iter(|| ours.act_and_score());
    });
    let mut theirs = Theirs::new();
    criterion.bench_function("plain scalar loop", |bencher| {
        bencher.iter(|| theirs.act_and_score());
    });
    criterion.final_summary();

    // Not when `cargo test --benches` only sees whether all this runs.
    if std::env::args().any(|argument| argument == "--bench") {
        Instructions::available().into_iter().for_each(compare);
    }
}

fn legs() -> Layout {
    let leg_of_output: Vec<usize> = (0..24).map(|output| output / 4).collect();
    let outputs = Mask::blocks(8, &leg_of_output).unwrap();
    Layout::new(Mask::full(48, 30).unwrap(), outputs).unwrap()
}

/// Both by turns, in alternating order.
fn compare(instructions: Instructions) {
    let (mut ours, mut theirs) =
        (Ours::new(Layout::full(30, 50, 24).unwrap(), instructions), Theirs::new());
    let mut run_ours = || timed(|| ours.act_and_score());
    let mut run_theirs = || timed(|| theirs.act_and_score());
    let [mut ratios, mut our_times, mut their_times] = [const { Vec::new() }; 3];
    for block in 0..BLOCKS {
        let (ours, theirs) = if block % 2 == 0 {
            let first = run_ours();
            (first, run_theirs())
        } else {
            let first = run_theirs();
            (run_ours(), first)
        };
        ratios.push(theirs.as_secs_f64() / ours.as_secs_f64());
        our_times.push(ours.as_secs_f64() * 1e6 / f64::from(BLOCK));
        their_times.push(theirs.as_secs_f64() * 1e6 / f64::from(BLOCK));
    }
    println!(
        "plain scalar loop / {instructions:?}: {:.1} (median of {BLOCKS} alternating blocks; \
         us per act and score {:.1} / {:.1})",
        median(ratios),
        median(their_times),
        median(our_times)
    );
}

fn timed(mut f: impl FnMut()) -> Duration {
    let start = Instant::now();
    (0..BLOCK).for_each(|_| f());
    start.elapsed()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Weights as after some learning, so that bits neither freeze nor are all coins.
fn parameters(layout: &Layout) -> Vec<f64> {
    layout.random_parameters(0.5, 1, "bench").unwrap()
}

struct Ours {
    policy: Policy,
    rng: ChainRng,
    parameters: Vec<f64>,
    x: Vec<bool>,
    y: Vec<bool>,
    score: Vec<f64>,
}

impl Ours {
    fn new(layout: Layout, instructions: Instructions) -> Self {
        let parameters = parameters(&layout);
        let x = (0..layout.n_inputs()).map(|k| k % 3 == 0).collect();
        let (y, score) = (vec![false; layout.n_outputs()], vec![0.0; layout.n_parameters()]);
        let mut policy = Policy::new(layout, Sampling::default(), &parameters).unwrap();
        policy.set_instructions(instructions).unwrap();
        let rng = policy.rng(1, "policy");
        Self { policy, rng, parameters, x, y, score }
    }

    fn act_and_score(&mut self) {
        let (rng, y, score) = (&mut self.rng, &mut self.y, &mut self.score);
        self.policy.act_and_score(black_box(&self.x), rng, y, score).unwrap();
        black_box((y, score));
    }

    fn act(&mut self) {
        self.policy.act(black_box(&self.x), &mut self.rng, &mut self.y).unwrap();
        black_box(&self.y);
    }

    fn set_parameters(&mut self) {
        self.policy.set_parameters(black_box(&self.parameters)).unwrap();
    }
}

struct Theirs {
    plain: Plain,
    x: Vec<f64>,
    y: Vec<f64>,
    score: Vec<f64>,
}

impl Theirs {
    fn new() -> Self {
        let [n_inputs, n_hidden, n_outputs] = SIZES;
        let layout = Layout::full(n_inputs, n_hidden, n_outputs).unwrap();
        let x = (0..n_inputs).map(|k| if k % 3 == 0 { 1.0 } else { 0.0 }).collect();
        let (y, score) = (vec![0.0; n_outputs], vec![0.0; layout.n_parameters()]);
        Self { plain: Plain::new(SIZES, parameters(&layout), 1), x, y, score }
    }

    fn act_and_score(&mut self) {
        self.plain.act_and_score(black_box(&self.x), &mut self.y, &mut self.score);
        black_box((&self.y, &self.score));
    }
}
