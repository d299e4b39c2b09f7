//! Final (not in the paper): what each cell reached, each setting's interquartile mean, and how
//! probably one setting is better than another.

use plotters::{
    element::Circle,
    style::{Color, RGBColor, text_anchor::HPos},
};

use super::{
    Drawing, Error, Figure, Measure, Options, Results, Setting,
    axis::{Axis, LEFT, Panel},
    canvas::{
        Area, BLUE, FAINT, INK, NORMAL, PAGE, Rect, SMALL, VERMILLION, fill, font, grid, line,
        notes_height, paint, setting_line, setting_lines, stroke, wrap, write, write_notes,
        write_y_label,
    },
    numbers::capitalised,
    tables::{self, Estimate, caveats, improvement_of, iqm, share},
};

pub(super) const FIGURE: Figure = Figure {
    name: "final",
    title: |_| "What was reached".into(),
    caption: |Measure { symbol, .. }| {
        format!(
            "Mean {symbol} of the last window: a dot for each cell, hollow if others have more \
             updates; for each setting the interquartile mean with its 95 % interval by stratified \
             bootstrap, and the probability that a cell of one setting has a higher {symbol} \
             than one of another (Agarwal et al. 2021)."
        )
    },
    draw,
    tables: |run| vec![tables::cells(run), tables::settings(run), tables::improvements(run)],
};

const MARGIN: f64 = 56.0;
const TOP: f64 = 26.0;
const FRAME_HEIGHT: f64 = 300.0;
const LINE: f64 = 17.0;
/// Settings with which the matrix has its place beside the dots.
const BESIDE: usize = 5;
/// Lines that a setting's name may have above a column, before letters stand for settings.
const LINES: usize = 3;
/// Of a square; in smaller ones colours have to do, and the table has the numbers.
const SMALLEST_WITH_NUMBERS: f64 = 36.0;
/// A square has room for a second line if it's larger.
const WITH_INTERVALS: f64 = 52.0;
const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZ";

/// Where things are.
struct Frames {
    dots: Rect,
    /// Of the matrix's squares; none with one setting.
    matrix: Option<Rect>,
    square: f64,
    /// Room for names beside the matrix.
    names: f64,
    /// What stands for each setting where there's little room.
    labels: Labels,
    bottom: f64,
}

/// Lines of text for each setting.
struct Labels {
    below_dots: Vec<Vec<String>>,
    above_matrix: Vec<Vec<String>>,
    beside_matrix: Vec<Vec<String>>,
}

fn draw(run: &Results, _: &Options) -> Result<Drawing, Error> {
    let layout = Frames::of(run);
    let notes = [vec![note(run)], caveats(run)].concat();
    let caption = FIGURE.caption_with(run, &notes);
    paint(&FIGURE, layout.bottom + notes_height(&notes) + 6.0, caption, |area| {
        draw_dots(area, run, &layout)?;
        if let Some(matrix) = layout.matrix {
            draw_matrix(area, run, matrix, &layout)?;
        }
        write_notes(area, layout.bottom, &notes)
    })
}

impl Frames {
    fn of(run: &Results) -> Self {
        let n = run.settings.len();
        let beside = Self::with(run, n <= BESIDE, false);
        let fits = |lines: &Vec<String>| lines.len() <= LINES;
        let labels = &beside.labels;
        match labels.below_dots.iter().chain(&labels.above_matrix).all(fits) || n == 1 {
            true => beside,
            false => Self::with(run, false, true),
        }
    }

    fn with(run: &Results, is_beside: bool, has_letters: bool) -> Self {
        let n = run.settings.len();
        let available = PAGE - MARGIN - LEFT - 14.0;
        let slot = if is_beside { (430.0 / n as f64).min(130.0) } else { available / n as f64 };
        let dots = Rect { x: MARGIN + LEFT, y: TOP, width: n as f64 * slot, height: FRAME_HEIGHT };
        let left = if is_beside { dots.right() + 16.0 } else { 10.0 };
        let names = if has_letters { 300.0 } else { 120.0 };
        let square = ((PAGE - 10.0 - left - names) / n as f64).min(80.0);
        let labels = Labels::of(run, [slot, square, names], has_letters);
        let most = |of: &[Vec<String>]| of.iter().map(Vec::len).max().unwrap_or(1) as f64 * LINE;
        let below_dots =
            dots.bottom() + most(&labels.below_dots) + FACTS.len() as f64 * LINE + 30.0;
        let above = most(&labels.above_matrix) + 10.0;
        let matrix = (n > 1).then_some(Rect {
            x: left + names,
            y: if is_beside { TOP + 36.0 + above } else { below_dots + 36.0 + above },
            width: n as f64 * square,
            height: n as f64 * square,
        });
        let bottom = below_dots.max(matrix.map_or(0.0, |it| it.bottom() + 24.0));
        Self { dots, matrix, square, names, labels, bottom }
    }
}

