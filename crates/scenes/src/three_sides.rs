//! A model from three sides, without perspective and to one scale, and as it stands there: figure 1
//! of the paper.
//!
//! ```text
//! from the right | from the front
//! from above     | in perspective
//! ```

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Isometry3, Point3, Vector3};
use svenja::{Body, Collider, Morphology};

use super::Error;
use super::render::{Camera, Ground, Ink, Picture, SKY, Scene, Solid, width_of};

/// Pixels across, even like the height, which follows from the robot.
const WIDTH: usize = 1060;
const MARGIN: usize = 22;
/// For the words below each side.
const CAPTION: usize = 40;
const LETTERS: f32 = 21.0;
const INK: Ink = Ink { colour: [0x22, 0x25, 0x2a], strength: 1.0 };
const FAINT: Ink = Ink { colour: [0x8a, 0x8f, 0x96], strength: 1.0 };
const PAPER: [u8; 3] = [0xff; 3];
/// Around the robot, as a share of its size.
const AIR: f64 = 0.04;
/// A side is at least so long, as a share of the longest, for what is flat.
const LEAST: f64 = 0.25;
/// A robot is at least so long, even if it has no shape at all.
const SMALLEST_M: f64 = 1e-3;
/// Of the camera of the fourth picture.
const ANGLE_DEGREES: f64 = 30.0;

/// A model as it's drawn in its file, on the ground, and looking along +y.
///
/// # Errors
/// None in practice: the font is in the program.
pub fn three_sides(morphology: &Morphology) -> Result<Picture, Error> {
    let sheet = Sheet::new(morphology);
    let mut picture = Picture::filled(WIDTH, sheet.height(), PAPER);
    let [left, right] = [MARGIN, 2 * MARGIN + sheet.pixels(sheet.size.y)];
    let [top, bottom] = [MARGIN, MARGIN + sheet.pixels(sheet.size.z) + CAPTION];
    for (view, [x, y]) in
        [(View::Right, [left, top]), (View::Front, [right, top]), (View::Above, [left, bottom])]
    {
        sheet.side(&mut picture, view, [x, y])?;
    }
    sheet.perspective(&mut picture, [right, bottom])?;
    Ok(picture)
}

#[derive(Clone, Copy)]
enum View {
    Right,
    Front,
    Above,
}

/// Where the robot is, and how large a metre.
struct Sheet<'a> {
    morphology: &'a Morphology,
    bodies: Vec<Body>,
    solids: Vec<Solid>,
    centre: Point3<f64>,
    /// With some air around it.
    size: Vector3<f64>,
    pixels_per_m: f64,
}

impl<'a> Sheet<'a> {
    fn new(morphology: &'a Morphology) -> Self {
        let bodies = placed(morphology);
        let boxes: Vec<_> = bodies.iter().map(corners).collect();
        let low = boxes.iter().fold(Point3::origin(), |a: Point3<f64>, (b, _)| a.inf(b));
        let high = boxes.iter().fold(boxes[0].1, |a, (_, b)| a.sup(b));
        let longest = (high - low).max().max(SMALLEST_M);
        let size = (high - low).map(|side| side.max(LEAST * longest) + 2.0 * AIR * longest);
        let solids = |body: &Body| {
            let solid =
                |it: &Collider| Solid::new(&it.shape, &(body.pose * it.pose), body.colour, 0.0);
            body.colliders.iter().map(solid).collect::<Vec<_>>()
        };
        Self {
            morphology,
            solids: bodies.iter().flat_map(solids).collect(),
            centre: nalgebra::center(&low, &high),
            size,
            pixels_per_m: (WIDTH - 3 * MARGIN) as f64 / (size.y + size.x),
            bodies,
        }
    }

    fn pixels(&self, metres: f64) -> usize {
        (metres * self.pixels_per_m).round() as usize
    }

    fn height(&self) -> usize {
        (MARGIN + self.pixels(self.size.z) + self.pixels(self.size.x) + 2 * CAPTION)
            .next_multiple_of(2)
    }

    fn side(&self, picture: &mut Picture, view: View, [x, y]: [usize; 2]) -> Result<(), Error> {
        let (away, across, upwards, words) = match view {
            View::Right => (Vector3::x(), self.size.y, self.size.z, "from the right"),
            View::Front => (Vector3::y(), self.size.x, self.size.z, "from the front"),
            View::Above => (Vector3::z(), self.size.y, self.size.x, "from above"),
        };
        let pixels = [self.pixels(across), self.pixels(upwards)];
        let height_m = pixels[1] as f64 / self.pixels_per_m;
        let eye = self.centre + away * (2.0 * self.size.norm());
        let camera = Camera::parallel(eye, self.centre, height_m, pixels);
        let scene = Scene { solids: self.solids.clone(), ground: None, sky: PAPER };
        picture.put(&scene.picture(&camera), x, y);
        if !matches!(view, View::Above) {
            // What it stands on, seen from its edge.
            let z = y as f32 + (pixels[1] as f64 / 2.0 + self.centre.z * self.pixels_per_m) as f32;
            let end = (x + pixels[0]) as f32;
            picture.line([x as f32, z], [end, z], 2.0, FAINT);
        }
        let baseline = (y + pixels[1]) as f32 + 1.1 * LETTERS;
        caption(picture, words, x, pixels[0], baseline)?;
        if matches!(view, View::Above) {
            self.scale_bar(picture, [x as f32, baseline])?;
        }
        Ok(())
    }

