//! A run's folder: settings, manifest, copies of the files that settings name, the cells' folders.
//!
//! `create.rs` makes it, `grow.rs` gives it more cells; here it's opened, compared and extended.

use std::{
    fs,
    path::{Path, PathBuf},
};

use xxhash_rust::xxh3::xxh3_64;

use super::{
    Bullet, Cell, CellFolder, Difference, Error, FileCopy, Hash, Lock, Manifest, Published, atomic,
    differences::Settings,
    manifest::{MODELS, POLICIES},
};

pub(super) const EXPERIMENT: &str = "experiment.toml";
/// The one that follows, while a run grows.
pub(super) const NEXT_EXPERIMENT: &str = "experiment.toml.new";
/// What every run's folder has: the file that says what it's made of.
pub const MANIFEST: &str = "manifest.json";
/// The folder of the cells.
pub const CELLS: &str = "cells";

/// How often a run may grow while it's being opened.
const ATTEMPTS: u32 = 10;

/// A run's folder, whole and checked. Holding it locks nothing.
#[derive(Clone, Debug)]
pub struct Run {
    folder: PathBuf,
    experiment: String,
    manifest: Manifest,
}

impl Run {
    /// Opens a run.
    ///
    /// # Errors
    /// [`Error::NotARun`], [`Error::Damaged`], [`Error::Version`], and what reading runs into.
    pub fn open(folder: &Path) -> Result<Self, Error> {
        let not_a_run = |what| Error::NotARun { path: folder.into(), what };
        let manifest_path = folder.join(MANIFEST);
        let Some(bytes) = atomic::read(&manifest_path)
            .or_else(|error| if folder.is_dir() { Err(error) } else { Ok(None) })?
        else {
            return Err(not_a_run(match fs::metadata(folder) {
                Err(_) => "there's nothing here; `itarl train FILE --out DIR` begins a run",
                Ok(it) if it.is_file() => "a file, and not the folder of a run",
                Ok(_) => "not the folder of a run: it has no manifest.json; choose another one",
            }));
        };
        let mut manifest = Manifest::decode(&manifest_path, &bytes)?;
        for _ in 0..ATTEMPTS {
            if let Some(experiment) = experiment_of(folder, &manifest)? {
                return Ok(Self { folder: folder.into(), experiment, manifest });
            }
            // It may have grown since the manifest was read.
            let bytes = atomic::read(&manifest_path)?.unwrap_or_default();
            let now = Manifest::decode(&manifest_path, &bytes)?;
            if now == manifest {
                break;
            }
            manifest = now;
        }
        let what = "its settings aren't those that the run was made with (manifest.json has their \
                    hash); put them back, or begin a new run with them";
        Err(Error::damaged(&folder.join(EXPERIMENT), what))
    }

    /// Refuses to go on with another physics engine than the run was made with.
    ///
    /// # Errors
    /// [`Error::Differs`]
    pub fn require(&self, bullet: Bullet) -> Result<(), Error> {
        self.refuse(self.manifest.bullet.differences(bullet))
    }

    /// Refuses to go on with what was published: there's nothing to go on from.
    ///
    /// # Errors
    /// [`Error::Published`]
    pub fn require_unpublished(&self) -> Result<(), Error> {
        match self.manifest.published {
            None => Ok(()),
            Some(Published { every, .. }) => {
                Err(Error::Published { path: self.folder.clone(), every })
            }
        }
    }

    /// In what the settings of another run differ, but for what is swept and `learning.updates`.
    ///
    /// # Errors
    /// If they can't be read.
    pub fn differences(&self, other: &Self) -> Result<Vec<Difference>, Error> {
        let settings = |run: &Self| Settings::read(&run.experiment_path(), run.experiment());
        let mut differences = settings(self)?.differences(&settings(other)?);
        differences.retain(|it| !it.what.starts_with("sweep."));
        Ok(differences)
    }

    /// Refuses what isn't as the run was made.
    pub(super) fn refuse(&self, differences: Vec<Difference>) -> Result<(), Error> {
        if differences.is_empty() {
            return Ok(());
        }
        Err(Error::Differs { path: self.folder.clone(), differences })
    }

    /// The run's folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The text of `experiment.toml`.
    #[must_use]
    pub fn experiment(&self) -> &str {
        &self.experiment
    }

    /// The path of `experiment.toml`.
    #[must_use]
    pub fn experiment_path(&self) -> PathBuf {
        self.folder.join(EXPERIMENT)
    }

