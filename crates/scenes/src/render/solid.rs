//! Where a ray meets a shape, and how its surface lies there.
//!
//! A ray o + t d with |d| = 1 meets a ball of radius r around 0 at the lesser root of
//! |o + t d|² = r², and the side of a cylinder along z at that of the same without z; a box is the
//! overlap of three slabs (Kay and Kajiya, 1986), a hull that of as many half spaces as it has
//! triangles. A capsule is a cylinder's side and two balls; an ellipsoid is a ball once lengths are
//! measured in its radii.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use svenja::{Hull, Shape};

use super::{Light, Vec3, picture::decoded};

/// A shape in space, with a colour.
#[derive(Clone, Debug)]
pub struct Solid {
    form: Form,
    /// Of the shape's own frame, in which what is round lies along z.
    centre: Vec3,
    to_own: Matrix3<f32>,
    /// Of a ball around it all.
    reach: f32,
    colour: Light,
    glow: f32,
}

#[derive(Clone, Debug)]
enum Form {
    Box(Vec3),
    Ball(f32),
    /// Radius, and half the length without the half balls.
    Capsule(f32, f32),
    /// Radius, and half the length.
    Cylinder(f32, f32),
    /// Its radii along x, y and z.
    Ellipsoid(Vec3),
    /// Half the size of a box around it, and of each half space its normal and its distance.
    Hull(Vec3, Vec<(Vec3, f32)>),
}

impl Solid {
    /// A shape at its pose. `glow` is the share of its colour that it sends out by itself.
    #[must_use]
    pub fn new(shape: &Shape, pose: &Isometry3<f64>, colour: [u8; 3], glow: f32) -> Self {
        let rod = |rod: &svenja::Rod| (rod.radius_m as f32, 0.5 * rod.length_m() as f32);
        let (form, reach) = match shape {
            Shape::Box { half_extents_m } => {
                let half: Vec3 = half_extents_m.cast();
                (Form::Box(half), half.norm())
            }
            Shape::Sphere { radius_m } => (Form::Ball(*radius_m as f32), *radius_m as f32),
            Shape::Capsule(it) => {
                let (radius, half) = rod(it);
                (Form::Capsule(radius, half), radius + half)
            }
            Shape::Cylinder(it) => {
                let (radius, half) = rod(it);
                (Form::Cylinder(radius, half), (radius * radius + half * half).sqrt())
            }
            Shape::Ellipsoid { radii_m } => {
                let radii: Vec3 = radii_m.cast();
                (Form::Ellipsoid(radii), radii.max())
            }
            Shape::Hull(it) => hull(it),
        };
        let centre = match shape {
            Shape::Capsule(_) | Shape::Cylinder(_) | Shape::Hull(_) => pose * shape.centre_m(),
            _ => pose.translation.vector.into(),
        };
        let turn = pose.rotation * shape.principal_axes();
        Self {
            form,
            centre: centre.coords.cast(),
            to_own: turn.inverse().to_rotation_matrix().matrix().cast(),
            reach,
            colour: decoded(colour),
            glow,
        }
    }

    pub(super) fn colour(&self) -> Light {
        self.colour
    }

    pub(super) fn glow(&self) -> f32 {
        self.glow
    }

    /// Of the ball around it all.
    pub(super) fn centre(&self) -> Vec3 {
        self.centre
    }

    /// The ball's radius.
    pub(super) fn reach(&self) -> f32 {
        self.reach
    }

    /// Whether a ray that widens by `spread` for each metre can come near: it's asked of a ball.
    pub(super) fn near_ray(&self, from: Vec3, to: Vec3, spread: f32) -> bool {
        let away = self.centre - from;
        let along = away.dot(&to);
        let beside = away - along * to;
        let reach = self.reach + spread * (along.max(0.0) + self.reach);
        along > -self.reach && beside.norm_squared() < reach * reach
    }

    /// From a point towards the nearest of the shape's axis, and the radius around it there; none
    /// if that's more than so many radii away.
    pub(super) fn towards_axis(&self, at: Vec3, far: f32) -> Option<(Vec3, f32)> {
        let (half, radius) = self.axis();
        let limit = self.limit(far);
        let away = at - self.centre;
        if away.norm_squared() > limit * limit {
            return None;
        }
        let own = self.to_own * away;
        let nearest = Vec3::from_fn(|i, _| own[i].clamp(-half[i], half[i]));
        Some((self.to_own.tr_mul(&(nearest - own)), radius))
    }

    /// How far from its centre a point is so many radii away at most.
    pub(super) fn limit(&self, far: f32) -> f32 {
        self.reach + far * self.axis().1
    }

    /// Half of the axis along each side, and the radius around it.
    fn axis(&self) -> (Vec3, f32) {
        match &self.form {
            Form::Box(half) | Form::Ellipsoid(half) | Form::Hull(half, _) => {
                (half * 0.6, half.min())
            }
            Form::Ball(radius) => (Vec3::zeros(), *radius),
            Form::Capsule(radius, half) | Form::Cylinder(radius, half) => {
                (*half * Vec3::z(), *radius)
            }
        }
    }

