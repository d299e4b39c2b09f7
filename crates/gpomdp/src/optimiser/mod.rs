//! What turns gradients into steps of the parameters: one small interface, and the list of all
//! that have it.
//!
//! To add an optimiser: a file beside this one with its settings, the optimiser and its tests, and
//! a line in the list below. The contract that `tests/optimisers.rs` runs on every entry of the
//! list then holds for it too.

mod adam;
mod momentum;
mod rprop;
mod settings;

use std::fmt::Debug;

use serde::{Deserialize, Serialize};

pub use adam::{Adam, AdamSettings};
pub use momentum::{Momentum, MomentumSettings};
pub use rprop::{Rprop, RpropSettings};
pub use settings::Setting;

use crate::{Error, check, check::LIMIT};
use settings::settings;

/// Climbs: moves parameters so that what the gradient belongs to gets larger.
pub trait Optimiser: Debug + Send {
    /// The length of the parameter vector that it was made for.
    fn n_parameters(&self) -> usize;

    /// One step uphill. Both slices are `[n_parameters]`. A parameter that is 0 and never gets a
    /// gradient other than 0 stays exactly 0.
    ///
    /// # Errors
    /// A slice of another length; an element that is NaN, infinite or beyond [`LIMIT`]. Parameters
    /// and optimiser are then as before. Parameters that blow up are met by the next call.
    fn update(&mut self, parameters: &mut [f64], gradient: &[f64]) -> Result<(), Error>;

    /// All that changes, for [`Optimiser::restore`]. Its length depends on the optimiser and on
    /// the number of parameters only.
    fn state(&self) -> Vec<f64>;

    /// Goes back to a state of an optimiser with the same settings and number of parameters, and
    /// continues from it with the same bits.
    ///
    /// # Errors
    /// A state of another length, or with numbers that no run leads to. The optimiser is then as
    /// before.
    fn restore(&mut self, state: &[f64]) -> Result<(), Error>;
}

/// Makes of the list the enum of all settings, and what depends on all of them.
macro_rules! optimisers {
    ($($(#[doc = $about:literal])+ $name:literal => $variant:ident($settings:ty, $optimiser:ty),)+) => {
        /// The optimiser to use, with its settings: the list of all there are.
        ///
        /// In a file it's the name with the settings that differ from their defaults, in TOML
        /// `optimiser.adam = { rate = 0.01 }`.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub enum OptimiserSettings {
            $($(#[doc = $about])+ #[serde(rename = $name)] $variant($settings),)+
        }

        impl OptimiserSettings {
            /// Every optimiser with its default settings.
            #[must_use]
            pub fn all() -> Vec<Self> {
                vec![$(Self::$variant(<$settings>::default())),+]
            }

            /// The name in files.
            #[must_use]
            pub fn name(&self) -> &'static str {
                match self { $(Self::$variant(_) => $name),+ }
            }

            /// What it does, in a sentence.
            #[must_use]
            pub fn about(&self) -> &'static str {
                match self { $(Self::$variant(_) => concat!($($about),+).trim_ascii()),+ }
            }

            /// What it's told, in the order of its fields.
            #[must_use]
            pub fn settings(&self) -> &'static [Setting] {
                match self { $(Self::$variant(_) => <$settings>::ALL),+ }
            }

            /// The optimiser for a vector of this many parameters, before its first step.
            ///
            /// # Errors
            /// A setting that is out of range; more parameters than there is memory for.
            pub fn build(&self, n_parameters: usize) -> Result<Box<dyn Optimiser>, Error> {
                Ok(match self {
                    $(Self::$variant(settings) =>
                        Box::new(<$optimiser>::new(n_parameters, settings)?)),+
                })
            }
        }
    };
}

optimisers! {
    /// Gradient ascent with momentum and weight decay.
    "momentum" => Momentum(MomentumSettings, Momentum),
    /// Steps scaled by running moments of the gradient.
    "adam" => Adam(AdamSettings, Adam),
    /// Steps from the signs of the gradient alone.
    "rprop" => Rprop(RpropSettings, Rprop),
}

/// The checks that all updates begin with.
fn check_update(
    place: &'static str,
    n_parameters: usize,
    parameters: &[f64],
    gradient: &[f64],
) -> Result<(), Error> {
    check::slice(place, "parameters", parameters, n_parameters, LIMIT)?;
    check::slice(place, "gradient", gradient, n_parameters, LIMIT)
}
