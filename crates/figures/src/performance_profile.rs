//! Performance profiles (not in the paper): for each setting the share of its cells that reached more
//! than a score, over all scores.
//!
//! ```text
//! F(tau) = 1/N sum_n [x_n > tau]
//! ```
//!
//! after R. Agarwal et al., *Deep Reinforcement Learning at the Edge of the Statistical Precipice*, NeurIPS
//! 2021, section 4.2, where x_n is a run's score: here a cell's last window. Read across, it has the
//! quantiles of the cells; the area below it is their mean; of two that cross neither is better throughout.

use std::ops::Range;

use super::{
    Drawing, Error, Figure, Options, Results, Setting, Table,
    axis::Axis,
    line_chart::{Line, LineChart},
    statistics::{share_above, sorted},
    tables::{CURVE_REPLICATES, Estimate, caveats, number},
};

pub(super) const FIGURE: Figure = Figure {
    name: "profile",
    title: |_| "How many reached how much".into(),
    caption: |measure| {
        format!(
            "Performance profiles: the share of a setting's cells whose mean {} of the last window is above \
             a score, over all scores, with 95 % intervals by bootstrap (Agarwal et al. 2021).",
            measure.symbol
        )
    },
    draw,
    tables: |run| vec![table(run)],
};

/// Scores at which there are intervals, and rows of the table.
const SCORES: usize = 51;

/// A setting's profile.
struct Profile {
    /// In increasing order.
    reached: Vec<f64>,
    /// At each of the scores.
    shares: Vec<Estimate>,
}

impl Profile {
    fn of(setting: &Setting, scores: &[f64]) -> Self {
        let last = setting.last();
        let at = |&score: &f64| {
            Estimate::of([&last], CURVE_REPLICATES, |[values]| share_above(values, score))
        };
        Self { reached: sorted(&last), shares: scores.iter().map(at).collect() }
    }

    /// The staircase between two scores, each step where a cell is.
    fn steps(&self, range: &Range<f64>) -> Vec<(f64, f64)> {
        let n = self.reached.len() as f64;
        let steps = self.reached.iter().enumerate();
        let steps =
            steps.flat_map(|(i, &x)| [(x, 1.0 - i as f64 / n), (x, 1.0 - (i + 1) as f64 / n)]);
        [(range.start, 1.0)].into_iter().chain(steps).chain([(range.end, 0.0)]).collect()
    }
}

/// From a little below the lowest cell to a little above the highest, evenly.
fn scores(run: &Results) -> Vec<f64> {
    let range = Axis::around(run.settings.iter().flat_map(Setting::last), 8).range;
    let step = (range.end - range.start) / (SCORES - 1) as f64;
    (0..SCORES).map(|i| range.start + i as f64 * step).collect()
}

fn profiles(run: &Results, scores: &[f64]) -> Vec<Profile> {
    runs::parallel::map(&run.settings, |setting| Profile::of(setting, scores))
}

fn draw(run: &Results, _: &Options) -> Result<Drawing, Error> {
    let scores = scores(run);
    let profiles = profiles(run, &scores);
    let x = Axis::around(run.settings.iter().flat_map(Setting::last), 12);
    let multiplier = x.multiplier().map(|it| format!("{it} ")).unwrap_or_default();
    let (symbol, unit) = (&run.measure.symbol, run.measure.axis_unit());
    let chart = LineChart {
        figure: &FIGURE,
        run,
        top: 20.0,
        height: 300.0,
        x,
        x_label: format!("score: {symbol} of the last window / {multiplier}{unit}"),
        y: Axis::new(0.0..1.0, 6),
        y_label: ["cells", "share above the score"],
        notes: [vec![note(run)], caveats(run)].concat(),
    };
    let range = scores[0]..scores[SCORES - 1];
    let line = |it: &Profile| {
        let shares = scores.iter().zip(&it.shares);
        let band = shares.filter_map(|(&score, share)| Some((score, share.interval?)));
        Line { points: it.steps(&range), band: band.collect() }
    };
    chart.draw(&profiles.iter().map(line).collect::<Vec<_>>())
}

fn note(run: &Results) -> String {
    format!(
        "A score is the mean {} of a cell's last {} updates. Line: share of a setting's cells above it; \
         shaded: its 95 % interval at each score (percentile bootstrap).",
        run.measure.symbol,
        run.windows()
    )
}

fn table(run: &Results) -> Table {
    let score = run.measure.column("score");
    let header = ["setting", &score, "share_above", "share_low", "share_high"];
    let scores = scores(run);
    let all = run.settings.iter().zip(profiles(run, &scores));
    let rows = all.flat_map(|(setting, profile)| {
        let row = |(score, share): (&f64, Estimate)| {
            let row = [setting.name.clone(), number(*score)].into_iter();
            row.chain(Estimate::fields(Some(share))).collect()
        };
        scores.iter().zip(profile.shares).map(row).collect::<Vec<Vec<_>>>()
    });
    Table { name: "profile", header: header.map(str::to_owned).into(), rows: rows.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::run_of;

    fn flat(values: &[f64]) -> Vec<Vec<f64>> {
        values.iter().map(|&value| vec![value; 20]).collect()
    }

    /// 1, 2, 2 and 4: above 0 are 4 of 4, above 1 three, above 2 one, above 4 none.
    #[test]
    fn a_profile_falls_at_each_cell() {
        let run = run_of(&[("a", flat(&[4.0, 2.0, 1.0, 2.0]))]);
        let profile = Profile::of(&run.settings[0], &[0.0, 1.0, 1.5, 2.0, 4.0]);
        let shares: Vec<_> = profile.shares.iter().map(|it| it.value).collect();
        assert_eq!(shares, [1.0, 0.75, 0.75, 0.25, 0.0]);
        let steps = profile.steps(&(0.0..5.0));
        assert_eq!(steps[..3], [(0.0, 1.0), (1.0, 1.0), (1.0, 0.75)]);
        assert_eq!(steps[steps.len() - 2..], [(4.0, 0.0), (5.0, 0.0)]);
        // The area below it, from 0, is the mean: 9/4.
        let area: f64 = steps.windows(2).map(|it| (it[1].0 - it[0].0) * it[0].1).sum();
        assert!((area - 9.0 / 4.0).abs() < 1e-12, "{area}");
    }

    /// A share's replicates are binomial: of 8 cells with 6 above, 2.5 % and 97.5 % of B(8, 3/4) / 8 are
    /// 3/8 (P(k <= 2) = 0.4 %, P(k <= 3) = 2.7 %) and 1 (P(k = 8) = 10 %).
    #[test]
    fn its_intervals_are_those_of_binomial_shares() {
        let run = run_of(&[("a", flat(&[0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]))]);
        let profile = Profile::of(&run.settings[0], &[0.5]);
        let interval = profile.shares[0].interval.unwrap();
        assert_eq!((interval.low, interval.high), (3.0 / 8.0, 1.0));
    }

    #[test]
    fn few_cells_have_no_band() {
        let of = |n: usize| {
            let values: Vec<_> = (0..n).map(|i| i as f64).collect();
            draw(&run_of(&[("a", flat(&values))]), &Options::default()).unwrap().svg
        };
        assert!(!of(5).contains("<polygon") && of(6).contains("<polygon"));
    }
}
