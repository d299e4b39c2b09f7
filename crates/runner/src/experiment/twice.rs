//! One setting that is written twice in a sweep, whatever it's called: its cells would be the same.

use std::{
    collections::{BTreeMap, BTreeSet},
    ptr,
};

use config::Problem;
use xxhash_rust::xxh3::xxh3_64;

use super::{
    Cell, Experiment,
    axis::{Point, in_sweep},
    sweep::Sweep,
};

/// A problem for each value that makes a setting what another one is already.
pub(super) fn twice(sweep: &Sweep, cells: &[Cell]) -> Vec<Problem> {
    let mut known: BTreeMap<u64, Vec<(Vec<_>, Experiment)>> = BTreeMap::new();
    let mut problems = BTreeSet::new();
    let settings = cells.iter().step_by(sweep.seeds.len());
    for (points, cell) in sweep.combinations().zip(settings) {
        // For readers; it changes nothing.
        let experiment = Experiment { description: None, ..cell.experiment.clone() };
        let alike = known.entry(hash(&experiment)).or_default();
        match alike.iter().find(|(_, other)| *other == experiment) {
            Some((others, _)) => problems.extend(problem(sweep, &points, others)),
            None => alike.push((points, experiment)),
        }
    }
    problems.into_iter().collect()
}

/// The same one for equal settings.
fn hash(experiment: &Experiment) -> u64 {
    // Plain structs of numbers and texts can always be written. 0.0 and -0.0 are equal.
    let text = serde_json::to_string(experiment).unwrap_or_default().replace("-0.0", "0.0");
    xxh3_64(text.as_bytes())
}

/// Names the values in which the two settings differ, and none that they share.
fn problem(sweep: &Sweep, points: &[&Point], others: &[&Point]) -> Option<Problem> {
    let axes = sweep.axes.iter().zip(points.iter().zip(others));
    let differing: Vec<_> = axes.filter(|(_, (point, other))| !ptr::eq(**point, **other)).collect();
    let place = &differing.last()?.1.0.node.place;
    let here: Vec<_> = differing.iter().map(|(axis, (point, _))| axis.named(point)).collect();
    let there: Vec<_> = differing.iter().map(|(axis, (_, other))| axis.named(other)).collect();
    let message = format!("{} sets the same as {}: one has to go", here.join(","), there.join(","));
    Some(in_sweep(place, message))
}
