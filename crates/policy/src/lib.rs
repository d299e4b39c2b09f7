//! Policies: what draws a robot's action, bits, given its readings, bits too; with the score, the
//! gradient of log p(y|x) by the parameters, which is what policy-gradient methods need. An open list:
//! one [`Policy`] for whoever uses them, one file a kind.
//!
//! | [`KindSettings`] | p(y\|x) | score | what for |
//! |---|---|---|---|
//! | [`Crbm`] | a conditional restricted Boltzmann machine: outputs depend on each other by hidden units | from samples, unbiased but for the chains' start | the paper's policy; with blocks, its restricted structures |
//! | [`Modular`] | a small such machine for each group (leg), which sees its own sensors, or its neighbours' too | likewise, the modules' side by side | controllers of parts |
//! | [`Logistic`] | each bit by itself, a logistic function of the inputs | exact | the plain policy to compare with |
//!
//! Each kind can be learned in two codings of its units ([`Coding`], `src/centred.rs`), which are other
//! parameters of the same policies.
//!
//! A [`Structure`] says what the robot's bits are and which belong together, [`PolicySettings`] is the
//! table `policy` of an experiment file.
//!
//! ```
//! use policy::{Group, PolicySettings, Structure};
//!
//! let leg = |name: &str, first: usize, other: usize| Group {
//!     name: name.into(),
//!     inputs: vec![first, first + 1],
//!     actuators: vec![first, first + 1],
//!     neighbours: vec![other],
//! };
//! let walker = Structure {
//!     bits_per_reading: 4,
//!     readings: 1,
//!     actuators: ["left hip", "left knee", "right hip", "right knee"].map(String::from).into(),
//!     bits_per_actuator: 1,
//!     groups: vec![leg("left", 0, 1), leg("right", 2, 0)],
//! };
//! let file = config::Document::parse("walker.toml", "kind = 'modular'\ninputs = 'neighbours'")?;
//! let mut policy = file.read(PolicySettings::read)?.build(&walker, 1)?;
//!
//! let (x, mut y) = ([true, false, true, true], [false; 4]);
//! let mut score = vec![0.0; policy.parameters().len()];
//! policy.act_and_score(&x, &mut y, &mut score)?;
//! let uphill: Vec<f64> = policy.parameters().iter().zip(&score).map(|(p, s)| p + 0.1 * s).collect();
//! policy.set_parameters(&uphill)?; // y has become more probable, given x
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Speed
//! Microseconds of a core's time at Svenja's size (30 inputs, 24 outputs, six legs), on a processor that
//! has AVX-512, with other work on the machine, which about doubles them: compare them with each other.
//! `cargo bench -p policy` measures the first column anew.
//!
//! | | act and score | act alone |
//! |---|---|---|
//! | `crbm`: 50 hidden units | 98 | 19 |
//! | `crbm`: 8 for each leg, whatever inputs | 60 | 12 |
//! | `modular`: 8 for each leg, whatever inputs | 69 | 12 |
//! | `logistic` | 1.7 | 1.3 |
//!
//! # Promises
//! - The same settings, parameters, inputs and random numbers give the same bits, at any optimisation
//!   level and on any processor: nothing is contracted, sums have one order, and no function is the
//!   system's. What has run on from a saved state has the same bits as what was never interrupted.
//! - A score is the gradient of log p(y|x) at the policy's own output: exactly, or in its mean
//!   (`tests/distribution.rs`).
//! - Slices of a wrong length, NaN, numbers beyond [`MAX_PARAMETER`](crbm::MAX_PARAMETER) and files of
//!   another layout are an [`Error`], and nothing has changed then.
//! - Neither acting nor changing the parameters allocates.
//!
//! # Files
//! [`Policy::to_safetensors`] writes named tensors, and in the metadata the kind;
//! [`Policy::read_safetensors`] takes the parameters of a policy of the same layout, and says of
//! another one what differs.

#![forbid(unsafe_code)]

mod centred;
mod error;
mod kinds;
mod neighbours;
mod policy;
mod settings;
mod structure;
mod tensors;
mod uniform;

pub use centred::Link;
pub use error::{Difference, Error};
pub use kinds::*;
pub use neighbours::beside;
pub use policy::Policy;
pub use settings::{Coding, PolicySettings, Start};
pub use structure::{Group, Inputs, Structure};
