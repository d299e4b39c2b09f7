//! A run, or several that are compared, as one page that needs nothing else: what was run, what came of it, its figures, and the
//! robots in 3-D.
//!
//! It's made from the recorded files alone, and the same files give the same bytes. `facts.rs` says
//! what was run, `tables.rs` has the numbers, `findings.rs` what the paper found, `health.rs` what is wrong with how cells learn, [`Report::read`] chooses what is shown in 3-D: the best
//! and the median cell of each setting.

mod facts;
mod findings;
mod health;
mod tables;

use std::path::PathBuf;

use base64::{Engine, engine::general_purpose::STANDARD};
use figures::{Drawing, FIGURES, Measure, Omitted, Options, Results};
use maud::{Markup, html};
use runs::{CellStatus, Look};
use scenes::{
    page::page,
    viewer::{PAGE_BYTES, Packed},
};

use crate::{catalogue::RunCell, clips, comparison::Comparison, health::Patient};

/// Of all recordings together: a page of 150 cells stays below 15 MB.
const REPLAY_BYTES: usize = 8_000_000;

/// An SVG beyond this is shown as PNG, which doesn't grow with the number of lines.
const SVG_BYTES: usize = 700_000;

/// All that the page shows.
pub struct Report {
    comparison: Comparison,
    results: Results,
    /// Of each run.
    cells: Vec<Vec<CellStatus>>,
    patients: Vec<Patient>,
    replays: Packed,
    omitted: Vec<Omitted>,
}

/// How far making it has come: so much of so many, as in "cells read".
pub type Progress<'a> = dyn Fn(usize, usize, &str) + Sync + 'a;

impl Report {
    /// Reads a run's folder, finished or not, or several to compare.
    ///
    /// # Errors
    /// If there's no run, or no update in it yet.
    pub fn read(folders: &[PathBuf], progress: &Progress<'_>) -> anyhow::Result<Self> {
        let comparison = Comparison::open(folders)?;
        let (results, omitted) =
            comparison.results(&|done, total| progress(done, total, "cells read"))?;
        let cells = comparison.catalogues().iter().map(|it| it.status(Look::Thorough)).collect();
        let patients = crate::health::of(&comparison, Some(&results));
        let replays = Packed::default();
        let mut report = Self { comparison, results, cells, patients, replays, omitted };
        report.read_replays(progress);
        Ok(report)
    }

    /// What can't be read is left out and named.
    fn read_replays(&mut self, progress: &Progress<'_>) {
        let wanted = self.wanted();
        let each = REPLAY_BYTES / wanted.len().max(1);
        for (i, Wanted { setting, folder, label }) in wanted.iter().enumerate() {
            let Some((run, cell)) = self.comparison.cell(folder) else { continue };
            if !records(cell) {
                continue;
            }
            match clips::of_cell(&self.comparison.catalogues()[run], cell) {
                Ok(clip) => self.replays.add(setting, label, &clip, each.min(PAGE_BYTES)),
                Err(error) => {
                    let omitted =
                        Omitted::new(cell.cell.folder().display(), format_args!("{error:#}"));
                    let omitted = self.comparison.of_run(run, omitted);
                    if !self.omitted.contains(&omitted) {
                        self.omitted.push(omitted);
                    }
                }
            }
            progress(i + 1, wanted.len(), "replays read");
        }
    }

    /// The best and the median cell of each setting.
    fn wanted(&self) -> Vec<Wanted> {
        let chosen = figures::best_and_median(&self.results);
        let settings = self.results.settings.iter().zip(chosen);
        let roles = settings.flat_map(|(setting, choice)| {
            let roles = match choice.best == choice.median {
                true => vec![(choice.best, "best and median")],
                false => vec![(choice.best, "best"), (choice.median, "median")],
            };
            roles.into_iter().map(move |(index, role)| (setting, index, role))
        });
        let wanted = roles.map(|(setting, index, role)| {
            let cell = &setting.cells[index];
            let last = cell.outcome.last;
            let Measure { symbol, unit, .. } = &self.results.measure;
            Wanted {
                setting: setting.name.clone(),
                folder: cell.folder.clone(),
                label: format!(
                    "{role} of {}: seed {}, {symbol} {last:+.4} {unit}",
                    setting.name, cell.seed
                ),
            }
        });
        wanted.collect()
    }

