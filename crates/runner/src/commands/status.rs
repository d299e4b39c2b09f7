//! `itarl status`: where each cell of a run stands.

use std::{
    collections::{BTreeMap, BTreeSet},
    io::{IsTerminal, stdout},
    thread,
    time::Duration,
};

use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};
use figures::{Information, Measure};
use indicatif::HumanDuration;
use runs::{CellStatus, Look, Row, State, Writer};
use serde::Serialize;

use super::{Outcome, json::print_json, print, print_line, published_note};
use crate::{catalogue::Catalogue, cli::Status};

/// Clears a terminal.
const CLEAR: &[u8] = b"\x1b[H\x1b[2J";

pub(super) fn status(arguments: &Status) -> anyhow::Result<Outcome> {
    let look = if arguments.check { Look::Thorough } else { Look::Quick };
    loop {
        let catalogue = Catalogue::open(&arguments.run)?;
        let cells = catalogue.status(look);
        let outcome = outcome(&cells);
        if arguments.print.json {
            print_json("status", Report::new(&arguments.run.display().to_string(), &cells))?;
        } else {
            if arguments.watch.is_some() && stdout().is_terminal() {
                print(CLEAR)?;
            }
            show(&cells, &catalogue.measure())?;
            published_note(&catalogue).iter().try_for_each(print_line)?;
        }
        let is_over = cells.iter().all(|cell| is_broken(cell) || cell.state == State::Done);
        match arguments.watch.filter(|_| !is_over) {
            Some(seconds) => thread::sleep(Duration::from_secs(seconds)),
            None => return Ok(outcome),
        }
    }
}

fn is_broken(cell: &CellStatus) -> bool {
    matches!(cell.state, State::Failed(_) | State::Unreadable(_))
}

/// As training would end that leaves the run like that.
fn outcome(cells: &[CellStatus]) -> Outcome {
    if cells.iter().any(is_broken) {
        return Outcome::Failed;
    }
    let all_done = cells.iter().all(|cell| cell.state == State::Done);
    if all_done { Outcome::Done } else { Outcome::Stopped }
}

fn show(cells: &[CellStatus], measure: &Measure) -> anyhow::Result<()> {
    print_line(table(cells, measure))?;
    print_line(summary(cells))?;
    if let Some(pace) = Pace::of(cells) {
        print_line(pace)?;
    }
    measure.caveats.iter().try_for_each(print_line)?;
    for cell in cells {
        if let State::Failed(reason) | State::Unreadable(reason) = &cell.state {
            print_line(format_args!("{}/seed={}: {reason}", cell.setting, cell.seed))?;
        }
    }
    Ok(())
}

/// How fast all workers together are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Pace {
    workers: usize,
    machines: usize,
    /// Cells from their beginning to their end.
    cells_per_hour: f64,
    /// Until all cells are done, if as many stay at work.
    seconds_left: f64,
}

impl Pace {
    /// None while nobody has made an update.
    fn of(cells: &[CellStatus]) -> Option<Self> {
        let share = |updates: f64, cell: &CellStatus| updates / cell.target_updates.max(1) as f64;
        let per_second: f64 = cells.iter().filter_map(|cell| Some(share(cell.pace?, cell))).sum();
        let left: f64 = cells
            .iter()
            .filter(|cell| !is_broken(cell))
            .map(|cell| 1.0 - share(cell.updates() as f64, cell))
            .sum();
        let workers: BTreeSet<_> = cells.iter().filter_map(worker).collect();
        let machines: BTreeSet<_> = workers.iter().map(|(host, ..)| host).collect();
        (per_second > 0.0).then(|| Self {
            workers: workers.len(),
            machines: machines.len(),
            cells_per_hour: 3600.0 * per_second,
            seconds_left: left / per_second,
        })
    }
}

fn worker(cell: &CellStatus) -> Option<(&str, u32, &str)> {
    let Writer { host, process, start } = cell.writer.as_ref()?;
    Some((host, *process, start))
}

impl std::fmt::Display for Pace {
    /// `3 workers on 2 machines: 12.5 cells an hour, 3 hours left`
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let count = |n, one| format!("{n} {one}{}", if n == 1 { "" } else { "s" });
        let left = Duration::try_from_secs_f64(self.seconds_left).unwrap_or(Duration::MAX);
        write!(
            formatter,
            "{} on {}: {:.1} cells an hour, {} left",
            count(self.workers, "worker"),
            count(self.machines, "machine"),
            self.cells_per_hour,
            HumanDuration(left)
        )
    }
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report<'a> {
    run: &'a str,
    /// How many cells are in each state that any is in.
    counts: BTreeMap<&'static str, usize>,
    pace: Option<Pace>,
    cells: Vec<CellReport<'a>>,
}

#[derive(Serialize)]
struct CellReport<'a> {
    index: usize,
    setting: &'a str,
    seed: u64,
    state: &'static str,
    reason: Option<&'a str>,
    updates: u64,
    saved_updates: u64,
    target_updates: u64,
    writer: Option<&'a Writer>,
    latest: Option<&'a Row>,
}

