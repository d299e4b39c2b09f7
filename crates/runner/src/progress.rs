//! How training goes, for whoever waits: bars in a terminal, now and then a line elsewhere.

use std::{
    collections::BTreeMap,
    io::{IsTerminal, Write, stderr},
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::{
    plain::plain,
    store::{Header, Row},
    training::{Ending, Lab, LabCell, Observer},
};

/// What the bars show; a test parses them.
const OVERALL: &str = "{msg} {bar:30} {percent:>3} %  {per_sec} control steps/s  {eta} left";
const CELL: &str = "  {prefix}  {wide_msg}";

const COUNTER: &str = "{msg} {bar:30} {pos}/{len}";

/// What takes no longer needs no bar.
const QUIET: Duration = Duration::from_secs(1);

/// Between two lines where there's no terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// A line for people, on standard error. That nobody reads it is no reason to stop.
pub fn tell(text: impl std::fmt::Display) {
    let _ = writeln!(stderr(), "{}", plain(&text.to_string()));
}

/// How far a command has come that may take a while: nothing for the first seconds, then a bar in a
/// terminal, and now and then a line elsewhere.
pub struct Counter {
    name: String,
    bar: ProgressBar,
    start: Instant,
    last_line: Mutex<Instant>,
}

impl Counter {
    /// Of what is done with `name`.
    #[must_use]
    pub fn new(name: String) -> Self {
        let now = Instant::now();
        Self { name, bar: ProgressBar::hidden(), start: now, last_line: Mutex::new(now) }
    }

    /// `done` of `total` are done, as in "12 of 150 cells read"; from any thread.
    pub fn report(&self, done: usize, total: usize, what: &str) {
        if self.start.elapsed() < QUIET {
            return;
        }
        if stderr().is_terminal() {
            if self.bar.is_hidden() {
                let style = ProgressStyle::with_template(COUNTER);
                self.bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
                self.bar.set_draw_target(ProgressDrawTarget::stderr());
            }
            self.bar.set_length(total as u64);
            self.bar.set_position(done as u64);
            self.bar.set_message(format!("{}: {what}", self.name));
            return;
        }
        let mut last = self.last_line.lock().unwrap_or_else(PoisonError::into_inner);
        if last.elapsed() >= LINE_EVERY {
            *last = Instant::now();
            tell(format_args!("{}: {done} of {total} {what}", self.name));
        }
    }

    /// Lets something be printed where the bar is.
    pub fn aside<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
    }
}

impl Drop for Counter {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// An observer for these cells of a run.
pub fn observer<'a>(lab: &Lab, cells: impl IntoIterator<Item = &'a LabCell>) -> Box<dyn Observer> {
    let mut work = Work::default();
    for cell in cells {
        let learning = &cell.cell.experiment.learning;
        let saved = Header::read(&cell.folder.checkpoint()).ok().flatten();
        work.total += learning.updates * learning.steps_per_update;
        work.done += saved.map_or(0, |header| header.control_steps);
        work.n_cells += 1;
    }
    let name = lab.run().folder().display().to_string();
    match stderr().is_terminal() {
        true => Box::new(Bars::new(&name, &work)),
        false => Box::new(Lines::new(name, work)),
    }
}

/// In control steps.
#[derive(Clone, Copy, Debug, Default)]
struct Work {
    total: u64,
    done: u64,
    n_cells: usize,
}

fn name(cell: &LabCell) -> String {
    cell.cell.folder().display().to_string()
}

/// `update 120/300  R 1.2e-5  R_MI 0.031 nats  R_Loc 0.0042 m`
fn values(cell: &LabCell, row: &Row) -> String {
    format!(
        "update {}/{}  R {:+.1e}  R_MI {:.3} nats  R_Loc {:+.4} m",
        row.update,
        cell.cell.experiment.learning.updates,
        row.reward,
        row.information_nats,
        row.locomotion_m
    )
}

