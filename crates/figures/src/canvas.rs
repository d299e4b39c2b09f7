//! The page that figures are drawn on: SVG through `plotters`, and PNG from that SVG through
//! `resvg`, so that both are the same drawing.
//!
//! Positions and sizes are in px of a page that is 1000 px wide. `plotters` places things at whole
//! numbers, so it's given a grid that is finer than px. Text stays text; the font that it's measured
//! and rasterised with is part of the program, so that the bytes are the same on every machine.

use std::sync::{Arc, Once};

use plotters::backend::SVGBackend;
use plotters::{
    coord::Shift,
    drawing::{DrawingArea, IntoDrawingArea},
    element::{PathElement, Polygon, Text},
    style::{
        Color, FontFamily, FontStyle, FontTransform, IntoFont, RGBColor, ShapeStyle, TextStyle,
        register_font,
        text_anchor::{HPos, Pos, VPos},
    },
};
use resvg::{tiny_skia, usvg};

use scenes::FONT;

use super::{Drawing, Error, Figure};
use crate::plain;

/// Width of a figure.
pub(super) const PAGE: f64 = 1000.0;
/// Grid points of a px.
const GRID: f64 = 4.0;

/// Sizes of text.
pub(super) const SMALL: f64 = 13.0;
pub(super) const NORMAL: f64 = 15.0;
const INDEX: f64 = 11.0;

/// Metrics as Arial's and Helvetica's, which stand in for it where it isn't installed.
const FAMILY: &str = "Liberation Sans, Arial, Helvetica, sans-serif";

/// The font of all text, which plotters knows from the first time on.
fn family() -> FontFamily<'static> {
    static REGISTERED: Once = Once::new();
    // A font that can't be read is an error as soon as something is written in it.
    REGISTERED.call_once(|| drop(register_font(FAMILY, FontStyle::Normal, FONT)));
    FontFamily::Name(FAMILY)
}

/// `plotters` divides sizes of text by it.
const PLOTTERS_SIZE: f64 = 1.24;

/// The palette of Okabe and Ito (2008), told apart with any kind of colour vision.
pub(super) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(super) const VERMILLION: RGBColor = RGBColor(213, 94, 0);
pub(super) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(super) const PURPLE: RGBColor = RGBColor(204, 121, 167);
/// For what has an order: steps of the palette viridis, without its lightest.
pub(super) const VIRIDIS: [RGBColor; 6] = [
    RGBColor(68, 1, 84),
    RGBColor(65, 68, 135),
    RGBColor(42, 120, 142),
    RGBColor(34, 168, 132),
    RGBColor(122, 209, 81),
    RGBColor(210, 180, 20),
];

/// The colour of one of n things in their order.
pub(super) fn viridis(i: usize, n: usize) -> RGBColor {
    let place = (VIRIDIS.len() - 1) as f64 * i as f64 / (n - 1).max(1) as f64;
    let below = (place as usize).min(VIRIDIS.len() - 2);
    let [a, b] = [VIRIDIS[below], VIRIDIS[below + 1]];
    let part = place - below as f64;
    let mix = |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8;
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

/// Text and the axes.
pub(super) const INK: RGBColor = RGBColor(34, 34, 34);
/// What is there but not looked at.
pub(super) const GREY: RGBColor = RGBColor(140, 140, 140);
/// Lines of a grid.
pub(super) const FAINT: RGBColor = RGBColor(225, 225, 225);

/// Where figures draw.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A rectangle, from its upper left corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rect {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Rect {
    pub(super) fn right(self) -> f64 {
        self.x + self.width
    }

    pub(super) fn bottom(self) -> f64 {
        self.y + self.height
    }
}

/// The grid point of a length in px.
pub(super) fn grid(px: f64) -> i32 {
    (px * GRID).round() as i32
}

