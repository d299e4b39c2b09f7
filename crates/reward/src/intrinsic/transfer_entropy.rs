//! Transfer entropy between neighbouring joints: what the position of a joint tells about the next one
//! of the joint beside it, beyond what that joint's own position tells.
//!
//! ```text
//! T_{Y->X} = I(X_{t+1} ; Y_t | X_t)
//! ```
//!
//! counted over the last T' steps ([`infotheory::TransferWindow`]; T. Schreiber, *Measuring information
//! transfer*, 2000), in both directions between [neighbours](RobotLayout::neighbours); the reward is
//! `max` times the mean of T / ln min(K, T') over these links, for K states of a position. It's the
//! value of the whole window, not of its newest step, and never more than `max`.
//!
//! For two bits, K = 4, the plug-in value of 100 steps is mostly bias, up to (K - 1)^2 K / 2 T' = 0.18
//! nats, which is why Miller and Madow's is recorded beside it.

use config::{Rule, Section, count, within};
use infotheory::{Estimator, TransferWindow};
use serde::Serialize;

use super::{Build, Intrinsic, Value};
use crate::{Error, NOMINAL_MAXIMUM, RobotLayout};

/// Settings of transfer entropy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TransferEntropySettings {
    /// T', the steps that are counted, 2 to 2^20; 100.
    pub window: usize,
    /// The greatest value; 0.1.
    pub max: f64,
}

impl Default for TransferEntropySettings {
    fn default() -> Self {
        Self { window: 100, max: NOMINAL_MAXIMUM }
    }
}

impl TransferEntropySettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let default = Self::default();
        Some(Self {
            window: section.or(
                "window",
                count(2, 1 << 20).about("newest steps that are counted"),
                default.window,
            ),
            max: section.or("max", within(1e-50, 1e50).about("the greatest value"), default.max),
        })
    }
}

impl Build for TransferEntropySettings {
    fn build(&self, layout: &RobotLayout) -> Result<Box<dyn Intrinsic>, Error> {
        if layout.neighbours.is_empty() {
            return Err(Error::NoNeighbours);
        }
        let both_ways = |&[a, b]: &[usize; 2]| [[a, b], [b, a]];
        let links: Vec<_> = layout.neighbours.iter().flat_map(both_ways).collect();
        let window = TransferWindow::new(self.window, &layout.radices(), &links)?;
        Ok(Box::new(TransferEntropy { window, max: self.max }))
    }

    fn symbol(&self) -> &'static str {
        "R_TE"
    }

    fn per(&self) -> &'static str {
        "link"
    }
}

#[derive(Debug)]
struct TransferEntropy {
    window: TransferWindow,
    max: f64,
}

impl Intrinsic for TransferEntropy {
    fn push(&mut self, bins: &[u64]) -> Result<(), Error> {
        Ok(self.window.push(bins)?)
    }

    fn value(&self) -> Value {
        let nats = |estimator| self.window.mean_transfer_entropy(estimator).nats();
        Value {
            nats: nats(Estimator::PlugIn),
            nats_corrected: nats(Estimator::MillerMadow),
            scaled: self.max * self.window.share_of_maximum(),
        }
    }

    fn save(&self) -> Vec<u64> {
        let mut state = Vec::new();
        self.window.save(&mut state);
        state
    }

    fn restore(&mut self, state: &[u64]) -> Result<(), Error> {
        Ok(self.window.restore(state)?)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Two joints with one between them that nobody has as a neighbour.
    fn layout() -> RobotLayout {
        RobotLayout { n_positions: 3, n_bins: 2, neighbours: vec![[2, 0]], ..Default::default() }
    }

    /// Joint 2 goes through all pairs of bits evenly, 0 0 1 1 and again, which tells it of itself
    /// nothing: its next is either as often. Joint 0 is a step behind it, so that joint 0's position tells
    /// which: ln 2. Joint 2's position is joint 0's next one, which joint 0 itself doesn't know: ln 2.
    #[test]
    fn a_joint_that_copies_its_neighbour_is_worth_ln_2() {
        let mut intrinsic = TransferEntropySettings::default().build(&layout()).unwrap();
        let leader = |t: u64| (t / 2) % 2;
        for t in 1..=101 {
            intrinsic.push(&[leader(t - 1), 1, leader(t)]).unwrap();
        }
        let value = intrinsic.value();
        // A few roundings of numbers below 1.
        assert!((value.nats - std::f64::consts::LN_2).abs() < 1e-15, "{value:?}");
        assert!((value.scaled - 0.1).abs() < 1e-16, "{value:?}");
        // Four states of (x', x, y) occur, all pairs of bits, and both bits: (4 + 4 - 4 - 2) / 200.
        assert!((value.nats_corrected - value.nats - 0.01).abs() < 1e-15, "{value:?}");
    }

    #[test]
    fn a_robot_whose_joints_have_no_neighbours_is_refused() {
        let layout = RobotLayout { neighbours: vec![], ..layout() };
        let error = TransferEntropySettings::default().build(&layout).unwrap_err();
        assert_eq!(error, Error::NoNeighbours);
        assert!(error.to_string().contains("got a model without"), "{error}");
    }
}
