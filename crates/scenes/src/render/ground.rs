//! The ground: a plane at z = 0 with a line at each metre, a bold one at every fifth, and metres
//! written on it in two rows. Around small robots it's a line at each 0.2 m, and all is smaller.

use super::{Light, picture::letters};
use crate::Error;

/// Where less than that is clear, lines are nearer to each other, in m.
const SMALL: f64 = 3.75;

const FLOOR: f32 = 0.78;
const LINE: f32 = 0.58;
const BOLD: f32 = 0.38;
const WORDS: f32 = 0.10;

/// Half as wide as lines, in the distance of two.
const HALF_LINE: f32 = 0.006;
const HALF_BOLD: f32 = 0.014;

/// Pixels of a word's mask, in the distance of two lines.
const MASK: f32 = 160.0;

/// How high letters are, in the distance of two lines.
const LETTERS: f32 = 0.3;

/// A ground around a place.
#[derive(Clone, Debug)]
pub struct Ground {
    centre: [f32; 2],
    /// From line to line, in m.
    unit: f64,
    /// Where it's lost in the distance, in m from the centre.
    fade: [f32; 2],
    /// Words in a row along x, and in one along y.
    rows: [Row; 2],
}

/// Words in a row, one at each line at most.
#[derive(Clone, Debug, Default)]
struct Row {
    first: i64,
    signs: Vec<Option<Sign>>,
}

impl Row {
    /// The ink at a place, in units. A word isn't longer than one.
    fn at(&self, along: f32, x: f32, y: f32) -> f32 {
        let place = usize::try_from(along.round() as i64 - self.first).ok();
        let sign = place.and_then(|place| self.signs.get(place)?.as_ref());
        sign.map_or(0.0, |sign| sign.at(x, y))
    }
}

/// A word that lies on the ground, to be read from one side.
#[derive(Clone, Debug)]
struct Sign {
    /// Its middle, in units, as all of it.
    at: [f32; 2],
    /// To the right of whoever reads: one of the four directions.
    right: [f32; 2],
    half: [f32; 2],
    width: usize,
    mask: Vec<f32>,
}

impl Ground {
    /// A ground that is clear as far as `clear_m` from a place. Metres are written beside it at
    /// `rows` (an x and a y), as far as they are clear, to be read by someone who stands in the
    /// direction `reader`.
    ///
    /// # Errors
    /// None in practice: the font is in the program.
    pub fn new(
        [x, y]: [f64; 2],
        clear_m: f64,
        rows: [f64; 2],
        reader: [f64; 2],
    ) -> Result<Self, Error> {
        let right: [f32; 2] = match (reader[0].abs() > reader[1].abs(), reader) {
            (true, [x, _]) => [0.0, x.signum() as f32],
            (false, [_, y]) => [-y.signum() as f32, 0.0],
        };
        let plain = Self::plain([x, y], clear_m);
        let lines = |metres: f64| (metres / plain.unit).round();
        let n = lines(clear_m) as i64;
        let cross = rows.map(lines);
        let row = |axis: usize, letter: char| {
            let first = lines([x, y][axis]) as i64 - n;
            let sign = |line: i64| {
                let mut at = cross;
                at[axis] = line as f64;
                let decimals = usize::from(plain.unit < 1.0);
                let words = format!("{letter} {:.decimals$} m", line as f64 * plain.unit);
                // Where the rows cross, neither is written.
                let clear = (at[axis] - cross[axis]).abs() > 1.0;
                clear.then(|| Sign::new(&words, at, right)).transpose()
            };
            let signs: Result<Vec<_>, Error> = (first..=first + 2 * n).map(sign).collect();
            Ok::<_, Error>(Row { first, signs: signs? })
        };
        Ok(Self { rows: [row(0, 'x')?, row(1, 'y')?], ..plain })
    }

    /// A ground with nothing written on it.
    #[must_use]
    pub fn plain([x, y]: [f64; 2], clear_m: f64) -> Self {
        let fade = [clear_m as f32, 3.0 * clear_m as f32];
        let unit = if clear_m < SMALL { 0.2 } else { 1.0 };
        Self { centre: [x as f32, y as f32], unit, fade, rows: Default::default() }
    }

    /// The colour at a place, where a pixel is so large, and how clear it is.
    pub(super) fn at(&self, x: f32, y: f32, pixel: f32) -> (Light, f32) {
        let [dx, dy] = [x - self.centre[0], y - self.centre[1]];
        let unit = self.unit as f32;
        let [x, y, pixel] = [x, y, pixel].map(|metres| metres / unit);
        let covered = |spacing: f32, half: f32| {
            let one = |value: f32| {
                let off = (value / spacing - (value / spacing).round()).abs() * spacing;
                // The share of the pixel that the line covers.
                let end = |edge: f32| ((edge - off) / pixel.max(1e-4) + 0.5).clamp(0.0, 1.0);
                (end(half) - end(-half)).max(0.0)
            };
            1.0 - (1.0 - one(x)) * (1.0 - one(y))
        };
        let mut value = FLOOR;
        for (ink, share) in [(LINE, covered(1.0, HALF_LINE)), (BOLD, covered(5.0, HALF_BOLD))] {
            value += (ink - value) * share;
        }
        let words = self.rows[0].at(x, x, y).max(self.rows[1].at(y, x, y));
        value += (WORDS - value) * words;
        let away = (dx * dx + dy * dy).sqrt();
        let gone = ((away - self.fade[0]) / (self.fade[1] - self.fade[0])).clamp(0.0, 1.0);
        (Light::new(value, value, 0.985 * value), (1.0 - gone) * (1.0 - gone))
    }
}

impl Sign {
    fn new(text: &str, at: [f64; 2], right: [f32; 2]) -> Result<Self, Error> {
        let text = text.replace('-', "\u{2212}");
        let size = LETTERS * MASK;
        let width = super::picture::width_of(&text, size)?.ceil() as usize + 2;
        let height = size as usize;
        let mut mask = vec![0.0; width * height];
        let baseline = (0.75 * size) as i64;
        letters(&text, size, |x, y, coverage| {
            let (x, y) = (usize::try_from(x + 1), usize::try_from(y + baseline));
            if let (Ok(x), Ok(y)) = (x, y)
                && x < width
                && y < height
            {
                mask[y * width + x] += coverage;
            }
        })?;
        let half = [width, height].map(|pixels| 0.5 * pixels as f32 / MASK);
        Ok(Self { at: at.map(|value| value as f32), right, half, width, mask })
    }

    /// The ink at a place of the ground: between the mask's four nearest pixels.
    fn at(&self, x: f32, y: f32) -> f32 {
        let [dx, dy] = [x - self.at[0], y - self.at[1]];
        let along = dx * self.right[0] + dy * self.right[1];
        // Downwards for the reader: the right turned clockwise.
        let down = dx * self.right[1] - dy * self.right[0];
        if along.abs() >= self.half[0] || down.abs() >= self.half[1] {
            return 0.0;
        }
        let place = |value: f32, half: f32| ((value + half) * MASK - 0.5).max(0.0);
        let (u, v) = (place(along, self.half[0]), place(down, self.half[1]));
        let (i, j) = (u as usize, v as usize);
        let ink = |i: usize, j: usize| self.mask.get(j * self.width + i).copied().unwrap_or(0.0);
        let (a, b) = (u - i as f32, v - j as f32);
        let upper = ink(i, j) * (1.0 - a) + ink(i + 1, j) * a;
        let lower = ink(i, j + 1) * (1.0 - a) + ink(i + 1, j + 1) * a;
        (upper * (1.0 - b) + lower * b).min(1.0)
    }
}
