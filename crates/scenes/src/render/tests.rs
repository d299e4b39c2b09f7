//! The ray caster against geometry worked out by hand.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use svenja::{Rod, Shape};

use super::*;

const RED: [u8; 3] = [255, 0, 0];
const BLUE: [u8; 3] = [0, 0, 255];
const WHITE: [u8; 3] = [255; 3];

fn ball(radius_m: f64, at: [f64; 3], colour: [u8; 3]) -> Solid {
    let pose = Isometry3::translation(at[0], at[1], at[2]);
    Solid::new(&Shape::Sphere { radius_m }, &pose, colour, 0.0)
}

fn scene(solids: Vec<Solid>) -> Scene {
    Scene { solids, ground: None, sky: WHITE }
}

/// From 5 m ahead, 400 x 300 pixels.
fn ahead(degrees: f64) -> Camera {
    let (eye, target) = (Point3::new(0.0, 5.0, 0.0), Point3::origin());
    Camera::perspective(eye, target, degrees, [400, 300])
}

/// Which pixels aren't sky.
fn covered(picture: &Picture) -> Vec<bool> {
    picture.pixels().iter().map(|pixel| *pixel != WHITE).collect()
}

/// A ball of radius r at distance d fills a cone of half angle a, sin a = r/d; in a picture of height
/// h over an angle of 2 b it's a disc of radius h/2 tan a / tan b.
#[test]
fn a_ball_is_a_disc_of_the_right_radius() {
    for radius in [0.3, 1.0, 1.5] {
        let picture = scene(vec![ball(radius, [0.0; 3], RED)]).picture(&ahead(50.0));
        let tangent = radius / (25.0_f64 - radius * radius).sqrt();
        let expected = 150.0 * tangent / 25.0_f64.to_radians().tan();
        for (i, covered) in covered(&picture).into_iter().enumerate() {
            let (x, y) = ((i % 400) as f64 + 0.5 - 200.0, (i / 400) as f64 + 0.5 - 150.0);
            let away = (x * x + y * y).sqrt();
            // A pixel reaches 0.71 from its middle.
            if (away - expected).abs() > 0.71 {
                assert_eq!(covered, away < expected, "r {radius}: {x}, {y} of {expected}");
            }
        }
    }
}

/// Without perspective, 2 m over 300 pixels are 150 pixels a metre, wherever it is.
#[test]
fn without_perspective_a_metre_is_a_metre() {
    let eye = Point3::new(4.0, 0.0, 0.0);
    let camera = Camera::parallel(eye, Point3::origin(), 2.0, [400, 300]);
    let half_extents_m = Vector3::new(0.1, 0.4, 0.2);
    for x in [-3.0, 2.0] {
        let pose = Isometry3::translation(x, 0.2, 0.1);
        let solid = Solid::new(&Shape::Box { half_extents_m }, &pose, RED, 0.0);
        let covered = covered(&scene(vec![solid]).picture(&camera));
        // y is to the right: -0.2 to 0.6 of it; z is up: -0.1 to 0.3.
        for (i, covered) in covered.into_iter().enumerate() {
            let (x, y) = (i % 400, i / 400);
            assert_eq!(covered, (170..290).contains(&x) && (105..165).contains(&y), "{x}, {y}");
        }
    }
}

#[test]
fn what_is_nearer_hides_what_is_farther() {
    let near = ball(0.2, [0.0, 2.0, 0.0], RED);
    let far = ball(1.0, [0.0, -2.0, 0.0], BLUE);
    for solids in [vec![near.clone(), far.clone()], vec![far, near]] {
        let picture = scene(solids).picture(&ahead(50.0));
        let [red, _, blue] = picture.pixels()[150 * 400 + 200];
        assert!(red > 60 && blue < red / 4, "{red} {blue}");
        // Beside the nearer one, within the farther one: 0.18 of 7 m, 45 pixels.
        let [red, _, blue] = picture.pixels()[150 * 400 + 240];
        assert!(blue > 60 && red < blue / 4, "{red} {blue}");
    }
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    let ground = Ground::new([0.0, 0.0], 6.0, [2.0, 2.0], [0.0, 1.0]).unwrap();
    let solids = vec![ball(0.5, [0.3, 0.0, 0.5], RED), ball(0.2, [-0.7, 0.1, 0.2], BLUE)];
    let scene = Scene { solids, ground: Some(ground), sky: SKY };
    let eye = Point3::new(2.0, 5.0, 2.0);
    let camera = Camera::perspective(eye, Point3::origin(), 40.0, [161, 97]);
    let first = scene.picture(&camera);
    assert_eq!(first, scene.picture(&camera));
    assert_eq!(first.png().unwrap(), scene.picture(&camera).png().unwrap());
}

