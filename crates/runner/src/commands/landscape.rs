//! `itarl landscape`: how reward, task and information depend on a policy's parameters, on slices through
//! them.

use std::{fs, num::NonZero, path::Path, thread};

use ::landscape::{PrincipalPlane, blocks, random_direction};
use anyhow::{Context, ensure};

use super::{Outcome, print_line, subject::Subject};
use crate::{
    cli::Landscape,
    landscape::{
        Centre, Functions, How, Kind, Slice, Survey,
        tables::{self, Findings},
    },
    progress::{Counter, notify},
    training::StopSignal,
};
use runs::atomic;

pub(super) fn landscape(arguments: &Landscape) -> anyhow::Result<Outcome> {
    check(arguments)?;
    let survey = survey(arguments)?;
    let functions = survey
        .centres
        .iter()
        .map(|it| Functions::new(&it.experiment.reward, arguments.mix.as_deref(), &arguments.xi))
        .collect::<Result<Vec<_>, _>>()?;
    let stop = StopSignal::at_signals().context("catching signals")?;
    let counter = Counter::new(arguments.out.display().to_string());
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let how = How {
        threads: arguments.threads.map_or(cores, usize::from),
        solver: arguments.solver,
        lanes: arguments.lanes.map(usize::from),
    };
    let progress = |done, total| counter.report(done, total, "parts rolled out");
    if !survey.make(&functions, how, &|| stop.is_requested(), &progress)? {
        notify("stopped; the same command goes on");
        return Ok(Outcome::Stopped);
    }
    let findings = Findings::of(&survey, &functions, &|done, total| {
        counter.report(done, total, "slices measured");
    })?;
    counter.aside(|| findings.omitted.iter().for_each(notify));
    for (name, bytes) in tables::files(&survey, &findings)? {
        let path = arguments.out.join(name);
        atomic::write(&path, &bytes)?;
        counter.aside(|| print_line(path.display()))?;
    }
    Ok(if findings.omitted.is_empty() { Outcome::Done } else { Outcome::Failed })
}

fn check(arguments: &Landscape) -> anyhow::Result<()> {
    let Landscape { span, points, xi, .. } = arguments;
    ensure!(
        *span > 0.0 && *span <= 1e6,
        "--span must be more than 0 and at most 1000000, got {span}"
    );
    ensure!(
        points % 2 == 1,
        "--points must be odd, so that one is the policy itself, got {points}"
    );
    if let Some(xi) = xi.iter().find(|xi| !(0.0..=1.0).contains(*xi)) {
        anyhow::bail!("--xi must be from 0 to 1, got {xi}");
    }
    Ok(())
}

/// The cells with the slices that are asked for.
fn survey(arguments: &Landscape) -> anyhow::Result<Survey> {
    fs::create_dir_all(&arguments.out)
        .with_context(|| format!("{}: making it", arguments.out.display()))?;
    let mut survey = Survey {
        centres: Vec::new(),
        slices: Vec::new(),
        n_steps: arguments.steps,
        seed: arguments.seed,
        n_repeats: arguments.repeats.into(),
        n_gradients: arguments.gradients.into(),
        folder: arguments.out.clone(),
    };
    for folder in &arguments.cells {
        let (centre, blocks) = centre(folder)?;
        through(&mut survey, &centre, &blocks, arguments);
        survey.centres.push(centre);
    }
    if arguments.along_training {
        let path = along_training(&survey, arguments)?;
        survey.slices.push(path);
    }
    for pair in arguments.between.chunks_exact(2) {
        between(&mut survey, &pair[0], &pair[1], arguments.points.into())?;
    }
    Ok(survey)
}

/// The trained policy of a cell's folder, and its parameters by units.
fn centre(folder: &Path) -> anyhow::Result<(Centre, Vec<Vec<usize>>)> {
    let subject = Subject::open(folder)?;
    let Some((catalogue, cell)) = &subject.cell else {
        anyhow::bail!("{}: a cell's folder expected, which has a trained policy", folder.display())
    };
    catalogue.check(cell)?;
    let policy = subject.learned(&cell.folder.policy())?;
    let parameters = policy.parameters().to_vec();
    let links = policy.links();
    let links = links.iter().map(|link| (link.weight, link.biases[0]));
    let blocks = blocks(parameters.len(), links);
    let name = cell.cell.folder().display().to_string();
    let identity = cell.identity;
    let Subject { experiment, morphology, .. } = subject;
    Ok((Centre { name, experiment, morphology, parameters, identity }, blocks))
}

/// Lines and a map through a policy.
fn through(survey: &mut Survey, centre: &Centre, blocks: &[Vec<usize>], arguments: &Landscape) {
    let lines_by_default = if arguments.along_training { 0 } else { 2 };
    let (index, reach) = (survey.centres.len(), (arguments.points.into(), arguments.span));
    let Centre { name, parameters, .. } = centre;
    let direction =
        |what: &str| random_direction(parameters, blocks, survey.seed, &format!("{name} {what}"));
    let mut slices = Vec::new();
    for i in 1..=arguments.directions.unwrap_or(lines_by_default) {
        let what = format!("direction {i}");
        let direction = direction(&what);
        slices.push(Slice::line(format!("{name} {what}"), index, parameters, direction, reach));
    }
    if arguments.plane {
        let directions = ["plane 1", "plane 2"].map(direction);
        let about = (format!("{name} plane"), Kind::Plane);
        slices.push(Slice::plane(about, index, parameters, directions, reach));
    }
    survey.slices.extend(slices);
}

fn along_training(survey: &Survey, arguments: &Landscape) -> anyhow::Result<Slice> {
    let points: Vec<Vec<f64>> = survey.centres.iter().map(|it| it.parameters.clone()).collect();
    let same = points.windows(2).all(|pair| pair[0].len() == pair[1].len());
    ensure!(
        same,
        "--along-training: the cells must have the same policy, and theirs differ in size"
    );
    let plane = PrincipalPlane::of(&points)
        .context("--along-training: at least three cells expected that don't lie in a line")?;
    let last = survey.centres.len() - 1;
    let Centre { name, parameters, .. } = &survey.centres[last];
    notify(format_args!("the plane has {:.1} % of the path's extent", 100.0 * plane.share));
    let about = (format!("path to {name}"), Kind::Path);
    let reach = (arguments.points.into(), arguments.span);
    Ok(Slice::plane(about, last, parameters, plane.directions, reach))
}

/// A line from one cell's policy to another's, in the world of the first.
fn between(survey: &mut Survey, from: &Path, to: &Path, n: usize) -> anyhow::Result<()> {
    let [(from, _), (to, _)] = [centre(from)?, centre(to)?];
    ensure!(
        from.parameters.len() == to.parameters.len()
            && from.experiment.policy.kind == to.experiment.policy.kind
            && from.experiment.policy.coding == to.experiment.policy.coding,
        "--between: two cells with the same policy expected, and those of {} and {} differ",
        from.name,
        to.name
    );
    let name = format!("{} to {}", from.name, to.name);
    let ends = (from.parameters.clone(), to.parameters);
    // A cell that is there needn't be there twice.
    let known =
        survey.centres.iter().position(|it| it.name == from.name && it.identity == from.identity);
    let index = known.unwrap_or(survey.centres.len());
    if known.is_none() {
        survey.centres.push(from);
    }
    survey.slices.push(Slice::between(name, index, ends, n));
    Ok(())
}
