//! Sums over the control steps of an update, for its row.

use nalgebra::Point3;
use reward::{RobotState, Terms};
use runs::Row;
use serde::{Deserialize, Serialize};

use super::Evaluation;

/// Sums over control steps.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct UpdateSums {
    /// Where the centre of gravity was, in m.
    start: [f64; 3],
    terms: [f64; Terms::NAMES.len()],
    advance_m: f64,
    heading_change_rad: f64,
    penalised_contacts: u64,
    clipped_readings: u64,
    /// Of the policy's outputs, a sum over control steps. Saved beside the others, which there were before.
    #[serde(skip)]
    pub(super) entropy_nats: f64,
}

impl UpdateSums {
    /// Before the first step.
    pub(super) fn begin(start: &RobotState) -> Self {
        Self { start: start.centre_of_gravity_m.into(), ..Self::default() }
    }

    pub(super) fn add(&mut self, step: &Evaluation) {
        for (sum, term) in self.terms.iter_mut().zip(step.terms.as_array()) {
            *sum += term;
        }
        self.advance_m += step.advance_m;
        self.heading_change_rad += step.heading_change_rad;
        self.penalised_contacts += step.penalised_contacts as u64;
        self.clipped_readings += step.clipped_readings as u64;
    }
}

/// The row of an update of `n` control steps in each of some worlds, each with where it ended: means
/// over all of them. What isn't known here is 0.
pub(super) fn row<'a>(
    worlds: impl ExactSizeIterator<Item = (&'a UpdateSums, &'a RobotState)>,
    n: u64,
) -> Row {
    let n_worlds = worlds.len() as f64;
    let mut sum = UpdateSums::default();
    let (mut net_displacement_m, mut entropy_nats) = (0.0, 0.0);
    for (world, end) in worlds {
        sum.terms.iter_mut().zip(world.terms).for_each(|(sum, term)| *sum += term);
        sum.advance_m += world.advance_m;
        sum.heading_change_rad += world.heading_change_rad;
        sum.penalised_contacts += world.penalised_contacts;
        sum.clipped_readings += world.clipped_readings;
        entropy_nats += world.entropy_nats;
        net_displacement_m += (end.centre_of_gravity_m - Point3::from(world.start)).xy().norm();
    }
    let n = n as f64 * n_worlds;
    let [reward, task, extrinsic, nats, nats_corrected, intrinsic, penalty, xi] =
        sum.terms.map(|sum| sum / n);
    Row {
        reward,
        intrinsic_nats: nats,
        intrinsic_nats_corrected: nats_corrected,
        intrinsic,
        advance_m: sum.advance_m / n,
        extrinsic,
        penalty,
        xi,
        net_displacement_m: net_displacement_m / n_worlds,
        heading_change_rad: sum.heading_change_rad / n_worlds,
        penalised_contacts: sum.penalised_contacts as f64,
        clipped_readings: sum.clipped_readings as f64,
        task,
        output_entropy_nats: entropy_nats / n,
        ..Row::default()
    }
}