    /// The path of `manifest.json`.
    #[must_use]
    pub fn manifest_path(&self) -> PathBuf {
        self.folder.join(MANIFEST)
    }

    /// The content of `manifest.json`.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Replaces `experiment.toml` by one with more `learning.updates`. Several processes may do
    /// that at the same time: one after the other, and the largest number stays.
    ///
    /// # Errors
    /// [`Error::Shorter`] if it has fewer than the run had when it was opened, [`Error::Differs`] if
    /// anything else is different; what writing runs into.
    pub fn extend(&mut self, experiment: &str) -> Result<(), Error> {
        let path = self.experiment_path();
        let settings = |text: &str| Settings::read(&path, text);
        let here = settings(experiment)?;
        let there = settings(&self.experiment)?;
        self.refuse(there.differences(&here))?;
        if here.updates < there.updates {
            let [there, here] = [there, here].map(|it| it.updates.unwrap_or_default());
            return Err(Error::Shorter { path: self.folder.clone(), there, here });
        }
        if here.updates == there.updates {
            return Ok(());
        }
        let _lock = self.lock()?;
        *self = Self::open(&self.folder)?;
        let there = settings(&self.experiment)?;
        self.refuse(there.differences(&here))?;
        if here.updates > there.updates {
            atomic::write(&path, experiment.as_bytes())?;
            self.experiment = experiment.into();
        }
        Ok(())
    }

    /// Lets one process at a time change what the run is made of. The file is one that's never
    /// replaced, so all lock the same.
    pub(super) fn lock(&self) -> Result<Lock, Error> {
        Lock::wait(&self.folder.join("lock"))
    }

    /// The path of a model file's copy.
    #[must_use]
    pub fn model_path(&self, file: &str) -> PathBuf {
        self.folder.join(MODELS).join(file)
    }

    /// The text of a model file's copy.
    ///
    /// # Errors
    /// [`Error::Damaged`] if it isn't what the run was made with.
    pub fn model(&self, model: &FileCopy) -> Result<String, Error> {
        let path = self.model_path(&model.file);
        String::from_utf8(read_copy(&path, model)?)
            .map_err(|error| Error::damaged(&path, error.utf8_error().to_string()))
    }

    /// The path of the copy of a policy's file.
    #[must_use]
    pub fn policy_path(&self, file: &str) -> PathBuf {
        self.folder.join(POLICIES).join(file)
    }

    /// The bytes of the copy of a policy's file.
    ///
    /// # Errors
    /// [`Error::Damaged`] if it isn't what the run was made with.
    pub fn policy(&self, policy: &FileCopy) -> Result<Vec<u8>, Error> {
        read_copy(&self.policy_path(&policy.file), policy)
    }

    /// The folder of a cell, made when the cell is opened first.
    #[must_use]
    pub fn cell(&self, cell: &Cell) -> CellFolder {
        CellFolder::new(self.folder.join(CELLS).join(cell.folder()))
    }
}

/// The text that a manifest has the hash of; none if there's none. A run that has grown may have been
/// left before its new text took the place of the old one.
fn experiment_of(folder: &Path, manifest: &Manifest) -> Result<Option<String>, Error> {
    let path = folder.join(EXPERIMENT);
    let missing = || Error::damaged(&path, "missing");
    let text = |bytes: Vec<u8>| {
        String::from_utf8(bytes)
            .map_err(|error| Error::damaged(&path, error.utf8_error().to_string()))
    };
    let is_it = |text: &String| {
        let hash = Settings::read(&path, text).map(|it| Hash(it.xxh3()));
        hash.map(|hash| hash == manifest.settings_xxh3)
    };
    let experiment = text(atomic::read(&path)?.ok_or_else(missing)?)?;
    if is_it(&experiment)? {
        return Ok(Some(experiment));
    }
    let Some(next) = atomic::read(&folder.join(NEXT_EXPERIMENT))? else { return Ok(None) };
    let next = text(next)?;
    Ok(is_it(&next)?.then_some(next))
}

