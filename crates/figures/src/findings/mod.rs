//! The paper's findings, asked of a run: five statements about xi, the task's share in the reward, each
//! with this run's numbers, their 95 % intervals and a verdict.
//!
//! `statements.rs` has the statements and how each is judged, `parts.rs` what they are judged by.
//! Settings that differ in xi alone are a [`Group`], and each group is asked for itself. A value is the
//! mean of a cell's last window, as everywhere here.

mod parts;
mod statements;

pub use parts::{Evidence, Verdict};

use runs::{COLUMNS, Moments};

use super::{
    CellResults, Results, Setting,
    statistics::{bootstrap, interquartile_mean, mean, pearson, quantile, sorted, together},
    tables::{Estimate, enough_for_interval, improvement_of},
};

/// Of the bootstraps here.
const REPLICATES: usize = 10_000;

/// What a run says to the paper's findings.
#[derive(Clone, Debug, PartialEq)]
pub struct Findings {
    /// Settings that differ in xi alone, in the order of the sweep.
    pub groups: Vec<Group>,
    /// Settings whose xi changes in the course of a run, and which are left out.
    pub left_out: Vec<String>,
    /// How all is judged, in sentences.
    pub notes: Vec<String>,
}

/// Settings that differ in xi alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// What they have in common, `kind=crbm`; empty if only xi is swept.
    pub name: String,
    /// What each xi came to, the lowest first.
    pub mixes: Vec<Mix>,
    /// The probability that a cell with xi = 0.75 ends higher than one with xi = 1, if both are there.
    pub improvement: Option<Estimate>,
    /// Pearson's r of what the run is judged by and the information, over all updates of all its cells; none if
    /// one of both is constant.
    pub correlation: Option<Estimate>,
    /// The paper's statements.
    pub statements: Vec<Statement>,
}

/// What the cells with one xi came to: of their last windows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mix {
    /// The task's share in the reward.
    pub xi: f64,
    /// The number of cells.
    pub n: usize,
    /// Their mean, median, interquartile mean and maximum, in the unit of the run's measure.
    pub last: [Estimate; 4],
    /// The mean information, in nats; 0 where none is measured.
    pub intrinsic_nats: Estimate,
    /// Pearson's r over all updates of these cells; none if one of both is constant.
    pub correlation: Option<f64>,
}

/// What [`Mix::last`] has.
pub const STATISTICS: [&str; 4] = ["mean", "median", "IQM", "maximum"];

/// A statement of the paper, and what this run says to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// The statement.
    pub text: String,
    /// What it's judged by: all of it holds, or the statement doesn't.
    pub evidence: Vec<Evidence>,
    /// What comes of it.
    pub verdict: Verdict,
}

/// Of some cells' values.
type Statistic = fn(&[f64]) -> f64;

/// The cells of a group, by xi.
struct Arm<'a> {
    xi: f64,
    /// Its place among the run's settings.
    place: usize,
    setting: &'a Setting,
    /// The last windows of its cells.
    last: Vec<f64>,
}

