//! Where a picture is taken from: with perspective, or without it, as drawings are.

use nalgebra::Point3;

use super::Vec3;

/// A camera with z up in its pictures.
#[derive(Clone, Debug)]
pub struct Camera {
    eye: Vec3,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    width: usize,
    height: usize,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// With tan of half the angle from the picture's bottom to its top.
    Perspective(f32),
    /// With half the height of what is seen, in m.
    Parallel(f32),
}

impl Camera {
    /// A camera at `eye` that looks at `target`, with an angle from bottom to top, in degrees.
    #[must_use]
    pub fn perspective(
        eye: Point3<f64>,
        target: Point3<f64>,
        degrees: f64,
        size: [usize; 2],
    ) -> Self {
        let tangent = libm::tan(degrees.to_radians() / 2.0) as f32;
        Self::new(eye, target, size, Kind::Perspective(tangent))
    }

    /// The same without perspective: what is seen is `height_m` high wherever it is.
    #[must_use]
    pub fn parallel(
        eye: Point3<f64>,
        target: Point3<f64>,
        height_m: f64,
        size: [usize; 2],
    ) -> Self {
        Self::new(eye, target, size, Kind::Parallel(height_m as f32 / 2.0))
    }

    fn new(eye: Point3<f64>, target: Point3<f64>, [width, height]: [usize; 2], kind: Kind) -> Self {
        let forward = (target - eye).normalize();
        // From straight above, y is to the right in the picture: forward, as robots are drawn.
        let up = if forward.x == 0.0 && forward.y == 0.0 { -Vec3::x() } else { Vec3::z() };
        let forward = forward.cast();
        let right = forward.cross(&up).normalize();
        let up = right.cross(&forward);
        Self { eye: eye.coords.cast(), forward, right, up, width, height, kind }
    }

    /// The width of the picture in pixels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// The height of the picture in pixels.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// From where and in which direction light reaches a place of the picture, in pixels from its
    /// upper left corner.
    pub(super) fn ray(&self, x: f32, y: f32) -> (Vec3, Vec3) {
        let scale = 2.0 / self.height as f32;
        let across = (x - 0.5 * self.width as f32) * scale;
        let upwards = (0.5 * self.height as f32 - y) * scale;
        let aside = across * self.right + upwards * self.up;
        match self.kind {
            Kind::Perspective(tangent) => (self.eye, (self.forward + tangent * aside).normalize()),
            Kind::Parallel(half) => (self.eye + half * aside, self.forward),
        }
    }

    /// A ray through a pixel's middle, and how fast the pixel widens along it: all of the pixel's
    /// rays stay within that of it, or within a pixel's size in parallel.
    pub(super) fn cone(&self, x: usize, y: usize) -> (Vec3, Vec3, f32) {
        let (eye, forward) = self.ray(x as f32 + 0.5, y as f32 + 0.5);
        (eye, forward, self.pixel_at(1.0))
    }

    /// The size of a pixel at a distance, in m.
    pub(super) fn pixel_at(&self, distance: f32) -> f32 {
        match self.kind {
            Kind::Perspective(tangent) => 2.0 * tangent * distance / self.height as f32,
            Kind::Parallel(half) => 2.0 * half / self.height as f32,
        }
    }

    /// The place of a point in the picture, in pixels, and its depth in m; none behind the camera.
    #[must_use]
    pub fn project(&self, point: Point3<f64>) -> Option<[f32; 3]> {
        let to = point.coords.cast() - self.eye;
        let depth = to.dot(&self.forward);
        let size = self.pixel_at(depth);
        (depth > 0.0).then(|| {
            let x = 0.5 * self.width as f32 + to.dot(&self.right) / size;
            let y = 0.5 * self.height as f32 - to.dot(&self.up) / size;
            [x, y, depth]
        })
    }
}
