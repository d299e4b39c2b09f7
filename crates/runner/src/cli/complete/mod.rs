//! Completions: a shell asks the program itself what may stand where the cursor is, with what is typed so
//! far behind `--`, and so it's offered the cells of the run and the keys of the experiment that are named
//! there. What can't be read offers nothing.

mod shells;

use std::{
    collections::BTreeSet,
    env,
    ffi::{OsStr, OsString},
    io,
    path::{Path, PathBuf},
};

use clap::CommandFactory;
use clap_complete::{
    CompleteEnv,
    engine::{CompletionCandidate as Candidate, PathCompleter, ValueCompleter},
    env::{Elvish, Fish, Powershell, Shells},
};
use config::Setting;
use figures::FIGURES;
use runs::{CELLS, MANIFEST, Run};

use self::shells::{BASH, ZSH};
use super::Cli;
use crate::experiment::{Cell, Experiment, Plan};

/// Set by a shell that asks, to its name.
const VARIABLE: &str = "ITARL_COMPLETE";

const PROGRAM: &str = "itarl";

const SHELLS: Shells<'static> = Shells(&[&BASH, &Elvish, &Fish, &Powershell, &ZSH]);

/// Answers a shell and ends the program, if one has asked.
pub fn answer() {
    CompleteEnv::with_factory(Cli::command).var(VARIABLE).shells(SHELLS).complete();
}

/// What makes a shell ask: to be run by it when it starts.
///
/// # Errors
/// A shell that isn't known; a working directory that's gone.
pub fn script(shell: &str) -> io::Result<Vec<u8>> {
    let unknown = || io::Error::other(format!("completions of {shell} aren't known"));
    let mut script = Vec::new();
    let shells = SHELLS;
    let shell = shells.completer(shell).ok_or_else(unknown)?;
    shell.write_registration(VARIABLE, PROGRAM, PROGRAM, &this_program()?, &mut script)?;
    Ok(script)
}

/// As it was called: by its name on the path, or else by its place, wherever the shell goes.
fn this_program() -> io::Result<String> {
    let called = env::args_os().next().map_or_else(|| PROGRAM.into(), PathBuf::from);
    let place = match called.components().count() {
        0 | 1 => called,
        _ => std::path::absolute(called)?,
    };
    Ok(place.to_string_lossy().into_owned())
}

/// A cell's folder of a run that the word leads to, or into; or the way to one, or to a model file.
pub(super) fn cells(word: &OsStr) -> Vec<Candidate> {
    let is_run = |folder: &&Path| folder.join(MANIFEST).is_file();
    let Some(folder) = Path::new(word).ancestors().find(is_run) else {
        return paths(word, |path| path.is_dir() || is_toml(path));
    };
    let Ok(run) = Run::open(folder) else { return Vec::new() };
    let cells = run.manifest().cells.iter().map(|it| folder.join(CELLS).join(it.folder()));
    matching(word, cells.map(Candidate::new))
}

/// Who decides in a rollout.
pub(super) fn policies(word: &OsStr) -> Vec<Candidate> {
    let named = [
        ("learned", "what the cell has learned"),
        ("random", "uniform random bits"),
        ("neutral", "the middle of all ranges"),
    ];
    let named = named.map(|(name, about)| Candidate::new(name).help(Some(about.into())));
    matching(word, named).into_iter().chain(paths(word, is_toml)).collect()
}

/// A run's folder, or a figure.
pub(super) fn runs_and_figures(word: &OsStr) -> Vec<Candidate> {
    let figures = FIGURES.iter().map(|it| Candidate::new(it.name));
    matching(word, figures).into_iter().chain(paths(word, Path::is_dir)).collect()
}

/// The settings of the runs that are named.
pub(super) fn settings(word: &OsStr) -> Vec<Candidate> {
    let runs = typed().into_iter().map(PathBuf::from).filter(|it| it.join(MANIFEST).is_file());
    let runs = runs.filter_map(|folder| Run::open(&folder).ok());
    let names = runs.flat_map(|run| {
        let cells = run.manifest().cells.iter();
        cells.map(|it| it.setting.clone()).collect::<BTreeSet<_>>()
    });
    matching(word, names.map(Candidate::new))
}

/// The numbers of the experiment's cells.
pub(super) fn indices(word: &OsStr) -> Vec<Candidate> {
    let cells = named_plan().map(|plan| plan.cells().to_vec()).unwrap_or_default();
    let candidate = |cell: &Cell| {
        let name = cell.folder().display().to_string();
        Candidate::new(cell.index.to_string()).help(Some(name.into()))
    };
    matching(word, cells.iter().map(candidate))
}

/// `KEY=` of the experiment that is named, with its value; of all experiments, if none is.
pub(super) fn assignments(word: &OsStr) -> Vec<Candidate> {
    let known = named_plan().map(|plan| {
        let shown = plan.cells().iter().flat_map(|cell| cell.experiment.shown());
        shown.map(|(key, _)| key).collect::<BTreeSet<_>>()
    });
    let is_there = |setting: &Setting| known.as_ref().is_none_or(|it| it.contains(&setting.key));
    let all = Experiment::settings();
    let keys = all.into_iter().filter(is_there).map(|it| (format!("{}=", it.key), it.about));
    // It's no setting of a cell.
    let keys = keys.chain([("sweep.seeds=".into(), "how many seeds, or which".into())]);
    // A key may be in several kinds.
    let mut seen = BTreeSet::new();
    let keys = keys.filter(|(key, _)| seen.insert(key.clone()));
    matching(word, keys.map(|(key, about)| Candidate::new(key).help(Some(about.into()))))
}

/// Settings, and the tables that they're in.
pub(super) fn keys(word: &OsStr) -> Vec<Candidate> {
    let all = Experiment::settings();
    let parts = all.iter().flat_map(|it| {
        let dots = it.key.match_indices('.').map(|(dot, _)| &it.key[..dot]);
        dots.chain([it.key.as_str()])
    });
    matching(word, parts.collect::<BTreeSet<_>>().into_iter().map(Candidate::new))
}

fn matching(word: &OsStr, all: impl IntoIterator<Item = Candidate>) -> Vec<Candidate> {
    let word = word.as_encoded_bytes();
    all.into_iter().filter(|it| it.get_value().as_encoded_bytes().starts_with(word)).collect()
}

fn paths(word: &OsStr, is_wanted: fn(&Path) -> bool) -> Vec<Candidate> {
    PathCompleter::any().filter(is_wanted).complete(word)
}

fn is_toml(path: &Path) -> bool {
    path.is_file() && path.extension() == Some("toml".as_ref())
}

/// The words of the line.
fn typed() -> Vec<OsString> {
    env::args_os().skip_while(|word| word != "--").skip(1).collect()
}

/// The experiment that the line names, with the changes that it makes, as far as they can be made.
fn named_plan() -> Option<Plan> {
    let words = typed();
    let file = words.iter().map(PathBuf::from).find(|path| is_toml(path))?;
    let pairs = words.iter().zip(words.iter().skip(1));
    let changes = pairs.filter(|(option, _)| *option == "--set");
    let changes = changes.filter_map(|(_, change)| Some(change.to_str()?.to_owned()));
    let changes: Vec<_> = changes.filter(|change| change.contains('=')).collect();
    Plan::open(&file, &changes).or_else(|_| Plan::open(&file, &[])).ok()
}
