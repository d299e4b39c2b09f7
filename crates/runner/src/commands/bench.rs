//! `itarl bench`: what the training loop takes on one core, in lanes and with Bullet's own solver.
//!
//! Both take turns, a block of control steps each, in one process: machines are shared, and only
//! ratios of neighbouring blocks mean something. For the machine's mode, by load and by clock, the
//! time of a step of Bullet's own stands.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use anyhow::Context;
use serde::Serialize;
use svenja::Morphology;

use super::{Outcome, json::print_json, print_line};
use crate::{
    cli::Bench,
    experiment::{Experiment, Plan},
    models, policies,
    session::{Session, Solver, control_step},
};

/// The paper's settings with its robot, which the program carries with it.
const SVENJA: &str = include_str!("../../../../models/svenja.toml");

/// Control steps in a row.
const BLOCK: u64 = 10;

pub(super) fn bench(arguments: &Bench) -> anyhow::Result<Outcome> {
    let (experiment, morphology) = arguments.file.as_deref().map_or_else(papers, from_file)?;
    let initial = experiment.initial().map(policies::open).transpose()?;
    let length = Duration::try_from_secs_f64(arguments.seconds)
        .context("--seconds must be a length of time, as in --seconds 10")?;
    let lockstep = Solver::lockstep()?;
    let lanes = arguments.lanes.map_or(lockstep.lanes(), usize::from);
    let sessions = |n| {
        (1..=n as u64)
            .map(|seed| Session::build(&experiment, &morphology, initial.as_deref(), seed))
            .collect::<Result<Vec<_>, _>>()
    };
    let n_cells = lanes.div_ceil(experiment.learning.worlds);
    let mut in_lanes = Batch::begin(lockstep, sessions(n_cells)?)?;
    let mut alone = Batch::begin(Solver::bullet(), sessions(1)?)?;
    let ratio = compare(&mut in_lanes, &mut alone, length)?;
    let physics_steps = experiment.physics_steps_per_control_step() as f64;
    let bullet_step_us = 1e6 * alone.physics.as_secs_f64() / (alone.steps as f64 * physics_steps);
    let instructions = in_lanes.solver.instructions().map_or("", bullet::Instructions::name);
    if arguments.print.json {
        print_json(
            "bench",
            Report {
                cells: n_cells,
                instructions,
                ratio,
                in_lanes: in_lanes.speed(),
                bullet: alone.speed(),
                bullet_step_us,
            },
        )?;
        return Ok(Outcome::Done);
    }
    print_line(format_args!(
        "{:.0} control steps/s with {n_cells} cells in lanes ({instructions}), {:.0} with --solver \
         bullet: {:.2} times as many",
        in_lanes.rate(),
        alone.rate(),
        ratio
    ))?;
    in_lanes.report("in lanes")?;
    in_lanes.report_parts(physics_steps)?;
    alone.report("with --solver bullet")?;
    print_line(format_args!(
        "the machine's mode: {bullet_step_us:.0} us for a physics step of Bullet's own"
    ))?;
    Ok(Outcome::Done)
}

/// How many times as fast the first is, in the median of blocks by turns: the machine may change its
/// mode.
fn compare(ours: &mut Batch, theirs: &mut Batch, length: Duration) -> anyhow::Result<f64> {
    let mut ratios = Vec::new();
    let start = Instant::now();
    while ratios.is_empty() || start.elapsed() < length {
        let (our_time, their_time) = (ours.run()?, theirs.run()?);
        ratios.push(their_time / our_time);
    }
    ratios.sort_by(f64::total_cmp);
    Ok(ratios[ratios.len() / 2])
}

/// The paper's settings, with Svenja.
fn papers() -> anyhow::Result<(Experiment, Morphology)> {
    let experiment =
        config::Document::parse("defaults", "model = 'svenja.toml'")?.read(Experiment::read)?;
    Ok((experiment, Morphology::parse("models/svenja.toml", SVENJA)?))
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report<'a> {
    cells: usize,
    /// Of the lanes; empty where there are none.
    instructions: &'a str,
    /// How many times as fast lanes are, in the median of neighbouring blocks.
    ratio: f64,
    in_lanes: Speed,
    bullet: Speed,
    /// A physics step of Bullet's own: the machine's mode.
    bullet_step_us: f64,
}

