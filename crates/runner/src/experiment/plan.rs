//! An experiment file as a whole: its cells, in a stable order.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use config::{Document, MOST_PROBLEMS, Node, Place, Problem, Problems, Value};
use toml::Table;

use super::{Experiment, axis::Point, files, leaves, sweep::Sweep, twice::twice};
use crate::models;

/// All that an experiment file says.
///
/// Two plans are equal if they train the same cells in the same order.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Swept keys with their values, in the order of the file.
    axes: Vec<(String, Vec<toml::Value>)>,
    seeds: Vec<u64>,
    cells: Vec<Cell>,
    warnings: Vec<Problem>,
}

impl PartialEq for Plan {
    fn eq(&self, other: &Self) -> bool {
        (&self.axes, &self.seeds, &self.cells) == (&other.axes, &other.seeds, &other.cells)
    }
}

/// One training instance.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Its place among all of a file.
    pub index: usize,
    /// What sets it apart from the others, `xi=0.75,power=2`; `base` where nothing is swept.
    pub setting: String,
    /// The seed that its random numbers come from.
    pub seed: u64,
    /// All other settings.
    pub experiment: Experiment,
}

impl Cell {
    /// Its folder in a run's `cells`: `xi=0.75/seed=3`.
    #[must_use]
    pub fn folder(&self) -> PathBuf {
        [self.setting.clone(), format!("seed={}", self.seed)].iter().collect()
    }
}

impl Plan {
    /// Reads a file, with overrides from the command line, each as in `learning.rate=0.3`.
    ///
    /// Paths are from the file's folder, in overrides from the current one; a plan has them absolute.
    ///
    /// # Errors
    /// All that is wrong with the file and the overrides, each with its place.
    pub fn open(path: &Path, overrides: &[String]) -> Result<Self, Problems> {
        Self::changed(Document::open(path)?, path, overrides)
    }

    /// The paper's settings with a robot, with overrides as of [`Plan::open`]. Without sensors it has a
    /// reward without information.
    ///
    /// # Errors
    /// All that is wrong with the robot, or with the overrides.
    pub fn of_model(model: &Path, overrides: &[String]) -> Result<Self, Problems> {
        let defaults = models::defaults(model, &models::open_model(model)?);
        Self::changed(Document::parse("defaults", &defaults)?, Path::new(""), overrides)
    }

    fn changed(
        mut document: Document,
        path: &Path,
        overrides: &[String],
    ) -> Result<Self, Problems> {
        let mut problems = Vec::new();
        for assignment in overrides {
            if let Err(found) = document.set("--set", assignment) {
                problems.extend(Vec::from(found));
            }
        }
        let (sweep, plan) = Self::read(document, path, problems)?;
        let twice = twice(&sweep, &plan.cells);
        if twice.is_empty() { Ok(plan) } else { Err(Problems::new(twice)) }
    }

    /// Reads the text of a run's own file at `path`, which was accepted when the run began.
    ///
    /// # Errors
    /// All that is wrong with it.
    pub fn written(path: &Path, text: &str) -> Result<Self, Problems> {
        let document = Document::parse(&path.display().to_string(), text)?;
        Ok(Self::read(document, path, Vec::new())?.1)
    }

    /// As [`Plan::written`], with another number of updates, which `--updates` asked for.
    ///
    /// # Errors
    /// Likewise; a number out of range, and any number where `learning.updates` is swept.
    pub fn extended(path: &Path, text: &str, updates: u64) -> Result<Self, Problems> {
        let mut document = Document::parse(&path.display().to_string(), text)?;
        let place = Place::whole(&format!("--updates {updates}"));
        document.set_value(&place, "learning.updates", &updates.to_string())?;
        Ok(Self::read(document, path, Vec::new())?.1)
    }

