//! A run published: what others need of it, in a folder that is small enough for a repository.
//!
//! It's a run's folder without checkpoints: settings, manifest and models as they are; of each cell
//! `metrics.csv` with means over `every` updates, the policy, and a recording where one is wanted, its
//! poses packed. `manifest.json` has what a checkpoint would vouch for ([`Published`]). The folder
//! appears by one rename, and the same run gives the same bytes.

use std::{
    fs,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};
use tempfile::TempDir;
use xxhash_rust::xxh3::xxh3_64;

use super::{
    Cell, CellFolder, Error, Hash, Inspection, Manifest, Recording, Row, Run, State, atomic,
    atomic::{folder_of, sync_folder},
    create::{followed, remove_leftovers, temporary, untaken},
    error::At,
    manifest::{MODELS, POLICIES, PUBLISHED_FORMAT},
    metrics::{parse, read_columns},
    run::{EXPERIMENT, MANIFEST},
};

/// What `manifest.json` has of a published run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// The number of updates that a row of `metrics.csv` is the mean of.
    pub every: u64,
    /// What was published of each cell, by index.
    pub cells: Vec<PublishedCell>,
}

/// What was published of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedCell {
    /// Updates that the cell had; its last ones may not fill a row.
    pub updates: u64,
    /// Hash of the bytes of `metrics.csv`; none without a row.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub metrics_xxh3: Option<Hash>,
    /// The moments of what the cell is judged by, and of the information in nats, over its single updates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moments: Option<Moments>,
}

/// Moments of pairs (x, y), from which their correlation is worked out, also that of several
/// cells together: means of updates have another one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Moments {
    /// The number of pairs.
    pub n: u64,
    /// The means of x and of y.
    pub means: [f64; 2],
    /// The sums of (x - mean)^2, (x - mean)(y - mean) and (y - mean)^2.
    pub sums: [f64; 3],
}

impl Published {
    /// What the types don't say.
    pub(super) fn check(&self, n_cells: usize) -> Result<(), String> {
        match (self.every, self.cells.len()) {
            (0, _) => Err("published.every is 0".into()),
            (_, n) if n != n_cells => {
                Err(format!("published has {n} cells, and there are {n_cells}"))
            }
            _ => Ok(()),
        }
    }
}

impl CellFolder {
    /// All rows of a published cell, each the mean of some updates.
    ///
    /// # Errors
    /// [`Error::Damaged`] if they aren't what was published; what reading runs into.
    pub fn published_rows(&self, published: &PublishedCell) -> Result<Vec<Row>, Error> {
        let path = self.metrics();
        let bytes = atomic::read(&path)?;
        let found = bytes.as_ref().map(|bytes| Hash(xxh3_64(bytes)));
        if found != published.metrics_xxh3 {
            let what = match found {
                None => "missing, and manifest.json has its hash",
                Some(_) => "it isn't what was published (manifest.json has its hash)",
            };
            return Err(Error::damaged(&path, what));
        }
        parse(&path, &bytes.unwrap_or_default())
    }

    /// Where a cell stood that is to have so many updates when it was published.
    ///
    /// # Errors
    /// As [`CellFolder::published_rows`].
    pub fn published_state(
        &self,
        published: &PublishedCell,
        target_updates: u64,
    ) -> Result<Inspection, Error> {
        let rows = self.published_rows(published)?;
        let state = match (self.failure()?, published.updates) {
            (Some(reason), _) => State::Failed(reason),
            (None, 0) => State::Waiting,
            (None, updates) if updates >= target_updates => State::Done,
            (None, _) => State::Stopped,
        };
        let latest = rows.last().copied();
        Ok(Inspection { state, saved_updates: published.updates, latest, writer: None, pace: None })
    }
}

/// A folder that is being filled, beside where it will be. Dropped before its end, it's gone.
#[derive(Debug)]
pub struct Publication {
    temporary: TempDir,
    folder: PathBuf,
    manifest: Manifest,
    published: Published,
}

