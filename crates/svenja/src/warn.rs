//! What a model file may say and had better not: what Bullet takes and doesn't do well.
//!
//! # Far turns about y
//! Of the three angles of a 6-dof joint (about z, then the new y, then the newest x) Bullet corrects
//! those about x and z along axes on which they change at only cos b of the rate, with b the angle
//! about y, and takes back `erp` of the error as if it were the whole: `erp / cos b`. Beyond twice the
//! error a correction makes it larger. So what is locked about x or z is only held where
//!
//! ```text
//! erp < 2 cos b
//! ```
//!
//! which is 60 degrees for stops with an erp of 1, and never a quarter turn. Where both turn nothing
//! is locked, and ranges correct nothing within their ends.

use config::Problem;

use crate::{
    JointKind, Turn,
    file::{JointFile, ModelFile},
};

/// Beyond, the stops that hold are so soft that an axis hardly comes near its ends.
const FARTHEST_DEG: f64 = 85.0;

pub(crate) fn warnings(file: &ModelFile) -> Vec<Problem> {
    file.joints.iter().filter_map(far_turn).collect()
}

fn far_turn(joint: &JointFile) -> Option<Problem> {
    if joint.kind != JointKind::Spherical || joint.axes.len() == 3 {
        return None;
    }
    let (index, axis) = joint.axes.iter().enumerate().find(|(_, axis)| axis.about == Turn::Y)?;
    let reach_rad = axis.upper_rad.max(-axis.lower_rad) + axis.stop_margin_rad;
    let erp = joint.stop.erp;
    if erp < 2.0 * libm::cos(reach_rad) {
        return None;
    }
    let reach_deg = reach_rad.to_degrees();
    let held_deg = reach_deg.min(FARTHEST_DEG);
    let message = format!(
        "joint '{}': axes[{index}]: range_deg and its stops reach {reach_deg:.0} degrees about y, but \
         with a stop.erp of {erp} Bullet can't hold beyond {:.0} what the joint locks; with at most \
         {:.2}, the cosine, it can up to {held_deg:.0}",
        joint.name.value,
        libm::acos(erp / 2.0).to_degrees(),
        libm::cos(held_deg.to_radians()),
    );
    Some(Problem { place: axis.place.clone(), message })
}
