//! Figures and tables of a run, from its recorded files alone.
//!
//! `docs/figures.md` says what each shows. A figure is one file here, and [`FIGURES`] names it:
//!
//! | file | what |
//! |---|---|
//! | `results.rs`, `contacts.rs` | [`Results`]: a run folder as plain data: settings, cells, columns |
//! | `measure.rs`, `information.rs` | [`Measure`]: what cells are judged by: the task's own value; [`Information`] beside it |
//! | `outcome.rs` | [`Outcome`]: what a cell came to; the best and the median one |
//! | [`statistics`] | quartiles, interquartile mean, bootstrap, correlation |
//! | `tables.rs` | [`Table`]: the numbers beside the figures |
//! | `symptoms.rs` | [`Symptom`]: what is wrong with how a cell learns |
//! | `findings/` | [`Findings`]: the paper's statements, and what a run says to each |
//! | `curves.rs`, `numbers.rs` | smoothing, quartiles over time; numbers as people read them |
//! | `together.rs` | several runs as one, to compare them |
//! | `canvas.rs`, `axis.rs`, `legend.rs`, `line_chart.rs` | the page, the font, the axes, the settings' colours; a line for each setting |
//! | `robot.rs`, `learning_curves.rs`, `close_up.rs`, `feet.rs`, `scatter.rs`, `final_values.rs`, `performance_profile.rs`, `sample_efficiency.rs`, `health.rs` | one figure each |
//! | `landscape.rs` | [`landscape_curves`], [`landscape_maps`]: slices through parameters, of numbers alone |
//!
//! ```no_run
//! use figures::{FIGURES, Measure, Options, Results, draw};
//!
//! let run = runs::Run::open("runs/quick".as_ref())?;
//! // Whoever knows the experiment asks for rows that its checkpoints vouch for; these are as they lie.
//! let rows = |cell: &runs::Cell| runs::read_all(&run.cell(cell).metrics());
//! let measure = Measure::of_task("locomotion", "R_Loc", "m");
//! let (results, omitted) = Results::read(&run, measure, &rows, &|_read, _cells| {})?;
//! omitted.iter().for_each(|it| eprintln!("{it}"));
//! for figure in &FIGURES {
//!     std::fs::write(format!("{}.svg", figure.name), draw(&results, figure, &Options::default())?.svg)?;
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What always holds: nothing is simulated, trained or written here; the same files give the same
//! bytes, with any number of threads; what can't be believed is left out and named. Experiment files
//! aren't known: whoever reads a run says how a cell's rows are read.

#![forbid(unsafe_code)]

mod axis;
mod canvas;
mod close_up;
mod contacts;
mod curves;
mod feet;
mod final_values;
mod findings;
mod health;
mod information;
mod landscape;
mod learning_curves;
mod legend;
mod line_chart;
mod measure;
mod numbers;
mod outcome;
mod performance_profile;
mod plain;
mod results;
mod robot;
mod sample_efficiency;
mod scatter;
pub mod statistics;
mod symptoms;
mod tables;
mod together;

#[cfg(test)]
mod example;

use std::path::PathBuf;

pub use contacts::Contacts;
pub use findings::{Evidence, Findings, Group, Mix, STATISTICS, Statement, Verdict};
pub use information::Information;
pub use landscape::{LandscapeMap, LandscapeProfile, landscape_curves, landscape_maps};
pub use measure::Measure;
pub use numbers::{capitalised, grouped, three_digits};
pub use outcome::{Choice, Outcome, best_and_median, tenth_of};
pub use plain::plain;
pub use results::{CellResults, Omitted, Results, Setting};
pub use symptoms::{Facts, KINDS, Kind, Symptom, symptoms};
pub use tables::{Estimate, Table, caveats, improvement, iqm};

use outcome::choice;

/// The figures: those of the paper in its order, then ours.
pub const FIGURES: [Figure; 9] = [
    robot::FIGURE,
    learning_curves::FIGURE,
    close_up::FIGURE,
    feet::FIGURE,
    scatter::FIGURE,
    final_values::FIGURE,
    performance_profile::FIGURE,
    sample_efficiency::FIGURE,
    health::FIGURE,
];

/// A kind of figure.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// As it's asked for, and its files are named.
    pub name: &'static str,
    title: fn(&Measure) -> String,
    caption: fn(&Measure) -> String,
    draw: fn(&Results, &Options) -> Result<Drawing, Error>,
    tables: fn(&Results) -> Vec<Table>,
}

/// What may be chosen.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The settings of `close-up`; empty: the one with the highest mean of the last window, and
    /// the last one of the sweep.
    pub settings: Vec<String>,
    /// Whether `feet` shows the two best cells of a setting in place of the best and the median.
    pub two_best: bool,
}

/// A figure of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// The name of its files, without `.svg`.
    pub file_stem: &'static str,
    /// A whole SVG document.
    pub svg: String,
    /// Its width in px.
    pub width: u32,
    /// Its height in px.
    pub height: u32,
    /// What is drawn, with this run's numbers: windows, rules.
    pub caption: String,
    /// The PNG file, where it's a picture and not lines.
    pub picture: Option<Vec<u8>>,
}