/// An overall bar, and a line for each cell at work.
struct Bars {
    bars: MultiProgress,
    overall: ProgressBar,
    cells: Mutex<BTreeMap<usize, ProgressBar>>,
}

impl Bars {
    fn new(name: &str, work: &Work) -> Self {
        let bars = MultiProgress::new();
        let overall = bars.add(ProgressBar::new(work.total));
        let style = ProgressStyle::with_template(OVERALL);
        overall.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).with_key(
            "per_sec",
            |state: &indicatif::ProgressState, out: &mut dyn std::fmt::Write| {
                let _ = write!(out, "{:.0}", state.per_sec());
            },
        ));
        overall.set_message(name.to_owned());
        overall.set_position(work.done);
        overall.reset_eta();
        overall.enable_steady_tick(Duration::from_millis(500));
        Self { bars, overall, cells: Mutex::default() }
    }

    fn cell(&self, cell: &LabCell) -> Option<ProgressBar> {
        let cells = self.cells.lock().unwrap_or_else(PoisonError::into_inner);
        cells.get(&cell.cell.index).cloned()
    }
}

impl Observer for Bars {
    fn begin(&self, cell: &LabCell, updates: u64) {
        let line = self.bars.add(ProgressBar::no_length());
        line.set_style(
            ProgressStyle::with_template(CELL).unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        line.set_prefix(name(cell));
        line.set_message(format!("update {updates}/{}", cell.cell.experiment.learning.updates));
        let mut cells = self.cells.lock().unwrap_or_else(PoisonError::into_inner);
        cells.insert(cell.cell.index, line);
    }

    fn row(&self, cell: &LabCell, row: &Row) {
        self.overall.inc(cell.cell.experiment.learning.steps_per_update);
        if let Some(line) = self.cell(cell) {
            line.set_message(values(cell, row));
        }
    }

    fn end(&self, cell: &LabCell, _: &Ending) {
        if let Some(line) = self.cell(cell) {
            line.finish_and_clear();
        }
    }
}

impl Drop for Bars {
    fn drop(&mut self) {
        self.overall.finish_and_clear();
        // A terminal that can't be cleared can't be told of it either.
        let _ = self.bars.clear();
    }
}

/// A line every few seconds, and one when a cell ends.
struct Lines {
    name: String,
    start: Instant,
    at_start: u64,
    state: Mutex<(Work, Instant)>,
}

impl Lines {
    fn new(name: String, work: Work) -> Self {
        let now = Instant::now();
        Self { name, start: now, at_start: work.done, state: Mutex::new((work, now)) }
    }
}

impl Observer for Lines {
    fn begin(&self, _: &LabCell, _: u64) {}

    fn row(&self, cell: &LabCell, row: &Row) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let (work, last) = &mut *state;
        work.done += cell.cell.experiment.learning.steps_per_update;
        if last.elapsed() < LINE_EVERY {
            return;
        }
        *last = Instant::now();
        let rate = (work.done - self.at_start) as f64 / self.start.elapsed().as_secs_f64();
        let left = work.total.saturating_sub(work.done) as f64 / rate;
        tell(format_args!(
            "{}: {:.1} % of {} cells, {rate:.0} control steps/s, {:.0} s left; {}: {}",
            self.name,
            100.0 * work.done as f64 / work.total as f64,
            work.n_cells,
            left,
            name(cell),
            values(cell, row)
        ));
    }

    fn end(&self, cell: &LabCell, ending: &Ending) {
        let how = match ending {
            Ending::Done => "done",
            Ending::Stopped => "stopped",
            Ending::Failed(_) => "failed",
            Ending::Broken(_) => "broken",
        };
        tell(format_args!("{}: {}: {how}", self.name, name(cell)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_templates_are_right() {
        for template in [OVERALL, CELL, COUNTER] {
            ProgressStyle::with_template(template).unwrap();
        }
    }
}
