//! A small ray caster: robots on the ground as pictures, with no GPU and no display.
//!
//! Boxes, balls, capsules and cylinders are met exactly (`solid.rs`), so a silhouette is that of the
//! shape and not of a mesh. A pixel is the mean of some rays, each of which asks several places
//! of the sun's disc for light, which makes the shadows soft. What a ray needn't ask is found
//! first: the balls around solids tell for each pixel which solids can be in it, and grids (`near.rs`)
//! which can shade it.
//!
//! The same scene gives the same bytes: each pixel is worked out by itself, so the number of threads
//! doesn't matter.

mod camera;
mod ground;
mod near;
mod picture;
mod solid;

use std::{array, ops::Range, thread};

use nalgebra::{Point3, Vector3};

pub use camera::Camera;
pub use ground::Ground;
pub use picture::{Ink, Picture, width_of};
pub use solid::Solid;

use near::{FAR, Near};

type Vec3 = Vector3<f32>;

/// Light, linear: red, green, blue.
type Light = Vec3;

/// Rays of a pixel along each side.
const SAMPLES: usize = 2;

/// Places of the sun's disc that a ray asks for light; each of a pixel's rays asks others. All
/// together are at most 32.
const SUNS: usize = 4;

/// Of the sun's disc, seen from the ground: tan of the angle. Wider than the real one, so that
/// shadows are soft at a robot's size.
const SUN_RADIUS: f32 = 0.05;

/// From the ground towards the sun.
const SUN: [f32; 3] = [-0.43, -0.3, 0.85];

/// Rows that a thread draws at a time.
const BAND: usize = 4;

/// Where light comes from.
struct Sun {
    /// Towards its middle.
    to: Vec3,
    /// Across, each as long as `to` and at right angles to it and to each other.
    side: Vec3,
    up: Vec3,
    /// Towards the places of its disc that rays ask; neighbours are far from each other on it.
    places: [Vec3; SAMPLES * SAMPLES * SUNS],
}

impl Sun {
    fn new() -> Self {
        let to = Vec3::from(SUN).normalize();
        let side = to.cross(&Vec3::y()).normalize();
        let up = side.cross(&to);
        let places = array::from_fn(|i| {
            let [a, b] = disc(i, SAMPLES * SAMPLES * SUNS);
            (to + SUN_RADIUS * (a * side + b * up)).normalize()
        });
        Self { to, side, up, places }
    }
}

/// Something to draw.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The solids that are drawn.
    pub solids: Vec<Solid>,
    /// The ground that they stand on, if it's drawn.
    pub ground: Option<Ground>,
    /// What is behind everything: red, green, blue.
    pub sky: [u8; 3],
}

/// A sky that leaves the ground its edge.
pub const SKY: [u8; 3] = [0xe6, 0xeb, 0xee];

/// What a ray met first.
struct Hit {
    distance: f32,
    normal: Vec3,
    colour: Light,
    glow: f32,
    is_ground: bool,
    /// 1 where all of it is seen, 0 where it's lost in the distance.
    clarity: f32,
}

impl Scene {
    /// The scene as a camera sees it, by all cores.
    #[must_use]
    pub fn picture(&self, camera: &Camera) -> Picture {
        self.picture_by(camera, thread::available_parallelism().map_or(1, usize::from))
    }

    /// The same by so many threads.
    #[must_use]
    pub fn picture_by(&self, camera: &Camera, n_threads: usize) -> Picture {
        let (width, height) = (camera.width(), camera.height());
        let mut picture = Picture::filled(width, height, self.sky);
        let caster = Caster::of(self, camera);
        let mut shares: Vec<Vec<_>> = (0..n_threads.max(1)).map(|_| Vec::new()).collect();
        // By turns: sky takes less time than a robot.
        for (i, band) in picture.rows(BAND).enumerate() {
            shares[i % n_threads.max(1)].push((i * BAND, band));
        }
        thread::scope(|scope| {
            let mut shares = shares.into_iter();
            let own = shares.next();
            for share in shares {
                scope.spawn(|| caster.draw(share));
            }
            caster.draw(own.unwrap_or_default());
        });
        picture
    }

