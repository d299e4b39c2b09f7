//! Learning curves (the paper's figure 2): a column a setting, rows R, the information, the paper's
//! R_MI, and what the run is judged by, the paper's R_Loc, over updates.

use plotters::{
    element::{PathElement, Polygon},
    style::{Color, RGBColor, text_anchor::HPos},
};

use super::{
    CellResults, Drawing, Error, Figure, Measure, Options, Results, Setting,
    axis::{Axis, BELOW, Chart, LEFT, Panel},
    canvas::{
        Area, BLUE, GREEN, INK, NORMAL, PAGE, Rect, SMALL, VERMILLION, fill, font, line,
        notes_height, paint, room, setting_lines, stroke, write, write_notes, write_y_label,
    },
    curves::{QUARTILES, Spread, smoothed, spreads, window_for},
};

pub(super) const FIGURE: Figure = Figure {
    name: "learning-curves",
    title: |_| "Learning curves".into(),
    caption: |measure| {
        let information = measure.information.as_ref().map(|it| format!(", {}", it.name()));
        format!(
            "Reward R{} and {} over updates for each setting: quartiles, the middle half and the mean \
             of its cells, each smoothed by means over windows.",
            information.unwrap_or_default(),
            measure.name()
        )
    },
    draw,
    tables: |_| Vec::new(),
};

/// Points of a curve, which are about as many as px of a panel, and of those of all settings
/// together, so that a file stays small.
const POINTS: usize = 150;
const ALL_POINTS: usize = 1100;
/// Columns beside each other.
const COLUMNS: usize = 5;
const ROW: f64 = 128.0;
const GAP: f64 = 24.0;
const TITLE_LINE: f64 = 18.0;
const MARGIN: f64 = 44.0;

/// A row.
struct Quantity {
    label: String,
    unit: String,
    color: RGBColor,
    column: fn(&CellResults) -> &[f64],
    /// Whether all settings have it in the same unit, and so the same axis.
    is_shared: bool,
}

fn quantities(measure: &Measure) -> Vec<Quantity> {
    let reward = Quantity {
        label: "R".into(),
        unit: "reward".into(),
        color: GREEN,
        column: |cell| &cell.reward,
        is_shared: false,
    };
    let information = measure.information.as_ref().map(|it| Quantity {
        label: it.symbol.clone(),
        unit: it.axis_unit(),
        color: VERMILLION,
        column: |cell| &cell.intrinsic_nats,
        is_shared: true,
    });
    let performance = Quantity {
        label: measure.symbol.clone(),
        unit: measure.axis_unit(),
        color: BLUE,
        column: |cell| &cell.performance,
        is_shared: true,
    };
    [Some(reward), information, Some(performance)].into_iter().flatten().collect()
}

/// Columns in bands, one below another.
struct Grid {
    /// Of a band: one for each quantity.
    n_rows: usize,
    n_columns: usize,
    frame_width: f64,
    title_lines: usize,
}

fn draw(run: &Results, _: &Options) -> Result<Drawing, Error> {
    let most_points = POINTS.min(ALL_POINTS / run.settings.len()).max(30);
    let w = run.updates(|longest| window_for(longest, most_points));
    let quantities = quantities(&run.measure);
    let curves: Vec<Vec<_>> = quantities
        .iter()
        .map(|quantity| {
            let of_setting = |setting: &Setting| {
                let columns = setting.cells.iter().map(quantity.column);
                let curves: Vec<_> = columns.map(|it| smoothed(setting, it, w)).collect();
                spreads(&curves, QUARTILES)
            };
            run.settings.iter().map(of_setting).collect()
        })
        .collect();
    let grid = Grid::of(run, quantities.len());
    let notes = run.with_caveats(vec![note(w)]);
    let n_bands = run.settings.len().div_ceil(grid.n_columns) as f64;
    let height = n_bands * grid.band() + 26.0 + notes_height(&notes) + 18.0;
    let caption = FIGURE.caption_with(run, &notes);
    paint(&FIGURE, height, caption, |area| {
        for (quantity, (row, curves)) in quantities.iter().zip(curves.iter().enumerate()) {
            draw_row(area, run, &grid, (row, quantity), curves)?;
        }
        let y = n_bands * grid.band() + 12.0;
        draw_legend(area, y)?;
        write_notes(area, y + 24.0, &notes)
    })
}

fn note(w: usize) -> String {
    let smoothing = match w {
        1 => "Nothing is smoothed: each point is an update.".to_owned(),
        _ => format!("Each cell is smoothed first: a point is its mean over {w} updates."),
    };
    format!(
        "{smoothing} At each point the cells count that have come so far. R has an axis of its \
         own for each setting, which rewards something else."
    )
}

