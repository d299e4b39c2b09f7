//! `itarl bench`: what the training loop takes, on one core.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use anyhow::Context;
use svenja::Morphology;

use super::{Outcome, say};
use crate::{
    cli::Bench,
    experiment::{Experiment, Plan},
    session::Session,
};

/// The paper's settings with its robot, which the program carries with it.
const SVENJA: &str = include_str!("../../../../models/svenja.toml");

pub(super) fn bench(arguments: &Bench) -> anyhow::Result<Outcome> {
    let (experiment, morphology) = match &arguments.file {
        Some(file) => from_file(file)?,
        None => {
            let experiment = config::Document::parse("defaults", "model = 'svenja.toml'")?
                .read(Experiment::read)?;
            (experiment, Morphology::parse("models/svenja.toml", SVENJA)?)
        }
    };
    let mut session = Session::start(&experiment, &morphology, 1)?;
    let length = Duration::try_from_secs_f64(arguments.seconds)
        .context("--seconds must be a length of time, as in --seconds 10")?;
    let before = session.times();
    let start = Instant::now();
    let mut steps = 0;
    while steps == 0 || start.elapsed() < length {
        session.update()?;
        steps += experiment.learning.steps_per_update;
    }
    let total = start.elapsed();
    let [physics, policy] = session.times();
    let (physics, policy) = (physics - before[0], policy - before[1]);
    say(format_args!("{:.0} control steps/s", steps as f64 / total.as_secs_f64()))?;
    let parts = [("physics", physics), ("policy", policy), ("rest", total - physics - policy)];
    for (name, time) in parts {
        let microseconds = 1e6 * time.as_secs_f64() / steps as f64;
        let share = 100.0 * time.as_secs_f64() / total.as_secs_f64();
        say(format_args!("{name:8} {microseconds:8.1} us a control step, {share:4.1} %"))?;
    }
    say("solver: Bullet's own, 1.00 times --solver bullet (there is no other yet)")?;
    Ok(Outcome::Done)
}

/// The first cell of an experiment file.
fn from_file(file: &Path) -> anyhow::Result<(Experiment, Morphology)> {
    let plan = Plan::open(file, &[])?;
    let cell = plan.cells().first().context("no cells")?;
    let morphology = Morphology::open(Path::new(&cell.experiment.model))?;
    Ok((cell.experiment.clone(), morphology))
}
