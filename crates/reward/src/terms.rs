//! Every term of a reward by itself.

use super::Error;

/// What a control step's reward is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    /// r, as optimised: scale (mix - penalty).
    pub reward: f64,
    /// The extrinsic part in its own unit, [`extrinsic::Build::unit`](crate::extrinsic::Build::unit).
    pub extrinsic_raw: f64,
    /// The extrinsic part as it's mixed.
    pub extrinsic: f64,
    /// Information in nats: the mean over sensors, groups or links, by observed frequencies.
    pub intrinsic_nats: f64,
    /// The same less its bias, by Miller and Madow. Can be negative.
    pub intrinsic_nats_corrected: f64,
    /// The intrinsic part as it's mixed.
    pub intrinsic: f64,
    /// What was subtracted for parts that touch something, in units of r.
    pub penalty: f64,
    /// Share of the extrinsic part.
    pub xi: f64,
}

impl Terms {
    /// Names of [`Terms::as_array`]: columns of tables.
    pub const NAMES: [&'static str; 8] = [
        "reward",
        "extrinsic_raw",
        "extrinsic",
        "intrinsic_nats",
        "intrinsic_nats_corrected",
        "intrinsic",
        "penalty",
        "xi",
    ];

    /// In the order of [`Terms::NAMES`].
    #[must_use]
    pub fn as_array(&self) -> [f64; 8] {
        [
            self.reward,
            self.extrinsic_raw,
            self.extrinsic,
            self.intrinsic_nats,
            self.intrinsic_nats_corrected,
            self.intrinsic,
            self.penalty,
            self.xi,
        ]
    }

    /// Refuses what blew up, the raw term before what is made of it.
    pub(super) fn check(&self) -> Result<(), Error> {
        let terms = Self::NAMES.into_iter().zip(self.as_array());
        let mut bad = terms.skip(1).chain([("reward", self.reward)]);
        match bad.find(|(_, value)| !value.is_finite()) {
            Some((term, value)) => Err(Error::NotFinite { term, value }),
            None => Ok(()),
        }
    }
}
