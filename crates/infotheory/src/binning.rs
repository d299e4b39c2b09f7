//! Binning: a value in [-1, 1] -> the number of a bin -> bits, and back to the bin's centroid.
//!
//! ```text
//! n        = 2^B
//! bin      = floor(n (v + 1) / 2), clipped to 0 ..= n - 1
//! bits     = bin written in B bits, the most significant first
//! centroid = 2 (bin + 1/2) / n - 1
//! ```
//!
//! With B = 1 that's the sign: bits 0 and 1, centroids -0.5 and 0.5.

use crate::error::{Error, check_length, refused};

/// Equal bins over [-1, 1], 2^bits of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binning {
    bits: u32,
}

/// The bin that a value fell into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bin {
    /// 0 ..= n_bins - 1, from -1 upwards.
    pub index: u64,
    /// Whether the value lay outside of [-1, 1] and was moved to the bin at that end.
    pub clipped: bool,
}

impl Binning {
    /// The most bits that a value can have: bins are then 2^-31 wide.
    pub const MAX_BITS: u32 = 32;

    /// Bins of 0 to [`MAX_BITS`](Self::MAX_BITS) bits. With 0 bits there's one bin, number 0,
    /// with centroid 0 and no bits to write.
    pub fn new(bits: u32) -> Result<Self, Error> {
        if bits > Self::MAX_BITS {
            let expected = format!("0 to {}", Self::MAX_BITS);
            return Err(refused("Binning::new", "bits", expected, bits));
        }
        Ok(Self { bits })
    }

    /// Bits of a value, B.
    #[must_use]
    pub fn bits(self) -> u32 {
        self.bits
    }

    /// Number of bins, 2^B.
    #[must_use]
    pub fn n_bins(self) -> u64 {
        1 << self.bits
    }

    /// The bin of a value. A value outside of [-1, 1], infinite ones too, is clipped, and
    /// [`Bin::clipped`] says so. NaN is an error.
    pub fn bin(self, value: f64) -> Result<Bin, Error> {
        if value.is_nan() {
            return Err(refused("Binning::bin", "value", "a number", value));
        }
        Ok(self.bin_of_number(value))
    }

    /// The bins of values, and how many values were clipped. With NaN among them, nothing is
    /// written.
    pub fn bins(self, values: &[f64], bins: &mut [u64]) -> Result<usize, Error> {
        check_length("Binning::bins", "bins", values.len(), bins.len())?;
        check_numbers("Binning::bins", values)?;
        let mut n_clipped = 0;
        for (&value, slot) in values.iter().zip(bins) {
            let bin = self.bin_of_number(value);
            *slot = bin.index;
            n_clipped += usize::from(bin.clipped);
        }
        Ok(n_clipped)
    }

    /// The middle of a bin, exact.
    pub fn centroid(self, bin: u64) -> Result<f64, Error> {
        self.check_bin("Binning::centroid", bin)?;
        Ok(self.centroid_of_bin(bin))
    }

    /// Writes a bin's number as B bits, the most significant first.
    ///
    /// `bits`: \[B\]
    pub fn write_bits(self, bin: u64, bits: &mut [bool]) -> Result<(), Error> {
        check_length("Binning::write_bits", "bits", self.bits as usize, bits.len())?;
        self.check_bin("Binning::write_bits", bin)?;
        self.bits_of_bin(bin, bits);
        Ok(())
    }

    /// The bin that B bits name.
    pub fn read_bits(self, bits: &[bool]) -> Result<u64, Error> {
        check_length("Binning::read_bits", "bits", self.bits as usize, bits.len())?;
        Ok(number_of_bits(bits))
    }

    /// Values to bits, and how many values were clipped. With NaN among them, nothing is written.
    ///
    /// `bits`: \[n_values x B\], row-major, each value's most significant bit first
    pub fn encode(self, values: &[f64], bits: &mut [bool]) -> Result<usize, Error> {
        let n_bits = self.bits as usize;
        check_length("Binning::encode", "bits", values.len() * n_bits, bits.len())?;
        check_numbers("Binning::encode", values)?;
        let mut n_clipped = 0;
        for (i, &value) in values.iter().enumerate() {
            let bin = self.bin_of_number(value);
            self.bits_of_bin(bin.index, &mut bits[i * n_bits..(i + 1) * n_bits]);
            n_clipped += usize::from(bin.clipped);
        }
        Ok(n_clipped)
    }

