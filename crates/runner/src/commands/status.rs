//! `itarl status`: where each cell of a run stands.

use std::path::Path;

use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};
use figures::Measure;
use runs::{CellStatus, Row, State};

use super::{Outcome, print_line, published_note};
use crate::catalogue::Catalogue;

pub(super) fn status(folder: &Path) -> anyhow::Result<Outcome> {
    let catalogue = Catalogue::open(folder)?;
    let (cells, measure) = (catalogue.status(), catalogue.measure());
    print_line(table(&cells, &measure))?;
    print_line(summary(&cells))?;
    published_note(&catalogue).iter().try_for_each(print_line)?;
    measure.caveat.iter().try_for_each(print_line)?;
    let broken = |cell: &&CellStatus| matches!(cell.state, State::Failed(_) | State::Unreadable(_));
    for cell in cells.iter().filter(broken) {
        if let State::Failed(reason) | State::Unreadable(reason) = &cell.state {
            print_line(format_args!("{}/seed={}: {reason}", cell.setting, cell.seed))?;
        }
    }
    let any_broken = cells.iter().any(|cell| broken(&cell));
    Ok(if any_broken { Outcome::Failed } else { Outcome::Done })
}

/// One row a cell, with the values of its newest update.
fn table(cells: &[CellStatus], measure: &Measure) -> Table {
    let mut table = Table::new();
    table.load_preset(ASCII_MARKDOWN).set_header([
        "cell",
        "setting",
        "seed",
        "state",
        "update",
        "R",
        "R_MI nats",
        &format!("{} {}", measure.symbol, measure.unit),
    ]);
    for cell in cells {
        let value = |of: &dyn Fn(&Row) -> f64| {
            cell.latest.as_ref().map_or(String::new(), |row| format!("{:.4}", of(row)))
        };
        table.add_row([
            cell.index.to_string(),
            cell.setting.clone(),
            cell.seed.to_string(),
            state(&cell.state).into(),
            format!("{}/{}", cell.updates(), cell.target_updates),
            cell.latest.as_ref().map_or(String::new(), |row| format!("{:.3e}", row.reward)),
            value(&|row| row.intrinsic_nats),
            value(&|row| measure.of(row)),
        ]);
    }
    for column in [0, 2, 4, 5, 6, 7] {
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
