//! Health (not in the paper): all other columns of the metrics, so that one sees how training goes:
//! do the parameters grow, do gradients vanish, do parts touch that shouldn't, do readings leave
//! their range.

use plotters::{
    element::{PathElement, Polygon},
    style::{Color, RGBColor, text_anchor::HPos},
};
use runs::{COLUMNS, Column};

use super::{
    Drawing, Error, Figure, Measure, Options, Results, Setting,
    axis::{Axis, BELOW, Chart, LEFT, Panel},
    canvas::{
        Area, GREY, INK, PAGE, Rect, SMALL, font, notes_height, paint, stroke, viridis, write,
        write_notes,
    },
    curves::{EXTREMES, Spread, Thinned, spreads},
    legend::Legend,
};

pub(super) const FIGURE: Figure = Figure {
    name: "health",
    title: |_| "How training goes".into(),
    caption: |_| {
        "All other columns of the metrics over updates: for each setting the median of its \
         cells, and shaded what lies between the lowest and the highest."
            .into()
    },
    draw,
    tables: |_| Vec::new(),
};

/// Points of a curve, and of those of all settings together, so that a file stays small.
const POINTS: usize = 120;
const ALL_POINTS: usize = 700;

const N_COLUMNS: usize = 3;
const HEIGHT: f64 = 118.0;
const GAP: f64 = 16.0;
const TITLE: f64 = 34.0;
const BAND: f64 = TITLE + HEIGHT + BELOW + 8.0;

/// A column's panel.
struct Quantity {
    column: &'static Column,
    /// Of each setting.
    curves: Vec<Vec<Spread>>,
}

fn draw(run: &Results, _: &Options) -> Result<Drawing, Error> {
    let w = window(run);
    let quantities = quantities(run, w);
    let n_bands = quantities.len().div_ceil(N_COLUMNS);
    let legend = Legend::of(&run.settings);
    let notes = run.with_caveats(vec![note(w)]);
    let caption = FIGURE.caption_with(run, &notes);
    let bottom = n_bands as f64 * BAND + 26.0;
    paint(&FIGURE, bottom + legend.height() + notes_height(&notes) + 14.0, caption, |area| {
        for (i, quantity) in quantities.iter().enumerate() {
            let is_last = i + N_COLUMNS >= quantities.len();
            draw_panel(area, run, quantity, (frame(i), is_last))?;
        }
        legend.draw(area, bottom)?;
        write_notes(area, bottom + legend.height() + 6.0, &notes)
    })
}

/// Of the panel `i`.
fn frame(i: usize) -> Rect {
    let slot = (PAGE - 4.0) / N_COLUMNS as f64;
    let (row, column) = (i / N_COLUMNS, i % N_COLUMNS);
    Rect {
        x: column as f64 * slot + LEFT,
        y: row as f64 * BAND + TITLE,
        width: slot - LEFT - GAP,
        height: HEIGHT,
    }
}

/// The window of all curves, in updates.
fn window(run: &Results) -> usize {
    let most_points = POINTS.min(ALL_POINTS / run.settings.len()).max(16);
    let kept = |setting: &Setting| kept(setting) * setting.every;
    let kept = run.settings.iter().map(kept).max().unwrap_or(1);
    run.updates(|longest| longest.div_ceil(most_points).next_power_of_two()).max(kept)
}

/// Rows of the longest windows that a setting's columns are kept in.
fn kept(setting: &Setting) -> usize {
    let columns = setting.cells.iter().flat_map(|it| &it.columns);
    columns.map(Thinned::window).max().unwrap_or(1)
}

/// What the other figures don't show, where anything is known of it.
fn quantities(run: &Results, w: usize) -> Vec<Quantity> {
    let spread = |place: usize, setting: &Setting| {
        // A power of two that isn't above w, nor below that of any column.
        let rows = (1 << setting.rows(w).ilog2()).max(kept(setting));
        let curves = setting.cells.iter().map(|it| it.columns[place].over(rows, setting.every));
        spreads(&curves.collect::<Vec<_>>(), EXTREMES)
    };
    let quantity = |(place, column): (usize, &'static Column)| Quantity {
        column,
        curves: run.settings.iter().map(|setting| spread(place, setting)).collect(),
    };
    let columns = COLUMNS.iter().enumerate().filter(|(_, it)| is_other(it.name, &run.measure));
    let known = |it: &Quantity| it.curves.iter().any(|curve| !curve.is_empty());
    columns.map(quantity).filter(known).collect()
}

