//! Safe Rust over [Bullet](https://pybullet.org), the physics library, as Debian ships it.
//!
//! A [`World`] holds shapes, bodies and joints and steps them. Everything is an id and a buffer
//! that the caller keeps; there are no callbacks and no shared state between worlds.
//!
//! ```
//! use bullet::{Body, Shape, World, WorldSettings};
//! use nalgebra::Isometry3;
//!
//! let mut world = World::new(&WorldSettings::default())?;
//! let ground = world.add_shape(&Shape::ground())?;
//! let ball = world.add_shape(&Shape::Sphere { radius: 0.1 })?;
//! world.add_body(&Body::fixed(ground, Isometry3::identity()))?;
//! let ball = world.add_body(&Body::dynamic(ball, 1.0, Isometry3::translation(0.0, 0.0, 1.0)))?;
//!
//! let mut bodies = Vec::new();
//! for _ in 0..300 {
//!     world.step()?;
//! }
//! world.read_bodies(&mut bodies)?;
//! assert!((bodies[ball.index()].position[2] - 0.1).abs() < 1e-3, "it lies on the ground");
//! # Ok::<(), bullet::Error>(())
//! ```
//!
//! # Conventions
//! SI units, radians, right-handed rotations, world coordinates unless a name says otherwise;
//! joints as [`joint`] tells. Numbers are `f64` here and become Bullet's `btScalar` in the shim:
//! `f32`, or `f64` with the cargo feature `float64`, which links Bullet's double-precision
//! libraries instead.
//!
//! # Promises
//! - The trajectory is Bullet's own, bit for bit (`tests/fidelity.rs`).
//! - The same calls give the same bits, whatever else the program does (`tests/determinism.rs`): on
//!   one build of Bullet and one glibc, and in double precision on CPUs that agree on FMA and AVX2,
//!   since glibc chooses its `sin`, `atan2` and their like by them.
//! - A restored [`World::snapshot`] continues with the same bits (`tests/snapshot.rs`).
//! - No argument, however wrong, panics, corrupts or ends the process (`tests/refusals/`,
//!   `tests/fuzz/`).

mod body;
mod bridge;
mod constants;
mod error;
pub mod joint;
mod lockstep;
mod settings;
mod shape;
mod snapshot;
mod world;

use bridge::ffi;

pub use body::{Body, CollisionFilter, Motion, Push};
pub use error::Error;
pub use ffi::{
    BodyId, BodyState, Contact, JointId, JointState, LockstepCounts, LockstepTimes, MotorState,
    ShapeId,
};
pub use joint::{Axis, AxisSettings, Joint, JointKind, Motor, MotorCommand, Range, Spring, Stop};
pub use lockstep::{INSTRUCTIONS_VARIABLE, Instructions, Lockstep};
pub use settings::{SolverMode, WorldSettings};
pub use shape::{Lengthwise, Shape};
pub use snapshot::SnapshotError;
pub use world::World;

/// Version of the Bullet headers that the crate was built with, 324 for 3.24.
pub const BULLET_VERSION: u32 = constants::BT_BULLET_VERSION;

/// Bytes of a `btScalar`: 4, or 8 with the feature `float64`.
pub const SCALAR_BYTES: usize = constants::SCALAR_BYTES as usize;

/// The README's example is compiled with the others.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
