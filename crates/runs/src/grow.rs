//! A run gets more cells. Those that it has stay what they are, with their numbers.
//!
//! The manifest's rename is the moment at which it has grown: whatever new files it names are there
//! before, the next `experiment.toml` under another name. A reader takes the text that the manifest
//! has the hash of.

use std::collections::BTreeSet;

use super::{
    Cell, Error, FileCopy, Manifest, NewRun, Run, atomic,
    differences::Settings,
    manifest::{MODELS, POLICIES},
    run::{EXPERIMENT, NEXT_EXPERIMENT},
};

impl Run {
    /// Appends the cells of `new` that the run doesn't have; false, with nothing done, if the run
    /// isn't any more what it was when it was opened. That its cells are among those of `new` with the
    /// same settings is the caller's to know.
    ///
    /// # Errors
    /// [`Error::Differs`] if it isn't of the same Bullet, or if cells or files are missing in `new` or
    /// have changed; [`Error::Shorter`]; what writing runs into.
    pub fn grow(&self, new: &NewRun) -> Result<bool, Error> {
        let wanted = new.manifest(self.folder())?;
        self.refuse(self.manifest().lost(&wanted))?;
        let updates = |text| Settings::read(&self.experiment_path(), text).map(|it| it.updates);
        if let (Some(there), Some(here)) = (updates(self.experiment())?, updates(&new.experiment)?)
            && here < there
        {
            return Err(Error::Shorter { path: self.folder().into(), there, here });
        }
        let _lock = self.lock()?;
        let now = Self::open(self.folder())?;
        if now.manifest() != self.manifest() || now.experiment() != self.experiment() {
            return Ok(false);
        }
        let [experiment, next] = [EXPERIMENT, NEXT_EXPERIMENT].map(|it| self.folder().join(it));
        // One that was left half-way has its text still there.
        if atomic::read(&experiment)?.as_deref() != Some(self.experiment().as_bytes()) {
            atomic::write(&experiment, self.experiment().as_bytes())?;
        }
        for (folder, files) in [(MODELS, &new.models), (POLICIES, &new.policies)] {
            self.add_files(folder, files)?;
        }
        atomic::write(&next, new.experiment.as_bytes())?;
        atomic::write(&self.manifest_path(), &self.manifest().grown(&wanted).encode()?)?;
        atomic::write(&experiment, new.experiment.as_bytes())?;
        atomic::remove(&next)?;
        Ok(true)
    }

    fn add_files(&self, folder: &str, files: &[(String, Vec<u8>)]) -> Result<(), Error> {
        let folder = self.folder().join(folder);
        if !files.is_empty() {
            atomic::make_folder(&folder)?;
        }
        // The manifest has those that are there already, with the same bytes.
        let is_new = |(file, _): &&(String, Vec<u8>)| !folder.join(file).exists();
        files
            .iter()
            .filter(is_new)
            .try_for_each(|(file, bytes)| atomic::write(&folder.join(file), bytes))
    }
}

