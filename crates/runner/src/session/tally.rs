//! Sums over the control steps of an update, for its row.

use nalgebra::Point3;
use reward::Terms;
use runs::Row;
use serde::{Deserialize, Serialize};

use super::{Transition, Whereabouts};

/// Sums over control steps.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Tally {
    /// Where the centre of gravity was, in m.
    start: [f64; 3],
    terms: [f64; Terms::NAMES.len()],
    advance_m: f64,
    heading_change_rad: f64,
    penalised_contacts: u64,
    clipped_readings: u64,
    /// Of the gradient that the update follows: known at its end.
    #[serde(skip)]
    pub(super) gradient_norm: f64,
}

impl Tally {
    /// Before the first step.
    pub(super) fn begin(start: &Whereabouts) -> Self {
        Self { start: start.centre_of_gravity_m.into(), ..Self::default() }
    }

    pub(super) fn add(&mut self, step: &Transition) {
        for (sum, term) in self.terms.iter_mut().zip(step.terms.as_array()) {
            *sum += term;
        }
        self.advance_m += step.advance_m;
        self.heading_change_rad += step.heading_change_rad;
        self.penalised_contacts += step.penalised_contacts as u64;
        self.clipped_readings += step.clipped_readings as u64;
    }

    /// Means over `n` steps that ended here; what isn't known here is 0.
    pub(super) fn row(&self, end: &Whereabouts, n: u64) -> Row {
        let n = n as f64;
        let [reward, task, extrinsic, nats, nats_corrected, intrinsic, penalty, xi] =
            self.terms.map(|sum| sum / n);
        Row {
            reward,
            intrinsic_nats: nats,
            intrinsic_nats_corrected: nats_corrected,
            intrinsic,
            advance_m: self.advance_m / n,
            extrinsic,
            penalty,
            xi,
            net_displacement_m: (end.centre_of_gravity_m - Point3::from(self.start)).xy().norm(),
            heading_change_rad: self.heading_change_rad,
            penalised_contacts: self.penalised_contacts,
            clipped_readings: self.clipped_readings,
            gradient_norm: self.gradient_norm,
            task,
            ..Row::default()
        }
    }
}
