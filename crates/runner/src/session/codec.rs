//! Readings to bits and bits to targets: rows 2 and 4 of a control step.
//!
//! ```text
//! bin = floor(n (v + 1)/2), within 0..n-1        n = 2^B bins for a value v from -1 to 1
//! v   = 2 (bin + 1/2)/n - 1                      the bin's centroid
//! ```
//!
//! A bin is written in B bits, big-endian. A contact is one bit as it is. The policy's inputs are the
//! last k+1 readings' bits, the oldest first; before there are so many, the first stands in for
//! those before it.

use infotheory::{Binning, Error};

/// Shapes of what the policy sees and does, and the readings that it remembers.
#[derive(Clone, Debug)]
pub struct Codec {
    sensor: Binning,
    actuator: Binning,
    n_positions: usize,
    n_contacts: usize,
    /// `[n_positions + n_contacts]`: of the newest reading.
    bins: Vec<u64>,
    /// `[(memory + 1) x bits of a reading]`
    inputs: Vec<bool>,
    begun: bool,
}

/// What a [`Codec`] is made for.
#[derive(Clone, Copy, Debug)]
pub struct CodecShape {
    /// The number of bits of a position.
    pub sensor_bits: u32,
    /// The number of bits of a target.
    pub actuator_bits: u32,
    /// Earlier readings that the policy sees, k.
    pub memory: usize,
    /// The number of sensors of positions.
    pub n_positions: usize,
    /// The number of sensors of contacts.
    pub n_contacts: usize,
}

impl Codec {
    /// Before the first reading.
    ///
    /// # Errors
    /// More bits than a bin can have.
    pub fn new(shape: &CodecShape) -> Result<Self, Error> {
        let &CodecShape { sensor_bits, actuator_bits, memory, n_positions, n_contacts } = shape;
        let bits_of_reading = n_positions * sensor_bits as usize + n_contacts;
        Ok(Self {
            sensor: Binning::new(sensor_bits)?,
            actuator: Binning::new(actuator_bits)?,
            n_positions,
            n_contacts,
            bins: vec![0; n_positions + n_contacts],
            inputs: vec![false; (memory + 1) * bits_of_reading],
            begun: false,
        })
    }

    /// Takes in a reading: positions, then contacts.
    ///
    /// # Errors
    /// A reading of another length, or with NaN among its positions. It changes nothing.
    pub fn encode(&mut self, reading: &[f64]) -> Result<(), Error> {
        if reading.len() != self.bins.len() {
            return Err(Error::Argument {
                call: "Codec::encode",
                argument: "reading".to_owned(),
                expected: format!("of length {}", self.bins.len()),
                value: reading.len().to_string(),
            });
        }
        let (positions, contacts) = reading.split_at(self.n_positions);
        let n = self.n_positions * self.sensor.bits() as usize + self.n_contacts;
        let (bins_of_positions, bins_of_contacts) = self.bins.split_at_mut(self.n_positions);
        self.sensor.bins(positions, bins_of_positions)?;
        self.inputs.rotate_left(n);
        let start = self.inputs.len() - n;
        let newest = &mut self.inputs[start..];
        let (of_positions, of_contacts) = newest.split_at_mut(n - self.n_contacts);
        self.sensor.encode(positions, of_positions)?;
        for ((bit, bin), &contact) in of_contacts.iter_mut().zip(bins_of_contacts).zip(contacts) {
            *bit = contact > 0.5;
            *bin = u64::from(*bit);
        }
        if !self.begun {
            self.begun = true;
            let (earlier, newest) = self.inputs.split_at_mut(start);
            earlier.chunks_mut(n.max(1)).for_each(|reading| reading.copy_from_slice(newest));
        }
        Ok(())
    }

    /// The newest reading's bins, `[n_positions + n_contacts]`.
    #[must_use]
    pub fn bins(&self) -> &[u64] {
        &self.bins
    }

    /// The bits that the policy sees, `[n_inputs]`.
    #[must_use]
    pub fn inputs(&self) -> &[bool] {
        &self.inputs
    }

    /// The number of bits of a target.
    #[must_use]
    pub fn actuator_bits(&self) -> u32 {
        self.actuator.bits()
    }

    /// Targets, `[n_actuators]`, from the bits of an action, `[n_actuators x bits]`.
    ///
    /// # Errors
    /// Slices that don't fit each other.
    pub fn decode(&self, action: &[bool], targets: &mut [f64]) -> Result<(), Error> {
        self.actuator.decode(action, targets)
    }

    /// Goes back to inputs that [`Codec::inputs`] gave, `[n_inputs]`. The next reading gives the
    /// bins.
    pub fn restore(&mut self, inputs: &[bool]) {
        self.begun = true;
        self.inputs.copy_from_slice(inputs);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codec(sensor_bits: u32, memory: usize) -> Codec {
        let shape =
            CodecShape { sensor_bits, actuator_bits: 2, memory, n_positions: 2, n_contacts: 1 };
        Codec::new(&shape).unwrap()
    }

    fn bits(text: &str) -> Vec<bool> {
        text.chars().filter(|c| *c != ' ').map(|c| c == '1').collect()
    }

    #[test]
    fn positions_and_contacts_become_bits() {
        let mut codec = codec(2, 0);
        codec.encode(&[-1.0, 0.3, 1.0]).unwrap();
        assert_eq!(codec.bins(), [0, 2, 1]);
        assert_eq!(codec.inputs(), bits("00 10 1"));
        let mut targets = [0.0; 2];
        codec.decode(&bits("01 11"), &mut targets).unwrap();
        assert_eq!(targets, [-0.25, 0.75]);
    }

    #[test]
    fn memory_keeps_readings_oldest_first() {
        let mut codec = codec(1, 2);
        codec.encode(&[0.5, -0.5, 0.0]).unwrap();
        assert_eq!(codec.inputs(), bits("100 100 100"));
        codec.encode(&[0.5, 0.5, 1.0]).unwrap();
        codec.encode(&[-0.5, -0.5, 0.0]).unwrap();
        assert_eq!(codec.inputs(), bits("100 111 000"));
        codec.encode(&[-0.5, 0.5, 0.0]).unwrap();
        assert_eq!(codec.inputs(), bits("111 000 010"));
    }

    #[test]
    fn goes_on_from_restored_inputs() {
        let (mut one, mut other) = (codec(1, 1), codec(1, 1));
        one.encode(&[0.5, -0.5, 1.0]).unwrap();
        other.restore(one.inputs());
        for codec in [&mut one, &mut other] {
            codec.encode(&[-0.5, -0.5, 0.0]).unwrap();
        }
        assert_eq!(one.inputs(), other.inputs());
        assert_eq!(one.bins(), other.bins());
    }

    #[test]
    fn misfits_are_refused_and_change_nothing() {
        let mut codec = codec(1, 1);
        codec.encode(&[0.5, -0.5, 1.0]).unwrap();
        let (bins, inputs) = (codec.bins().to_vec(), codec.inputs().to_vec());
        for reading in [&[0.0][..], &[0.0; 2], &[0.0; 4], &[-0.5, f64::NAN, 0.0]] {
            codec.encode(reading).unwrap_err();
            assert_eq!((codec.bins(), codec.inputs()), (&bins[..], &inputs[..]), "{reading:?}");
        }
    }
}
