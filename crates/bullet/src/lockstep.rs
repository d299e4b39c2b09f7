//! Worlds that step together, one in each lane of the processor's vectors.
//!
//! Most of a step is the solver's loop over rows, each of which waits for the one before it. Worlds
//! that are built alike have the same rows, so one loop can do them for many worlds at once; and so
//! with finding contacts, making rows, and moving bodies.
//! Each world's trajectory has, bit for bit, what [`World::step`] gives it alone: lanes do the same
//! operations in the same order, and a step that lanes don't cover is left to Bullet's own loop.
//! `cpp/lockstep/` has the reasoning, file by file; ARCHITECTURE.md the picture.

use std::{env, str::FromStr};

use cxx::UniquePtr;

use crate::{Error, LockstepCounts, LockstepTimes, World, bridge, bridge::ffi};

/// Overrides what [`Lockstep::new`] chooses: `plain`, `avx2` or `avx512`.
pub const INSTRUCTIONS_VARIABLE: &str = "ITARL_INSTRUCTIONS";

/// Vector instructions. The bits are the same with all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Instructions {
    /// What every processor of the target has: SSE2 on x86-64.
    Plain,
    /// 256 bits a vector, with AVX2.
    Avx2,
    /// 512 bits a vector, with AVX-512 F.
    Avx512,
}

impl Instructions {
    /// From the narrowest to the widest.
    pub const ALL: [Self; 3] = [Self::Plain, Self::Avx2, Self::Avx512];

    /// Whether this processor has them.
    pub fn are_available(self) -> bool {
        ffi::has_instructions(self as u8)
    }

    /// The widest that this processor has.
    pub fn best() -> Self {
        Self::ALL.into_iter().rev().find(|it| it.are_available()).unwrap_or(Self::Plain)
    }

    /// How many worlds one sweep takes, in Bullet's precision.
    pub fn lanes(self) -> usize {
        ffi::lanes_of(self as u8)
    }

    /// The name that [`INSTRUCTIONS_VARIABLE`] has for them.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }
}

impl FromStr for Instructions {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        let found = Self::ALL.into_iter().find(|it| it.name() == name);
        found.ok_or_else(|| refusal("plain, avx2 or avx512", name))
    }
}

fn refusal(expected: &str, value: &str) -> Error {
    Error::Argument {
        call: "Lockstep::new".into(),
        argument: INSTRUCTIONS_VARIABLE.into(),
        expected: expected.into(),
        value: format!("{value:?}"),
    }
}

/// Steps worlds together.
///
/// From step to step it keeps memory, the order of rows, and copies of what joints are made of, which
/// it makes anew once a world's bodies or joints change. Worlds whose steps lanes can make from end to
/// end live in lanes in between, and each holds on to its own lane: any world may leave or join
/// between steps, and outlive the `Lockstep`.
///
/// ```
/// use bullet::{Body, Lockstep, Shape, World, WorldSettings};
/// use nalgebra::Isometry3;
/// let mut worlds = Vec::new();
/// for i in 0..5 {
///     let mut world = World::new(&WorldSettings::default())?;
///     let ball = world.add_shape(&Shape::Sphere { radius: 0.1 })?;
///     world.add_body(&Body::dynamic(ball, 1.0, Isometry3::translation(0.0, 0.0, f64::from(i))))?;
///     worlds.push(world);
/// }
/// let mut lockstep = Lockstep::new()?;
/// let mut results = Vec::new();
/// let mut together: Vec<&mut World> = worlds.iter_mut().collect();
/// lockstep.step(&mut together, &mut results)?;
/// assert!(results.iter().all(Result::is_ok));
/// # Ok::<(), bullet::Error>(())
/// ```
pub struct Lockstep {
    inner: UniquePtr<ffi::Lockstep>,
    instructions: Instructions,
}

impl Lockstep {
    /// With the widest instructions that the processor has, or those that
    /// [`INSTRUCTIONS_VARIABLE`] names.
    ///
    /// # Errors
    /// [`Error::Argument`] if the variable names none, or some that the processor doesn't have.
    pub fn new() -> Result<Self, Error> {
        match env::var_os(INSTRUCTIONS_VARIABLE) {
            Some(name) => Self::with(name.to_string_lossy().parse()?),
            None => Self::with(Instructions::best()),
        }
    }

    /// With given instructions.
    ///
    /// # Errors
    /// [`Error::Argument`] if the processor doesn't have them.
    pub fn with(instructions: Instructions) -> Result<Self, Error> {
        Ok(Self { inner: ffi::new_lockstep(instructions as u8)?, instructions })
    }

    /// The vector instructions that the sweeps use.
    pub fn instructions(&self) -> Instructions {
        self.instructions
    }

    /// Makes one step of each world, as [`World::step`] does; `results[i]` becomes what that would
    /// return for `worlds[i]`. What becomes of one world doesn't touch the others. A part of the
    /// lanes costs the same as all: [`Instructions::lanes`] worlds, or fewer, go best together.
    ///
    /// # Errors
    /// [`Error::Argument`] if the worlds don't match: they need the same number of iterations, the
    /// same solver mode, and the same bodies and joints, as far as rows depend on them. Masses,
    /// shapes, poses, limits may differ. No world is stepped then. [`Error::Cpp`] if memory runs out:
    /// worlds that were left in the middle of the step refuse to go on until they're restored.
    pub fn step(
        &mut self,
        worlds: &mut [&mut World],
        results: &mut Vec<Result<(), Error>>,
    ) -> Result<(), Error> {
        results.clear();
        let lockstep = self.inner.pin_mut();
        bridge::step_together(lockstep, worlds.iter_mut().map(|world| world.inner_mut()))?;
        results.extend((0..worlds.len()).map(|i| Ok(self.inner.result(i)?)));
        Ok(())
    }

    /// What became of all steps so far.
    pub fn counts(&self) -> LockstepCounts {
        self.inner.counts()
    }

    /// Where the time of all steps so far went; for benchmarks, no result depends on it.
    pub fn times(&self) -> LockstepTimes {
        self.inner.times()
    }
}

impl std::fmt::Debug for Lockstep {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("Lockstep")
            .field("instructions", &self.instructions)
            .field("counts", &self.counts())
            .finish_non_exhaustive()
    }
}
