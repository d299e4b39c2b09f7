//! Axes: ranges that hold the data, numbers on ticks that can be read, and the frame around a panel.

use std::ops::Range;

use plotters::{
    backend::SVGBackend,
    chart::{ChartBuilder, ChartContext},
    coord::{
        cartesian::Cartesian2d,
        ranged1d::{BoldPoints, Ranged},
        types::RangedCoordf64,
    },
    style::text_anchor::HPos,
};

use super::{
    Error,
    canvas::{Area, FAINT, INK, Rect, SMALL, font, grid, line, stroke, write},
};

/// Room for the numbers beside and below a panel.
pub(super) const LEFT: f64 = 52.0;
pub(super) const BELOW: f64 = 22.0;

/// A panel in whose coordinates series are drawn.
pub(super) type Chart<'a, 'b> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// A linear axis.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) range: Range<f64>,
    n_ticks: usize,
    /// Numbers are written as multiples of ten to the power of this, a multiple of 3.
    exponent: i32,
    decimals: usize,
}

impl Axis {
    /// Holds all values with a little room beside them.
    pub(super) fn around(values: impl Iterator<Item = f64>, n_ticks: usize) -> Self {
        let finite = values.filter(|value| value.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
        // Equal values need an axis too, one with short numbers.
        let smallest = (low.abs().max(high.abs()) * 0.02).max(1e-12);
        let room = ((high - low) * 0.05).max(smallest);
        Self::new(low - room..high + room, n_ticks)
    }

    /// Has exactly this range.
    pub(super) fn new(range: Range<f64>, n_ticks: usize) -> Self {
        let n_ticks = n_ticks.max(2);
        let ticks = RangedCoordf64::from(range.clone()).key_points(BoldPoints(n_ticks));
        let largest = ticks.iter().map(|tick| tick.abs()).fold(0.0, f64::max);
        let power = if largest > 0.0 { largest.log10().floor() as i32 } else { 0 };
        // From 0.01 to 99,999 numbers are written as they are.
        let exponent = if (-2..5).contains(&power) { 0 } else { power.div_euclid(3) * 3 };
        let step = ticks.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        let step = if step.is_finite() { step } else { largest };
        let digits = -(step.log10() + 1e-9).floor() as i32 + exponent;
        let decimals = if step > 0.0 { digits.clamp(0, 9) as usize } else { 0 };
        Self { range, n_ticks, exponent, decimals }
    }

    /// Without ticks.
    pub(super) fn bare(range: Range<f64>) -> Self {
        Self { range, n_ticks: 0, exponent: 0, decimals: 0 }
    }

    /// From 0 to a number of updates, in thousands where they are many, on an axis of so many px.
    pub(super) fn updates(n: usize, width: f64) -> Self {
        let (exponent, px_of_a_number) = if n >= 10_000 { (3, 26.0) } else { (0, 52.0) };
        let n_ticks = (width / px_of_a_number) as usize;
        Self { exponent, decimals: 0, ..Self::new(0.0..n as f64, n_ticks) }
    }

    /// From 0 to a number of things that may be millions, on an axis of so many px.
    pub(super) fn counts(n: f64, width: f64) -> Self {
        let exponent = [6, 3].into_iter().find(|&it| n >= 10_f64.powi(it + 1)).unwrap_or(0);
        Self { exponent, decimals: 0, ..Self::new(0.0..n, (width / 52.0) as usize) }
    }

    /// What the numbers of [`Axis::updates`] are.
    pub(super) fn updates_label(&self) -> &'static str {
        if self.exponent == 0 { "updates" } else { "updates / 1000" }
    }

    /// What the numbers of [`Axis::counts`] are.
    pub(super) fn counts_label(&self, things: &str) -> String {
        match self.exponent {
            0 => things.into(),
            3 => format!("{things} / 1000"),
            _ => format!("{things} / 1,000,000"),
        }
    }

