//! The table `perturbation`: noise on what the policy does, now and then, like a wind.
//!
//! In the learned control steps k `every` to k `every` + `length` - 1, for k = 1, 2, ..., each bit
//! of the output flips with the probability `flip_probability`. Flipped bits are executed; the
//! score is taken at the policy's own output.

use config::{Rule, Section, count, within};
use serde::Serialize;

/// Noise now and then.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PerturbationSettings {
    /// Control steps from the beginning of one to that of the next; 0: there is none.
    pub every: u64,
    /// Control steps that one lasts.
    pub length: u64,
    /// The probability that a bit of the output flips.
    pub flip_probability: f64,
}

impl PerturbationSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        /// Control steps that a run can have, and more.
        const LAST: i64 = 1 << 53;
        let every = count(0, LAST).about(
            "control steps from the beginning of one perturbation to that of the next; 0: none",
        );
        let every = section.given_or("every", every, 1000);
        let length =
            count(1, LAST).about("control steps that one lasts").condition("at most `every`");
        let length = section.given_or("length", length, 10);
        let flip_probability =
            within(0.0, 1.0).about("probability that a bit of the policy's output flips");
        let flip_probability = section.or("flip_probability", flip_probability, 0.1);
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
