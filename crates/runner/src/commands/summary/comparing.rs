//! Several runs against each other: interquartile means, probabilities of improvement, what differs.

use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};
use figures::{Measure, improvement, iqm};

use super::{Learned, OfRun};
use crate::{commands::print_line, comparison::Comparison};

/// A row for each setting of each run.
pub(super) fn interquartile_means(rows: &[(String, &Learned)], measure: &Measure) -> Table {
    let mut table = Table::new();
    let Measure { symbol, unit, .. } = measure;
    let iqm_header = format!("{symbol} {unit} late, IQM [95 %]");
    table.load_preset(ASCII_MARKDOWN).set_header(["setting", "cells", &iqm_header]);
    for (name, it) in rows {
        table.add_row([name.clone(), it.seeds.to_string(), iqm(&it.late).to_string()]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// For each two runs, the settings that both have by the same name; where there's none, the best of each.
pub(super) fn better(
    comparison: &Comparison,
    read: &[OfRun],
    measure: &Measure,
) -> anyhow::Result<()> {
    print_line(format_args!(
        "probability that a cell of the first has a higher {} late than one of the second:",
        measure.symbol
    ))?;
    for (i, j) in (0..read.len()).flat_map(|j| (0..j).map(move |i| (i, j))) {
        for (a, b) in pairs(&read[i].settings, &read[j].settings) {
            let names = [(i, a), (j, b)].map(|(run, it)| comparison.named(run, &it.setting));
            let told = match improvement(&a.late, &b.late) {
                Some(probability) => probability.to_string(),
                None => "one cell can't tell".into(),
            };
            print_line(format_args!("  {} over {}: {told}", names[0], names[1]))?;
        }
    }
    Ok(())
}

fn pairs<'a>(a: &'a [Learned], b: &'a [Learned]) -> Vec<(&'a Learned, &'a Learned)> {
    let same = a.iter().filter_map(|a| Some((a, b.iter().find(|b| b.setting == a.setting)?)));
    let same: Vec<_> = same.collect();
    if !same.is_empty() {
        return same;
    }
    let best = |of: &'a [Learned]| {
        of.iter().max_by(|a, b| iqm(&a.late).value.total_cmp(&iqm(&b.late).value))
    };
    best(a).zip(best(b)).into_iter().collect()
}

/// A row for each key that differs, a column for each run.
pub(super) fn differences(comparison: &Comparison) -> anyhow::Result<()> {
    let differences = comparison.differences();
    if differences.is_empty() {
        return print_line(
            "all settings agree; the runs differ in their folders, seeds or lengths alone",
        );
    }
    let mut table = Table::new();
    let runs = 0..comparison.catalogues().len();
    let names = runs.clone().map(|run| comparison.catalogues()[run].run().folder().display());
    let header = ["differs".to_owned()].into_iter().chain(names.map(|it| it.to_string()));
    table.load_preset(ASCII_MARKDOWN).set_header(header);
    for it in differences {
        table.add_row([it.key.clone()].into_iter().chain(runs.clone().map(|run| it.shown(run))));
    }
    print_line(table)?;
    print_line("all other settings agree")
}
