//! A run folder as figures need it: settings, their cells, columns of numbers.
//!
//! Only recorded files are read, and nothing is written. What can't be read is left out and named.

use std::{
    collections::BTreeSet,
    path::PathBuf,
    sync::atomic::{AtomicUsize, Ordering},
};

use runs::{Cell, CellFolder, Moments, Row, Run};

use super::{Contacts, Error, Measure, Outcome, choice, curves::Thinned, statistics::moments};

/// Beyond it a number isn't one that learning gives, and its square has no place in an f64.
const LARGEST: f64 = 1e100;

/// What a run has recorded so far.
#[derive(Clone, Debug)]
pub struct Results {
    /// The run's folder; of [several runs](Results::together) all of theirs.
    pub folders: Vec<PathBuf>,
    /// What its cells are judged by.
    pub measure: Measure,
    /// The settings that have a cell with an update, in the order of the sweep.
    pub settings: Vec<Setting>,
}

/// The cells of one setting.
#[derive(Clone, Debug)]
pub struct Setting {
    /// The name of its folder, `xi=0.75,power=2`.
    pub name: String,
    /// Those that have an update, in the order of their seeds in the experiment.
    pub cells: Vec<CellResults>,
    /// Updates of the first and of the last window, by which cells are judged: a tenth of those
    /// of the run's longest cell, in whole rows, at least one.
    pub window: usize,
    /// Updates that a row is the mean of: 1, but in a published run.
    pub every: usize,
    /// Control steps that an update takes, those of all worlds of a cell together.
    pub steps_per_update: f64,
}

/// What a cell has recorded. Its columns have one value a row, at least one.
#[derive(Clone, Debug)]
pub struct CellResults {
    /// The name of its folder, `xi=0.75/seed=3`.
    pub name: String,
    /// The seed that its random numbers come from.
    pub seed: u64,
    /// The cell's folder.
    pub folder: PathBuf,
    /// R, the reward that is optimised.
    pub reward: Vec<f64>,
    /// The information in the reward, in nats; 0 where none is measured.
    pub intrinsic_nats: Vec<f64>,
    /// What it's judged by: the run's measure.
    pub performance: Vec<f64>,
    /// All columns of the metrics, in their order, as thin as they're drawn.
    pub(crate) columns: Vec<Thinned>,
    /// Of what it's judged by, and the information, over its single updates, or over its rows if only
    /// these are known.
    pub(crate) moments: Moments,
    /// Those done, or that are looked at.
    pub(crate) updates: usize,
    /// The outcome of its training so far.
    pub outcome: Outcome,
    /// The feet of the last control steps; only read for cells that [`best_and_median`] has.
    ///
    /// [`best_and_median`]: super::best_and_median
    pub contacts: Option<Contacts>,
}

/// Something that was left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Omitted {
    /// The cell, `xi=0.75/seed=3`.
    pub cell: String,
    /// Why: the file, what was expected and what was found.
    pub reason: String,
}

impl Omitted {
    /// A cell, called `xi=0.75/seed=3`, for a reason.
    #[must_use]
    pub fn new(cell: impl std::fmt::Display, reason: impl std::fmt::Display) -> Self {
        Self { cell: cell.to_string(), reason: reason.to_string() }
    }
}

impl std::fmt::Display for Omitted {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}: left out: {}", self.cell, self.reason)
    }
}

