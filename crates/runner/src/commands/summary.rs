//! `itarl summary`: what was learned, early updates against late ones, for each setting.
//!
//! Each cell gives the mean of a value over its early updates and that over its late ones. A
//! [paired t-test](paired_t) over the cells of a setting asks whether
//! what the run is judged by, its task's own value, is higher late. Several runs have one table;
//! `comparing.rs` says which of them is better, and in what they differ.

mod comparing;

use anyhow::{Context, bail};
use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};
use figures::{
    Measure, Omitted,
    statistics::{deviation, mean, paired_t},
    tenth_of,
};
use runs::Row;
use serde::Serialize;

use super::{Outcome, json::print_json, print_line, published_notes};
use crate::{
    catalogue::RunCell,
    cli::{Summary, Updates},
    comparison::Comparison,
    progress::notify,
};

/// What a cell did in early and in late updates.
#[derive(Clone, Copy, Debug, Default)]
struct Windows {
    intrinsic_nats: [f64; 2],
    performance: [f64; 2],
}

pub(super) fn summary(arguments: &Summary) -> anyhow::Result<Outcome> {
    let comparison = Comparison::open(&arguments.runs)?;
    let measure = comparison.measure()?;
    let catalogues = comparison.catalogues();
    catalogues.iter().try_for_each(|it| require_whole(arguments, it.every()))?;
    let mut read = Vec::new();
    for run in 0..catalogues.len() {
        read.push(OfRun::read(&comparison, run, &measure, arguments)?);
    }
    if arguments.print.json {
        read.iter().try_for_each(|it| it.print_json(&measure))?;
    } else {
        print_all(&comparison, &read, &measure)?;
    }
    Ok(if read.iter().all(|it| it.unreadable == 0) { Outcome::Done } else { Outcome::Failed })
}

/// What a run's cells learned.
struct OfRun {
    run: String,
    early: Updates,
    late: Updates,
    settings: Vec<Learned>,
    /// Cells that don't have these updates, or can't be read.
    left_out: Vec<String>,
    unreadable: usize,
}

impl OfRun {
    /// What can't be read is said, and what doesn't have the windows.
    fn read(
        comparison: &Comparison,
        run: usize,
        measure: &Measure,
        arguments: &Summary,
    ) -> anyhow::Result<Self> {
        let catalogue = &comparison.catalogues()[run];
        let every = catalogue.every();
        let (curves, mut left_out) = curves(comparison, run, measure);
        let unreadable = left_out.len();
        let n_updates: Vec<_> = curves.iter().map(|(_, it)| it.len() as u64 * every).collect();
        let windows = chosen(arguments, reached(&n_updates), every);
        let mut settings: Vec<(String, Vec<Windows>)> = Vec::new();
        for ((run_cell, curve), n) in curves.iter().zip(n_updates) {
            let cell = &run_cell.cell;
            let [first, second] = windows.map(|window| means(curve, window, every));
            let (Some(first), Some(second)) = (first, second) else {
                left_out.push(cell.folder().display().to_string());
                if !arguments.print.json {
                    let path = run_cell.folder.metrics();
                    let [early, late] = windows;
                    print_line(format_args!(
                        "{}: left out: it has {n} updates, and not all of {early} and {late}",
                        path.display()
                    ))?;
                }
                continue;
            };
            let learned =
                Windows { intrinsic_nats: [first.0, second.0], performance: [first.1, second.1] };
            match settings.iter_mut().find(|(setting, _)| *setting == cell.setting) {
                Some((_, cells)) => cells.push(learned),
                None => settings.push((cell.setting.clone(), vec![learned])),
            }
        }
        let folder = catalogue.run().folder().display().to_string();
        if settings.is_empty() {
            bail!("{folder}: no cell has the updates that are asked for");
        }
        let [early, late] = windows;
        let settings = settings.into_iter().map(|(name, of)| Learned::of(name, &of)).collect();
        Ok(Self { run: folder, early, late, settings, left_out, unreadable })
    }

    fn print_json(&self, measure: &Measure) -> anyhow::Result<()> {
        let Self { run, early, late, settings, left_out, .. } = self;
        let performance = Performance { symbol: &measure.symbol, unit: &measure.unit };
        print_json("summary", Report { run, early, late, performance, settings, left_out })
    }
}

/// A row as far as it's told of.
struct Point {
    update: u64,
    intrinsic_nats: f64,
    performance: f64,
}

/// A cell, with a point for each of its rows.
type Curve<'a> = (&'a RunCell, Vec<Point>);

