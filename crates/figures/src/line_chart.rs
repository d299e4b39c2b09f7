//! A chart as wide as the page: a line for each setting with a band around it, a legend and notes below.

use plotters::{
    element::{PathElement, Polygon},
    style::{Color, RGBColor, text_anchor::HPos},
};

use super::{
    Drawing, Error, Figure, Results,
    axis::{Axis, BELOW, Chart, LEFT, Panel},
    canvas::{
        INK, PAGE, Rect, SMALL, font, notes_height, paint, stroke, viridis, write, write_notes,
        write_y_label,
    },
    legend::Legend,
    statistics::Interval,
};

const MARGIN: f64 = 44.0;

/// Of the chart without what is beside it.
pub(super) const WIDTH: f64 = PAGE - MARGIN - LEFT - 16.0;

/// What is drawn, but for the lines.
pub(super) struct LineChart<'a> {
    pub(super) figure: &'a Figure,
    /// Its settings are the lines.
    pub(super) run: &'a Results,
    /// From the page's upper edge to the chart's, and from there to its lower one.
    pub(super) top: f64,
    pub(super) height: f64,
    pub(super) x: Axis,
    pub(super) x_label: String,
    pub(super) y: Axis,
    /// What is on the axis, and its unit.
    pub(super) y_label: [&'a str; 2],
    pub(super) notes: Vec<String>,
}

/// A setting's line.
pub(super) struct Line {
    pub(super) points: Vec<(f64, f64)>,
    /// At places along x.
    pub(super) band: Vec<(f64, Interval)>,
}

impl LineChart<'_> {
    /// Draws the lines of the settings, in their order.
    pub(super) fn draw(self, lines: &[Line]) -> Result<Drawing, Error> {
        let Self { figure, run, top, height, x, x_label, y, y_label, notes } = self;
        let legend = Legend::of(&run.settings);
        let frame = Rect { x: MARGIN + LEFT, y: top, width: WIDTH, height };
        let bottom = frame.bottom() + BELOW + 40.0;
        let height = bottom + legend.height() + notes_height(&notes) + 12.0;
        paint(figure, height, figure.caption_with(run, &notes), |area| {
            let panel = Panel { frame, x: &x, y: &y, x_numbers: true, y_numbers: true };
            panel.draw(area, |chart| {
                for (i, line) in lines.iter().enumerate() {
                    line.draw(chart, viridis(i, lines.len()))?;
                }
                Ok(())
            })?;
            let [what, unit] = y_label;
            write_y_label(area, frame, what, unit)?;
            let at = (frame.x + frame.width / 2.0, frame.bottom() + BELOW + 10.0);
            write(area, &x_label, at, &font(SMALL, INK, HPos::Center))?;
            legend.draw(area, bottom)?;
            write_notes(area, bottom + legend.height() + 6.0, &notes)
        })
    }
}

impl Line {
    fn draw(&self, chart: &mut Chart<'_, '_>, color: RGBColor) -> Result<(), Error> {
        let low = self.band.iter().map(|(x, it)| (*x, it.low));
        let high = self.band.iter().map(|(x, it)| (*x, it.high)).rev();
        let around: Vec<_> = low.chain(high).collect();
        if !around.is_empty() {
            chart.draw_series([Polygon::new(around, color.mix(0.15))])?;
        }
        chart.draw_series([PathElement::new(self.points.clone(), stroke(color, 2.2))])?;
        Ok(())
    }
}
