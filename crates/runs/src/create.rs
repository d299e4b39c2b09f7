//! A run's folder made: by one rename, so it's there as a whole or not at all.
//!
//! Several processes may make the same one at the same time: the first wins, the others compare and
//! go on with it.

use std::{
    fs::{self, Permissions},
    io,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
};

use xxhash_rust::xxh3::xxh3_64;

use super::{
    Bullet, Cell, Error, FileCopy, Hash, Manifest, Run, atomic,
    atomic::{folder_of, sync_folder},
    differences::Settings,
    error::At,
    manifest::{FORMAT, MODELS, POLICIES},
    run::{CELLS, EXPERIMENT, MANIFEST},
};

/// Characters that tell the temporary folders of one run apart.
const RANDOM: usize = 6;

/// All that a run is made from.
#[derive(Clone, Debug)]
pub struct NewRun {
    /// The resolved experiment, TOML.
    pub experiment: String,
    /// Version of itarl.
    pub itarl: String,
    /// The physics engine.
    pub bullet: Bullet,
    /// Name and bytes of each model file.
    pub models: Vec<(String, Vec<u8>)>,
    /// Name and bytes of each file of a policy that cells start from.
    pub policies: Vec<(String, Vec<u8>)>,
    /// The seeds, in the order of the experiment.
    pub seeds: Vec<u64>,
    /// The cells, in the order of their indices.
    pub cells: Vec<Cell>,
}

impl Run {
    /// Makes the folder; if there's a run already, opens it. It may then differ in
    /// `learning.updates` ([`Run::experiment`] says) and in nothing else.
    ///
    /// # Errors
    /// [`Error::Differs`], and what [`Run::open`] refuses. An empty folder is taken; one with
    /// anything else in it is [`Error::NotARun`].
    pub fn create(folder: &Path, new: &NewRun) -> Result<Self, Error> {
        let manifest = new.manifest(folder)?;
        if !folder.join(MANIFEST).exists() {
            make(folder, new, &manifest)?;
        }
        let run = Self::open(folder)?;
        run.require_unpublished()?;
        let path = run.experiment_path();
        let settings = Settings::read(&path, run.experiment())?;
        let mut differences = settings.differences(&Settings::read(&path, &new.experiment)?);
        differences.extend(run.manifest().differences(&manifest));
        run.refuse(differences)?;
        Ok(run)
    }
}

impl NewRun {
    /// What its run is made of, in a folder.
    ///
    /// # Errors
    /// [`Error::Argument`] if its cells or files can't have the names that they have.
    pub fn manifest(&self, folder: &Path) -> Result<Manifest, Error> {
        let copies = |files: &[(String, Vec<u8>)]| {
            let copy = |(file, bytes): &(String, Vec<u8>)| FileCopy {
                file: file.clone(),
                xxh3: Hash(xxh3_64(bytes)),
            };
            files.iter().map(copy).collect()
        };
        let settings = Settings::read(&folder.join(EXPERIMENT), &self.experiment)?;
        let manifest = Manifest {
            format: FORMAT,
            itarl: self.itarl.clone(),
            bullet: self.bullet,
            settings_xxh3: Hash(settings.xxh3()),
            models: copies(&self.models),
            policies: copies(&self.policies),
            seeds: self.seeds.clone(),
            cells: self.cells.clone(),
            published: None,
        };
        manifest.check().map_err(|what| {
            Error::argument("Run::create", "the run", "one with usable names", what)
        })?;
        Ok(manifest)
    }
}

/// Makes the folder under another name beside it and renames it. If another process was faster,
/// that's fine: its folder is there then.
fn make(folder: &Path, new: &NewRun, manifest: &Manifest) -> Result<(), Error> {
    let folder = &followed(folder)?;
    let Some(name) = folder.file_name() else {
        let path = folder.display();
        return Err(Error::argument("Run::create", "the folder", "one with a name", path));
    };
    let parent = folder_of(folder);
    fs::create_dir_all(parent).at(parent, "making the folder")?;
    let prefix = format!(".{}.new-", name.to_string_lossy());
    let made = fill(parent, &prefix, new, manifest).and_then(|temporary| {
        fs::rename(temporary.path(), folder).map_err(|cause| untaken(folder, cause))?;
        let _ = temporary.keep();
        Ok(())
    });
    // There's something at the place, by whomever: opening it says whether it will do.
    let taken = fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    match made {
        Err(error) if !taken && !folder.is_file() => Err(error),
        _ => {
            remove_leftovers(parent, &prefix);
            sync_folder(parent)
        }
    }
}

