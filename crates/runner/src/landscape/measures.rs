//! Roughness of each function on each slice, and its mean over cells.
//!
//! docs/landscapes.md says what each measure is; the crate `landscape` has their formulas.

use std::collections::BTreeMap;

use ::landscape::{
    Estimate, Optima, Repeats, barrier, cosine, curvature, distance_correlation, variation,
};
use figures::statistics::{self, FEWEST_FOR_INTERVAL, Interval};

use super::{Kind, Slice};

/// A measure of a function.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The slice, or the cell where there's none.
    pub place: String,
    /// What counts as one in a mean over places: the cell, or the pair of cells.
    pub unit: String,
    /// How the slice was laid: [`Kind::name`], or `gradient`.
    pub kind: &'static str,
    /// As [`Functions::names`](super::Functions::names) has it.
    pub function: String,
    /// The measure.
    pub measure: &'static str,
    /// With its interval over repeats; both ends NaN where a measure has none.
    pub estimate: Estimate,
}

/// A slice that was measured.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Of each function, `[n_functions][n_points]`.
    pub means: Vec<Vec<f64>>,
    /// Their standard errors.
    pub errors: Vec<Vec<f64>>,
    /// All measures.
    pub rows: Vec<Row>,
}

/// Measures all functions on a slice, `[n_functions][n_repeats][n_points]`; the first one is the task.
///
/// # Errors
/// Values that aren't finite, where a robot blew up.
pub fn measure(
    slice: &Slice,
    unit: &str,
    names: &[String],
    values: Vec<Vec<Vec<f64>>>,
) -> Result<Measured, ::landscape::Error> {
    let functions = values.into_iter().map(Repeats::new).collect::<Result<Vec<_>, _>>()?;
    let mut rows = Vec::new();
    for (name, function) in names.iter().zip(&functions) {
        let task = functions.first().unwrap_or(function);
        rows.extend(of_function(slice, function, task).into_iter().map(|(measure, estimate)| {
            Row {
                place: slice.name.clone(),
                unit: unit.to_owned(),
                kind: slice.kind.name(),
                function: name.clone(),
                measure,
                estimate,
            }
        }));
    }
    Ok(Measured {
        means: functions.iter().map(Repeats::mean).collect(),
        errors: functions.iter().map(Repeats::errors).collect(),
        rows,
    })
}

fn of_function(slice: &Slice, function: &Repeats, task: &Repeats) -> Vec<(&'static str, Estimate)> {
    let optima = Optima::of(function, slice.grid());
    let mut found = vec![
        ("optima", Some(alone(optima.n as f64))),
        ("threshold", Some(alone(optima.threshold))),
        ("signal_to_noise", signal_to_noise(function)),
        ("agreement", agreement(function, task)),
    ];
    if !slice.is_plane() {
        let variation = variation(&function.mean(), optima.threshold);
        found.push(("variation", variation.map(alone)));
        found.push(("curvature", curvature(function)));
    }
    match slice.kind {
        Kind::Between => {
            found.push(("barrier", Some(barrier(function))));
            found.push(("relative_barrier", relative_barrier(function)));
        }
        _ => {
            let distances = slice.distances();
            found.push(("distance_correlation", distance_correlation(function, &distances)));
        }
    }
    found.into_iter().filter_map(|(name, it)| Some((name, it?))).collect()
}

/// How well each function's gradient at a cell points to where the task's does:
/// `[n_functions][n_gradients][n_parameters]`.
#[must_use]
pub fn align(cell: &str, names: &[String], gradients: &[Vec<Vec<f64>>]) -> Vec<Row> {
    let Some(task) = gradients.first() else { return Vec::new() };
    let of = |(name, gradient): (&String, &Vec<Vec<f64>>)| {
        Some(Row {
            place: cell.to_owned(),
            unit: cell.to_owned(),
            kind: "gradient",
            function: name.clone(),
            measure: "cosine",
            estimate: cosine(gradient, task)?,
        })
    };
    names.iter().zip(gradients).filter_map(of).collect()
}

/// A number that has no interval.
fn alone(value: f64) -> Estimate {
    Estimate { value, low: f64::NAN, high: f64::NAN }
}

/// The deviation of a slice's values over the mean standard error of one.
fn signal_to_noise(function: &Repeats) -> Option<Estimate> {
    let error = statistics::mean(&function.errors());
    let ratio = statistics::deviation(&function.mean())? / error;
    ratio.is_finite().then(|| alone(ratio))
}

