//! What was run: settings, seeds, versions, how far it is, and what is wrong with it.

use figures::{Omitted, grouped};
use maud::{Markup, html};
use runs::{CellStatus, Precision, Run, State};

use crate::{comparison::Comparison, experiment::Plan};

/// The run's folder, without the way to it.
pub(super) fn name(run: &Run) -> String {
    let folder = run.folder().canonicalize().unwrap_or_else(|_| run.folder().into());
    folder.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// What was run, in a few lines.
pub(super) fn introduction(run: &Run, plan: &Plan, cells: &[CellStatus]) -> Markup {
    let manifest = run.manifest();
    let first = plan.cells().first().map(|cell| &cell.experiment);
    let mut settings: Vec<&str> = manifest.cells.iter().map(|it| it.setting.as_str()).collect();
    settings.dedup();
    let precision = match manifest.bullet.precision {
        Precision::Single => "single",
        Precision::Double => "double",
    };
    let bullet = format!("{}.{:02}", manifest.bullet.version / 100, manifest.bullet.version % 100);
    let models = manifest.models.iter().map(|model| model.file.as_str()).collect::<Vec<_>>();
    html! {
        @if let Some(description) = first.and_then(|it| it.description.as_ref()) { p { (description) } }
        dl {
            dt { "settings" }
            dd { (settings.join("; ")) }
            dt { "seeds" }
            dd { (manifest.seeds.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")) }
            dt { "cells" }
            dd { (counts(cells)) }
            dt { "time" }
            dd { (time(plan, cells)) }
            dt { "model" }
            dd { (models.join(", ")) }
            @if let Some(published) = &manifest.published {
                dt { "published" }
                dd { "with curves as means over " (published.every) " updates, and without checkpoints" }
            }
            dt { "versions" }
            dd { "itarl " (manifest.itarl) ", Bullet " (bullet) " in " (precision) " precision" }
        }
    }
}

/// As `itarl status` says it.
fn counts(cells: &[CellStatus]) -> String {
    let of = |name: &str, is: fn(&State) -> bool| {
        let n = cells.iter().filter(|cell| is(&cell.state)).count();
        (n > 0).then(|| format!("{n} {name}"))
    };
    let counts: Vec<_> = [
        of("done", |it| matches!(it, State::Done)),
        of("running", |it| matches!(it, State::Running)),
        of("stopped", |it| matches!(it, State::Stopped)),
        of("waiting", |it| matches!(it, State::Waiting)),
        of("failed", |it| matches!(it, State::Failed(_))),
        of("unreadable", |it| matches!(it, State::Unreadable(_))),
    ]
    .into_iter()
    .flatten()
    .collect();
    format!("{}: {}", cells.len(), counts.join(", "))
}

/// Of the robots, since the page of the same files is the same whenever it's made.
fn time(plan: &Plan, cells: &[CellStatus]) -> String {
    let done = cells.iter().map(CellStatus::updates).fold(0, u64::saturating_add);
    let settings = plan.cells().iter().map(|cell| &cell.experiment);
    let steps = settings
        .clone()
        .zip(cells)
        .map(|(it, cell)| cell.updates().saturating_mul(it.learning.control_steps_per_update()));
    let steps = steps.fold(0, u64::saturating_add);
    let seconds: f64 = settings
        .zip(cells)
        .map(|(it, cell)| {
            cell.updates() as f64 * it.learning.control_steps_per_update() as f64
                / it.control.frequency_hz
        })
        .sum();
    let [done, steps] = [done, steps].map(grouped);
    format!("{done} updates, {steps} control steps, {} of the robots' time", duration(seconds))
}

fn duration(seconds: f64) -> String {
    match seconds {
        ..120.0 => format!("{seconds:.0} s"),
        ..7200.0 => format!("{:.0} min", seconds / 60.0),
        ..172_800.0 => format!("{:.1} h", seconds / 3600.0),
        _ => format!("{:.1} days", seconds / 86_400.0),
    }
}

/// Cells that ended early, and what couldn't be read.
pub(super) fn problems<'a>(
    cells: impl Iterator<Item = &'a CellStatus>,
    omitted: &[Omitted],
) -> Markup {
    let failed: Vec<_> = cells
        .filter_map(|cell| match &cell.state {
            State::Failed(reason) => Some((cell, reason)),
            _ => None,
        })
        .collect();
    html! {
        @if !omitted.is_empty() {
            div .problems {
                p { strong { "Left out, because it can't be read:" } }
                ul { @for it in omitted { li { strong { (it.cell) } ": " (it.reason) } } }
            }
        }
        @if !failed.is_empty() {
            div .problems {
                p { strong { "Ended early:" } }
                ul { @for (cell, reason) in failed {
                    li { strong { (cell.setting) "/seed=" (cell.seed) } ": " (reason) }
                } }
            }
        }
    }
}

/// In what several runs differ; nothing of one.
pub(super) fn differences(comparison: &Comparison) -> Markup {
    let (runs, differences) = (comparison.catalogues(), comparison.differences());
    html! { @if runs.len() > 1 {
        h2 { "What differs" }
        @if !differences.is_empty() {
            div .scroll tabindex="0" role="region" aria-label="what differs" {
                table id="differences" {
                    thead { tr {
                        th scope="col" .text { "setting" }
                        @for run in runs { th scope="col" .text { (name(run.run())) } }
                    } }
                    tbody { @for it in differences { tr {
                        td .text { code { (it.key) } }
                        @for run in 0..runs.len() { td .text { (it.shown(run)) } }
                    } } }
                }
            }
        }
        p .faint { "All " @if !differences.is_empty() { "other " } "settings agree, but for lengths, seeds and what is recorded." }
    } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_told_in_a_fitting_unit() {
        for (seconds, text) in
            [(59.6, "60 s"), (600.0, "10 min"), (9000.0, "2.5 h"), (302_400.0, "3.5 days")]
        {
            assert_eq!(duration(seconds), text);
        }
    }
}
