//! The table `codec`: readings to bits, bits to targets.

use config::Section;
use serde::Serialize;

use crate::rules::count;

/// The most bits of a value: 256 bins, finer than any servo here.
const MOST_BITS: i64 = 8;

/// Readings to bits, bits to targets.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CodecSettings {
    /// Bits of a joint position, 1 to 8; 1. A contact has one in any case.
    pub sensor_bits: u32,
    /// Bits of an actuator's target, 1 to 8; 1.
    pub actuator_bits: u32,
}

impl Default for CodecSettings {
    fn default() -> Self {
        Self { sensor_bits: 1, actuator_bits: 1 }
    }
}

impl CodecSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let default = Self::default();
        Some(Self {
            sensor_bits: section.or("sensor_bits", count(1, MOST_BITS), default.sensor_bits),
            actuator_bits: section.or("actuator_bits", count(1, MOST_BITS), default.actuator_bits),
        })
    }
}
