//! Scatter (a figure of the paper's supplement): the information, the paper's R_MI, over what the run
//! is judged by, a sliding-window curve for each cell, and how the two correlate.

use plotters::{
    element::{Circle, PathElement},
    style::{Color, text_anchor::HPos},
};

use super::{
    CellResults, Drawing, Error, Figure, Information, Measure, Options, Results, Setting,
    axis::{Axis, BELOW, LEFT, Panel},
    canvas::{
        Area, INK, NORMAL, PAGE, Rect, SMALL, VIRIDIS, font, grid, notes_height, paint,
        setting_lines, stroke, write, write_notes, write_y_label,
    },
    curves::sliding_means,
    tables,
};
use crate::{capitalised, grouped};

pub(super) const FIGURE: Figure = Figure {
    name: "scatter",
    title: |measure| {
        let symbol = measure.information.as_ref().map_or("Information", |it| &it.symbol);
        format!("{symbol} against {}", measure.symbol)
    },
    caption: |measure| {
        let name = measure.information.as_ref().map_or("information".into(), Information::name);
        format!(
            "{} against {}: a curve for each cell, of means over a sliding window, with a dot where \
             it stands now; r is Pearson's correlation over the single updates of all cells.",
            capitalised(&name),
            measure.name()
        )
    },
    draw,
    tables: |run| tables::correlation(run).into_iter().collect(),
};

/// The window is this part of the longest cell.
const WINDOWS: usize = 20;
/// Points of a curve, and of all curves together: so many that a file stays small.
const POINTS: usize = 80;
const ALL_POINTS: usize = 20_000;

const COLUMNS: usize = 5;
const TITLE_LINE: f64 = 18.0;
const MARGIN: f64 = 44.0;
/// Numbers at the ends of two axes don't touch.
const GAP: f64 = 26.0;

fn draw(run: &Results, _: &Options) -> Result<Drawing, Error> {
    let Some(information) = &run.measure.information else {
        let why = "the reward has no information in it (reward.intrinsic.kind is 'none')".into();
        return Err(Error::Nothing { figure: FIGURE.name, why });
    };
    let w = run.updates(|longest| (longest / WINDOWS).max(1));
    let most_points = POINTS.min(ALL_POINTS / run.cells().count()).max(10);
    let curve = |setting: &Setting, cell: &CellResults| -> Vec<(f64, f64)> {
        let step = setting.longest_rows().div_ceil(most_points);
        let column = |values: &[f64]| sliding_means(values, setting.rows(w), step);
        let pairs = column(&cell.performance).into_iter().zip(column(&cell.intrinsic_nats));
        pairs.map(|([_, x], [_, y])| (x, y)).collect()
    };
    let of_setting = |it: &Setting| it.cells.iter().map(|cell| curve(it, cell)).collect();
    let curves: Vec<Vec<_>> = run.settings.iter().map(of_setting).collect();
    let points = || curves.iter().flatten().flatten();

    let n = run.settings.len();
    let n_columns = n.div_ceil(n.div_ceil(COLUMNS));
    let width = (PAGE - MARGIN - LEFT - 14.0 + GAP) / n_columns as f64 - GAP;
    let width = width.min(640.0);
    let height = (width * 1.1).min(330.0);
    let x = Axis::around(points().map(|&(x, _)| x), (width / 32.0) as usize);
    let y = Axis::around(points().map(|&(_, y)| y), 7);
    let lines = |setting: &Setting| setting_lines(&setting.name, NORMAL, width).len();
    let title = run.settings.iter().map(lines).max().unwrap_or(1) as f64 * TITLE_LINE + 28.0;
    let band = title + height + BELOW + 30.0;
    let n_bands = n.div_ceil(n_columns) as f64;
    let notes = run.with_caveats(vec![note(run, w)]);
    let caption = FIGURE.caption_with(run, &notes);
    paint(&FIGURE, n_bands * band + notes_height(&notes) + 12.0, caption, |area| {
        for (i, (setting, curves)) in run.settings.iter().zip(&curves).enumerate() {
            let (row, column) = (i / n_columns, i % n_columns);
            let frame = Rect {
                x: MARGIN + LEFT + column as f64 * (width + GAP),
                y: row as f64 * band + title,
                width,
                height,
            };
            let y_numbers = column == 0;
            let panel = Panel { frame, x: &x, y: &y, x_numbers: true, y_numbers };
            draw_panel(area, &panel, (&run.measure, information, setting), curves)?;
        }
        write_notes(area, n_bands * band + 6.0, &notes)
    })
}

/// `r = 0.789`
fn correlation(settings: &[Setting]) -> String {
    match tables::correlation_of(settings) {
        Some(r) => format!("r = {r:.3}").replace('-', "−"),
        None => "r undefined".into(),
    }
}

fn note(run: &Results, w: usize) -> String {
    let n: usize = run.cells().map(CellResults::updates).sum();
    format!(
        "Over all {} updates of all cells Pearson's {}. Curves are means over a sliding \
         window of {w} {}, one for each cell, in a colour of its own; the dot is its end.",
        grouped(n as u64),
        correlation(&run.settings),
        if w == 1 { "update" } else { "updates" }
    )
}

fn draw_panel(
    area: &Area<'_>,
    panel: &Panel<'_>,
    (measure, information, setting): (&Measure, &Information, &Setting),
    curves: &[Vec<(f64, f64)>],
) -> Result<(), Error> {
    // From early to late cells of the setting.
    let color = |i: usize| VIRIDIS[i * VIRIDIS.len() / curves.len()];
    panel.draw(area, |chart| {
        for (i, curve) in curves.iter().enumerate() {
            let style = stroke(color(i).mix(0.6), 1.0);
            chart.draw_series([PathElement::new(curve.clone(), style)])?;
        }
        for (i, end) in curves.iter().enumerate().filter_map(|(i, it)| Some((i, *it.last()?))) {
            chart.draw_series([Circle::new(end, grid(2.6), color(i).filled())])?;
        }
        Ok(())
    })?;
    let frame = panel.frame;
    let middle = frame.x + frame.width / 2.0;
    let lines = setting_lines(&setting.name, NORMAL, frame.width);
    for (i, text) in lines.iter().rev().enumerate() {
        let at = (middle, frame.y - 30.0 - i as f64 * TITLE_LINE);
        write(area, text, at, &font(NORMAL, INK, HPos::Center))?;
    }
    let r = format!("n = {}, {}", curves.len(), correlation(std::slice::from_ref(setting)));
    write(area, &r, (frame.right(), frame.y - 10.0), &font(SMALL, INK, HPos::Right))?;
    let Measure { symbol, unit, .. } = measure;
    let label = match panel.x.multiplier() {
        Some(multiplier) => format!("{symbol} / {multiplier} {unit} per step"),
        None => format!("{symbol} / {unit} per step"),
    };
    let below = (middle, frame.bottom() + BELOW + 10.0);
    write(area, &label, below, &font(SMALL, INK, HPos::Center))?;
    if panel.y_numbers {
        write_y_label(area, frame, &information.symbol, &information.axis_unit())?;
    }
    Ok(())
}