/// Draws a figure of this height, in px. Its SVG says what it is to whoever can't see it.
pub(super) fn paint(
    figure: &Figure,
    height: f64,
    caption: String,
    draw: impl FnOnce(&Area<'_>) -> Result<(), Error>,
) -> Result<Drawing, Error> {
    paint_as(figure.name, height, caption, draw)
}

/// The same for files of any name.
pub(super) fn paint_as(
    file_stem: &'static str,
    height: f64,
    caption: String,
    draw: impl FnOnce(&Area<'_>) -> Result<(), Error>,
) -> Result<Drawing, Error> {
    let size = [PAGE, height.round()];
    let [grid_width, grid_height] = size.map(|px| grid(px).unsigned_abs());
    let mut svg = String::new();
    {
        let backend = SVGBackend::with_string(&mut svg, (grid_width, grid_height));
        let area = backend.into_drawing_area();
        area.fill(&plotters::style::WHITE)?;
        draw(&area)?;
        area.present()?;
    }
    // Its own first tag has the grid's size as the figure's.
    let (_, content) =
        svg.split_once('>').ok_or_else(|| Error::Drawing("plotters began no SVG".into()))?;
    let [width, height] = size.map(|px| px as u32);
    let label = escaped(&caption);
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {grid_width} {grid_height}\" role=\"img\" aria-label=\"{label}\">{content}"
    );
    Ok(Drawing { file_stem, svg, width, height, caption, picture: None })
}

/// For an attribute's value.
pub(super) fn escaped(text: &str) -> String {
    let text = plain(text).replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}

/// The bytes of a PNG file of an SVG that [`paint`] made, with `scale` pixels a px.
pub(super) fn png(svg: &str, scale: f32) -> Result<Vec<u8>, Error> {
    let failed = |error: &dyn std::fmt::Display| Error::Drawing(error.to_string());
    let mut options = usvg::Options::default();
    Arc::make_mut(&mut options.fontdb).load_font_data(FONT.to_vec());
    let tree = usvg::Tree::from_str(svg, &options).map_err(|error| failed(&error))?;
    let [width, height] =
        [tree.size().width(), tree.size().height()].map(|px| (px * scale).round() as u32);
    let mut pixels = tiny_skia::Pixmap::new(width, height)
        .ok_or_else(|| Error::Drawing(format!("no memory for {width} x {height} pixels")))?;
    let transform = tiny_skia::Transform::from_scale(scale, scale);
    resvg::render(&tree, transform, &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| failed(&error))
}

/// A line's style.
pub(super) fn stroke(color: impl Color, width: f64) -> ShapeStyle {
    color.stroke_width(grid(width).unsigned_abs())
}

/// Text of a size, with its middle or the middle of an end at the point where it's drawn.
pub(super) fn font(size: f64, color: RGBColor, h_pos: HPos) -> TextStyle<'static> {
    let font = (family(), size * GRID * PLOTTERS_SIZE).into_font();
    font.color(&color).pos(Pos::new(h_pos, VPos::Center))
}

/// Writes a line of text: its middle, or the middle of an end, is at (x, y).
pub(super) fn write(
    area: &Area<'_>,
    text: &str,
    (x, y): (f64, f64),
    style: &TextStyle<'_>,
) -> Result<(), Error> {
    area.draw(&Text::new(plain(text), (grid(x), grid(y)), style))?;
    Ok(())
}

/// Names the y axis of a frame, from bottom to top: `R_Loc` with what follows the `_` as an index,
/// and the unit beside it.
pub(super) fn write_y_label(
    area: &Area<'_>,
    frame: Rect,
    symbol: &str,
    unit: &str,
) -> Result<(), Error> {
    let upwards = |size, h_pos| font(size, INK, h_pos).transform(FontTransform::Rotate270);
    let middle = frame.y + frame.height / 2.0;
    let (base, index) = symbol.split_once('_').unwrap_or((symbol, ""));
    let sizes = [width(base, NORMAL), width(index, INDEX)];
    let begin = middle + (sizes[0] + sizes[1]) / 2.0;
    write(area, base, (11.0, begin), &upwards(NORMAL, HPos::Left))?;
    write(area, index, (15.0, begin - sizes[0]), &upwards(INDEX, HPos::Left))?;
    write(area, unit, (30.0, middle), &upwards(SMALL, HPos::Center))
}

/// A line through points in px.
pub(super) fn line(area: &Area<'_>, points: &[(f64, f64)], style: ShapeStyle) -> Result<(), Error> {
    let points: Vec<_> = points.iter().map(|&(x, y)| (grid(x), grid(y))).collect();
    area.draw(&PathElement::new(points, style))?;
    Ok(())
}

/// A filled area between points in px.
pub(super) fn fill(
    area: &Area<'_>,
    points: &[(f64, f64)],
    style: impl Into<ShapeStyle>,
) -> Result<(), Error> {
    let points: Vec<_> = points.iter().map(|&(x, y)| (grid(x), grid(y))).collect();
    area.draw(&Polygon::new(points, style))?;
    Ok(())
}

/// The width that text needs, in px, whatever stands in for the font: where neither Arial nor
/// Helvetica is installed that's often DejaVu Sans, which is 1.17 times as wide.
pub(super) fn room(text: &str, size: f64) -> f64 {
    1.17 * width(text, size)
}

/// How wide a text is in the font, in px.
fn width(text: &str, size: f64) -> f64 {
    // Where it measures, plotters takes the size for the height of a line, which is 1.12 em.
    let font = (family(), size * GRID * 1.12).into_font();
    font.box_size(text).map_or(0.0, |(width, _)| f64::from(width) / GRID)
}