    /// A round length, a fifth of the side at most.
    fn scale_bar(&self, picture: &mut Picture, [x, baseline]: [f32; 2]) -> Result<(), Error> {
        let fits = |metres: &f64| *metres <= 0.2 * self.size.y;
        let metres = [10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01].into_iter().find(fits);
        let metres = metres.unwrap_or(0.001);
        let words = format!("{metres} m");
        let end = x + (metres * self.pixels_per_m) as f32;
        let y = baseline - 0.3 * LETTERS;
        picture.line([x, y], [end, y], 4.0, INK);
        picture.line([x, y - 8.0], [x, y + 8.0], 3.0, INK);
        picture.line([end, y - 8.0], [end, y + 8.0], 3.0, INK);
        picture.write(&words, [end + 10.0, baseline], LETTERS, INK)
    }

    /// As near as all of the robot can be seen from.
    fn near_enough(&self, pixels: [usize; 2]) -> Camera {
        let view = Vector3::new(0.75, 0.8, 0.55).normalize();
        let corners: Vec<_> = self.bodies.iter().flat_map(box_around).collect();
        let [width, height] = pixels.map(|side| side as f32);
        let inside = |camera: &Camera| {
            let edge = 0.03 * width;
            corners.iter().all(|corner| {
                camera.project(*corner).is_some_and(|[x, y, _]| {
                    (edge..width - edge).contains(&x) && (edge..height - edge).contains(&y)
                })
            })
        };
        let mut distance = self.size.max();
        loop {
            let eye = self.centre + distance * view;
            let camera = Camera::perspective(eye, self.centre, ANGLE_DEGREES, pixels);
            // Far away everything is a point in the middle.
            if inside(&camera) {
                return camera;
            }
            distance *= 1.03;
        }
    }

    fn perspective(&self, picture: &mut Picture, [x, y]: [usize; 2]) -> Result<(), Error> {
        let pixels = [self.pixels(self.size.x), self.pixels(self.size.x)];
        let camera = self.near_enough(pixels);
        let ground = Ground::plain([self.centre.x, self.centre.y], self.size.norm());
        let scene = Scene { solids: self.solids.clone(), ground: Some(ground), sky: SKY };
        picture.put(&scene.picture(&camera), x, y);
        let words = format!(
            "{}: {} bodies, {} kg, {} driven axes",
            self.morphology.name(),
            self.morphology.bodies().len(),
            (100.0 * self.morphology.total_mass_kg()).round() / 100.0,
            self.morphology.actuators().len()
        );
        caption(picture, &words, x, pixels[0], (y + pixels[1]) as f32 + 1.1 * LETTERS)
    }
}

/// In the middle below, smaller if it's too long.
fn caption(
    picture: &mut Picture,
    words: &str,
    x: usize,
    width: usize,
    baseline: f32,
) -> Result<(), Error> {
    let natural = width_of(words, LETTERS)?;
    let size = LETTERS * (width as f32 / natural).min(1.0);
    let start = x as f32 + 0.5 * (width as f32 - natural * size / LETTERS);
    picture.write(words, [start, baseline], size, INK)
}

/// The bodies of a robot as they're looked at: turned by quarters until it looks along +y, and at the
/// height at which it's drawn or at that at which it starts, whichever is nearer to the ground. Some
/// are drawn around their middle; others start with a fall.
fn placed(morphology: &Morphology) -> Vec<Body> {
    let mut bodies = morphology.bodies().to_vec();
    let heading = morphology.heading();
    let forward = bodies[heading.body].pose * heading.axis;
    let quarters: [(f64, Vector3<f64>); 4] = [
        (0.0, Vector3::y()),
        (FRAC_PI_2, Vector3::x()),
        (PI, -Vector3::y()),
        (-FRAC_PI_2, -Vector3::x()),
    ];
    // The first, if it looks up or down.
    let mut turn = quarters[0];
    for other in quarters {
        let is_nearer = other.1.dot(&forward) > turn.1.dot(&forward) + 1e-6;
        turn = if is_nearer { other } else { turn };
    }
    let low = bodies.iter().map(|it| corners(it).0.z).fold(f64::INFINITY, f64::min);
    let start = morphology.start().translation.z;
    let lift = if (low + start).abs() < low.abs() { start } else { 0.0 };
    let placed = Isometry3::new(lift * Vector3::z(), turn.0 * Vector3::z());
    bodies.iter_mut().for_each(|body| body.pose = placed * body.pose);
    bodies
}

