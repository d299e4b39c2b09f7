//! Landscapes: how functions of a policy's parameters look on slices, side by side on one scale: each
//! from its lowest value on a slice, 0, to its highest, 1.

use plotters::{
    element::{PathElement, Polygon, Rectangle},
    style::{Color, text_anchor::HPos},
};

use super::{
    Drawing, Error,
    axis::{Axis, BELOW, LEFT, Panel},
    canvas::{
        Area, BLUE, GREY, INK, NORMAL, PAGE, Rect, SMALL, font, notes_height, paint_as,
        setting_line, stroke, viridis, write, write_notes,
    },
};

/// A line through parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct LandscapeProfile {
    /// What is over its panels.
    pub title: String,
    /// Where the points are, `[n_points]`, increasing.
    pub t: Vec<f64>,
    /// Each function's means, `[n_functions][n_points]`.
    pub values: Vec<Vec<f64>>,
    /// Their standard errors; where they aren't known, NaN, and there's no shade.
    pub errors: Vec<Vec<f64>>,
}

/// A square of a plane through parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct LandscapeMap {
    /// What is over its panels.
    pub title: String,
    /// How far it reaches from the middle to each side.
    pub reach: f64,
    /// Each function's means, `[n_functions][n x n]`, row by row from below.
    pub values: Vec<Vec<f64>>,
}

const CURVES: &str = "landscape-curves";
const MAPS: &str = "landscape-maps";

/// Bands of height in a map.
const LEVELS: usize = 10;

/// Room for names, for a row's title, between panels for the numbers below them, and between rows.
const HEAD: f64 = 30.0;
const TITLE: f64 = 26.0;
const GAP: f64 = 30.0;
const BETWEEN_ROWS: f64 = 10.0;
const ROW: f64 = 92.0;

/// A row of panels for each slice, a panel for each of the functions by these names.
///
/// # Errors
/// [`Error::Drawing`]
pub fn landscape_curves(names: &[String], profiles: &[LandscapeProfile]) -> Result<Drawing, Error> {
    let notes = [
        "Along each line, from its lowest mean, 0, to its highest, 1; the shade is one standard error of \
         a mean to either side."
            .to_owned(),
    ];
    let layout = Rows { n: names.len(), row: ROW };
    layout.paint(
        (CURVES, names),
        &titles(profiles, |it| &it.title),
        &notes,
        |area, row, f, frame| {
            let LandscapeProfile { t, values, errors, .. } = &profiles[row];
            let scaled = scale(&values[f]);
            let error = scale_of(&values[f]).1;
            let x = Axis::new(t[0]..t[t.len() - 1], 3);
            let y = Axis::new(-0.1..1.1, 3);
            let panel = Panel { frame, x: &x, y: &y, x_numbers: true, y_numbers: f == 0 };
            panel.draw(area, |chart| {
                let at = |sign: f64| {
                    let points = t.iter().zip(&scaled).zip(&errors[f]);
                    let known = points.filter(|(_, e)| e.is_finite());
                    known.map(move |((t, value), e)| {
                        (*t, (value + sign * e * error).clamp(-0.1, 1.1))
                    })
                };
                let mut outline: Vec<_> = at(1.0).collect();
                outline.extend(at(-1.0).collect::<Vec<_>>().into_iter().rev());
                chart.draw_series([Polygon::new(outline, BLUE.mix(0.2))])?;
                let curve: Vec<_> = t.iter().copied().zip(scaled.iter().copied()).collect();
                chart.draw_series([PathElement::new(curve, stroke(BLUE, 1.4))])?;
                Ok(())
            })
        },
    )
}

/// A row of maps for each plane, a map for each of the functions by these names.
///
/// # Errors
/// [`Error::Drawing`]
pub fn landscape_maps(names: &[String], maps: &[LandscapeMap]) -> Result<Drawing, Error> {
    let notes = [format!(
        "From the lowest mean of a map, dark, to the highest, light, in {LEVELS} bands of equal height; \
         what blew up is grey."
    )];
    let width = Rows { n: names.len(), row: 0.0 }.width();
    let layout = Rows { n: names.len(), row: width };
    layout.paint((MAPS, names), &titles(maps, |it| &it.title), &notes, |area, row, f, frame| {
        let LandscapeMap { reach, values, .. } = &maps[row];
        let axis = Axis::new(-reach..*reach, 3);
        let panel = Panel { frame, x: &axis, y: &axis, x_numbers: true, y_numbers: f == 0 };
        panel.draw(area, |chart| {
            chart.draw_series(cells(&values[f], *reach))?;
            Ok(())
        })
    })
}

/// A map's rectangles: neighbours in a row that have the same band are one.
fn cells(values: &[f64], reach: f64) -> Vec<Rectangle<(f64, f64)>> {
    let n = values.len().isqrt();
    let side = 2.0 * reach / n as f64;
    let bands: Vec<Option<usize>> = scale(values).into_iter().map(band).collect();
    let mut cells = Vec::new();
    for (row, bands) in bands.chunks(n).enumerate() {
        let at = |i: usize| -reach + i as f64 * side;
        let mut start = 0;
        for run in bands.chunk_by(|a, b| a == b) {
            let corners = [(at(start), at(row)), (at(start + run.len()), at(row + 1))];
            let color = run[0].map_or(GREY, |band| viridis(band, LEVELS));
            cells.push(Rectangle::new(corners, color.filled()));
            start += run.len();
        }
    }
    cells
}