/// Pearson's correlation of a function's values with the task's over the slice, both without noise.
fn agreement(function: &Repeats, task: &Repeats) -> Option<Estimate> {
    cosine(&function.centred(), &task.centred())
}

/// A barrier in units of the lower end's value; none if that's not positive.
fn relative_barrier(function: &Repeats) -> Option<Estimate> {
    let mean = function.mean();
    let lower = mean.first()?.min(*mean.last()?);
    let Estimate { value, low, high } = barrier(function);
    (lower > 0.0).then(|| Estimate { value: value / lower, low: low / lower, high: high / lower })
}

/// A measure's mean over cells, or pairs of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// How the slices were laid.
    pub kind: &'static str,
    /// The measure.
    pub measure: &'static str,
    /// The function.
    pub function: String,
    /// How many cells or pairs there are.
    pub n: usize,
    /// The mean over these, each of its own slices' mean.
    pub mean: f64,
    /// Its 95 % interval by bootstrap over these; none if they are too few.
    pub interval: Option<Interval>,
    /// The mean of the differences to the task's, with its interval, likewise; none of what is in units of
    /// a function of its own.
    pub difference: Option<(f64, Option<Interval>)>,
}

/// Replicates of a bootstrap.
const REPLICATES: usize = 10_000;

/// Means over cells; differences are to `task`, the name of the first function.
#[must_use]
pub fn summarise(rows: &[Row], task: &str) -> Vec<Summary> {
    type Key = (&'static str, &'static str, String);
    let mut groups: BTreeMap<Key, BTreeMap<&str, Vec<f64>>> = BTreeMap::new();
    for row in rows {
        let key = (row.kind, row.measure, row.function.clone());
        let values = groups.entry(key).or_default().entry(&row.unit).or_default();
        values.push(row.estimate.value);
    }
    let means: BTreeMap<Key, BTreeMap<&str, f64>> = groups
        .into_iter()
        .map(|(key, units)| {
            let of = |(unit, values): (_, Vec<f64>)| (unit, statistics::mean(&values));
            (key, units.into_iter().map(of).collect())
        })
        .collect();
    let summary = |(key, units): (&Key, &BTreeMap<&str, f64>)| {
        let (kind, measure, function) = key.clone();
        let values: Vec<f64> = units.values().copied().collect();
        let of_task = means.get(&(kind, measure, task.to_owned()));
        let differences: Vec<f64> = of_task
            .iter()
            .flat_map(|task| units.iter().filter_map(|(unit, value)| Some(value - task.get(unit)?)))
            .collect();
        let has_unit = matches!(measure, "threshold" | "barrier");
        let has_difference = function != task && !has_unit && !differences.is_empty();
        Summary {
            n: values.len(),
            mean: statistics::mean(&values),
            interval: interval(&values),
            difference: has_difference
                .then(|| (statistics::mean(&differences), interval(&differences))),
            kind,
            measure,
            function,
        }
    };
    means.iter().map(summary).collect()
}

fn interval(values: &[f64]) -> Option<Interval> {
    let mean = |drawn: &[Vec<f64>]| statistics::mean(&drawn[0]);
    (values.len() >= FEWEST_FOR_INTERVAL)
        .then(|| statistics::bootstrap(&[values], REPLICATES, mean))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(unit: &str, function: &str, value: f64) -> Row {
        Row {
            place: format!("{unit} direction"),
            unit: unit.into(),
            kind: "direction",
            function: function.into(),
            measure: "optima",
            estimate: alone(value),
        }
    }

    /// A cell counts once, however many slices it has; differences are within cells.
    #[test]
    fn means_are_over_cells() {
        let mut rows = vec![row("a", "R_Loc", 1.0), row("a", "R_Loc", 3.0), row("a", "xi=1", 5.0)];
        rows.extend([row("b", "R_Loc", 6.0), row("b", "xi=1", 7.0)]);
        let found = summarise(&rows, "R_Loc");
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].n, found[0].mean, found[0].difference.clone()), (2, 4.0, None));
        // 5 - 2 and 7 - 6; two cells are too few for an interval.
        assert_eq!((found[1].mean, found[1].difference.clone()), (6.0, Some((2.0, None))));
        let many: Vec<_> = (0..8).map(|i| row(&i.to_string(), "R_Loc", f64::from(i))).collect();
        let interval = summarise(&many, "R_Loc")[0].interval.unwrap();
        assert!(interval.low > 1.0 && interval.low < 3.5 && interval.high < 6.0, "{interval:?}");
    }
}