fn read_copy(path: &Path, copy: &FileCopy) -> Result<Vec<u8>, Error> {
    let bytes = atomic::read(path)?.ok_or_else(|| Error::damaged(path, "missing"))?;
    if Hash(xxh3_64(&bytes)) != copy.xxh3 {
        let what = "it isn't what the run was made with (manifest.json has its hash)";
        return Err(Error::damaged(path, what));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;
    use crate::create::tests::{SINGLE, names, new};

    #[test]
    fn what_was_created_is_opened() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("a").join("run");
        // A killed process left this.
        let leftover = parent.path().join("a").join(".run.new-x1y2z3");
        fs::create_dir_all(leftover.join("models")).unwrap();
        // Another process is making `run.new-x` just now.
        let other = parent.path().join("a").join(".run.new-x.new-y2z3x1");
        fs::create_dir_all(&other).unwrap();

        let created = Run::create(&folder, &new(300, 0.5)).unwrap();
        assert_eq!(names(&folder), ["cells", "experiment.toml", "manifest.json", "models"]);
        assert_eq!(names(&parent.path().join("a")), [".run.new-x.new-y2z3x1", "run"]);
        let opened = Run::open(&folder).unwrap();
        assert_eq!(opened.manifest(), created.manifest());
        assert_eq!(opened.experiment(), new(300, 0.5).experiment);
        let model = &opened.manifest().models[0];
        assert_eq!(opened.model(model).unwrap(), "name = 'svenja'\n");
        let cell = opened.cell(&opened.manifest().cells[1]);
        assert_eq!(cell.path(), folder.join("cells/xi=0.75/seed=2"));
        assert!(!cell.path().exists());
    }

    #[test]
    fn only_the_number_of_updates_may_change() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("run");
        Run::create(&folder, &new(300, 0.5)).unwrap();
        let mut run = Run::create(&folder, &new(900, 0.5)).unwrap();
        assert_eq!(run.experiment(), new(300, 0.5).experiment);
        run.extend(&new(900, 0.5).experiment).unwrap();
        assert_eq!(Run::open(&folder).unwrap().experiment(), new(900, 0.5).experiment);

        let mut other = new(900, 1.0);
        other.models[0].1.push(b'#');
        let error = Run::create(&folder, &other).unwrap_err().to_string();
        let expected = format!(
            "{}: this run was made differently:\n  learning.rate: 0.5 there, 1.0 here\n  \
             models/svenja.toml: XXH3 ",
            folder.display()
        );
        assert!(error.starts_with(&expected), "{error}");
        assert!(matches!(run.extend(&other.experiment), Err(Error::Differs { .. })));

        run.require(SINGLE).unwrap();
        let error = run.require(Bullet { version: 326, ..SINGLE }).unwrap_err().to_string();
        assert!(error.contains("\n  Bullet: 325 in single precision there, 326 in"), "{error}");
    }

    #[test]
    fn extended_by_many_at_once_it_has_the_largest_number() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("run");
        Run::create(&folder, &new(300, 0.5)).unwrap();
        thread::scope(|scope| {
            let extending = (1..=8).map(|i| {
                let mut run = Run::open(&folder).unwrap();
                scope.spawn(move || run.extend(&new(300 + 100 * i, 0.5).experiment))
            });
            let extending: Vec<_> = extending.collect();
            extending.into_iter().for_each(|it| it.join().unwrap().unwrap());
        });
        let mut run = Run::open(&folder).unwrap();
        assert_eq!(run.experiment(), new(1100, 0.5).experiment);
        let error = run.extend(&new(300, 0.5).experiment).unwrap_err().to_string();
        let expected =
            "learning.updates: 1100 there, 300 here: a run can be extended, not cut short";
        assert!(error.ends_with(expected), "{error}");
        assert_eq!(Run::open(&folder).unwrap().experiment(), new(1100, 0.5).experiment);
    }

    #[test]
    fn what_is_wrong_with_a_folder_is_named() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("run");
        let refused = |message: &str| {
            let error = Run::open(&folder).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        };
        refused("run: there's nothing here; `itarl train FILE --out DIR` begins a run");
        let run = Run::create(&folder, &new(300, 0.5)).unwrap();
        let model = &run.manifest().models[0];
        fs::write(run.model_path(&model.file), "name = 'Svenja'\n").unwrap();
        let error = run.model(model).unwrap_err().to_string();
        assert!(error.contains("models/svenja.toml: damaged: it isn't what"), "{error}");
        fs::write(run.experiment_path(), new(300, 0.6).experiment).unwrap();
        refused("experiment.toml: damaged: its settings aren't those");
        fs::remove_file(run.experiment_path()).unwrap();
        refused("experiment.toml: damaged: missing");
        fs::write(folder.join("manifest.json"), "{\n\"format\": }").unwrap();
        refused("manifest.json: damaged: expected value at line 2 column 11");
    }
}
