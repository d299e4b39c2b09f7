//! `itarl bench`: what the training loop takes on one core, in lanes and with Bullet's own solver.
//!
//! Both take turns, a block of control steps each, in one process: machines are shared, and only
//! ratios of neighbouring blocks mean something. For the machine's mode, by load and by clock, the
//! time of a step of Bullet's own stands.

mod batch;
mod table;

use std::{
    path::Path,
    time::{Duration, Instant},
};

use anyhow::{Context, bail};
use serde::Serialize;
use svenja::Morphology;

use self::batch::{Batch, Speed};
use super::{Outcome, json::print_json, print_line};
use crate::{
    cli::Bench,
    experiment::{Experiment, Plan},
    models, policies,
    session::{Session, Solver},
};

/// The paper's settings with its robot, which the program carries with it.
const SVENJA: &str = include_str!("../../../../../models/svenja.toml");

pub(super) fn bench(arguments: &Bench) -> anyhow::Result<Outcome> {
    let seconds = arguments.seconds.unwrap_or(if arguments.table { 2.0 } else { 10.0 });
    let length = Duration::try_from_secs_f64(seconds)
        .context("--seconds must be a length of time, as in --seconds 10")?;
    if arguments.table {
        return table::table(arguments, length);
    }
    let (experiment, morphology) = match &arguments.files[..] {
        [] => papers()?,
        [file] => from_file(file)?,
        _ => bail!("several files are measured with --table"),
    };
    let lockstep = Solver::lockstep()?;
    let lanes = arguments.lanes.map_or(lockstep.lanes(), usize::from);
    let n_cells = lanes.div_ceil(experiment.learning.worlds);
    let mut in_lanes = Batch::begin(lockstep, sessions(&experiment, &morphology, n_cells)?)?;
    let mut alone = Batch::begin(Solver::bullet(), sessions(&experiment, &morphology, 1)?)?;
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

/// Cells with the seeds from 1 on.
fn sessions(
    experiment: &Experiment,
    morphology: &Morphology,
    n: usize,
) -> anyhow::Result<Vec<Session>> {
    let initial = experiment.initial().map(policies::open).transpose()?;
    let build = |seed| Ok(Session::build(experiment, morphology, initial.as_deref(), seed)?);
    (1..=n as u64).map(build).collect()
}

/// The paper's settings, with Svenja.
fn papers() -> anyhow::Result<(Experiment, Morphology)> {
    papers_with("")
}

/// The paper's settings but for some lines.
fn papers_with(lines: &str) -> anyhow::Result<(Experiment, Morphology)> {
    let text = format!("model = 'svenja.toml'\n{lines}");
    let experiment = config::Document::parse("defaults", &text)?.read(Experiment::read)?;
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

/// The first cell of an experiment file.
fn from_file(file: &Path) -> anyhow::Result<(Experiment, Morphology)> {
    let plan = Plan::open(file, &[])?;
    let cell = plan.cells().first().context("no cells")?;
    let morphology = models::open(&cell.experiment)?;
    Ok((cell.experiment.clone(), morphology))
}