    /// Bits to the centroids of the bins that they name.
    ///
    /// `bits`: \[n_values x B\], row-major, each value's most significant bit first
    pub fn decode(self, bits: &[bool], values: &mut [f64]) -> Result<(), Error> {
        let n_bits = self.bits as usize;
        check_length("Binning::decode", "bits", values.len() * n_bits, bits.len())?;
        for (i, value) in values.iter_mut().enumerate() {
            let bin = number_of_bits(&bits[i * n_bits..(i + 1) * n_bits]);
            *value = self.centroid_of_bin(bin);
        }
        Ok(())
    }

    /// floor(n (v + 1) / 2) = n/2 + floor(v n/2) for n >= 2. The product with a power of two is
    /// exact, where v + 1 would round a tiny negative value up into the bin above zero.
    fn bin_of_number(self, value: f64) -> Bin {
        let clipped = !(-1.0..=1.0).contains(&value);
        if self.bits == 0 {
            return Bin { index: 0, clipped };
        }
        let half = (self.n_bins() / 2) as f64;
        let from_middle = (value.clamp(-1.0, 1.0) * half).floor().min(half - 1.0);
        Bin { index: (from_middle + half) as u64, clipped }
    }

    /// (2 bin + 1 - n) / n: integers below 2^34 over a power of two, so nothing rounds.
    fn centroid_of_bin(self, bin: u64) -> f64 {
        let n = self.n_bins() as f64;
        ((2 * bin + 1) as f64 - n) / n
    }

    fn bits_of_bin(self, bin: u64, bits: &mut [bool]) {
        for (place, bit) in bits.iter_mut().rev().enumerate() {
            *bit = bin >> place & 1 == 1;
        }
    }

    fn check_bin(self, call: &'static str, bin: u64) -> Result<(), Error> {
        if bin >= self.n_bins() {
            return Err(refused(call, "bin", format!("below {}", self.n_bins()), bin));
        }
        Ok(())
    }
}

fn number_of_bits(bits: &[bool]) -> u64 {
    bits.iter().fold(0, |number, &bit| number << 1 | u64::from(bit))
}

