//! Gaits: open-loop periodic bit patterns, for comparison with what is learned.
//!
//! ```toml
//! name = "tripod"
//! bits = 1                # of each actuator, as codec.actuator_bits
//! steps = [               # one row a control step, and again from the first after the last
//!     "0101 1100 0011",   # the bits of all actuators in their order; spaces don't count
//!     "1010 0011 1100",
//! ]
//! ```

use std::path::Path;

use config::{Document, Mismatch, Node, Problems, Rule, Value, integer, list, text};

/// An open-loop periodic bit pattern.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Gait {
    /// The gait's name.
    pub name: String,
    /// Bits of each actuator.
    pub bits: u32,
    /// The bits of each control step, `[period][n_actuators x bits]`.
    pub steps: Vec<Vec<bool>>,
}

impl Gait {
    /// Reads a gait file for a robot with so many actuators.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place.
    pub fn open(path: &Path, n_actuators: usize) -> Result<Self, Problems> {
        Self::of(&Document::open(path)?, n_actuators)
    }

    fn of(document: &Document, n_actuators: usize) -> Result<Self, Problems> {
        document.read(|gait| {
            let name = gait.required("name", text());
            let bits = gait.optional("bits", integer(1, 16)).or((!gait.has("bits")).then_some(1));
            let length = bits.map(|bits| n_actuators * bits as usize);
            let steps = gait.required("steps", list(Bits { length }))?;
            if steps.is_empty() {
                gait.refuse("steps", "a list of at least one row", "none");
            }
            Some(Self { name: name?, bits: bits? as u32, steps })
        })
    }

    /// The bits of a control step.
    #[must_use]
    pub fn at(&self, step: u64) -> &[bool] {
        &self.steps[(step % self.steps.len() as u64) as usize]
    }
}

/// `"0101 1100"`
struct Bits {
    /// None: any, where it can't be told how many an actuator has.
    length: Option<usize>,
}

impl Rule for Bits {
    type Out = Vec<bool>;

    fn expected(&self) -> String {
        let length = self.length.map_or(String::new(), |length| format!("{length} "));
        format!("a text of {length}digits 0 and 1")
    }

    fn take(&self, node: &Node) -> Result<Vec<bool>, Mismatch> {
        let Value::Text(text) = &node.value else { return Err(self.refuse(node)) };
        let digit = |c: char| match c {
            '0' => Some(false),
            '1' => Some(true),
            _ => None,
        };
        let bits: Option<Vec<bool>> =
            text.chars().filter(|c| !c.is_whitespace()).map(digit).collect();
        let fits = |bits: &Vec<bool>| self.length.is_none_or(|length| bits.len() == length);
        bits.filter(fits).ok_or_else(|| self.refuse(node))
    }

    fn written(&self, bits: &Vec<bool>) -> String {
        let digits: String = bits.iter().map(|&bit| if bit { '1' } else { '0' }).collect();
        format!("{digits:?}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Gait, Problems> {
        Gait::of(&Document::parse("gait.toml", text)?, 4)
    }

    #[test]
    fn a_gait_repeats() {
        let gait = read("name = 'trot'\nsteps = ['01 10', '1111']").unwrap();
        assert_eq!(gait.at(0), [false, true, true, false]);
        assert_eq!(gait.at(1), [true; 4]);
        assert_eq!(gait.at(2), gait.at(0));
    }

    #[test]
    fn misfits_say_where() {
        let says = |text| read(text).unwrap_err().to_string();
        assert_eq!(
            says("name = 'x'\nsteps = ['0101', '01012']"),
            "gait.toml:2:18: steps[1] must be a text of 4 digits 0 and 1, got \"01012\""
        );
        assert_eq!(
            says("name = 'x'\nbits = 2\nsteps = []"),
            "gait.toml:3:9: steps must be a list of at least one row, got none"
        );
    }

    #[test]
    fn one_mistake_is_one_message() {
        let says = |bits: &str, row: &str| {
            read(&format!("name = 'x'\nbits = {bits}\nsteps = ['{row}']")).unwrap_err().to_string()
        };
        for (bits, shown) in [("17", "17"), ("0", "0"), ("1.5", "1.5"), ("'two'", "\"two\"")] {
            let expected =
                format!("gait.toml:2:8: bits must be a whole number from 1 to 16, got {shown}");
            assert_eq!(says(bits, &"0".repeat(4 * 17)), expected);
            // What is wrong whatever the bits should be is said, too.
            let row = "gait.toml:3:10: steps[0] must be a text of digits 0 and 1, got \"012\"";
            assert_eq!(says(bits, "012"), format!("{expected}\n{row}"));
        }
    }
}
