//! The table `perturbation`: noise on what the policy does, now and then, like a wind.
//!
//! In the learned control steps k `every` to k `every` + `length` - 1, for k = 1, 2, ..., each bit
//! of the output flips with the probability `flip_probability`. Flipped bits are executed; the
//! score is taken at the policy's own output.

use config::{Section, count, within};
use serde::Serialize;

/// Noise now and then.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PerturbationSettings {
    /// Control steps from the beginning of one to that of the next; 1000. 0: there is none.
    pub every: u64,
    /// Control steps that one lasts, at most `every`; 10.
    pub length: u64,
    /// For each bit of the output, 0 to 1; 0.1.
    pub flip_probability: f64,
}

impl Default for PerturbationSettings {
    fn default() -> Self {
        Self { every: 1000, length: 10, flip_probability: 0.1 }
    }
}

impl PerturbationSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        /// Control steps that a run can have, and more.
        const LAST: i64 = 1 << 53;
        let default = Self::default();
        let every = section.given_or("every", count(0, LAST), default.every);
        let length = section.given_or("length", count(1, LAST), default.length);
        let flip_probability =
            section.or("flip_probability", within(0.0, 1.0), default.flip_probability);
        let (every, length) = (every?, length?);
        if every > 0 && length > every {
            let key = if section.has("length") { "length" } else { "every" };
            let message =
                format!("length must be at most every, got length = {length} and every = {every}");
            section.complain(&section.place_of(key), message);
        }
        Some(Self { every, length, flip_probability })
    }
}