impl<'a> Report<'a> {
    fn new(run: &'a str, cells: &'a [CellStatus]) -> Self {
        let mut counts = BTreeMap::new();
        cells.iter().for_each(|cell| *counts.entry(state(&cell.state)).or_insert(0) += 1);
        let of = |cell: &'a CellStatus| CellReport {
            index: cell.index,
            setting: &cell.setting,
            seed: cell.seed,
            state: state(&cell.state),
            reason: match &cell.state {
                State::Failed(reason) | State::Unreadable(reason) => Some(reason),
                _ => None,
            },
            updates: cell.updates(),
            saved_updates: cell.saved_updates,
            target_updates: cell.target_updates,
            writer: cell.writer.as_ref(),
            latest: cell.latest.as_ref(),
        };
        Self { run, counts, pace: Pace::of(cells), cells: cells.iter().map(of).collect() }
    }
}

/// One row a cell, with the values of its newest update.
fn table(cells: &[CellStatus], measure: &Measure) -> Table {
    let mut table = Table::new();
    let information = measure.information.as_ref();
    let header = ["cell", "setting", "seed", "state", "update", "R"].map(str::to_owned);
    let values = information.map(Information::heading).into_iter().chain([measure.heading()]);
    let header: Vec<_> = header.into_iter().chain(values).collect();
    let n_numbers = header.len();
    table.load_preset(ASCII_MARKDOWN).set_header(header.into_iter().chain(["at work".into()]));
    for cell in cells {
        let value = |of: &dyn Fn(&Row) -> f64| {
            cell.latest.as_ref().map_or(String::new(), |row| format!("{:.4}", of(row)))
        };
        let row = [
            cell.index.to_string(),
            cell.setting.clone(),
            cell.seed.to_string(),
            state(&cell.state).into(),
            format!("{}/{}", cell.updates(), cell.target_updates),
            cell.latest.as_ref().map_or(String::new(), |row| format!("{:.3e}", row.reward)),
        ];
        let nats = information.map(|_| value(&|row| row.intrinsic_nats));
        let worker =
            worker(cell).map_or(String::new(), |(host, process, _)| format!("{host}:{process}"));
        let values = nats.into_iter().chain([value(&|row| measure.of(row)), worker]);
        table.add_row(row.into_iter().chain(values));
    }
    for column in [0, 2].into_iter().chain(4..n_numbers) {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

fn state(state: &State) -> &'static str {
    match state {
        State::Waiting => "waiting",
        State::Running => "running",
        State::Stopped => "stopped",
        State::Done => "done",
        State::Failed(_) => "failed",
        State::Unreadable(_) => "unreadable",
    }
}

/// `16 cells: 3 done, 2 running, 11 waiting`
pub(super) fn summary(cells: &[CellStatus]) -> String {
    let names = ["done", "running", "stopped", "waiting", "failed", "unreadable"];
    let counts = names.iter().filter_map(|name| {
        let count = cells.iter().filter(|cell| state(&cell.state) == *name).count();
        (count > 0).then(|| format!("{count} {name}"))
    });
    let counts: Vec<_> = counts.collect();
    let n = cells.len();
    format!("{n} {}: {}", if n == 1 { "cell" } else { "cells" }, counts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(state: State, updates: u64, by: Option<(&str, u32)>, pace: Option<f64>) -> CellStatus {
        let writer = by.map(|(host, process)| Writer {
            host: host.into(),
            process,
            start: "2026-03-01T12:00:00.000000000Z".into(),
        });
        let latest = Some(Row { update: updates, ..Row::default() });
        let (index, setting, seed) = (0, "base".into(), 1);
        let (saved_updates, target_updates) = (updates, 100);
        CellStatus {
            index,
            setting,
            seed,
            state,
            saved_updates,
            target_updates,
            latest,
            writer,
            pace,
        }
    }

    #[test]
    fn the_pace_is_of_all_workers_and_what_failed_is_not_left() {
        let a = Some(("node1", 1));
        let mut cells = vec![
            cell(State::Done, 100, None, None),
            cell(State::Running, 50, a, Some(0.1)),
            cell(State::Running, 50, Some(("node2", 1)), Some(0.3)),
            cell(State::Running, 0, a, None),
            cell(State::Failed("?".into()), 10, None, None),
        ];
        let pace = Pace::of(&cells).unwrap();
        assert!(
            (pace.cells_per_hour - 14.4).abs() < 1e-9 && (pace.seconds_left - 500.0).abs() < 1e-9
        );
        let text = "2 workers on 2 machines: 14.4 cells an hour, 8 minutes left";
        assert_eq!(pace.to_string(), text);
        assert_eq!(outcome(&cells), Outcome::Failed);
        cells.pop();
        assert_eq!(outcome(&cells), Outcome::Stopped);
        assert_eq!(outcome(&cells[..1]), Outcome::Done);
        assert_eq!(Pace::of(&cells[..1]), None);
    }
}