    /// The ticks with their numbers.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        let ticks = RangedCoordf64::from(self.range.clone()).key_points(BoldPoints(self.n_ticks));
        ticks.into_iter().map(|tick| (tick, self.tick(tick))).collect()
    }

    /// The number on a tick.
    fn tick(&self, value: f64) -> String {
        let value = value / 10_f64.powi(self.exponent);
        let text = format!("{value:.*}", self.decimals);
        let digits = text.trim_start_matches('-');
        // Rounding makes -0.0 of a tick at 0.
        let is_zero = digits.chars().all(|digit| "0.".contains(digit));
        let sign = if is_zero || !text.starts_with('-') { "" } else { "−" };
        format!("{sign}{digits}")
    }

    /// What the numbers are to be multiplied with, as in 1e−3; none if they are as they are.
    pub(super) fn multiplier(&self) -> Option<String> {
        let text = format!("1e{}", self.exponent).replace('-', "−");
        (self.exponent != 0).then_some(text)
    }
}

/// A frame with a grid and two axes.
pub(super) struct Panel<'a> {
    /// Within the frame.
    pub(super) frame: Rect,
    pub(super) x: &'a Axis,
    pub(super) y: &'a Axis,
    /// Whether there are numbers below and at the left.
    pub(super) x_numbers: bool,
    pub(super) y_numbers: bool,
}

impl Panel<'_> {
    /// Draws the frame, then what belongs in it.
    pub(super) fn draw<'b>(
        &self,
        area: &Area<'b>,
        series: impl FnOnce(&mut Chart<'_, 'b>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let left = if self.y_numbers { LEFT } else { 0.0 };
        let below = if self.x_numbers { BELOW } else { 0.0 };
        let frame = self.frame;
        let whole = area.clone().shrink(
            (grid(frame.x - left), grid(frame.y)),
            (grid(frame.width + left), grid(frame.height + below)),
        );
        let mut chart = ChartBuilder::on(&whole)
            .set_label_area_size(plotters::chart::LabelAreaPosition::Left, grid(left))
            .set_label_area_size(plotters::chart::LabelAreaPosition::Bottom, grid(below))
            .build_cartesian_2d(self.x.range.clone(), self.y.range.clone())?;
        chart
            .configure_mesh()
            .x_labels(self.x.n_ticks)
            .y_labels(self.y.n_ticks)
            .max_light_lines(0)
            .bold_line_style(stroke(FAINT, 1.0))
            .axis_style(stroke(INK, 1.0))
            .label_style(font(SMALL, INK, HPos::Center))
            .set_all_tick_mark_size(grid(4.0))
            .x_label_formatter(&|value| self.x.tick(*value))
            .y_label_formatter(&|value| self.y.tick(*value))
            .draw()?;
        series(&mut chart)?;
        let corners =
            [(frame.x, frame.y), (frame.x, frame.bottom()), (frame.right(), frame.bottom())];
        line(area, &corners, stroke(INK, 1.0))?;
        if let Some(multiplier) = self.y.multiplier().filter(|_| self.y_numbers) {
            let at = (frame.x - 7.0, frame.y - 10.0);
            write(area, &multiplier, at, &font(SMALL, INK, HPos::Right))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn ticks_are_read_without_counting_zeros() {
        let axis = Axis::new(-0.0041..0.0082, 8);
        assert_eq!(axis.multiplier().as_deref(), Some("1e−3"));
        assert_eq!(ticks(&axis), ["−4", "−2", "0", "2", "4", "6", "8"]);
        let axis = Axis::new(0.0..0.25, 3);
        assert_eq!(axis.multiplier(), None);
        assert!(ticks(&axis).contains(&"0.1".to_owned()), "{:?}", ticks(&axis));
        assert!(ticks(&Axis::updates(30_000, 160.0)).contains(&"20".to_owned()));
        assert_eq!(Axis::new(0.0..2e7, 2).multiplier().as_deref(), Some("1e6"));
    }

    #[test]
    fn any_values_make_an_axis() {
        for values in [
            vec![],
            vec![0.0],
            vec![7.0, 7.0],
            vec![1e100, -1e100],
            vec![1e100, 1e100],
            vec![1e-300],
            vec![f64::NAN, f64::INFINITY],
            vec![1.0, 1.0 + f64::EPSILON],
        ] {
            let axis = Axis::around(values.iter().copied(), 4);
            assert!(axis.range.start < axis.range.end, "{values:?}");
            assert!(ticks(&axis).len() < 20, "{values:?}");
        }
    }
}
