//! Several runs as one: their settings side by side, so that every figure and every table compares them.
//!
//! Each run keeps windows of its own, a tenth of its longest cell, since an update of one may have many
//! times the control steps of another's. What counts as progress is a tenth of the largest gain of all.

use super::{Error, Information, Measure, Outcome, Results};

impl Results {
    /// Runs that are judged by the same, one after another. Their settings should have names that tell
    /// them apart.
    ///
    /// # Errors
    /// [`Error::Incomparable`] if two of them are judged by different things; [`Error::Empty`] of no run.
    pub fn together(mut runs: Vec<Self>) -> Result<Self, Error> {
        if let Some((first, others)) = runs.split_first() {
            for other in others {
                comparable(first, other)?;
            }
        }
        Outcome::evaluate(&mut runs);
        let mut runs = runs.into_iter();
        let nothing = || Error::Empty { folder: Default::default(), omitted: Vec::new() };
        let mut all = runs.next().ok_or_else(nothing)?;
        for run in runs {
            all.folders.extend(run.folders);
            all.settings.extend(run.settings);
            let information = common(all.measure.information.take(), run.measure.information);
            all.measure.information = information;
            for caveat in run.measure.caveats {
                if !all.measure.caveats.contains(&caveat) {
                    all.measure.caveats.push(caveat);
                }
            }
        }
        Ok(all)
    }
}

/// What the information of two runs is called.
fn common(a: Option<Information>, b: Option<Information>) -> Option<Information> {
    match (a, b) {
        (Some(a), Some(b)) if a != b => Some(Information::common(&a.unit)),
        (a, b) => a.or(b),
    }
}

/// That two runs may stand on one axis.
fn comparable(a: &Results, b: &Results) -> Result<(), Error> {
    let of = |measure: &Measure| [measure.name(), measure.unit.clone()];
    if of(&a.measure) == of(&b.measure) {
        return Ok(());
    }
    let side =
        |run: &Results| (run.folders.first().cloned().unwrap_or_default(), run.measure.clone());
    Err(Error::Incomparable(Box::new([side(a), side(b)])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::run_of;

    /// Flat at `first` for the first tenth, then at `last`, without noise.
    fn curve(n: usize, first: f64, last: f64) -> Vec<f64> {
        [vec![first; n / 10], vec![last; n - n / 10]].concat()
    }

    /// Of 200 updates and of 20: with the window of the long one, all of the short one would be its
    /// last window, and have a mean of 0.9 * 3.
    #[test]
    fn each_run_has_its_own_windows_and_all_have_one_gain() {
        let long = run_of(&[("a", vec![curve(200, 0.0, 40.0), curve(200, 0.0, 1.0)])]);
        let short = run_of(&[("b", vec![curve(20, 0.0, 3.0), curve(20, 0.0, 5.0)])]);
        assert_eq!(short.settings[0].cells[0].outcome.progressed, Some(true));
        let both = Results::together(vec![long, short]).unwrap();
        assert_eq!(both.settings.iter().map(|it| it.window).collect::<Vec<_>>(), [20, 2]);
        assert_eq!(both.windows(), "20 or 2");
        let last: Vec<_> = both.cells().map(|cell| cell.outcome.last).collect();
        assert_eq!(last, [40.0, 1.0, 3.0, 5.0]);
        // A tenth of the largest gain of all is 4.
        let progressed: Vec<_> = both.cells().map(|cell| cell.outcome.progressed).collect();
        assert_eq!(progressed, [Some(true), Some(false), Some(false), Some(true)]);
        // Nobody is behind: each is as long as its run.
        assert!(both.cells().all(|cell| !cell.outcome.is_behind));
    }

    #[test]
    fn other_tasks_are_refused_by_name() {
        let walking = run_of(&[("a", vec![vec![1.0]])]);
        let mut turning = walking.clone();
        turning.folders = vec!["runs/turn".into()];
        turning.measure = Measure::of_task("turning", "turning", "rad");
        let error = Results::together(vec![walking, turning]).unwrap_err().to_string();
        for part in ["run is judged by locomotion R_Loc in m", "runs/turn by turning in rad"] {
            assert!(error.contains(part), "{error}");
        }
        assert!(Results::together(Vec::new()).is_err());
    }
}