/// What a control step of a world takes.
#[derive(Serialize)]
struct Speed {
    control_steps_per_second: f64,
    physics_us: f64,
    policy_us: f64,
    rest_us: f64,
}

/// Cells that are stepped together, and what that took.
struct Batch {
    solver: Solver,
    sessions: Vec<Session>,
    /// Control steps of all worlds: those measured, and those with the ones in which they settled.
    steps: u64,
    all_steps: u64,
    total: Duration,
    physics: Duration,
    policy: Duration,
}

impl Batch {
    fn begin(solver: Solver, sessions: Vec<Session>) -> anyhow::Result<Self> {
        let mut batch = Self {
            solver,
            sessions,
            steps: 0,
            all_steps: 0,
            total: Duration::ZERO,
            physics: Duration::ZERO,
            policy: Duration::ZERO,
        };
        while batch.sessions.iter().any(Session::is_settling) {
            batch.step()?;
        }
        Ok(batch)
    }

    fn step(&mut self) -> anyhow::Result<()> {
        let mut sessions: Vec<&mut Session> = self.sessions.iter_mut().collect();
        for result in control_step(&mut sessions, &mut self.solver) {
            result?;
        }
        for session in &mut self.sessions {
            if session.is_to_learn() {
                session.learn()?;
            }
        }
        self.all_steps += self.worlds();
        Ok(())
    }

    fn worlds(&self) -> u64 {
        self.sessions.iter().map(|session| session.worlds() as u64).sum()
    }

    fn policy_time(&self) -> Duration {
        self.sessions.iter().map(Session::policy_time).sum()
    }

    /// A block; seconds for a control step of a world.
    fn run(&mut self) -> anyhow::Result<f64> {
        let (start, physics, policy) = (Instant::now(), self.solver.time(), self.policy_time());
        for _ in 0..BLOCK {
            self.step()?;
        }
        let time = start.elapsed();
        let steps = BLOCK * self.worlds();
        self.steps += steps;
        self.total += time;
        self.physics += self.solver.time() - physics;
        self.policy += self.policy_time() - policy;
        Ok(time.as_secs_f64() / steps as f64)
    }

    fn rate(&self) -> f64 {
        self.steps as f64 / self.total.as_secs_f64()
    }

    fn speed(&self) -> Speed {
        let us = |time: Duration| 1e6 * time.as_secs_f64() / self.steps as f64;
        Speed {
            control_steps_per_second: self.rate(),
            physics_us: us(self.physics),
            policy_us: us(self.policy),
            rest_us: us(self.total - self.physics - self.policy),
        }
    }

    fn report(&self, name: &str) -> anyhow::Result<()> {
        print_line(format_args!("{name}:"))?;
        let rest = self.total - self.physics - self.policy;
        for (name, time) in [("physics", self.physics), ("policy", self.policy), ("rest", rest)] {
            let microseconds = 1e6 * time.as_secs_f64() / self.steps as f64;
            let share = 100.0 * time.as_secs_f64() / self.total.as_secs_f64();
            print_line(format_args!(
                "  {name:8} {microseconds:8.1} us a control step, {share:4.1} %"
            ))?;
        }
        Ok(())
    }

    /// Where a physics step goes that is made in lanes, without the servo law.
    fn report_parts(&self, physics_steps: f64) -> anyhow::Result<()> {
        let times = self.solver.times();
        let parts = [
            ("begin", times.begin),
            ("pack", times.pack),
            ("sweep", times.sweep),
            ("unpack", times.unpack),
            ("end", times.end),
        ];
        for (name, seconds) in parts {
            let time = 1e6 * seconds / (self.all_steps as f64 * physics_steps);
            print_line(format_args!("    {name:6} {time:8.1} us a physics step"))?;
        }
        Ok(())
    }
}

/// The first cell of an experiment file.
fn from_file(file: &Path) -> anyhow::Result<(Experiment, Morphology)> {
    let plan = Plan::open(file, &[])?;
    let cell = plan.cells().first().context("no cells")?;
    let morphology = models::open(&cell.experiment)?;
    Ok((cell.experiment.clone(), morphology))
}
