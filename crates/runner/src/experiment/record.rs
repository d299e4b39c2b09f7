//! The tables `record` and `checkpoint`: what is kept of a cell, and when it's saved.

use config::{Rule, Section, count};
use serde::Serialize;

/// What is kept of the last control steps, for replay and rasters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordSettings {
    /// Control steps that are kept.
    pub steps: u64,
    /// Physics steps from one pose to the next, within a control step.
    pub pose_every: u64,
}

impl RecordSettings {
    /// `steps`: physics steps in a control step, where that's known.
    pub(super) fn read(section: &mut Section<'_>, physics_steps: Option<u64>) -> Option<Self> {
        let steps = count(0, 1_000_000).about(
            "last control steps of a cell that are recorded for replay and rasters; 0: none, and a \
             report has neither",
        );
        let steps = section.or("steps", steps, 600);
        let pose_every = count(1, 1_000_000)
            .about(
                "physics steps from one recorded pose to the next, within a control step; by default \
                 1 if a control step has only one",
            )
            .condition("at most the physics steps of a control step");
        let default = physics_steps.unwrap_or(2).min(2);
        let pose_every = section.given_or("pose_every", pose_every, default)?;
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
    /// Updates from one checkpoint to the next.
    pub every: u64,
}

impl CheckpointSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let every = count(1, 1_000_000_000).about("updates from one checkpoint to the next");
        Some(Self { every: section.or("every", every, 100) })
    }
}
