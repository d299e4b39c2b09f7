//! The command line: what can be typed, with an example for each command.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueHint};
use clap_complete::{Shell, engine::ArgValueCompleter as Completer};

pub use self::{
    import::{Base, Import},
    landscape::Landscape,
    results::{Check, Export, Format, Plot, Publish, Report, Summary, Updates},
    training::{Cell, Resume, Slurm, Train, Until, Which, Work},
    values::{Cells, Shown, Size, Task},
};
use crate::experiment::known;

pub mod complete;
mod import;
mod landscape;
mod results;
mod training;
mod values;

/// Trains simulated robots whose reward mixes a task with the information in their own sensors.
#[derive(Debug, Parser)]
#[command(name = "itarl", version, max_term_width = 100, after_help = EXIT_CODES)]
pub struct Cli {
    /// The command to run.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES: &str = "\
Exit codes: 0 done; 1 failed (a mistake in a file, a write that failed, a cell that blew up);
            2 usage; 75 stopped at a checkpoint, `itarl resume` goes on, or cells are left that
            another process is at

Example:
  itarl train experiments/quick.toml --out runs/quick
  itarl status runs/quick";

const CONFIG_USAGE: &str = "\
itarl config [OPTIONS] <FILE>
       itarl config --help [KEY]";

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Train all cells of an experiment file
    #[command(after_help = "Examples:
  itarl train experiments/quick.toml --set reward.mix.power=1 --out runs/power-1
  itarl train experiments/figure2.toml --out /shared/figure2 --for 55m    # on each of many machines

Ctrl-C, SIGTERM, SIGHUP or SIGUSR1 stop it at the next control step, with all saved (exit code 75);
a second one, after a second or more, at once. The same command, or `itarl resume`, goes on.

Started several times on one folder, on one machine or on many, each takes cells that nobody is at, in
groups that fill its lanes, and ends when there's none left: with 75 if others are still at some.")]
    Train(Train),
    /// Go on with a run that was stopped or killed
    #[command(after_help = "Examples:
  itarl resume runs/quick
  itarl resume runs/quick --updates 2000    # and longer than it was meant to be")]
    Resume(Resume),
    /// Train these cells and no others, for schedulers that spread a sweep
    #[command(after_help = "Examples:
  itarl train experiments/figure2.toml --list
  itarl cell experiments/figure2.toml --index 17 --out /shared/figure2
  itarl cell experiments/figure2.toml --cells 0-15 --out /shared/figure2
  itarl cell experiments/figure2.toml --task 1/10 --out /shared/figure2    # the first tenth

All in one thread: 16 cells in its lanes take about as long as four or five alone.
Several of these may share the folder: the first makes it, the others compare. A cell that another
process is at is left to it (exit code 75).")]
    Cell(Cell),
    /// Print a batch script that starts workers on a Slurm cluster; submit it with sbatch
    #[command(after_help = "Example:
  itarl slurm experiments/figure2.toml --out /shared/figure2 --nodes 10 --time 1h | sbatch

Each worker takes cells that nobody is at. One that is asked to stop, or leaves cells to others, is
queued again, until all are done. docs/clusters.md tells more.")]
    Slurm(Slurm),
    /// Show where each cell of a run stands, also while it runs
    #[command(after_help = "Examples:
  itarl status runs/quick
  itarl status runs/quick --watch=60         # until nothing is left to do
  itarl status runs/quick --check            # whether all files are as they were written
  itarl status runs/quick --json | jq .pace  # docs/json.md has the shape

Exit codes: 0 all cells are done; 75 some aren't yet; 1 some failed, or can't be read.")]
    Status(Status),
    /// Put runs of the same settings together: other seeds, other values, or cells of the same run
    #[command(after_help = "Example:
  itarl merge runs/seeds-1-8 runs/seeds-9-16 --out runs/seeds-1-16

The runs stay as they are. A cell that two of them have must have the same bytes in both. The new run
has all combinations of what they sweep; those that none of them has are trained by `itarl resume`.")]
    Merge(Merge),
    /// Show what was learned: early updates against late ones, for each setting of a run or of several
    #[command(after_help = "Examples:
  itarl summary runs/quick --early 1-40 --late 120-160
  itarl summary runs/quick runs/power-1    # in one table, with what differs")]
    Summary(Summary),
    /// Draw the paper's figures of a run, finished or not, or of several runs side by side
    #[command(after_help = "Examples:
  itarl plot runs/quick                    # into runs/quick/plots
  itarl plot runs/quick runs/power-1       # both in each figure, into ./comparison
  itarl plot runs/quick --format svg,png learning-curves final
  itarl plot runs/quick --setting xi=0.75 --setting xi=1 close-up

docs/figures.md says what each figure and table shows.")]
    Plot(Plot),
    /// Say which of the paper's statements hold in a run over several xi, and how sure that is
    #[command(after_help = "Example:
  itarl findings runs/figure2
  itarl findings runs/worlds runs/worlds-32    # each for itself
  itarl findings runs/worlds --until 240       # of an unfinished run, all cells at the same age

docs/figures.md says how each is judged.")]
    Findings {
        /// The run's folder, or several, each asked for itself
        #[arg(required = true, value_name = "RUN", value_hint = ValueHint::DirPath)]
        runs: Vec<PathBuf>,
        /// Only the first so many updates of each cell, and only cells that have them
        #[arg(long, value_name = "UPDATES", value_parser = clap::value_parser!(u64).range(1..))]
        until: Option<u64>,
    },
    /// Say what is wrong with how a run's cells learn, since when, and what to try
    #[command(after_help = "Examples:
  itarl check runs/quick
  itarl check runs/quick --json | jq .symptoms

docs/health.md says how each symptom is found. Exit codes: 0 nothing is found; 1 otherwise.")]
    Check(Check),
    /// Put what others need of a run into a small folder, to be read and not to go on from
    #[command(after_help = "Example:
  itarl publish runs/figure2 --out experiments/results/figure2
  itarl report experiments/results/figure2

It has the settings, curves as means over some updates, the policies, and the recordings of each
setting's best and median cell. What reads a run reads it, too.")]
    Publish(Publish),
    /// Write the curves of runs for other programs: event files that TensorBoard opens
    #[command(after_help = "Examples:
  itarl export runs/quick --tensorboard events
  tensorboard --logdir events

A run of TensorBoard's is a cell, by the name of its folder; steps are control steps.
docs/run-folders.md tells more, and how to read a run without it.")]
    Export(Export),
    /// Print the complete settings of an experiment file
    #[command(
        disable_help_flag = true,
        override_usage = CONFIG_USAGE,
        after_help = "Examples:
  itarl config experiments/quick.toml --set learning.rate=0.3
  itarl config --help reward.mix.xi    # what that setting means, its range, its default
  itarl config --help reward           # all settings of the reward"
    )]
    Config(Config),
    /// Run a policy without learning and without wind, and report what it does
    #[command(after_help = "Examples:
  itarl rollout runs/quick/cells/xi=0.75/seed=1 --steps 600 --csv walk.csv
  itarl rollout models/svenja.toml --policy models/gaits/svenja.toml")]
    Rollout(Rollout),
    /// Measure how reward, task and information depend on a policy's parameters, on slices through them
    #[command(after_help = "Examples:
  itarl landscape runs/worlds/cells/xi=0.75/seed=3 --directions 2 --plane --out landscape
  itarl landscape --between runs/worlds/cells/xi=1/seed=1 runs/worlds/cells/xi=1/seed=2 --out landscape

