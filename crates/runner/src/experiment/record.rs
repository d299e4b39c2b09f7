//! The tables `record` and `checkpoint`: what is kept of a cell, and when it's saved.

use config::{Section, count};
use serde::Serialize;

/// What is kept of the last control steps, for replay and rasters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordSettings {
    /// Control steps that are kept, 0 to 1,000,000; 600.
    pub steps: u64,
    /// Physics steps from one pose to the next, within a control step; 2.
    pub pose_every: u64,
}

impl RecordSettings {
    /// `steps`: physics steps in a control step, where that's known.
    pub(super) fn read(section: &mut Section<'_>, physics_steps: Option<u64>) -> Option<Self> {
        let steps = section.or("steps", count(0, 1_000_000), 600);
        let default = physics_steps.unwrap_or(2).min(2);
        let pose_every = section.given_or("pose_every", count(1, 1_000_000), default)?;
        if let Some(most) = physics_steps
            && pose_every > most
        {
            let expected = format!("at most the {most} physics steps of a control step");
            section.refuse("pose_every", &expected, pose_every);
        }
        Some(Self { steps, pose_every })
    }
}

/// When all that a cell needs to go on is saved.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CheckpointSettings {
    /// Updates from one checkpoint to the next, 1 to 10^9; 100.
    pub every: u64,
}

impl CheckpointSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        Some(Self { every: section.or("every", count(1, 1_000_000_000), 100) })
    }
}