impl Results {
    /// Reads a run, finished or not, whose cells are judged by `measure`. `rows` gives all rows
    /// of a cell that can be believed, and `progress` is told how many of how many cells are read:
    /// both from any thread.
    ///
    /// # Errors
    /// If there's no update in it yet.
    pub fn read(
        run: &Run,
        measure: Measure,
        rows: &(dyn Fn(&Cell) -> Result<Vec<Row>, runs::Error> + Sync),
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<(Self, Vec<Omitted>), Error> {
        let folder = run.folder();
        let cells = &run.manifest().cells;
        let published = run.manifest().published.as_ref();
        let every = published.map_or(1, |it| usize::try_from(it.every).unwrap_or(usize::MAX));
        let n_read = AtomicUsize::new(0);
        let all = runs::parallel::map(cells, |cell| {
            let read = rows(cell).and_then(|rows| {
                let moments = published.and_then(|it| it.cells[cell.index].moments);
                CellResults::of(cell, run.cell(cell), &measure, (rows, every, moments))
            });
            progress(n_read.fetch_add(1, Ordering::Relaxed) + 1, cells.len());
            read
        });
        let mut omitted = Vec::new();
        let mut settings: Vec<Setting> = Vec::new();
        for (cell, read) in cells.iter().zip(all) {
            let read = match read {
                Ok(read) => read,
                Err(error) => {
                    omitted.push(Omitted::new(cell.folder(), &error));
                    None
                }
            };
            let Some((read, steps_per_update)) = read else { continue };
            match settings.iter_mut().find(|setting| setting.name == cell.setting) {
                Some(setting) => setting.cells.push(read),
                None => settings.push(Setting {
                    name: cell.setting.clone(),
                    cells: vec![read],
                    window: every,
                    every,
                    steps_per_update,
                }),
            }
        }
        if settings.is_empty() {
            return Err(Error::Empty { folder: folder.into(), omitted });
        }
        let mut read = Self { folders: vec![folder.into()], measure, settings };
        read.weigh_alike();
        Outcome::evaluate(std::slice::from_mut(&mut read));
        read.read_contacts(&mut omitted);
        Ok((read, omitted))
    }

    /// Where the moments of one cell are of rows, those of all are: an update that is alone would
    /// otherwise count as much as a row.
    fn weigh_alike(&mut self) {
        if self.cells().all(|cell| cell.moments.n == cell.updates as u64) {
            return;
        }
        for cell in self.settings.iter_mut().flat_map(|it| &mut it.cells) {
            let pairs = cell.performance.iter().zip(&cell.intrinsic_nats);
            cell.moments = moments(pairs.map(|(x, y)| (*x, *y)));
        }
    }

    /// All cells, setting by setting.
    pub fn cells(&self) -> impl Iterator<Item = &CellResults> + Clone {
        self.settings.iter().flat_map(|setting| &setting.cells)
    }

    /// Notes, and what else to keep in mind of the run.
    pub(crate) fn with_caveats(&self, notes: Vec<String>) -> Vec<String> {
        notes.into_iter().chain(self.measure.caveats.clone()).collect()
    }

    /// Updates of the longest cell.
    #[must_use]
    pub fn longest(&self) -> usize {
        self.cells().map(CellResults::updates).max().unwrap_or(0)
    }

    /// The largest number of updates that `rows` makes of the settings' longest cells, in rows.
    pub(crate) fn updates(&self, rows: impl Fn(usize) -> usize) -> usize {
        let of = |it: &Setting| rows(it.longest_rows()) * it.every;
        self.settings.iter().map(of).max().unwrap_or(1)
    }

    /// Updates of the windows by which cells are judged, in words: `30`; of several runs with windows of
    /// their own `330 or 32`.
    #[must_use]
    pub fn windows(&self) -> String {
        let mut windows: Vec<_> = self.settings.iter().map(|it| it.window.to_string()).collect();
        windows.dedup();
        let last = windows.pop().unwrap_or_default();
        if windows.is_empty() { last } else { format!("{} or {last}", windows.join(", ")) }
    }

    /// Only of those that may be drawn: a recording has some megabytes.
    fn read_contacts(&mut self, omitted: &mut Vec<Omitted>) {
        for setting in &mut self.settings {
            let chosen = choice(&setting.cells);
            let indices = [Some(chosen.best), chosen.second, Some(chosen.median)];
            for index in indices.into_iter().flatten().collect::<BTreeSet<_>>() {
                let cell = &mut setting.cells[index];
                match Contacts::read(&CellFolder::new(&cell.folder).replay()) {
                    Ok(contacts) => cell.contacts = contacts,
                    Err(error) => omitted.push(Omitted::new(&cell.name, error)),
                }
            }
        }
    }
}

impl Setting {
    /// The last-window means of the run's measure, cell by cell.
    #[must_use]
    pub fn last(&self) -> Vec<f64> {
        self.cells.iter().map(|cell| cell.outcome.last).collect()
    }

    /// Rows of its longest cell.
    pub(crate) fn longest_rows(&self) -> usize {
        self.cells.iter().map(|cell| cell.performance.len()).max().unwrap_or(0)
    }

    /// So many updates in whole rows, at least one.
    pub(crate) fn rows(&self, updates: usize) -> usize {
        (updates / self.every).max(1)
    }

    /// [`Setting::window`] in rows.
    pub(crate) fn window_rows(&self) -> usize {
        self.rows(self.window)
    }
}

impl CellResults {
    /// The number of updates done; those that don't fill a row are counted too.
    #[must_use]
    pub fn updates(&self) -> usize {
        self.updates
    }