Stopped or killed, it goes on with the same command; another --xi or --mix takes no rollout more.
docs/landscapes.md says what each file and measure is.")]
    Landscape(Landscape),
    /// Write a run's report, or one that compares several: a page with tables, figures, robots in 3-D
    #[command(after_help = "Examples:
  itarl report runs/quick                  # runs/quick/report.html, for any browser, on any machine
  itarl report runs/quick runs/power-1     # ./comparison.html")]
    Report(Report),
    /// Watch a robot: a 3-D page for any browser, a film, a picture, or a scene for Blender
    #[command(after_help = "Examples:
  itarl replay runs/quick/cells/xi=1/seed=2          # xi=1-seed=2.html: its last control steps
  itarl replay models/svenja.toml                    # svenja.html: random actions
  itarl replay models/svenja.toml --png svenja.png   # from three sides
  itarl replay runs/quick/cells/xi=1/seed=2 --gif walk.gif --glb walk.glb

The page, pictures and films need no display and no GPU where they're made.")]
    Replay(Replay),
    /// Check, show or import model files
    #[command(subcommand)]
    Model(Model),
    /// Measure the training loop on one core, in lanes and with Bullet's own solver by turns
    #[command(after_help = "Example:
  itarl bench --seconds 10")]
    Bench(Bench),
    /// Print the manual page, or write those of all commands into a folder
    #[command(after_help = "Examples:
  itarl man | man -l -
  itarl man --out ~/.local/share/man/man1")]
    Man {
        /// Where all pages go
        #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
        out: Option<PathBuf>,
    },
    /// Print a shell's completions: of commands and options, cells, settings and keys
    #[command(after_help = "Examples:
  source <(itarl completions bash)    # in ~/.bashrc
  source <(itarl completions zsh)     # in ~/.zshrc, behind compinit
  itarl completions fish | source     # in ~/.config/fish/config.fish