/// A link to a folder stays, and the run takes the place of what it leads to.
pub(super) fn followed(folder: &Path) -> Result<PathBuf, Error> {
    match folder.canonicalize() {
        Ok(target) if folder.is_symlink() => Ok(target),
        Err(_) if folder.is_symlink() => {
            let what = "a link to nothing: make the folder that it leads to, or choose another one";
            Err(Error::NotARun { path: folder.into(), what })
        }
        _ => Ok(folder.into()),
    }
}

/// Why a run couldn't take the place of a folder.
pub(super) fn untaken(folder: &Path, cause: io::Error) -> Error {
    let path = folder.into();
    match cause.kind() {
        io::ErrorKind::ResourceBusy => {
            let what = "a disk is mounted there, whose folder can't be replaced: choose a folder \
                        in it";
            Error::NotARun { path, what }
        }
        _ => Error::Io { path, doing: "renaming the temporary folder", cause },
    }
}

/// An empty folder beside others, removed again if it isn't kept.
pub(super) fn temporary(parent: &Path, prefix: &str) -> Result<tempfile::TempDir, Error> {
    tempfile::Builder::new()
        .prefix(prefix)
        .rand_bytes(RANDOM)
        .permissions(Permissions::from_mode(0o777))
        .tempdir_in(parent)
        .at(parent, "making a temporary folder in it")
}

fn fill(
    parent: &Path,
    prefix: &str,
    new: &NewRun,
    manifest: &Manifest,
) -> Result<tempfile::TempDir, Error> {
    let temporary = temporary(parent, prefix)?;
    let make = |name| {
        let folder = temporary.path().join(name);
        fs::create_dir(&folder).at(&folder, "making the folder").map(|()| folder)
    };
    make(CELLS)?;
    let fill = |name, files: &[(String, Vec<u8>)]| {
        let folder = make(name)?;
        files.iter().try_for_each(|(file, bytes)| atomic::write(&folder.join(file), bytes))
    };
    fill(MODELS, &new.models)?;
    if !new.policies.is_empty() {
        fill(POLICIES, &new.policies)?;
    }
    atomic::write(&temporary.path().join(EXPERIMENT), new.experiment.as_bytes())?;
    atomic::write(&temporary.path().join(MANIFEST), &manifest.encode()?)?;
    Ok(temporary)
}

