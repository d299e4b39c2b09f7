//! Roughness of each function on each slice, and its mean over cells.
//!
//! docs/landscapes.md says what each measure is; the crate `landscape` has their formulas.

use std::collections::{BTreeMap, BTreeSet};

use ::landscape::{
    Estimate, Optima, Repeats, barrier, cosine, curvature, distance_correlation, require_finite,
    slope, variation,
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
    /// The mean of each function at each point, `[n_functions][n_points]`.
    pub means: Vec<Vec<f64>>,
    /// Their standard errors; NaN of one repeat alone.
    pub errors: Vec<Vec<f64>>,
    /// All measures; none of one repeat alone, which says nothing of its noise.
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
    if values.iter().all(|repeats| repeats.len() == 1) {
        return of_one_repeat(values.into_iter().flatten().collect());
    }
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

/// `[n_functions][n_points]`
fn of_one_repeat(means: Vec<Vec<f64>>) -> Result<Measured, ::landscape::Error> {
    require_finite(&means)?;
    let errors = means.iter().map(|values| vec![f64::NAN; values.len()]).collect();
    Ok(Measured { means, errors, rows: Vec::new() })
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
    if slice.kind == Kind::Direction {
        let t: Vec<f64> = slice.places.iter().map(|place| place[0]).collect();
        found.push(("slope", slope(function, &t, (t.len() / 10).max(1))));
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

/// The slope that each function's gradient predicts along a line through its cell, which is comparable to
/// `slope` of the same line: `[n_functions][n_gradients][n_parameters]`. None of other slices.
#[must_use]
pub fn predict(
    slice: &Slice,
    unit: &str,
    names: &[String],
    gradients: &[Vec<Vec<f64>>],
) -> Vec<Row> {
    let Some(direction) = slice.direction() else { return Vec::new() };
    let along = |gradient: &Vec<f64>| gradient.iter().zip(direction).map(|(g, d)| g * d).sum();
    let of = |(name, gradient): (&String, &Vec<Vec<f64>>)| Row {
        place: slice.name.clone(),
        unit: unit.to_owned(),
        kind: slice.kind.name(),
        function: name.clone(),
        measure: "predicted_slope",
        estimate: Estimate::mean(&gradient.iter().map(along).collect::<Vec<f64>>()),
    };
    names.iter().zip(gradients).map(of).collect()
}

/// How well the slopes that each function's gradient predicts go with the task's own slopes: Pearson's
/// correlation over all lines.
fn slope_correlations(rows: &[Row], task: &str) -> Vec<Summary> {
    let of = |measure: &str, function: &str| -> Vec<(&str, f64)> {
        let rows = rows.iter().filter(|row| row.measure == measure && row.function == function);
        rows.map(|row| (&*row.place, row.estimate.value)).collect()
    };
    let slopes: BTreeMap<&str, f64> = of("slope", task).into_iter().collect();
    let functions: BTreeSet<&str> = rows.iter().map(|row| &*row.function).collect();
    let summary = |function: &str| {
        let predicted = of("predicted_slope", function);
        let pairs = predicted.iter().filter_map(|(place, it)| Some((*it, *slopes.get(place)?)));
        Some(Summary {
            kind: Kind::Direction.name(),
            measure: "slope_correlation",
            function: function.to_owned(),
            n: predicted.len(),
            mean: statistics::pearson(statistics::moments(pairs))?,
            interval: None,
            difference: None,
        })
    };
    functions.into_iter().filter_map(summary).collect()
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
    /// The mean of the differences to the reference's, with its interval, likewise; none of what is in units
    /// of a function of its own.
    pub difference: Option<(f64, Option<Interval>)>,
}

/// Replicates of a bootstrap.
const REPLICATES: usize = 10_000;

/// Means over cells; differences are to the function `reference`. The name of the first one is `task`.
#[must_use]
pub fn summarise(rows: &[Row], task: &str, reference: &str) -> Vec<Summary> {
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
        let other = means.get(&(kind, measure, reference.to_owned()));
        let differences: Vec<f64> = other
            .iter()
            .flat_map(|of| units.iter().filter_map(|(unit, value)| Some(value - of.get(unit)?)))
            .collect();
        let has_unit = matches!(measure, "threshold" | "barrier" | "slope" | "predicted_slope");
        let has_difference = function != reference && !has_unit && !differences.is_empty();
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
    means.iter().map(summary).chain(slope_correlations(rows, task)).collect()
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
        let found = summarise(&rows, "R_Loc", "R_Loc");
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].n, found[0].mean, found[0].difference), (2, 4.0, None));
        // 5 - 2 and 7 - 6; two cells are too few for an interval.
        assert_eq!((found[1].mean, found[1].difference), (6.0, Some((2.0, None))));
        let many: Vec<_> = (0..8).map(|i| row(&i.to_string(), "R_Loc", f64::from(i))).collect();
        let interval = summarise(&many, "R_Loc", "R_Loc")[0].interval.unwrap();
        assert!(interval.low > 1.0 && interval.low < 3.5 && interval.high < 6.0, "{interval:?}");
    }
    /// A line along (1, 3), and gradients of (2, 0) and (0, 1) but for noise that is the same in both: the
    /// cosine of the means is 0, and along the line they rise by 2 and 3.
    #[test]
    fn gradients_predict_slopes_and_are_compared_without_noise() {
        let line = Slice::line("line".into(), 0, &[0.0, 0.0], vec![1.0, 3.0], (5, 1.0));
        let noise = [[0.5, 0.0], [-0.5, 0.0], [0.0, 0.5], [0.0, -0.5]];
        let of = |a: f64, b: f64| noise.iter().map(|[x, y]| vec![a + x, b + y]).collect::<Vec<_>>();
        let gradients = [of(2.0, 0.0), of(0.0, 1.0)];
        let names = ["R_Loc", "R_MI"].map(str::to_owned);
        let values = |rows: Vec<Row>| rows.iter().map(|it| it.estimate.value).collect::<Vec<_>>();
        assert_eq!(values(predict(&line, "cell", &names, &gradients)), [2.0, 3.0]);
        let cosines = values(align("cell", &names, &gradients));
        assert!((cosines[0] - 1.0).abs() < 1e-12 && cosines[1].abs() < 0.1, "{cosines:?}");
        let between = Slice::between("".into(), 0, (vec![0.0; 2], vec![1.0; 2]), 3);
        assert_eq!(predict(&between, "cells", &names, &gradients), []);
    }
}
