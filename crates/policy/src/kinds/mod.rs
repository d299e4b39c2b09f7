//! The list of kinds, and what all of them share.

mod crbm;
mod logistic;
mod modular;

use std::fmt;

use config::{Rule, Section, count};
use serde::Serialize;

pub use self::{
    crbm::{Connectivity, Crbm, CrbmSettings},
    logistic::{Logistic, LogisticSettings},
    modular::{Modular, ModularSettings},
};

use crate::{Error, Link, Policy, Structure};

/// Makes a policy of its settings.
pub trait Build: fmt::Debug {
    /// For a robot, with all parameters 0, and with random numbers from any stream.
    ///
    /// # Errors
    /// Settings that don't fit the robot.
    fn build(&self, structure: &Structure) -> Result<Box<dyn Policy>, Error>;
}

/// Makes of the list the enum of all settings, and what depends on all of them. The first kind is the
/// default. What stands above a kind says in the documentation what it is.
macro_rules! kinds {
    ($($(#[doc = $about:literal])+ $word:literal => $kind:ident($settings:ty),)+) => {
        /// The kind of a policy, with the settings that are its own: the list of all there are.
        #[derive(Clone, Debug, PartialEq, Serialize)]
        #[serde(untagged)]
        #[non_exhaustive]
        pub enum KindSettings {
            $($(#[doc = $about])+ $kind($settings),)+
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
                let kinds = [$(($word, concat!($($about),+).trim_ascii())),+];
                section.kind("kind", "what draws the action", &kinds, |section, word| {
                    if section.has("kind") {
                        section.call(format!("policy '{word}'"));
                    }
                    match word {
                        $($word => <$settings>::read(section).map(Self::$kind),)+
                        _ => None,
                    }
                })
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
    /// A conditional restricted Boltzmann machine, the paper's.
    "crbm" => Crbm(CrbmSettings),
    /// A small conditional restricted Boltzmann machine for each of the model's groups (legs), which
    /// draws the targets of that group.
    "modular" => Modular(ModularSettings),
    /// Each bit by itself, a logistic function of the inputs.
    "logistic" => Logistic(LogisticSettings),
}

/// How conditional restricted Boltzmann machines are sized and sampled: keys of several kinds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MachineSettings {
    /// Hidden units of a machine, or of a block of one.
    pub hidden_units: usize,
    /// Full updates of a Gibbs chain from its random start.
    pub gibbs_updates: usize,
    /// Samples for the score's second term.
    pub samples: usize,
}

impl MachineSettings {
    fn with(hidden_units: usize) -> Self {
        let ::crbm::Sampling { gibbs_updates, samples } = ::crbm::Sampling::default();
        Self { hidden_units, gibbs_updates, samples }
    }

    fn read(section: &mut Section<'_>, default: &Self) -> Self {
        let hidden_units = count(1, ::crbm::MAX_UNITS as i64)
            .about("hidden units of a machine, or of each block of one (`connectivity`)");
        let gibbs_updates = count(0, 100_000).about(
            "full updates of a Gibbs chain from its random start; with 0, actions are uniform",
        );
        let samples = count(1, 100_000).about("samples for the second term of the score");
        Self {
            hidden_units: section.or("hidden_units", hidden_units, default.hidden_units),
            gibbs_updates: section.or("gibbs_updates", gibbs_updates, default.gibbs_updates),
            samples: section.or("samples", samples, default.samples),
        }
    }

    fn sampling(&self) -> ::crbm::Sampling {
        ::crbm::Sampling { gibbs_updates: self.gibbs_updates, samples: self.samples }
    }
}

/// The links of a machine whose parameters begin at `start`.
fn links(layout: &::crbm::Layout, start: usize) -> Vec<Link> {
    let (m, k, n) = (layout.n_hidden(), layout.n_inputs(), layout.n_outputs());
    let hidden_bias = |hidden| Some(start + layout.hidden_biases().start + hidden);
    let output_bias = |output| Some(start + layout.output_biases().start + output);
    let mut links = Vec::new();
    for hidden in 0..m {
        let weights = (0..k).filter_map(|input| layout.input_weight(hidden, input));
        links.extend(
            weights.map(|it| Link { weight: start + it, biases: [hidden_bias(hidden), None] }),
        );
        for output in 0..n {
            if let Some(weight) = layout.output_weight(hidden, output) {
                let biases = [hidden_bias(hidden), output_bias(output)];
                links.push(Link { weight: start + weight, biases });
            }
        }
    }
    links
}
