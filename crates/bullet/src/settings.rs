//! What holds for a whole world: gravity, time step, and how the solver works.

use std::ops::{BitOr, Sub};

use nalgebra::Vector3;

use crate::{bridge::ffi, constants};

/// Settings of a [`World`](crate::World), fixed for its life.
///
/// The defaults are Bullet's own, but for gravity (along -z), the time step (100 Hz) and the
/// iterations (200).
///
/// ```
/// use bullet::{SolverMode, World, WorldSettings};
/// let settings = WorldSettings {
///     iterations: 50,
///     solver_mode: SolverMode::default() - SolverMode::WARM_STARTING,
///     ..WorldSettings::default()
/// };
/// let world = World::new(&settings)?;
/// # Ok::<(), bullet::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct WorldSettings {
    /// The acceleration by gravity, in m/s².
    pub gravity: Vector3<f64>,
    /// Length of a step in s, between 1e-6 and 1.
    pub time_step: f64,
    /// Sweeps of the solver over all rows in a step, between 1 and 1,000,000. They stop early only
    /// if a sweep changes nothing at all. Fewer make joints softer, not just less exact.
    pub iterations: u32,
    /// The solver's switches, Bullet's `btSolverMode`.
    pub solver_mode: SolverMode,
    /// Error reduction of joints: the share of a joint's error that a step corrects, 0 to 1.
    pub joint_erp: f64,
    /// Error reduction of contacts, 0 to 1.
    pub contact_erp: f64,
    /// Constraint force mixing of contacts and joints: 0 is rigid, above is softer.
    pub cfm: f64,
    /// Whether deep penetrations are resolved apart from the velocities, so that they don't bounce.
    pub split_impulse: bool,
    /// Contacts deeper than this distance (in m, negative) are split.
    pub split_impulse_threshold: f64,
    /// Whether bodies that hardly moved for 2 s are left out until something touches them.
    pub sleeping: bool,
}

impl Default for WorldSettings {
    fn default() -> Self {
        Self {
            gravity: Vector3::new(0.0, 0.0, -9.81),
            time_step: 0.01,
            iterations: 200,
            solver_mode: SolverMode::default(),
            joint_erp: 0.2,
            contact_erp: 0.2,
            cfm: 0.0,
            split_impulse: true,
            split_impulse_threshold: -0.04,
            sleeping: false,
        }
    }
}

impl WorldSettings {
    pub(crate) fn to_spec(&self) -> ffi::WorldSpec {
        ffi::WorldSpec {
            gravity: self.gravity.into(),
            time_step: self.time_step,
            iterations: self.iterations,
            solver_mode: self.solver_mode.0 as i32,
            joint_erp: self.joint_erp,
            contact_erp: self.contact_erp,
            cfm: self.cfm,
            split_impulse: self.split_impulse,
            split_impulse_threshold: self.split_impulse_threshold,
            sleeping: self.sleeping,
        }
    }
}

/// Switches of Bullet's solver (`btSolverMode`): `|` adds, `-` takes away.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SolverMode(u32);

impl SolverMode {
    /// Contacts begin with the impulses of the step before.
    pub const WARM_STARTING: Self = Self(constants::SOLVER_USE_WARMSTARTING);
    /// Friction along two directions in the contact plane, in place of one along the sliding.
    pub const TWO_FRICTION_DIRECTIONS: Self = Self(constants::SOLVER_USE_2_FRICTION_DIRECTIONS);
    /// A contact keeps its friction direction from step to step.
    pub const CACHED_FRICTION_DIRECTIONS: Self =
        Self(constants::SOLVER_ENABLE_FRICTION_DIRECTION_CACHING);
    /// Friction directions don't follow the sliding velocity.
    pub const FIXED_FRICTION_DIRECTIONS: Self =
        Self(constants::SOLVER_DISABLE_VELOCITY_DEPENDENT_FRICTION_DIRECTION);
    /// Each contact's friction rows come right after it, in place of after all contacts.
    pub const INTERLEAVED_FRICTION: Self =
        Self(constants::SOLVER_INTERLEAVE_CONTACT_AND_FRICTION_CONSTRAINTS);
    /// Rows are swept in a random order, drawn from a seed that snapshots hold.
    pub const RANDOM_ORDER: Self = Self(constants::SOLVER_RANDMIZE_ORDER);
    /// Vector instructions for single rows, where Bullet was built with them. Debian's wasn't.
    pub const SIMD: Self = Self(constants::SOLVER_SIMD);
}

/// Bullet's own default: warm starting and SIMD.
impl Default for SolverMode {
    fn default() -> Self {
        Self::WARM_STARTING | Self::SIMD
    }
}

impl BitOr for SolverMode {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Sub for SolverMode {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }
}
