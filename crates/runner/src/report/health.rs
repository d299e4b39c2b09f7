//! What is wrong with how cells learn: a row a symptom, with the cells that have it.

use std::collections::BTreeMap;

use figures::KINDS;
use maud::{Markup, html};

use crate::health::Patient;

/// Cells that are named in a row; of more, only how many.
const NAMED: usize = 4;

pub(super) fn section(patients: &[Patient], cells: usize) -> Markup {
    html! {
        h2 { "Health" }
        @if patients.is_empty() {
            p { "Nothing is found in " (cells) " cells." }
        } @else {
            p { (patients.len()) " of " (cells) " cells have a symptom." }
            div .scroll tabindex="0" role="region" aria-label="health" {
                table id="table-health" {
                    thead { tr {
                        @for name in ["symptom", "cells", "since update", "found, in the first of them", "what to try"] {
                            th scope="col" .text { (name) }
                        }
                    } }
                    tbody { @for kind in KINDS { (row(kind, patients)) } }
                }
            }
        }
        p .faint {
            "What lasts to a cell's end, for at least a tenth of its updates; " code { "itarl check" }
            " has each cell, docs/health.md how each is found."
        }
    }
}

fn row(kind: &figures::Kind, patients: &[Patient]) -> Markup {
    let found = patients.iter().flat_map(|patient| {
        let own = patient.symptoms.iter().filter(|it| it.kind == kind);
        own.map(move |it| (patient, it))
    });
    let found: Vec<_> = found.collect();
    let since: BTreeMap<_, _> = found.iter().filter_map(|it| Some((it.1.since?, ()))).collect();
    let names = found.iter().take(NAMED).map(|it| format!("{}/seed={}", it.0.setting, it.0.seed));
    let names = names.collect::<Vec<_>>().join("; ");
    html! { @if let Some((_, first)) = found.first() { tr {
        td .text { (kind.name) }
        td .text { (found.len()) ": " (names) @if found.len() > NAMED { "; \u{2026}" } }
        td .text {
            @match (since.keys().next(), since.keys().next_back()) {
                (Some(a), Some(b)) if a != b => { (a) "\u{2013}" (b) }
                (Some(a), _) => { (a) }
                _ => { "\u{2013}" }
            }
        }
        td .text { (first.found) }
        td .text { (kind.advice) }
    } } }
}