fn check_numbers(call: &'static str, values: &[f64]) -> Result<(), Error> {
    match values.iter().position(|value| value.is_nan()) {
        Some(place) => Err(refused(call, format!("value {place}"), "a number", values[place])),
        None => Ok(()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn one_bit_is_the_sign() {
        let one = Binning::new(1).unwrap();
        for (value, bin) in [(-1.0, 0), (-1e-300, 0), (-0.0, 1), (0.0, 1), (0.3, 1), (1.0, 1)] {
            assert_eq!(one.bin(value), Ok(Bin { index: bin, clipped: false }), "{value}");
        }
        assert_eq!((one.centroid(0), one.centroid(1)), (Ok(-0.5), Ok(0.5)));
    }

    #[test]
    fn two_bits_by_hand() {
        let two = Binning::new(2).unwrap();
        let mut bits = [false; 8];
        assert_eq!(two.encode(&[-0.75, -0.25, 0.25, 0.75], &mut bits), Ok(0));
        assert_eq!(bits.map(u8::from), [0, 0, 0, 1, 1, 0, 1, 1]);
        let mut values = [0.0; 4];
        two.decode(&bits, &mut values).unwrap();
        assert_eq!(values, [-0.75, -0.25, 0.25, 0.75]);
        assert_eq!(two.bin(-0.5).unwrap().index, 1, "an edge belongs to the bin above");
        assert_eq!(two.bin(1.0).unwrap().index, 3, "but for the last");
    }

    #[test]
    fn no_bits_are_one_bin_around_zero() {
        let none = Binning::new(0).unwrap();
        assert_eq!(none.n_bins(), 1);
        for value in [-1.0, 0.0, 0.9, 1.0] {
            assert_eq!(none.bin(value), Ok(Bin { index: 0, clipped: false }));
        }
        assert_eq!(none.bin(1.1), Ok(Bin { index: 0, clipped: true }));
        assert_eq!(none.centroid(0), Ok(0.0));
        assert_eq!(none.encode(&[0.1, 0.2], &mut []), Ok(0));
        let mut values = [7.0; 2];
        none.decode(&[], &mut values).unwrap();
        assert_eq!(values, [0.0; 2]);
    }

    #[test]
    fn out_of_range_is_clipped_and_counted() {
        let three = Binning::new(3).unwrap();
        let mut bins = [9; 5];
        let values = [f64::NEG_INFINITY, -1.0 - 1e-15, 1.0, 1.0 + 1e-15, f64::INFINITY];
        assert_eq!(three.bins(&values, &mut bins), Ok(4));
        assert_eq!(bins, [0, 0, 7, 7, 7]);
        assert_eq!(three.bin(f64::INFINITY), Ok(Bin { index: 7, clipped: true }));
    }

    #[test]
    fn nan_is_an_error_and_nothing_is_written() {
        let two = Binning::new(2).unwrap();
        assert_eq!(
            two.bin(f64::NAN).unwrap_err().to_string(),
            "Binning::bin: value must be a number, got NaN"
        );
        let mut bins = [9; 2];
        let error = two.bins(&[0.0, f64::NAN], &mut bins).unwrap_err();
        assert_eq!(error.to_string(), "Binning::bins: value 1 must be a number, got NaN");
        let mut bits = [true; 4];
        let error = two.encode(&[0.0, f64::NAN], &mut bits).unwrap_err();
        assert_eq!(error.to_string(), "Binning::encode: value 1 must be a number, got NaN");
        assert_eq!((bins, bits), ([9; 2], [true; 4]));
    }

    #[test]
    fn misfits_are_refused_with_place_and_value() {
        let two = Binning::new(2).unwrap();
        let message = |error: Error| error.to_string();
        for (found, expected) in [
            (Binning::new(33).map(|_| ()), "Binning::new: bits must be 0 to 32, got 33"),
            (two.centroid(4).map(|_| ()), "Binning::centroid: bin must be below 4, got 4"),
            (two.write_bits(4, &mut [false; 2]), "Binning::write_bits: bin must be below 4, got 4"),
            (
                two.write_bits(0, &mut [false; 3]),
                "Binning::write_bits: the length of bits must be 2, got 3",
            ),
            (
                two.read_bits(&[true]).map(|_| ()),
                "Binning::read_bits: the length of bits must be 2, got 1",
            ),
            (
                two.decode(&[false; 3], &mut [0.0; 2]),
                "Binning::decode: the length of bits must be 4, got 3",
            ),
            (
                two.encode(&[0.0], &mut []).map(|_| ()),
                "Binning::encode: the length of bits must be 2, got 0",
            ),
            (
                two.bins(&[0.0], &mut []).map(|_| ()),
                "Binning::bins: the length of bins must be 1, got 0",
            ),
        ] {
            assert_eq!(found.map_err(message), Err(expected.to_owned()));
        }
    }

    fn binnings() -> impl Strategy<Value = Binning> {
        (0..=Binning::MAX_BITS).prop_map(|bits| Binning { bits })
    }

    proptest! {
        #[test]
        fn a_bin_comes_back_from_its_centroid_and_from_its_bits(
            binning in binnings(),
            number: u64,
        ) {
            let bin = number % binning.n_bins();
            let mut bits = vec![true; binning.bits() as usize];
            binning.write_bits(bin, &mut bits)?;
            prop_assert_eq!(binning.read_bits(&bits)?, bin);
            let centroid = binning.centroid(bin)?;
            prop_assert_eq!(binning.bin(centroid)?, Bin { index: bin, clipped: false });
        }

        #[test]
        fn a_value_is_within_half_a_bin_of_its_centroid(
            binning in binnings(),
            value in -1.0..=1.0,
        ) {
            let centroid = binning.centroid(binning.bin(value)?.index)?;
            // The difference of two doubles in [-1, 1] rounds by at most 2^-53.
            let half = 1.0 / binning.n_bins() as f64;
            prop_assert!((value - centroid).abs() <= half + 2.0_f64.powi(-53));
        }

        #[test]
        fn greater_values_are_never_in_lower_bins(
            binning in binnings(),
            a in -1.5..1.5,
            b in -1.5..1.5,
        ) {
            let (low, high) = if a < b { (a, b) } else { (b, a) };
            prop_assert!(binning.bin(low)?.index <= binning.bin(high)?.index);
        }
    }
}