    /// How far along a ray from outside the surface is first met, and its normal there.
    pub(super) fn meet(&self, from: Vec3, to: Vec3) -> Option<(f32, Vec3)> {
        let o = self.to_own * (from - self.centre);
        let d = self.to_own * to;
        let (t, normal) = match &self.form {
            Form::Box(half) => meet_box(o, d, *half),
            Form::Ball(radius) => meet_ball(o, d, *radius),
            Form::Capsule(radius, half) => meet_capsule(o, d, *radius, *half),
            Form::Cylinder(radius, half) => meet_cylinder(o, d, *radius, *half),
            Form::Ellipsoid(radii) => meet_ellipsoid(o, d, radii),
            Form::Hull(_, sides) => meet_hull(o, d, sides),
        }?;
        Some((t, self.to_own.tr_mul(&normal)))
    }
}

/// Around its centre, along the axes of its frame; with its reach.
fn hull(hull: &Hull) -> (Form, f32) {
    let centre = hull.centre_m();
    let mut half = Vector3::zeros();
    let mut reach: f64 = 0.0;
    for point in hull.points_m() {
        let away = point - centre;
        half = half.sup(&away.abs());
        reach = reach.max(away.norm());
    }
    let side = |[a, b, c]: [Point3<f64>; 3]| {
        let normal = (b - a).cross(&(c - a)).normalize();
        (normal.cast(), normal.dot(&(a - centre)) as f32)
    };
    (Form::Hull(half.cast(), hull.facets_m().map(side).collect()), reach as f32)
}

fn meet_ball(o: Vec3, d: Vec3, radius: f32) -> Option<(f32, Vec3)> {
    let b = o.dot(&d);
    // From the point nearest to the centre, which is better conditioned than b² - |o|² + r².
    let beside = o - b * d;
    let h = radius * radius - beside.norm_squared();
    let t = -b - (h >= 0.0).then(|| h.sqrt())?;
    (t > 0.0).then(|| (t, (o + t * d) / radius))
}

/// The side alone, endless along z.
fn meet_side(o: Vec3, d: Vec3, radius: f32) -> Option<f32> {
    let a = d.x * d.x + d.y * d.y;
    if a < 1e-12 {
        return None;
    }
    let b = o.x * d.x + o.y * d.y;
    let across = o.x * d.y - o.y * d.x;
    let h = radius * radius * a - across * across;
    let t = (-b - (h >= 0.0).then(|| h.sqrt())?) / a;
    (t > 0.0).then_some(t)
}

fn meet_capsule(o: Vec3, d: Vec3, radius: f32, half: f32) -> Option<(f32, Vec3)> {
    let side = meet_side(o, d, radius).map(|t| (t, o + t * d));
    if let Some((t, at)) = side.filter(|(_, at)| at.z.abs() <= half) {
        return Some((t, Vec3::new(at.x, at.y, 0.0) / radius));
    }
    let end = |z: f32| meet_ball(o - z * Vec3::z(), d, radius);
    match (end(half), end(-half)) {
        (Some(upper), Some(lower)) => Some(if upper.0 < lower.0 { upper } else { lower }),
        (upper, lower) => upper.or(lower),
    }
}

fn meet_cylinder(o: Vec3, d: Vec3, radius: f32, half: f32) -> Option<(f32, Vec3)> {
    let side = meet_side(o, d, radius).map(|t| (t, o + t * d));
    if let Some((t, at)) = side.filter(|(_, at)| at.z.abs() <= half) {
        return Some((t, Vec3::new(at.x, at.y, 0.0) / radius));
    }
    // The lid that the ray comes from.
    let z = if d.z < 0.0 { half } else { -half };
    let t = (z - o.z) / d.z;
    let at = o + t * d;
    let meets = t > 0.0 && at.x * at.x + at.y * at.y <= radius * radius;
    meets.then(|| (t, z.signum() * Vec3::z()))
}

fn meet_box(o: Vec3, d: Vec3, half: Vec3) -> Option<(f32, Vec3)> {
    let (mut enter, mut leave, mut normal) = (f32::NEG_INFINITY, f32::INFINITY, Vec3::zeros());
    for i in 0..3 {
        // A ray along the slab divides by 0, and both ends are infinite: within or never.
        let (near, far) =
            ((-half[i] * d[i].signum() - o[i]) / d[i], (half[i] * d[i].signum() - o[i]) / d[i]);
        if near > enter {
            enter = near;
            normal = Vec3::zeros();
            normal[i] = -d[i].signum();
        }
        leave = leave.min(far);
    }
    (enter <= leave && enter > 0.0).then_some((enter, normal))
}

fn meet_ellipsoid(o: Vec3, d: Vec3, radii: &Vec3) -> Option<(f32, Vec3)> {
    let along = d.component_div(radii);
    let length = along.norm();
    let (t, normal) = meet_ball(o.component_div(radii), along / length, 1.0)?;
    Some((t / length, normal.component_div(radii).normalize()))
}

fn meet_hull(o: Vec3, d: Vec3, sides: &[(Vec3, f32)]) -> Option<(f32, Vec3)> {
    let (mut enter, mut leave, mut first) = (f32::NEG_INFINITY, f32::INFINITY, Vec3::zeros());
    for (normal, distance) in sides {
        let (towards, height) = (normal.dot(&d), normal.dot(&o) - distance);
        let t = -height / towards;
        if towards < 0.0 {
            if t > enter {
                (enter, first) = (t, *normal);
            }
        } else if towards > 0.0 {
            leave = leave.min(t);
        } else if height > 0.0 {
            return None;
        }
    }
    (enter <= leave && enter > 0.0).then_some((enter, first))
}