/// Whether a column is neither what counts updates nor what the learning curves show.
fn is_other(name: &str, measure: &Measure) -> bool {
    match name {
        "update" | "control_steps" | "R" | "R_MI_nats" | "task" => false,
        "R_Loc" => !measure.is_advance(),
        "R_MI" | "R_MI_miller_madow_nats" => measure.information.is_some(),
        _ => true,
    }
}

fn note(w: usize) -> String {
    let smoothing = match w {
        1 => "Nothing is smoothed: each point is an update.".into(),
        _ => format!("Each cell is smoothed first: a point is its mean over {w} updates."),
    };
    format!(
        "Line: median of a setting's cells; shaded: from the lowest to the highest. {smoothing}"
    )
}

fn draw_panel(
    area: &Area<'_>,
    run: &Results,
    Quantity { column, curves }: &Quantity,
    (frame, is_last): (Rect, bool),
) -> Result<(), Error> {
    let values = curves.iter().flatten().flat_map(|it| it.quantiles);
    let [low, high] =
        [values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max)];
    // A line of which all is said with a number.
    let constant = (low == high).then_some(low);
    let room = constant.map_or(0.0, |it| it.abs().max(1.0));
    let y = Axis::around([low - room, high + room].into_iter(), 5);
    let x = Axis::updates(run.longest(), frame.width);
    let panel = Panel { frame, x: &x, y: &y, x_numbers: true, y_numbers: constant.is_none() };
    panel.draw(area, |chart| {
        for (i, curve) in curves.iter().enumerate() {
            draw_curve(chart, curve, viridis(i, curves.len()))?;
        }
        Ok(())
    })?;
    let middle = frame.x + frame.width / 2.0;
    if let Some(value) = constant {
        let at = (middle, frame.y + frame.height / 4.0);
        write(area, &format!("always {value}"), at, &font(SMALL, GREY, HPos::Center))?;
    }
    let title = match column.unit {
        "" => column.label.to_owned(),
        unit => format!("{} / {unit}", column.label),
    };
    write(area, &title, (frame.x, frame.y - 11.0), &font(SMALL, INK, HPos::Left))?;
    if is_last {
        let at = (middle, frame.bottom() + BELOW + 9.0);
        write(area, x.updates_label(), at, &font(SMALL, INK, HPos::Center))?;
    }
    Ok(())
}

fn draw_curve(chart: &mut Chart<'_, '_>, curve: &[Spread], color: RGBColor) -> Result<(), Error> {
    let quantile = |i: usize| curve.iter().map(move |it| (it.update, it.quantiles[i]));
    let around: Vec<_> = quantile(0).chain(quantile(2).rev()).collect();
    chart.draw_series([Polygon::new(around, color.mix(0.16))])?;
    chart.draw_series([PathElement::new(quantile(1).collect::<Vec<_>>(), stroke(color, 1.6))])?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::run_of;

    fn shown(run: &Results) -> Vec<&'static str> {
        quantities(run, window(run)).iter().map(|it| it.column.name).collect()
    }

    #[test]
    fn every_column_is_shown_in_one_figure_or_another() {
        let mut run = run_of(&[("a", vec![vec![1.0, 2.0]])]);
        let walking = shown(&run);
        for name in ["gradient_norm", "parameter_norm", "penalised_contacts", "clipped_readings"] {
            assert!(walking.contains(&name), "{walking:?}");
        }
        let elsewhere = ["update", "control_steps", "R", "R_MI_nats", "R_Loc", "task"];
        assert_eq!(walking.len() + elsewhere.len(), COLUMNS.len());
        // Of another task the way is a column like others.
        let information = run.measure.information.take();
        run.measure = Measure::of_task("turning", "turning", "rad").with(information, None);
        assert_eq!(shown(&run).len(), walking.len() + 1);
        let drawn = draw(&run, &Options::default()).unwrap();
        assert!(drawn.svg.contains("way along the heading / m per control step"));
        assert!(!(drawn.svg.clone() + &drawn.caption).contains("R_Loc"));
    }

    #[test]
    fn a_column_of_which_nothing_is_known_is_not_shown() {
        let mut run = run_of(&[("a", vec![vec![1.0, 2.0]])]);
        let place = COLUMNS.iter().position(|it| it.name == "gradient_norm").unwrap();
        run.settings[0].cells[0].columns[place].fill(f64::NAN);
        assert!(!shown(&run).contains(&"gradient_norm"));
        let drawn = draw(&run, &Options::default()).unwrap();
        assert!(!drawn.svg.contains("norm of the gradient") && !drawn.svg.contains("NaN"));
    }

    #[test]
    fn what_never_changes_is_said() {
        let run = run_of(&[("a", vec![vec![0.0; 20]; 3])]);
        assert!(draw(&run, &Options::default()).unwrap().svg.contains("always 0"));
    }
}
