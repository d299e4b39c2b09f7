//! Sample efficiency (not in the paper): the interquartile mean of a setting's cells after so many control
//! steps.
//!
//! The sample-efficiency curves of R. Agarwal et al., *Deep Reinforcement Learning at the Edge of the
//! Statistical Precipice*, NeurIPS 2021, as their library rliable makes them: at each point the IQM over
//! cells with a 95 % bootstrap interval, the same cells drawn at all points of a replicate. Samples are
//! control steps, those of all worlds of a cell together: an update of 32 worlds has taken 32 times as
//! many as that of one.

use super::{
    Drawing, Error, Figure, Options, Results, Setting, Table,
    axis::Axis,
    curves::{smoothed, window_for},
    line_chart::{Line, LineChart, WIDTH},
    statistics::interquartile_mean,
    tables::{CURVE_REPLICATES, Estimate, caveats, number},
};

pub(super) const FIGURE: Figure = Figure {
    name: "efficiency",
    title: |_| "What was reached after how many steps".into(),
    caption: |measure| {
        format!(
            "Sample efficiency: the interquartile mean of {} over a setting's cells after so many control \
             steps, those of all worlds of a cell together, with 95 % intervals by bootstrap (Agarwal et \
             al. 2021).",
            measure.symbol
        )
    },
    draw,
    tables: |run| vec![table(run)],
};

/// Points of a setting's curve at most.
const POINTS: usize = 40;

/// What a setting's cells had reached at one time.
struct Point {
    control_steps: f64,
    /// Cells that have come so far.
    n: usize,
    iqm: Estimate,
}

/// At the middles of windows, of which the setting's longest cell has up to so many.
fn curve(setting: &Setting) -> Vec<Point> {
    let w = window_for(setting.longest_rows(), POINTS) * setting.every;
    let cells = setting.cells.iter().map(|cell| smoothed(setting, &cell.performance, w));
    let cells: Vec<_> = cells.collect();
    let n_points = cells.iter().map(Vec::len).max().unwrap_or(0);
    let point = |i: usize| {
        let there: Vec<_> = cells.iter().filter_map(|cell| cell.get(i)).collect();
        let update = there.iter().map(|point| point[0]).fold(0.0, f64::max);
        let values: Vec<_> = there.iter().map(|point| point[1]).collect();
        // Each time from the same seed: of as many cells the same ones are drawn at all points.
        let iqm = Estimate::of([&values], CURVE_REPLICATES, |[it]| interquartile_mean(it));
        Point { control_steps: update * setting.steps_per_update, n: values.len(), iqm }
    };
    (0..n_points).map(point).collect()
}

fn draw(run: &Results, _: &Options) -> Result<Drawing, Error> {
    let curves = runs::parallel::map(&run.settings, curve);
    let ends = |it: &Point| it.iqm.interval.map_or([it.iqm.value; 2], |it| [it.low, it.high]);
    let x = Axis::counts(run.settings.iter().map(run_steps).fold(1.0, f64::max), WIDTH);
    let chart = LineChart {
        figure: &FIGURE,
        run,
        top: 24.0,
        height: 340.0,
        x_label: x.counts_label("control steps of a cell"),
        x,
        y: Axis::around(curves.iter().flatten().flat_map(ends), 8),
        y_label: [&run.measure.symbol, &run.measure.axis_unit()],
        notes: [vec![note()], caveats(run)].concat(),
    };
    let line = |curve: &Vec<Point>| Line {
        points: curve.iter().map(|it| (it.control_steps, it.iqm.value)).collect(),
        band: curve.iter().filter_map(|it| Some((it.control_steps, it.iqm.interval?))).collect(),
    };
    chart.draw(&curves.iter().map(line).collect::<Vec<_>>())
}

/// Control steps of a setting's longest cell.
fn run_steps(setting: &Setting) -> f64 {
    let longest = setting.cells.iter().map(super::CellResults::updates).max().unwrap_or(0);
    longest as f64 * setting.steps_per_update
}

fn note() -> String {
    format!(
        "Line: interquartile mean of a setting's cells that have come so far; shaded: its 95 % interval at \
         each point (percentile bootstrap). Each cell is smoothed first: a point is its mean over the \
         updates around it, 1/{POINTS} of those of the setting's longest cell."
    )
}

fn table(run: &Results) -> Table {
    let of = |what| run.measure.column(what);
    let header = vec![
        "setting".into(),
        "control_steps".into(),
        "instances".into(),
        of("IQM"),
        of("IQM_low"),
        of("IQM_high"),
    ];
    let curves = runs::parallel::map(&run.settings, curve);
    let rows = run.settings.iter().zip(curves).flat_map(|(setting, curve)| {
        let row = |it: Point| {
            let row = [setting.name.clone(), number(it.control_steps), it.n.to_string()];
            row.into_iter().chain(Estimate::fields(Some(it.iqm))).collect()
        };
        curve.into_iter().map(row).collect::<Vec<Vec<_>>>()
    });
    Table { name: "efficiency", header, rows: rows.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::run_of;

    /// Eighty updates: windows of two, whose middles are updates 1.5, 3.5, ... Cell i is at i + t in
    /// update t; without two of each end of eight, the IQM is that of 2 to 5, which is 3.5 + t.
    #[test]
    fn a_point_is_the_interquartile_mean_after_so_many_steps() {
        let cell = |i: usize| (1..=80).map(|t| (i + t) as f64).collect();
        let mut run = run_of(&[("a", (0..8).map(cell).collect())]);
        run.settings[0].steps_per_update = 3200.0;
        let curve = curve(&run.settings[0]);
        assert_eq!(curve.len(), 40);
        for (k, point) in curve.iter().enumerate() {
            let t = 2.0 * k as f64 + 1.5;
            assert_eq!((point.control_steps, point.n), (3200.0 * t, 8));
            assert!((point.iqm.value - (3.5 + t)).abs() < 1e-12);
        }
        // The same cells are drawn at all points: the interval is as wide everywhere, and lies alike.
        let ends = |it: &Point| it.iqm.interval.map(|it| [it.low, it.high]).unwrap();
        let [low, high] = ends(&curve[0]).map(|end| end - curve[0].iqm.value);
        for point in &curve {
            let found = ends(point).map(|end| end - point.iqm.value);
            assert!((found[0] - low).abs() < 1e-9 && (found[1] - high).abs() < 1e-9);
        }
        assert!(-3.0 < low && low < -0.5 && 0.5 < high && high < 3.0, "{low} {high}");
    }

    /// Where fewer than six have come so far there's no interval; and an end by one cell is still told.
    #[test]
    fn cells_count_as_far_as_they_have_come() {
        let cell = |n: usize| vec![1.0; n];
        let run = run_of(&[("a", vec![cell(40), cell(40), cell(20)])]);
        let n: Vec<_> = curve(&run.settings[0]).iter().map(|it| it.n).collect();
        assert_eq!((n.len(), n[19], n[20]), (40, 3, 2));
        assert!(curve(&run.settings[0]).iter().all(|it| it.iqm.interval.is_none()));
    }
}