/// Temporary folders are of no use once the run is there: they are of killed processes, or of those
/// that have lost the race and will find that out. What can't be removed harms nobody.
pub(super) fn remove_leftovers(parent: &Path, prefix: &str) {
    let entries = fs::read_dir(parent).into_iter().flatten().filter_map(io::Result::ok);
    // And not those of another run, whose name goes on as the prefix does.
    let is_one = |name: &str| name.strip_prefix(prefix).is_some_and(|rest| rest.len() == RANDOM);
    for entry in entries.filter(|it| is_one(&it.file_name().to_string_lossy())) {
        let _ = fs::remove_dir_all(entry.path());
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::thread;

    use super::*;
    use crate::Precision;

    pub(crate) const SINGLE: Bullet = Bullet { version: 325, precision: Precision::Single };

    pub(crate) fn new(updates: u64, rate: f64) -> NewRun {
        let cell = |index, seed| Cell { index, setting: "xi=0.75".into(), seed };
        NewRun {
            experiment: format!("[learning]\nrate = {rate:?}\nupdates = {updates}\n"),
            itarl: "0.1.0".into(),
            bullet: SINGLE,
            models: vec![("svenja.toml".into(), b"name = 'svenja'\n".to_vec())],
            policies: Vec::new(),
            seeds: vec![1, 2],
            cells: vec![cell(0, 1), cell(1, 2)],
        }
    }

    pub(crate) fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn an_empty_folder_is_taken_and_another_is_not() {
        let parent = tempfile::tempdir().unwrap();
        Run::create(parent.path(), &new(300, 0.5)).unwrap();

        let other = tempfile::tempdir().unwrap();
        fs::write(other.path().join("thesis.tex"), "").unwrap();
        let file = other.path().join("thesis.tex");
        for (folder, message) in [(other.path(), "it has no manifest.json"), (&file, "a file, and")]
        {
            let error = Run::create(folder, &new(300, 0.5)).unwrap_err();
            assert!(matches!(error, Error::NotARun { .. }), "{error}");
            assert!(error.to_string().contains(message), "{error}");
        }
        assert_eq!(names(other.path()), ["thesis.tex"]);
        let error = Run::create(&file.join("run"), &new(300, 0.5)).unwrap_err().to_string();
        assert!(error.contains("thesis.tex: making the folder: "), "{error}");
    }

    #[test]
    fn the_first_wins_and_the_others_go_on_with_it() {
        for _ in 0..20 {
            let parent = tempfile::tempdir().unwrap();
            let folder = parent.path().join("run");
            thread::scope(|scope| {
                let racers: Vec<_> = (0..8)
                    .map(|i| {
                        let folder = &folder;
                        // Half of them want something else.
                        let rate = f64::from(i % 2);
                        scope.spawn(move || (rate, Run::create(folder, &new(300, rate))))
                    })
                    .collect();
                let results: Vec<_> = racers.into_iter().map(|it| it.join().unwrap()).collect();
                let winner = Run::open(&folder).unwrap();
                for (rate, result) in results {
                    match result {
                        Ok(_) => assert_eq!(winner.experiment(), new(300, rate).experiment),
                        Err(Error::Differs { differences, .. }) => {
                            assert_ne!(winner.experiment(), new(300, rate).experiment);
                            assert_eq!(differences[0].what, "learning.rate");
                        }
                        Err(error) => panic!("{error}"),
                    }
                }
            });
            assert_eq!(names(parent.path()), ["run"]);
        }
    }

    #[test]
    fn a_link_to_an_empty_folder_is_followed() {
        let parent = tempfile::tempdir().unwrap();
        let [disk, link] = ["disk", "link"].map(|name| parent.path().join(name));
        std::os::unix::fs::symlink(&disk, &link).unwrap();
        let error = Run::create(&link, &new(300, 0.5)).unwrap_err().to_string();
        assert!(
            error.ends_with(
                "link: a link to nothing: make the folder that it leads to, or \
                                 choose another one"
            ),
            "{error}"
        );
        fs::create_dir(&disk).unwrap();
        for _ in 0..2 {
            Run::create(&link, &new(300, 0.5)).unwrap();
            assert!(link.is_symlink());
            Run::open(&disk).unwrap();
            assert_eq!(names(parent.path()), ["disk", "link"]);
        }
    }

    /// As the system refuses to rename over a mount point: a test may not mount.
    #[test]
    fn a_mount_point_is_told_from_other_folders() {
        let refused =
            |code| untaken(Path::new("disk"), io::Error::from_raw_os_error(code)).to_string();
        const EBUSY: i32 = 16;
        const ENOSPC: i32 = 28;
        assert_eq!(
            refused(EBUSY),
            "disk: a disk is mounted there, whose folder can't be replaced: choose a folder in it"
        );
        assert_eq!(
            refused(ENOSPC),
            "disk: renaming the temporary folder: No space left on device (os error 28)"
        );
    }

    #[test]
    fn names_that_lead_elsewhere_are_refused() {
        let parent = tempfile::tempdir().unwrap();
        let mut other = new(300, 0.5);
        other.cells[0].setting = "../../elsewhere".into();
        let error = Run::create(&parent.path().join("run"), &other).unwrap_err();
        assert!(matches!(error, Error::Argument { .. }), "{error}");
        assert_eq!(names(parent.path()), [""; 0]);
    }
}