Then `itarl replay runs/quick/<TAB>` offers cells, and `itarl train FILE --set rew<TAB>` keys.")]
    Completions {
        /// Which shell
        shell: Shell,
    },
}

/// An experiment file with changes from the command line.
#[derive(Debug, Args)]
pub struct ExperimentFile {
    /// The experiment file
    #[arg(value_hint = ValueHint::FilePath)]
    pub file: PathBuf,
    /// Change a setting, as in learning.rate=0.3; a text in quotes: learning.optimiser='"adam"'
    #[arg(long = "set", value_name = "KEY=VALUE", add = Completer::new(complete::assignments))]
    pub set: Vec<String>,
}

/// The arguments of `itarl config`.
#[derive(Debug, Args)]
pub struct Config {
    /// The experiment file
    #[arg(required_unless_present = "help", value_hint = ValueHint::FilePath)]
    pub file: Option<PathBuf>,
    /// Change a setting, as in learning.rate=0.3
    #[arg(long = "set", value_name = "KEY=VALUE", add = Completer::new(complete::assignments))]
    pub set: Vec<String>,
    /// Print help; of a setting, or of all in a table, what it means
    #[arg(short, long, value_name = "KEY", value_parser = known, add = Completer::new(complete::keys))]
    pub help: Option<Option<String>>,
}

/// The arguments of `itarl status`.
#[derive(Debug, Args)]
pub struct Status {
    /// The run's folder
    #[arg(value_hint = ValueHint::DirPath)]
    pub run: PathBuf,
    /// Look again every so many seconds, until nothing is left to do
    #[arg(long, value_name = "SECONDS", num_args = 0..=1, require_equals = true,
        default_missing_value = "10", value_parser = clap::value_parser!(u64).range(1..))]
    pub watch: Option<u64>,
    /// Read all of each cell's checkpoint and metrics, as a resume would, and not only how long they are
    #[arg(long)]
    pub check: bool,
    /// How it's printed.
    #[command(flatten)]
    pub print: Print,
}

/// The arguments of `itarl merge`.
#[derive(Debug, Args)]
pub struct Merge {
    /// The runs' folders
    #[arg(required = true, value_name = "RUN", value_hint = ValueHint::DirPath)]
    pub runs: Vec<PathBuf>,
    /// The new run's folder
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub out: PathBuf,
}

/// How results are printed.
#[derive(Clone, Copy, Debug, Args)]
pub struct Print {
    /// Print JSON, one object a line, in the shape that docs/json.md has
    #[arg(long)]
    pub json: bool,
}

