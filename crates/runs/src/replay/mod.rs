//! The last control steps as they were, for replay and rasters: kept in a ring of fixed size while
//! a cell runs, written as safetensors.

mod packing;
mod recording;
mod ring;

pub use packing::Packing;
pub(super) use recording::ENTRY;
pub use recording::{Recording, TENSORS};
pub use ring::{Ring, Step};

use serde::{Deserialize, Serialize};

use super::Error;

/// Numbers of a pose: x y z, then the orientation as a quaternion x y z w.
pub(super) const POSE: usize = 7;

/// What a recorded control step consists of, and at which times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordingLayout {
    /// Names of the actuators.
    pub actuators: Vec<String>,
    /// Names of the bodies.
    pub bodies: Vec<String>,
    /// Frames of poses in a control step; the last one is at its end.
    pub frames_per_step: usize,
    /// Simulated seconds from one frame to the next.
    pub seconds_per_frame: f64,
    /// Names of the sensors.
    pub sensors: Vec<String>,
    /// Names of the reward terms.
    pub terms: Vec<String>,
}

impl RecordingLayout {
    /// Numbers of one control step in each tensor, in the order of [`TENSORS`]; none if it's more
    /// than there is memory for.
    fn widths(&self) -> Option<[usize; 5]> {
        let poses = self.frames_per_step.checked_mul(self.bodies.len())?.checked_mul(POSE)?;
        let [sensors, actuators] = [self.sensors.len(), self.actuators.len()];
        Some([poses, sensors, actuators, self.bodies.len(), self.terms.len()])
    }
}