impl Labels {
    fn of(run: &Results, [slot, square, names]: [f64; 3], has_letters: bool) -> Self {
        let lines = |most: f64| -> Vec<Vec<String>> {
            run.settings.iter().map(|it| setting_lines(&it.name, SMALL, most)).collect()
        };
        if !has_letters {
            return Self {
                below_dots: lines(slot - 4.0),
                above_matrix: lines(square - 2.0),
                beside_matrix: lines(names - 14.0),
            };
        }
        let letters: Vec<_> = (0..run.settings.len()).map(letter).collect();
        let named = run.settings.iter().zip(&letters).map(|(setting, letter)| {
            wrap(&format!("{} ({letter})", setting_line(&setting.name)), SMALL, names - 14.0)
        });
        let alone: Vec<_> = letters.iter().map(|letter| vec![letter.clone()]).collect();
        Self { beside_matrix: named.collect(), below_dots: alone.clone(), above_matrix: alone }
    }
}

/// A, B, ... Z, A1, B1, ...
fn letter(i: usize) -> String {
    let letter = char::from(LETTERS[i % LETTERS.len()]);
    match i / LETTERS.len() {
        0 => letter.to_string(),
        round => format!("{letter}{round}"),
    }
}

fn note(run: &Results) -> String {
    format!(
        "{} is the mean over a cell's last {} updates. Bar: interquartile mean with its \
         95 % interval (percentile bootstrap). No progress: the gain over the first {} updates is \
         less than a tenth of the run's largest, or not significant (Welch's t-test, 5 %). \
         Collapsed: the best window showed progress, and the last kept less than half of its gain.",
        capitalised(&run.measure.symbol),
        run.windows(),
        run.windows()
    )
}