impl Publication {
    /// Begins one of a run, with a row for each `every` updates: its settings and the files that they
    /// name.
    ///
    /// # Errors
    /// [`Error::Published`] if the run is itself published, [`Error::NotARun`] if there's something
    /// at the place; files that aren't what the run was made with; what can't be written.
    pub fn begin(run: &Run, folder: &Path, every: u64) -> Result<Self, Error> {
        run.require_unpublished()?;
        let folder = followed(folder)?;
        let is_empty = fs::read_dir(&folder).is_ok_and(|mut entries| entries.next().is_none());
        if folder.exists() && !is_empty {
            let what = "there's something here already: remove it, or choose another folder";
            return Err(Error::NotARun { path: folder, what });
        }
        let parent = folder_of(&folder);
        fs::create_dir_all(parent).at(parent, "making the folder")?;
        let temporary = temporary(parent, &prefix(&folder))?;
        let manifest = run.manifest().clone();
        atomic::write(&temporary.path().join(EXPERIMENT), run.experiment().as_bytes())?;
        for (name, copies) in [(MODELS, &manifest.models), (POLICIES, &manifest.policies)] {
            if copies.is_empty() {
                continue;
            }
            let to = temporary.path().join(name);
            fs::create_dir(&to).at(&to, "making the folder")?;
            for copy in copies {
                let bytes = match name {
                    MODELS => run.model(copy)?.into_bytes(),
                    _ => run.policy(copy)?,
                };
                atomic::write(&to.join(&copy.file), &bytes)?;
            }
        }
        let cells = vec![PublishedCell::default(); manifest.cells.len()];
        Ok(Self { temporary, folder, manifest, published: Published { every, cells } })
    }

    /// Adds a cell: the mean of each `every` of its rows, and its policy and its failure, if there are
    /// any. Last rows that don't fill one are left out.
    ///
    /// # Errors
    /// What can't be read or written.
    pub fn add(
        &mut self,
        cell: &Cell,
        from: &CellFolder,
        (rows, moments): (&[Row], Moments),
    ) -> Result<(), Error> {
        let to = self.cell(cell);
        let make = |folder: &CellFolder| {
            fs::create_dir_all(folder.path()).at(folder.path(), "making the folder")
        };
        let every = usize::try_from(self.published.every).unwrap_or(usize::MAX);
        let mut published = PublishedCell { updates: rows.len() as u64, ..Default::default() };
        if let Some(columns) = read_columns(&from.metrics())?.filter(|_| rows.len() >= every) {
            let mut text = columns.header_line();
            for rows in rows.chunks_exact(every) {
                text +=
                    &columns.line(&Row::mean(rows)).at(&to.metrics(), "putting a row together")?;
            }
            make(&to)?;
            atomic::write(&to.metrics(), text.as_bytes())?;
            published.metrics_xxh3 = Some(Hash(xxh3_64(text.as_bytes())));
            let mut numbers = moments.means.iter().chain(&moments.sums);
            // What isn't finite has no place in JSON.
            published.moments = numbers.all(|it| it.is_finite()).then_some(moments);
        }
        for (from, file) in [(from.policy(), to.policy()), (from.failed(), to.failed())] {
            if let Some(bytes) = atomic::read(&from)? {
                make(&to)?;
                atomic::write(&file, &bytes)?;
            }
        }
        self.published.cells[cell.index] = published;
        Ok(())
    }

    /// The folder as it's so far, without recordings: to be read before it has its name.
    ///
    /// # Errors
    /// What can't be written, or can't be read again.
    pub fn run(&mut self) -> Result<Run, Error> {
        self.manifest.format = PUBLISHED_FORMAT;
        self.manifest.published = Some(self.published.clone());
        let path = self.temporary.path().join(MANIFEST);
        atomic::write(&path, &self.manifest.encode()?)?;
        Run::open(self.temporary.path())
    }

    /// Adds the recording of a cell, packed.
    ///
    /// # Errors
    /// As [`Recording::encode_packed`]; what can't be written.
    pub fn record(&self, cell: &Cell, recording: &Recording) -> Result<(), Error> {
        atomic::write(&self.cell(cell).replay(), &recording.encode_packed()?)
    }

    /// Gives the folder its name.
    ///
    /// # Errors
    /// If it can't be renamed: there's then nothing at the place.
    pub fn finish(mut self) -> Result<Run, Error> {
        self.run()?;
        let Self { temporary, folder, .. } = self;
        sync_below(temporary.path())?;
        fs::rename(temporary.path(), &folder).map_err(|cause| untaken(&folder, cause))?;
        let _ = temporary.keep();
        let parent = folder_of(&folder);
        remove_leftovers(parent, &prefix(&folder));
        sync_folder(parent)?;
        Run::open(&folder)
    }

    fn cell(&self, cell: &Cell) -> CellFolder {
        CellFolder::new(self.temporary.path().join(super::run::CELLS).join(cell.folder()))
    }
}

/// Of the temporary folders beside a folder.
fn prefix(folder: &Path) -> String {
    let name = folder.file_name().unwrap_or_default();
    format!(".{}.new-", name.to_string_lossy())
}

/// Forces the names in all folders to the disk, the innermost first.
fn sync_below(folder: &Path) -> Result<(), Error> {
    for entry in fs::read_dir(folder).at(folder, "reading")? {
        let path = entry.at(folder, "reading")?.path();
        if path.is_dir() {
            sync_below(&path)?;
        }
    }
    sync_folder(folder)
}