    fn read(
        mut document: Document,
        path: &Path,
        mut problems: Vec<Problem>,
    ) -> Result<(Sweep, Self), Problems> {
        let folder = path.parent().unwrap_or(path);
        for key in files::KEYS {
            // A list isn't a path, and is refused as it is.
            let found = document.get(key).filter(|node| matches!(node.value, Value::Text(_)));
            if let Some(mut path) = found.cloned() {
                files::make_absolute(key, &mut path, folder);
                document.replace(key, &path.place.clone(), path)?;
            }
        }
        let mut swept = document.take("sweep");
        if let Some(swept) = &mut swept {
            files::make_absolute("", swept, folder);
        }
        let sweep = Sweep::read(swept.as_ref(), &mut problems);
        sweep.check_against(&document, &mut problems);
        let plan = Self::of(&document, &sweep, problems)?;
        Ok((sweep, plan))
    }

    fn of(document: &Document, sweep: &Sweep, problems: Vec<Problem>) -> Result<Self, Problems> {
        let combinations: Box<dyn Iterator<Item = _>> = match problems.is_empty() {
            true => Box::new(sweep.combinations()),
            false => Box::new(sweep.one_by_one()),
        };
        let (mut problems, mut warnings) = (BTreeSet::from_iter(problems), BTreeSet::new());
        let mut cells = Vec::new();
        for points in combinations {
            let mut document = document.clone();
            sweep.put(&points, &mut document, &mut problems);
            let read = document.read(|root| {
                root.mention("sweep");
                Experiment::read(root)
            });
            match read {
                Ok(experiment) => {
                    warnings.extend(experiment.codec.warning(&document));
                    let setting = sweep.name(&points);
                    for &seed in &sweep.seeds {
                        let (setting, experiment) = (setting.clone(), experiment.clone());
                        cells.push(Cell { index: cells.len(), setting, seed, experiment });
                    }
                }
                Err(found) => problems.extend(Vec::from(found)),
            }
            if problems.len() > MOST_PROBLEMS {
                break;
            }
        }
        if !problems.is_empty() {
            return Err(Problems::new(problems.into_iter().collect()));
        }
        let values =
            |points: &[Point]| points.iter().map(|point| toml_value(&point.node.value)).collect();
        let axes = sweep.axes.iter().map(|axis| (axis.key.clone(), values(&axis.points)));
        Ok(Self {
            axes: axes.collect(),
            seeds: sweep.seeds.clone(),
            cells,
            warnings: warnings.into_iter().collect(),
        })
    }

    /// What is allowed, and most likely not what is meant: each with its place and what to do.
    #[must_use]
    pub fn warnings(&self) -> &[Problem] {
        &self.warnings
    }

    /// All cells: for each combination of swept values, the first key slowest, all seeds.
    #[must_use]
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The seeds that each setting is trained with.
    #[must_use]
    pub fn seeds(&self) -> &[u64] {
        &self.seeds
    }

