//! Final (not in the paper): what each instance reached, each setting's interquartile mean, and how
//! probably one setting is better than another.

use plotters::{
    element::Circle,
    style::{Color, RGBColor, text_anchor::HPos},
};

use super::{
    Drawing, Error, Figure, Options, Run, Setting,
    axis::{Axis, LEFT, Panel},
    canvas::{
        Area, BLUE, GREY, INK, NORMAL, PAGE, Rect, SMALL, VERMILLION, fill, font, grid, line,
        notes_height, paint, setting_lines, stroke, write, write_notes, write_upwards,
    },
    statistics::Interval,
    tables::{self, improvement_of, iqm, share},
};

pub(super) const FIGURE: Figure = Figure {
    name: "final",
    title: "What was reached",
    caption: "Mean R_Loc of the last window: a dot for each instance, hollow if others have more \
              updates; for each setting the interquartile mean with its 95 % interval by stratified \
              bootstrap, and the probability that an instance of one setting has a higher R_Loc \
              than one of another (Agarwal et al. 2021).",
    draw,
    tables: |run| vec![tables::instances(run), tables::settings(run), tables::improvement(run)],
};

const MARGIN: f64 = 36.0;
const TOP: f64 = 26.0;
const FRAME_HEIGHT: f64 = 300.0;
const LINE: f64 = 17.0;
/// A cell of the matrix.
const MOST_CELL: f64 = 64.0;

fn draw(run: &Run, _: &Options) -> Result<Drawing, Error> {
    let n = run.settings.len() as f64;
    let width = (PAGE - MARGIN - LEFT - 14.0).min(n * 150.0);
    let slot = width / n;
    let dots = Rect { x: MARGIN + LEFT, y: TOP, width, height: FRAME_HEIGHT };
    let most_lines = |most: f64| {
        let lines = |setting: &Setting| setting_lines(&setting.name, SMALL, most).len();
        run.settings.iter().map(lines).max().unwrap_or(1) as f64
    };
    let below_dots = (most_lines(slot - 6.0) + 3.0) * LINE + 14.0;
    let cell = ((PAGE - 190.0) / n).min(MOST_CELL);
    let has_matrix = run.settings.len() > 1;
    let matrix_top = dots.bottom() + below_dots + 44.0 + most_lines(cell - 4.0) * LINE;
    let matrix = Rect { x: 180.0, y: matrix_top, width: n * cell, height: n * cell };
    let bottom =
        if has_matrix { matrix.bottom() + 22.0 } else { dots.bottom() + below_dots + 10.0 };
    let notes = [note(run)];
    let caption = format!("{} {}", FIGURE.caption, notes.join(" "));
    paint(&FIGURE, bottom + notes_height(&notes) + 6.0, caption, |area| {
        draw_dots(area, run, dots)?;
        if has_matrix {
            let title = "Probability that an instance of the row has a higher R_Loc than one of \
                         the column";
            let at = (10.0, dots.bottom() + below_dots + 14.0);
            write(area, title, at, &font(NORMAL, INK, HPos::Left))?;
            draw_matrix(area, run, matrix, cell)?;
        }
        write_notes(area, bottom, &notes)
    })
}

fn note(run: &Run) -> String {
    format!(
        "R_Loc is the mean over an instance's last {} updates. Bar: interquartile mean with its \
         95 % interval (percentile bootstrap over the setting's instances). No progress: the last \
         window gained less than a tenth of the run's largest gain, or not significantly (Welch's \
         t-test, 5 %). Collapsed: less than half of the gain of the best window was left.",
        run.window
    )
}

fn draw_dots(area: &Area<'_>, run: &Run, frame: Rect) -> Result<(), Error> {
    let n = run.settings.len();
    let iqms: Vec<_> = run.settings.iter().map(iqm).collect();
    let ends = iqms.iter().flat_map(|(iqm, interval)| [*iqm, interval.low, interval.high]);
    let y = Axis::around(run.settings.iter().flat_map(Setting::last).chain(ends), 8);
    // No numbers below: the settings' names are there.
    let x = Axis::new(0.0..n as f64, 1);
    let panel = Panel { frame, x: &x, y: &y, x_numbers: false, y_numbers: true };
    let slot = frame.width / n as f64;
    panel.draw(area, |chart| {
        for (i, setting) in run.settings.iter().enumerate() {
            let values = setting.last();
            let offsets = offsets(&values, &y, frame.height);
            for ((instance, value), offset) in setting.instances.iter().zip(&values).zip(offsets) {
                let px = (offset - 0.14 * slot).clamp(-0.46 * slot, 0.3 * slot);
                let at = (i as f64 + 0.5 + px / slot, *value);
                let style = match instance.outcome.is_behind {
                    true => stroke(BLUE.mix(0.8), 1.2),
                    false => BLUE.mix(0.55).filled(),
                };
                chart.draw_series([Circle::new(at, grid(3.6), style)])?;
            }
        }
        Ok(())
    })?;
    let py = |value: f64| {
        let part = (value - y.range.start) / (y.range.end - y.range.start);
        frame.bottom() - part * frame.height
    };
    for (i, (setting, (iqm, interval))) in run.settings.iter().zip(&iqms).enumerate() {
        let middle = frame.x + (i as f64 + 0.5) * slot;
        draw_interval(area, middle + 0.3 * slot, py(*iqm), [py(interval.low), py(interval.high)])?;
        draw_names(area, setting, middle, frame.bottom() + 16.0, slot)?;
    }
    write_upwards(area, "R_Loc", (10.0, frame.y + frame.height / 2.0), NORMAL)?;
    write_upwards(area, "m per control step", (28.0, frame.y + frame.height / 2.0), SMALL)
}