impl Findings {
    /// What a run says, finished or not.
    #[must_use]
    pub fn of(run: &Results) -> Self {
        let mut left_out = Vec::new();
        let mut groups: Vec<(String, Vec<Arm<'_>>)> = Vec::new();
        for (place, setting) in run.settings.iter().enumerate() {
            let Some(xi) = xi_of(setting) else {
                left_out.push(setting.name.clone());
                continue;
            };
            let arm = Arm { xi, place, setting, last: setting.last() };
            let name = without_xi(&setting.name);
            match groups.iter_mut().find(|(other, _)| *other == name) {
                Some((_, arms)) => arms.push(arm),
                None => groups.push((name, vec![arm])),
            }
        }
        for (_, arms) in &mut groups {
            arms.sort_by(|a, b| a.xi.total_cmp(&b.xi));
        }
        let groups = groups.into_iter().map(|(name, arms)| Group::of(run, name, &arms)).collect();
        Self { groups, left_out, notes: statements::notes(run) }
    }
}

impl Group {
    fn of(run: &Results, name: String, arms: &[Arm<'_>]) -> Self {
        let place = |xi| parts::find(arms, xi).map(|arm| arm.place);
        let better = place(0.75).zip(place(1.0));
        Self {
            name,
            mixes: arms.iter().map(Mix::of).collect(),
            improvement: better.and_then(|(a, b)| improvement_of(&run.settings, a, b)),
            correlation: correlation(arms),
            statements: statements::all(run, arms),
        }
    }
}

impl Mix {
    fn of(arm: &Arm<'_>) -> Self {
        let of = |values: &[f64], statistic: Statistic| {
            Estimate::of([values], REPLICATES, |[values]| statistic(values))
        };
        let nats: Vec<_> =
            arm.setting.cells.iter().map(|cell| last_nats(arm.setting, cell)).collect();
        Self {
            xi: arm.xi,
            n: arm.last.len(),
            last: [mean, median, interquartile_mean, maximum].map(|it| of(&arm.last, it)),
            intrinsic_nats: of(&nats, mean),
            correlation: pearson(moments(arm.setting)),
        }
    }
}

/// The xi of a setting's cells, as they recorded it; none if it changes.
fn xi_of(setting: &Setting) -> Option<f64> {
    let column = COLUMNS.iter().position(|column| column.name == "xi")?;
    let mut all = setting.cells.iter().map(|cell| cell.columns[column].constant());
    let first = all.next()??;
    all.all(|xi| xi.is_some_and(|xi| (xi - first).abs() < 1e-9)).then_some(first)
}

/// The name of a setting without the part that says its xi.
fn without_xi(name: &str) -> String {
    let is_xi = |part: &&str| {
        let key = part.split('=').next().unwrap_or_default();
        key == "xi" || key.ends_with(".xi")
    };
    let others: Vec<_> = name.split(',').filter(|part| !is_xi(part)).collect();
    others.join(",")
}

/// The mean information in a cell's last window.
fn last_nats(setting: &Setting, cell: &CellResults) -> f64 {
    let nats = &cell.intrinsic_nats;
    mean(&nats[nats.len() - setting.window_rows().min(nats.len())..])
}

fn median(values: &[f64]) -> f64 {
    quantile(&sorted(values), 0.5)
}

fn maximum(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// Of all updates of a setting's cells.
fn moments(setting: &Setting) -> Moments {
    setting.cells.iter().map(|cell| cell.moments).fold(Moments::default(), together)
}

/// Pearson's r over all updates of all cells; cells are drawn within their setting.
fn correlation(arms: &[Arm<'_>]) -> Option<Estimate> {
    let all = arms.iter().map(|arm| moments(arm.setting)).fold(Moments::default(), together);
    let value = pearson(all)?;
    // What is drawn are the places of cells.
    let places: Vec<Vec<f64>> =
        arms.iter().map(|arm| (0..arm.last.len()).map(|i| i as f64).collect()).collect();
    let strata: Vec<_> = places.iter().map(Vec::as_slice).collect();
    let of_drawn = |drawn: &[Vec<f64>]| {
        let cells = arms.iter().zip(drawn).flat_map(|(arm, drawn)| {
            drawn.iter().map(|&place| arm.setting.cells[place as usize].moments)
        });
        pearson(cells.fold(Moments::default(), together)).unwrap_or(0.0)
    };
    let interval = enough_for_interval(&strata).then(|| bootstrap(&strata, REPLICATES, of_drawn));
    Some(Estimate { value, interval })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{example::run_of, statistics::Interval};

    /// Twenty updates, from 0 to its end in the second half; a little more or less for each cell.
    fn cell(i: usize, onset: usize, end: f64) -> Vec<f64> {
        let own = 1.0 + 1e-3 * i as f64;
        (0..100).map(|t| if t < onset { 1e-4 * own * (t % 2) as f64 } else { end * own }).collect()
    }

    /// A setting called by its xi, of curves with these ends; all improve at `onset`.
    fn setting(xi: f64, onset: usize, ends: &[f64]) -> (String, Vec<Vec<f64>>) {
        let cells = ends.iter().enumerate().map(|(i, &end)| cell(i, onset, end));
        (format!("xi={xi}"), cells.collect())
    }

    /// Of settings whose names say what xi their cells recorded.
    fn results(settings: &[(String, Vec<Vec<f64>>)]) -> Results {
        let settings: Vec<_> =
            settings.iter().map(|(name, cells)| (name.as_str(), cells.clone())).collect();
        let mut run = run_of(&settings);
        let column = COLUMNS.iter().position(|column| column.name == "xi").unwrap();
        for setting in &mut run.settings {
            let xi = setting.name.rsplit("xi=").next().unwrap().parse().unwrap();
            setting.cells.iter_mut().for_each(|cell| cell.columns[column].fill(xi));
        }
        run
    }

    /// As the paper has it: eight cells of each xi; at 1 six of eight never start, one of them falls.
    fn as_in_the_paper() -> Vec<(String, Vec<Vec<f64>>)> {
        let mut task = setting(1.0, 40, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.05]);
        task.1[0] = cell(0, 30, 0.05)[..60].iter().chain(&[1e-4; 40]).copied().collect();
        let mut half = setting(0.5, 70, &[0.06; 8]);
        for (i, cell) in half.1.iter_mut().enumerate() {
            cell[90..].fill(0.07 + 1e-4 * i as f64);
        }
        vec![
            setting(0.0, 50, &[0.01; 8]),
            setting(0.25, 50, &[0.02; 8]),
            half,
            setting(0.75, 20, &[0.1; 8]),
            task,
        ]
    }

    fn verdicts(run: &Results) -> Vec<String> {
        let findings = Findings::of(run);
        assert_eq!(findings.groups.len(), 1);
        findings.groups[0].statements.iter().map(|it| it.verdict.to_string()).collect()
    }

    /// R_MI is half of R_Loc in these runs, so r is 1.
    #[test]
    fn what_the_paper_says_holds_where_it_is_so() {
        let run = results(&as_in_the_paper());
        let found = verdicts(&run);
        // Seven of eight: Wilson's interval of that begins at 0.53.
        assert_eq!(found, ["holds"; 5], "{:#?}", Findings::of(&run).groups[0].statements);
        let group = &Findings::of(&run).groups[0];
        assert_eq!(group.name, "");
        let xis: Vec<_> = group.mixes.iter().map(|mix| (mix.xi, mix.n)).collect();
        assert_eq!(xis, [(0.0, 8), (0.25, 8), (0.5, 8), (0.75, 8), (1.0, 8)]);
        assert!((group.correlation.unwrap().value - 1.0).abs() < 1e-12);
        assert_eq!(group.improvement.unwrap().value, 1.0);
        // 0.1 to 0.1007 m, and half of it.
        let best = &group.mixes[3];
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found}");
        near(best.last[0].value, 0.10035);
        near(best.last[1].value, 0.10035);
        near(best.last[3].value, 0.1007);
        near(best.intrinsic_nats.value, 0.050175);
        // xi = 0.5 starts 50 updates later.
        let later = &group.statements[1].evidence[1];
        assert_eq!(
            later.estimate.unwrap(),
            Estimate { value: 50.0, interval: Some(Interval { low: 50.0, high: 50.0 }) }
        );
        assert_eq!(
            later.said(),
            "median update of improvement minus that of xi = 0.75: 50.0 [50.0, 50.0] updates: holds"
        );
    }

    #[test]
    fn what_is_the_other_way_round_does_not_hold() {
        let run = results(&[
            setting(0.0, 20, &[0.1; 8]),
            setting(0.25, 20, &[0.09; 8]),
            setting(0.5, 20, &[0.01; 8]),
            setting(0.75, 50, &[0.02; 8]),
            setting(1.0, 20, &[0.05; 8]),
        ]);
        let found = verdicts(&run);
        assert_eq!(found[..4], ["doesn't hold"; 4], "{found:?}");
        // The lower ends of 0.5 and 0.75 against 0: each part says so.
        let groups = Findings::of(&run).groups;
        let low = &groups[0].statements[2].evidence;
        assert!(low.iter().all(|part| part.verdict == Verdict::Fails), "{low:?}");
    }

    #[test]
    fn few_cells_and_wide_ones_tell_nothing() {
        let three: Vec<_> = as_in_the_paper();
        let three = three.into_iter().map(|(name, mut cells)| {
            cells.truncate(3);
            (name, cells)
        });
        let found = verdicts(&results(&three.collect::<Vec<_>>()));
        assert_eq!(
            found,
            ["can't tell with 3 instances"; 3]
                .into_iter()
                .chain(["can't tell with 3 instances", "can't tell with 15 instances"])
                .collect::<Vec<_>>()
        );
        let wide = [0.0, 0.2, 0.0, 0.2, 0.0, 0.2, 0.0, 0.2];
        let run = results(&[setting(0.75, 20, &wide), setting(1.0, 20, &wide)]);
        let group = &Findings::of(&run).groups[0];
        let mean = &group.statements[0].evidence[1];
        assert_eq!(mean.verdict.to_string(), "can't tell with 8 instances");
        assert!((group.improvement.unwrap().value - 0.5).abs() < 0.01);
    }

    #[test]
    fn a_missing_xi_is_named_and_the_others_are_compared() {
        let run = results(&[setting(0.75, 20, &[0.1; 8]), setting(1.0, 20, &[0.05; 8])]);
        assert_eq!(
            verdicts(&run),
            [
                "can't tell without cells of xi = 0",
                "can't tell without cells of xi = 0.5",
                "can't tell without cells of xi = 0",
                "doesn't hold",
                "holds",
            ]
        );
        let best = &Findings::of(&run).groups[0].statements[0].evidence;
        assert_eq!(best.len(), 6);
        assert!(best[..3].iter().all(|part| part.verdict == Verdict::Holds), "{best:?}");
        // One that is worse is enough against the first statement.
        let run = results(&[setting(0.75, 20, &[0.05; 8]), setting(1.0, 20, &[0.1; 8])]);
        assert_eq!(verdicts(&run)[0], "doesn't hold");
        let alone = results(&[setting(0.5, 20, &[0.1; 8])]);
        assert_eq!(verdicts(&alone)[0], "can't tell without cells of xi = 0.75");
        let nothing_walks = results(&[setting(0.0, 20, &[-0.1; 8]), setting(0.25, 20, &[-0.2; 8])]);
        assert_eq!(verdicts(&nothing_walks)[2], "can't tell where no xi has a mean above 0");
    }

    #[test]
    fn settings_that_differ_in_more_than_xi_are_asked_for_themselves() {
        let named = |kind: &str, (name, cells): (String, Vec<Vec<f64>>)| {
            (format!("kind={kind},{name}"), cells)
        };
        let mut settings = Vec::new();
        for kind in ["crbm", "logistic"] {
            for xi in [1.0, 0.75] {
                settings.push(named(kind, setting(xi, 20, &[0.1 * xi; 2])));
            }
        }
        let mut run = results(&settings);
        let groups = Findings::of(&run).groups;
        let names: Vec<_> = groups.iter().map(|group| group.name.as_str()).collect();
        assert_eq!(names, ["kind=crbm", "kind=logistic"]);
        let xis: Vec<_> = groups[1].mixes.iter().map(|mix| mix.xi).collect();
        assert_eq!(xis, [0.75, 1.0]);
        // A schedule.
        let column = COLUMNS.iter().position(|column| column.name == "xi").unwrap();
        run.settings[0].cells[1].columns[column].fill(0.3);
        let findings = Findings::of(&run);
        assert_eq!(findings.left_out, ["kind=crbm,xi=1"]);
        assert_eq!(findings.groups[0].mixes.len(), 1);
    }

    #[test]
    fn names_lose_their_xi() {
        for (name, without) in [
            ("xi=0.75", ""),
            ("kind=crbm,xi=0.75", "kind=crbm"),
            ("mix.xi=1,power=2", "power=2"),
            ("base", "base"),
            ("xii=1", "xii=1"),
        ] {
            assert_eq!(without_xi(name), without);
        }
    }

    /// Cells that are published say the same but for what is smoothed away.
    #[test]
    fn rows_that_are_means_say_the_same() {
        let whole = results(&as_in_the_paper());
        let mut thin = whole.clone();
        thin.settings.iter_mut().for_each(|setting| setting.every = 5);
        let means = |values: &[f64]| values.chunks(5).map(mean).collect::<Vec<_>>();
        for cell in thin.settings.iter_mut().flat_map(|setting| &mut setting.cells) {
            cell.performance = means(&cell.performance);
            cell.intrinsic_nats = means(&cell.intrinsic_nats);
        }
        crate::Outcome::evaluate(std::slice::from_mut(&mut thin));
        let (whole, thin) = (Findings::of(&whole), Findings::of(&thin));
        assert_eq!(whole.groups[0].correlation, thin.groups[0].correlation);
        for (a, b) in whole.groups[0].mixes.iter().zip(&thin.groups[0].mixes) {
            for (a, b) in a.last.iter().zip(&b.last) {
                assert!((a.value - b.value).abs() < 1e-12);
            }
        }
        for (a, b) in whole.groups[0].statements.iter().zip(&thin.groups[0].statements) {
            assert_eq!(a.verdict, b.verdict);
        }
    }
}
