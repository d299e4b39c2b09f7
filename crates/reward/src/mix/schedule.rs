//! xi over time: constant, or linear between given updates and constant before and after them.

use std::fmt;

use config::{Mismatch, Node, Rule, Section, Value, integer, within};
use serde::Serialize;

/// The default of xi, the paper's.
const XI: f64 = 0.75;

/// Share of the extrinsic part, 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Xi {
    /// The same in all updates.
    #[serde(rename = "xi")]
    Constant(f64),
    /// Pairs of an update, from 0 and increasing, and xi; at least one.
    Schedule(Vec<(u64, f64)>),
}

impl Default for Xi {
    fn default() -> Self {
        Self::Constant(XI)
    }
}

impl Xi {
    /// Reads `xi` or `schedule`.
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let both = section.has("xi") && section.has("schedule");
        let schedule = Points
            .about(
                "xi over time in place of `xi`: pairs [update, xi], linear between them, constant \
                 before and after; updates are counted from 0",
            )
            .condition("with increasing updates and xi from 0 to 1");
        let schedule = section.optional("schedule", schedule);
        let xi = within(0.0, 1.0).about("share of the extrinsic part");
        let xi = section.given_or("xi", xi, XI);
        if both {
            let message = "schedule says what xi is, and xi says it too: one of them has to go";
            section.complain(&section.place_of("schedule"), message);
            return None;
        }
        match section.has("schedule") {
            true => schedule.map(Self::Schedule),
            false => xi.map(Self::Constant),
        }
    }

    /// xi after so many updates.
    #[must_use]
    pub fn at(&self, update: u64) -> f64 {
        let points = match self {
            Self::Constant(xi) => return *xi,
            Self::Schedule(points) => points,
        };
        let later = points.partition_point(|&(point, _)| point <= update);
        match (later.checked_sub(1).map(|last| points[last]), points.get(later)) {
            (Some((from, a)), Some(&(to, b))) => {
                let part = (update - from) as f64 / (to - from) as f64;
                a + part * (b - a)
            }
            (Some((_, xi)), None) | (None, Some(&(_, xi))) => xi,
            (None, None) => Self::default().at(update),
        }
    }

    /// The pairs of update and xi between which it's linear.
    pub fn points(&self) -> impl Iterator<Item = (u64, f64)> + '_ {
        let (constant, points) = match self {
            Self::Constant(xi) => (Some((0, *xi)), &[][..]),
            Self::Schedule(points) => (None, &points[..]),
        };
        constant.into_iter().chain(points.iter().copied())
    }
}

impl fmt::Display for Xi {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Constant(xi) => write!(formatter, "{xi}"),
            Self::Schedule(points) => {
                let points: Vec<_> =
                    points.iter().map(|(update, xi)| format!("[{update}, {xi}]")).collect();
                write!(formatter, "[{}]", points.join(", "))
            }
        }
    }
}

/// A list of pairs of an update and xi.
struct Points;

impl Rule for Points {
    type Out = Vec<(u64, f64)>;

    fn expected(&self) -> String {
        "a list of pairs [update, xi]".into()
    }

    fn take(&self, node: &Node) -> Result<Self::Out, Mismatch> {
        let items = match &node.value {
            Value::List(items) if !items.is_empty() => items,
            _ => return Err(self.refuse(node)),
        };
        let mut points: Vec<(u64, f64)> = Vec::new();
        for (i, item) in items.iter().enumerate() {
            let inside =
                |inner: Mismatch| Mismatch { part: format!("[{i}]{}", inner.part), ..inner };
            let after = points.last().map_or(0, |&(update, _)| update as i64 + 1);
            points.push(point(item, after).map_err(inside)?);
        }
        Ok(points)
    }

    fn written(&self, points: &Self::Out) -> String {
        Xi::Schedule(points.clone()).to_string()
    }
}

/// A pair whose update is at least `after`.
fn point(node: &Node, after: i64) -> Result<(u64, f64), Mismatch> {
    /// Updates that a run can have, and more.
    const LAST: i64 = 1 << 53;
    let Value::List(items) = &node.value else { return Err(not_a_pair(node)) };
    let [update, xi] = &items[..] else { return Err(not_a_pair(node)) };
    let part = |i: usize| move |inner: Mismatch| Mismatch { part: format!("[{i}]"), ..inner };
    let update = integer(after, LAST).take(update).map_err(part(0))?;
    let xi = within(0.0, 1.0).take(xi).map_err(part(1))?;
    Ok((update as u64, xi))
}

fn not_a_pair(node: &Node) -> Mismatch {
    Mismatch { expected: "a pair [update, xi]".into(), ..Points.refuse(node) }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use config::Document;

    use super::*;

    fn read(text: &str) -> Result<Xi, String> {
        let document = Document::parse("f", text).unwrap();
        document.read(Xi::read).map_err(|problems| problems.to_string())
    }

    #[test]
    fn it_is_linear_between_points_and_constant_outside() {
        let xi = read("schedule = [[10, 0.5], [20, 1], [24, 0.0]]").unwrap();
        for (update, expected) in
            [(0, 0.5), (10, 0.5), (15, 0.75), (20, 1.0), (21, 0.75), (24, 0.0), (u64::MAX, 0.0)]
        {
            assert_eq!(xi.at(update), expected, "update {update}");
        }
        assert_eq!(read("schedule = [[7, 0.25]]").unwrap().at(0), 0.25);
    }

    #[test]
    fn without_a_schedule_it_is_constant() {
        assert_eq!(read("xi = 0.5").unwrap().at(123), 0.5);
        assert_eq!(read("").unwrap(), Xi::Constant(0.75));
    }

    #[test]
    fn mistakes_are_placed_within_the_list() {
        let cases = [
            ("schedule = []", "f:1:12: schedule must be a list of pairs [update, xi], got []"),
            ("schedule = [3]", "f:1:13: schedule[0] must be a pair [update, xi], got 3"),
            ("schedule = [[3]]", "f:1:13: schedule[0] must be a pair [update, xi], got [3]"),
            (
                "schedule = [[3, 0.5], [3, 1]]",
                "f:1:24: schedule[1][0] must be a whole number from 4 to 9007199254740992, got 3",
            ),
            (
                "schedule = [[0, 1.5]]",
                "f:1:17: schedule[0][1] must be a number from 0 to 1, got 1.5",
            ),
        ];
        for (text, expected) in cases {
            assert_eq!(read(text), Err(expected.into()));
        }
        assert!(read("xi = 1\nschedule = [[0, 1]]").unwrap_err().contains("one of them has to go"));
    }
}
