//! Run folders put together into one: the cells of all of them, as they are.
//!
//! The new run's experiment sweeps what any of them sweeps. Each cell must be in it what it was: the
//! same setting and seed with the same identity, so that its checkpoint is its own there, too.

use std::{collections::BTreeMap, path::Path};

use anyhow::{Context, bail};
use runs::{CellFolder, Lock, MODELS, NewRun, POLICIES, Run, atomic};

use crate::{
    catalogue::{Catalogue, RunCell, identified},
    experiment::Plan,
    training::this_bullet,
};

/// What became of a merge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Merged {
    /// Cells of the new run.
    pub cells: usize,
    /// Those of them that one of the runs had begun.
    pub begun: usize,
}

/// Puts runs together in a new folder, or in one where that was begun.
///
/// # Errors
/// What isn't a run; runs that differ in anything but what they sweep; a cell that another process is
/// at, that is damaged, or that two runs have with other bytes. What was copied by then stays, and the
/// same call goes on.
pub fn merge(folders: &[&Path], out: &Path) -> anyhow::Result<Merged> {
    let runs = folders.iter().map(|it| Catalogue::open(it)).collect::<Result<Vec<_>, _>>()?;
    for catalogue in &runs {
        catalogue.run().require(this_bullet())?;
    }
    let new = new_run(&runs, out)?;
    let manifest = new.manifest(out)?;
    let plan = Plan::written(&out.join("experiment.toml"), &new.experiment)?;
    let cells = identified(out, &plan, &manifest).map_err(anyhow::Error::msg)?;
    let find = |cell: &RunCell| cells.get(&(cell.cell.setting.clone(), cell.cell.seed));
    for catalogue in &runs {
        for cell in catalogue.cells() {
            if find(cell).is_none_or(|it| it.identity != cell.identity) {
                return Err(contradiction(&runs[0], catalogue, cell)?);
            }
        }
    }
    Run::create(out, &new)?;
    for catalogue in &runs {
        for cell in catalogue.cells().iter().filter(|cell| cell.folder.path().exists()) {
            if let Some(to) = find(cell) {
                copy(catalogue, cell, &to.folder)?;
            }
        }
    }
    let begun = cells.values().filter(|cell| cell.folder.metrics().exists()).count();
    Ok(Merged { cells: cells.len(), begun })
}

/// Why a cell can't be in one run with those of another.
fn contradiction(
    first: &Catalogue,
    other: &Catalogue,
    cell: &RunCell,
) -> anyhow::Result<anyhow::Error> {
    let path = other.run().folder().to_path_buf();
    let differences = first.run().differences(other.run())?;
    if !differences.is_empty() {
        return Ok(runs::Error::Differs { path, differences }.into());
    }
    let (cell, first) = (cell.folder.path().display(), first.run().folder().display());
    Ok(anyhow::anyhow!("{cell}: it wouldn't be the same cell in one run with {first}"))
}

fn new_run(catalogues: &[Catalogue], out: &Path) -> anyhow::Result<NewRun> {
    let first = catalogues.first().context("no runs to merge")?;
    let (mut plans, mut models, mut policies) = (Vec::new(), BTreeMap::new(), BTreeMap::new());
    for catalogue in catalogues {
        let run = catalogue.run();
        let mut names = BTreeMap::new();
        for (copy, path) in run.manifest().models.iter().zip(crate::models::paths(run)) {
            add(&mut models, &copy.file, run.model(copy)?.into_bytes(), run)?;
            names.insert(path, format!("{MODELS}/{}", copy.file));
        }
        for (copy, path) in run.manifest().policies.iter().zip(crate::policies::paths(run)) {
            add(&mut policies, &copy.file, run.policy(copy)?, run)?;
            names.insert(path, format!("{POLICIES}/{}", copy.file));
        }
        let name = |path: &str| names.get(path).map_or(path, String::as_str).to_owned();
        plans.push(catalogue.plan().clone().with_files(name));
    }
    let Some(experiment) = Plan::merged(&plans) else {
        bail!("{}: the runs don't sweep the same keys in the same order", out.display());
    };
    let plan = Plan::written(&out.join("experiment.toml"), &experiment)?;
    let cell = |cell: &crate::experiment::Cell| runs::Cell {
        index: cell.index,
        setting: cell.setting.clone(),
        seed: cell.seed,
    };
    Ok(NewRun {
        experiment,
        itarl: env!("CARGO_PKG_VERSION").into(),
        bullet: first.run().manifest().bullet,
        models: models.into_iter().collect(),
        policies: policies.into_iter().collect(),
        seeds: plan.seeds().to_vec(),
        cells: plan.cells().iter().map(cell).collect(),
    })
}

/// A file that runs must have alike, by its name.
fn add(
    files: &mut BTreeMap<String, Vec<u8>>,
    name: &str,
    bytes: Vec<u8>,
    run: &Run,
) -> anyhow::Result<()> {
    match files.get(name) {
        Some(other) if *other != bytes => {
            bail!("{}: its {name} isn't that of the others", run.folder().display())
        }
        Some(_) => {}
        None => drop(files.insert(name.into(), bytes)),
    }
    Ok(())
}

/// A cell's files, in the order in which they're written by training: killed in between, what is there
/// is a cell to go on with, and the same call makes it whole.
fn copy(catalogue: &Catalogue, cell: &RunCell, to: &CellFolder) -> anyhow::Result<()> {
    let _lock = Lock::acquire(&cell.folder.lock())?;
    catalogue.expecting(cell, |expected| cell.folder.whole(expected))?;
    runs::make_folder(to.path())?;
    let _there = Lock::acquire(&to.lock())?;
    let paths =
        |it: &CellFolder| [it.metrics(), it.checkpoint(), it.policy(), it.replay(), it.failed()];
    let files = paths(&cell.folder).into_iter().zip(paths(to));
    let mut missing = Vec::new();
    for (from, to) in files {
        let (from, there) = (atomic::read(&from)?, atomic::read(&to)?);
        match (from, there) {
            (Some(bytes), None) => missing.push((to, bytes)),
            (from, there) if from != there => bail!(
                "{}: two of the runs have this cell with other bytes: which is meant?",
                to.display()
            ),
            _ => {}
        }
    }
    missing.iter().try_for_each(|(path, bytes)| Ok(atomic::write(path, bytes)?))
}