    /// Whether a camera sees a point, and no solid is before it; then its place in the picture.
    #[must_use]
    pub fn see(&self, camera: &Camera, point: Point3<f64>) -> Option<[f32; 2]> {
        let [x, y, _] = camera.project(point)?;
        let (from, to) = camera.ray(x, y);
        let far = (point.coords.cast() - from).norm();
        let hides = |solid: &Solid| {
            solid.near_ray(from, to, 0.0) && solid.meet(from, to).is_some_and(|(t, _)| t < far)
        };
        (!self.solids.iter().any(hides)).then_some([x, y])
    }
}

/// What is worked out once for all pixels of a picture.
struct Caster<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    sky: Light,
    sun: Sun,
    near: Near,
}

impl<'a> Caster<'a> {
    fn of(scene: &'a Scene, camera: &'a Camera) -> Self {
        let sun = Sun::new();
        let near = Near::of(&scene.solids, &sun);
        Self { scene, camera, sky: picture::decoded(scene.sky), sun, near }
    }

    /// Bands of rows, each with its first row.
    fn draw(&self, bands: Vec<(usize, &mut [[u8; 3]])>) {
        let width = self.camera.width();
        let mut seen = Vec::new();
        for (first, band) in bands {
            for (j, pixel) in band.iter_mut().enumerate() {
                *pixel = self.pixel([j % width, first + j / width], &mut seen);
            }
        }
    }

    /// With room for the solids that can be in it.
    fn pixel(&self, [x, y]: [usize; 2], seen: &mut Vec<&'a Solid>) -> [u8; 3] {
        let Self { camera, sky, .. } = *self;
        let (eye, forward, spread) = camera.cone(x, y);
        let near = |solid: &&Solid| solid.near_ray(eye, forward, spread);
        seen.clear();
        seen.extend(self.scene.solids.iter().filter(near));
        let seen = &seen[..];
        let n = SAMPLES * SAMPLES;
        let rays = (0..n).map(|sample| {
            let step = |i: usize| (i as f32 + 0.5) / SAMPLES as f32;
            camera.ray(x as f32 + step(sample % SAMPLES), y as f32 + step(sample / SAMPLES))
        });
        let far = |hit: &Hit, light: Light| light * hit.clarity + sky * (1.0 - hit.clarity);
        let mean = |sum: Light| picture::encoded(sum / n as f32);
        let meet = |(from, to)| self.hit(seen, from, to, camera.pixel_at(1.0));
        if seen.is_empty() {
            // Nothing but ground, whose light changes slowly: it's worked out once.
            let Some(middle) = meet((eye, forward)) else { return mean(sky * n as f32) };
            let light = self.shade(&middle, eye, forward, 0..n * SUNS);
            let colour = |hit: Option<Hit>| {
                hit.map_or(sky, |hit| far(&hit, light.component_mul(&hit.colour)))
            };
            return mean(rays.map(|ray| colour(meet(ray))).sum());
        }
        let colour = |(sample, (from, to))| match meet((from, to)) {
            None => sky,
            Some(hit) => {
                let suns = sample * SUNS..(sample + 1) * SUNS;
                let light = self.shade(&hit, from, to, suns).component_mul(&hit.colour);
                let gleam = self.gleam(&hit, to);
                far(&hit, light + Light::repeat(gleam))
            }
        };
        mean(rays.enumerate().map(colour).sum())
    }