/// Pixels of a PNG file for each px of the SVG: 2,000 over the width of a page.
const PNG_SCALE: f32 = 2.0;

impl Drawing {
    /// The bytes of a PNG file.
    ///
    /// # Errors
    /// [`Error::Drawing`]
    pub fn png(&self) -> Result<Vec<u8>, Error> {
        self.picture.clone().map_or_else(|| canvas::png(&self.svg, PNG_SCALE), Ok)
    }
}

/// Draws a figure.
///
/// # Errors
/// [`Error::Nothing`] if this run has nothing to show in it, [`Error::Setting`], [`Error::Drawing`].
pub fn draw(run: &Results, figure: &Figure, options: &Options) -> Result<Drawing, Error> {
    (figure.draw)(run, options)
}

impl Figure {
    /// What it shows of a run that is judged so, in a few words.
    #[must_use]
    pub fn title(&self, measure: &Measure) -> String {
        (self.title)(measure)
    }

    /// What is drawn, in a sentence.
    #[must_use]
    pub fn caption(&self, measure: &Measure) -> String {
        (self.caption)(measure)
    }

    /// The caption with what is particular to a run.
    fn caption_with(&self, run: &Results, notes: &[String]) -> String {
        format!("{} {}", self.caption(&run.measure), notes.join(" "))
    }

    /// The numbers beside it.
    #[must_use]
    pub fn tables(&self, run: &Results) -> Vec<Table> {
        (self.tables)(run)
    }
}

/// The tables of all figures.
#[must_use]
pub fn tables(run: &Results) -> Vec<Table> {
    FIGURES.iter().flat_map(|figure| figure.tables(run)).collect()
}

/// Why a run can't be read or drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// It can't be read.
    #[error(transparent)]
    Store(#[from] runs::Error),
    /// It has no update.
    #[error("{}: {}", folder.display(), empty(folder, omitted))]
    Empty {
        /// The run's folder.
        folder: PathBuf,
        /// What would be there, if it could be read.
        omitted: Vec<Omitted>,
    },
    /// No cell came as far as is asked for.
    #[error("{}: {}", folder.display(), young(folder, *updates, *every))]
    Young {
        /// The run's folder.
        folder: PathBuf,
        /// Those that were asked for.
        updates: u64,
        /// Updates of a row.
        every: u64,
    },
    /// Two runs are judged by different things, which can't stand on one axis.
    #[error("{}", incomparable(.0))]
    Incomparable(Box<[(PathBuf, Measure); 2]>),
    /// There's no such setting.
    #[error("no setting {name:?} has an update; there are {}", known.join(", "))]
    Setting {
        /// What was asked for.
        name: String,
        /// What there is.
        known: Vec<String>,
    },
    /// There's nothing to show in this figure.
    #[error("{figure}: {why}")]
    Nothing {
        /// The figure.
        figure: &'static str,
        /// Why.
        why: String,
    },
    /// The drawing libraries refused.
    #[error("drawing: {0}")]
    Drawing(String),
}

fn incomparable([(a, by_a), (b, by_b)]: &[(PathBuf, Measure); 2]) -> String {
    format!(
        "these can't be compared: {} is judged by {} in {}, and {} by {} in {}; name runs of the same task",
        a.display(),
        by_a.name(),
        by_a.unit,
        b.display(),
        by_b.name(),
        by_b.unit
    )
}

fn empty(folder: &std::path::Path, omitted: &[Omitted]) -> String {
    let folder = folder.display();
    if omitted.is_empty() {
        return format!(
            "no cell has an update yet: `itarl resume {folder}` trains, `itarl status {folder}` \
             shows where it stands"
        );
    }
    let lines: Vec<_> = omitted.iter().map(|it| format!("\n  {it}")).collect();
    format!("no cell that has an update can be read{}", lines.concat())
}

fn young(folder: &std::path::Path, updates: u64, every: u64) -> String {
    if updates < every {
        return format!(
            "it has means over {every} updates, so the first {updates} can't be told apart"
        );
    }
    let folder = folder.display();
    format!("no cell has {updates} updates: `itarl status {folder}` shows how many they have")
}

