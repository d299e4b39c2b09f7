//! Which feet touched the ground in the last recorded control steps.

use std::path::Path;

use runs::Recording;

/// Contact readings, step by step.
#[derive(Clone, Debug, PartialEq)]
pub struct Contacts {
    /// Names of the bodies that have a contact sensor, in the order of the readings: foot 1, 2, ...
    pub feet: Vec<String>,
    /// Simulated seconds from one control step to the next.
    pub seconds_per_step: f64,
    /// \[T x n_feet\], row-major, the oldest step first.
    pub touching: Vec<bool>,
}

impl Contacts {
    /// Reads the contacts of a cell's `replay.safetensors`; none if there's no such file.
    ///
    /// # Errors
    /// A file that is damaged, or can't be read.
    pub fn read(path: &Path) -> Result<Option<Self>, runs::Error> {
        Ok(Recording::read(path)?.map(|it| Self::of(&it)))
    }

    /// Of a recording. Contact readings come after the positions and are named as their bodies.
    pub(super) fn of(recording: &Recording) -> Self {
        let layout = &recording.layout;
        let n_sensors = layout.sensors.len();
        let is_contact = |name: &&String| layout.bodies.contains(name);
        let n_feet = layout.sensors.iter().rev().take_while(is_contact).count();
        let readings = recording.sensors.chunks_exact(n_sensors.max(1));
        Self {
            feet: layout.sensors[n_sensors - n_feet..].to_vec(),
            seconds_per_step: layout.seconds_per_frame * layout.frames_per_step as f64,
            touching: readings
                .flat_map(|step| &step[n_sensors - n_feet..])
                .map(|&reading| reading > 0.5)
                .collect(),
        }
    }

    /// The number T of control steps.
    #[must_use]
    pub fn n_steps(&self) -> usize {
        self.touching.len() / self.feet.len().max(1)
    }

    /// When a foot touched within some steps: ranges of steps, in their order.
    #[must_use]
    pub fn stances(&self, foot: usize, steps: std::ops::Range<usize>) -> Vec<[usize; 2]> {
        let mut stances: Vec<[usize; 2]> = Vec::new();
        for step in steps.filter(|step| self.touching[step * self.feet.len() + foot]) {
            match stances.last_mut() {
                Some([_, end]) if *end == step => *end = step + 1,
                _ => stances.push([step, step + 1]),
            }
        }
        stances
    }
}

#[cfg(test)]
mod tests {
    use runs::RecordingLayout;

    use super::*;

    #[test]
    fn feet_are_the_last_readings_by_the_names_of_bodies() {
        let names = |names: &[&str]| names.iter().map(ToString::to_string).collect();
        let recording = Recording {
            layout: RecordingLayout {
                actuators: names(&["hip"]),
                bodies: names(&["torso", "left foot", "right foot"]),
                frames_per_step: 5,
                seconds_per_frame: 0.02,
                // The first is an axis, though a body has its name.
                sensors: names(&["torso", "hip", "right foot", "left foot"]),
                terms: names(&[]),
            },
            first_control_step: 7,
            n_steps: 3,
            poses: vec![0.0; 3 * 5 * 3 * 7],
            sensors: vec![0.9, -0.9, 1.0, 0.0, 0.9, 0.9, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            actions: vec![0.0; 3],
            contacts: vec![0; 9],
            terms: vec![],
        };
        let contacts = Contacts::of(&recording);
        assert_eq!(contacts.feet, ["right foot", "left foot"]);
        assert_eq!(contacts.touching, [true, false, true, true, false, true]);
        assert_eq!(contacts.n_steps(), 3);
        assert!((contacts.seconds_per_step - 0.1).abs() < 1e-15);
        assert_eq!(contacts.stances(0, 0..3), [[0, 2]]);
        assert_eq!(contacts.stances(1, 0..3), [[1, 3]]);
        assert_eq!(contacts.stances(0, 1..3), [[1, 2]]);
        let none = Contacts { feet: vec![], seconds_per_step: 0.1, touching: vec![] };
        assert_eq!(none.n_steps(), 0);
    }
}
