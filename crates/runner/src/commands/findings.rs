//! `itarl findings`: the paper's statements, and what a run says to each.

use std::path::PathBuf;

use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};
use figures::{Findings, Group, Information, Measure, STATISTICS, three_digits};

use super::{Outcome, joined, print_line, published_notes};
use crate::{
    comparison::Comparison,
    progress::{Counter, notify},
};

pub(super) fn findings(folders: &[PathBuf], until: Option<u64>) -> anyhow::Result<Outcome> {
    let counter = Counter::new(joined(folders));
    let comparison = Comparison::open(folders)?.until(until);
    let (results, omitted) =
        comparison.results(&|done, total| counter.report(done, total, "cells read"))?;
    counter.aside(|| omitted.iter().for_each(notify));
    let findings = Findings::of(&results);
    findings.groups.iter().try_for_each(|group| print_group(group, &results.measure))?;
    for name in &findings.left_out {
        print_line(format_args!("{name}: left out, since its xi changes"))?;
    }
    findings.notes.iter().try_for_each(print_line)?;
    if let Some(update) = until {
        print_line(format_args!("cells that have {update} updates, as they were then"))?;
    }
    published_notes(&comparison).iter().try_for_each(print_line)?;
    results.measure.caveats.iter().try_for_each(print_line)?;
    Ok(if omitted.is_empty() { Outcome::Done } else { Outcome::Failed })
}

fn print_group(group: &Group, measure: &Measure) -> anyhow::Result<()> {
    if !group.name.is_empty() {
        print_line(&group.name)?;
    }
    print_line(table(group, measure))?;
    if let Some(probability) = group.improvement {
        print_line(format_args!(
            "probability that a cell with xi = 0.75 ends higher than one with xi = 1: {probability}"
        ))?;
    }
    if let Some((r, information)) = group.correlation.zip(measure.information.as_ref()) {
        let both = [&measure.symbol, &information.symbol].map(String::as_str).join(" and ");
        print_line(format_args!("r of {both} over all updates: {r}"))?;
    }
    for (i, statement) in group.statements.iter().enumerate() {
        print_line(format_args!("\n{}. {}: {}", i + 1, statement.text, statement.verdict))?;
        for part in &statement.evidence {
            print_line(format_args!("   {}", part.said()))?;
        }
    }
    print_line("")
}

/// A row for each xi: what its cells came to.
fn table(group: &Group, Measure { symbol, unit, information, .. }: &Measure) -> Table {
    let mut table = Table::new();
    let statistics = STATISTICS.map(|name| format!("{symbol} {name} {unit}"));
    let header = ["xi", "cells"].map(str::to_owned).into_iter().chain(statistics);
    let both = |it: &Information| [format!("{} mean {}", it.symbol, it.unit), "r of both".into()];
    let header = header.chain(information.iter().flat_map(both));
    table.load_preset(ASCII_MARKDOWN).set_header(header);
    for mix in &group.mixes {
        let numbers = [mix.xi.to_string(), mix.n.to_string()];
        let r = mix.correlation.map_or("-".into(), three_digits);
        let both = information.iter().flat_map(|_| [mix.intrinsic_nats.to_string(), r.clone()]);
        table.add_row(numbers.into_iter().chain(mix.last.map(|it| it.to_string())).chain(both));
    }
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