impl Manifest {
    /// With what another one has besides, behind what there is.
    fn grown(&self, wanted: &Self) -> Self {
        let files = |there: &[FileCopy], here: &[FileCopy]| {
            let added = here.iter().filter(|file| !there.contains(file));
            there.iter().chain(added).cloned().collect()
        };
        let mut cells = self.cells.clone();
        let known: BTreeSet<String> = cells.iter().map(Cell::folder).collect();
        for cell in wanted.cells.iter().filter(|cell| !known.contains(&cell.folder())) {
            cells.push(Cell { index: cells.len(), ..cell.clone() });
        }
        Self {
            settings_xxh3: wanted.settings_xxh3,
            models: files(&self.models, &wanted.models),
            policies: files(&self.policies, &wanted.policies),
            seeds: wanted.seeds.clone(),
            cells,
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::{create::tests::new, run::MANIFEST};

    /// The two cells of `new`, and one of another seed before them.
    fn more(updates: u64) -> NewRun {
        let mut more = new(updates, 0.5);
        more.experiment += "[sweep]\nseeds = [7, 1, 2]\n";
        more.seeds = vec![7, 1, 2];
        more.cells.insert(0, Cell { index: 0, setting: "xi=0.75".into(), seed: 7 });
        (0..3).for_each(|index| more.cells[index].index = index);
        more.models.push(("crawler.toml".into(), b"name = 'crawler'\n".to_vec()));
        more
    }

    #[test]
    fn new_cells_are_numbered_behind_those_that_are_there() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("run");
        let run = Run::create(&folder, &new(300, 0.5)).unwrap();
        assert!(run.grow(&more(400)).unwrap());
        let grown = Run::open(&folder).unwrap();
        let cells: Vec<_> = grown.manifest().cells.iter().map(|it| (it.index, it.seed)).collect();
        assert_eq!(cells, [(0, 1), (1, 2), (2, 7)]);
        assert_eq!(grown.manifest().seeds, [7, 1, 2]);
        assert_eq!(grown.experiment(), more(400).experiment);
        assert_eq!(grown.model(&grown.manifest().models[1]).unwrap(), "name = 'crawler'\n");
        assert!(!folder.join(NEXT_EXPERIMENT).exists());
        // Opened by what it is now, and only by that.
        Run::create(&folder, &more(400)).unwrap();
        let error = Run::create(&folder, &new(400, 0.5)).unwrap_err().to_string();
        assert!(error.contains("\n  cell 2: xi=0.75/seed=7 there, nothing here"), "{error}");
        // The one that was opened before isn't what is there.
        assert!(!run.grow(&more(500)).unwrap());
    }

    #[test]
    fn many_that_let_it_grow_at_once_leave_it_whole() {
        let parent = tempfile::tempdir().unwrap();
        for attempt in 0..20 {
            let folder = parent.path().join(attempt.to_string());
            Run::create(&folder, &new(300, 0.5)).unwrap();
            let grow = || {
                let run = Run::open(&folder).unwrap();
                run.manifest().cells.len() == 2 && run.grow(&more(300)).unwrap()
            };
            let n_grown = std::thread::scope(|scope| {
                let growing: Vec<_> = (0..8).map(|_| scope.spawn(grow)).collect();
                growing.into_iter().map(|it| it.join().unwrap()).filter(|it| *it).count()
            });
            assert_eq!(n_grown, 1);
            assert_eq!(Run::open(&folder).unwrap().manifest().cells.len(), 3);
        }
    }

    #[test]
    fn nothing_is_lost_by_growing() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("run");
        let run = Run::create(&folder, &new(300, 0.5)).unwrap();
        let mut fewer = more(300);
        fewer.cells.remove(1);
        (0..2).for_each(|index| fewer.cells[index].index = index);
        let error = run.grow(&fewer).unwrap_err().to_string();
        assert!(error.contains("cell 0: xi=0.75/seed=1 there, nothing here"), "{error}");
        let mut changed = more(300);
        changed.models[0].1.push(b'#');
        let error = run.grow(&changed).unwrap_err().to_string();
        assert!(error.contains("models/svenja.toml: XXH3 "), "{error}");
        assert!(matches!(run.grow(&more(299)), Err(Error::Shorter { there: 300, here: 299, .. })));
        assert_eq!(Run::open(&folder).unwrap().manifest(), run.manifest());
    }

    /// Before the manifest's rename the run is the old one, and behind it the new one.
    #[test]
    fn left_half_way_it_is_whole() {
        let parent = tempfile::tempdir().unwrap();
        let [folder, grown] = ["run", "grown"].map(|name| parent.path().join(name));
        let run = Run::create(&folder, &new(300, 0.5)).unwrap();
        Run::create(&grown, &new(300, 0.5)).unwrap().grow(&more(300)).unwrap();

        fs::write(folder.join(NEXT_EXPERIMENT), more(300).experiment).unwrap();
        assert_eq!(Run::open(&folder).unwrap().experiment(), run.experiment());
        fs::copy(grown.join("models/crawler.toml"), folder.join("models/crawler.toml")).unwrap();
        fs::copy(grown.join(MANIFEST), folder.join(MANIFEST)).unwrap();
        let opened = Run::open(&folder).unwrap();
        assert_eq!(opened.experiment(), more(300).experiment);

        // Extended, it has no need of the other text.
        opened.clone().extend(&more(600).experiment).unwrap();
        fs::remove_file(folder.join(NEXT_EXPERIMENT)).unwrap();
        assert_eq!(Run::open(&folder).unwrap().experiment(), more(600).experiment);
        fs::write(folder.join(EXPERIMENT), new(300, 0.5).experiment).unwrap();
        assert!(matches!(Run::open(&folder), Err(Error::Damaged { .. })));
    }
}