    /// The cells that were left out, and why.
    #[must_use]
    pub fn omitted(&self) -> &[Omitted] {
        &self.omitted
    }

    /// The whole page.
    ///
    /// # Errors
    /// What can't be drawn.
    pub fn html(&self, progress: &Progress<'_>) -> anyhow::Result<String> {
        let catalogues = self.comparison.catalogues();
        let names = catalogues.iter().map(|it| facts::name(it.run()));
        let name = names.collect::<Vec<_>>().join(", ");
        let figures = self.figures(progress)?;
        let body = html! {
            header {
                h1 { (name) }
                @for (catalogue, cells) in catalogues.iter().zip(&self.cells) {
                    @if catalogues.len() > 1 { h2 { (facts::name(catalogue.run())) } }
                    (facts::introduction(catalogue.run(), catalogue.plan(), cells))
                }
                (facts::problems(self.cells.iter().flatten(), &self.omitted))
                (facts::differences(&self.comparison))
            }
            main {
                h2 { "What came of it" }
                (tables::all(&self.results))
                (health::section(&self.patients, self.cells.iter().map(Vec::len).sum()))
                (findings::section(&self.results))
                @if !self.replays.is_empty() {
                    h2 { "The robots" }
                    p .faint {
                        "The best and the median cell of each setting, by the mean "
                        (self.results.measure.symbol) " of the last "
                        (self.results.windows()) " updates, as they moved and learned in their last control steps."
                    }
                    (self.replays.markup(false))
                } @else if !catalogues.iter().flat_map(|it| it.cells()).any(records) {
                    h2 { "The robots" }
                    p .faint {
                        "No control steps were recorded (" code { "record.steps" } " is 0), so there "
                        "is nothing to replay."
                    }
                }
                h2 { "Figures" }
                (figures)
                h2 { "All settings" }
                @for catalogue in catalogues {
                    details {
                        summary {
                            @if catalogues.len() > 1 { (facts::name(catalogue.run())) ": " }
                            "experiment.toml, complete: " code { "itarl train" } " takes it again"
                        }
                        pre { (catalogue.run().experiment()) }
                    }
                }
            }
        };
        Ok(page(&format!("{name}: itarl report"), &body, &self.replays)?)
    }

    fn figures(&self, progress: &Progress<'_>) -> anyhow::Result<Markup> {
        let mut drawn = Vec::new();
        for (i, figure) in FIGURES.iter().enumerate() {
            match figures::draw(&self.results, figure, &Options::default()) {
                Ok(drawing) => drawn.push((figure, source(&drawing)?, drawing)),
                // There may be none of this run.
                Err(figures::Error::Nothing { .. }) => {}
                Err(error) => return Err(error.into()),
            }
            progress(i + 1, FIGURES.len(), "figures drawn");
        }
        Ok(html! { @for (figure, source, drawing) in &drawn {
            (one_figure(&figure.title(&self.results.measure), source, drawing))
        } })
    }
}

/// Whether the cell's experiment asks for recorded control steps.
fn records(cell: &RunCell) -> bool {
    cell.cell.experiment.record.steps > 0
}

struct Wanted {
    setting: String,
    folder: PathBuf,
    label: String,
}

fn one_figure(title: &str, source: &str, drawing: &Drawing) -> Markup {
    html! {
        h3 { (title) }
        figure {
            div .scroll tabindex="0" role="region" aria-label=(title) {
                img src=(source) alt=(drawing.caption) width=(drawing.width) height=(drawing.height);
            }
            figcaption { (drawing.caption) }
        }
    }
}

/// A data URL.
fn source(drawing: &Drawing) -> anyhow::Result<String> {
    let (kind, bytes) = match drawing.svg.len() <= SVG_BYTES {
        true => ("svg+xml", drawing.svg.clone().into_bytes()),
        false => ("png", drawing.png()?),
    };
    Ok(format!("data:image/{kind};base64,{}", STANDARD.encode(bytes)))
}
