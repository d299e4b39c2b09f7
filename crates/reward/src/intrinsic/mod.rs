//! Intrinsic rewards: the information in the robot's own readings.

mod mutual_information;
mod none;
mod transfer_entropy;

pub use mutual_information::{Grouping, MutualInformationSettings, Sensors};
pub use none::NoneSettings;
pub use transfer_entropy::TransferEntropySettings;

use std::fmt::Debug;

use super::{Error, RobotLayout, kinds::kinds};

/// Makes an intrinsic reward of its settings.
pub trait Build {
    /// For readings of this layout, before the first.
    ///
    /// # Errors
    /// Settings that don't fit the layout.
    fn build(&self, layout: &RobotLayout) -> Result<Box<dyn Intrinsic>, Error>;

    /// What the information is called on axes and in tables.
    fn symbol(&self) -> &'static str;

    /// The unit of the information.
    fn unit(&self) -> &'static str {
        "nats"
    }

    /// What the information is the mean over, as in nats per variable.
    fn per(&self) -> &'static str {
        "variable"
    }

    /// Whether there is any information to tell of.
    fn is_measured(&self) -> bool {
        true
    }
}

/// Hears of readings and tells what they are worth.
pub trait Intrinsic: Debug + Send {
    /// Takes in the next reading: each sensor's bin, `[n_sensors]`.
    ///
    /// # Errors
    /// A reading that doesn't fit the layout.
    fn push(&mut self, bins: &[u64]) -> Result<(), Error>;

    /// What the newest reading is worth; 0 as long as there are too few.
    fn value(&self) -> Value;

    /// All that changes, for [`Intrinsic::restore`].
    fn save(&self) -> Vec<u64>;

    /// Goes back to a state with the same settings and layout.
    ///
    /// # Errors
    /// A state of others. Nothing has changed then.
    fn restore(&mut self, state: &[u64]) -> Result<(), Error>;
}

/// The information in a reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Value {
    /// By observed frequencies, the mean over sensors, groups or links; never negative.
    pub nats: f64,
    /// Less its bias, by Miller and Madow.
    pub nats_corrected: f64,
    /// The value that goes into the mix; never negative.
    pub scaled: f64,
}

kinds! {
    /// The information, with its settings: the list of all there are.
    IntrinsicSettings, dyn Build, "reward.intrinsic" ("the information"):
    /// Mutual information of successive readings: i = max * mean over sensors or groups of
    /// r_MI / ln min(states, window).
    "mutual_information" => MutualInformation(MutualInformationSettings),
    /// What joints tell about the next positions of their neighbours, beyond what those tell
    /// themselves: i = max * mean over both directions between neighbours of T / ln min(states, window).
    "transfer_entropy" => TransferEntropy(TransferEntropySettings),
    /// Nothing: the task alone. It needs xi = 1, since a geometric mix with 0 is 0 for any other.
    "none" => None(NoneSettings),
}