/// Lines that are at most so wide: broken at blanks, and a word that is too long anywhere.
pub(super) fn wrap(text: &str, size: f64, most: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_inclusive([' ', '-', '+']) {
        let fits = |line: &str| room(line.trim_end(), size) <= most;
        let mut line = lines.pop().unwrap_or_default();
        if !line.is_empty() && !fits(&format!("{line}{word}")) {
            lines.push(std::mem::take(&mut line));
        }
        for letter in word.chars() {
            if !line.is_empty() && !fits(&format!("{line}{letter}")) {
                lines.push(std::mem::take(&mut line));
            }
            line.push(letter);
        }
        lines.push(line);
    }
    lines.iter().map(|line| line.trim_end().to_owned()).collect()
}

/// Writes paragraphs of notes over the page's width, the first line's middle at `y`.
pub(super) fn write_notes(area: &Area<'_>, y: f64, notes: &[String]) -> Result<(), Error> {
    let style = font(SMALL, INK, HPos::Left);
    for (i, line) in note_lines(notes).iter().enumerate() {
        write(area, line, (NOTE_MARGIN, y + i as f64 * NOTE_LINE), &style)?;
    }
    Ok(())
}

const NOTE_MARGIN: f64 = 10.0;
const NOTE_LINE: f64 = 18.0;

fn note_lines(notes: &[String]) -> Vec<String> {
    notes.iter().flat_map(|note| wrap(note, SMALL, PAGE - 2.0 * NOTE_MARGIN)).collect()
}

/// The height of these notes.
pub(super) fn notes_height(notes: &[String]) -> f64 {
    note_lines(notes).len() as f64 * NOTE_LINE
}

/// A setting's name for people, `xi=0.75,power=2` as lines `ξ = 0.75` and `power = 2`.
pub(super) fn setting_lines(name: &str, size: f64, most: f64) -> Vec<String> {
    name.split(',').flat_map(|part| wrap(&setting_part(part), size, most)).collect()
}

/// The same in one line.
pub(super) fn setting_line(name: &str) -> String {
    name.split(',').map(setting_part).collect::<Vec<_>>().join(", ")
}

fn setting_part(part: &str) -> String {
    match part.split_once('=') {
        Some(("xi", value)) => format!("ξ = {value}"),
        Some((key, value)) => format!("{key} = {value}"),
        None => part.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FIGURES;

    fn page(text: &str) -> String {
        let style = font(NORMAL, INK, HPos::Center);
        paint(&FIGURES[0], 100.0, text.into(), |area| write(area, text, (500.0, 50.0), &style))
            .unwrap()
            .svg
    }

    #[test]
    fn text_from_files_is_escaped() {
        let text = "<script>&\"'";
        let svg = page(text);
        let document = usvg::roxmltree::Document::parse(&svg).unwrap();
        let root = document.root_element();
        assert_eq!(root.attribute("aria-label"), Some(text));
        let written = root.descendants().find(|node| node.has_tag_name("text")).unwrap();
        assert_eq!(written.text().map(str::trim), Some(text));
        // XML has no control characters, however they are written.
        assert!(usvg::roxmltree::Document::parse(&page("a\u{1b}[31m\u{1}")).is_ok());
    }

    /// Each letter that figures use leaves a mark: the font has it.
    #[test]
    fn the_font_has_the_letters() {
        let marks = |text: &str| {
            let png = png(&page(text), 1.0).unwrap();
            let pixels = tiny_skia::Pixmap::decode_png(&png).unwrap();
            assert_eq!((pixels.width(), pixels.height()), (1000, 100));
            pixels.data().to_vec()
        };
        let missing = marks("\u{e000}");
        for letter in ["ξ", "−", "×", "·", "≥"] {
            assert_ne!(marks(letter), missing, "{letter}");
        }
    }

    #[test]
    fn colours_lie_between_those_of_the_palette() {
        assert_eq!(
            [viridis(0, 1), viridis(0, 6), viridis(5, 6)],
            [VIRIDIS[0], VIRIDIS[0], VIRIDIS[5]]
        );
        // Half way from (68, 1, 84) to (65, 68, 135).
        assert_eq!(viridis(1, 11), RGBColor(67, 35, 110));
    }

    #[test]
    fn lines_are_broken_where_they_are_too_long() {
        let long = "codec = sensor_bits-2-actuator_bits-2";
        assert_eq!(wrap("xi = 1", SMALL, 200.0), ["xi = 1"]);
        let lines = wrap(long, SMALL, 120.0);
        assert!(lines.len() > 1 && lines.iter().all(|line| room(line, SMALL) <= 120.0));
        assert_eq!(lines.concat().replace(' ', ""), long.replace(' ', ""));
        // A letter a line at the least, whatever the width.
        assert_eq!(wrap("abc", SMALL, 0.0), ["a", "b", "c"]);
        assert_eq!(setting_lines("xi=0.75,power=2", SMALL, 200.0), ["ξ = 0.75", "power = 2"]);
        assert_eq!(setting_line("xi=0.75,power=2"), "ξ = 0.75, power = 2");
    }
}
