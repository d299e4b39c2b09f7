//! The paper's statements, one function each, and the definitions that it leaves to the reader.

use super::{
    Arm, Evidence, Statement, Statistic, Verdict, correlation, maximum, mean, median,
    parts::{difference, find},
};
use crate::{
    CellResults, Results, Setting,
    curves::window_means,
    statistics::wilson,
    tables::{Estimate, enough_for_interval},
};

/// The paper's xi, each with 30 instances.
const PAPERS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
/// The paper's r, over all updates of all its instances.
const PAPERS_R: f64 = 0.7888;
/// From here on a correlation is called large (Cohen, *Statistical Power Analysis*, 1988).
const LARGE_R: f64 = 0.5;
/// The share that more than half of the instances are.
const MOST: f64 = 0.5;
/// The part of the highest mean from which on a mean is called high.
const HIGH: f64 = 0.5;
/// Smoothing windows of an onset, in each window of the run.
const FINER: usize = 10;

/// All five, in the paper's order.
pub(super) fn all(run: &Results, arms: &[Arm<'_>]) -> Vec<Statement> {
    let symbol = &run.measure.symbol;
    let statement = |text: String, evidence: Vec<Evidence>| {
        let verdict = Verdict::of(&evidence);
        Statement { text, evidence, verdict }
    };
    vec![
        statement(
            format!("xi = 0.75 gives the highest {symbol}, in maximum, mean and median"),
            best(run, arms),
        ),
        statement(
            "xi = 0.5 is good, too; it improves later, and is still rising at the end".into(),
            later(run, arms),
        ),
        statement(format!("xi = 0 and 0.25 give no high {symbol}"), low(run, arms)),
        statement(
            "with xi = 1 more than half of the instances make no significant progress, and some \
             collapse"
                .into(),
            without_progress(arms),
        ),
        statement(
            format!(
                "{symbol} and {} are high together: Pearson's r {PAPERS_R} over all updates",
                run.measure.information.as_ref().map_or("information", |it| &it.symbol)
            ),
            vec![rising_together(arms)],
        ),
    ]
}

/// How all is judged.
pub(super) fn notes(run: &Results) -> Vec<String> {
    let (symbol, window) = (&run.measure.symbol, run.windows());
    vec![
        format!(
            "A value is a cell's mean {symbol} over its last {window} updates; in brackets the 95 % \
             interval (percentile bootstrap over cells; of a share Wilson's), which fewer than 6 cells \
             don't have. Each stands by itself, not corrected for their number. An interval of a \
             maximum can't reach beyond the highest cell."
        ),
        format!(
            "A part holds if its interval lies above 0, for a share above {MOST} and for r above \
             {LARGE_R}, and doesn't hold if it lies below; otherwise more instances are needed. A \
             statement holds if all its parts do, and doesn't if one doesn't."
        ),
        format!(
            "High: at least half of the highest mean of all xi. Improving: reaching, with means over \
             {} updates, half of the way from the first window to the best one; only cells that made \
             significant progress. Rising: the last window over the one before.",
            finest(run)
        ),
        "No significant progress: the gain over the first window is less than a tenth of the run's \
         largest, or not significant (Welch's t-test, 5 %). Collapsed: the best window showed progress, \
         and the last kept less than half of its gain."
            .into(),
    ]
}

/// Against each of the others that are there, and for each of the paper's that isn't.
fn best(run: &Results, arms: &[Arm<'_>]) -> Vec<Evidence> {
    let Some(favourite) = find(arms, 0.75) else { return vec![none_of(0.75)] };
    let statistics: [(&str, Statistic); 3] =
        [("maximum", maximum), ("mean", mean), ("median", median)];
    let others = || arms.iter().filter(|arm| arm.place != favourite.place);
    let against = |arm: &Arm<'_>| {
        statistics.map(|(name, of)| {
            let what = format!("{name} minus that of xi = {}", arm.xi);
            let both = [&favourite.last[..], &arm.last];
            difference(what, &run.measure.unit, both, |x, y| of(x) - of(y))
        })
    };
    let missing = PAPERS.iter().filter(|&&xi| find(arms, xi).is_none());
    others().flat_map(against).chain(missing.map(|&xi| none_of(xi))).collect()
}

fn later(run: &Results, arms: &[Arm<'_>]) -> Vec<Evidence> {
    let Some(half) = find(arms, 0.5) else { return vec![none_of(0.5)] };
    let high = highness(run, arms, half, true);
    let later = match find(arms, 0.75) {
        None => none_of(0.75),
        Some(other) => {
            let onsets = [half, other].map(|arm| onsets(arm.setting));
            let what = "median update of improvement minus that of xi = 0.75";
            let [x, y] = [&onsets[0][..], &onsets[1][..]];
            difference(what.into(), "updates", [x, y], |x, y| median(x) - median(y))
        }
    };
    let gains: Vec<_> =
        half.setting.cells.iter().filter_map(|it| last_gain(half.setting, it)).collect();
    let rising = Evidence::of(
        "mean of the last window minus that of the one before".into(),
        &run.measure.unit,
        (!gains.is_empty())
            .then(|| Estimate::of([&gains], super::REPLICATES, |[gains]| mean(gains))),
        (0.0, gains.len()),
    );
    vec![high, later, rising]
}

fn low(run: &Results, arms: &[Arm<'_>]) -> Vec<Evidence> {
    let of = |xi| find(arms, xi).map_or_else(|| none_of(xi), |arm| highness(run, arms, arm, false));
    [0.0, 0.25].map(of).into()
}

fn without_progress(arms: &[Arm<'_>]) -> Vec<Evidence> {
    let Some(task) = find(arms, 1.0) else { return vec![none_of(1.0)] };
    let outcomes = || task.setting.cells.iter().map(|cell| cell.outcome);
    let progressed: Vec<_> = outcomes().filter_map(|it| it.progressed).collect();
    let n = progressed.len();
    let n_without = progressed.iter().filter(|it| !**it).count();
    let n_collapsed = outcomes().filter(|it| it.collapsed == Some(true)).count();
    let without = "share without significant progress";
    vec![
        Evidence::of(without.into(), "", share(n_without, n), (MOST, n)),
        Evidence {
            what: "share that collapsed, of whom one is enough".into(),
            estimate: share(n_collapsed, n),
            unit: String::new(),
            // That none of a few did says little.
            verdict: if n_collapsed > 0 { Verdict::Holds } else { Verdict::with(n) },
        },
    ]
}

fn rising_together(arms: &[Arm<'_>]) -> Evidence {
    let estimate = correlation(arms);
    let n = arms.iter().map(|arm| arm.last.len()).sum();
    let inside = estimate.and_then(|it| it.interval).map_or("", |it| {
        match (it.low..=it.high).contains(&PAPERS_R) {
            true => ", whose interval has the paper's in it",
            false => ", whose interval doesn't have the paper's in it",
        }
    });
    Evidence::of(format!("r over all updates{inside}"), "", estimate, (LARGE_R, n))
}

/// By how much the mean of an arm is above half of the highest, or below it.
fn highness(run: &Results, arms: &[Arm<'_>], arm: &Arm<'_>, is_above: bool) -> Evidence {
    let highest = arms.iter().max_by(|a, b| mean(&a.last).total_cmp(&mean(&b.last))).unwrap_or(arm);
    let sign = if is_above { 1.0 } else { -1.0 };
    let what = match is_above {
        true => format!("mean of xi = {} minus half of the highest mean", arm.xi),
        false => format!("half of the highest mean minus that of xi = {}", arm.xi),
    };
    let unit = &run.measure.unit;
    if mean(&highest.last) <= 0.0 {
        let why = "where no xi has a mean above 0".to_owned();
        return Evidence { what, estimate: None, unit: unit.clone(), verdict: Verdict::Open(why) };
    }
    let both = [&arm.last[..], &highest.last];
    match highest.place == arm.place {
        // Drawn once, since it's the same cells.
        true => difference(what, unit, both, |x, _| sign * (1.0 - HIGH) * mean(x)),
        false => difference(what, unit, both, |x, y| sign * (mean(x) - HIGH * mean(y))),
    }
}

fn none_of(xi: f64) -> Evidence {
    let (what, unit) = (format!("xi = {xi}"), String::new());
    Evidence { what, estimate: None, unit, verdict: Verdict::missing(xi) }
}

fn share(n_true: usize, n: usize) -> Option<Estimate> {
    let places: Vec<_> = (0..n).map(|i| i as f64).collect();
    let interval = enough_for_interval(&[&places]).then(|| wilson(n_true, n));
    (n > 0).then(|| Estimate { value: n_true as f64 / n as f64, interval })
}

/// Rows of an onset's smoothing window.
fn finer(setting: &Setting) -> usize {
    (setting.window_rows() / FINER).max(1)
}

/// The same in updates: the longest of all settings.
fn finest(run: &Results) -> usize {
    run.settings.iter().map(|it| finer(it) * it.every).max().unwrap_or(1)
}

/// When each cell that made progress at some time came half of the way to its best window.
fn onsets(setting: &Setting) -> Vec<f64> {
    let is_told =
        |it: &&CellResults| [it.outcome.progressed, it.outcome.collapsed].contains(&Some(true));
    let onset = |cell: &CellResults| {
        let half = 0.5 * (cell.outcome.first + cell.outcome.best);
        let points = window_means(&cell.performance, finer(setting), setting.every);
        points.into_iter().find(|[_, value]| *value >= half).map(|[update, _]| update)
    };
    setting.cells.iter().filter(is_told).filter_map(onset).collect()
}

/// The mean of a cell's last window minus that of the one before; none if it's too short.
fn last_gain(setting: &Setting, cell: &CellResults) -> Option<f64> {
    let (values, window) = (&cell.performance, setting.window_rows());
    let before = values.len().checked_sub(2 * window)?;
    let (before, last) = values[before..].split_at(window);
    Some(mean(last) - mean(before))
}
