//! What can be typed after `itarl landscape`.

use std::path::PathBuf;

use clap::{Args, ValueHint, value_parser};
use clap_complete::engine::ArgValueCompleter as Completer;

use super::complete;
use crate::training::SolverKind;

/// The arguments of `itarl landscape`.
#[derive(Debug, Args)]
pub struct Landscape {
    /// Cells' folders: slices go through their policies
    #[arg(value_name = "CELL", required_unless_present = "between", value_hint = ValueHint::DirPath,
        add = Completer::new(complete::cells))]
    pub cells: Vec<PathBuf>,
    /// Lines in so many random directions through each cell [default: 2; 0 with --between or
    /// --along-training]
    #[arg(long, value_name = "N")]
    pub directions: Option<usize>,
    /// A map of each cell: the plane of two more random directions
    #[arg(long)]
    pub plane: bool,
    /// A line from one cell to another; can be given several times
    #[arg(long, num_args = 2, value_names = ["A", "B"], value_hint = ValueHint::DirPath,
        add = Completer::new(complete::cells))]
    pub between: Vec<PathBuf>,
    /// A map of the principal plane of a path: the cells are one policy while it was trained, in order
    #[arg(long)]
    pub along_training: bool,
    /// How far lines and maps reach from a policy to either side: 1 is as far as each unit's weights are
    /// from 0, along a path as far as it goes
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    pub span: f64,
    /// Points of a line, and of a map's side; odd, so that one is the policy itself
    #[arg(long, value_name = "N", default_value_t = 41, value_parser = value_parser!(u16).range(3..=1001))]
    pub points: u16,
    /// Control steps of a rollout
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = value_parser!(u64).range(1..=100_000))]
    pub steps: u64,
    /// Rollouts of each point; more can be added later. One draws a slice, measures need two
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = value_parser!(u16).range(1..))]
    pub repeats: u16,
    /// Rollouts of each cell for its policy gradients; 0 leaves them out
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub gradients: u16,
    /// Where random numbers come from: the directions', and those of the first rollouts
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Mixes to look at, by their share of the task
    #[arg(long, value_name = "XI,...", value_delimiter = ',', default_values_t = [0.0, 0.25, 0.5, 0.75, 1.0])]
    pub xi: Vec<f64>,
    /// Another mix than the cell's, as in --mix 'power = 1' or --mix 'kind = "linear"'
    #[arg(long, value_name = "TOML")]
    pub mix: Option<String>,
    /// The folder for rollouts, tables and figures
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub out: PathBuf,
    /// Threads [default: one a core]
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Worlds that a thread steps at a time [default: as many as the solver has lanes]
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..))]
    pub lanes: Option<u16>,
    /// Who steps the worlds
    #[arg(long, value_enum, default_value_t)]
    pub solver: SolverKind,
}