impl Grid {
    fn of(run: &Results, n_rows: usize) -> Self {
        let n = run.settings.len();
        let n_columns = n.div_ceil(n.div_ceil(COLUMNS));
        let available = PAGE - MARGIN - 12.0;
        let frame_width = available / n_columns as f64 - LEFT - 4.0;
        let lines =
            |setting: &Setting| setting_lines(&setting.name, NORMAL, frame_width + 40.0).len();
        let title_lines = run.settings.iter().map(lines).max().unwrap_or(1);
        Self { n_rows, n_columns, frame_width, title_lines }
    }

    fn title(&self) -> f64 {
        self.title_lines as f64 * TITLE_LINE + 22.0
    }

    fn band(&self) -> f64 {
        self.title() + self.n_rows as f64 * (ROW + GAP) - GAP + BELOW + 34.0
    }

    fn frame(&self, setting: usize, row: usize) -> Rect {
        let (band, column) = (setting / self.n_columns, setting % self.n_columns);
        Rect {
            x: MARGIN + LEFT + column as f64 * (self.frame_width + LEFT + 4.0),
            y: band as f64 * self.band() + self.title() + row as f64 * (ROW + GAP),
            width: self.frame_width,
            height: ROW,
        }
    }
}

fn draw_row(
    area: &Area<'_>,
    run: &Results,
    grid: &Grid,
    (row, quantity): (usize, &Quantity),
    curves: &[Vec<Spread>],
) -> Result<(), Error> {
    let values = |spread: &Spread| {
        let [low, median, high] = spread.quantiles;
        [low, median, high, spread.mean]
    };
    let shared = Axis::around(curves.iter().flatten().flat_map(values), 6);
    let x = Axis::updates(run.longest(), grid.frame_width);
    for (i, (setting, curve)) in run.settings.iter().zip(curves).enumerate() {
        let frame = grid.frame(i, row);
        let is_first = i % grid.n_columns == 0;
        let own = Axis::around(curve.iter().flat_map(values), 6);
        let y = if quantity.is_shared { &shared } else { &own };
        let is_last = row + 1 == grid.n_rows;
        let y_numbers = is_first || !quantity.is_shared;
        let panel = Panel { frame, x: &x, y, x_numbers: is_last, y_numbers };
        panel.draw(area, |chart| draw_spreads(chart, curve, quantity.color))?;
        if is_first {
            write_y_label(area, frame, &quantity.label, &quantity.unit)?;
        }
        let n = format!("n = {}", setting.cells.len());
        let at = (frame.right(), frame.y - 10.0);
        write(area, &n, at, &font(SMALL, INK, HPos::Right))?;
        if row == 0 {
            draw_title(area, grid, &setting.name, frame)?;
        }
        if is_last {
            let at = (frame.x + frame.width / 2.0, frame.bottom() + BELOW + 12.0);
            write(area, x.updates_label(), at, &font(SMALL, INK, HPos::Center))?;
        }
    }
    Ok(())
}

fn draw_title(area: &Area<'_>, grid: &Grid, name: &str, frame: Rect) -> Result<(), Error> {
    let lines = setting_lines(name, NORMAL, grid.frame_width + 40.0);
    for (i, text) in lines.iter().rev().enumerate() {
        let at = (frame.x + frame.width / 2.0, frame.y - 28.0 - i as f64 * TITLE_LINE);
        write(area, text, at, &font(NORMAL, INK, HPos::Center))?;
    }
    Ok(())
}

fn draw_spreads(chart: &mut Chart<'_, '_>, curve: &[Spread], color: RGBColor) -> Result<(), Error> {
    let quartile = |i: usize| curve.iter().map(move |it| (it.update, it.quantiles[i]));
    let around: Vec<_> = quartile(0).chain(quartile(2).rev()).collect();
    chart.draw_series([Polygon::new(around, color.mix(0.22))])?;
    for i in 0..3 {
        let points: Vec<_> = quartile(i).collect();
        chart.draw_series([PathElement::new(points, stroke(INK.mix(0.75), 0.8))])?;
    }
    let mean: Vec<_> = curve.iter().map(|it| (it.update, it.mean)).collect();
    chart.draw_series([PathElement::new(mean, stroke(color, 2.5))])?;
    Ok(())
}

/// What the lines are, in the colours of the last row.
fn draw_legend(area: &Area<'_>, y: f64) -> Result<(), Error> {
    let mut x = 10.0;
    let [mean, middle, thin] =
        ["mean", "middle half of the cells", "first quartile, median, third quartile"];
    for (text, style) in
        [(mean, Some(stroke(BLUE, 2.5))), (middle, None), (thin, Some(stroke(INK.mix(0.75), 0.8)))]
    {
        match style {
            Some(style) => line(area, &[(x, y), (x + 30.0, y)], style)?,
            None => {
                let [top, bottom] = [y - 6.0, y + 6.0];
                let corners = [(x, top), (x + 30.0, top), (x + 30.0, bottom), (x, bottom)];
                fill(area, &corners, BLUE.mix(0.22))?;
            }
        }
        write(area, text, (x + 36.0, y), &font(SMALL, INK, HPos::Left))?;
        x += 36.0 + room(text, SMALL) + 20.0;
    }
    Ok(())
}
