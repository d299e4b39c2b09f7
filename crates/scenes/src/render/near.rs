//! Which solids can matter where, so that a point asks few of them.
//!
//! Shadows and what solids cover of the sky are asked of each point that is seen, and of all solids most are
//! too far off. Here each solid's reach is a disc, on the plane that the sun looks at and on the ground,
//! and a grid has for each of its cells the solids whose discs touch it. What is left out would have been
//! left out by [`Solid::near_ray`] or [`Solid::towards_axis`] itself, so the bytes are those of asking all.

use super::{SUN_RADIUS, Solid, Sun, Vec3};

/// Cells along the longer side of a grid.
const CELLS: f32 = 64.0;

/// How many radii away a solid still covers the sky.
pub(super) const FAR: f32 = 8.0;

/// The two grids of a scene.
pub(super) struct Near {
    /// By places on the plane that the sun looks at.
    shadows: Grid,
    /// By places on the ground.
    covers: Grid,
}

impl Near {
    pub(super) fn of(solids: &[Solid], sun: &Sun) -> Self {
        // Of all points that are seen: on the ground, or on a solid.
        let lowest = solids.iter().map(|it| it.centre().z - it.reach()).fold(0.0, f32::min);
        let shadow = |solid: &Solid| {
            let (r, centre) = (solid.reach(), solid.centre());
            // A point at distance t before a solid lies t sun.z lower, but for what it's beside.
            let height = centre.z - lowest + 0.01 + r * (1.0 + SUN_RADIUS);
            let farthest = (height / (sun.to.z - SUN_RADIUS)).max(0.0);
            ([centre.dot(&sun.side), centre.dot(&sun.up)], r + SUN_RADIUS * (farthest + r))
        };
        let cover = |solid: &Solid| ([solid.centre().x, solid.centre().y], solid.limit(FAR));
        Self {
            shadows: Grid::of(&solids.iter().map(shadow).collect::<Vec<_>>()),
            covers: Grid::of(&solids.iter().map(cover).collect::<Vec<_>>()),
        }
    }

    /// Solids that may be between a point and the sun, in their order.
    pub(super) fn shading(&self, at: Vec3, sun: &Sun) -> &[u32] {
        self.shadows.at([at.dot(&sun.side), at.dot(&sun.up)])
    }

    /// Solids that may cover some of a point's sky, in their order.
    pub(super) fn covering(&self, at: Vec3) -> &[u32] {
        self.covers.at([at.x, at.y])
    }
}

/// Cells with the discs that touch them.
struct Grid {
    low: [f32; 2],
    /// The side of a cell.
    cell: f32,
    n: [usize; 2],
    lists: Vec<Vec<u32>>,
}

impl Grid {
    /// Of discs with a middle and a radius, which get some room for roundings.
    fn of(discs: &[([f32; 2], f32)]) -> Self {
        let ends = |&([x, y], radius): &([f32; 2], f32)| {
            let radius = radius * 1.001 + 1e-5 * (1.0 + x.abs().max(y.abs()));
            [[x - radius, y - radius], [x + radius, y + radius]]
        };
        let ends: Vec<_> = discs.iter().map(ends).collect();
        let low = [0, 1].map(|i| ends.iter().map(|it| it[0][i]).fold(f32::INFINITY, f32::min));
        let high = [0, 1].map(|i| ends.iter().map(|it| it[1][i]).fold(f32::NEG_INFINITY, f32::max));
        let longest = (high[0] - low[0]).max(high[1] - low[1]);
        if !(longest > 0.0 && longest.is_finite()) {
            return Self { low: [0.0; 2], cell: 1.0, n: [0; 2], lists: Vec::new() };
        }
        let cell = longest / CELLS;
        let n = [0, 1].map(|i| ((high[i] - low[i]) / cell) as usize + 1);
        let mut grid = Self { low, cell, n, lists: vec![Vec::new(); n[0] * n[1]] };
        for (disc, [low, high]) in ends.iter().enumerate() {
            let [from, to] = [low, high].map(|end| [0, 1].map(|i| grid.index(end[i], i)));
            for y in from[1].unwrap_or(0)..=to[1].unwrap_or(n[1] - 1) {
                for x in from[0].unwrap_or(0)..=to[0].unwrap_or(n[0] - 1) {
                    grid.lists[y * n[0] + x].push(disc as u32);
                }
            }
        }
        grid
    }

    /// A cell's number along an axis; it never falls as the place rises.
    fn index(&self, place: f32, axis: usize) -> Option<usize> {
        let index = (place - self.low[axis]) / self.cell;
        (index >= 0.0 && index < self.n[axis] as f32).then_some(index as usize)
    }

    fn at(&self, [x, y]: [f32; 2]) -> &[u32] {
        match (self.index(x, 0), self.index(y, 1)) {
            (Some(x), Some(y)) => &self.lists[y * self.n[0] + x],
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
    use svenja::{Rod, Shape};

    use super::*;

    /// Numbers that look random, within -1 to 1.
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 1_u64;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1 << 30) - 1.0
        }
    }

    fn solids(next: &mut impl FnMut() -> f64, far: f64) -> Vec<Solid> {
        let mut solid = |i: usize| {
            let place = Translation3::new(far + next(), far - next(), 0.4 + 0.4 * next());
            let turn = UnitQuaternion::from_euler_angles(3.0 * next(), next(), next());
            let size = 0.05 + 0.04 * next();
            let shape = match i % 3 {
                0 => Shape::Sphere { radius_m: size },
                1 => Shape::Box { half_extents_m: Vector3::new(size, 2.0 * size, 0.5 * size) },
                _ => Shape::Capsule(Rod {
                    radius_m: size,
                    from_m: Point3::new(0.0, 0.0, -2.0 * size),
                    to_m: Point3::new(0.0, 0.0, 2.0 * size),
                }),
            };
            Solid::new(&shape, &Isometry3::from_parts(place, turn), [9; 3], 0.0)
        };
        (0..24).map(&mut solid).collect()
    }

    /// Whatever a solid says of itself that it's near, it's in the list of the place; wherever the robot is.
    #[test]
    fn no_solid_that_is_near_is_left_out() {
        let (mut next, sun) = (numbers(), Sun::new());
        for far in [0.0, 30.0, -900.0] {
            let solids = solids(&mut next, far);
            let near = Near::of(&solids, &sun);
            let (mut shading, mut all) = (0, 0);
            for i in 0..20_000 {
                let z = if i % 2 == 0 { 0.0 } else { 0.5 + 0.5 * next() };
                let place =
                    Vec3::new((far + 3.0 * next()) as f32, (far + 3.0 * next()) as f32, z as f32);
                let place = place + 1e-3 * Vec3::z();
                let [a, b] = [near.shading(place, &sun), near.covering(place)];
                for (i, solid) in solids.iter().enumerate() {
                    let listed = |list: &[u32]| list.contains(&(i as u32));
                    let shades = solid.near_ray(place, sun.to, SUN_RADIUS);
                    assert!(!shades || listed(a), "{i} at {place}");
                    assert!(
                        solid.towards_axis(place, FAR).is_none() || listed(b),
                        "{i} at {place}"
                    );
                    shading += usize::from(shades);
                    all += usize::from(listed(a));
                }
            }
            assert!(0 < shading && all < 20_000 * 24 / 4, "{shading} of {all}: it's of some use");
        }
    }
}
