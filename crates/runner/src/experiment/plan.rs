//! An experiment file as a whole: its cells, in a stable order.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use config::{Document, MOST_PROBLEMS, Node, Problem, Problems, Value};
use toml::Table;

use super::{Experiment, leaves, sweep::Sweep};

/// All that an experiment file says.
///
/// Two plans are equal if they train the same cells in the same order.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Swept keys with their values, in the order of the file.
    axes: Vec<(String, Vec<toml::Value>)>,
    seeds: Vec<u64>,
    cells: Vec<Cell>,
}

/// One training instance.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Its place among all of a file.
    pub index: usize,
    /// What sets it apart from the others, `xi=0.75,power=2`; `base` where nothing is swept.
    pub setting: String,
    /// What its random numbers come from.
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
    /// Models are paths from the file's folder, in overrides from the current one; a plan has them
    /// absolute.
    ///
    /// # Errors
    /// All that is wrong with the file and the overrides, each with its place.
    pub fn open(path: &Path, overrides: &[String]) -> Result<Self, Problems> {
        let mut document = Document::open(path)?;
        let mut problems = Vec::new();
        for assignment in overrides {
            if let Err(found) = document.set("--set", assignment) {
                problems.extend(Vec::from(found));
            }
        }
        let resolve = |node: &mut Node| make_absolute(node, path.parent().unwrap_or(path));
        if let Some(mut model) = document.take("model") {
            resolve(&mut model);
            document.replace("model", &model.place.clone(), model)?;
        }
        let mut sweep = Sweep::read(document.take("sweep").as_ref(), &mut problems);
        sweep.resolve_models(resolve);
        sweep.check_against(&document, &mut problems);
        Self::read(&document, &sweep, problems)
    }

    fn read(document: &Document, sweep: &Sweep, problems: Vec<Problem>) -> Result<Self, Problems> {
        let combinations: Box<dyn Iterator<Item = _>> = match problems.is_empty() {
            true => Box::new(sweep.combinations()),
            false => Box::new(sweep.one_by_one()),
        };
        let mut problems = BTreeSet::from_iter(problems);
        let mut cells = Vec::new();
        for points in combinations {
            let mut document = document.clone();
            sweep.put(&points, &mut document, &mut problems);
            match document.read(Experiment::read) {
                Ok(experiment) => {
                    for &seed in &sweep.seeds {
                        let setting = sweep.name(&points);
                        let experiment = experiment.clone();
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
        let values = |points: &[super::sweep::Point]| {
            points.iter().map(|point| toml_value(&point.node.value)).collect()
        };
        let axes = sweep.axes.iter().map(|axis| (axis.key.clone(), values(&axis.points)));
        Ok(Self { axes: axes.collect(), seeds: sweep.seeds.clone(), cells })
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
        let mut file = Table::new();
        for (key, value) in self.shared() {
            leaves::put(&mut file, &key, value);
        }
        let mut sweep = Table::new();
        for (key, values) in &self.axes {
            sweep.insert(key.clone(), values.clone().into());
        }
        sweep.insert("seeds".into(), self.seeds_value());
        file.insert("sweep".into(), sweep.into());
        file.to_string()
    }

    /// Keys with values that are the same in all cells, and that nothing sweeps. A value that
    /// varies though nothing sweeps it is a default, which follows from what is swept.
    fn shared(&self) -> Vec<(String, toml::Value)> {
        let mut settings = self.cells.iter().step_by(self.seeds.len());
        let all = |cell: &Cell| leaves::leaves(&leaves::table(&cell.experiment));
        let mut shared = settings.next().map(all).unwrap_or_default();
        for cell in settings {
            let others = all(cell);
            shared.retain(|leaf| others.contains(leaf));
        }
        shared.retain(|(key, _)| !self.sweeps(key));
        shared
    }

    fn sweeps(&self, key: &str) -> bool {
        self.axes.iter().any(|(swept, values)| match key.strip_prefix(swept.as_str()) {
            Some("") => true,
            Some(rest) => rest.strip_prefix('.').is_some_and(|rest| {
                let tables = values.iter().filter_map(toml::Value::as_table);
                tables.flat_map(leaves::leaves).any(|(leaf, _)| leaf == rest)
            }),
            None => false,
        })
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

/// A path relative to `folder`, or to the current one if it's from the command line.
fn make_absolute(node: &mut Node, folder: &Path) {
    let Value::Text(text) = &mut node.value else { return };
    if text.trim().is_empty() {
        return;
    }
    let folder = if node.place.line == 0 { Path::new("") } else { folder };
    let path = folder.join(&text);
    // Without `..` if it's there; if not, whoever opens it will say so.
    if let Ok(path) = path.canonicalize().or_else(|_| std::path::absolute(&path)) {
        *text = path.to_string_lossy().into_owned();
    }
}

fn toml_value(value: &Value) -> toml::Value {
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