    fn hit(&self, solids: &[&Solid], from: Vec3, to: Vec3, pixel: f32) -> Option<Hit> {
        let mut first: Option<Hit> = None;
        for solid in solids {
            if let Some((distance, normal)) = solid.meet(from, to)
                && first.as_ref().is_none_or(|hit| distance < hit.distance)
            {
                let (colour, glow) = (solid.colour(), solid.glow());
                first =
                    Some(Hit { distance, normal, colour, glow, is_ground: false, clarity: 1.0 });
            }
        }
        if let Some(ground) = &self.scene.ground
            && to.z < 0.0
            && from.z > 0.0
        {
            let distance = -from.z / to.z;
            if first.as_ref().is_none_or(|hit| distance < hit.distance) {
                let at = from + distance * to;
                let (colour, clarity) = ground.at(at.x, at.y, pixel * distance / -to.z);
                let normal = Vec3::z();
                first = Some(Hit { distance, normal, colour, glow: 0.0, is_ground: true, clarity });
            }
        }
        first
    }

    /// What a surface is lit with: the sky, the sun where nothing is in its way, its own glow.
    fn shade(&self, hit: &Hit, from: Vec3, to: Vec3, suns: Range<usize>) -> Light {
        let at = from + hit.distance * to + 1e-3 * hit.normal;
        let facing = hit.normal.dot(&self.sun.to).max(0.0);
        let lit = if facing > 0.0 { facing * self.sunlight(at, suns) } else { 0.0 };
        let open = 0.5 + 0.5 * hit.normal.z;
        let sky = (0.34 + 0.2 * open) * self.openness(at, hit.normal);
        Light::repeat(sky + 0.62 * lit + hit.glow)
    }

    /// Where the sun is mirrored, on what isn't the ground.
    fn gleam(&self, hit: &Hit, to: Vec3) -> f32 {
        let half = (self.sun.to - to).normalize();
        if hit.is_ground { 0.0 } else { 0.08 * hit.normal.dot(&half).max(0.0).powi(24) }
    }

    /// The share of the sun that isn't covered, by some of its places.
    fn sunlight(&self, at: Vec3, suns: Range<usize>) -> f32 {
        let n = suns.len();
        let mut covered = 0_u32;
        let solids =
            self.near.shading(at, &self.sun).iter().map(|&i| &self.scene.solids[i as usize]);
        for solid in solids.filter(|solid| solid.near_ray(at, self.sun.to, SUN_RADIUS)) {
            for (bit, to) in self.sun.places[suns.clone()].iter().enumerate() {
                if covered >> bit & 1 == 0 && solid.meet(at, *to).is_some() {
                    covered |= 1 << bit;
                }
            }
        }
        1.0 - covered.count_ones() as f32 / n as f32
    }

    /// The share of the sky that solids leave open, about: what makes the ground darker where
    /// something is close. A ball of radius r at distance d covers (r/d)² of the light from its
    /// direction; what is far off is left out, and the rest lowered so that this has no edge.
    fn openness(&self, at: Vec3, normal: Vec3) -> f32 {
        let solids = self.near.covering(at).iter().map(|&i| &self.scene.solids[i as usize]);
        solids.fold(1.0, |open, solid| {
            let Some((d, r)) = solid.towards_axis(at, FAR) else { return open };
            let distance = d.norm().max(1e-4);
            let facing = (normal.dot(&d) / distance).max(0.0);
            let covered = ((r / distance).min(1.0).powi(2) - 1.0 / (FAR * FAR)).max(0.0);
            open * (1.0 - 0.7 * covered * facing)
        })
    }
}

/// Place i of n on a disc of radius 1, evenly spread: Vogel's spiral, whose golden angle is written
/// as a rotation, so that no system's sine is asked.
fn disc(i: usize, n: usize) -> [f32; 2] {
    const COS: f32 = -0.737_368_9;
    const SIN: f32 = 0.675_490_3;
    let (mut c, mut s) = (1.0_f32, 0.0_f32);
    for _ in 0..i {
        (c, s) = (c * COS - s * SIN, c * SIN + s * COS);
    }
    let radius = ((i as f32 + 0.5) / n as f32).sqrt();
    [radius * c, radius * s]
}

#[cfg(test)]
mod tests;
