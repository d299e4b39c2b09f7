//! What the paper found, and what this run says to it: where it has several xi.

use figures::{Findings, Group, Mix, Results, STATISTICS, Verdict};
use maud::{Markup, html};

/// Nothing where no xi can be compared with another.
pub(super) fn section(run: &Results) -> Markup {
    let findings = Findings::of(run);
    let compares = findings.groups.iter().any(|group| group.mixes.len() > 1);
    html! { @if compares {
        h2 { "What the paper found" }
        @for group in &findings.groups { (one(group, run)) }
        @for name in &findings.left_out {
            p .faint { (name) ": left out, since its xi changes." }
        }
        p .faint { @for note in &findings.notes { (note) " " } }
    } }
}

fn one(group: &Group, run: &Results) -> Markup {
    let measure = &run.measure;
    html! {
        @if !group.name.is_empty() { h3 { (group.name) } }
        div .scroll tabindex="0" role="region" aria-label="mixes" {
            table {
                thead { tr {
                    th scope="col" { "\u{3be}" }
                    th scope="col" { "cells" }
                    @for name in STATISTICS {
                        th scope="col" { (measure.symbol) " " (name) " [" (measure.unit) "]" }
                    }
                    @if let Some(it) = &measure.information {
                        th scope="col" { (it.symbol) " mean [" (it.unit) "]" }
                        th scope="col" { "r of both" }
                    }
                } }
                tbody { @for mix in &group.mixes { (row(mix, measure.information.is_some())) } }
            }
        }
        @if let Some(probability) = group.improvement {
            p { "A cell with \u{3be} = 0.75 ends higher than one with \u{3be} = 1 with probability "
                (typeset(probability)) "." }
        }
        @if let Some((r, it)) = group.correlation.zip(measure.information.as_ref()) {
            p { "Pearson's r of " (measure.symbol) " and " (it.symbol) " over all updates: "
                (typeset(r)) "." }
        }
        @for statement in &group.statements {
            details open[statement.verdict == Verdict::Fails] {
                summary { (statement.text) ": " strong { (statement.verdict) } }
                ul { @for part in &statement.evidence {
                    li { (typeset(part.said())) }
                } }
            }
        }
    }
}

fn row(mix: &Mix, has_information: bool) -> Markup {
    let r = mix.correlation.map_or("\u{2013}".into(), figures::three_digits);
    html! { tr {
        td { (mix.xi) }
        td { (mix.n) }
        @for estimate in mix.last { td { (typeset(estimate)) } }
        @if has_information {
            td { (typeset(mix.intrinsic_nats)) }
            td { (typeset(r)) }
        }
    } }
}

/// With minus signs.
fn typeset(number: impl std::fmt::Display) -> String {
    number.to_string().replace('-', "\u{2212}")
}
