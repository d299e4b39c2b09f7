//! The table `codec`: readings to bits, bits to targets.

use config::{Document, Problem, Rule, Section, count};
use serde::Serialize;

/// The most bits of a value: 256 bins, finer than any servo here.
const MOST_BITS: i64 = 8;

/// Readings to bits, bits to targets.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CodecSettings {
    /// Bits of a joint position. A contact has one in any case.
    pub sensor_bits: u32,
    /// Bits of an actuator's target.
    pub actuator_bits: u32,
}

impl CodecSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let sensor_bits = count(1, MOST_BITS).about(
            "bits of a joint position, in 2^bits equal bins; a contact has one bit in any case",
        );
        let actuator_bits = count(1, MOST_BITS)
            .about("bits of an actuator's target, the centre of one of 2^bits equal bins");
        Some(Self {
            sensor_bits: section.or("sensor_bits", sensor_bits, 1),
            actuator_bits: section.or("actuator_bits", actuator_bits, 1),
        })
    }

    /// Whether the targets lie on edges of the sensors' bins: the centre of a bin is an edge of its
    /// halves.
    pub(super) fn warning(&self, document: &Document) -> Option<Problem> {
        let Self { sensor_bits, actuator_bits } = self;
        // More than by default, so it's in the file.
        let place = document.get("codec.sensor_bits")?.place.clone();
        (sensor_bits > actuator_bits).then(|| Problem {
            place,
            message: format!(
                "codec: with {sensor_bits} sensor_bits and {actuator_bits} actuator_bits the servos' \
                 targets lie exactly on edges of the sensors' bins, so a joint that is at its target \
                 flips between two bins; take at least as many actuator_bits as sensor_bits"
            ),
        })
    }
}
