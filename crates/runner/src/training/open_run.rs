//! A run opened for work: its folder, its cells with their settings, their robots.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use anyhow::{Context, bail};
use config::Problems;
use runs::{Bullet, MODELS, NewRun, POLICIES, Precision, Run};
use svenja::Morphology;

use crate::{
    catalogue::{Catalogue, RunCell, identified},
    experiment::{Cell, Experiment, Plan, RobotSettings, absolute, policy_names},
    models, policies,
    session::{self, Session},
};

/// A run opened for work.
pub struct OpenRun {
    catalogue: Catalogue,
    /// As the cells count them.
    morphologies: Vec<Morphology>,
    /// The bytes of the files that policies start from, in the order of `manifest.json`.
    initial: Vec<Vec<u8>>,
}

/// The physics engine of this program.
#[must_use]
pub fn this_bullet() -> Bullet {
    let precision = if bullet::SCALAR_BYTES == 4 { Precision::Single } else { Precision::Double };
    Bullet { version: bullet::BULLET_VERSION, precision }
}

impl OpenRun {
    /// Begins the run of an experiment file in a folder, or opens the one that is there, if it has
    /// the same settings. More updates than it has extend it, and so do more cells.
    ///
    /// # Errors
    /// All that is wrong with the file and its models; another run in the folder.
    pub fn begin(plan: &Plan, folder: &Path) -> anyhow::Result<Self> {
        let files = Files::of(plan)?;
        files.check_settings(plan)?;
        let experiment = written(plan, &files.copies(), folder)?;
        let contents =
            |files: Vec<InputFile>| files.into_iter().map(|file| (file.name, file.bytes)).collect();
        let cell = |cell: &Cell| runs::Cell {
            index: cell.index,
            setting: cell.setting.clone(),
            seed: cell.seed,
        };
        let new = NewRun {
            experiment,
            itarl: env!("CARGO_PKG_VERSION").into(),
            bullet: this_bullet(),
            models: contents(files.models),
            policies: contents(files.policies),
            seeds: plan.seeds().to_vec(),
            cells: plan.cells().iter().map(cell).collect(),
        };
        let run = match Run::create(folder, &new) {
            Err(differs @ runs::Error::Differs { .. }) => grown(folder, &new)?.ok_or(differs)?,
            run => run?,
        };
        Self::of(run)?.extended(&new.experiment)
    }

    /// Opens a run that is there; `updates` extends it.
    ///
    /// # Errors
    /// What isn't a run, a damaged one, or one of another Bullet; updates out of range, fewer than
    /// the run has, or of a run that sweeps them.
    pub fn open(folder: &Path, updates: Option<u64>) -> anyhow::Result<Self> {
        let open_run = Self::of(Run::open(folder)?)?;
        let Some(updates) = updates else { return Ok(open_run) };
        let run = open_run.run();
        let plan = Plan::extended(&run.experiment_path(), run.experiment(), updates)?;
        let name = |folder, copy: &runs::FileCopy| format!("{folder}/{}", copy.file);
        let models = run.manifest().models.iter().map(|copy| name(MODELS, copy));
        let policies = run.manifest().policies.iter().map(|copy| name(POLICIES, copy));
        let paths = models::paths(run).into_iter().chain(policies::paths(run));
        let experiment = written(&plan, &paths.zip(models.chain(policies)).collect(), folder)?;
        open_run.extended(&experiment)
    }

    /// With more updates, where this text of the same experiment has more.
    fn extended(self, experiment: &str) -> anyhow::Result<Self> {
        let mut run = self.run().clone();
        run.extend(experiment)?;
        if run.experiment() == self.run().experiment() { Ok(self) } else { Self::of(run) }
    }

    fn of(run: Run) -> anyhow::Result<Self> {
        run.require_unpublished()?;
        run.require(this_bullet())?;
        let catalogue = Catalogue::of(run)?;
        let morphologies = catalogue.morphologies()?;
        let initial = policies::read(catalogue.run())?;
        Ok(Self { catalogue, morphologies, initial })
    }

    /// The run with its cells.
    #[must_use]
    pub fn catalogue(&self) -> &Catalogue {
        &self.catalogue
    }

    /// The run's folder.
    #[must_use]
    pub fn run(&self) -> &Run {
        self.catalogue.run()
    }

    /// All cells, by index.
    #[must_use]
    pub fn cells(&self) -> &[RunCell] {
        self.catalogue.cells()
    }

    /// The robot of a cell.
    #[must_use]
    pub fn morphology(&self, cell: &RunCell) -> &Morphology {
        &self.morphologies[cell.robot]
    }

    /// A cell that hasn't moved yet.
    ///
    /// # Errors
    /// As [`Session::build`].
    pub fn session(&self, cell: &RunCell) -> Result<Session, session::Error> {
        let initial = cell.initial.map(|index| self.initial[index].as_slice());
        Session::build(&cell.cell.experiment, self.morphology(cell), initial, cell.cell.seed)
    }
}

