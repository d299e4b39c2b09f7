//! RPROP: steps from the signs of the gradient alone.
//!
//! Every parameter has a step size D of its own, which grows while the sign of its gradient stays
//! and shrinks when it changes:
//!
//! ```text
//!     same sign:     D <- min(grow D, largest)        theta <- theta + sign(g) D
//!     other sign:    D <- max(shrink D, smallest)     theta stays, and g counts as 0
//!     one of them 0: D stays                          theta <- theta + sign(g) D
//! ```
//!
//! where the signs are those of this gradient and of the last. This is iRprop- of C. Igel and
//! M. Huesken (Improving the Rprop learning algorithm, Proceedings of the 2nd ICSC Symposium on
//! Neural Computation, 2000, 115-121): RPROP (M. Riedmiller and H. Braun, A direct adaptive method
//! for faster backpropagation learning: the RPROP algorithm, IEEE International Conference on
//! Neural Networks, 1993, 586-591) without taking steps back. It was made for exact gradients:
//! where noise sets the signs, steps are too small, so give it long estimates.

use super::{Optimiser, check_update, settings};
use crate::{
    Error,
    check::{self, LIMIT},
};

settings! {
    /// What [`Rprop`] can be told. The defaults are those of Riedmiller and Braun.
    RpropSettings {
        // Judged by bounds that are right: a bad one is told by itself.
        first: "first step of every parameter", 0.1, "within smallest to largest",
            |it| !it.has_bounds() || (it.smallest..=it.largest).contains(&it.first);
        smallest: "smallest step", 1e-6,
            "> 0 and at most 1e100", |it| it.smallest > 0.0 && it.smallest <= LIMIT;
        largest: "largest step", 50.0,
            "within smallest to 1e100", |it| (it.smallest..=LIMIT).contains(&it.largest);
        grow: "factor of a step when the gradient's sign stays", 1.2,
            "within 1 to 1e100", |it| (1.0..=LIMIT).contains(&it.grow);
        shrink: "factor of a step when the gradient's sign changes", 0.5,
            "> 0 and at most 1", |it| it.shrink > 0.0 && it.shrink <= 1.0;
    }
}

impl RpropSettings {
    fn has_bounds(&self) -> bool {
        self.smallest > 0.0 && (self.smallest..=LIMIT).contains(&self.largest)
    }
}

/// RPROP in the variant iRprop-: each parameter's step size grows while the sign of its gradient
/// stays, and shrinks when it changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Rprop {
    settings: RpropSettings,
    /// D, [n_parameters]
    size: Vec<f64>,
    /// The sign of the last gradient, -1, 0 or 1, [n_parameters]
    sign: Vec<f64>,
}

impl Rprop {
    /// The optimiser before its first step.
    ///
    /// # Errors
    /// A setting that is out of range; more parameters than there is memory for.
    pub fn new(n_parameters: usize, settings: &RpropSettings) -> Result<Self, Error> {
        let place = "Rprop::new";
        settings.check(place)?;
        Ok(Self {
            settings: settings.clone(),
            size: check::filled(place, n_parameters, settings.first)?,
            sign: check::filled(place, n_parameters, 0.0)?,
        })
    }
}

impl Optimiser for Rprop {
    fn n_parameters(&self) -> usize {
        self.size.len()
    }

    fn update(&mut self, parameters: &mut [f64], gradient: &[f64]) -> Result<(), Error> {
        check_update("Rprop::update", self.size.len(), parameters, gradient)?;
        let RpropSettings { smallest, largest, grow, shrink, .. } = self.settings;
        let memory = self.size.iter_mut().zip(&mut self.sign);
        for ((theta, &g), (size, last)) in parameters.iter_mut().zip(gradient).zip(memory) {
            let mut sign = sign(g);
            let agreement = sign * *last;
            if agreement > 0.0 {
                *size = (grow * *size).min(largest);
            } else if agreement < 0.0 {
                *size = (shrink * *size).max(smallest);
                sign = 0.0;
            }
            *theta += sign * *size;
            *last = sign;
        }
        Ok(())
    }

    /// D and the signs: `[2 n_parameters]`.
    fn state(&self) -> Vec<f64> {
        [&self.size[..], &self.sign].concat()
    }

    fn restore(&mut self, state: &[f64]) -> Result<(), Error> {
        let place = "Rprop::restore";
        let n = self.size.len();
        check::slice(place, "state", state, 2 * n, LIMIT)?;
        let (sizes, signs) = state.split_at(n);
        let range = self.settings.smallest..=self.settings.largest;
        if let Some(&size) = sizes.iter().find(|size| !range.contains(size)) {
            check::number(false, place, "a step size", "within smallest to largest", size)?;
        }
        if let Some(&sign) = signs.iter().find(|sign| ![-1.0, 0.0, 1.0].contains(sign)) {
            check::number(false, place, "a sign", "-1, 0 or 1", sign)?;
        }
        self.size.copy_from_slice(sizes);
        self.sign.copy_from_slice(signs);
        Ok(())
    }
}

/// -1, 0 or 1. (`f64::signum` has no 0.)
fn sign(x: f64) -> f64 {
    f64::from(i8::from(x > 0.0) - i8::from(x < 0.0))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_run_through_all_branches_worked_by_hand() {
        let settings =
            RpropSettings { first: 1.0, smallest: 0.75, largest: 3.0, grow: 2.0, shrink: 0.5 };
        let mut rprop = Rprop::new(1, &settings).unwrap();
        let mut theta = [0.0];
        // gradient, then the step size and theta after it
        let table = [
            (0.1, 1.0, 1.0),    // the first step
            (1e-9, 2.0, 3.0),   // same sign: the size grows, whatever the gradient's
            (7.0, 3.0, 6.0),    // up to the largest
            (-1.0, 1.5, 6.0),   // other sign: it shrinks, and nothing moves
            (-1.0, 1.5, 4.5),   // the sign changed from "0": the size stays
            (1.0, 0.75, 4.5),   // down to the smallest
            (0.0, 0.75, 4.5),   // no gradient, no step
            (1.0, 0.75, 5.25),  // and then the size as it was
            (-1.0, 0.75, 5.25), // the smallest stays
        ];
        for (line, (gradient, size, position)) in table.into_iter().enumerate() {
            rprop.update(&mut theta, &[gradient]).unwrap();
            assert_eq!((rprop.state()[0], theta[0]), (size, position), "line {line}");
        }
    }

    #[test]
    fn only_signs_count() {
        let mut runs = [1e-100, 1.0, 1e100].map(|scale| {
            let mut rprop = Rprop::new(1, &RpropSettings::default()).unwrap();
            let mut theta = [0.0];
            for t in 0..50 {
                let gradient = if t * t % 7 < 3 { scale } else { -0.5 * scale };
                rprop.update(&mut theta, &[gradient]).unwrap();
            }
            theta[0]
        });
        assert_eq!(runs[0], runs[1]);
        runs.rotate_left(1);
        assert_eq!(runs[0], runs[1]);
    }
}