/// How far to move dots sideways so that they don't cover each other, in px.
fn offsets(values: &[f64], y: &Axis, height: f64) -> Vec<f64> {
    let apart = 7.0;
    let py = |value: f64| value / (y.range.end - y.range.start) * height;
    let mut placed: Vec<(f64, f64)> = Vec::new();
    for &value in values {
        let tries = (0..).map(|k: i32| {
            let side = if k % 2 == 0 { 1.0 } else { -1.0 };
            side * f64::from((k + 1) / 2) * apart / 2.0
        });
        let is_free = |x: &f64| {
            placed.iter().all(|(px, other)| {
                let (dx, dy) = (px - x, py(value) - py(*other));
                dx * dx + dy * dy >= apart * apart
            })
        };
        let x = tries.take(4 * values.len() + 4).find(is_free).unwrap_or(0.0);
        placed.push((x, value));
    }
    placed.into_iter().map(|(x, _)| x).collect()
}

fn draw_interval(area: &Area<'_>, x: f64, iqm: f64, ends: [f64; 2]) -> Result<(), Error> {
    let style = stroke(VERMILLION, 2.0);
    line(area, &[(x, ends[0]), (x, ends[1])], style)?;
    for end in ends {
        line(area, &[(x - 4.0, end), (x + 4.0, end)], style)?;
    }
    line(area, &[(x - 9.0, iqm), (x + 9.0, iqm)], stroke(VERMILLION, 3.5))
}

fn draw_names(
    area: &Area<'_>,
    setting: &Setting,
    middle: f64,
    mut y: f64,
    slot: f64,
) -> Result<(), Error> {
    for text in setting_lines(&setting.name, SMALL, slot - 6.0) {
        write(area, &text, (middle, y), &font(SMALL, INK, HPos::Center))?;
        y += LINE;
    }
    let share = |what: &str, share: f64| match share.is_nan() {
        true => format!("{what} ?"),
        false => format!("{what} {:.0} %", 100.0 * share),
    };
    let stuck = self::share(setting, |it| it.outcome.progressed.map(|it| !it));
    let collapsed = self::share(setting, |it| it.outcome.collapsed);
    let facts = [
        format!("n = {}", setting.instances.len()),
        share(if slot < 110.0 { "stuck" } else { "no progress" }, stuck),
        share(if slot < 110.0 { "coll." } else { "collapsed" }, collapsed),
    ];
    for text in facts {
        write(area, &text, (middle, y), &font(SMALL, GREY, HPos::Center))?;
        y += LINE;
    }
    Ok(())
}

fn draw_matrix(area: &Area<'_>, run: &Run, frame: Rect, cell: f64) -> Result<(), Error> {
    for (i, row) in run.settings.iter().enumerate() {
        let y = frame.y + (i as f64 + 0.5) * cell;
        let lines = setting_lines(&row.name, SMALL, frame.x - 20.0);
        for (k, text) in lines.iter().enumerate() {
            let at = (frame.x - 8.0, y + (k as f64 - (lines.len() as f64 - 1.0) / 2.0) * LINE);
            write(area, text, at, &font(SMALL, INK, HPos::Right))?;
        }
        let x = frame.x + (i as f64 + 0.5) * cell;
        for (k, text) in setting_lines(&row.name, SMALL, cell - 4.0).iter().rev().enumerate() {
            let at = (x, frame.y - 10.0 - k as f64 * LINE);
            write(area, text, at, &font(SMALL, INK, HPos::Center))?;
        }
        for (j, column) in run.settings.iter().enumerate().filter(|(j, _)| *j != i) {
            let corner = (frame.x + j as f64 * cell, frame.y + i as f64 * cell);
            draw_cell(area, corner, cell, improvement_of(row, column))?;
        }
    }
    Ok(())
}

fn draw_cell(
    area: &Area<'_>,
    (x, y): (f64, f64),
    cell: f64,
    (probability, interval): (f64, Interval),
) -> Result<(), Error> {
    let (right, bottom) = (x + cell - 1.0, y + cell - 1.0);
    let corners = [(x, y), (right, y), (right, bottom), (x, bottom)];
    fill(area, &corners, shade(probability))?;
    let strength = (probability - 0.5).abs();
    let ink = if strength > 0.4 { RGBColor(255, 255, 255) } else { INK };
    let middle = (x + cell / 2.0, y + cell / 2.0);
    let has_room = cell > 56.0;
    let up = if has_room { 7.0 } else { 0.0 };
    let text = format!("{probability:.2}");
    write(area, &text, (middle.0, middle.1 - up), &font(NORMAL, ink, HPos::Center))?;
    if has_room {
        let text = format!("{:.2}–{:.2}", interval.low, interval.high);
        write(area, &text, (middle.0, middle.1 + 11.0), &font(12.0, ink, HPos::Center))?;
    }
    Ok(())
}

/// White at 1/2, blue above, vermillion below.
fn shade(probability: f64) -> RGBColor {
    let RGBColor(r, g, b) = if probability > 0.5 { BLUE } else { VERMILLION };
    let strength = (2.0 * (probability - 0.5).abs()).clamp(0.0, 1.0);
    let mix = |channel: u8| (255.0 - strength * (255.0 - f64::from(channel))).round() as u8;
    RGBColor(mix(r), mix(g), mix(b))
}
