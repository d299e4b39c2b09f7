//! A legend: each setting's colour with its name, in as many lines as they need.

use plotters::style::text_anchor::HPos;

use super::{
    Error, Setting,
    canvas::{Area, INK, PAGE, SMALL, font, line, room, setting_line, stroke, viridis, write},
};

const LINE: f64 = 19.0;

/// Settings with their places.
pub(super) struct Legend<'a> {
    settings: &'a [Setting],
    /// Of each one's entry, from the legend's upper left corner.
    places: Vec<(f64, f64)>,
}

impl<'a> Legend<'a> {
    pub(super) fn of(settings: &'a [Setting]) -> Self {
        let (mut x, mut y) = (10.0, 0.0);
        let place = |setting: &Setting| {
            let width = 34.0 + room(&setting_line(&setting.name), SMALL) + 22.0;
            if x > 10.0 && x + width > PAGE {
                (x, y) = (10.0, y + LINE);
            }
            let at = (x, y);
            x += width;
            at
        };
        Self { settings, places: settings.iter().map(place).collect() }
    }

    pub(super) fn height(&self) -> f64 {
        self.places.last().map_or(0.0, |(_, y)| y + LINE)
    }

    /// With the middle of its first line at `top`.
    pub(super) fn draw(&self, area: &Area<'_>, top: f64) -> Result<(), Error> {
        let n = self.settings.len();
        for (i, (setting, (x, y))) in self.settings.iter().zip(&self.places).enumerate() {
            let (name, y) = (setting_line(&setting.name), top + y);
            line(area, &[(*x, y), (x + 28.0, y)], stroke(viridis(i, n), 2.5))?;
            write(area, &name, (x + 34.0, y), &font(SMALL, INK, HPos::Left))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::run_of;

    #[test]
    fn a_legend_stays_on_the_page() {
        let names: Vec<_> = (0..30).map(|i| format!("policy=modular,xi={i}")).collect();
        let settings: Vec<_> = names.iter().map(|it| (it.as_str(), vec![vec![1.0]])).collect();
        let run = run_of(&settings);
        let places = Legend::of(&run.settings).places;
        assert!(places.iter().all(|(x, _)| (10.0..PAGE - 60.0).contains(x)), "{places:?}");
        assert!(places.windows(2).all(|it| it[0].1 < it[1].1 || it[0].0 < it[1].0));
    }
}
