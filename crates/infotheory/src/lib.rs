//! Information theory of discrete data: what variables hold, share and pass on, in batches and in
//! sliding windows.
//!
//! ```
//! use infotheory::{Binning, Estimator, History, mutual_information, transfer_entropy};
//!
//! // A sine, and the same one step later, in bins of two bits.
//! let binning = Binning::new(2)?;
//! let mut leader = vec![0; 500];
//! let values: Vec<f64> = (0..500).map(|t| (0.7 * t as f64).sin()).collect();
//! binning.bins(&values, &mut leader)?;
//! let follower: Vec<u64> = leader.iter().cycle().skip(499).take(500).copied().collect();
//!
//! let shared = mutual_information(&leader, &follower, Estimator::MillerMadow)?;
//! let there = transfer_entropy(&leader, &follower, History::default(), Estimator::MillerMadow)?;
//! let back = transfer_entropy(&follower, &leader, History::default(), Estimator::MillerMadow)?;
//! println!("{:.2} bits shared, {:.2} passed on", shared.bits(), there.bits());
//! assert!(shared.bits() > 0.5 && there > back);
//! # Ok::<(), infotheory::Error>(())
//! ```
//!
//! # What is here
//! | | |
//! |---|---|
//! | [`Binning`] | values in \[-1, 1\] to bins, to bits, and back to the bins' centroids |
//! | [`MixedRadix`], [`Dictionary`] | joint states as one number, up to 64 bits and beyond |
//! | [`entropy()`], [`joint_entropy`], [`conditional_entropy`] | H(X), H(X, Y), H(X\|Y) |
//! | [`mutual_information`], [`conditional_mutual_information`] | I(X; Y), I(X; Y\|Z) |
//! | [`multi_information`], [`transfer_entropy`] | of many variables; between two series |
//! | [`PermutationTest`] | how likely as much is by chance |
//! | [`Window`] | the information between successive readings, kept up to date at each: a reward |
//! | [`TransferWindow`] | the same for what one sensor tells about another's next reading |
//!
//! Symbols are of any type with an order (`u8`, `u64`, `char`, tuples, arrays; no floats, which have
//! none), codes are `u64`. The batch measures take slices, one symbol a sample. An [`Information`]
//! is read in [`nats`](Information::nats) or [`bits`](Information::bits); an [`Estimator`] says
//! whether the bias of small samples is taken away.
//!
//! # Promises
//! - The same input and seed give the same bits, on any machine and at any optimisation level:
//!   logarithms come from the `libm` crate and are summed as integers.
//! - For that reason names of states and the order of samples don't matter, to the bit; and a
//!   [`Window`] equals a recount of its pairs, to the bit, however long it has been sliding
//!   (`tests/window.rs`,
//!   `tests/transfer_window.rs`).
//! - No joint state overflows silently: it's numbered injectively, or refused, or kept in several
//!   words.
//! - NaN, empty samples and misfits are errors that say where, what was expected, and what was
//!   there; values beyond \[-1, 1\] are clipped and counted. Nothing panics.
//!
//! # What it costs
//! Batches take the time of sorting them. A [`Window`] of 100 pairs takes in a reading of 24 sensors
//! and gives the mean over them in about a microsecond (`benches/measures.rs`), without allocating
//! (`tests/allocation.rs`).
//!
//! # At the edges
//! | | |
//! |---|---|
//! | a sample without symbols | an error |
//! | a sample of one, or of one state | all measures are 0 |
//! | a binning of 0 bits | one bin, centroid 0, no bits to write |
//! | a window of one pair, or a variable of one state | 0, and a share of the maximum of 0 |
//! | a window without pairs yet | 0 |
//! | a joint state of 64 bits | one code; [`MixedRadix::n_states`] is 2^64 |
//! | a joint state of more | refused by [`MixedRadix`], taken by [`Dictionary`] and [`Window`] |

#![forbid(unsafe_code)]

mod binning;
mod column;
mod encoder;
mod entropy;
mod error;
mod information;
mod keys;
mod logs;
mod mutual;
mod permutation;
mod transfer;
mod window;

pub use binning::{Bin, Binning};
pub use encoder::{Dictionary, MixedRadix};
pub use entropy::{conditional_entropy, entropy, entropy_of_counts, joint_entropy};
pub use error::Error;
pub use information::{Estimator, Information};
pub use mutual::{conditional_mutual_information, multi_information, mutual_information};
pub use permutation::{PermutationTest, Significance};
pub use transfer::{History, transfer_entropy};
pub use window::{TransferWindow, Window, WindowSettings, all_sensors, each_sensor};