/// A run without learning.
#[derive(Debug, Args)]
pub struct Rollout {
    /// A cell's folder, or a model file
    #[arg(value_name = "CELL|MODEL", value_hint = ValueHint::AnyPath, add = Completer::new(complete::cells))]
    pub what: PathBuf,
    /// Control steps
    #[arg(long, default_value_t = 600, value_parser = clap::value_parser!(u64).range(1..))]
    pub steps: u64,
    /// Where random numbers come from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Write a row for each control step
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub csv: Option<PathBuf>,
    /// learned, random, neutral, or a gait file [default: learned for a cell, neutral for a model]
    #[arg(long, value_name = "POLICY", add = Completer::new(complete::policies))]
    pub policy: Option<String>,
    /// How it's printed.
    #[command(flatten)]
    pub print: Print,
}

/// The arguments of `itarl replay`.
#[derive(Debug, Args)]
pub struct Replay {
    /// A cell's folder, or a model file
    #[arg(value_name = "CELL|MODEL", value_hint = ValueHint::AnyPath, add = Completer::new(complete::cells))]
    pub what: PathBuf,
    /// Write a page with a 3-D viewer [default, if nothing else is asked for: a file by the name of
    /// what is watched, here]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub html: Option<PathBuf>,
    /// Write an animated glTF 2.0 scene, for Blender and others
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub glb: Option<PathBuf>,
    /// Write a film that shows everywhere
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub gif: Option<PathBuf>,
    /// Write a film through ffmpeg, which has to be installed
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub mp4: Option<PathBuf>,
    /// Write a picture of the robot from three sides
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub png: Option<PathBuf>,
    /// How much of the end a film shows, in simulated seconds
    #[arg(long, value_name = "S", default_value_t = 10.0)]
    pub seconds: f64,
    /// A film's size in pixels [default: 480x320 for a GIF, 1280x720 for an MP4]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
    /// Roll out in place of what was recorded: learned, random, neutral, or a gait file [default: a
    /// cell's record; random for a model]
    #[arg(long, value_name = "POLICY", add = Completer::new(complete::policies))]
    pub policy: Option<String>,
    /// Control steps of a rollout
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub steps: u64,
    /// Where a rollout's random numbers come from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

/// The commands of `itarl model`.
#[derive(Debug, Subcommand)]
pub enum Model {
    /// Check model files, and say all that is wrong with them
    #[command(after_help = "Example:
  itarl model check models/*.toml")]
    Check {
        /// Model files
        #[arg(required = true, value_hint = ValueHint::FilePath)]
        files: Vec<PathBuf>,
    },
    /// Make a model file of a robot in URDF, MJCF, SDF or RoSiML, and say what became of what
    #[command(after_help = "Examples:
  itarl model import go2.urdf                        # go2.toml, here
  itarl model import urdf/anymal.urdf -o anymal.toml --package anymal_description=.
  itarl model import ant.xml --feet ankle_1,ankle_2,ankle_3,ankle_4 --strict

Meshes are copied into a folder beside the model file. An experiment takes such a robot directly, too:
model = \"go2.urdf\" is imported when the run begins.")]
    Import(Import),
    /// Show model files as tables: bodies, joints, sensors, actuators
    #[command(after_help = "Example:
  itarl model show models/svenja.toml")]
    Show {
        /// Model files
        #[arg(required = true, value_hint = ValueHint::FilePath)]
        files: Vec<PathBuf>,
        /// How they're printed.
        #[command(flatten)]
        print: Print,
    },
}

/// The arguments of `itarl bench`.
#[derive(Debug, Args)]
pub struct Bench {
    /// What to measure: an experiment; with --table several, and models [default: the paper's settings
    /// with Svenja]
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub files: Vec<PathBuf>,
    /// How cost grows: over cells that are stepped together, hidden units, and cores
    #[arg(long, conflicts_with = "lanes")]
    pub table: bool,
    /// For how long, about [default: 10, with --table 2 for each row]
    #[arg(long)]
    pub seconds: Option<f64>,
    /// Worlds stepped at a time [default: as many as there are lanes]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub lanes: Option<u16>,
    /// How it's printed.
    #[command(flatten)]
    pub print: Print,
}
