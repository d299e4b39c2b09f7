//! What a statement is judged by: a number with its interval, and on which side of its bound that lies.

use super::{Arm, REPLICATES};
use crate::tables::Estimate;

/// What is to be said of a statement, or of a part of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The interval lies where the statement has it.
    Holds,
    /// The interval lies elsewhere.
    Fails,
    /// Neither, and why, as in "with 8 instances".
    Open(String),
}

/// A number of this run that a statement is judged by.
#[derive(Clone, Debug, PartialEq)]
pub struct Evidence {
    /// What it is.
    pub what: String,
    /// The number; none if there's nothing to count it from.
    pub estimate: Option<Estimate>,
    /// Its unit.
    pub unit: String,
    /// What it says.
    pub verdict: Verdict,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Holds => formatter.write_str("holds"),
            Self::Fails => formatter.write_str("doesn't hold"),
            Self::Open(why) => write!(formatter, "can't tell {why}"),
        }
    }
}

impl Verdict {
    /// Of an estimate that's to be above a bound.
    pub(super) fn above(bound: f64, estimate: Estimate, n: usize) -> Self {
        match estimate.interval {
            Some(interval) if interval.low > bound => Self::Holds,
            Some(interval) if interval.high < bound => Self::Fails,
            _ => Self::with(n),
        }
    }

    /// More would tell.
    pub(super) fn with(n: usize) -> Self {
        Self::Open(format!("with {n} {}", if n == 1 { "instance" } else { "instances" }))
    }

    pub(super) fn missing(xi: f64) -> Self {
        Self::Open(format!("without cells of xi = {xi}"))
    }

    /// Of a whole whose parts are these: all must hold, and none may not.
    pub(super) fn of(parts: &[Evidence]) -> Self {
        let verdicts = || parts.iter().map(|part| &part.verdict);
        let open = || verdicts().find(|it| matches!(it, Self::Open(_)));
        match verdicts().find(|it| **it == Self::Fails) {
            Some(fails) => fails.clone(),
            None => open().cloned().unwrap_or(Self::Holds),
        }
    }
}

impl Evidence {
    /// An estimate that's to be above a bound, of so many instances.
    pub(super) fn of(
        what: String,
        unit: &str,
        estimate: Option<Estimate>,
        (bound, n): (f64, usize),
    ) -> Self {
        let verdict = estimate.map_or(Verdict::with(n), |it| Verdict::above(bound, it, n));
        Self { what, estimate, unit: unit.into(), verdict }
    }

    /// All of it as people read it: `mean minus that of xi = 1: 0.0041 [0.001, 0.0102] m: holds`.
    #[must_use]
    pub fn said(&self) -> String {
        let Self { what, unit, verdict, .. } = self;
        match self.estimate {
            None => format!("{what}: {verdict}"),
            Some(it) => {
                format!("{what}: {}: {verdict}", format!("{it} {unit}").trim_end())
            }
        }
    }
}

/// The cells with an xi.
pub(super) fn find<'a, 'b>(arms: &'a [Arm<'b>], xi: f64) -> Option<&'a Arm<'b>> {
    arms.iter().find(|arm| (arm.xi - xi).abs() < 1e-9)
}

/// The statistic of `x` minus that of `y`, which is to be above 0; cells are drawn from each.
pub(super) fn difference(
    what: String,
    unit: &str,
    [x, y]: [&[f64]; 2],
    statistic: impl Fn(&[f64], &[f64]) -> f64,
) -> Evidence {
    let n = x.len().min(y.len());
    let of = || Estimate::of([x, y], REPLICATES, |[x, y]| statistic(x, y));
    Evidence::of(what, unit, (n > 0).then(of), (0.0, n))
}