fn band(value: f64) -> Option<usize> {
    value.is_finite().then(|| ((value * LEVELS as f64) as usize).min(LEVELS - 1))
}

/// The lowest value, and what one unit above it is drawn as.
fn scale_of(values: &[f64]) -> (f64, f64) {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let factor = 1.0 / (high - low);
    // What doesn't vary lies at 0.
    (low, if factor.is_finite() { factor } else { 0.0 })
}

fn scale(values: &[f64]) -> Vec<f64> {
    let (low, factor) = scale_of(values);
    values.iter().map(|value| (value - low) * factor).collect()
}

fn titles<T>(slices: &[T], title: impl Fn(&T) -> &String) -> Vec<String> {
    // Names of cells are SETTING/seed=N.
    slices.iter().map(|slice| setting_line(&title(slice).replace('/', ","))).collect()
}

/// Rows of n panels each.
struct Rows {
    n: usize,
    row: f64,
}

impl Rows {
    fn width(&self) -> f64 {
        let n = self.n.max(1) as f64;
        ((PAGE - LEFT - 16.0 + GAP) / n - GAP).min(260.0)
    }

    fn band(&self) -> f64 {
        TITLE + self.row + BELOW + BETWEEN_ROWS
    }

    /// Draws names above, and for each row its title and each panel, given row and column.
    fn paint(
        &self,
        (file_stem, names): (&'static str, &[String]),
        titles: &[String],
        notes: &[String],
        draw: impl Fn(&Area<'_>, usize, usize, Rect) -> Result<(), Error>,
    ) -> Result<Drawing, Error> {
        let rows = titles.len() as f64 * self.band();
        let height = HEAD + rows + notes_height(notes) + 16.0;
        let caption = format!("Landscapes of {}. {}", names.join(", "), notes.join(" "));
        let left = |f: usize| LEFT + f as f64 * (self.width() + GAP);
        paint_as(file_stem, height, caption, |area| {
            for (f, name) in names.iter().enumerate() {
                let middle = (left(f) + self.width() / 2.0, 14.0);
                write(area, &setting_line(name), middle, &font(NORMAL, INK, HPos::Center))?;
            }
            for (row, title) in titles.iter().enumerate() {
                let top = HEAD + row as f64 * self.band();
                write(area, title, (LEFT, top + 8.0), &font(SMALL, INK, HPos::Left))?;
                for f in 0..names.len() {
                    let (width, height) = (self.width(), self.row);
                    let frame = Rect { x: left(f), y: top + TITLE, width, height };
                    draw(area, row, f, frame)?;
                }
            }
            write_notes(area, HEAD + rows + 10.0, notes)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(n: usize) -> Vec<String> {
        (0..n).map(|i| format!("xi=0.{i}")).collect()
    }

    fn is_drawing(drawing: &Drawing, most: usize) {
        let document = resvg::usvg::roxmltree::Document::parse(&drawing.svg).unwrap();
        assert_eq!(document.root_element().attribute("width"), Some("1000"));
        assert!(!drawing.svg.contains("NaN") && drawing.svg.len() < most, "{}", drawing.svg.len());
    }

    #[test]
    fn any_values_are_drawn() {
        for value in [0.0, 1e100, -1e-300, f64::NAN] {
            let values: Vec<f64> =
                (0..41).map(|i| if i == 7 { value } else { f64::from(i) }).collect();
            let profile = LandscapeProfile {
                title: "xi=1/seed=<5> direction 1".into(),
                t: (-20..=20).map(f64::from).collect(),
                errors: vec![vec![0.1; 41], vec![f64::NAN; 41], vec![value; 41]],
                values: vec![values.clone(), vec![value; 41], vec![0.0; 41]],
            };
            let drawn = landscape_curves(&names(3), &vec![profile.clone(); 2]).unwrap();
            is_drawing(&drawn, 60_000);
            let rough: Vec<f64> = (0..1681).map(|i| f64::from(i * i % 97)).collect();
            let values = vec![rough, vec![value; 1681], vec![0.0; 1681]];
            let map = LandscapeMap { title: "plane".into(), reach: 0.5, values };
            is_drawing(&landscape_maps(&names(3), &[map]).unwrap(), 400_000);
        }
    }

    #[test]
    fn scales_go_from_0_to_1() {
        assert_eq!(scale(&[2.0, 6.0, 4.0]), [0.0, 1.0, 0.5]);
        assert_eq!(scale(&[2.0, 2.0]), [0.0, 0.0]);
        assert_eq!([0.0, 0.05, 0.1, 0.99, 1.0].map(band), [0, 0, 1, 9, 9].map(Some));
        assert_eq!(band(f64::NAN), None);
        // Three of one band in a row are one rectangle, and the other rows' are theirs.
        assert_eq!(cells(&[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0], 1.0).len(), 5);
    }
}
