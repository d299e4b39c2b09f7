//! Who steps the worlds: Bullet alone, one after the other, or lanes, all at once. The bits are the
//! same.

use std::time::{Duration, Instant};

use bullet::{Instructions, Lockstep, LockstepCounts, LockstepTimes, World};

/// The solver that steps worlds, some of them together.
#[derive(Debug)]
pub struct Solver {
    lanes: Option<Lockstep>,
    /// Spent in physics steps, for `itarl bench`; no result knows it.
    time: Duration,
}

impl Solver {
    /// Bullet's own solver.
    #[must_use]
    pub fn bullet() -> Self {
        Self { lanes: None, time: Duration::ZERO }
    }

    /// Worlds in the lanes of the processor's vectors.
    ///
    /// # Errors
    /// Instructions that the environment asks for and the processor doesn't have.
    pub fn lockstep() -> Result<Self, bullet::Error> {
        Ok(Self { lanes: Some(Lockstep::new()?), time: Duration::ZERO })
    }

    /// How many worlds are best stepped at a time.
    #[must_use]
    pub fn lanes(&self) -> usize {
        self.lanes.as_ref().map_or(1, |lockstep| lockstep.instructions().lanes())
    }

    /// The vector instructions, if it's in lanes.
    #[must_use]
    pub fn instructions(&self) -> Option<Instructions> {
        self.lanes.as_ref().map(Lockstep::instructions)
    }

    /// A step of each world. Worlds in lanes must be built alike: all are refused if they aren't.
    pub(super) fn step(&mut self, worlds: &mut [&mut World]) -> Vec<Result<(), bullet::Error>> {
        match &mut self.lanes {
            None => worlds.iter_mut().map(|world| world.step()).collect(),
            Some(lockstep) => {
                let mut results = Vec::new();
                match lockstep.step(worlds, &mut results) {
                    Ok(()) => results,
                    Err(error) => worlds.iter().map(|_| Err(error.clone())).collect(),
                }
            }
        }
    }

    /// Counts a physics step, servo law included, as begun then.
    pub(super) fn spent_since(&mut self, start: Instant) {
        self.time += start.elapsed();
    }

    /// Spent in physics steps so far, servo law included.
    #[must_use]
    pub fn time(&self) -> Duration {
        self.time
    }

    /// Where it went without the servo law, in lanes.
    #[must_use]
    pub fn times(&self) -> LockstepTimes {
        self.lanes.as_ref().map(Lockstep::times).unwrap_or_default()
    }

    /// What became of all steps in lanes.
    #[must_use]
    pub fn counts(&self) -> LockstepCounts {
        self.lanes.as_ref().map(Lockstep::counts).unwrap_or_default()
    }
}
