//! One run, or several that are compared: what tells their settings apart, and their results as one.
//!
//! Of several runs a setting is called by what differs between them, as in `worlds=8,xi=0.75`: settings
//! that are fixed in a run, and another value, or swept, in another. Where more than `MOST_KEYS` differ, a
//! name would be too long to be read; and where none does, there's nothing else: then it's called by the
//! run's folder, and [`Comparison::differences`] has what differs. What doesn't touch a result (how
//! long a run is, how often it's saved, what it records) is no difference.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

use anyhow::bail;
use figures::{Error, Measure, Omitted, Results};

use crate::{
    catalogue::{Catalogue, RunCell},
    experiment::{Experiment, safe},
};

/// Keys that a name has at most, besides what is swept.
const MOST_KEYS: usize = 2;

/// Keys, or tables of keys, that no result depends on.
const WITHOUT_EFFECT: [&str; 4] = ["description", "learning.updates", "checkpoint", "record"];

/// In place of a value that there isn't.
const NONE: &str = "-";

/// Runs in the order in which they were named, at least one.
#[derive(Debug)]
pub struct Comparison {
    catalogues: Vec<Catalogue>,
    /// What stands before a setting's name, a run's own part; empty of one run alone, and where names
    /// differ without it.
    parts: Vec<String>,
    differences: Vec<Difference>,
    /// The last update that counts; none if all do.
    until: Option<u64>,
}

/// A key that doesn't have the same values in all runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// With dots, from the top of the file.
    pub key: String,
    /// Its values in each run, in the order in which its settings have them; a `-` where a run has no
    /// such key.
    pub values: Vec<Vec<String>>,
}

impl Difference {
    /// The values in a run, as a person would write them.
    #[must_use]
    pub fn shown(&self, run: usize) -> String {
        self.values[run].join(", ")
    }
}

impl Comparison {
    /// Opens runs' folders.
    ///
    /// # Errors
    /// As [`Catalogue::open`]; no run, or one twice.
    pub fn open(folders: &[PathBuf]) -> anyhow::Result<Self> {
        let mut known: BTreeMap<PathBuf, &Path> = BTreeMap::new();
        for folder in folders {
            let place = folder.canonicalize().unwrap_or_else(|_| folder.clone());
            if let Some(other) = known.insert(place, folder) {
                let [this, other] = [folder, other].map(Path::display);
                bail!("{this}: it's the same run as {other}, and would be compared with itself");
            }
        }
        if folders.is_empty() {
            bail!("a run's folder expected, got none");
        }
        let catalogues: Vec<_> =
            folders.iter().map(|folder| Catalogue::open(folder)).collect::<Result<_, _>>()?;
        let differences = differences(&catalogues);
        let parts = parts(folders, &differences, &names(&catalogues));
        Ok(Self { catalogues, parts, differences, until: None })
    }

    /// The same at one age: only the first so many updates count, of cells that have as many. None: all
    /// of all.
    #[must_use]
    pub fn until(self, update: Option<u64>) -> Self {
        Self { until: update, ..self }
    }

    /// The runs.
    #[must_use]
    pub fn catalogues(&self) -> &[Catalogue] {
        &self.catalogues
    }

    /// The one run, if it's only one.
    #[must_use]
    pub fn alone(&self) -> Option<&Catalogue> {
        if let [one] = &self.catalogues[..] { Some(one) } else { None }
    }

    /// In what the runs differ, in the order of files.
    #[must_use]
    pub fn differences(&self) -> &[Difference] {
        &self.differences
    }

    /// What a run's setting is called here.
    #[must_use]
    pub fn named(&self, run: usize, setting: &str) -> String {
        named(&self.parts[run], setting)
    }

    /// What all are judged by.
    ///
    /// # Errors
    /// [`Error::Incomparable`] if that isn't the same.
    pub fn measure(&self) -> Result<Measure, Error> {
        let nothing = |it: &Catalogue| Results {
            folders: vec![it.run().folder().into()],
            measure: it.measure(),
            settings: Vec::new(),
        };
        Ok(Results::together(self.catalogues.iter().map(nothing).collect())?.measure)
    }

