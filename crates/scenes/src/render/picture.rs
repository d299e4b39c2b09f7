//! Pixels: from light to bytes and back (the sRGB curve), as PNG, with lines and words on them.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};

use super::Light;
use crate::{Error, FONT};

/// A picture, 8 bits a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

/// What lines and words are drawn with.
#[derive(Clone, Copy, Debug)]
pub struct Ink {
    /// Red, green, blue.
    pub colour: [u8; 3],
    /// The share of the colour that is mixed in, 0 to 1.
    pub strength: f32,
}

impl Picture {
    /// All of one colour: red, green, blue.
    #[must_use]
    pub fn filled(width: usize, height: usize, colour: [u8; 3]) -> Self {
        Self { width, height, pixels: vec![colour; width * height] }
    }

    /// The width in pixels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// The height in pixels.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// `[height x width]`: red, green, blue.
    #[must_use]
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }

    /// `[height x width x 3]`
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.pixels.as_flattened()
    }

    /// Parts of some rows each, from the top.
    pub(super) fn rows(&mut self, rows: usize) -> impl Iterator<Item = &mut [[u8; 3]]> {
        self.pixels.chunks_mut((rows * self.width).max(1))
    }

    /// Puts another picture there, its upper left corner at (x, y); what doesn't fit is cut off.
    pub fn put(&mut self, other: &Self, x: usize, y: usize) {
        let width = other.width.min(self.width.saturating_sub(x));
        for row in 0..other.height.min(self.height.saturating_sub(y)) {
            let from = &other.pixels[row * other.width..][..width];
            self.pixels[(y + row) * self.width + x..][..width].copy_from_slice(from);
        }
    }

    /// A line with round ends between places in pixels; a pixel takes the share of the ink that
    /// covers it.
    pub fn line(&mut self, from: [f32; 2], to: [f32; 2], width: f32, ink: Ink) {
        let half = 0.5 * width;
        let range = |a: f32, b: f32, end: usize| {
            let low = (a.min(b) - half - 1.0).max(0.0) as usize;
            low..((a.max(b) + half + 2.0).max(0.0) as usize).min(end)
        };
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let squared = dx * dx + dy * dy;
        for y in range(from[1], to[1], self.height) {
            for x in range(from[0], to[0], self.width) {
                let [px, py] = [x as f32 + 0.5 - from[0], y as f32 + 0.5 - from[1]];
                let share = if squared > 0.0 {
                    ((px * dx + py * dy) / squared).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let [ex, ey] = [px - share * dx, py - share * dy];
                let coverage = (half + 0.5 - (ex * ex + ey * ey).sqrt()).clamp(0.0, 1.0);
                self.mix(x, y, ink, coverage);
            }
        }
    }

    /// Words with their left end and baseline at a place in pixels, `size` pixels high.
    ///
    /// # Errors
    /// None in practice: the font is in the program.
    pub fn write(&mut self, text: &str, at: [f32; 2], size: f32, ink: Ink) -> Result<(), Error> {
        let (width, height) = (self.width, self.height);
        letters(text, size, |x, y, coverage| {
            let (x, y) = (x + at[0] as i64, y + at[1] as i64);
            let inside =
                |value: i64, end: usize| usize::try_from(value).ok().filter(|&it| it < end);
            if let (Some(x), Some(y)) = (inside(x, width), inside(y, height)) {
                self.mix(x, y, ink, coverage);
            }
        })
    }

    fn mix(&mut self, x: usize, y: usize, ink: Ink, coverage: f32) {
        let pixel = &mut self.pixels[y * self.width + x];
        for (value, ink_value) in pixel.iter_mut().zip(ink.colour) {
            let share = coverage * ink.strength;
            *value =
                (f32::from(*value) * (1.0 - share) + f32::from(ink_value) * share).round() as u8;
        }
    }

    /// The bytes of a PNG file.
    ///
    /// # Errors
    /// None in practice: a picture that is no rectangle.
    pub fn png(&self) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        let too_large = |_| Error::TooLarge("a PNG can't have more than 2^32 pixels a side");
        let [width, height] =
            [self.width, self.height].map(|side| u32::try_from(side).map_err(too_large));
        let mut encoder = png::Encoder::new(&mut bytes, width?, height?);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::High);
        // Flat areas and soft shadows are smallest as they are.
        encoder.set_filter(png::Filter::NoFilter);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.bytes())?;
        writer.finish()?;
        Ok(bytes)
    }
}

/// The letters of a text, pixel by pixel with its coverage, from its left end and baseline.
pub(super) fn letters(
    text: &str,
    size: f32,
    mut pixel: impl FnMut(i64, i64, f32),
) -> Result<(), Error> {
    let font = FontRef::try_from_slice(FONT).map_err(Error::Font)?;
    let scaled = font.as_scaled(PxScale::from(size));
    let mut x = 0.0;
    for letter in text.chars() {
        let id = scaled.glyph_id(letter);
        let glyph = id.with_scale_and_position(PxScale::from(size), point(x, 0.0));
        x += scaled.h_advance(id);
        if let Some(outline) = font.outline_glyph(glyph) {
            let corner = outline.px_bounds().min;
            outline.draw(|dx, dy, coverage| {
                pixel(corner.x as i64 + i64::from(dx), corner.y as i64 + i64::from(dy), coverage);
            });
        }
    }
    Ok(())
}

/// How wide a text is, in pixels.
///
/// # Errors
/// None in practice: the font is in the program.
pub fn width_of(text: &str, size: f32) -> Result<f32, Error> {
    let font = FontRef::try_from_slice(FONT).map_err(Error::Font)?;
    let scaled = font.as_scaled(PxScale::from(size));
    Ok(text.chars().map(|letter| scaled.h_advance(scaled.glyph_id(letter))).sum())
}

/// Where the light of a byte ends and that of the next one begins.
static EDGES: LazyLock<[f32; 255]> =
    LazyLock::new(|| std::array::from_fn(|byte| curve((byte as f32 + 0.5) / 255.0)));

/// Light to bytes, by the sRGB curve.
pub(super) fn encoded(light: Light) -> [u8; 3] {
    let byte = |value: f32| EDGES.partition_point(|&edge| edge <= value) as u8;
    [byte(light.x), byte(light.y), byte(light.z)]
}

/// The sRGB curve, by a power function that is the same on all machines.
fn curve(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { libm::powf((value + 0.055) / 1.055, 2.4) }
}

/// And back.
pub(super) fn decoded(colour: [u8; 3]) -> Light {
    Light::from(colour.map(|byte| curve(f32::from(byte) / 255.0)))
}
