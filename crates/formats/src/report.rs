//! What an import carried over, what it left out, and what it chose: a table.

use std::fmt;

use comfy_table::{ContentArrangement, Table, presets::NOTHING};
use config::Place;

/// The account of an import, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// What is in the model: what and how much.
    pub carried: Vec<(String, String)>,
    /// What is in the file and not in the model.
    pub left_out: Vec<LeftOut>,
    /// What is in the file and is no part of a robot: looks, and settings of a simulator.
    pub set_aside: Vec<LeftOut>,
    /// What the file leaves open, or says in a way that a model can't: what and how it was decided.
    pub chosen: Vec<Chosen>,
}

/// Elements of a kind that weren't carried over.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Its name, with those around it that tell what it is.
    pub element: String,
    /// The first of them.
    pub place: Place,
    /// How many there are.
    pub count: usize,
    /// Why, where that isn't plain.
    pub why: String,
}

/// A decision.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// About what.
    pub what: String,
    /// What was decided; the first few, where the same was decided about several.
    pub values: Vec<String>,
    /// How often it was decided.
    pub count: usize,
}

/// What is counted together.
const OTHERS: &str = "others";

/// Values of a decision that are shown.
const MOST_VALUES: usize = 4;

impl Report {
    pub(crate) fn left_out(&mut self, element: &str, place: Place, why: &str) {
        count(&mut self.left_out, element, place, why);
    }

    pub(crate) fn set_aside(&mut self, element: &str, place: Place) {
        count(&mut self.set_aside, element, place, "");
    }

    pub(crate) fn chose(&mut self, what: &str, value: &str) {
        let is_known = self.chosen.iter().any(|chosen| chosen.what == what);
        let what = if is_known || self.chosen.len() < MOST_ROWS { what } else { OTHERS };
        let known = self.chosen.iter().position(|chosen| chosen.what == what);
        let index = known.unwrap_or(self.chosen.len());
        if known.is_none() {
            self.chosen.push(Chosen { what: what.into(), values: Vec::new(), count: 0 });
        }
        let chosen = &mut self.chosen[index];
        chosen.count += 1;
        if chosen.values.len() < MOST_VALUES && !chosen.values.iter().any(|known| known == value) {
            chosen.values.push(value.into());
        }
    }

    pub(crate) fn carry(&mut self, what: &str, value: impl Into<String>) {
        self.carried.push((what.into(), value.into()));
    }

    /// Whether everything that matters to physics, sensing and acting was carried over.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.left_out.is_empty()
    }
}

/// Rows of a table; more are counted together.
const MOST_ROWS: usize = 100;

fn count(list: &mut Vec<LeftOut>, element: &str, place: Place, why: &str) {
    let is_known = list.iter().any(|known| known.element == element);
    let (element, why) =
        if is_known || list.len() < MOST_ROWS { (element, why) } else { (OTHERS, "") };
    match list.iter_mut().find(|known| known.element == element) {
        Some(known) => known.count += 1,
        None => list.push(LeftOut { element: element.into(), place, count: 1, why: why.into() }),
    }
}

impl fmt::Display for Report {
    /// Three tables without a frame, each under its heading; an empty one isn't shown.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = |place: &Place| match place.line {
            0 => place.to_string(),
            line => format!("line {line} of {}", file_name(&place.source)),
        };
        let left = |list: &[LeftOut]| {
            let row = |it: &LeftOut| {
                vec![it.element.clone(), it.count.to_string(), place(&it.place), it.why.clone()]
            };
            list.iter().map(row).collect::<Vec<_>>()
        };
        let carried = self.carried.iter().map(|(what, value)| vec![what.clone(), value.clone()]);
        let chosen = self.chosen.iter().map(|it| {
            let more = it.count > it.values.len() && it.values.len() == MOST_VALUES;
            let values = it.values.join(", ") + if more { ", ..." } else { "" };
            vec![it.what.clone(), it.count.to_string(), values]
        });
        let tables = [
            ("carried over", carried.collect()),
            ("left out (what, how many, the first, why)", left(&self.left_out)),
            ("no part of a robot (what, how many, the first)", left(&self.set_aside)),
            ("chosen (what, how often, how)", chosen.collect::<Vec<_>>()),
        ];
        let tables = tables.into_iter().filter(|(_, rows)| !rows.is_empty());
        for (i, (heading, rows)) in tables.enumerate() {
            let mut table = Table::new();
            table.load_preset(NOTHING).set_content_arrangement(ContentArrangement::Disabled);
            table.add_rows(rows);
            let gap = if i == 0 { "" } else { "\n\n" };
            write!(formatter, "{gap}{heading}")?;
            for line in table.to_string().lines() {
                write!(formatter, "\n {}", line.trim_end())?;
            }
        }
        Ok(())
    }
}

fn file_name(source: &str) -> &str {
    source.rsplit('/').next().unwrap_or(source)
}
