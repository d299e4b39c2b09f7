//! Sums over the control steps of an update, for its row.

use nalgebra::Point3;

use crate::{
    reward::{Step, Terms},
    store::Row,
};

/// Sums over control steps.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    start: Point3<f64>,
    terms: [f64; Terms::NAMES.len()],
    advance_m: f64,
    heading_change_rad: f64,
    penalised_contacts: u64,
    clipped_readings: u64,
    pub(super) gradient_norm: f64,
}

impl Tally {
    /// Before the first step, with the centre of gravity in m.
    pub(super) fn begin(start: Point3<f64>) -> Self {
        Self { start, ..Self::default() }
    }

    pub(super) fn add(&mut self, terms: &Terms, step: &Step<'_>, n_clipped: usize) {
        for (sum, term) in self.terms.iter_mut().zip(terms.as_array()) {
            *sum += term;
        }
        self.advance_m += step.advance_m;
        self.heading_change_rad += step.heading_change_rad;
        self.penalised_contacts += step.penalised_contacts as u64;
        self.clipped_readings += n_clipped as u64;
    }

    /// Means over `n` steps, with the centre of gravity now, in m; what isn't known here is 0.
    pub(super) fn row(&self, end: Point3<f64>, n: u64) -> Row {
        let n = n as f64;
        let [reward, _raw, extrinsic, nats, nats_corrected, intrinsic, penalty, xi] =
            self.terms.map(|sum| sum / n);
        Row {
            reward,
            information_nats: nats,
            information_miller_madow_nats: nats_corrected,
            information: intrinsic,
            locomotion_m: self.advance_m / n,
            extrinsic,
            penalty,
            xi,
            net_displacement_m: (end - self.start).xy().norm(),
            heading_change_rad: self.heading_change_rad,
            penalised_contacts: self.penalised_contacts,
            clipped_readings: self.clipped_readings,
            gradient_norm: self.gradient_norm,
            ..Row::default()
        }
    }
}
