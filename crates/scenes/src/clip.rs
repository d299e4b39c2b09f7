//! A robot and its motion: the one thing that all ways of showing it start from.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};
use runs::Recording;
use svenja::{Morphology, centre_of_gravity_m};

use crate::Error;

/// Numbers of a pose.
const POSE: usize = 7;

/// A robot and its motion. There is at least one frame, all poses are finite, and the recording's
/// bodies are the model's.
#[derive(Clone, Debug)]
pub struct Clip {
    title: String,
    morphology: Morphology,
    recording: Recording,
    parts: RewardParts,
}

/// What both parts of a reward measure, for whoever reads their values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RewardParts {
    /// What the task measures.
    pub task: Quantity,
    /// The information in the readings; none if none is measured.
    pub information: Option<Quantity>,
}

/// A symbol and its unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// As the paper or the experiment file calls it.
    pub symbol: &'static str,
    /// The unit of a control step's raw value.
    pub unit: &'static str,
}

impl Clip {
    /// A recording of a robot.
    ///
    /// # Errors
    /// [`Error::Recording`]: bodies that aren't the model's, no frames, poses that aren't numbers.
    pub fn new(
        title: String,
        parts: RewardParts,
        morphology: Morphology,
        recording: Recording,
    ) -> Result<Self, Error> {
        let refused = |what| Err(Error::Recording(what));
        let names: Vec<_> = morphology.bodies().iter().map(|body| body.name.as_str()).collect();
        let recorded = &recording.layout.bodies;
        if *recorded != names {
            return refused(format!(
                "the recording has the bodies {recorded:?}, the model has {names:?}"
            ));
        }
        if recording.poses.is_empty() {
            let what = "no control steps were recorded (record.steps is 0, or none was done yet)";
            return refused(what.into());
        }
        let is_pose = |pose: &[f32]| {
            let length: f32 = pose[3..].iter().map(|value| value * value).sum();
            pose.iter().all(|value| value.is_finite()) && length > 0.5
        };
        if let Some(i) = recording.poses.chunks(POSE).position(|pose| !is_pose(pose)) {
            let (frame, body) = (i / names.len(), names[i % names.len()]);
            return refused(format!("frame {frame}: the pose of '{body}' isn't one"));
        }
        Ok(Self { title, morphology, recording, parts })
    }

    /// A title for what the clip shows.
    #[must_use]
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The robot's model.
    #[must_use]
    pub fn morphology(&self) -> &Morphology {
        &self.morphology
    }

    /// The recorded motion.
    #[must_use]
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// What both parts of its reward measure.
    #[must_use]
    pub fn reward_parts(&self) -> RewardParts {
        self.parts
    }

    /// The number of frames of poses.
    #[must_use]
    pub fn n_frames(&self) -> usize {
        self.recording.n_steps * self.recording.layout.frames_per_step
    }

    /// Simulated seconds from the clip's beginning to a frame: the first one is one interval in.
    #[must_use]
    pub fn seconds(&self, frame: usize) -> f64 {
        (frame + 1) as f64 * self.recording.layout.seconds_per_frame
    }

    /// The frame that shows a moment, in simulated seconds from the clip's beginning.
    #[must_use]
    pub fn frame_at(&self, seconds: f64) -> usize {
        let frame = (seconds / self.recording.layout.seconds_per_frame).round() as usize;
        frame.saturating_sub(1).min(self.n_frames() - 1)
    }

    /// The pose of a body's centre of mass in a frame.
    #[must_use]
    pub fn pose(&self, frame: usize, body: usize) -> Isometry3<f64> {
        let n_bodies = self.morphology.bodies().len();
        let pose = &self.recording.poses[(frame * n_bodies + body) * POSE..][..POSE];
        let [x, y, z, qx, qy, qz, qw] = std::array::from_fn(|i| f64::from(pose[i]));
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(qw, qx, qy, qz));
        Isometry3::from_parts(Translation3::new(x, y, z), rotation)
    }

    /// The centre of gravity of all bodies, in m.
    #[must_use]
    pub fn centre_of_gravity(&self, frame: usize) -> Point3<f64> {
        let bodies = self.morphology.bodies().iter().enumerate();
        centre_of_gravity_m(
            bodies.map(|(i, body)| (body.mass_kg, self.pose(frame, i).translation.vector)),
        )
    }

    /// How far the robot reaches from its centre of gravity in the first frame, in m; at least 0.1.
    #[must_use]
    pub fn reach_m(&self) -> f64 {
        let centre = self.centre_of_gravity(0);
        let bodies = self.morphology.bodies().iter().enumerate();
        let reach = bodies.map(|(i, body)| {
            let away = (self.pose(0, i).translation.vector - centre.coords).norm();
            away + body.reach_m()
        });
        reach.fold(0.1, f64::max)
    }

    /// Whether a body touches something at the end of the frame's control step.
    #[must_use]
    pub fn touches(&self, frame: usize, body: usize) -> bool {
        let step = frame / self.recording.layout.frames_per_step;
        self.recording.contacts[step * self.morphology.bodies().len() + body] != 0
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::example::{PARTS, clip, morphology, recording};

    /// 2 kg at y = 0, 1 kg at 0.5 and 1 kg at -0.5; 2 kg at z = 0.2 and 2 kg at 0.1.
    #[test]
    fn frames_are_where_they_were_recorded() {
        let clip = clip(4);
        assert_eq!((clip.n_frames(), clip.title()), (8, "a title"));
        let centre = clip.centre_of_gravity(3);
        assert!((centre - Point3::new(0.0, 0.3, 0.15)).norm() < 1e-7, "{centre}");
        assert!((clip.pose(3, 1).translation.y - 0.8).abs() < 1e-7);
        // The ball's centre is 0.5 m ahead and 0.05 m below; the rod's ends are 0.2 m from its own.
        assert!((clip.reach_m() - (0.5_f64.hypot(0.05) + 0.25)).abs() < 1e-6);
        let turned = clip.pose(0, 2) * Vector3::x();
        assert!((turned - Vector3::y()).norm() < 1e-6);
        assert_eq!(clip.seconds(0), 0.05);
        assert_eq!([0.0, 0.05, 0.12, 0.13, 9.0].map(|s| clip.frame_at(s)), [0, 0, 1, 2, 7]);
        assert_eq!([1, 2, 3, 4].map(|frame| clip.touches(frame, 1)), [false, true, true, false]);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let refused = |change: fn(&mut Recording), message: &str| {
            let mut recording = recording(2);
            change(&mut recording);
            let error = Clip::new(String::new(), PARTS, morphology(), recording).unwrap_err();
            assert!(error.to_string().contains(message), "{error}");
        };
        refused(|it| it.layout.bodies.swap(0, 1), "the model has [\"block\", \"ball\", \"rod\"]");
        refused(|it| it.poses[7] = f32::NAN, "frame 0: the pose of 'ball' isn't one");
        refused(|it| it.poses[27] = 0.0, "frame 1: the pose of 'block' isn't one");
        refused(|it| it.poses.clear(), "no control steps were recorded");
    }
}
