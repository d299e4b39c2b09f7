//! The arguments of what trains cells: `itarl train`, `resume`, `cell`, and `slurm`, whose workers do.

use std::{path::PathBuf, time::Duration};

use clap::{Args, ValueHint};
use clap_complete::engine::ArgValueCompleter as Completer;

use super::{Cells, ExperimentFile, Task, complete};
use crate::training::SolverKind;

/// The arguments of `itarl train`.
#[derive(Debug, Args)]
pub struct Train {
    /// What to train.
    #[command(flatten)]
    pub experiment: ExperimentFile,
    /// The run's folder [default: runs/NAME for NAME.toml]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub out: Option<PathBuf>,
    /// How far it goes, and on how many threads.
    #[command(flatten)]
    pub work: Work,
    /// Print the cells with their indices, and train nothing
    #[arg(long)]
    pub list: bool,
}

/// The arguments of `itarl resume`.
#[derive(Debug, Args)]
pub struct Resume {
    /// The run's folder
    #[arg(value_hint = ValueHint::DirPath)]
    pub run: PathBuf,
    /// Extend it to so many updates a cell
    #[arg(long, value_name = "N")]
    pub updates: Option<u64>,
    /// How far it goes, and on how many threads.
    #[command(flatten)]
    pub work: Work,
}

/// The arguments of `itarl cell`.
#[derive(Debug, Args)]
pub struct Cell {
    /// What to train.
    #[command(flatten)]
    pub experiment: ExperimentFile,
    /// Which cells.
    #[command(flatten)]
    pub which: Which,
    /// The run's folder
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub out: PathBuf,
    /// How far it goes.
    #[command(flatten)]
    pub until: Until,
    /// Who steps the worlds
    #[arg(long, value_enum, default_value_t)]
    pub solver: SolverKind,
}

/// Some cells of an experiment, as `itarl train FILE --list` counts them.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
pub struct Which {
    /// A cell
    #[arg(long, value_name = "N", add = Completer::new(complete::indices))]
    pub index: Option<usize>,
    /// Cells, as in 0-15 or 3,7,20-23
    #[arg(long, value_name = "FIRST-LAST,...", value_delimiter = ',', add = Completer::new(complete::indices))]
    pub cells: Vec<Cells>,
    /// The K-th of N parts of all cells, K from 1, as array jobs count
    #[arg(long, value_name = "K/N")]
    pub task: Option<Task>,
}

/// The arguments of `itarl slurm`.
#[derive(Debug, Args)]
pub struct Slurm {
    /// What to train.
    #[command(flatten)]
    pub experiment: ExperimentFile,
    /// The run's folder, which all nodes see [default: runs/NAME for NAME.toml]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub out: Option<PathBuf>,
    /// Workers, each on a node of its own or beside others
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    pub nodes: u16,
    /// Cores of a worker [default: as many as all cells fill with their lanes, up to 16]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub cpus: Option<u16>,
    /// Time of a job, as in 1h30m; what isn't done then is gone on with by the next one
    #[arg(long, value_name = "TIME", default_value = "1h", value_parser = humantime::parse_duration)]
    pub time: Duration,
    /// Whose account pays
    #[arg(long, value_name = "NAME")]
    pub account: Option<String>,
    /// Which nodes
    #[arg(long, value_name = "NAME")]
    pub partition: Option<String>,
    /// One more option of sbatch, as in --sbatch=--qos=long
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    pub sbatch: Vec<String>,
}

/// How training is done. Nothing of it changes a result.
#[derive(Debug, Args)]
pub struct Work {
    /// Threads [default: one a core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Worlds that a thread steps at a time [default: as many as the solver has lanes]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub lanes: Option<u16>,
    /// Who steps the worlds
    #[arg(long, value_enum, default_value_t)]
    pub solver: SolverKind,
    /// How far it goes.
    #[command(flatten)]
    pub until: Until,
}

/// How far a call goes. What it leaves is gone on with by the next one.
#[derive(Debug, Args)]
pub struct Until {
    /// Stop each cell after so many updates in this call
    #[arg(long, value_name = "UPDATES")]
    pub stop_after: Option<u64>,
    /// Stop after so much time, as in 55m or 1h30m, with all saved [default: within a Slurm job,
    /// shortly before it ends]
    #[arg(long = "for", value_name = "TIME", value_parser = humantime::parse_duration)]
    pub time: Option<Duration>,
}