    /// Index, setting and seed of every cell.
    pub fn listing(&self) -> impl Iterator<Item = (usize, &str, u64)> + '_ {
        self.cells.iter().map(|cell| (cell.index, cell.setting.as_str(), cell.seed))
    }

    /// The complete file: all settings that the cells share, and the sweep. Defaults that depend on
    /// what is swept are left out. Opened again it gives an equal plan.
    #[must_use]
    pub fn to_toml(&self) -> String {
        self.to_toml_with(str::to_owned)
    }

    /// The complete file, with other paths for its files.
    #[must_use]
    pub fn to_toml_with(&self, other: impl Fn(&str) -> String) -> String {
        let renamed = |key: &str, value| files::with_paths(key, value, &other);
        let mut file = Table::new();
        for (key, value) in self.shared() {
            let value = renamed(&key, value);
            leaves::put(&mut file, &key, value);
        }
        let mut text = format!("{file}\n[sweep]\n");
        for (key, values) in &self.axes {
            let values: Vec<_> =
                values.iter().map(|value| leaves::inline(&renamed(key, value.clone()))).collect();
            // Tables are long.
            let list = match values.iter().any(|value| value.starts_with('{')) {
                true => format!("[\n    {},\n]", values.join(",\n    ")),
                false => format!("[{}]", values.join(", ")),
            };
            text += &format!("{} = {list}\n", leaves::key(key));
        }
        text + &format!("seeds = {}\n", self.seeds_value())
    }

    /// As it is with other paths for its files.
    #[must_use]
    pub fn with_files(mut self, other: impl Fn(&str) -> String) -> Self {
        for cell in &mut self.cells {
            cell.experiment = cell.experiment.clone().with_files(&other);
        }
        for (key, values) in &mut self.axes {
            for value in values {
                *value = files::with_paths(key, value.clone(), &other);
            }
        }
        self
    }

    /// The complete file of one that has the cells of several plans: all that any of them sweeps, each
    /// combined with each, and the most updates. None if they don't sweep the same keys.
    #[must_use]
    pub fn merged(plans: &[Self]) -> Option<String> {
        let mut merged = plans.first()?.clone();
        for plan in &plans[1..] {
            let keys =
                |plan: &Self| plan.axes.iter().map(|(key, _)| key.clone()).collect::<Vec<_>>();
            if keys(plan) != keys(&merged) {
                return None;
            }
            for ((_, values), (_, more)) in merged.axes.iter_mut().zip(&plan.axes) {
                let new: Vec<_> = more.iter().filter(|it| !values.contains(it)).cloned().collect();
                values.extend(new);
            }
            merged.seeds.extend(&plan.seeds);
            merged.cells.extend(plan.cells.iter().cloned());
        }
        merged.seeds.sort_unstable();
        merged.seeds.dedup();
        let updates = |cell: &Cell| cell.experiment.learning.updates;
        let is_swept = merged.axes.iter().flat_map(swept_keys).any(|key| key == "learning.updates");
        let most = merged.cells.iter().map(updates).max().filter(|_| !is_swept);
        if let Some(most) = most {
            merged.cells.iter_mut().for_each(|cell| cell.experiment.learning.updates = most);
        }
        Some(merged.to_toml())
    }

    /// Keys with values that are the same in all cells, and that nothing sweeps. A value that
    /// varies though nothing sweeps it is a default, which follows from what is swept.
    fn shared(&self) -> Vec<(String, toml::Value)> {
        let mut last = None;
        let mut settings =
            self.cells.iter().filter(|cell| last.replace(&cell.setting) != Some(&cell.setting));
        let all = |cell: &Cell| leaves::table(&cell.experiment);
        let mut shared = settings.next().map(|cell| leaves::leaves(&all(cell))).unwrap_or_default();
        let swept: BTreeSet<String> = self.axes.iter().flat_map(swept_keys).collect();
        shared.retain(|(key, _)| !swept.contains(key));
        for cell in settings {
            let others = all(cell);
            shared.retain(|(key, value)| leaves::get(&others, key) == Some(value));
        }
        shared
    }

    /// A number where they are 1, 2, ..., as a person would write it.
    fn seeds_value(&self) -> toml::Value {
        let n = self.seeds.len() as i64;
        if self.seeds.iter().copied().eq(1..=n as u64) {
            return n.into();
        }
        self.seeds.iter().map(|&seed| seed as i64).collect::<Vec<_>>().into()
    }
}

/// The keys that an axis sets in one cell or another.
fn swept_keys((key, values): &(String, Vec<toml::Value>)) -> Vec<String> {
    let keys = values.iter().flat_map(|value| match value {
        toml::Value::Table(table) => {
            leaves::leaves(table).into_iter().map(|(leaf, _)| format!("{key}.{leaf}")).collect()
        }
        _ => vec![key.clone()],
    });
    keys.collect()
}

/// A value as it's written again.
pub(super) fn toml_value(value: &Value) -> toml::Value {
    match value {
        Value::Text(text) | Value::Date(text) => text.clone().into(),
        Value::Integer(value) => (*value).into(),
        Value::Number(value) => (*value).into(),
        Value::Flag(value) => (*value).into(),
        Value::List(items) => {
            items.iter().map(|item| toml_value(&item.value)).collect::<Vec<_>>().into()
        }
        Value::Table(entries) => {
            let entry =
                |(key, node): &(config::Key, Node)| (key.name.clone(), toml_value(&node.value));
            toml::Value::Table(entries.iter().map(entry).collect())
        }
    }
}