    /// What the runs came to so far, side by side, and what had to be left out. `progress` is told how many
    /// of how many cells are read, from any thread.
    ///
    /// # Errors
    /// If there's no update in one of them yet; if they are judged by different things.
    pub fn results(
        &self,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<(Results, Vec<Omitted>), Error> {
        self.measure()?;
        let total: usize = self.catalogues.iter().map(|it| it.cells().len()).sum();
        let (mut runs, mut omitted, mut before) = (Vec::new(), Vec::new(), 0);
        for (i, catalogue) in self.catalogues.iter().enumerate() {
            let read = catalogue.results(self.until, &|done, _| progress(before + done, total));
            let (mut results, left_out) = read.map_err(|error| match (error, self.until) {
                (Error::Empty { folder, omitted }, Some(updates)) if omitted.is_empty() => {
                    Error::Young { folder, updates, every: catalogue.every() }
                }
                (error, _) => error,
            })?;
            before += catalogue.cells().len();
            for setting in &mut results.settings {
                setting.name = self.named(i, &setting.name);
            }
            runs.push(results);
            omitted.extend(left_out.into_iter().map(|it| self.of_run(i, it)));
        }
        Ok((Results::together(runs)?, omitted))
    }

    /// What was left out, with its run if there are several.
    pub(crate) fn of_run(&self, run: usize, omitted: Omitted) -> Omitted {
        match self.alone() {
            Some(_) => omitted,
            None => {
                let folder = self.catalogues[run].run().folder().display();
                Omitted { cell: format!("{folder}: {}", omitted.cell), ..omitted }
            }
        }
    }

    /// The cell with this folder, and its run.
    #[must_use]
    pub fn cell(&self, folder: &Path) -> Option<(usize, &RunCell)> {
        self.catalogues.iter().enumerate().find_map(|(run, catalogue)| {
            let cell = catalogue.cells().iter().find(|cell| cell.folder.path() == folder)?;
            Some((run, cell))
        })
    }
}

fn named(part: &str, setting: &str) -> String {
    match (part, setting) {
        ("", _) => setting.into(),
        (_, "base") => part.into(),
        _ => format!("{part},{setting}"),
    }
}

/// The settings of each run, by their folders' names.
fn names(catalogues: &[Catalogue]) -> Vec<Vec<String>> {
    let of = |it: &Catalogue| {
        let mut names: Vec<_> = it.cells().iter().map(|it| it.cell.setting.clone()).collect();
        names.dedup();
        names
    };
    catalogues.iter().map(of).collect()
}

/// All keys with a value in one run that another doesn't have.
fn differences(catalogues: &[Catalogue]) -> Vec<Difference> {
    let mut keys: Vec<String> = Vec::new();
    let mut values: BTreeMap<String, Vec<Vec<String>>> = BTreeMap::new();
    let hashes = hashes(catalogues);
    for (run, catalogue) in catalogues.iter().enumerate() {
        let mut before = "";
        for cell in catalogue.cells() {
            if before == cell.cell.setting {
                continue;
            }
            before = &cell.cell.setting;
            for (key, value) in comparable(catalogue, cell, &hashes) {
                let of_key = values.entry(key.clone()).or_insert_with(|| {
                    keys.push(key);
                    vec![Vec::new(); catalogues.len()]
                });
                if !of_key[run].contains(&value) {
                    of_key[run].push(value);
                }
            }
        }
    }
    let difference = |key: String| {
        let mut values = values.remove(&key)?;
        let sets: BTreeSet<BTreeSet<&String>> =
            values.iter().map(|of_run| of_run.iter().collect()).collect();
        let differs = sets.len() > 1;
        values.iter_mut().filter(|it| it.is_empty()).for_each(|it| it.push(NONE.into()));
        differs.then_some(Difference { key, values })
    };
    keys.into_iter().filter_map(difference).collect()
}

/// For each name of a file that runs have a copy of, what the copies have in them.
type Hashes = BTreeMap<String, BTreeSet<u64>>;

fn hashes(catalogues: &[Catalogue]) -> Hashes {
    let mut hashes = Hashes::new();
    let manifests = catalogues.iter().map(|it| it.run().manifest());
    for copy in manifests.flat_map(|it| it.models.iter().chain(&it.policies)) {
        hashes.entry(copy.file.clone()).or_default().insert(copy.xxh3.0);
    }
    hashes
}

/// A cell's settings that results depend on. Files are told apart by what is in them.
fn comparable(catalogue: &Catalogue, cell: &RunCell, hashes: &Hashes) -> Vec<(String, String)> {
    let manifest = catalogue.run().manifest();
    let file = |path: &str| {
        let name = Path::new(path).file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut copies = manifest.models.iter().chain(&manifest.policies);
        let copy = copies.find(|copy| copy.file == name);
        match (hashes.get(&name), copy) {
            (Some(all), Some(copy)) if all.len() > 1 => format!("{name}-{:08x}", copy.xxh3.0 >> 32),
            _ => name,
        }
    };
    let experiment: Experiment = cell.cell.experiment.clone().with_files(file);
    let touches = |key: &str| {
        let is_in = |table: &str| key == table || key.starts_with(&format!("{table}."));
        !WITHOUT_EFFECT.into_iter().any(is_in)
    };
    experiment.shown().into_iter().filter(|(key, _)| touches(key)).collect()
}

/// Each run's own part of its settings' names.
fn parts(folders: &[PathBuf], differences: &[Difference], settings: &[Vec<String>]) -> Vec<String> {
    if folders.len() == 1 {
        return vec![String::new()];
    }
    // What a run sweeps is in its settings' names.
    let is_fixed = |it: &&Difference| it.values.iter().any(|values| values.len() == 1);
    let fixed: Vec<_> = differences.iter().filter(is_fixed).collect();
    let part = |run: usize| {
        let own = fixed.iter().filter(|it| it.values[run].len() == 1 && it.values[run][0] != NONE);
        let own = own
            .map(|it| format!("{}={}", last(&it.key), safe(it.values[run][0].trim_matches('"'))));
        // It may sweep a key with one value.
        let is_named =
            |own: &String| settings[run].iter().all(|name| name.split(',').any(|part| part == own));
        own.filter(|it| !is_named(it)).collect::<Vec<_>>().join(",")
    };
    let by_keys: Vec<_> = (0..folders.len()).map(part).collect();
    let ends: BTreeSet<_> = fixed.iter().map(|it| last(&it.key)).collect();
    let rows = by_keys.iter().zip(settings);
    let rows: Vec<_> =
        rows.flat_map(|(part, names)| names.iter().map(move |name| named(part, name))).collect();
    let are_told_apart = rows.iter().collect::<BTreeSet<_>>().len() == rows.len();
    match are_told_apart && ends.len() == fixed.len() && fixed.len() <= MOST_KEYS {
        true => by_keys,
        false => folder_names(folders),
    }
}

fn last(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

/// With as many of the last parts of their paths as tell them apart.
fn folder_names(folders: &[PathBuf]) -> Vec<String> {
    let place = |folder: &PathBuf| folder.canonicalize().unwrap_or_else(|_| folder.clone());
    let places: Vec<_> = folders.iter().map(place).collect();
    let longest = places.iter().map(|it| it.components().count()).max().unwrap_or(1);
    let ends = |n: usize| -> Vec<String> {
        let end = |place: &PathBuf| {
            let parts: Vec<_> = place.iter().map(|it| it.to_string_lossy()).collect();
            safe(&parts[parts.len().saturating_sub(n)..].join("/"))
        };
        places.iter().map(end).collect()
    };
    let differ = |names: &Vec<String>| names.iter().collect::<BTreeSet<_>>().len() == names.len();
    (1..=longest).map(ends).find(differ).unwrap_or_else(|| {
        folders.iter().enumerate().map(|(i, _)| format!("run-{}", i + 1)).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn difference(key: &str, values: &[&[&str]]) -> Difference {
        let of_run = |it: &&[&str]| it.iter().map(|it| (*it).to_owned()).collect();
        Difference { key: key.into(), values: values.iter().map(of_run).collect() }
    }

    fn parts_of(differences: &[Difference], settings: [&[&str]; 2]) -> Vec<String> {
        let folders = ["runs/a", "runs/b"].map(PathBuf::from);
        let settings = settings.map(|names| names.iter().map(|it| (*it).to_owned()).collect());
        parts(&folders, differences, &settings)
    }

    #[test]
    fn what_differs_names_the_runs() {
        let worlds = difference("learning.worlds", &[&["8"], &["32"]]);
        let xi: [&[&str]; 2] = [&["xi=0", "xi=1"], &["xi=0", "xi=1"]];
        assert_eq!(parts_of(std::slice::from_ref(&worlds), xi), ["worlds=8", "worlds=32"]);
        // Swept in one of them, and fixed in the other.
        let mix = difference("reward.mix.xi", &[&["0", "1"], &["1"]]);
        let found = parts_of(&[worlds.clone(), mix.clone()], [&["xi=0", "xi=1"], &["base"]]);
        assert_eq!(found, ["worlds=8", "worlds=32,xi=1"]);
        assert_eq!(parts_of(&[mix], [&["xi=0", "xi=1"], &["base"]]), ["a", "b"], "xi=1 is in both");
        // Swept with one value, which its settings' names have already.
        let mix = difference("reward.mix.xi", &[&["0", "1"], &["0.5"]]);
        let swept: [&[&str]; 2] = [&["xi=0", "xi=1"], &["xi=0.5"]];
        assert_eq!(parts_of(&[worlds.clone(), mix.clone()], swept), ["worlds=8", "worlds=32"]);
        assert_eq!(parts_of(&[mix], swept), ["", ""]);
        let one = difference("reward.mix.xi", &[&["0", "1"], &["1"]]);
        assert_eq!(parts_of(&[one], [&["xi=0", "xi=1"], &["xi=1"]]), ["a", "b"], "xi=1 is in both");
        // Nothing, or too much.
        assert_eq!(parts_of(&[], xi), ["a", "b"]);
        let many = ["a.x", "b.y", "c.z"].map(|key| difference(key, &[&["1"], &["2"]]));
        assert_eq!(parts_of(&many, xi), ["a", "b"]);
        // Two keys that would be called the same.
        let same = ["a.x", "b.x"].map(|key| difference(key, &[&["1"], &["2"]]));
        assert_eq!(parts_of(&same, xi), ["a", "b"]);
    }

    #[test]
    fn a_run_alone_keeps_its_names() {
        let alone = parts(&["runs/a".into()], &[], &[vec!["xi=1".into()]]);
        assert_eq!(alone, [""]);
        assert_eq!((named("", "xi=1"), named("a", "base")), ("xi=1".into(), "a".into()));
        assert_eq!(named("a", "xi=1"), "a,xi=1");
    }

    #[test]
    fn folders_are_called_by_as_much_as_tells_them_apart() {
        let names =
            |folders: &[&str]| folder_names(&folders.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(names(&["/no/a", "/no/b"]), ["a", "b"]);
        assert_eq!(names(&["/no/x/run", "/no/y/run"]), ["x-run", "y-run"]);
    }
}
