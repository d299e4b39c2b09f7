//! Small made-up runs for tests.

use std::path::PathBuf;

use runs::Row;

use super::{
    CellResults, Information, Measure, Outcome, Results, Setting, curves::Thinned,
    statistics::moments,
};

/// The paper's task.
pub(super) fn locomotion() -> Measure {
    let information = Information::of_kind("mutual_information", "R_MI", ["nats", "variable"]);
    Measure::of_task("locomotion", "R_Loc", "m").with(Some(information), None)
}

/// Settings with a curve of R_Loc for each cell. R is its square, R_MI its half, and so are the norms.
pub(super) fn run_of(settings: &[(&str, Vec<Vec<f64>>)]) -> Results {
    let row = |value: &f64| Row {
        parameter_norm: value / 2.0,
        gradient_norm: value / 2.0,
        ..Row::default()
    };
    let cell = |(i, curve): (usize, &Vec<f64>)| CellResults {
        name: format!("seed={}", i + 1),
        seed: i as u64 + 1,
        folder: PathBuf::new(),
        reward: curve.iter().map(|value| value * value).collect(),
        intrinsic_nats: curve.iter().map(|value| value / 2.0).collect(),
        performance: curve.clone(),
        columns: Thinned::of(&curve.iter().map(row).collect::<Vec<_>>()),
        updates: curve.len(),
        moments: moments(curve.iter().map(|value| (*value, value / 2.0))),
        outcome: Outcome::default(),
        contacts: None,
    };
    let setting = |(name, curves): &(&str, Vec<Vec<f64>>)| Setting {
        name: (*name).into(),
        cells: curves.iter().enumerate().map(cell).collect(),
        window: 1,
        every: 1,
        steps_per_update: 100.0,
    };
    let mut run = Results {
        folders: vec!["run".into()],
        measure: locomotion(),
        settings: settings.iter().map(setting).collect(),
    };
    Outcome::evaluate(std::slice::from_mut(&mut run));
    run
}