/// The cells that were begun, and the names of those that can't be read, which is said.
fn curves<'a>(
    comparison: &'a Comparison,
    run: usize,
    measure: &Measure,
) -> (Vec<Curve<'a>>, Vec<String>) {
    let catalogue = &comparison.catalogues()[run];
    let point = |row: Row| Point {
        update: row.update,
        intrinsic_nats: row.intrinsic_nats,
        performance: measure.of(&row),
    };
    let read = runs::parallel::map(catalogue.cells(), |cell| -> Result<Vec<_>, _> {
        Ok(catalogue.rows(cell)?.into_iter().map(point).collect())
    });
    let (mut curves, mut unreadable) = (Vec::new(), Vec::new());
    for (cell, points) in catalogue.cells().iter().zip(read) {
        match points {
            Ok(points) if points.is_empty() && !cell.folder.metrics().exists() => {}
            Ok(points) => curves.push((cell, points)),
            Err(error) => {
                let error: runs::Error = error;
                let name = cell.cell.folder().display().to_string();
                notify(comparison.of_run(run, Omitted::new(&name, error)));
                unreadable.push(name);
            }
        }
    }
    (curves, unreadable)
}

/// Updates that windows are chosen of, of cells with so many each: those that are reached by the cells whose
/// updates up to there are the most in all. One cell that has gone on doesn't leave the others out, nor one
/// that has hardly begun shorten theirs.
fn reached(n_updates: &[u64]) -> u64 {
    let covered = |n: u64| n_updates.iter().filter(|it| **it >= n).count() as u64 * n;
    n_updates.iter().copied().max_by_key(|&n| (covered(n), n)).unwrap_or(0)
}

/// A table of all settings; of several runs also what differs, and which is better.
fn print_all(comparison: &Comparison, read: &[OfRun], measure: &Measure) -> anyhow::Result<()> {
    for OfRun { run, early, late, .. } in read {
        let run = comparison.alone().map_or(format!("{run}: "), |_| String::new());
        print_line(format_args!("{run}means over updates {early} (early) and {late} (late)"))?;
    }
    let rows = read.iter().enumerate().flat_map(|(run, of)| {
        of.settings.iter().map(move |it| (comparison.named(run, &it.setting), it))
    });
    let rows: Vec<_> = rows.collect();
    print_line(table(&rows, measure))?;
    print_line(format_args!(
        "p: one-sided paired t-test of {}, late above early, over a setting's seeds; - of one seed",
        measure.symbol
    ))?;
    if comparison.alone().is_none() {
        print_line(comparing::interquartile_means(&rows, measure))?;
        comparing::better(comparison, read, measure)?;
        comparing::differences(comparison)?;
    }
    published_notes(comparison).iter().try_for_each(print_line)?;
    measure.caveats.iter().try_for_each(print_line)
}

/// What the cells of a setting learned; early and late where there are two numbers.
#[derive(Serialize)]
struct Learned {
    setting: String,
    seeds: usize,
    intrinsic_nats: [f64; 2],
    performance: [f64; 2],
    deviation_late: Option<f64>,
    best_late: f64,
    t: Option<f64>,
    p: Option<f64>,
    /// Of each cell, late.
    #[serde(skip)]
    late: Vec<f64>,
}

impl Learned {
    fn of(setting: String, cells: &[Windows]) -> Self {
        let column = |of: &dyn Fn(&Windows) -> f64| cells.iter().map(of).collect::<Vec<f64>>();
        let early_and_late =
            |of: fn(&Windows) -> [f64; 2]| [0, 1].map(|i| mean(&column(&|it| of(it)[i])));
        let late = column(&|it| it.performance[1]);
        let test = paired_t(&column(&|it| it.performance[1] - it.performance[0]));
        Self {
            setting,
            seeds: cells.len(),
            intrinsic_nats: early_and_late(|it| it.intrinsic_nats),
            performance: early_and_late(|it| it.performance),
            deviation_late: deviation(&late),
            best_late: late.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            t: test.map(|(t, _)| t),
            p: test.map(|(_, p)| p),
            late,
        }
    }
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report<'a> {
    run: &'a str,
    early: &'a Updates,
    late: &'a Updates,
    performance: Performance<'a>,
    settings: &'a [Learned],
    left_out: &'a [String],
}

/// What cells are judged by.
#[derive(Serialize)]
struct Performance<'a> {
    symbol: &'a str,
    unit: &'a str,
}

/// That windows which are asked for have whole rows, of so many updates each.
fn require_whole(arguments: &Summary, every: u64) -> anyhow::Result<()> {
    let is_whole = |window: &Updates| {
        (window.first - 1).is_multiple_of(every) && window.last.is_multiple_of(every)
    };
    let windows = [("--early", arguments.early), ("--late", arguments.late)];
    for (name, window) in windows.into_iter().filter_map(|(name, it)| Some((name, it?))) {
        if !is_whole(&window) {
            bail!(
                "{name} must have whole rows, which are means over {every} updates in this published \
                 run, as in 1-{}, got {window}",
                2 * every
            );
        }
    }
    Ok(())
}