/// The run of a folder with more cells, if `new` has all that it has, with the same settings; none if it
/// isn't so.
fn grown(folder: &Path, new: &NewRun) -> anyhow::Result<Option<Run>> {
    let wanted = new.manifest(folder)?;
    let plan = Plan::written(&folder.join("experiment.toml"), &new.experiment)?;
    let wanted = identified(folder, &plan, &wanted).map_err(anyhow::Error::msg)?;
    loop {
        let there = Catalogue::open(folder)?;
        let stays = |cell: &RunCell| {
            let here = wanted.get(&(cell.cell.setting.clone(), cell.cell.seed));
            here.is_some_and(|here| here.identity == cell.identity)
        };
        if !there.cells().iter().all(stays) || there.run().require(this_bullet()).is_err() {
            return Ok(None);
        }
        if there.run().grow(new)? {
            return Ok(Some(Run::open(folder)?));
        }
        // Another process was faster.
        if let Ok(run) = Run::create(folder, new) {
            return Ok(Some(run));
        }
    }
}

/// That the files which a plan names can be read.
///
/// # Errors
/// All that is wrong with them.
pub fn check_files(plan: &Plan) -> anyhow::Result<()> {
    Files::of(plan).map(drop)
}

/// The files that a plan names, each once.
#[derive(Default)]
struct Files {
    models: Vec<InputFile>,
    policies: Vec<InputFile>,
}

struct InputFile {
    /// As the plan has it.
    path: String,
    /// Of the copy in the run folder.
    name: String,
    bytes: Vec<u8>,
}

impl Files {
    /// Reads them, and finds all problems at once.
    fn of(plan: &Plan) -> anyhow::Result<Self> {
        let (mut files, mut problems) = (Self::default(), BTreeSet::new());
        for (path, robots) in robots(plan) {
            match copied(path, &robots) {
                Ok(file) => files.models.push(file),
                Err(found) => problems.extend(Vec::from(found)),
            }
        }
        let names = policy_names(plan.cells().iter().filter_map(|cell| cell.experiment.initial()));
        let mut known = BTreeSet::new();
        for path in plan.cells().iter().filter_map(|cell| cell.experiment.initial()) {
            if !known.insert(path) {
                continue;
            }
            match policies::open(path) {
                Ok(bytes) => {
                    let name = format!("{}.safetensors", names[path]);
                    files.policies.push(InputFile { path: path.into(), name, bytes });
                }
                Err(found) => problems.extend(Vec::from(found)),
            }
        }
        match problems.is_empty() {
            true => Ok(files),
            false => Err(Problems::new(problems.into_iter().collect()).into()),
        }
    }

    /// That each setting's cells can be built.
    fn check_settings(&self, plan: &Plan) -> anyhow::Result<()> {
        let mut last: Option<&Experiment> = None;
        for Cell { experiment, setting, seed, .. } in plan.cells() {
            if last.is_some_and(|last| last == experiment) {
                continue;
            }
            let morphology = models::open(experiment)?;
            let initial =
                self.policies.iter().find(|it| Some(it.path.as_str()) == experiment.initial());
            let initial = initial.map(|file| file.bytes.as_slice());
            Session::build(experiment, &morphology, initial, *seed)
                .with_context(|| format!("setting {setting}"))?;
            last = Some(experiment);
        }
        Ok(())
    }

    /// Where the copies are in a run folder, by the paths of the plan.
    fn copies(&self) -> BTreeMap<String, String> {
        let copies = |folder: &'static str, files: &[InputFile]| {
            let copy = |file: &InputFile| (file.path.clone(), format!("{folder}/{}", file.name));
            files.iter().map(copy).collect::<Vec<_>>()
        };
        let all = [copies(MODELS, &self.models), copies(POLICIES, &self.policies)];
        all.into_iter().flatten().collect()
    }
}

/// The model files that a plan names, each with the different robots that are made of it, in the order
/// of the cells.
fn robots(plan: &Plan) -> Vec<(&str, Vec<&RobotSettings>)> {
    let (mut robots, mut known) = (Vec::<(&str, Vec<_>)>::new(), BTreeSet::new());
    for Cell { experiment, .. } in plan.cells() {
        if !known.insert(models::key(experiment)) {
            continue;
        }
        match robots.iter_mut().find(|(path, _)| *path == experiment.model) {
            Some((_, robots)) => robots.push(&experiment.robot),
            None => robots.push((&experiment.model, vec![&experiment.robot])),
        }
    }
    robots
}

fn copied(path: &str, robots: &[&RobotSettings]) -> Result<InputFile, Problems> {
    let bytes = models::copied(Path::new(path), robots)?.into_bytes();
    // Stems differ, or cells would share a folder.
    let stem = Path::new(path).file_stem().unwrap_or_default().to_string_lossy();
    Ok(InputFile { path: path.into(), name: format!("{stem}.toml"), bytes })
}

/// The plan's text for a run folder that has copies of its files, by their paths in the plan. It has
/// been read again, and gives the same cells.
fn written(
    plan: &Plan,
    copies: &BTreeMap<String, String>,
    folder: &Path,
) -> anyhow::Result<String> {
    let copy = |path: &str| copies.get(path).map_or(path, String::as_str).to_owned();
    let text = plan.to_toml_with(copy);
    let again = Plan::written(&folder.join("experiment.toml"), &text);
    let same = |(cell, again): (&Cell, &Cell)| {
        let experiment =
            cell.experiment.clone().with_files(|path| absolute(&folder.join(copy(path))));
        *again == Cell { experiment, ..cell.clone() }
    };
    let cells = plan.cells();
    match again {
        Ok(again)
            if again.cells().len() == cells.len() && cells.iter().zip(again.cells()).all(same) =>
        {
            Ok(text)
        }
        _ => bail!(
            "{}: nothing was written, since read again it would be another experiment; that's a \
             mistake in itarl: please report it, with the experiment file",
            folder.display()
        ),
    }
}