/// The lower and the upper corner of the box around a body, as it's drawn: a point if it has no shape.
fn corners(body: &Body) -> (Point3<f64>, Point3<f64>) {
    let around = |it: &Collider| {
        let (points, radius) = it.shape.outline_m();
        let points = points.into_iter().map(|point| body.pose * (it.pose * point));
        let both = points.map(|point| (point, point)).reduce(joined);
        both.map(|(low, high)| (low - Vector3::repeat(radius), high + Vector3::repeat(radius)))
    };
    let here = Point3::from(body.pose.translation.vector);
    body.colliders.iter().filter_map(around).reduce(joined).unwrap_or((here, here))
}

/// The box around two boxes.
fn joined(
    a: (Point3<f64>, Point3<f64>),
    b: (Point3<f64>, Point3<f64>),
) -> (Point3<f64>, Point3<f64>) {
    (a.0.inf(&b.0), a.1.sup(&b.1))
}

/// Its eight corners.
fn box_around(body: &Body) -> [Point3<f64>; 8] {
    let (low, high) = corners(body);
    std::array::from_fn(|i| {
        let side = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        Point3::new(side(0), side(1), side(2))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::{MODEL, morphology};

    /// The slider reaches from -0.55 to 0.6 along y, 0.2 to either side, and from 0 to 0.3 upwards.
    #[test]
    fn the_sides_are_to_one_scale() {
        let morphology = morphology();
        let sheet = Sheet::new(&morphology);
        // 1.15 m at most, a 25th of it on either side of each.
        let air = 2.0 * 0.04 * 1.15;
        let expected = Vector3::new(0.5, 1.15, 0.3) + Vector3::repeat(air);
        assert!((sheet.size - expected).norm() < 1e-9, "{}", sheet.size);
        let picture = three_sides(&morphology).unwrap();
        assert_eq!((picture.width(), picture.height()), (WIDTH, sheet.height()));
        // From above, the block is a grey rectangle of 0.6 m by 0.4 m: its row through the middle.
        let y = MARGIN + sheet.pixels(sheet.size.z) + CAPTION + sheet.pixels(sheet.size.x) / 2;
        let row = &picture.pixels()[y * WIDTH..][..MARGIN + sheet.pixels(sheet.size.y)];
        let inked = row.iter().filter(|pixel| **pixel != PAPER).count();
        // Ball, gap, block, gap, and the rod across: 0.2 + 0.6 + 0.1 m.
        let expected = 0.9 * sheet.pixels_per_m;
        assert!((inked as f64 - expected).abs() < 6.0, "{inked}, {expected}");
        assert_eq!(picture.png().unwrap(), three_sides(&morphology).unwrap().png().unwrap());
    }

    /// As most robots in other formats are: looking along +x, around the origin, with a start on the
    /// ground. One that starts with a fall is where it's drawn.
    #[test]
    fn it_stands_on_the_ground_and_looks_along_y_however_it_is_drawn() {
        let start =
            |z: f64| format!("name = \"Slider\"\nstart = {{ position_m = [0.0, 0.0, {z}] }}");
        let turned = [
            ("name = \"Slider\"", start(0.3)),
            ("[0.0, 0.0, 0.2]", "[0.0, 0.0, -0.1]\nrotation_deg = [0.0, 0.0, -90.0]".into()),
            ("[0.0, 0.5, 0.1]", "[0.5, 0.0, -0.2]\nrotation_deg = [0.0, 0.0, -90.0]".into()),
            ("[0.0, -0.5, 0.1]", "[-0.5, 0.0, -0.2]\nrotation_deg = [0.0, 0.0, -90.0]".into()),
        ];
        let falling = [("name = \"Slider\"", start(0.3))];
        for changes in [&turned[..], &falling] {
            let text = changes.iter().fold(MODEL.to_owned(), |text, (from, to)| {
                assert!(text.contains(from));
                text.replace(from, to)
            });
            let model = Morphology::parse("slider.toml", &text).unwrap();
            for (body, expected) in placed(&model).iter().zip(morphology().bodies()) {
                let off = body.pose.inverse() * expected.pose;
                assert!(off.translation.vector.norm() < 1e-12, "{}: {off}", body.name);
                assert!(off.rotation.angle() < 1e-7, "{}: {off}", body.name);
            }
        }
    }

    #[test]
    fn boxes_are_as_large_as_what_is_in_them() {
        let morphology = morphology();
        let mut body = morphology.bodies()[0].clone();
        body.pose = Isometry3::rotation(Vector3::z() * std::f64::consts::FRAC_PI_2);
        let (low, high) = corners(&body);
        let half = Point3::new(0.3, 0.2, 0.1);
        assert!((high - half).norm() < 1e-12 && (low + half.coords).coords.norm() < 1e-12);
    }
}