/// The sun stands at (-0.43, -0.3, 0.85): the shadow of a ball at height z lies at z/0.85 times
/// (0.43, 0.3) from below it.
#[test]
fn shadows_fall_away_from_the_sun() {
    let ground = Ground::plain([0.0, 0.0], 10.0);
    let solids = vec![ball(0.3, [0.0, 0.0, 1.7], RED)];
    let scene = Scene { solids, ground: Some(ground), sky: WHITE };
    // From above, 100 pixels a metre; y is to the right, -x is up.
    let camera = Camera::parallel(Point3::new(0.0, 0.0, 9.0), Point3::origin(), 4.0, [400, 400]);
    let picture = scene.picture(&camera);
    let value = |x: f64, y: f64| {
        let (column, row) = (200.0 + 100.0 * y, 200.0 + 100.0 * x);
        picture.pixels()[row as usize * 400 + column as usize][1]
    };
    // Off the lines of the grid.
    assert!(value(0.86, 0.61) + 60 < value(0.86, -0.61), "{}", value(0.86, 0.61));
    assert!(value(-0.86, -0.61).abs_diff(value(0.86, -0.61)) < 12);
}

/// The nearest point of a surface, from a fine grid of its points: an oracle that knows no roots.
#[test]
fn rays_meet_surfaces_where_they_are() {
    let rod = Rod {
        radius_m: 0.2,
        from_m: Point3::new(-0.3, 0.1, -0.2),
        to_m: Point3::new(0.4, 0.3, 0.5),
    };
    let turn = UnitQuaternion::from_euler_angles(0.3, -0.8, 1.9);
    let pose = Isometry3::from_parts(Vector3::new(0.2, -0.1, 0.4).into(), turn);
    let shapes = [
        Shape::Box { half_extents_m: Vector3::new(0.3, 0.5, 0.2) },
        Shape::Sphere { radius_m: 0.4 },
        Shape::Capsule(rod.clone()),
        Shape::Cylinder(rod),
        Shape::Ellipsoid { radii_m: Vector3::new(0.3, 0.5, 0.2) },
        Shape::Hull(crate::example::pyramid()),
    ];
    for shape in shapes {
        let solid = Solid::new(&shape, &pose, RED, 0.0);
        let mut hits = 0;
        for i in 0..400 {
            let [a, b] = disc(i, 400);
            let from = Vec3::new(3.0 * a, 3.0 * b, 2.5 - 0.01 * i as f32);
            let to = (Vec3::new(0.2, -0.1, 0.4) + 0.3 * Vec3::new(b, a, a * b) - from).normalize();
            let steps = (0..20_000).map(|step| step as f32 * 3e-4);
            let inside = |t: f32| depth(&shape, &pose, from + t * to) > 0.0;
            let marched = steps.into_iter().find(|&t| inside(t));
            let met = solid.meet(from, to);
            match (marched, met) {
                (Some(marched), Some((t, normal))) => {
                    hits += 1;
                    assert!((t - marched).abs() < 4e-4, "{shape:?}: {t}, {marched}");
                    assert!((normal.norm() - 1.0).abs() < 1e-3 && normal.dot(&to) < 1e-3);
                    // Outwards: a little along it there's less depth.
                    let at = from + t * to;
                    assert!(depth(&shape, &pose, at + 0.01 * normal) < 0.0, "{shape:?}");
                    assert!(solid.near_ray(from, to, 0.0));
                }
                (None, None) => {}
                // Grazing: it's in for less than a step.
                (marched, met) => {
                    let t = marched.or(met.map(|(t, _)| t)).unwrap();
                    assert!(depth(&shape, &pose, from + t * to).abs() < 2e-3, "{shape:?}");
                }
            }
        }
        assert!(hits > 100, "{shape:?}: {hits}");
    }
}

/// How deep a point is in a shape, in m; negative outside.
fn depth(shape: &Shape, pose: &Isometry3<f64>, at: Vec3) -> f64 {
    let at = pose.inverse_transform_point(&Point3::from(at.cast::<f64>()));
    let beside = |rod: &Rod| {
        let axis = rod.to_m - rod.from_m;
        let share = (at - rod.from_m).dot(&axis) / axis.norm_squared();
        let near = |share: f64| (at - (rod.from_m + share * axis)).norm();
        (share, near(share), near(share.clamp(0.0, 1.0)), axis.norm())
    };
    match shape {
        Shape::Box { half_extents_m } => (half_extents_m - at.coords.abs()).min(),
        Shape::Sphere { radius_m } => radius_m - at.coords.norm(),
        Shape::Capsule(rod) => rod.radius_m - beside(rod).2,
        Shape::Cylinder(rod) => {
            let (share, across, _, length) = beside(rod);
            (rod.radius_m - across).min(length * share.min(1.0 - share))
        }
        // Along the line from the centre, which is never less than how deep it is.
        Shape::Ellipsoid { radii_m } => {
            let share = at.coords.component_div(radii_m).norm();
            at.coords.norm() * (1.0 / share - 1.0)
        }
        Shape::Hull(hull) => {
            let depth =
                |[a, b, c]: [Point3<f64>; 3]| -(b - a).cross(&(c - a)).normalize().dot(&(at - a));
            hull.facets_m().map(depth).fold(f64::INFINITY, f64::min)
        }
    }
}

#[test]
fn bytes_of_light_are_those_of_the_curve() {
    for byte in 0..=255 {
        assert_eq!(picture::encoded(picture::decoded([byte, 0, 255])), [byte, 0, 255]);
    }
    // Half of the light is 188 of 255: any table of sRGB.
    assert_eq!(picture::encoded(Light::repeat(0.5)), [188; 3]);
    assert_eq!(picture::encoded(Light::new(-1.0, 2.0, f32::NAN))[..2], [0, 255]);
}
