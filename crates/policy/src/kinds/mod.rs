//! The list of kinds, and what all of them share.

mod crbm;
mod logistic;
mod modular;

use std::fmt;

use config::{Section, integer, one_of};
use serde::Serialize;

pub use self::{
    crbm::{Connectivity, Crbm, CrbmSettings},
    logistic::{Logistic, LogisticSettings},
    modular::{Modular, ModularSettings},
};

use crate::{Error, Policy, Structure};

/// Makes a policy of its settings.
pub trait Build: fmt::Debug {
    /// For a robot, with all parameters 0, and with random numbers from any stream.
    ///
    /// # Errors
    /// Settings that don't fit the robot.
    fn build(&self, structure: &Structure) -> Result<Box<dyn Policy>, Error>;
}

/// Makes of the list the enum of all settings, and what depends on all of them. The first kind is the
/// default.
macro_rules! kinds {
    ($($(#[$about:meta])* $word:literal => $kind:ident($settings:ty),)+) => {
        /// The kind of a policy, with the settings that are its own: the list of all there are.
        #[derive(Clone, Debug, PartialEq, Serialize)]
        #[serde(untagged)]
        #[non_exhaustive]
        pub enum KindSettings {
            $($(#[$about])* $kind($settings),)+
        }

        impl KindSettings {
            /// Every kind with its default settings.
            #[must_use]
            pub fn all() -> Vec<Self> {
                vec![$(Self::$kind(<$settings>::default())),+]
            }

            /// The name in files.
            #[must_use]
            pub fn name(&self) -> &'static str {
                match self { $(Self::$kind(_) => $word),+ }
            }

            /// What builds it.
            #[must_use]
            pub fn get(&self) -> &dyn Build {
                match self { $(Self::$kind(settings) => settings),+ }
            }

            /// Reads `kind` and the keys that are that kind's own.
            pub fn read(section: &mut Section<'_>) -> Option<Self> {
                type Reader = fn(&mut Section<'_>) -> Option<KindSettings>;
                let words: &[(&str, (&str, Reader))] = &[
                    $(($word, ($word, |section| <$settings>::read(section).map(Self::$kind)))),+
                ];
                let given = section.has("kind");
                match section.optional("kind", one_of(words)) {
                    Some((word, read)) => {
                        section.call(format!("policy '{word}'"));
                        read(section)
                    }
                    None if given => {
                        section.accept_all();
                        None
                    }
                    None => words[0].1.1(section),
                }
            }
        }

        impl Default for KindSettings {
            fn default() -> Self {
                Self::all().swap_remove(0)
            }
        }
    };
}

kinds! {
    /// One conditional restricted Boltzmann machine, the paper's.
    "crbm" => Crbm(CrbmSettings),
    /// One small machine for each of the robot's groups.
    "modular" => Modular(ModularSettings),
    /// Each output bit a logistic function of the inputs.
    "logistic" => Logistic(LogisticSettings),
}

/// How conditional restricted Boltzmann machines are sized and sampled: keys of several kinds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MachineSettings {
    /// Hidden units of a machine, or of a block of one, 1 to 16,384.
    pub hidden_units: usize,
    /// Full updates of a Gibbs chain from its random start, 0 to 100,000; 10. With 0, actions are
    /// uniform.
    pub gibbs_updates: usize,
    /// Samples for the score's second term, 1 to 100,000; 60.
    pub samples: usize,
}

impl MachineSettings {
    fn with(hidden_units: usize) -> Self {
        let ::crbm::Sampling { gibbs_updates, samples } = ::crbm::Sampling::default();
        Self { hidden_units, gibbs_updates, samples }
    }

    fn read(section: &mut Section<'_>, default: &Self) -> Self {
        let mut count =
            |key, low, high, default| section.or(key, integer(low, high), default as i64) as usize;
        Self {
            hidden_units: count("hidden_units", 1, ::crbm::MAX_UNITS as i64, default.hidden_units),
            gibbs_updates: count("gibbs_updates", 0, 100_000, default.gibbs_updates),
            samples: count("samples", 1, 100_000, default.samples),
        }
    }

    fn sampling(&self) -> ::crbm::Sampling {
        ::crbm::Sampling { gibbs_updates: self.gibbs_updates, samples: self.samples }
    }
}
