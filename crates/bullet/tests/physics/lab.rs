//! Worlds to experiment in, and how to look at them.

use bullet::{
    Body, BodyId, BodyState, Contact, JointId, JointState, SCALAR_BYTES, Shape, ShapeId, World,
    WorldSettings,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// Distance of 1 from the next number, in Bullet's precision.
pub(crate) const EPS: f64 = if SCALAR_BYTES == 8 { f64::EPSILON } else { f32::EPSILON as f64 };
pub(crate) const G: f64 = 9.81;

pub(crate) fn world(gravity: Vector3<f64>, time_step: f64) -> World {
    World::new(&WorldSettings { gravity, time_step, ..WorldSettings::default() }).unwrap()
}

pub(crate) fn weightless(time_step: f64) -> World {
    world(Vector3::zeros(), time_step)
}

/// On the usual ground, z = 0, under the usual gravity.
pub(crate) fn grounded(time_step: f64, ground: impl FnOnce(ShapeId) -> Body) -> (World, BodyId) {
    let mut world = world(-G * Vector3::z(), time_step);
    let plane = world.add_shape(&Shape::ground()).unwrap();
    let id = world.add_body(&ground(plane)).unwrap();
    (world, id)
}

pub(crate) fn still_ground(plane: ShapeId) -> Body {
    Body::fixed(plane, Isometry3::identity())
}

pub(crate) fn cuboid(world: &mut World, x: f64, y: f64, z: f64) -> ShapeId {
    world.add_shape(&Shape::Box { half_extents: Vector3::new(x, y, z) }).unwrap()
}

pub(crate) fn ball(world: &mut World, radius: f64) -> ShapeId {
    world.add_shape(&Shape::Sphere { radius }).unwrap()
}

pub(crate) fn at(x: f64, y: f64, z: f64) -> Isometry3<f64> {
    Isometry3::translation(x, y, z)
}

/// A pose with nothing special about it.
pub(crate) fn askew() -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::new(0.3, -0.7, 1.1),
        UnitQuaternion::from_euler_angles(0.4, -0.9, 2.1),
    )
}

pub(crate) fn steps(world: &mut World, count: u32) {
    for _ in 0..count {
        world.step().unwrap();
    }
}

pub(crate) fn see(world: &World, id: BodyId) -> BodyState {
    let mut bodies = Vec::new();
    world.read_bodies(&mut bodies).unwrap();
    bodies[id.index()]
}

pub(crate) fn joint_of(world: &World, id: JointId) -> JointState {
    let mut joints = Vec::new();
    world.read_joints(&mut joints).unwrap();
    joints[id.index()]
}

pub(crate) fn contacts(world: &World) -> Vec<Contact> {
    let mut contacts = Vec::new();
    world.read_contacts(&mut contacts).unwrap();
    contacts
}

pub(crate) fn position(world: &World, id: BodyId) -> Vector3<f64> {
    see(world, id).position.into()
}

pub(crate) fn velocity(world: &World, id: BodyId) -> Vector3<f64> {
    see(world, id).linear_velocity.into()
}

pub(crate) fn spin(world: &World, id: BodyId) -> Vector3<f64> {
    see(world, id).angular_velocity.into()
}

#[track_caller]
pub(crate) fn assert_near(what: &str, got: f64, expected: f64, tolerance: f64) {
    assert!(
        (got - expected).abs() <= tolerance,
        "{what}: {got} is {:e} from {expected}, more than {tolerance:e}",
        got - expected
    );
}

#[track_caller]
pub(crate) fn assert_all_near(
    what: &str,
    got: Vector3<f64>,
    expected: Vector3<f64>,
    tolerance: f64,
) {
    for i in 0..3 {
        assert_near(&format!("{what}, component {i}"), got[i], expected[i], tolerance);
    }
}

/// Time between the first and the last upward zero of samples taken every `dt`, over the periods
/// between them.
pub(crate) fn period(samples: &[f64], dt: f64) -> f64 {
    let zeros: Vec<f64> = samples
        .windows(2)
        .enumerate()
        .filter(|(_, pair)| pair[0] < 0.0 && pair[1] >= 0.0)
        .map(|(i, pair)| (i as f64 + pair[0] / (pair[0] - pair[1])) * dt)
        .collect();
    assert!(zeros.len() > 1, "fewer than two upward zeros in {} samples", samples.len());
    (zeros[zeros.len() - 1] - zeros[0]) / (zeros.len() - 1) as f64
}
