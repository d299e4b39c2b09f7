//! Poses in 16 bits a number: positions as steps from the middle of the box that they cover,
//! quaternions, made as long as 1, in 1/32767.

use serde::{Deserialize, Serialize};

use super::POSE;

/// The largest number of a quaternion, and of steps to either side.
const LARGEST: f64 = i16::MAX as f64;
/// Of poses that all lie in a plane, or in one point.
const SMALLEST_STEP_M: f64 = 1e-9;

/// The box that packed positions lie in.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Packing {
    /// Its middle, in m.
    pub centre_m: [f64; 3],
    /// The length of a step along each axis, in m: 1/32767 of half its size.
    pub step_m: [f64; 3],
}

impl Packing {
    /// How far an unpacked orientation may be from the recorded one, in rad: half a step in each of
    /// a quaternion's four numbers, which turns by twice its length.
    pub const TURN_RAD: f64 = 2.0 / LARGEST;

    /// The box around all positions of some poses, `[7]` each.
    pub fn covering<'a>(poses: impl Iterator<Item = &'a [f32]>) -> Self {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for pose in poses {
            for i in 0..3 {
                low[i] = low[i].min(f64::from(pose[i]));
                high[i] = high[i].max(f64::from(pose[i]));
            }
        }
        let is_empty = low > high;
        let middle = |i: usize| if is_empty { 0.0 } else { 0.5 * (low[i] + high[i]) };
        let half = |i: usize| 0.5 * (high[i] - low[i]);
        Self {
            centre_m: std::array::from_fn(middle),
            step_m: std::array::from_fn(|i| (half(i) / LARGEST).max(SMALLEST_STEP_M)),
        }
    }

    /// A pose, `[7]`, in the box.
    #[must_use]
    pub fn pack(&self, pose: &[f32]) -> [i16; POSE] {
        let square = |&value: &f32| f64::from(value) * f64::from(value);
        let length = pose[3..].iter().map(square).sum::<f64>().sqrt();
        std::array::from_fn(|i| {
            let value = f64::from(pose[i]);
            // Within the range but for roundings; `as` cuts off what is beyond.
            let scaled = match i {
                0..3 => (value - self.centre_m[i]) / self.step_m[i],
                _ => value / length * LARGEST,
            };
            scaled.round() as i16
        })
    }

    /// The pose that was packed, to half a step in each number.
    #[must_use]
    pub fn unpack(&self, packed: [i16; POSE]) -> [f32; POSE] {
        std::array::from_fn(|i| {
            let value = f64::from(packed[i]);
            let value = match i {
                0..3 => self.centre_m[i] + self.step_m[i] * value,
                _ => value / LARGEST,
            };
            value as f32
        })
    }

    /// How far an unpacked position may be from the recorded one, in m: half a step along each axis.
    #[must_use]
    pub fn position_m(&self) -> f64 {
        let largest = self.step_m.into_iter().fold(0.0, f64::max);
        0.5 * largest * 3.0_f64.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_comes_back_to_half_a_step() {
        let poses = [
            [1.0, -2.0, 0.5, 0.0, 0.0, 0.0, 1.0],
            [3.0, 4.0, 0.5, 0.5, -0.5, 0.5, -0.5],
            [1.7, 1.1, 0.5, 0.6, 0.0, 0.0, -0.8_f32],
        ];
        let packing = Packing::covering(poses.iter().map(<[f32; POSE]>::as_slice));
        assert_eq!(packing.centre_m, [2.0, 1.0, 0.5]);
        assert_eq!(packing.step_m, [1.0 / 32767.0, 3.0 / 32767.0, 1e-9]);
        for pose in poses {
            let back = packing.unpack(packing.pack(&pose));
            for i in 0..POSE {
                let step = if i < 3 { packing.step_m[i] } else { 1.0 / 32767.0 };
                // A f32 near 4 has steps of 2.4e-7.
                let off = f64::from(back[i] - pose[i]).abs();
                assert!(off <= 0.5 * step + 5e-7, "{i}: {pose:?} {back:?}");
            }
        }
        assert_eq!(packing.pack(&poses[1])[..2], [32767, 32767]);
        // Not as long as 1.
        let long = [2.0, 1.0, 0.5, 0.0, 0.0, 3.0, 4.0];
        assert_eq!(packing.pack(&long)[3..], [0, 0, 19660, 26214]);
        let nothing = Packing::covering([].into_iter());
        assert_eq!(nothing, Packing { centre_m: [0.0; 3], step_m: [1e-9; 3] });
    }
}