    /// Of rows, each the mean of `every` updates, and of the single updates' moments where they're
    /// known; with the control steps that an update takes. None if there's no row yet.
    fn of(
        cell: &Cell,
        folder: CellFolder,
        measure: &Measure,
        (rows, every, moments): (Vec<Row>, usize, Option<Moments>),
    ) -> Result<Option<(Self, f64)>, runs::Error> {
        let find = |(i, row)| wrong(i, row, every, measure);
        if let Some(what) = rows.iter().enumerate().find_map(find) {
            return Err(runs::Error::Damaged { path: folder.metrics(), what });
        }
        let column = |of: fn(&Row) -> f64| rows.iter().map(of).collect();
        let Some(last) = rows.last() else { return Ok(None) };
        // What is known of all updates says nothing where later ones aren't looked at.
        let moments = moments.filter(|of| of.n < last.update + every as u64);
        let read = Self {
            name: cell.folder(),
            seed: cell.seed,
            folder: folder.path().into(),
            reward: column(|row| row.reward),
            intrinsic_nats: column(|row| row.intrinsic_nats),
            performance: rows.iter().map(|row| measure.of(row)).collect(),
            columns: Thinned::of(&rows),
            moments: moments.unwrap_or_else(|| measure.moments(&rows)),
            updates: moments.map_or(last.update, |of| of.n) as usize,
            outcome: Outcome::default(),
            contacts: None,
        };
        Ok(Some((read, last.control_steps as f64 / last.update as f64)))
    }
}

/// What is wrong with the row `i`, counted from 0, if anything.
fn wrong(i: usize, row: &Row, every: usize, measure: &Measure) -> Option<String> {
    let update = (i as u64 + 1).saturating_mul(every as u64);
    if row.update != update {
        return Some(format!("line {}: update {update} expected, got {}", i + 2, row.update));
    }
    let values = [
        ("R", row.reward),
        ("R_MI_nats", row.intrinsic_nats),
        ("R_Loc", row.advance_m),
        ("task", measure.of(row)),
    ];
    let (name, value) =
        values.into_iter().find(|(_, value)| value.is_nan() || value.abs() > LARGEST)?;
    Some(format!("line {}: {name} must be within -1e100 to 1e100, got {value}", i + 2))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use runs::{Bullet, NewRun, Precision};

    use super::*;
    use crate::example::locomotion;

    /// A run folder of two settings with two seeds each, in which nothing was trained.
    fn run(folder: &Path) -> Run {
        let cell = |index: usize| Cell {
            index,
            setting: format!("xi={}", index / 2),
            seed: index as u64 % 2 + 1,
        };
        let new = NewRun {
            experiment: "learning.updates = 3".into(),
            itarl: "0.1.0".into(),
            bullet: Bullet { version: 325, precision: Precision::Single },
            models: Vec::new(),
            policies: Vec::new(),
            seeds: vec![1, 2],
            cells: (0..4).map(cell).collect(),
        };
        Run::create(folder, &new).unwrap()
    }

    fn rows(updates: impl IntoIterator<Item = u64>, advance_m: f64) -> Vec<Row> {
        let row = |update| Row { update, advance_m, task: advance_m, ..Row::default() };
        updates.into_iter().map(row).collect()
    }

    #[test]
    fn what_cannot_be_believed_is_left_out_and_named() {
        let folder = tempfile::tempdir().unwrap();
        let run = run(&folder.path().join("run"));
        let rows = |cell: &Cell| match cell.index {
            0 => Ok(rows(1..=3, 0.5)),
            1 => Ok(rows([1, 3], 0.5)),
            2 => Ok(Vec::new()),
            _ => Ok(rows(1..=3, f64::NAN)),
        };
        let (results, omitted) = Results::read(&run, locomotion(), &rows, &|_, _| {}).unwrap();
        let names: Vec<_> = results.settings.iter().map(|it| it.name.as_str()).collect();
        assert_eq!(names, ["xi=0"]);
        assert_eq!(results.settings[0].cells[0].performance, [0.5; 3]);
        let [gap, nan] = &omitted[..] else { panic!("{omitted:?}") };
        assert!(gap.to_string().starts_with("xi=0/seed=2: left out: "), "{gap}");
        assert!(gap.reason.ends_with("damaged: line 3: update 2 expected, got 3"), "{gap}");
        assert_eq!(nan.cell, "xi=1/seed=2");
        assert!(nan.reason.contains("line 2: R_Loc must be within"), "{nan}");
    }

    #[test]
    fn a_run_without_an_update_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let run = run(&folder.path().join("run"));
        let error = Results::read(&run, locomotion(), &|_| Ok(Vec::new()), &|_, _| {}).unwrap_err();
        assert!(error.to_string().contains("no cell has an update yet"), "{error}");
    }
}