fn draw_dots(area: &Area<'_>, run: &Results, layout: &Frames) -> Result<(), Error> {
    let frame = layout.dots;
    let n = run.settings.len();
    let iqms: Vec<_> = run.settings.iter().map(|it| iqm(&it.last())).collect();
    let ends = iqms.iter().filter_map(|iqm| iqm.interval).flat_map(|it| [it.low, it.high]);
    let values = iqms.iter().map(|iqm| iqm.value).chain(ends);
    let y = Axis::around(run.settings.iter().flat_map(Setting::last).chain(values), 8);
    // No numbers below: the settings' names are there.
    let x = Axis::bare(0.0..n as f64);
    let panel = Panel { frame, x: &x, y: &y, x_numbers: false, y_numbers: true };
    let slot = frame.width / n as f64;
    panel.draw(area, |chart| {
        for (i, setting) in run.settings.iter().enumerate() {
            let values = setting.last();
            let offsets = offsets(&values, &y, frame.height, 0.33 * slot);
            for ((cell, value), offset) in setting.cells.iter().zip(&values).zip(offsets) {
                let at = (i as f64 + 0.36 + offset / slot, *value);
                let style = match cell.outcome.is_behind {
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
    for (i, iqm) in iqms.iter().enumerate() {
        let middle = frame.x + (i as f64 + 0.5) * slot;
        let ends = iqm.interval.map(|it| [py(it.low), py(it.high)]);
        draw_iqm(area, middle + 0.33 * slot, py(iqm.value), ends)?;
    }
    draw_facts(area, run, frame, &layout.labels.below_dots)?;
    write_y_label(area, frame, &run.measure.symbol, &run.measure.axis_unit())
}

/// How far to move dots sideways so that they don't cover each other, in px; closer where there are
/// too many for `most` px at either side.
fn offsets(values: &[f64], y: &Axis, height: f64, most: f64) -> Vec<f64> {
    const APART: f64 = 7.0;
    let py = |value: f64| value / (y.range.end - y.range.start) * height;
    let mut placed: Vec<(f64, f64)> = Vec::new();
    for &value in values {
        // 0, 1, -1, 2, -2, ... half distances.
        let tries = (0..=4 * values.len()).map(|k| {
            let side = if k % 2 == 0 { -1.0 } else { 1.0 };
            side * k.div_ceil(2) as f64 * APART / 2.0
        });
        let is_free = |x: &f64| {
            let far = |(px, other): &(f64, f64)| (px - x).hypot(py(value) - py(*other)) >= APART;
            placed.iter().all(far)
        };
        let x = tries.into_iter().find(is_free).unwrap_or(0.0);
        placed.push((x, value));
    }
    let widest = placed.iter().map(|(x, _)| x.abs()).fold(0.0, f64::max);
    let scale = if widest > most { most / widest } else { 1.0 };
    placed.into_iter().map(|(x, _)| scale * x).collect()
}

fn draw_iqm(area: &Area<'_>, x: f64, iqm: f64, ends: Option<[f64; 2]>) -> Result<(), Error> {
    let style = stroke(VERMILLION, 2.0);
    if let Some([low, high]) = ends {
        line(area, &[(x, low), (x, high)], style)?;
    }
    for end in ends.into_iter().flatten() {
        line(area, &[(x - 4.0, end), (x + 4.0, end)], style)?;
    }
    line(area, &[(x - 9.0, iqm), (x + 9.0, iqm)], stroke(VERMILLION, 3.5))
}

/// A number of a setting, below its name.
type Fact = (&'static str, fn(&Setting) -> String);

const FACTS: [Fact; 3] = [
    ("cells", |setting| setting.cells.len().to_string()),
    ("no progress %", |it| percent(share(it, |it| it.outcome.progressed.map(|it| !it)))),
    ("collapsed %", |it| percent(share(it, |it| it.outcome.collapsed))),
];

fn percent(share: f64) -> String {
    if share.is_nan() { "?".into() } else { format!("{:.0}", 100.0 * share) }
}

/// Names of settings with their facts, below the dots.
fn draw_facts(
    area: &Area<'_>,
    run: &Results,
    frame: Rect,
    names: &[Vec<String>],
) -> Result<(), Error> {
    let slot = frame.width / run.settings.len() as f64;
    let n_lines = names.iter().map(Vec::len).max().unwrap_or(1);
    let y = |line: usize| frame.bottom() + 16.0 + line as f64 * LINE;
    for (i, (setting, lines)) in run.settings.iter().zip(names).enumerate() {
        let middle = frame.x + (i as f64 + 0.5) * slot;
        let facts: Vec<_> = FACTS.iter().map(|(_, of)| of(setting)).collect();
        for (k, text) in lines.iter().enumerate() {
            write(area, text, (middle, y(k)), &font(SMALL, INK, HPos::Center))?;
        }
        for (k, text) in facts.iter().enumerate() {
            write(area, text, (middle, y(n_lines + k)), &font(SMALL, INK, HPos::Center))?;
        }
    }
    for (k, (what, _)) in FACTS.iter().enumerate() {
        write(area, what, (frame.x - 10.0, y(n_lines + k)), &font(SMALL, INK, HPos::Right))?;
    }
    Ok(())
}

fn draw_matrix(area: &Area<'_>, run: &Results, frame: Rect, layout: &Frames) -> Result<(), Error> {
    let Frames { square, labels, .. } = layout;
    let n_lines = labels.above_matrix.iter().map(Vec::len).max().unwrap_or(1) as f64;
    let left = frame.x - layout.names;
    let title = format!(
        "Probability that a cell of the row has a higher {} than one of the column",
        run.measure.symbol
    );
    let title = wrap(&title, NORMAL, PAGE - left - 10.0);
    for (i, text) in title.iter().rev().enumerate() {
        let y = frame.y - 24.0 - n_lines * LINE - i as f64 * 19.0;
        write(area, text, (left, y), &font(NORMAL, INK, HPos::Left))?;
    }
    let names = labels.beside_matrix.iter().zip(&labels.above_matrix);
    for (i, (name, lines)) in names.enumerate() {
        let y = frame.y + (i as f64 + 0.5) * square;
        for (k, text) in name.iter().enumerate() {
            let at = (frame.x - 8.0, y + (k as f64 - (name.len() as f64 - 1.0) / 2.0) * LINE);
            write(area, text, at, &font(SMALL, INK, HPos::Right))?;
        }
        let x = frame.x + (i as f64 + 0.5) * square;
        for (k, text) in lines.iter().rev().enumerate() {
            let at = (x, frame.y - 10.0 - k as f64 * LINE);
            write(area, text, at, &font(SMALL, INK, HPos::Center))?;
        }
        for j in 0..run.settings.len() {
            let corner = (frame.x + j as f64 * square, frame.y + i as f64 * square);
            match (i != j).then(|| improvement_of(&run.settings, i, j)) {
                Some(Some(value)) => draw_square(area, corner, *square, value)?,
                Some(None) => draw_empty(area, corner, *square, &["one", "cell"])?,
                None => draw_empty(area, corner, *square, &[])?,
            }
        }
    }
    Ok(())
}

/// A square of the matrix.
fn corners((x, y): (f64, f64), square: f64) -> [(f64, f64); 4] {
    let (right, bottom) = (x + square - 1.0, y + square - 1.0);
    [(x, y), (right, y), (right, bottom), (x, bottom)]
}

/// What has no number, and why, if there's room for it.
fn draw_empty(area: &Area<'_>, at: (f64, f64), square: f64, why: &[&str]) -> Result<(), Error> {
    fill(area, &corners(at, square), FAINT)?;
    let has_room = square > WITH_INTERVALS;
    for (k, text) in why.iter().enumerate().filter(|_| has_room) {
        let y = at.1 + square / 2.0 + (k as f64 - 0.5) * 14.0;
        write(area, text, (at.0 + square / 2.0, y), &font(12.0, INK, HPos::Center))?;
    }
    Ok(())
}

fn draw_square(area: &Area<'_>, at: (f64, f64), square: f64, value: Estimate) -> Result<(), Error> {
    let Estimate { value: probability, interval } = value;
    fill(area, &corners(at, square), shade(probability))?;
    if square < SMALLEST_WITH_NUMBERS {
        return Ok(());
    }
    let strength = (probability - 0.5).abs();
    let ink = if strength > 0.4 { RGBColor(255, 255, 255) } else { INK };
    let middle = (at.0 + square / 2.0, at.1 + square / 2.0);
    let interval = interval.filter(|_| square > WITH_INTERVALS);
    let up = if interval.is_some() { 7.0 } else { 0.0 };
    let text = format!("{probability:.2}");
    write(area, &text, (middle.0, middle.1 - up), &font(NORMAL, ink, HPos::Center))?;
    if let Some(interval) = interval {
        // Without its zeros it has a place in a square.
        let text = format!("{:.2}–{:.2}", interval.low, interval.high).replace("0.", ".");
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::run_of;

    #[test]
    fn dots_lie_beside_each_other() {
        let y = Axis::new(0.0..1.0, 2);
        let apart = offsets(&[0.5, 0.5, 0.5, 0.9], &y, 100.0, 50.0);
        assert_eq!(apart, [0.0, 7.0, -7.0, 0.0]);
        let many = offsets(&[0.5; 30], &y, 100.0, 20.0);
        assert!(many.iter().all(|x| x.abs() <= 20.0));
        assert!(many.contains(&20.0));
    }

    #[test]
    fn what_cannot_be_told_is_not_drawn() {
        let of = |n: usize| {
            let settings =
                ["a", "b"].map(|name| (name, (0..n).map(|i| vec![i as f64; 20]).collect()));
            draw(&run_of(&settings), &Options::default()).unwrap()
        };
        let (one, two, six) = (of(1), of(2), of(6));
        assert!(one.svg.contains("\ncell\n") && !one.svg.contains("\n0.50\n"));
        assert!(two.svg.contains("\n0.50\n") && !two.svg.contains('–'));
        assert!(six.svg.contains("\n0.50\n") && six.svg.contains('–'));
        assert!(one.caption.contains("One cell") && !two.caption.contains("One cell"));
        assert!(two.caption.contains("Fewer than 6 cells") && !six.caption.contains("Fewer"));
    }

    #[test]
    fn an_even_chance_is_white() {
        assert_eq!(shade(0.5), RGBColor(255, 255, 255));
        assert_eq!([shade(1.0), shade(0.0)], [BLUE, VERMILLION]);
    }
}