impl<E: std::error::Error + Send + Sync> From<plotters::drawing::DrawingAreaErrorKind<E>>
    for Error
{
    fn from(error: plotters::drawing::DrawingAreaErrorKind<E>) -> Self {
        Self::Drawing(error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use example::{locomotion, run_of};

    /// Made-up curves that differ and have up to `n` updates.
    fn made_up(n_settings: usize, n_cells: usize, n: usize) -> Results {
        let curve = |i: usize, j: usize| -> Vec<f64> {
            let n = if j % 3 == 2 { n.div_ceil(2) } else { n };
            (0..n).map(|t| ((1 + i + j) * (1 + t) % 97) as f64 * 1e-3).collect()
        };
        let names: Vec<_> = (0..n_settings).map(|i| format!("xi={i},key=<{i}&\">")).collect();
        let settings: Vec<_> = names
            .iter()
            .enumerate()
            .map(|(i, name)| (name.as_str(), (0..n_cells).map(|j| curve(i, j)).collect()))
            .collect();
        let mut run = run_of(&settings);
        for cell in run.settings.iter_mut().flat_map(|setting| &mut setting.cells) {
            cell.contacts = Some(Contacts {
                feet: vec!["left <foot>".into(), "right foot".into()],
                seconds_per_step: 0.1,
                touching: (0..500).map(|i| i * i % 7 < 3).collect(),
            });
        }
        run
    }

    /// The robot is drawn of a folder, which these runs don't have; its own file tests it.
    fn of_numbers(figure: &&Figure) -> bool {
        figure.name != robot::FIGURE.name
    }

    /// The contract of every figure: any number of settings, cells and updates gives a small
    /// SVG of the size that it says, the same one each time.
    #[test]
    fn every_figure_draws_any_run() {
        for (n_settings, n_cells, n) in
            [(1, 1, 1), (1, 2, 2), (7, 3, 40), (12, 30, 500), (40, 1, 9)]
        {
            let run = made_up(n_settings, n_cells, n);
            for figure in FIGURES.iter().filter(of_numbers) {
                let what = format!("{} of {n_settings} x {n_cells} x {n}", figure.name);
                let drawing = draw(&run, figure, &Options::default()).unwrap();
                let document = resvg::usvg::roxmltree::Document::parse(&drawing.svg).expect(&what);
                let root = document.root_element();
                let size = ["width", "height"].map(|it| root.attribute(it).unwrap().to_owned());
                assert_eq!(
                    size,
                    [drawing.width, drawing.height].map(|it| it.to_string()),
                    "{what}"
                );
                let texts = root.descendants().filter(|node| node.is_text());
                let texts: Vec<_> = texts.filter_map(|node| node.text()).map(str::trim).collect();
                assert!(!texts.contains(&"NaN") && !texts.contains(&"inf"), "{what}");
                let most = 300_000.max(25_000 * n_settings);
                assert!(drawing.svg.len() < most, "{what}: {} bytes", drawing.svg.len());
                assert!(drawing.caption.starts_with(&figure.caption(&run.measure)), "{what}");
                assert_eq!(draw(&run, figure, &Options::default()).unwrap(), drawing, "{what}");
            }
        }
    }

    /// What isn't measured is in no figure and no table.
    #[test]
    fn a_run_without_information_is_drawn_without() {
        let mut run = made_up(2, 2, 20);
        run.measure = Measure::of_task("locomotion", "R_Loc", "m");
        for figure in FIGURES.iter().filter(of_numbers) {
            match draw(&run, figure, &Options::default()) {
                Ok(Drawing { svg, caption, .. }) => {
                    let text = svg + &caption;
                    // The entropy of a policy's outputs is in nats, too.
                    let tells = |word| figure.name != "health" && text.contains(word);
                    let tells = tells("nats") || text.contains("information");
                    assert!(!tells && !text.contains("R_MI"), "{}", figure.name);
                }
                Err(error) => {
                    assert!(matches!(error, Error::Nothing { figure: "scatter", .. }), "{error}");
                }
            }
        }
        assert!(tables(&run).iter().all(|table| table.name != "correlation"));
    }

    #[test]
    fn numbers_of_any_size_are_drawn() {
        for value in [0.0, 1e100, -1e100, 1e-300, f64::MIN_POSITIVE] {
            let mut run = made_up(2, 2, 30);
            for cell in run.settings.iter_mut().flat_map(|setting| &mut setting.cells) {
                cell.performance.fill(value);
                cell.columns.iter_mut().for_each(|it| it.fill(value));
                cell.intrinsic_nats[7] = value;
                cell.reward[7] = -value;
            }
            Outcome::evaluate(std::slice::from_mut(&mut run));
            for figure in FIGURES.iter().filter(of_numbers) {
                let drawing = draw(&run, figure, &Options::default()).unwrap();
                assert!(!drawing.svg.contains("NaN"), "{} of {value}", figure.name);
            }
            assert!(tables(&run).iter().flat_map(|it| &it.rows).flatten().all(|it| it != "NaN"));
        }
    }

    #[test]
    fn the_document_has_every_figure_and_column() {
        let document = include_str!("../../../docs/figures.md");
        for figure in &FIGURES {
            assert!(document.contains(&format!("\n## `{}`", figure.name)), "{}", figure.name);
            let [title, caption] =
                [Figure::title, Figure::caption].map(|of| of(figure, &locomotion()));
            assert!(!title.is_empty() && caption.ends_with('.'), "{}", figure.name);
        }
        for table in tables(&made_up(2, 2, 20)) {
            assert!(document.contains(&format!("`{}.csv`", table.name)), "{}", table.name);
            for column in &table.header {
                assert!(document.contains(&format!("| `{column}` |")), "{column}");
            }
            assert!(table.rows.iter().all(|row| row.len() == table.header.len()));
        }
    }
}