/// As asked, or the first and the last tenth of so many updates, in whole rows, at least one.
fn chosen(arguments: &Summary, n: u64, every: u64) -> [Updates; 2] {
    let n = n.max(every);
    let tenth = (tenth_of(n) / every).max(1) * every;
    [
        arguments.early.unwrap_or(Updates { first: 1, last: tenth }),
        arguments.late.unwrap_or(Updates { first: n + 1 - tenth, last: n }),
    ]
}

/// Of the information in nats and of the measure; none if an update is missing.
fn means(points: &[Point], window: Updates, every: u64) -> Option<(f64, f64)> {
    let inside = |point: &&Point| (window.first..=window.last).contains(&point.update);
    let points: Vec<_> = points.iter().filter(inside).collect();
    let mean_of = |of: fn(&Point) -> f64| mean(&points.iter().map(|it| of(it)).collect::<Vec<_>>());
    (points.len() as u64 * every == window.last + 1 - window.first)
        .then(|| (mean_of(|it| it.intrinsic_nats), mean_of(|it| it.performance)))
}

fn table(settings: &[(String, &Learned)], measure: &Measure) -> Table {
    let mut table = Table::new();
    let information = measure.information.as_ref();
    let early_and_late = |heading: String| [format!("{heading} early"), "late".into()];
    let nats = information.map(|it| early_and_late(it.heading()));
    let performance = early_and_late(measure.heading());
    let header = ["setting", "seeds"].map(str::to_owned).into_iter();
    let header = header.chain(nats.into_iter().flatten()).chain(performance);
    let header = header.chain(["sd late", "best late", "t", "p"].map(str::to_owned));
    let header: Vec<_> = header.collect();
    let n_columns = header.len();
    table.load_preset(ASCII_MARKDOWN).set_header(header);
    for (name, it) in settings {
        let nats = information.map(|_| it.intrinsic_nats.map(|nats| format!("{nats:.4}")));
        let performance = [
            format!("{:+.5}", it.performance[0]),
            format!("{:+.5}", it.performance[1]),
            it.deviation_late.map_or("-".into(), |it| format!("{it:.5}")),
            format!("{:+.5}", it.best_late),
            it.t.map_or("-".into(), |t| format!("{t:.2}")),
            it.p.map_or("-".into(), |p| format!("{p:.1e}")),
        ];
        let row = [name.clone(), it.seeds.to_string()].into_iter();
        table.add_row(row.chain(nats.into_iter().flatten()).chain(performance));
    }
    for column in 1..n_columns {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

impl std::str::FromStr for Updates {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let parse = || {
            let (first, last) = text.split_once('-')?;
            let (first, last) = (first.parse().ok()?, last.parse().ok()?);
            (1 <= first && first <= last).then_some(Self { first, last })
        };
        parse().with_context(|| format!("FIRST-LAST expected, as in 200-300, got {text}"))
    }
}

impl std::fmt::Display for Updates {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}-{}", self.first, self.last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_read_as_they_are_written() {
        let updates: Updates = "200-300".parse().unwrap();
        assert_eq!((updates.first, updates.last), (200, 300));
        assert_eq!(updates.to_string(), "200-300");
        for wrong in ["", "3", "0-4", "5-4", "a-b", "1-2-3"] {
            assert!(wrong.parse::<Updates>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn means_need_all_updates() {
        let point = |update| Point { update, intrinsic_nats: 0.5, performance: update as f64 };
        let points: Vec<_> = (1..=10).map(point).collect();
        let means_of = |first, last| means(&points, Updates { first, last }, 1);
        assert_eq!(means_of(3, 5), Some((0.5, 4.0)));
        assert_eq!(means_of(9, 11), None);
        // Of a published run: rows 4, 8, 12 are updates 1-4, 5-8 and 9-12.
        let points: Vec<_> = [4, 8, 12].map(point).into();
        let means_of = |first, last| means(&points, Updates { first, last }, 4);
        assert_eq!(means_of(5, 12), Some((0.5, 10.0)));
        assert_eq!(means_of(9, 16), None);
    }

    #[test]
    fn windows_are_of_the_updates_that_the_cells_have() {
        assert_eq!(reached(&[252, 240, 240, 240]), 240, "one has gone on");
        assert_eq!(reached(&[3, 240, 240, 240]), 240, "one has failed early");
        assert_eq!(reached(&[100, 101, 103, 110, 104]), 100, "they run");
        assert_eq!(reached(&[1000, 1000, 10, 10, 0]), 1000, "some haven't begun yet");
        assert_eq!((reached(&[7]), reached(&[0]), reached(&[])), (7, 0, 0));
    }
}
