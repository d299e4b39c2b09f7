//! Close-up (the paper's figure 3): what the run is judged by, of some settings: all cells faint, a
//! few highlighted.

use plotters::{
    element::PathElement,
    style::{Color, RGBColor, text_anchor::HPos},
};

use super::{
    CellResults, Drawing, Error, Figure, Measure, Options, Results, Setting,
    axis::{Axis, BELOW, LEFT, Panel},
    canvas::{
        Area, BLUE, GREEN, GREY, INK, NORMAL, PAGE, PURPLE, Rect, SMALL, VERMILLION, font, line,
        notes_height, paint, setting_line, stroke, wrap, write, write_notes, write_y_label,
    },
    curves::{smoothed, window_for},
    numbers::capitalised,
    outcome::choice,
    statistics::mean,
};

pub(super) const FIGURE: Figure = Figure {
    name: "close-up",
    title: |measure| format!("Close-up of {}", measure.symbol),
    caption: |measure| {
        format!(
            "{} over updates for each cell of some settings, each smoothed by means over \
             windows; highlighted are the best, the median and the worst cell by the mean of \
             their last window, and the one that lost most from its best window to its last.",
            capitalised(&measure.name())
        )
    },
    draw,
    tables: |_| Vec::new(),
};

/// Points of a curve, and of all curves together: so many that a file stays small.
const POINTS: usize = 200;
const ALL_POINTS: usize = 24_000;

const FRAME_HEIGHT: f64 = 280.0;
const TITLE_LINE: f64 = 18.0;
const LEGEND_LINE: f64 = 18.0;
const MARGIN: f64 = 44.0;
const GAP: f64 = 30.0;

/// A highlighted cell.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Highlight {
    cell: usize,
    /// What for, as in "best, largest loss".
    why: String,
    color: RGBColor,
}

fn draw(run: &Results, options: &Options) -> Result<Drawing, Error> {
    let settings = chosen(run, options)?;
    let n_curves: usize = settings.iter().map(|setting| setting.cells.len()).sum();
    let most_points = POINTS.min(ALL_POINTS / n_curves.max(1)).max(30);
    let w = run.updates(|longest| window_for(longest, most_points));
    let of_setting = |setting: &&Setting| -> Vec<_> {
        let of_cell = |it: &CellResults| smoothed(setting, &it.performance, w);
        setting.cells.iter().map(of_cell).collect()
    };
    let curves: Vec<Vec<_>> = settings.iter().map(of_setting).collect();
    let y = Axis::around(curves.iter().flatten().flatten().map(|point| point[1]), 8);

    let n_columns = settings.len().min(2);
    let n_bands = settings.len().div_ceil(n_columns) as f64;
    let width = (PAGE - MARGIN - LEFT - 16.0 - GAP * (n_columns as f64 - 1.0)) / n_columns as f64;
    let x = Axis::updates(run.longest(), width);
    let lines = |setting: &&Setting| wrap(&setting_line(&setting.name), NORMAL, width).len();
    let title = settings.iter().map(lines).max().unwrap_or(1) as f64 * TITLE_LINE + 28.0;
    let band = title + FRAME_HEIGHT + BELOW + 30.0 + 4.0 * LEGEND_LINE + 10.0;
    let notes = run.with_caveats(vec![note(run, w)]);
    let caption = FIGURE.caption_with(run, &notes);
    paint(&FIGURE, n_bands * band + notes_height(&notes) + 14.0, caption, |area| {
        for (i, (setting, curves)) in settings.iter().zip(&curves).enumerate() {
            let (row, column) = (i / n_columns, i % n_columns);
            let frame = Rect {
                x: MARGIN + LEFT + column as f64 * (width + GAP),
                y: row as f64 * band + title,
                width,
                height: FRAME_HEIGHT,
            };
            let y_numbers = column == 0;
            let panel = Panel { frame, x: &x, y: &y, x_numbers: true, y_numbers };
            draw_panel(area, &panel, (&run.measure, setting), curves)?;
        }
        write_notes(area, n_bands * band + 8.0, &notes)
    })
}

fn note(run: &Results, w: usize) -> String {
    let smoothing = match w {
        1 => "Nothing is smoothed: each point is an update.".to_owned(),
        _ => format!("A point is a mean over {w} updates."),
    };
    format!(
        "{smoothing} Highlighted by the mean {} of windows of {} updates: the best, the median \
         and the worst last window, and the largest loss from the best window to the last.",
        run.measure.symbol,
        run.windows()
    )
}

/// As asked, or the setting with the highest mean and the last one; in the order of the sweep.
fn chosen<'a>(run: &'a Results, options: &Options) -> Result<Vec<&'a Setting>, Error> {
    let known = || run.settings.iter().map(|it| it.name.clone()).collect();
    if let Some(name) =
        options.settings.iter().find(|name| run.settings.iter().all(|it| &it.name != *name))
    {
        return Err(Error::Setting { name: name.clone(), known: known() });
    }
    let last = run.settings.len() - 1;
    let means: Vec<_> = run.settings.iter().map(|setting| mean(&setting.last())).collect();
    let best = (0..means.len()).max_by(|&a, &b| means[a].total_cmp(&means[b])).unwrap_or(last);
    // Of the best alone there would be nothing to compare with.
    let other = if best == last { last.saturating_sub(1) } else { last };
    let is_chosen = |(i, setting): &(usize, &Setting)| match options.settings.is_empty() {
        true => [best, other].contains(i),
        false => options.settings.contains(&setting.name),
    };
    Ok(run.settings.iter().enumerate().filter(is_chosen).map(|(_, setting)| setting).collect())
}

