//! The arguments of what reads results: `itarl summary`, `check`, `plot`, `report`, `publish`, `export`.

use std::path::PathBuf;

use clap::{
    Args, ValueEnum, ValueHint,
    builder::{OsStringValueParser, TypedValueParser},
};
use clap_complete::engine::ArgValueCompleter as Completer;
use serde::Serialize;

use super::{Print, Shown, complete};
use crate::publish::RECORDINGS_KB;

/// The arguments of `itarl summary`.
#[derive(Debug, Args)]
pub struct Summary {
    /// The run's folder, or several to compare
    #[arg(required = true, value_name = "RUN", value_hint = ValueHint::DirPath)]
    pub runs: Vec<PathBuf>,
    /// Early updates [default: the first tenth of those that the cells have in common]
    #[arg(long, value_name = "FIRST-LAST")]
    pub early: Option<Updates>,
    /// Late updates [default: the last tenth of them; a cell that's far behind isn't waited for, and is left out]
    #[arg(long, value_name = "FIRST-LAST")]
    pub late: Option<Updates>,
    /// How it's printed.
    #[command(flatten)]
    pub print: Print,
}

/// The arguments of `itarl check`.
#[derive(Debug, Args)]
pub struct Check {
    /// The run's folder, or several
    #[arg(required = true, value_name = "RUN", value_hint = ValueHint::DirPath)]
    pub runs: Vec<PathBuf>,
    /// How it's printed.
    #[command(flatten)]
    pub print: Print,
}

/// Figures of a run, or of several.
#[derive(Debug, Args)]
pub struct Plot {
    /// The run's folder, or several to compare, and which figures [default: all]
    #[arg(required = true, value_name = "RUN|FIGURE", value_hint = ValueHint::DirPath,
        value_parser = OsStringValueParser::new().try_map(Shown::parse),
        add = Completer::new(complete::runs_and_figures))]
    pub shown: Vec<Shown>,
    /// Where the files go [default: RUN/plots; of several runs ./comparison]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub out: Option<PathBuf>,
    /// Kinds of files
    #[arg(long, value_name = "FORMAT,...", value_delimiter = ',', default_value = "svg")]
    pub format: Vec<Format>,
    /// A setting that close-up shows, as its folder is named [default: the best and the last one]
    #[arg(long = "setting", value_name = "SETTING", add = Completer::new(complete::settings))]
    pub settings: Vec<String>,
    /// The two best cells in feet, in place of the best and the median one
    #[arg(long)]
    pub two_best: bool,
    /// Only the first so many updates of each cell, and only cells that have them
    #[arg(long, value_name = "UPDATES", value_parser = clap::value_parser!(u64).range(1..))]
    pub until: Option<u64>,
}

/// The arguments of `itarl report`.
#[derive(Debug, Args)]
pub struct Report {
    /// The run's folder, or several to compare
    #[arg(required = true, value_name = "RUN", value_hint = ValueHint::DirPath)]
    pub runs: Vec<PathBuf>,
    /// The page [default: RUN/report.html; of several runs ./comparison.html]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub out: Option<PathBuf>,
}

/// The arguments of `itarl publish`.
#[derive(Debug, Args)]
pub struct Publish {
    /// The run's folder, finished or not
    #[arg(value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub run: PathBuf,
    /// The folder that's made
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub out: PathBuf,
    /// Updates that a row is the mean of [default: so many that the longest cell has up to 300 rows]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u64).range(1..))]
    pub every: Option<u64>,
    /// Size of all recordings together: the ends of longer ones
    #[arg(long, value_name = "KB", default_value_t = RECORDINGS_KB)]
    pub recordings: u64,
}

/// The arguments of `itarl export`.
#[derive(Debug, Args)]
pub struct Export {
    /// The run's folder, or several, finished or not
    #[arg(required = true, value_name = "RUN", value_hint = ValueHint::DirPath)]
    pub runs: Vec<PathBuf>,
    /// The folder of event files for TensorBoard: SETTING/seed=N below it
    #[arg(long, required = true, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub tensorboard: PathBuf,
}

/// A kind of picture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Format {
    /// Lines and text, for pages and print
    Svg,
    /// 2,000 pixels wide
    Png,
}

/// Some updates in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Updates {
    /// The first update, counted from 1.
    pub first: u64,
    /// The last update, which belongs to them.
    pub last: u64,
}
