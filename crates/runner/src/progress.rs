//! How training goes, for whoever waits: bars in a terminal, now and then a line elsewhere.

use std::{
    collections::{BTreeMap, BTreeSet},
    io::{IsTerminal, Write, stderr},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use figures::{Information, Measure, plain};
use indicatif::{HumanDuration, MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use runs::{Header, Row};

use crate::training::{Ending, Observer, OpenRun, RunCell};

/// What the bars show; a test parses them.
const OVERALL: &str = "{msg} {bar:30} {percent:>3} %  {pace}";
const CELL: &str = "  {prefix}  {wide_msg}";

const COUNTER: &str = "{msg} {bar:30} {pos}/{len}";

/// What takes no longer needs no bar.
const QUIET: Duration = Duration::from_secs(1);

/// Between two lines where there's no terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// A line for people, on standard error. That nobody reads it is no reason to stop.
pub fn notify(text: impl std::fmt::Display) {
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
    /// A counter of what is done with `name`.
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
        let mut last = lock(&self.last_line);
        if last.elapsed() >= LINE_EVERY {
            *last = Instant::now();
            notify(format_args!("{}: {done} of {total} {what}", self.name));
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
pub fn observer<'a>(
    open_run: &OpenRun,
    cells: impl IntoIterator<Item = &'a RunCell>,
) -> Box<dyn Observer> {
    let (mut work, mut waiting) = (Work::begin(Instant::now()), BTreeSet::new());
    for cell in cells {
        let saved = Header::read(&cell.folder.checkpoint()).ok().flatten();
        // What a damaged checkpoint says is found out when it's opened.
        let done = saved.map_or(0, |header| header.control_steps).min(all_steps(cell));
        work.total = work.total.saturating_add(all_steps(cell));
        work.stands(cell.cell.index, done);
        if done < all_steps(cell) {
            waiting.insert(cell.cell.index);
        }
    }
    let name = open_run.run().folder().display().to_string();
    match stderr().is_terminal() {
        true => Box::new(Bars::new(&name, work, ProgressDrawTarget::stderr())),
        false => Box::new(Lines::new(name, work, waiting)),
    }
}

fn name(cell: &RunCell) -> String {
    cell.cell.folder().display().to_string()
}

/// Control steps that a cell is to have.
fn all_steps(cell: &RunCell) -> u64 {
    let learning = &cell.cell.experiment.learning;
    learning.updates.saturating_mul(learning.control_steps_per_update())
}

fn values_of(cell: &RunCell, row: &Row) -> String {
    values(&cell.task(), cell.cell.experiment.learning.updates, row)
}

/// `update 120/300  R 1.2e-5  R_MI 0.031 nats  R_Loc 0.0042 m`
fn values(task: &Measure, updates: u64, row: &Row) -> String {
    let nats = |it: &Information| format!("  {} {:.3} {}", it.symbol, row.intrinsic_nats, it.unit);
    format!(
        "update {}/{}  R {:+.1e}{}  {} {:+.4} {}",
        row.update,
        updates,
        row.reward,
        task.information.as_ref().map(nats).unwrap_or_default(),
        task.symbol,
        task.of(row),
        task.unit
    )
}

/// How far the cells are, in control steps.
#[derive(Clone, Debug)]
struct Work {
    total: u64,
    /// Where each cell stands, by index, and what that is together.
    cells: BTreeMap<usize, u64>,
    done: u64,
    /// Made here since then: what was done before, or by others, says nothing of this pace.
    made: u64,
    since: Instant,
}

impl Work {
    fn begin(since: Instant) -> Self {
        Self { total: 0, cells: BTreeMap::new(), done: 0, made: 0, since }
    }

    /// A cell stands there, however it got there. By how many control steps that's further.
    fn stands(&mut self, index: usize, steps: u64) -> u64 {
        let before = self.cells.insert(index, steps).unwrap_or(0);
        self.done = self.done.saturating_sub(before).saturating_add(steps);
        steps.saturating_sub(before)
    }

    /// A cell got there at work.
    fn makes(&mut self, index: usize, steps: u64) {
        self.made += self.stands(index, steps);
    }

    /// Nothing before the first update; then `2140 control steps/s, 3 minutes left`.
    fn pace(&self, now: Instant) -> String {
        if self.made == 0 {
            return String::new();
        }
        let rate = self.made as f64 / (now - self.since).as_secs_f64();
        let left = self.total.saturating_sub(self.done) as f64 / rate;
        let left = Duration::try_from_secs_f64(left).unwrap_or(Duration::MAX);
        format!("{rate:.0} control steps/s, {} left", HumanDuration(left))
    }
}

/// An overall bar, and a line for each cell at work.
struct Bars {
    bars: MultiProgress,
    overall: ProgressBar,
    cells: Mutex<BTreeMap<usize, ProgressBar>>,
    work: Arc<Mutex<Work>>,
}

impl Bars {
    fn new(name: &str, work: Work, target: ProgressDrawTarget) -> Self {
        let bars = MultiProgress::with_draw_target(target);
        let overall = bars.add(ProgressBar::new(work.total).with_position(work.done));
        let work = Arc::new(Mutex::new(work));
        let shown = work.clone();
        let style = ProgressStyle::with_template(OVERALL);
        overall.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).with_key(
            "pace",
            move |_: &indicatif::ProgressState, out: &mut dyn std::fmt::Write| {
                let _ = write!(out, "{}", lock(&shown).pace(Instant::now()));
            },
        ));
        overall.set_message(name.to_owned());
        overall.enable_steady_tick(Duration::from_millis(500));
        Self { bars, overall, cells: Mutex::default(), work }
    }

    fn cell(&self, cell: &RunCell) -> Option<ProgressBar> {
        lock(&self.cells).get(&cell.cell.index).cloned()
    }

    /// Not with the work locked: drawing asks for it.
    fn show(&self) {
        let done = lock(&self.work).done;
        self.overall.set_position(done);
    }
}

impl Observer for Bars {
    fn begin(&self, cell: &RunCell, control_steps: u64) {
        lock(&self.work).stands(cell.cell.index, control_steps);
        self.show();
        let line = self.bars.add(ProgressBar::no_length());
        line.set_style(
            ProgressStyle::with_template(CELL).unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        line.set_prefix(name(cell));
        let learning = &cell.cell.experiment.learning;
        let updates = control_steps / learning.control_steps_per_update();
        line.set_message(format!("update {updates}/{}", learning.updates));
        lock(&self.cells).insert(cell.cell.index, line);
    }

    fn row(&self, cell: &RunCell, row: &Row) {
        lock(&self.work).makes(cell.cell.index, row.control_steps);
        self.show();
        if let Some(line) = self.cell(cell) {
            line.set_message(values_of(cell, row));
        }
    }

    fn end(&self, cell: &RunCell, ending: &Ending) {
        if matches!(ending, Ending::Done) {
            lock(&self.work).stands(cell.cell.index, all_steps(cell));
            self.show();
        }
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
    state: Mutex<Told>,
}

struct Told {
    work: Work,
    /// When the last line was told.
    last: Instant,
    /// Cells that weren't done at first, and those that were begun here, by index.
    waiting: BTreeSet<usize>,
    begun: BTreeSet<usize>,
    /// How many lines of cells that are elsewhere may still be told.
    elsewhere: usize,
}

/// Lines that tell of cells elsewhere: in a large run, that's most of them for each of its workers.
const ELSEWHERE: usize = 20;

impl Lines {
    /// `waiting`: the cells that aren't done, by index.
    fn new(name: String, work: Work, waiting: BTreeSet<usize>) -> Self {
        let (last, begun, elsewhere) = (work.since, BTreeSet::new(), ELSEWHERE);
        Self { name, state: Mutex::new(Told { work, last, waiting, begun, elsewhere }) }
    }
}

impl Observer for Lines {
    fn begin(&self, cell: &RunCell, control_steps: u64) {
        let mut state = lock(&self.state);
        state.work.stands(cell.cell.index, control_steps);
        state.begun.insert(cell.cell.index);
    }

    fn row(&self, cell: &RunCell, row: &Row) {
        let mut state = lock(&self.state);
        state.work.makes(cell.cell.index, row.control_steps);
        let now = Instant::now();
        if now - state.last < LINE_EVERY {
            return;
        }
        state.last = now;
        let work = &state.work;
        notify(format_args!(
            "{}: {:.1} % of {} cells, {}; {}: {}",
            self.name,
            100.0 * work.done as f64 / work.total as f64,
            work.cells.len(),
            work.pace(now),
            name(cell),
            values_of(cell, row)
        ));
    }

    fn end(&self, cell: &RunCell, ending: &Ending) {
        let mut state = lock(&self.state);
        let index = cell.cell.index;
        let how = match ending {
            Ending::Done => {
                state.work.stands(index, all_steps(cell));
                match state.begun.contains(&index) {
                    true => "done",
                    // By another process, since this one looked first.
                    false if state.waiting.contains(&index) => "done already",
                    false => return,
                }
            }
            Ending::Stopped | Ending::Crowded(_) => "stopped",
            Ending::Elsewhere => match state.elsewhere.checked_sub(1) {
                Some(left) => {
                    state.elsewhere = left;
                    "elsewhere"
                }
                None => return,
            },
            Ending::Failed(_) => "failed",
            Ending::Broken(_) => "broken",
        };
        notify(format_args!("{}: {}: {how}", self.name, name(cell)));
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::io;

    use indicatif::TermLike;

    use super::*;

    #[test]
    fn an_update_is_told_by_what_its_cell_measures() {
        let row = Row { update: 3, intrinsic_nats: 0.25, task: 0.5, ..Row::default() };
        let turning = Measure::of_task("turning", "turning", "rad");
        let told = values(&turning, 9, &row);
        assert_eq!(told, "update 3/9  R +0.0e0  turning +0.5000 rad");
        let flow = Information::of_kind("transfer_entropy", "R_TE", ["nats", "link"]);
        let told = values(&turning.with(Some(flow), None), 9, &row);
        assert_eq!(told, "update 3/9  R +0.0e0  R_TE 0.250 nats  turning +0.5000 rad");
    }

    #[test]
    fn the_templates_are_right() {
        for template in [OVERALL, CELL, COUNTER] {
            ProgressStyle::with_template(template).unwrap();
        }
    }

    /// Three cells of 4,000 control steps; two of them have half.
    fn work(since: Instant) -> Work {
        let mut work = Work::begin(since);
        work.total = 12_000;
        for (index, steps) in [2_000, 2_000, 0].into_iter().enumerate() {
            work.stands(index, steps);
        }
        work
    }

    #[test]
    fn the_pace_is_of_what_was_made_here() {
        let begin = Instant::now();
        let mut work = work(begin);
        let after = |work: &Work, seconds| work.pace(begin + Duration::from_secs(seconds));
        assert_eq!(after(&work, 5), "");
        // Another process has brought it further.
        work.stands(1, 3_000);
        assert_eq!(after(&work, 5), "");
        work.makes(0, 2_500);
        work.makes(0, 3_000);
        assert_eq!((work.done, work.made), (6_000, 1_000));
        assert_eq!(after(&work, 10), "100 control steps/s, 60 seconds left");
    }

    #[derive(Clone, Debug, Default)]
    struct Screen(Arc<Mutex<String>>);

    impl TermLike for Screen {
        fn width(&self) -> u16 {
            120
        }
        fn move_cursor_up(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_down(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_right(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_left(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn write_line(&self, text: &str) -> io::Result<()> {
            self.write_str(text)
        }
        fn write_str(&self, text: &str) -> io::Result<()> {
            lock(&self.0).push_str(text);
            Ok(())
        }
        fn clear_line(&self) -> io::Result<()> {
            lock(&self.0).clear();
            Ok(())
        }
        fn flush(&self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_bar_that_goes_on_shows_no_pace_before_the_first_update() {
        let screen = Screen::default();
        let target = ProgressDrawTarget::term_like(Box::new(screen.clone()));
        let bars = Bars::new("runs/quick", work(Instant::now()), target);
        bars.overall.force_draw();
        let shown = lock(&screen.0).clone();
        assert!(shown.contains("runs/quick") && shown.contains(" 33 %"), "{shown}");
        assert!(!shown.contains("control steps/s") && !shown.contains("left"), "{shown}");

        lock(&bars.work).makes(2, 2_000);
        bars.show();
        bars.overall.force_draw();
        let shown = lock(&screen.0).clone();
        assert!(shown.contains(" 50 %") && shown.contains(" control steps/s, "), "{shown}");
    }
}