/// The cells that stand for others, each once.
fn highlights(setting: &Setting) -> Vec<Highlight> {
    let cells = &setting.cells;
    let choice = choice(cells);
    let loss = |i: &usize| cells[*i].outcome.best - cells[*i].outcome.last;
    let by = |of: &dyn Fn(&usize) -> f64| {
        // The first of equal ones.
        (0..cells.len()).rev().max_by(|a, b| of(a).total_cmp(&of(b))).unwrap_or(0)
    };
    let worst = by(&|i| -cells[*i].outcome.last);
    let most_lost = by(&loss);
    let wanted = [
        (choice.best, "best", BLUE),
        (choice.median, "median", GREEN),
        (worst, "worst", PURPLE),
        (most_lost, "largest loss", VERMILLION),
    ];
    let mut highlights: Vec<Highlight> = Vec::new();
    for (cell, why, color) in wanted {
        if why == "largest loss" && loss(&cell) <= 0.0 {
            continue;
        }
        match highlights.iter_mut().find(|it| it.cell == cell) {
            Some(known) => known.why += &format!(", {why}"),
            None => highlights.push(Highlight { cell, why: why.into(), color }),
        }
    }
    highlights
}

fn draw_panel(
    area: &Area<'_>,
    panel: &Panel<'_>,
    (measure, setting): (&Measure, &Setting),
    curves: &[Vec<[f64; 2]>],
) -> Result<(), Error> {
    let highlights = highlights(setting);
    let points = |curve: &[[f64; 2]]| curve.iter().map(|&[x, y]| (x, y)).collect::<Vec<_>>();
    panel.draw(area, |chart| {
        for (i, curve) in curves.iter().enumerate() {
            if highlights.iter().all(|it| it.cell != i) {
                let faint = stroke(GREY.mix(0.5), 0.8);
                chart.draw_series([PathElement::new(points(curve), faint)])?;
            }
        }
        // The best lies on top.
        for highlight in highlights.iter().rev() {
            let style = stroke(highlight.color, 1.8);
            chart.draw_series([PathElement::new(points(&curves[highlight.cell]), style)])?;
        }
        Ok(())
    })?;
    let frame = panel.frame;
    let middle = frame.x + frame.width / 2.0;
    let title = wrap(&setting_line(&setting.name), NORMAL, frame.width);
    for (i, text) in title.iter().rev().enumerate() {
        let at = (middle, frame.y - 30.0 - i as f64 * TITLE_LINE);
        write(area, text, at, &font(NORMAL, INK, HPos::Center))?;
    }
    let n = format!("n = {}", setting.cells.len());
    write(area, &n, (frame.right(), frame.y - 10.0), &font(SMALL, INK, HPos::Right))?;
    let below = frame.bottom() + BELOW;
    let label = font(SMALL, INK, HPos::Center);
    write(area, panel.x.updates_label(), (middle, below + 10.0), &label)?;
    if panel.y_numbers {
        write_y_label(area, frame, &measure.symbol, &measure.axis_unit())?;
    }
    for (i, it) in highlights.iter().enumerate() {
        let y = below + 34.0 + i as f64 * LEGEND_LINE;
        line(area, &[(frame.x, y), (frame.x + 26.0, y)], stroke(it.color, 2.5))?;
        let text = format!("seed {}: {}", setting.cells[it.cell].seed, it.why);
        write(area, &text, (frame.x + 32.0, y), &font(SMALL, INK, HPos::Left))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::run_of;

    fn flat(value: f64) -> Vec<f64> {
        vec![value; 20]
    }

    #[test]
    fn the_best_and_the_last_setting_are_shown() {
        let names = |values: &[f64], asked: &[&str]| {
            let names = ["a", "b", "c", "d"];
            let settings: Vec<_> =
                names.iter().zip(values).map(|(name, &it)| (*name, vec![flat(it)])).collect();
            let options = Options {
                settings: asked.iter().map(ToString::to_string).collect(),
                ..Options::default()
            };
            let run = run_of(&settings);
            let chosen = chosen(&run, &options);
            chosen.map(|it| it.iter().map(|setting| setting.name.clone()).collect::<String>())
        };
        assert_eq!(names(&[1.0, 3.0, 2.0, 0.0], &[]).unwrap(), "bd");
        assert_eq!(names(&[1.0, 2.0, 3.0, 4.0], &[]).unwrap(), "cd");
        assert_eq!(names(&[1.0], &[]).unwrap(), "a");
        assert_eq!(names(&[1.0, 2.0, 3.0], &["c", "a"]).unwrap(), "ac");
        let error = names(&[1.0, 2.0], &["xi=2"]).unwrap_err().to_string();
        assert_eq!(error, "no setting \"xi=2\" has an update; there are a, b");
    }

    #[test]
    fn each_cell_is_highlighted_once() {
        let fallen = [vec![9.0; 10], vec![2.0; 10]].concat();
        let run = run_of(&[("a", vec![flat(1.0), flat(3.0), fallen, flat(4.0), flat(5.0)])]);
        let found: Vec<_> =
            highlights(&run.settings[0]).into_iter().map(|it| (it.cell, it.why)).collect();
        let expected = [(4, "best"), (1, "median"), (0, "worst"), (2, "largest loss")]
            .map(|(i, why)| (i, why.into()));
        assert_eq!(found, expected);
        // Nobody lost anything.
        let run = run_of(&[("a", vec![flat(1.0)])]);
        let found = highlights(&run.settings[0]);
        assert_eq!((found.len(), found[0].why.as_str()), (1, "best, median, worst"));
    }
}
