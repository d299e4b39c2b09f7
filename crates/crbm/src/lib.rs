//! Conditional restricted Boltzmann machines as stochastic policies: sampling, score, exact
//! enumeration.
//!
//! ```text
//! p(y|x) = 1/Z(x) * sum_h exp(h'V x + h'W y + c'h + b'y),   x, y, h vectors of bits
//! ```
//! A [`Policy`] draws y, the action, given x, the sensors, and with it the score, the gradient of
//! log p(y|x) by all parameters, which is what policy-gradient methods need. The parameters are one
//! flat vector, ordered by a [`Layout`]; [`Exact`] gives everything by enumeration when there are
//! few outputs.
//!
//! ```
//! use crbm::{Layout, Policy, Sampling};
//!
//! let layout = Layout::full(30, 50, 24)?;
//! let parameters = layout.random_parameters(0.01, 1, "start")?;
//! let mut policy = Policy::new(layout, Sampling::default(), &parameters)?;
//! let mut rng = policy.rng(1, "policy");
//!
//! let (x, mut y) = ([true; 30], [false; 24]);
//! let mut score = vec![0.0; policy.layout().n_parameters()];
//! policy.act_and_score(&x, &mut rng, &mut y, &mut score)?;
//!
//! let moved: Vec<f64> = parameters.iter().zip(&score).map(|(p, s)| p + 0.1 * s).collect();
//! policy.set_parameters(&moved)?; // y has become more probable, given x
//! # Ok::<(), crbm::Error>(())
//! ```
//! The machine and its use are those of "Information theoretically aided reinforcement learning for
//! embodied agents" (Montúfar, Ghazi-Zahedi, Ay, 2016). `examples/learn.rs` learns a small
//! distribution from pairs.
//!
//! # Sampling
//! y starts uniform at random; then G times ([`Sampling::gibbs_updates`], 10 in the paper) all of h
//! is drawn given x and y, and all of y given h. The score's first term is exact; its second is the
//! mean over S further chains ([`Sampling::samples`], 60), with E[h|x,y'] in place of h. It's
//! unbiased but for the chains' start. `cargo run --release -p crbm --example bias` computes what
//! that amounts to, exactly, for machines with 3 inputs, 8 hidden units and 6 outputs, whose
//! parameters are N(0, s²): the bias in parts of the score's own size (root mean square):
//!
//! | s | G = 1 | 2 | 5 | 10 | 20 | 50 |
//! |---|---|---|---|---|---|---|
//! | 0.01 | 7.5e-7 | 9.8e-11 | 0 | 0 | 0 | 0 |
//! | 0.5 | 4.0e-2 | 5.9e-3 | 4.1e-5 | 3.2e-8 | 0 | 0 |
//! | 1 | 1.5e-1 | 4.8e-2 | 3.6e-3 | 1.7e-4 | 9.7e-7 | 0 |
//! | 2 | 4.2e-1 | 2.2e-1 | 6.3e-2 | 2.1e-2 | 6.3e-3 | 2.2e-4 |
//! | 4 | 8.6e-1 | 6.0e-1 | 3.4e-1 | 2.1e-1 | 1.4e-1 | 9.5e-2 |
//!
//! (0: below 1e-12, the rounding of the enumeration.) With large weights p(y|x) has modes that a
//! chain seldom leaves; the action is then drawn from what the chain reaches, and so are the
//! samples.
//!
//! # Connections
//! A [`Mask`] restricts which hidden units see which inputs or outputs: [`Mask::blocks`] makes one
//! block of hidden units for each actuator, or leg. A pair that isn't connected has no parameter:
//! it's always zero, and takes no time in the update, and in sampling and score none as far as
//! blocks are contiguous. Inputs with memory (several
//! past readings) are just more inputs; a value of several bits is several units, coded by the
//! caller.
//!
//! # Speed
//! One chain is one lane of a SIMD register; weights are added three at a time, by table; sampling
//! is in `f32`, the score in `f64`. No call but [`Policy::new`] allocates. Measured by
//! `cargo bench -p crbm` at the size of the example, in microseconds on one core of a processor
//! that has AVX-512, with other work on the machine:
//!
//! | | AVX-512 | AVX2 | portable (SSE2) |
//! |---|---|---|---|
//! | act and score | 45 | 63 | 350 |
//! | act alone | 9 | | |
//! | act and score, 48 hidden units in a block of 8 for each of 6 legs | 24 | | |
//! | set parameters | 5 | | |
//! | the plain scalar loop of `tests/plain` in place of act and score | 1040 | | |
//!
//! # Promises
//! - The same parameters, inputs and random numbers give the same bits, at any optimisation level
//!   and on whatever [`Instructions`] (`tests/determinism.rs`): nothing is contracted, nothing is
//!   added up across lanes, and no function is the system's.
//! - Random numbers are named streams ([`ChainRng`]) whose state can be saved and restored; chain i
//!   depends on seed, name and i alone.
//! - The distribution is that of the formulas (`tests/sampling.rs`, `tests/exact.rs`): a unit is on
//!   with the sigmoid's probability to within 4e-7, besides the rounding of sums to `f32`.
//! - Parameters of 1e9 neither overflow nor give NaN; larger ones, NaN and slices of wrong length
//!   are an [`Error`], and nothing has changed then.
//!
//! # Files
//! [`Layout::to_safetensors`] and [`Layout::from_safetensors`] write and read `V`, `c`, `W` and `b`
//! with their shapes, for `safetensors.numpy.load` and `safetensors.torch.load` too.

#![forbid(unsafe_code)]

mod entropy;
mod error;
mod exact;
mod file;
mod gibbs;
mod layout;
mod mask;
mod policy;
mod rng;
mod score;
mod simd;
mod tables;

pub use error::Error;
pub use exact::{Exact, MAX_ENUMERATED};
pub use layout::{Layout, MAX_PARAMETER, MAX_UNITS};
pub use mask::Mask;
pub use policy::{Policy, Sampling};
pub use rng::{ChainRng, random_parameters};
pub use simd::Instructions;
